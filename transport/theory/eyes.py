"""An eye in front of a round wall: the reading R = L T of a cell of its retina, and its limits.

The eye has its pupil 17 mm in front of the retina (the reduced eye: Listing 1853). T is the throughput
between the pupil and the cell. R = L T requires that the ray from the cell through every point of the
pupil ends on the wall. With an ideal lens in the pupil, which conserves throughput, these rays end on
the cell's image; with a bare pupil, on a patch that is wider by the pupil.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from transport.theory.apertures import reach_through_lens, three_disks_throughput
from transport.theory.elements import disks_throughput

DEPTH = 0.017  # m, from the pupil to the retina
SURE = 0.98  # share of a radius up to which traced rays count as inside


@dataclass(frozen=True)
class Eye:
    """A round wall and an eye on its axis.

    Parameters
    ----------
    wall : float
        Radius of the wall [m].
    distance : float
        Distance from the wall to the pupil [m].
    pupil : float
        Radius of the pupil [m].
    cell : float
        Radius of the retina's central cell [m].
    has_lens : bool, default False
        Whether an ideal lens in the pupil focuses the wall on the retina.

    Examples
    --------
    >>> from transport.theory.eyes import Eye
    >>> print(f"{Eye(wall=1.0, distance=2.0, pupil=0.002, cell=0.001).furthest:.4g}")
    5.655
    """

    wall: float
    distance: float
    pupil: float
    cell: float
    has_lens: bool = False

    @property
    def focal_length(self) -> float:
        """Focal length of the lens [m], from 1/f = 1/depth + 1/distance; inf without a lens."""
        return 1 / (1 / DEPTH + 1 / self.distance) if self.has_lens else math.inf

    @property
    def furthest(self) -> float:
        """Distance at which the wall just fills the central cell's view [m]; the lens's blur is neglected."""
        if self.has_lens:
            return self.wall * DEPTH / self.cell
        return (self.wall - self.pupil) * DEPTH / (self.pupil + self.cell)

    def throughput(self, inner: float, outer: float) -> float:
        """Throughput between the pupil and a ring of the retina.

        Parameters
        ----------
        inner : float
            Inner radius of the ring [m].
        outer : float
            Outer radius of the ring [m].

        Returns
        -------
        float
            T [m^2 sr].

        Notes
        -----
        Source: Howell, C-41.
        """
        whole, middle = (disks_throughput(self.pupil, radius, DEPTH) for radius in (outer, inner))
        return float(whole - middle)

    def brightness(self, inner: float, outer: float) -> float | None:
        """Reading of a ring of the retina over L T.

        Parameters
        ----------
        inner : float
            Inner radius of the ring [m].
        outer : float
            Outer radius of the ring [m].

        Returns
        -------
        float or None
            R / L T [1]; None if the lens puts an edge of the wall's image on the ring.

        Notes
        -----
        It is 1 where the wall fills the ring's view, 0 where the ring does not see the wall, and T'/T
        for a central cell that holds the whole image, T' the throughput between wall and pupil. With a
        bare pupil all values between follow from the throughput of ring, pupil and wall.
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
