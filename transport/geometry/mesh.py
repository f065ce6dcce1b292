"""Triangle mesh: read-only arrays of vertices and faces, checked once."""

from __future__ import annotations

import functools
import hashlib
import math
import sys
import warnings
from collections.abc import Iterable
from dataclasses import field
from os import PathLike
from typing import Any, NoReturn

import numpy as np

from transport.geometry.flat import even_facets, points_in_triangles
from transport.geometry.mesh_build import arrays_of_file, arrays_of_polydata, box_arrays, sphere_arrays
from transport.geometry.mesh_topology import (
    Edges,
    Facets,
    drop_unused_vertices,
    edges_of,
    facets,
    repeated_triangles,
    signed_volume,
    weld,
    winding_number,
)
from transport.geometry.shape import Shape
from transport.geometry.solid import Box, Sphere
from transport.validation import (
    MASKED_VALUES_HINT,
    ArrayField,
    SceneError,
    as_float,
    as_floats,
    is_masked,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)
from transport.vectors import Frame, Vector, local_frame

MAX_TRIANGLES = 20_000_000  # of Mesh.sphere: about 2 GB
MIN_WINDING_INSIDE = 1 - 2.0**-10  # least winding number of a point inside; points on the surface have less
MAX_HALF_DIAGONAL = 1e150  # half diagonal [m] whose square still fits a double
MAX_EXAMPLES = 3  # number of examples in a message


class MeshWarning(UserWarning):
    """Warning about a mesh that is usable, but whose edges or orientation are probably not intended."""


