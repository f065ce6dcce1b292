"""A mesh: triangles that share vertices, checked once; arrays that never change."""

from __future__ import annotations

import functools
import hashlib
import math
import warnings
from collections.abc import Iterable
from dataclasses import field
from os import PathLike
from typing import Any

import numpy as np

from transport.fields import ArrayField
from transport.shapes.base import Shape
from transport.shapes.mesh_checks import (
    MeshWarning,
    check_facets,
    check_size,
    settled_faces,
    settled_factor,
    settled_tolerance,
    settled_vertices,
    warn,
    warn_of_edges,
    warn_of_volume,
)
from transport.shapes.mesh_files import arrays_of_file, arrays_of_polydata
from transport.shapes.mesh_geometry import facets, signed_volume, winding_number
from transport.shapes.mesh_solids import box_arrays, sphere_arrays
from transport.shapes.mesh_topology import Edges, edges_of, without_unused
from transport.shapes.mesh_weld import weld
from transport.shapes.solid import Box, Sphere
from transport.validation import SceneError, as_float, as_floats, refuse, scene_object, shown, store
from transport.vectors import Frame, Vector, local_frame

MOST_TRIANGLES = 20_000_000  # of a sphere: some 2 GB
HELD = 1 - 2.0**-10  # winding number from which a point is inside; on the surface it is less

__all__ = ["Mesh", "MeshWarning"]


