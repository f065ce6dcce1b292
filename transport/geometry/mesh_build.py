"""Triangles from files and from pyvista.PolyData; pyvista is imported only when a file is read."""

from __future__ import annotations

import math
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np

from transport.geometry.mesh_topology import weld
from transport.validation import SceneError, pip_install, short_repr

SUFFIXES = (".stl", ".ply", ".obj", ".vtp")


def arrays_of_file(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles (m, 3) of an STL (ascii or binary), PLY, OBJ or VTP file, unchanged.

    Raises SceneError if the file is missing, empty or holds no triangles, or if pyvista is not installed.
    """
    file = _check_file(path)
    try:
        import pyvista
    except ImportError as error:
        raise SceneError(
            f"Mesh.from_file: reading {file.name!r} needs pyvista, got {error}; {pip_install('viz')}"
        ) from error
    # Collect VTK's error messages, which it does not raise.
    errors = pyvista.VtkErrorCatcher(send_to_logging=False)
    try:
        with errors:
            reader = pyvista.get_reader(str(file))
            if file.suffix.lower() == ".stl":
                reader.reader.MergingOff()  # merging would silently drop collapsed triangles
            polydata = reader.read()
    except Exception as error:
        raise _unreadable_error(file, errors.events[0].alert if errors.events else error) from error
    if errors.events:
        raise _unreadable_error(file, errors.events[0].alert)
    arrays = _triangles_of(polydata)
    if arrays is None:
        raise _unreadable_error(file, "no triangles")
    return arrays


def arrays_of_polydata(polydata: Any) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles (m, 3) of the polygons of a PolyData; lines and points are ignored."""
    kind = type(polydata).__name__
    if not all(hasattr(polydata, name) for name in ("triangulate", "points", "faces")):
        cure = "write Mesh.from_file(path) for a file, Mesh.from_pyvista(grid.extract_surface()) for a grid"
        raise SceneError(f"Mesh.from_pyvista: polydata must be a pyvista.PolyData, got {kind}; {cure}")
    arrays = _triangles_of(polydata)
    if arrays is None:
        cure = "write polydata.extract_surface()"
        raise SceneError(f"Mesh.from_pyvista: polydata must hold polygons, got none in {kind}; {cure}")
    return arrays


def _triangles_of(polydata: Any) -> tuple[np.ndarray, np.ndarray] | None:
    """Vertices and triangles; None if there are no polygons."""
    surface = polydata.triangulate()
    faces = np.asarray(surface.faces).reshape(-1, 4)  # each row: 3, then three vertex indices
    if len(faces) == 0:
        return None
    return np.asarray(surface.points, dtype=np.float64), np.asarray(faces[:, 1:], dtype=np.int64)


def _check_file(path: str | os.PathLike) -> Path:
    """The file at that path; raises SceneError if it is missing, empty, cut off or not a mesh format."""
    if not isinstance(path, str | os.PathLike):
        raise SceneError(
            f"Mesh.from_file: path must be a text or a Path, got {short_repr(path)}; write 'part.stl'"
        )
    file = Path(path).expanduser()
    if file.suffix.lower() not in SUFFIXES:
        kinds = ", ".join(SUFFIXES)
        raise SceneError(
            f"Mesh.from_file: path must end in one of {kinds}, got {str(path)!r}; save it as one of these"
        )
    if not file.is_file():
        what = "a folder" if file.is_dir() else "no such file"
        raise SceneError(
            f"Mesh.from_file: path must be a file, got {what} {str(path)!r}; look in {_nearest_folder(file)}"
        )
    if file.stat().st_size == 0:
        raise _unreadable_error(file, "an empty file, 0 bytes")
    found = truncation_reason(file)
    if found is not None:
        raise _unreadable_error(file, found)
    return file


def _nearest_folder(file: Path) -> str:
    """Quoted path of the nearest existing parent folder."""
    return repr(str(next(folder for folder in file.absolute().parents if folder.is_dir())))


def _unreadable_error(file: Path, found: object) -> SceneError:
    """SceneError for a file that cannot be read."""
    return SceneError(
        f"Mesh.from_file: {file.name!r} cannot be read as {file.suffix},"
        f" got {str(found).splitlines()[0]}; save it again"
    )


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


# ---- Triangulated solids: a sphere (subdivided icosahedron) and a box.

GOLDEN_RATIO = (1 + math.sqrt(5)) / 2
CORNERS = np.array(
    [(0, s, t * GOLDEN_RATIO) for s in (-1, 1) for t in (-1, 1)]
    + [(s, t * GOLDEN_RATIO, 0) for s in (-1, 1) for t in (-1, 1)]
    + [(t * GOLDEN_RATIO, 0, s) for s in (-1, 1) for t in (-1, 1)]
)


def sphere_arrays(center: tuple[float, ...], radius: float, triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices on a sphere [m] and at least `triangles` triangles, 20 f^2, of a subdivided icosahedron.

    Points of a shared edge are computed by identical sums on both sides, so that they merge exactly.
    """
    f = max(1, math.isqrt(max(triangles - 1, 0) // 20) + 1)
    a, b, c = (CORNERS[faces] for faces in _icosahedron().T)
    # Place points of the divided face at integer barycentric coordinates (i, j, f - i - j).
    i, j = (index.ravel() for index in np.meshgrid(range(f + 1), range(f + 1), indexing="ij"))
    i, j = i[i + j <= f], j[i + j <= f]
    points = (i[:, None] * a[:, None, :] + j[:, None] * b[:, None, :]) + (f - i - j)[:, None] * c[:, None, :]
    points = points.reshape(-1, 3)
    # Number the points of one face, and list its upright and inverted triangles.
    place = np.full((f + 2, f + 2), -1)
    place[i, j] = np.arange(len(i))
    upright = np.stack([place[i, j], place[i + 1, j], place[i, j + 1]], axis=1)[i + j < f]
    turned = np.stack([place[i, j], place[i - 1, j], place[i, j - 1]], axis=1)[(i > 0) & (j > 0)]
    one_side = np.concatenate([upright, turned])
    # Repeat for all 20 faces, merge shared points, and project them onto the sphere.
    faces = (one_side[None] + len(i) * np.arange(20)[:, None, None]).reshape(-1, 3)
    points, faces, *_ = weld(points, faces)
    return radius * (points / np.linalg.norm(points, axis=1)[:, None]) + center, faces


def box_arrays(low: tuple[float, ...], high: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Eight corners [m] of an axis-aligned box, and twelve triangles with outward normals."""
    ends = np.array([low, high])
    vertices = np.array([ends[(x, y, z), (0, 1, 2)] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, np.array([(p, q, r) for a, b, c, d in sides for p, q, r in ((a, b, c), (a, c, d))])


def _icosahedron() -> np.ndarray:
    """The 20 triples of adjacent corners, with outward normals."""
    # Adjacent corners, at edge length 2, have the scalar product phi.
    near = np.abs(CORNERS @ CORNERS.T - GOLDEN_RATIO) < 0.1
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(a)
        for c in range(b)
        if near[a, b] and near[b, c] and near[a, c]
    ]
    return np.array([(a, b, c) if np.linalg.det(CORNERS[[a, b, c]]) > 0 else (a, c, b) for a, b, c in faces])
