"""The samples of snapshots: recorded particles, of histories chosen by their numbers alone.

All snapshots of a batch record the same histories.  Excess records are thinned by the history's own random
number in [0, 1), so that a history in one snapshot that is absent from a later one has ended in between.
"""

import numpy as np

from transport.compile.layout import RECORD
from transport.results.aside import let_go, put_aside, room_for

SAMPLED = np.dtype([*RECORD.descr, ("identity", "i8"), ("place", "f8"), ("below", "f8")])
# identity: of the history in the run;  place: its number in [0, 1);  below: limit of the kept places


def records_of(raw: np.ndarray, stride: int, seed: int) -> np.ndarray:
    """Convert a batch's records to SAMPLED; each weight is multiplied by the histories that it stands for."""
    records = room_for(len(raw), SAMPLED)
    if not len(raw):
        return records
    for name in RECORD.names:
        records[name] = raw[name]
    records["weight"] *= stride
    records["identity"] = (raw["batch"] << 32) | raw["history"]
    records["place"] = (
        _mixed(records["identity"].astype(np.uint64) ^ _mixed(np.array([seed], np.uint64))) * 2.0**-64
    )
    records["below"] = 1.0
    let_go(records)
    return records


def merged_records(one: np.ndarray, other: np.ndarray, most: int) -> np.ndarray:
    """Concatenate records; if there are more than `most`, keep those of half as many histories."""
    records = np.concatenate([one, other])
    if len(records) > most:
        records = thinned(records, 0.5 * records["below"].min())
    return put_aside(records)


def thinned(records: np.ndarray, below: float) -> np.ndarray:
    """The records of the histories with places below a limit, with weights increased accordingly."""
    kept = records[records["place"] < below]
    kept["weight"] *= np.maximum(kept["below"] / below, 1.0)
    kept["below"] = np.minimum(kept["below"], below)
    return kept


def chance_alike(records: list[np.ndarray], snapshots: list[int], most: int) -> float:
    """The probability for choosing histories so that no snapshot has more than `most` records.

    It is the place of the first history that is left out; sums with weights of one over it are unbiased
    (priority sampling: Duffield, Lund, Thorup 2007).
    """
    limit = 1.0
    for number in snapshots:
        own = np.concatenate([_places(of_batch[of_batch["snapshot"] == number]) for of_batch in records])
        if len(own) > most:
            own.sort()
            limit = min(limit, float(own[most]))
    return limit


def chosen_of(records: np.ndarray, snapshot: int, chance: float) -> np.ndarray:
    """Which records belong to a snapshot and to histories chosen with this probability, (N,) of bool."""
    return (records["snapshot"] == snapshot) & (_places(records) < chance)


def _places(records: np.ndarray) -> np.ndarray:
    return records["place"] / records["below"]


def told_apart(identities: np.ndarray, seeds: np.ndarray, seed: int) -> np.ndarray:
    """Numbers of histories that are distinct for different seeds, (N,); unchanged for histories of `seed`."""
    own = _mixed(np.array([seed], np.uint64))
    return (identities.astype(np.uint64) ^ _mixed(seeds) ^ own).astype(np.int64)


def _mixed(numbers: np.ndarray) -> np.ndarray:
    """A hash of 64 bits for each number (SplitMix64: Steele, Lea, Flood 2014)."""
    z = numbers + np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))
