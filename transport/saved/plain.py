"""The state of a run as JSON data: dataclasses, lists, tuples, dictionaries and numbers, bit for bit.

Each type is tagged, {"tuple": [...]}, {"Look": {"particles": ...}}, so that reading restores it.  Batches are
stored as numbers only: {"batch": 3}.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from transport.estimators.methods import Method
from transport.results.batches import Batch
from transport.results.choice import Choice, Mean, Pilot
from transport.results.record import Cost, Forecast
from transport.runs.limits import Limits
from transport.runs.origins import Origin
from transport.runs.state import State
from transport.runs.stopping import Look, Standing
from transport.tracking import Splitting, Tracking

_ALL = (
    Choice,
    Cost,
    Forecast,
    Limits,
    Look,
    Mean,
    Method,
    Origin,
    Pilot,
    Splitting,
    Standing,
    State,
    Tracking,
)
KINDS = {kind.__name__: kind for kind in _ALL}


class Pool:
    """Numbered batches, each stored once."""

    def __init__(self) -> None:
        self.batches: list[Batch] = []
        self._numbers: dict[int, int] = {}

    def number_of(self, batch: Batch) -> int:
        """Return the number of a batch; a new batch is added."""
        if id(batch) not in self._numbers:
            self._numbers[id(batch)] = len(self.batches)
            self.batches.append(batch)
        return self._numbers[id(batch)]


def plain(value: object, pool: Pool) -> object:
    """Return the value as JSON data.  Raises TypeError for a type outside KINDS."""
    match value:
        case None | bool() | int() | str():
            return value
        case np.generic():
            return plain(value.item(), pool)
        case float():
            return value if math.isfinite(value) else {"float": repr(value)}
        case Batch():
            return {"batch": pool.number_of(value)}
        case list():
            return [plain(item, pool) for item in value]
        case tuple():
            return {"tuple": [plain(item, pool) for item in value]}
        case Mapping():
            return {"table": [[plain(key, pool), plain(item, pool)] for key, item in value.items()]}
    kind = type(value).__name__
    if KINDS.get(kind) is not type(value):
        raise TypeError(f"{kind} cannot be stored in the file of a run: saved.plain.KINDS lists the types")
    names = [field.name for field in dataclasses.fields(value) if field.init]
    return {kind: {name: plain(getattr(value, name), pool) for name in names}}


def meant(data: object, batches: list[Batch]) -> object:
    """Return the value of JSON data that `plain` wrote.  Raises KeyError or TypeError for other data."""
    if isinstance(data, list):
        return [meant(item, batches) for item in data]
    if not isinstance(data, dict):
        return data
    ((kind, content),) = data.items()
    match kind:
        case "float":
            return float(content)
        case "batch":
            return batches[content]
        case "tuple":
            return tuple(meant(item, batches) for item in content)
        case "table":
            return {meant(key, batches): meant(item, batches) for key, item in content}
    return KINDS[kind](**{name: meant(item, batches) for name, item in content.items()})
