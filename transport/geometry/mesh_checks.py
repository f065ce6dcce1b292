"""Checks of a mesh's arrays: errors quote the first examples, warnings give counts."""

from __future__ import annotations

import math
import struct
import sys
import warnings
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from transport.geometry.mesh_topology import Edges, Facets, repeated_triangles
from transport.validation import MASKED_VALUES_HINT, SceneError, as_float, is_masked, refuse, short_repr

MAX_HALF_DIAGONAL = 1e150  # half diagonal [m] whose square still fits a double
MAX_EXAMPLES = 3  # number of examples in a message


class MeshWarning(UserWarning):
    """Warning about a mesh that is usable, but whose edges or orientation are probably not intended."""


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


# ---- Detects truncated mesh files, on which VTK's readers return garbage or crash the process.
#
# Only lengths are compared, before anything is read: an STL file states its number of triangles or ends with
# a keyword; the header of a PLY file states how many bytes or lines follow.

STL_HEADER, STL_TRIANGLE = 84, 50  # bytes of a binary STL file's header and of each triangle
MAX_PLY_HEADER = 1 << 20  # bytes
PLY_TYPE_SIZES = {
    "char": 1, "uchar": 1, "int8": 1, "uint8": 1, "short": 2, "ushort": 2, "int16": 2, "uint16": 2,
    "int": 4, "uint": 4, "int32": 4, "uint32": 4, "float": 4, "float32": 4, "double": 8, "float64": 8,
}  # fmt: skip


def truncation_reason(file: Path) -> str | None:
    """Reason why a file is truncated or not of the type of its suffix; None if nothing is wrong."""
    match file.suffix.lower():
        case ".stl":
            return _stl_truncation(file)
        case ".ply":
            return _ply_truncation(file)
    return None


def _stl_truncation(file: Path) -> str | None:
    """Reason why an STL file is truncated: too short for its number of triangles, or without an end."""
    size = file.stat().st_size
    with file.open("rb") as stream:
        head = stream.read(STL_HEADER)
        stream.seek(max(0, size - 1024))
        tail = stream.read()
    if len(head) == STL_HEADER:
        (triangles,) = struct.unpack("<I", head[80:])
        if size >= STL_HEADER + STL_TRIANGLE * triangles:
            return None
    if not head.lstrip().lower().startswith(b"solid"):
        return "a truncated STL file, or none"
    return None if b"endsolid" in tail.lower() else "text that does not end with 'endsolid'"


def _ply_truncation(file: Path) -> str | None:
    """Reason why a PLY file is truncated: shorter than its header promises."""
    with file.open("rb") as stream:
        start = stream.read(MAX_PLY_HEADER)
        header, mark, _ = start.partition(b"end_header")
        if not start.startswith(b"ply") or not mark:
            return "no PLY header"
        try:
            is_text, lines, least = _ply_header_sizes(header.decode("latin1"))
        except (KeyError, ValueError, IndexError) as error:
            return f"an invalid header ({error})"
        if not is_text:
            there = file.stat().st_size - len(header) - len(mark) - 1
            return None if there >= least else f"{there} bytes where the header promises at least {least}"
        stream.seek(len(header) + len(mark))
        there = sum(1 for line in stream if line.strip())
        return None if there >= lines else f"{there} lines where the header promises {lines}"


def _ply_header_sizes(header: str) -> tuple[bool, int, int]:
    """Read from a header whether the data are text, the number of lines, and the least number of bytes."""
    is_text, lines, least, count = False, 0, 0, 0
    for words in filter(None, map(str.split, header.splitlines())):
        match words:
            case ["format", kind, *_]:
                is_text = kind == "ascii"
            case ["element", _, number]:
                count = int(number)
                lines += count
            case ["property", "list", length, item, name]:
                most = 3 if name.startswith("vertex_ind") else 0
                least += count * (PLY_TYPE_SIZES[length] + most * PLY_TYPE_SIZES[item])
            case ["property", kind, _]:
                least += count * PLY_TYPE_SIZES[kind]
    return is_text, lines, least