@scene_object(kw_only=True)
class Mesh(Shape):
    """Triangles `faces` (m, 3), each three numbers of `vertices` (n, 3) [m], counted from 0.

    A triangle's normal is that of a right hand whose fingers follow its vertices: outwards on a closed mesh.
    The arrays are copied, kept read-only, and stripped of vertices that no triangle names; `normals` (m, 3) and
    `areas` (m,) [m^2] are exact to rounding for slivers too, `edges` says how the triangles hang together.
    Raises SceneError for arrays that are no triangles, for triangles without an area and for repeated ones; gives
    a MeshWarning for edges of more than two triangles, neighbours of opposite orientation, and inverted meshes.
    """

    vertices: ArrayField = field(compare=False)
    faces: ArrayField = field(compare=False)
    normals: np.ndarray = field(init=False, compare=False)
    areas: np.ndarray = field(init=False, compare=False)
    edges: Edges = field(init=False, compare=False)
    digest: bytes = field(init=False)  # of the arrays' bytes: what equality and hash go by

    def __post_init__(self) -> None:
        vertices = settled_vertices(self, self.vertices)
        faces = settled_faces(self, self.faces, len(vertices))
        check_size(self, vertices)
        found = facets(vertices, faces)
        check_facets(self, vertices, faces, found)
        vertices, faces = without_unused(vertices, faces)
        arrays = {"vertices": vertices, "faces": faces, "normals": found.normals, "areas": found.areas}
        store(self, **arrays, edges=edges_of(faces), digest=_digest(vertices, faces))
        self._freeze()
        warn_of_edges(self.edges)
        if self.edges.are_paired and not self.is_closed:
            warn_of_volume(self.volume, self.volume_rounding, self.triangles)

    @classmethod
    def from_file(cls, path: str | PathLike, scale: float = 1.0, tolerance: float = 0.0) -> Mesh:
        """The triangles of an STL, PLY, OBJ or VTP file whose unit of length is `scale` metres; needs pyvista.

        Vertices with equal coordinates are welded, or all within `tolerance` [m] of one another; triangles that
        collapse are left out with a MeshWarning.  Raises SceneError for what cannot be read.
        """
        return cls._welded(*arrays_of_file(path), scale, tolerance)

    @classmethod
    def from_pyvista(cls, polydata: Any, scale: float = 1.0, tolerance: float = 0.0) -> Mesh:
        """The polygons of a pyvista.PolyData as triangles, welded; `scale` and `tolerance` as in `from_file`."""
        return cls._welded(*arrays_of_polydata(polydata), scale, tolerance)

    @classmethod
    def sphere(
        cls, *, center: Iterable[float] = (0.0, 0.0, 0.0), radius: float, triangles: int = 1280
    ) -> Mesh:
        """A closed mesh of at least so many triangles, 20 f^2, whose vertices lie on a sphere of `radius` [m]."""
        shape = Sphere(center=center, radius=radius)
        number = as_float(triangles)
        if number is None or number != int(number) or not 1 <= number <= MOST_TRIANGLES:
            must = f"triangles must be a whole number from 1 to {MOST_TRIANGLES}"
            raise SceneError(f"Mesh.sphere: {must}, got {shown(triangles)}; write triangles=1280")
        vertices, faces = sphere_arrays(shape.center, shape.radius, int(number))
        return cls(vertices=vertices, faces=faces)

    @classmethod
    def box(cls, *, center: Iterable[float] = (0.0, 0.0, 0.0), size: Iterable[float] | float) -> Mesh:
        """The twelve triangles of a box along the axes, `size` its three lengths [m] or one for a cube."""
        vertices, faces = box_arrays(*Box(center=center, size=size).bounds)
        return cls(vertices=vertices, faces=faces)

    @property
    def triangles(self) -> int:
        """How many triangles there are."""
        return len(self.faces)

    @functools.cached_property
    def area(self) -> float:
        """Area of one side of all triangles [m^2], exact to rounding."""
        return math.fsum(self.areas)

    @functools.cached_property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest box along the axes that holds the mesh."""
        return tuple(
            tuple(corner.tolist()) for corner in (self.vertices.min(axis=0), self.vertices.max(axis=0))
        )

    @property
    def middle(self) -> Vector:
        """Middle of its bounds [m]."""
        low, high = self.bounds
        return tuple(p / 2 + q / 2 for p, q in zip(low, high, strict=True))

    @functools.cached_property
    def extent(self) -> float:
        """Distance of the vertex that is farthest from the middle [m]."""
        way = np.abs(self.vertices - self.middle)
        return float(np.hypot(np.hypot(way[:, 0], way[:, 1]), way[:, 2]).max())

    @property
    def frame(self) -> Frame:
        """Unit vectors (e_u, e_v, axis) of its coordinates, axis = +z."""
        return local_frame((0.0, 0.0, 1.0), None)

    @property
    def open_edges(self) -> int:
        """How many edges have a triangle on one side only."""
        return self.edges.open

    @functools.cached_property
    def is_closed(self) -> bool:
        """Whether every edge joins two triangles that run it in opposite directions, with the normals outwards."""
        return self.edges.are_paired and self.volume > self.volume_rounding

    @property
    def volume(self) -> float:
        """Volume [m^3] inside; negative where the normals point inwards.  Raises SceneError for an open mesh."""
        return self._volume[0]

    @property
    def volume_rounding(self) -> float:
        """A bound [m^3] on the rounding of the volume."""
        return self._volume[1]

    def holds(self, point: Iterable[float]) -> bool:
        """Whether a point [m] lies inside a closed mesh; of what lies in a facet, it does not."""
        position = as_floats(point)
        if position is None or len(position) != 3:
            refuse(self, f"point must be three finite numbers, got {shown(point)}")
        self._refuse_open("an inside")
        return abs(winding_number(self.vertices, self.faces, np.array(position))) > HELD

    def flipped(self) -> Mesh:
        """The mesh with all normals turned round."""
        return self._changed(self.vertices, self.faces[:, ::-1])

    def moved(self, by: Iterable[float]) -> Mesh:
        """The mesh moved by three lengths [m]."""
        way = as_floats(by)
        if way is None or len(way) != 3:
            refuse(self, f"by must be three finite lengths, got {shown(by)}")
        return self._changed(self.vertices + way, self.faces)

    def scaled(self, by: float) -> Mesh:
        """The mesh enlarged about the origin by a positive factor, as from millimetres: `scaled(tp.mm)`."""
        return self._changed(self.vertices * settled_factor(self, "by", by), self.faces)

    def merged(self, tolerance: float = 0.0) -> Mesh:
        """The mesh with vertices in one place made one: of equal coordinates, or within `tolerance` [m]."""
        return self._welded(self.vertices, self.faces, 1.0, tolerance)

    def __repr__(self) -> str:
        kind = "closed"
        if not self.is_closed:
            counts = {"open": self.edges.open, "crowded": self.edges.crowded, "turned": self.edges.turned}
            found = [f"{n} {name} edge{'s' if n > 1 else ''}" for name, n in counts.items() if n]
            kind = ", ".join(found) or "inverted"
        return f"Mesh({self.triangles} triangle{'s' if self.triangles > 1 else ''}, {kind})"

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._freeze()

    @functools.cached_property
    def _volume(self) -> tuple[float, float]:
        self._refuse_open("a volume")
        return signed_volume(self.vertices, self.faces, self.normals, self.areas)

    def _refuse_open(self, what: str) -> None:
        if not self.edges.are_paired:
            cure = "close the holes and turn the triangles alike"
            refuse(self, f"{what} needs a closed mesh, got {self!r}; {cure}")

    def _freeze(self) -> None:
        for array in (self.vertices, self.faces, self.normals, self.areas):
            array.flags.writeable = False

    @classmethod
    def _welded(cls, vertices: np.ndarray, faces: np.ndarray, scale: float, tolerance: float) -> Mesh:
        scale = settled_factor(cls, "scale", scale)
        tolerance = settled_tolerance(cls, tolerance)
        found = weld(vertices * scale, faces, tolerance)
        if found.collapsed:
            many = "1 triangle" if found.collapsed == 1 else f"{found.collapsed} triangles"
            warn(
                f"{many} of {len(faces)} left out, with two vertices in one place; mend the file if they matter"
            )
        return cls(vertices=found.vertices, faces=found.faces)

    def _changed(self, vertices: np.ndarray, faces: np.ndarray) -> Mesh:
        """A mesh of other arrays, whose edges were warned of before."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MeshWarning)
            return Mesh(vertices=vertices, faces=faces)


def _digest(*arrays: np.ndarray) -> bytes:
    code = hashlib.blake2b(digest_size=16)
    for array in arrays:
        code.update(repr(array.shape).encode())
        code.update(array)
    return code.digest()
