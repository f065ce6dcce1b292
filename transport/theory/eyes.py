"""An eye before a round wall: what a cell of its retina reads, R = L T, and when the wall is too small for that.

The eye has its pupil 17 mm before the retina (the reduced eye: Listing 1853).  T is the throughput between the pupil and
the cell.  A ray from the cell through every point of the pupil must end on the wall; with an ideal lens in the pupil,
which keeps throughput, these rays end on the cell's image, with a bare pupil on a patch that is wider by the pupil.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from transport.theory.apertures import reach_through_lens, three_disks_throughput
from transport.theory.elements import disks_throughput

DEPTH = 0.017  # m, from the pupil to the retina
SURE = 0.98  # of a radius, up to which what is traced counts as within it


@dataclass(frozen=True)
class Eye:
    """A round wall and an eye on its axis; wall, pupil and the retina's middle cell by their radii [m]."""

    wall: float
    distance: float
    pupil: float
    cell: float
    has_lens: bool = False

    @property
    def focal_length(self) -> float:
        """Of the lens that throws a sharp image of the wall on the retina [m]: 1/f = 1/depth + 1/distance; inf without."""
        return 1 / (1 / DEPTH + 1 / self.distance) if self.has_lens else math.inf

    @property
    def furthest(self) -> float:
        """Distance from which the wall just fills the middle cell's view [m]; with a lens but for its small blur."""
        if self.has_lens:
            return self.wall * DEPTH / self.cell
        return (self.wall - self.pupil) * DEPTH / (self.pupil + self.cell)

    def throughput(self, inner: float, outer: float) -> float:
        """T between the pupil and a ring of the retina [m^2 sr] (Howell, C-41)."""
        whole, middle = (disks_throughput(self.pupil, radius, DEPTH) for radius in (outer, inner))
        return float(whole - middle)

    def brightness(self, inner: float, outer: float) -> float | None:
        """R / L T of a ring of the retina [1]; None where the lens leaves an edge of the wall's image on it.

        1 where the wall fills its view, 0 where its view misses the wall, T'/T for a middle cell that holds the whole
        image, T' between wall and pupil.  With a bare pupil all between is the throughput of ring, pupil and wall.
        """
        reach = reach_through_lens(outer, self.pupil, self.focal_length, DEPTH, self.distance)
        image = reach_through_lens(self.wall, self.pupil, self.focal_length, self.distance, DEPTH)
        whole = self.throughput(inner, outer)
        if reach < SURE * self.wall:
            return 1.0
        if image < SURE * inner:
            return 0.0
        if inner == 0 and image < SURE * outer:
            return float(disks_throughput(self.wall, self.pupil, self.distance)) / whole
        if self.has_lens:
            return None
        return (self._through(outer) - (self._through(inner) if inner > 0 else 0.0)) / whole

    def _through(self, radius: float) -> float:
        return three_disks_throughput(radius, self.pupil, self.wall, DEPTH, self.distance)
