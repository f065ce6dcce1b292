"""Numbers from a batch's integer sums: mean weights per history; the energy balance is checked exactly."""

from dataclasses import dataclass, fields

import numpy as np

from transport.compile import layout
from transport.compile.layout import RECORD
from transport.compile.plan import Plan
from transport.statistics.chunked import empty_memmap, release_pages, to_memmap
from transport.statistics.packed import CHUNK_ROWS, MAX_UNPACKED_ROWS, Packed, make_columns

# ---- The samples of snapshots: recorded particles, of histories chosen by their numbers alone.
#
# All snapshots of a batch record the same histories.  Excess records are thinned by the history's own random
# number in [0, 1), so that a history in one snapshot that is absent from a later one has ended in between.

SAMPLED = np.dtype([*RECORD.descr, ("identity", "i8"), ("place", "f8"), ("below", "f8")])
# identity: of the history in the run;  place: its number in [0, 1);  below: limit of the kept places


def records_of(raw: np.ndarray, stride: int, seed: int) -> np.ndarray:
    """Convert a batch's records to SAMPLED; each weight is multiplied by the histories that it stands for."""
    records = empty_memmap(len(raw), SAMPLED)
    if not len(raw):
        return records
    for name in RECORD.names:
        records[name] = raw[name]
    records["weight"] *= stride
    records["identity"] = (raw["batch"] << 32) | raw["history"]
    records["place"] = (
        _hashed(records["identity"].astype(np.uint64) ^ _hashed(np.array([seed], np.uint64))) * 2.0**-64
    )
    records["below"] = 1.0
    release_pages(records)
    return records


def merged_records(one: np.ndarray, other: np.ndarray, most: int) -> np.ndarray:
    """Concatenate records; if there are more than `most`, keep those of half as many histories."""
    records = np.concatenate([one, other])
    if len(records) > most:
        records = thinned(records, 0.5 * records["below"].min())
    return to_memmap(records)


def thinned(records: np.ndarray, below: float) -> np.ndarray:
    """The records of the histories with places below a limit, with weights increased accordingly."""
    kept = records[records["place"] < below]
    kept["weight"] *= np.maximum(kept["below"] / below, 1.0)
    kept["below"] = np.minimum(kept["below"], below)
    return kept


def common_probability(records: list[np.ndarray], snapshots: list[int], most: int) -> float:
    """The probability for choosing histories so that no snapshot has more than `most` records.

    It is the place of the first history that is left out; sums with weights of one over it are unbiased
    (priority sampling: Duffield, Lund, Thorup 2007).
    """
    limit = 1.0
    for number in snapshots:
        own = np.concatenate([_priorities(of_batch[of_batch["snapshot"] == number]) for of_batch in records])
        if len(own) > most:
            own.sort()
            limit = min(limit, float(own[most]))
    return limit


def chosen_records(records: np.ndarray, snapshot: int, chance: float) -> np.ndarray:
    """Mask of the records of a snapshot whose histories are chosen with this probability, (N,) of bool."""
    return (records["snapshot"] == snapshot) & (_priorities(records) < chance)


def _priorities(records: np.ndarray) -> np.ndarray:
    return records["place"] / records["below"]


def distinct_identities(identities: np.ndarray, seeds: np.ndarray, seed: int) -> np.ndarray:
    """Numbers of histories that are distinct for different seeds, (N,); unchanged for histories of `seed`."""
    own = _hashed(np.array([seed], np.uint64))
    return (identities.astype(np.uint64) ^ _hashed(seeds) ^ own).astype(np.int64)


def _hashed(numbers: np.ndarray) -> np.ndarray:
    """A hash of 64 bits for each number (SplitMix64: Steele, Lea, Flood 2014)."""
    z = numbers + np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


# ---- The sums of one batch.

HIGH_UNIT, LOW_UNIT, SLANT_UNIT = 2.0**-32, 2.0**-63, 2.0**-22  # units of the sums [largest birth weight]

MOST_COUNT = (1 << layout.COUNT_BITS) - 1  # above it, a count holds the grazing excess
ENDS = {name: getattr(layout, name.upper()) for name in ("escaped", "in_flight", "roulette", "lost")}
MOMENT_LIMB_UNITS = np.array([HIGH_UNIT, LOW_UNIT, 2.0**-94, 2.0**-125])  # of a row of velocity sums


class LedgerError(AssertionError):
    """Weight appeared or vanished: an error of the engine, never of a scene."""


