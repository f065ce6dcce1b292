"""What a detector read, laid on the facets of its shape: the value, its error and the number of hits of each cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from transport.scene.detectors import Detector
from transport.statistics.axes import POSITION
from transport.statistics.chunked import over_batches
from transport.statistics.estimates import Estimate, EstimateArray

SYMBOLS = {"irradiance": "E", "exitance": "M"}
OF_VOLUMES = {"fluence_rate": "φ"}
LEAVING = ("exitance",)
PLACES = ("u", "v")
LEAST_HITS = 4  # below, a cell is grey
SPANS = {"time": "s", "speed": "m/s"}  # axes that a detector may cover in part


@dataclass(frozen=True)
class Paint:
    """values, errors, hits: of each bin of place, flat, u before v;  words: the value with its error, of one without bins;

    only: what alone was counted, such as "events=0", None where all was.
    """

    quantity: str
    unit: str
    words: str | None
    only: str | None
    values: np.ndarray
    errors: np.ndarray
    hits: np.ndarray

    def on(self, bins: np.ndarray) -> dict[str, np.ndarray]:
        """Cell arrays for facets of these bins; nan, and no hits, for what lies in none (-1)."""
        columns = {self.quantity: self.values, f"{self.quantity} error": self.errors}
        found = {name: np.append(column, np.nan)[bins] for name, column in columns.items()}
        return found | {"hits": np.append(self.hits, 0)[bins]}


def paint_of(reading: object, quantity: str = "irradiance", duration: float | None = None) -> Paint:
    """What a detector read of that quantity, by place: means over bins of time, sums over those of speed.

    duration: of the scene's clock [s]; bins of time that cover it all leave nothing out.

    Raises ValueError for a quantity that cannot be painted.
    """
    if quantity not in SYMBOLS:
        raise ValueError(f"painted: quantity must be one of {', '.join(SYMBOLS)}, got {quantity!r}")
    read = getattr(reading, quantity)
    estimate = by_place(read)
    values, errors = (np.ravel(getattr(estimate, name)).astype(float) for name in ("value", "error"))
    hits = np.broadcast_to(np.ravel(_hits(reading, quantity)), values.shape)
    words = str(estimate) if isinstance(estimate, Estimate) else None
    return Paint(
        quantity, str(estimate.unit), words, _only(reading.detector, read, duration), values, errors, hits
    )


def by_place(estimate: Estimate | EstimateArray) -> Estimate | EstimateArray:
    """Over u and v alone."""
    if "time" in estimate.coords:
        widths = np.diff(estimate.coords["time"])
        shares = widths / widths.sum()
        axis = estimate.dims.index("time")
        estimate = (estimate * shares.reshape(-1, *(1,) * (len(estimate.dims) - 1 - axis))).sum("time")
    if "speed" in estimate.coords:
        estimate = estimate.sum("speed")
    return estimate


def _only(detector: Detector, read: Estimate | EstimateArray, duration: float | None) -> str | None:
    """What a detector is limited to, as it is written; None where it counts all."""
    limits = {name: getattr(detector, name) for name in ("via", "events")}
    said = [f"{name}={limit!r}" for name, limit in limits.items() if limit is not None]
    spans = {name: edges for name, edges in read.coords.items() if name in SPANS}
    if "time" in spans and spans["time"][0] == 0 and spans["time"][-1] == duration:
        del spans["time"]
    said += [f"{name} {edges[0]:.3g} to {edges[-1]:.3g} {SPANS[name]}" for name, edges in spans.items()]
    return ", ".join(said) or None


def _hits(reading: object, quantity: str) -> np.ndarray:
    """How many scores each bin of place is made of."""
    score = "weight out" if quantity in LEAVING else "weight in"
    if score in reading.scores:
        kept = [axis.group for axis in reading.axes_of(score, (POSITION,))]
        others = tuple(k for k, group in enumerate(kept) if group != POSITION)
        return over_batches(reading.counts_of(score, (POSITION,))).sum(axis=others)
    counts = reading.counts
    if not isinstance(counts, EstimateArray):
        return np.array(counts.value)
    others = tuple(k for k, name in enumerate(counts.dims) if name not in PLACES)
    return counts.value.sum(axis=others)