@scene_object(kw_only=True)
class Mesh(Shape):
    """Triangle mesh, open or closed.

    The arrays are copied, made read-only, and vertices that no triangle uses are dropped. Two meshes are
    equal if their arrays are.

    Parameters
    ----------
    vertices : array (n, 3)
        Vertices [m].
    faces : array (m, 3) of int
        Triangles as indices into `vertices`, counted from 0. The normal of a triangle follows the right-hand
        rule over its vertices: outwards on a closed mesh.

    Attributes
    ----------
    normals : array (m, 3)
        Unit normals, accurate to rounding for thin triangles too.
    areas : array (m,)
        Areas [m^2], accurate to rounding for thin triangles too.
    edges : Edges
        Numbers of open, non-manifold and inconsistently oriented edges.

    Raises
    ------
    SceneError
        If the arrays are not triangles, or a triangle has no area or occurs twice.

    Warns
    -----
    MeshWarning
        If an edge has more than two triangles, neighbours have opposite orientations, or a closed mesh is
        inverted.

    Notes
    -----
    For glass use `Sphere`, not a sphere mesh: flat facets leak light that total internal reflection should
    block.

    Examples
    --------
    >>> import transport as tp
    >>> mesh = tp.Mesh(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces=[(0, 1, 2)])
    >>> mesh
    Mesh(1 triangle, 3 open edges)
    >>> mesh.area
    0.5
    """

    vertices: ArrayField = field(compare=False)
    faces: ArrayField = field(compare=False)
    normals: np.ndarray = field(init=False, compare=False)
    areas: np.ndarray = field(init=False, compare=False)
    edges: Edges = field(init=False, compare=False)
    digest: bytes = field(init=False)  # hash of the arrays' bytes, for == and hash()
    coordinates_cure = "use bins of direction, or one Detector per part of the mesh"

    def __post_init__(self) -> None:
        vertices = coerce_vertices(self, self.vertices)
        faces = coerce_faces(self, self.faces, len(vertices))
        check_size(self, vertices)
        found = facets(vertices, faces)
        check_facets(self, vertices, faces, found)
        vertices, faces = drop_unused_vertices(vertices, faces)
        arrays = {"vertices": vertices, "faces": faces, "normals": found.normals, "areas": found.areas}
        set_fields(self, **arrays, edges=edges_of(faces), digest=_digest(vertices, faces))
        self._freeze()
        warn_about_edges(self.edges)
        if self.edges.are_paired and not self.is_closed:
            warn_of_volume(self.volume, self.volume_rounding, self.triangles)

    @classmethod
    def from_file(cls, path: str | PathLike, scale: float = 1.0, tolerance: float = 0.0) -> Mesh:
        """Read the triangles of an STL, PLY, OBJ or VTP file (needs pyvista).

        Parameters
        ----------
        path : str or Path
            File that ends in .stl, .ply, .obj or .vtp.
        scale : float, default 1
            Unit of length of the file [m], as 1e-3 for millimetres.
        tolerance : float, default 0
            Vertices within this distance [m] of one another are merged; 0 merges equal coordinates only.

        Returns
        -------
        Mesh
            The mesh; triangles that collapse when vertices are merged are left out with a MeshWarning.

        Raises
        ------
        SceneError
            If the file cannot be read or pyvista is not installed.
        """
        return cls._welded(*arrays_of_file(path), scale, tolerance)

    @classmethod
    def from_pyvista(cls, polydata: Any, scale: float = 1.0, tolerance: float = 0.0) -> Mesh:
        """Convert the polygons of a pyvista.PolyData to triangles and merge their vertices.

        Parameters
        ----------
        polydata : pyvista.PolyData
            Polygons; lines and points are ignored.
        scale : float, default 1
            Unit of length of `polydata` [m].
        tolerance : float, default 0
            Distance [m] within which vertices are merged.

        Returns
        -------
        Mesh
            The mesh.

        Raises
        ------
        SceneError
            If `polydata` has no polygons.
        """
        return cls._welded(*arrays_of_polydata(polydata), scale, tolerance)

    @classmethod
    def sphere(
        cls, *, center: Iterable[float] = (0.0, 0.0, 0.0), radius: float, triangles: int = 1280
    ) -> Mesh:
        """Return a closed mesh of a sphere: a subdivided icosahedron with its vertices on the sphere.

        Parameters
        ----------
        center : three floats, default (0, 0, 0)
            Centre [m].
        radius : float
            Radius [m], positive.
        triangles : int, default 1280
            Least number of triangles; the mesh has the next number 20 f^2, f an integer.

        Returns
        -------
        Mesh
            Closed mesh, with area and volume below those of the sphere.

        Examples
        --------
        >>> import transport as tp
        >>> tp.Mesh.sphere(radius=1.0, triangles=100)
        Mesh(180 triangles, closed)
        """
        shape = Sphere(center=center, radius=radius)
        number = as_float(triangles)
        if number is None or number != int(number) or not 1 <= number <= MAX_TRIANGLES:
            must = f"triangles must be a whole number from 1 to {MAX_TRIANGLES}"
            raise SceneError(f"Mesh.sphere: {must}, got {short_repr(triangles)}; write triangles=1280")
        vertices, faces = sphere_arrays(shape.center, shape.radius, int(number))
        return cls(vertices=vertices, faces=faces)

    @classmethod
    def box(cls, *, center: Iterable[float] = (0.0, 0.0, 0.0), size: Iterable[float] | float) -> Mesh:
        """Return a closed mesh of an axis-aligned box: twelve triangles.

        Parameters
        ----------
        center : three floats, default (0, 0, 0)
            Centre [m].
        size : float or three floats
            Edge lengths [m] along x, y and z; one number for a cube.

        Returns
        -------
        Mesh
            Closed mesh.

        Examples
        --------
        >>> import transport as tp
        >>> tp.Mesh.box(size=(1, 2, 3)).volume
        6.0
        """
        vertices, faces = box_arrays(*Box(center=center, size=size).bounds)
        return cls(vertices=vertices, faces=faces)

    @property
    def triangles(self) -> int:
        """Number of triangles."""
        return len(self.faces)

    @functools.cached_property
    def area(self) -> float:
        """Area of one side of all triangles [m^2], accurate to rounding."""
        return math.fsum(self.areas)

    @functools.cached_property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest axis-aligned box that holds the mesh."""
        return tuple(
            tuple(corner.tolist()) for corner in (self.vertices.min(axis=0), self.vertices.max(axis=0))
        )

    @property
    def middle(self) -> Vector:
        """Middle of the bounds [m]."""
        low, high = self.bounds
        return tuple(p / 2 + q / 2 for p, q in zip(low, high, strict=True))

    @functools.cached_property
    def extent(self) -> float:
        """Distance from the middle to the farthest vertex [m]."""
        offset = np.abs(self.vertices - self.middle)
        return float(np.hypot(np.hypot(offset[:, 0], offset[:, 1]), offset[:, 2]).max())

    @property
    def frame(self) -> Frame:
        """Unit vectors (e_u, e_v, axis) of the mesh's coordinates, axis = +z."""
        return local_frame((0.0, 0.0, 1.0), None)

    @property
    def open_edges(self) -> int:
        """Number of edges with one triangle only."""
        return self.edges.open

    @functools.cached_property
    def is_closed(self) -> bool:
        """Whether every edge joins two triangles of equal orientation and the normals point outwards."""
        return self.edges.are_paired and self.volume > self.volume_rounding

    @property
    def volume(self) -> float:
        """Enclosed volume [m^3], negative if the normals point inwards; SceneError for an open mesh."""
        return self._volume[0]

    @property
    def volume_rounding(self) -> float:
        """Bound on the rounding error of `volume` [m^3]."""
        return self._volume[1]

    def holds(self, point: Iterable[float]) -> bool:
        """Return whether a point lies inside a closed mesh; a point in a facet does not.

        Parameters
        ----------
        point : three floats
            Point [m].

        Returns
        -------
        bool
            Whether the winding number of the mesh around the point is 1.

        Raises
        ------
        SceneError
            If the mesh is open.

        Examples
        --------
        >>> import transport as tp
        >>> cube = tp.Mesh.box(size=1.0)
        >>> cube.holds((0, 0, 0)), cube.holds((0, 0, 1))
        (True, False)
        """
        position = as_floats(point)
        if position is None or len(position) != 3:
            refuse(self, f"point must be three finite numbers, got {short_repr(point)}")
        self._require_closed("an inside")
        return self._winds_around(np.array(position))

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Return which points (n, 3) [m] lie inside, as `holds`; none lie in an open mesh."""
        held = np.zeros(len(points), bool)
        if self.is_closed:
            low, high = self.bounds
            near = ((points >= low) & (points <= high)).all(axis=1)
            held[near] = [self._winds_around(point) for point in points[near]]
        return held

    def distance(self, point: Vector, filled: bool = False) -> float:
        """Return the distance [m] of a point from the nearest triangle; filled: from a closed mesh's volume.

        For each triangle it is the height over it if the foot lies inside, else the distance to the nearest
        side.
        """
        if filled and self.is_closed and self.holds(point):
            return 0.0
        corners = self.vertices[self.faces] - np.array(point)
        height = np.abs(np.einsum("ij,ij->i", corners[:, 0], self.normals))
        is_over, nearest = True, math.inf
        for k in range(3):
            start, side = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
            is_left = np.einsum("ij,ij->i", np.cross(start, side), self.normals) >= 0  # of each side
            is_over &= is_left
            step = -np.einsum("ij,ij->i", start, side) / np.einsum("ij,ij->i", side, side)
            apart = np.linalg.norm(start + np.clip(step, 0.0, 1.0)[:, None] * side, axis=1)
            nearest = np.minimum(nearest, apart)
        return float(np.where(is_over, height, nearest).min())

    def sample_area(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points even over the area, and the normals there; see `Shape`."""
        facets, left = even_facets(self.areas, numbers[:, 0])
        corners = self.vertices[self.faces[facets]]
        return points_in_triangles(corners, left, numbers[:, 1:2]), self.normals[facets]

    def flipped(self) -> Mesh:
        """Return the mesh with all normals reversed.

        Returns
        -------
        Mesh
            Same vertices, each triangle in reverse order.
        """
        return self._changed(self.vertices, self.faces[:, ::-1])

    def moved(self, by: Iterable[float]) -> Mesh:
        """Return the mesh translated by a vector.

        Parameters
        ----------
        by : three floats
            Translation [m].

        Returns
        -------
        Mesh
            Translated mesh.

        Examples
        --------
        >>> import transport as tp
        >>> tp.Mesh.box(size=2.0).moved((0, 0, 1)).bounds
        ((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0))
        """
        offset = as_floats(by)
        if offset is None or len(offset) != 3:
            refuse(self, f"by must be three finite lengths, got {short_repr(by)}")
        return self._changed(self.vertices + offset, self.faces)

    def scaled(self, by: float) -> Mesh:
        """Return the mesh scaled about the origin.

        Parameters
        ----------
        by : float
            Positive factor; `tp.mm` for coordinates in millimetres.

        Returns
        -------
        Mesh
            Scaled mesh.

        Examples
        --------
        >>> import transport as tp
        >>> f"{tp.Mesh.box(size=2.0).scaled(by=0.5).volume:g}"
        '1'
        """
        return self._changed(self.vertices * coerce_factor(self, "by", by), self.faces)

    def merged(self, tolerance: float = 0.0) -> Mesh:
        """Return the mesh with coincident vertices merged.

        Parameters
        ----------
        tolerance : float, default 0
            Vertices within this distance [m] of one another are merged; 0 merges equal coordinates only.

        Returns
        -------
        Mesh
            Mesh without triangles that collapsed; their number is warned of.
        """
        return self._welded(self.vertices, self.faces, 1.0, tolerance)

    def __repr__(self) -> str:
        kind = "closed"
        if not self.is_closed:
            edges = self.edges
            counts = {"open": edges.open, "non-manifold": edges.crowded, "misoriented": edges.turned}
            found = [f"{n} {name} edge{'s' if n > 1 else ''}" for name, n in counts.items() if n]
            kind = ", ".join(found) or "inverted"
        return f"Mesh({self.triangles} triangle{'s' if self.triangles > 1 else ''}, {kind})"

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._freeze()

    @functools.cached_property
    def _volume(self) -> tuple[float, float]:
        """Volume [m^3] and the bound on its rounding error."""
        self._require_closed("a volume")
        return signed_volume(self.vertices, self.faces, self.normals, self.areas)

    def _require_closed(self, what: str) -> None:
        """Raise SceneError if the mesh is open."""
        if not self.edges.are_paired:
            cure = "close the holes and orient all triangles alike"
            refuse(self, f"{what} needs a closed mesh, got {self!r}; {cure}")

    def _winds_around(self, point: np.ndarray) -> bool:
        """Return whether the mesh winds once around a point; not around a point in a facet."""
        return abs(winding_number(self.vertices, self.faces, point)) > MIN_WINDING_INSIDE

    def _freeze(self) -> None:
        """Make the arrays read-only."""
        for array in (self.vertices, self.faces, self.normals, self.areas):
            array.flags.writeable = False

    @classmethod
    def _welded(cls, vertices: np.ndarray, faces: np.ndarray, scale: float, tolerance: float) -> Mesh:
        """Mesh of scaled vertices after merging; warns of triangles that collapsed."""
        scale = coerce_factor(cls, "scale", scale)
        tolerance = coerce_tolerance(cls, tolerance)
        found = weld(vertices * scale, faces, tolerance)
        if found.collapsed:
            many = "1 triangle" if found.collapsed == 1 else f"{found.collapsed} triangles"
            warn_mesh(
                f"{many} of {len(faces)} left out: two of their vertices coincide;"
                " repair the file if they matter"
            )
        return cls(vertices=found.vertices, faces=found.faces)

    def _changed(self, vertices: np.ndarray, faces: np.ndarray) -> Mesh:
        """Mesh with new arrays; warnings about its edges were given for the original and are suppressed."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MeshWarning)
            return Mesh(vertices=vertices, faces=faces)


def _digest(*arrays: np.ndarray) -> bytes:
    """Hash of the shapes and bytes of arrays."""
    code = hashlib.blake2b(digest_size=16)
    for array in arrays:
        code.update(repr(array.shape).encode())
        code.update(array)
    return code.digest()


# ---- Checks of the arrays: errors quote the first examples, warnings give counts.


def coerce_vertices(mesh: object, given: Any) -> np.ndarray:
    """Return the vertices as a new float64 array (n, 3) [m], with -0.0 replaced by 0.0."""
    table = _as_table(mesh, "vertices", given, "an array (n, 3) of lengths in metres")
    vertices = np.array(table, dtype=np.float64, order="C") + 0.0
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(bad):
        where = f"{len(bad)} of {len(vertices)}, first vertex {bad[0]}: {short_repr(vertices[bad[0]])}"
        refuse(mesh, f"vertices must be finite, got NaN or infinity in {where}; correct these vertices")
    return vertices


def coerce_faces(mesh: object, given: Any, number: int) -> np.ndarray:
    """Return the faces as a new int64 array (m, 3): distinct indices below `number`, no triangle twice."""
    table = _as_table(mesh, "faces", given, "an array (m, 3) of numbers of vertices")
    if len(table) == 0:
        refuse(mesh, f"faces must hold at least one triangle, got none of {number} vertices; give triangles")
    if table.dtype.kind == "f":
        bad = np.flatnonzero((table != np.floor(table)).any(axis=1) | ~np.isfinite(table).all(axis=1))
        if len(bad):
            where = f"{len(bad)} triangles, {_examples(bad, table)}"
            refuse(mesh, f"faces must be whole numbers, got fractions in {where}; cast them to int")
    bad = np.flatnonzero(((table < 0) | (table >= number)).any(axis=1))
    if len(bad):
        where = f"{len(bad)} of {len(table)} triangles, {_examples(bad, table)}"
        one_based = table.min() == 1 and table.max() == number
        cure = "they count from 0: subtract 1" if one_based else "number the vertices from 0"
        refuse(
            mesh, f"faces must lie in 0 to {number - 1} with {number} vertices, got others in {where}; {cure}"
        )
    faces = np.array(table, dtype=np.int64, order="C")
    a, b, c = faces.T
    bad = np.flatnonzero((a == b) | (b == c) | (c == a))
    if len(bad):
        where = f"{len(bad)} of {len(faces)}, {_examples(bad, faces)}"
        refuse(mesh, f"faces must have three different vertices each, got {where}; leave these triangles out")
    count, pair = repeated_triangles(faces)
    if pair:
        where = (
            f"{count} that repeat an earlier one, first triangles {pair[0]} and {pair[1]}:"
            f" {short_repr(faces[pair[1]])}"
        )
        refuse(mesh, f"faces must not have the same three vertices twice, got {where}; leave the copies out")
    return faces


def coerce_factor(mesh: object, name: str, given: Any) -> float:
    """Return a positive finite number."""
    factor = as_float(given)
    if factor is None or not 0 < factor < math.inf:
        _refuse(
            mesh,
            f"{name} must be a number, positive and finite, got {short_repr(given)};"
            f" write {name}=1e-3 for mm",
        )
    return factor


def coerce_tolerance(mesh: object, given: Any) -> float:
    """Return a length [m], zero or positive."""
    tolerance = as_float(given)
    if tolerance is None or not 0 <= tolerance < math.inf:
        must = "tolerance must be a length in metres, zero or positive and finite"
        _refuse(mesh, f"{must}, got {short_repr(given)}; write tolerance=0 for equal coordinates only")
    return tolerance


def check_size(mesh: object, vertices: np.ndarray) -> None:
    """Raise if the size of the mesh overflows a double."""
    with np.errstate(over="ignore"):
        size = np.linalg.norm(vertices.max(axis=0) / 2 - vertices.min(axis=0) / 2)
    if not size < MAX_HALF_DIAGONAL:
        refuse(
            mesh,
            f"vertices must not be farther apart than {2 * MAX_HALF_DIAGONAL:.0e} m, got {size:.3g};"
            " change the unit",
        )


def check_facets(mesh: object, vertices: np.ndarray, faces: np.ndarray, found: Facets) -> None:
    """Raise for triangles without a normal, and for areas outside the range of doubles."""
    bad = np.flatnonzero(found.is_collinear)
    if len(bad):
        where = f"{len(bad)} of {len(faces)}, first triangle {bad[0]}: {short_repr(vertices[faces[bad[0]]])}"
        cure = "move or merge the vertices, or leave these triangles out"
        refuse(mesh, f"triangles must have an area, got vertices on one line in {where}; {cure}")
    bad = np.flatnonzero(~((found.areas > 0) & (found.areas < np.inf)))
    if len(bad):
        where = f"{found.areas[bad[0]]} of triangle {bad[0]}"
        refuse(mesh, f"areas must be positive and finite, got {where}; change the unit")


def warn_mesh(text: str) -> None:
    """Issue a MeshWarning that points at the line outside this package which created the mesh."""
    level, frame = 1, sys._getframe()
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "transport":
        level, frame = level + 1, frame.f_back
    warnings.warn(f"Mesh: {text}", MeshWarning, stacklevel=level)


def warn_about_edges(edges: Edges) -> None:
    """Warn of non-manifold edges, neighbours of opposite orientation, and inverted meshes."""
    if edges.crowded:
        many = _pluralized(edges.crowded, "edge is", "edges are")
        where = f"the first by triangles {_joined(edges.crowded_example)}"
        warn_mesh(
            f"{many} shared by more than two triangles (non-manifold), {where};"
            " the mesh has no inside: split it there"
        )
    if edges.turned:
        many = _pluralized(edges.turned, "pair of neighbours has", "pairs of neighbours have")
        where = f"the first is triangles {_joined(edges.turned_example)}"
        warn_mesh(
            f"{many} opposite orientations, {where}; reverse the vertex order of one triangle of each pair"
        )


def warn_of_volume(volume: float, rounding: float, triangles: int) -> None:
    """Warn of a mesh without gaps that encloses nothing, or whose normals point inwards."""
    if volume < -rounding:
        got = f"volume {volume:.6g} m^3, {triangles} triangles"
        warn_mesh(f"it is closed, but its normals point inwards ({got}); write mesh.flipped()")
    else:
        got = f"volume {volume:.3g} m^3, rounding up to {rounding:.3g}"
        warn_mesh(f"its triangles enclose nothing ({got}); it has no inside: use a single layer of triangles")


def _refuse(mesh: object, problem: str) -> NoReturn:
    """Like `refuse`, also for class methods, where no mesh exists yet."""
    raise SceneError(f"Mesh: {problem}")


def _as_table(mesh: object, name: str, given: Any, must: str) -> np.ndarray:
    """Return the input as an array with three columns of numbers; raises SceneError otherwise."""
    if is_masked(given):
        masked = np.ma.count_masked(given)
        refuse(mesh, f"{name} must have all their values, got {masked} masked; {MASKED_VALUES_HINT}")
    try:
        table = np.asarray(given)
    except ValueError:  # rows of unequal lengths
        table = np.empty(1, dtype=object)
    if table.size == 0 and name == "faces" and (table.ndim == 1 or table.shape[1:] == (3,)):
        return np.empty((0, 3), dtype=np.int64)
    if table.ndim != 2 or table.shape[1] != 3 or table.dtype.kind not in "iuf":
        got = f"{table.dtype} of shape {table.shape}" if isinstance(given, np.ndarray) else short_repr(given)
        cure = "triangulate other polygons first" if name == "faces" else "one row of x, y, z per vertex"
        refuse(mesh, f"{name} must be {must}, got {got}; {cure}")
    return table


def _examples(bad: np.ndarray, faces: np.ndarray) -> str:
    """The first bad triangles, as text."""
    return "first " + ", ".join(f"triangle {t}: {short_repr(faces[t])}" for t in bad[:MAX_EXAMPLES])


def _pluralized(number: int, one: str, many: str) -> str:
    """A number with its noun in singular or plural."""
    return f"{number} {one if number == 1 else many}"


def _joined(triangles: tuple[int, ...]) -> str:
    """Numbers of triangles as text, such as "3, 4 and 7"."""
    *others, last = map(str, triangles[: MAX_EXAMPLES + 1])
    return f"{', '.join(others)} and {last}"