@dataclass(frozen=True)
class Batch:
    """The sums of one batch, or of several merged ones; weights in units of the largest birth weight.

    Long columns of weights, counts, slants and moments are packed; a slice of them is an array as well.
    """

    histories: int
    weights: np.ndarray | Packed  # (rows,) sums
    counts: np.ndarray | Packed  # (rows,) scores
    slants: np.ndarray | Packed  # (rows,) sums of weight/|mu|
    # (detectors,) crossings below the grazing cut: excess of those in its inner half over those in the outer
    # half
    grazing: np.ndarray
    born: float
    heaviest: float  # of births towards an aim
    ledger: dict[str, float]
    absorbed: np.ndarray  # (rows of surfaces, then of media)
    lost: int  # histories
    astray: int  # crossings of a boundary from another medium than the particle was in
    unseen: int  # crossings out of a body by particles that were not recorded as entering it
    crossings: int
    collisions: int
    moments: np.ndarray | Packed  # (long rows,) sums of velocities and paths
    records: np.ndarray  # the sample of its snapshots (batches.py)
    sizes: np.ndarray  # (cells,) number of scores of each size (compile/detectors.py)
    seed: int  # key of its random numbers, together with the numbers of the batch:
    first: int  # its number in the run; the lowest one of merged batches
    past: int  # its number plus 1; the highest one plus 1 of merged batches

    def merged(self, other: "Batch", most_records: int) -> "Batch":
        """Merge two batches; of more than `most_records` records, keep those of every second history."""
        merged = {
            "heaviest": max(self.heaviest, other.heaviest),
            "ledger": {name: value + other.ledger[name] for name, value in self.ledger.items()},
            "records": merged_records(self.records, other.records, most_records),
            "seed": self.seed,
            "first": min(self.first, other.first),
            "past": max(self.past, other.past),
        }
        summed = [field.name for field in fields(self) if field.name not in merged]
        return Batch(**merged, **{name: getattr(self, name) + getattr(other, name) for name in summed})


def batch_of(plan: Plan, raw, number: int = 0) -> Batch:
    """Convert the raw sums (engine.driver.RawSums) of the batch with this number.

    Raises LedgerError if the energy balance does not close.
    """
    return batches_of(plan, {number: raw})[number]


def batches_of(plan: Plan, parcel: dict[int, object]) -> dict[int, Batch]:
    """Convert the raw sums of several batches by number: where they are short, all at once.

    Raises LedgerError if an energy balance does not close.
    """
    columns = zip(*_columns(plan, list(parcel.values())), strict=True)
    return {
        number: _batch_of(raw, number, *own)
        for (number, raw), own in zip(parcel.items(), columns, strict=True)
    }


def _batch_of(raw, number: int, weights, counts, slants, grazing: np.ndarray) -> Batch:
    """Check that the energy balance closes exactly, and return a batch with these columns."""
    ledger = raw.ledger.tolist()
    whole = [(high << 31) + low for high, low, _, _ in ledger]
    born = raw.birth_weight + whole[layout.BORN]
    ended = sum(whole) - whole[layout.BORN]
    if born != ended:
        raise LedgerError(
            f"the ledger of {raw.histories} histories does not close: born {born / 2**63!r},"
            f" ended {ended / 2**63!r}"
        )
    moments = raw.moments
    (velocities,) = make_columns([lambda a, b: moments[a:b] @ MOMENT_LIMB_UNITS], [1], moments)
    return Batch(
        raw.histories,
        weights,
        counts,
        slants,
        grazing,
        born * LOW_UNIT,
        float(raw.ledger[layout.BORN, 3].view(np.float64)),
        {name: whole[row] * LOW_UNIT for name, row in ENDS.items()},
        np.array([value * LOW_UNIT for value in whole[layout.ABSORBED + 1 :]]),
        ledger[layout.LOST][2],
        ledger[layout.LOST][3],
        ledger[layout.ESCAPED][3],
        raw.crossings,
        raw.collisions,
        velocities,
        records_of(raw.records, raw.stride, raw.seed),
        raw.sizes,
        raw.seed,
        number,
        number + 1,
    )


def _columns(plan: Plan, raws: list) -> tuple:
    """Return weights, counts, slants and grazing excess of each batch; long columns are packed."""
    if plan.rows > MAX_UNPACKED_ROWS:
        return zip(*(_long_columns(plan, raw.detectors) for raw in raws), strict=True)
    detectors = np.array([raw.detectors for raw in raws])
    detectors[:, 0] = 0  # unused row: the target of lanes without a detector
    high, low, counts, slants = (detectors[..., column] for column in range(4))
    excess = (counts[:, : 2 * plan.half] >> layout.COUNT_BITS).reshape(len(raws), 2, -1).sum(axis=1)
    firsts = plan.first_detector_rows
    return (
        high * HIGH_UNIT + low * LOW_UNIT,
        counts & MOST_COUNT,
        slants * SLANT_UNIT,
        np.add.reduceat(excess, firsts, axis=1) if len(firsts) else excess[:, :0],
    )


def _long_columns(plan: Plan, detectors: np.ndarray) -> tuple:
    """Return the packed columns of one batch, computed in stretches of rows."""
    detectors[0] = 0
    columns = make_columns(
        [
            lambda a, b: detectors[a:b, 0] * HIGH_UNIT + detectors[a:b, 1] * LOW_UNIT,
            lambda a, b: detectors[a:b, 2] & MOST_COUNT,
            lambda a, b: detectors[a:b, 3] * SLANT_UNIT,
        ],
        [1, 1, SLANT_UNIT],
        detectors,
    )
    firsts = plan.first_detector_rows.tolist()
    rows = zip(firsts, [*firsts[1:], plan.half], strict=True) if firsts else ()
    excess = [_grazing_excess_of_rows(plan, detectors[:, 2], *each) for each in rows]
    return *columns, np.array(excess, np.int64)


def _grazing_excess_of_rows(plan: Plan, counts: np.ndarray, first: int, past: int) -> int:
    """The grazing excess of one detector, computed in stretches of rows."""
    sides = (counts[: plan.half], counts[plan.half : 2 * plan.half])
    return sum(
        int((side[a : min(a + CHUNK_ROWS, past)] >> layout.COUNT_BITS).sum())
        for side in sides
        for a in range(first, past, CHUNK_ROWS)
    )
