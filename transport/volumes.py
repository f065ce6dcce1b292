"""Volume detectors: what is in a box or a ball, by the ways that particles go in it or by their collisions there."""

import math
from collections.abc import Iterable

import numpy as np

from transport.bins import DirectionSphere, check_total
from transport.fields import ConvertedAs
from transport.shapes import Box, Shape, Slab, Sphere
from transport.sides import AnyDetector
from transport.validation import (
    as_float,
    as_floats,
    check_one_of,
    check_type,
    is_count,
    refuse,
    scene_object,
    settle_name,
    shown,
    store,
)

MOST_CELLS = 1_000_000  # along one axis; more would be a slip
TRACK, COLLISION = "track", "collision"


@scene_object
class VolumeDetector(AnyDetector):
    """Means over a volume, or over each of its `cells`: fluence rate, absorbed power, radiance; it stops nothing.

    shape: a Box, a whole Sphere, or the name of a surface of such a shape.  cells: (nx, ny, nz) equal voxels of a Box; a
    number of shells of a Sphere, equally thick, or the radii [m] between them, rising within its own (the first may be 0).
    directions: Directions.sphere(mu=8, phi=16), bins over all directions of flight, for `radiance`.
    estimator "track": weight times length of way in each cell (Spanier and Gelbard 1969, 2.6), in vacuum as well; where
    absorption lessens the weights on the way, their mean on it.  "collision": weight over the coefficient by which
    collisions happen, at each: of more noise in thin media, of less work in thick ones.  Followed by weight, only
    scattering makes collisions: then all that fills the shape must scatter.
    A way along a face belongs to the volume; one along a face between two voxels to one of them.
    """

    shape: Shape | str
    name: ConvertedAs[str | None, str, str | None] = None
    cells: ConvertedAs[
        int | Iterable[float] | None, tuple[float, ...] | None, int | tuple[float, ...] | None
    ] = None
    directions: DirectionSphere | None = None
    estimator: str = TRACK

    def __post_init__(self) -> None:
        settle_name(self)
        check_type(self, "shape", (Shape, str), "a Box, a Sphere or the name of a surface")
        if self.name is None:
            if not isinstance(self.shape, str):
                refuse(self, "name must be given with a shape, got None; write name='inside'")
            store(self, name=self.shape)
        check_one_of(self, "estimator", (TRACK, COLLISION))
        if self.directions is not None:
            must = "Directions.sphere(mu=..., phi=...), over all directions"
            check_type(self, "directions", DirectionSphere, must)
        self._settle_cells()
        if isinstance(self.shape, Shape):
            self.check_shape(self.shape)

    def check_shape(self, shape: Shape) -> None:
        """Refuse a resolved shape that has no volume here, and cells that do not fit it."""
        cure = "meter a Box or a Sphere in it"
        if isinstance(shape, Slab):
            cure = "meter a Box in it, such as one from face to face"
        if not isinstance(shape, Box | Sphere):
            refuse(self, f"shape must be a Box or a Sphere, got a {type(shape).__name__}; {cure}")
        if isinstance(shape, Sphere) and shape.is_zone:
            refuse(self, f"shape must be a whole Sphere, got {shown(shape)}; leave mu_min and mu_max out")
        counts = {name: len(edges) - 1 for name, edges in self.edges(shape).items()}
        if self.directions is not None:
            counts |= {name: len(edges) - 1 for name, edges in self.directions.edges().items()}
        check_total(self, counts or {"cells": 1}, sides=2)

    def check_clock(self, duration: float | None) -> None:
        """With a clock or without: it looks all the time."""

    def edges(self, shape: Shape) -> dict[str, np.ndarray]:
        """Edges [m] of the cells, "x", "y", "z" of a Box in the world or "r" of a Sphere; none without cells."""
        if self.cells is None:
            return {}
        if isinstance(shape, Box):
            if len(self.cells) != 3 or not all(map(_is_number_of_cells, self.cells)):
                must = f"three whole numbers for a Box, each from 1 to {MOST_CELLS}"
                refuse(self, f"cells must be {must}, got {shown(self.cells)}; write cells=(nx, ny, nz)")
            spans = zip("xyz", *shape.bounds, self.cells, strict=True)
            return {name: np.linspace(low, high, count + 1) for name, low, high, count in spans}
        return {"r": self._radii(shape)}

    def volumes(self, shape: Shape) -> np.ndarray:
        """Volumes [m^3] of the cells, of the shape of their axes; of the whole, where there are none."""
        edges = self.edges(shape)
        if not edges:
            return np.float64(shape.volume)
        if isinstance(shape, Box):
            return np.full([len(e) - 1 for e in edges.values()], shape.volume / math.prod(self.cells))
        a, b = edges["r"][:-1], edges["r"][1:]
        return 4 * math.pi / 3 * (b - a) * (a * a + a * b + b * b)  # no difference of cubes

    def _radii(self, shape: Sphere) -> np.ndarray:
        cells = self.cells
        if len(cells) == 1:
            if not _is_number_of_cells(cells[0]):
                must = f"a number of shells from 1 to {MOST_CELLS}, or two radii at least, for a Sphere"
                refuse(self, f"cells must be {must}, got {shown(cells)}; write cells=(10,)")
            return np.linspace(0.0, shape.radius, cells[0] + 1)
        radii = np.array(cells, dtype=float)
        if radii[-1] > shape.radius * (1 + 4e-16) or not (np.diff(radii) > 0).all():
            must = f"radii that rise within [0, {shape.radius!r}] m of the Sphere"
            cure = "write numpy.linspace(0, radius, shells + 1)"
            refuse(self, f"cells must be {must}, got {shown(cells)}; {cure}")
        return radii.clip(0.0, shape.radius)

    def _settle_cells(self) -> None:
        """None, or a tuple of whole numbers and of lengths; what they mean is known with the shape."""
        if self.cells is None:
            return
        given = (self.cells,) if is_count(self.cells) else self.cells
        if as_floats(given) is None or len(given) == 0 or min(map(as_float, given)) < 0:
            must = "(nx, ny, nz) of a Box, or a number of shells or the radii between them of a Sphere"
            refuse(self, f"cells must be {must}, got {shown(self.cells)}")
        store(self, cells=tuple(int(each) if is_count(each) else as_float(each) for each in given))


def _is_number_of_cells(value: float) -> bool:
    return is_count(value) and 1 <= value <= MOST_CELLS
