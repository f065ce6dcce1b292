"""Memory of a program: bytes touched per lane, bytes carried with a particle, size of the bundle."""

from dataclasses import dataclass

WORD = 8  # bytes per field and lane


@dataclass(frozen=True)
class Footprint:
    """Memory of a program in bytes.

    Per lane: `touched` by the passes of a step, `carried` with the particle, `known` for all fields of the
    engine.  Per bundle: `bundle` reserved, `used` by the fields of this program.
    """

    touched: int
    carried: int
    known: int
    bundle: int
    used: int


def footprint_of(program) -> Footprint:
    """Return the footprint of a program."""
    from transport.engine.bundle import HEADER_WORDS, PITCH, empty_bundle
    from transport.engine.passes import LANE_FIELDS

    steps = (*program.steps, *program.withdrawal, *program.sight)
    touched = {name for lane_pass, _ in steps for name in lane_pass.fields} | set(program.carried)
    used = touched | {name for lane_pass in program.passes for name in lane_pass.fields}
    return Footprint(
        touched=WORD * len(touched),
        carried=WORD * len(program.carried),
        known=WORD * len(LANE_FIELDS),
        bundle=empty_bundle().nbytes,
        used=WORD * (HEADER_WORDS + PITCH * len(used)),
    )
