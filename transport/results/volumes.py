"""The tally of a VolumeDetector: means over the cells of a volume, each with its standard error."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property, partial

import numpy as np

from transport.geometry.revolved import Cylinder
from transport.geometry.solid import Box, Sphere
from transport.results.batches import Batch
from transport.results.tally import (
    NO_CLOCK,
    Lacks,
    Measure,
    Quantity,
    Score,
    Tally,
    energy_unit,
    plain_column,
)
from transport.scene.bodies import may_absorb
from transport.scene.parts import SceneParts
from transport.scene.volumes import VolumeDetector
from transport.statistics.axes import DIRECTION
from transport.statistics.chunked import over_batches
from transport.statistics.estimates import EstimateOrArray

# Absorbed share of what a cell of the most absorbing medium would absorb; below it, geometry decides whether
# it absorbs.
NEGLIGIBLE_ABSORPTION = 1e-6


class VolumeReading(Tally):
    """The quantities of one VolumeDetector, from `result["name"]`.

    Parameters
    ----------
    result : Result
        The run.
    detector : VolumeDetector
        The detector of the scene.

    Raises
    ------
    SceneError
        When a quantity is read for which the detector or the scene has not the options.

    Notes
    -----
    With cells each quantity is an EstimateArray with the axes of the cells, (x, y, z), (r,) or (r, z);
    without cells it is an Estimate.  Sources of particles give s^-1 in place of W, and 1 in place of J.
    """

    kind = "volume detector"
    main = ("path",)

    fluence_rate = Quantity(
        "Mean of ∫ L dω over each cell, φ [W m^-2 or s^-1 m^-2]; with a clock also over its duration.",
        "path",
        per=("time", "volume"),
    )
    absorbed_power = Quantity(
        """Power absorbed by the media in each cell [W or s^-1].

        Absorption coefficient times fluence rate, integrated over the cell's volume.
        """,
        "absorbed",
        per=("time",),
        needs=("absorption",),
    )
    absorbed_density = Quantity(
        "Absorbed power per volume [W m^-3 or s^-1 m^-3].",
        "absorbed",
        per=("time", "volume"),
        needs=("absorption",),
    )
    radiance = Quantity(
        "Mean over each cell and each bin of flight direction, L [W m^-2 sr^-1 or s^-1 m^-2 sr^-1].",
        "path",
        (DIRECTION,),
        ("time", "volume", "solid angle"),
        ("directions",),
    )
    counts = Quantity(
        "Number of scores in the whole run: of paths through each cell, or of collisions there [1].", "count"
    )
    fluence = Quantity(
        "Fluence rate integrated over the duration, H [J m^-2 or m^-2]; mean over each cell.",
        "path",
        per=("volume",),
        needs=("clock",),
    )
    absorbed_energy = Quantity(
        "Energy [J], or particles, absorbed by the media in each cell within the duration.",
        "absorbed",
        needs=("clock", "absorption"),
    )

    def __init__(self, result, detector: VolumeDetector) -> None:
        super().__init__(result, detector)
        self._volume = next(volume for volume in self.plan.volumes if volume.detector is detector)
        self.shape = self._volume.shape
        self._rows, self._absorbed_rows = (
            each.get(self.name) for each in (self.plan.rows_of, self.plan.absorbed_rows_of)
        )
        self.cells, self.axes = self._rows.outer, self._rows.axes

    @cached_property
    def volumes(self) -> np.ndarray:
        """Volume of each cell [m^3].

        Returns
        -------
        numpy.ndarray
            Shape of the cells.
        """
        return self.detector.volumes(self.shape)

    @cached_property
    def scores(self) -> Mapping[str, Score]:
        """Path lengths times weight, and absorbed weight."""
        plan, rows, energy = self.plan, self._rows, energy_unit(self.plan)
        weights, counts = plain_column("weights"), plain_column("counts")
        missing = partial(self.diagnosis.missing, "path")
        path = Score(rows, weights, counts, f"{energy} m", self.unit * plan.unit, findings=missing)
        found = {"path": path, "count": Score(rows, counts, counts, "1", float(self.particles))}
        if self._absorbed_rows is not None:
            found["all absorbed"] = Score(self._absorbed_rows, weights, counts, energy)
            found["absorbed"] = Score(
                self._absorbed_rows,
                self._absorbed,
                counts,
                energy,
                is_dark=lambda: not self._may_absorb.any(),
                findings=missing,
                largest=max(float(np.max(medium.absorption)) for medium in plan.distinct_media) * path.scale,
            )
        return found

    def _absorbed(self, batch: Batch, first: int, past: int) -> np.ndarray:
        """Absorbed weight in the unit of the run, in the cells where anything absorbs."""
        base = self._absorbed_rows.first
        which = slice(first - base, past - base)
        return batch.weights[first:past] * np.ravel(self._may_absorb)[which] * self.plan.unit

    @cached_property
    def measures(self) -> Mapping[str, Callable[[], Measure]]:
        """Sizes of the cells and of the bins of direction, by name."""
        cells = tuple(axis.name for axis in self.cells)
        return {
            "time": lambda: Measure(self.plan.time_unit, "s"),
            "volume": lambda: Measure(self.volumes, "m^3", cells),
            "solid angle": lambda: Measure(self.detector.directions.solid_angles(), "sr", ("mu", "phi")),
        }

    @cached_property
    def lacks(self) -> Lacks:
        """What the scene or the detector was not set up for."""
        absorption = {} if self._volume.absorbs else {"absorption": NO_ABSORPTION}
        return {**super().lacks, **absorption}

    @staticmethod
    def lacks_of(scene: SceneParts, detector: VolumeDetector) -> Lacks:
        """Return what the scene or the detector was not set up for; known before a run."""
        lacks = {
            "clock": scene.duration is None and NO_CLOCK,
            "directions": detector.directions is None
            and ("directions=..., got None", "write directions=Directions.sphere(mu=8, phi=16)"),
        }
        return {need: why for need, why in lacks.items() if why}

    def __repr__(self) -> str:
        return f"<{self.name}: fluence_rate {self.fluence_rate!r}>"

    def binned(self) -> Iterator[tuple[str, EstimateOrArray]]:
        """Yield the fluence rate by cell."""
        if self.cells:
            yield "fluence_rate", self.fluence_rate

    @property
    def unit(self) -> float:
        """Length of a sum of 1 [m]."""
        return self._volume.unit

    @cached_property
    def _may_absorb(self) -> np.ndarray:
        """Whether anything absorbs in each cell.

        Where nothing absorbs, rounding may still leave the end of a flight through an absorbing neighbour.
        """
        scene, shape = self.plan.scene, self.shape
        found = np.full(np.shape(self.volumes), may_absorb(scene, shape))
        if self.cells and found.all():
            for index in zip(*np.nonzero(self._has_negligible_absorption), strict=True):
                found[index] = may_absorb(scene, *self._cell(index))
        return found

    def _cell(self, index: tuple[int, ...]) -> tuple[Box | Sphere | Cylinder, Sphere | None]:
        """One cell by its index along each axis; a shell as its outer ball and its inner one.

        A ring is held by the cylinder around it.
        """
        shape = self.shape
        spans = [axis.edges[k : k + 2].tolist() for axis, k in zip(self.cells, index, strict=True)]
        if isinstance(shape, Box):
            sizes = [high - low for low, high in spans]
            return Box(center=[(low + high) / 2 for low, high in spans], size=sizes), None
        if isinstance(shape, Cylinder):
            (_, radius), (low, high) = spans
            center = [c + a * (low + high) / 2 for c, a in zip(shape.center, shape.axis, strict=True)]
            return Cylinder(center=center, axis=shape.axis, radius=radius, height=high - low), None
        inner, outer = (Sphere(center=shape.center, radius=r) if r > 0 else None for r in spans[0])
        return outer, inner

    @property
    def _has_negligible_absorption(self) -> np.ndarray:
        """The cells that absorb less than NEGLIGIBLE_ABSORPTION of the share of the most absorbing medium."""
        kept = over_batches(self.sums("all absorbed"))
        lengths = over_batches(self.sums("path")) * self.unit
        most = max(float(np.max(medium.absorption)) for medium in self.plan.distinct_media)
        return (kept > 0) & (kept <= NEGLIGIBLE_ABSORPTION * most * lengths)


NO_ABSORPTION = "a medium that absorbs", "write Medium(absorption=...)"
