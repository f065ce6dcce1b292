"""What a program weighs: bytes of a lane that its passes touch, those that move along with a particle, and the bundle's."""

from dataclasses import dataclass

WORD = 8  # bytes of a field of one lane


@dataclass(frozen=True)
class Footprint:
    """Bytes.

    touched: of a lane, by the passes of a step;  carried: of a lane, moved along with its particle;  known: of a lane,
    of all fields that the engine has, most of them never touched;  bundle: of the whole bundle in memory that is
    reserved, and `used`, of it, by the fields of this program.
    """

    touched: int
    carried: int
    known: int
    bundle: int
    used: int


def footprint_of(program) -> Footprint:
    """The footprint of a program."""
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
