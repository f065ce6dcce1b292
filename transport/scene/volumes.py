"""Volume detectors: means over a box, a sphere or a cylinder, by track length or by collisions."""

import math
from collections.abc import Iterable

import numpy as np

from transport.geometry.flat import Slab
from transport.geometry.revolved import Cylinder
from transport.geometry.shape import Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.bins import DirectionSphere, check_bin_count
from transport.scene.sides import AnyDetector
from transport.validation import (
    ConvertedAs,
    as_float,
    as_floats,
    check_one_of,
    check_type,
    coerce_name,
    is_whole_number,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)

MAX_CELLS_PER_AXIS = 1_000_000  # per axis; more would be a mistake
TRACK, COLLISION = "track", "collision"


@scene_object
class VolumeDetector(AnyDetector):
    """Means over a volume, or over each of its cells: fluence rate, absorbed power, radiance.

    It affects no particle.

    Parameters
    ----------
    shape : Box, Sphere, Cylinder or str
        A Box, a whole Sphere, the volume within a Cylinder between its ends, or the name of a surface of such
        a shape.
    name : str, default the surface's name
        Key of the detector in the result; required with a shape.
    cells : int or sequence, default None
        For a Box: (nx, ny, nz) equal voxels. For a Sphere: a number of equally thick shells, or the
        increasing radii [m] of the shells within its own (the first may be 0). For a Cylinder: (nr, nz)
        rings, equally thick in the radius r, in layers of equal height z. None: one cell.
    directions : Directions.sphere, default None
        Bins over all directions of flight, for `radiance`.
    estimator : {"track", "collision"}, default "track"
        "track" scores weight times track length in each cell, in vacuum too; where absorption reduces
        the weight along the track, the mean weight is used. "collision" scores at each collision the
        weight divided by the collision coefficient: noisier in thin media, cheaper in thick ones. With
        weighted tracking only scattering makes collisions, so that all media in the shape must scatter.

    Raises
    ------
    SceneError
        If an argument is invalid, or if there are too many cells.

    Notes
    -----
    Track-length and collision estimators: Spanier and Gelbard 1969, section 2.6. A track along a face of the
    volume counts as inside; a track along the face between two voxels counts in one of them. The coordinate
    z of a Cylinder is a height above its center, along its axis.

    Examples
    --------
    >>> import transport as tp
    >>> box = tp.Box(size=2.0)
    >>> core = tp.VolumeDetector(box, name="core", cells=(1, 1, 2))
    >>> core.edges(box)["z"]  # [m]
    array([-1.,  0.,  1.])
    >>> core.volumes(box).shape
    (1, 1, 2)
    >>> rod = tp.Cylinder(radius=2.0, height=3.0)
    >>> tp.VolumeDetector(rod, name="rod", cells=(2, 1)).volumes(rod).round(4)  # [m^3], rings of one layer
    array([[ 9.4248],
           [28.2743]])
    """

    shape: Shape | str
    name: ConvertedAs[str | None, str, str | None] = None
    cells: ConvertedAs[
        int | Iterable[float] | None, tuple[float, ...] | None, int | tuple[float, ...] | None
    ] = None
    directions: DirectionSphere | None = None
    estimator: str = TRACK

    def __post_init__(self) -> None:
        coerce_name(self)
        check_type(self, "shape", (Shape, str), "a Box, a Sphere, a Cylinder or the name of a surface")
        if self.name is None:
            if not isinstance(self.shape, str):
                refuse(self, "name must be given with a shape, got None; write name='inside'")
            set_fields(self, name=self.shape)
        check_one_of(self, "estimator", (TRACK, COLLISION))
        if self.directions is not None:
            must = "Directions.sphere(mu=..., phi=...), over all directions"
            check_type(self, "directions", DirectionSphere, must)
        self._coerce_cells()
        if isinstance(self.shape, Shape):
            self.check_shape(self.shape)

    def check_shape(self, shape: Shape) -> None:
        """Raise SceneError if the shape is no Box, whole Sphere or Cylinder, or if cells do not fit it."""
        cure = "use a Box, a Sphere or a Cylinder in it"
        if isinstance(shape, Slab):
            cure = "use a Box in it, such as one from face to face"
        if not isinstance(shape, Box | Sphere | Cylinder):
            got = type(shape).__name__
            refuse(self, f"shape must be a Box, a Sphere or a Cylinder, got a {got}; {cure}")
        if isinstance(shape, Sphere) and shape.is_zone:
            refuse(
                self, f"shape must be a whole Sphere, got {short_repr(shape)}; leave mu_min and mu_max out"
            )
        # Count the cells, and refuse too many.
        counts = {name: len(edges) - 1 for name, edges in self.edges(shape).items()}
        if self.directions is not None:
            counts |= {name: len(edges) - 1 for name, edges in self.directions.edges().items()}
        check_bin_count(self, counts or {"cells": 1}, sides=2)

    def check_clock(self, duration: float | None) -> None:
        """Accept every scene, with a duration or without."""

    def edges(self, shape: Shape) -> dict[str, np.ndarray]:
        """Return the edges of the cells.

        Returns
        -------
        dict of str to array
            Edges [m]: "x", "y", "z" of a Box in world coordinates, "r" of a Sphere, or "r" and "z" of a
            Cylinder, z from its center along its axis; empty without cells.
        """
        if self.cells is None:
            return {}
        if isinstance(shape, Sphere):
            return {"r": self._radii(shape)}
        if isinstance(shape, Box):
            many, names, lows, highs = "three", "xyz", *shape.bounds
        else:
            half = shape.height / 2
            many, names, lows, highs = "two", "rz", (0.0, -half), (shape.radius, half)
        if len(self.cells) != len(names) or not all(map(_is_cell_count, self.cells)):
            must = f"{many} whole numbers for a {type(shape).__name__}, each from 1 to {MAX_CELLS_PER_AXIS}"
            cure = f"write cells=({', '.join(f'n{name}' for name in names)})"
            refuse(self, f"cells must be {must}, got {short_repr(self.cells)}; {cure}")
        spans = zip(names, lows, highs, self.cells, strict=True)
        return {name: np.linspace(low, high, count + 1) for name, low, high, count in spans}

    def volumes(self, shape: Shape) -> np.ndarray:
        """Return the volume of each cell.

        Returns
        -------
        array
            Volumes [m^3], of the shape of the cells; a scalar without cells.
        """
        edges = self.edges(shape)
        if not edges:
            return np.float64(shape.volume)
        if isinstance(shape, Box):
            return np.full([len(e) - 1 for e in edges.values()], shape.volume / math.prod(self.cells))
        a, b = edges["r"][:-1], edges["r"][1:]
        if isinstance(shape, Cylinder):
            layers = self.cells[1]
            return np.outer(math.pi * (b - a) * (a + b), np.full(layers, shape.height / layers))
        return 4 * math.pi / 3 * (b - a) * (a * a + a * b + b * b)  # no difference of cubes, which cancels

    def _radii(self, shape: Sphere) -> np.ndarray:
        cells = self.cells
        if len(cells) == 1:
            if not _is_cell_count(cells[0]):
                must = (
                    f"a number of shells from 1 to {MAX_CELLS_PER_AXIS}, or two radii at least, for a Sphere"
                )
                refuse(self, f"cells must be {must}, got {short_repr(cells)}; write cells=(10,)")
            return np.linspace(0.0, shape.radius, cells[0] + 1)
        radii = np.array(cells, dtype=float)
        if radii[-1] > shape.radius * (1 + 4e-16) or not (np.diff(radii) > 0).all():
            must = f"radii that rise within [0, {shape.radius!r}] m of the Sphere"
            cure = "write numpy.linspace(0, radius, shells + 1)"
            refuse(self, f"cells must be {must}, got {short_repr(cells)}; {cure}")
        return radii.clip(0.0, shape.radius)

    def _coerce_cells(self) -> None:
        """Convert `cells` to None or a tuple of counts and lengths; the shape decides what they mean."""
        if self.cells is None:
            return
        given = (self.cells,) if is_whole_number(self.cells) else self.cells
        if as_floats(given) is None or len(given) == 0 or min(map(as_float, given)) < 0:
            must = (
                "(nx, ny, nz) of a Box, (nr, nz) of a Cylinder, or a number of shells or the radii between"
                " them of a Sphere"
            )
            refuse(self, f"cells must be {must}, got {short_repr(self.cells)}")
        set_fields(
            self, cells=tuple(int(each) if is_whole_number(each) else as_float(each) for each in given)
        )


def _is_cell_count(value: float) -> bool:
    return is_whole_number(value) and 1 <= value <= MAX_CELLS_PER_AXIS
