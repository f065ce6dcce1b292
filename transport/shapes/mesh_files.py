"""Triangles from files and from pyvista.PolyData; pyvista is imported only when a file is read."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from transport.shapes.mesh_intact import why_not_whole
from transport.validation import SceneError, shown

SUFFIXES = (".stl", ".ply", ".obj", ".vtp")


def arrays_of_file(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles (m, 3) of an STL (ascii or binary), PLY, OBJ or VTP file, unchanged.

    Raises SceneError if the file is missing, empty or holds no triangles, or if pyvista is not installed.
    """
    file = _existing(path)
    try:
        import pyvista
    except ImportError as error:
        raise SceneError(
            f"Mesh.from_file: reading {file.name!r} needs pyvista, got {error};"
            " pip install '.[viz]' in the clone"
        ) from error
    # Collect VTK's error messages, which it does not raise.
    heard = pyvista.VtkErrorCatcher(send_to_logging=False)
    try:
        with heard:
            reader = pyvista.get_reader(str(file))
            if file.suffix.lower() == ".stl":
                reader.reader.MergingOff()  # merging would silently drop collapsed triangles
            polydata = reader.read()
    except Exception as error:
        raise _unreadable(file, heard.events[0].alert if heard.events else error) from error
    if heard.events:
        raise _unreadable(file, heard.events[0].alert)
    arrays = _triangles_of(polydata)
    if arrays is None:
        raise _unreadable(file, "no triangles")
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


def _existing(path: str | os.PathLike) -> Path:
    """The file at that path; raises SceneError if it is missing, empty, cut off or not a mesh format."""
    if not isinstance(path, str | os.PathLike):
        raise SceneError(
            f"Mesh.from_file: path must be a text or a Path, got {shown(path)}; write 'part.stl'"
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
            f"Mesh.from_file: path must be a file, got {what} {str(path)!r}; look in {_near(file)}"
        )
    if file.stat().st_size == 0:
        raise _unreadable(file, "an empty file, 0 bytes")
    found = why_not_whole(file)
    if found is not None:
        raise _unreadable(file, found)
    return file


def _near(file: Path) -> str:
    """Quoted path of the nearest existing parent folder."""
    return repr(str(next(folder for folder in file.absolute().parents if folder.is_dir())))


def _unreadable(file: Path, found: object) -> SceneError:
    """SceneError for a file that cannot be read."""
    return SceneError(
        f"Mesh.from_file: {file.name!r} cannot be read as {file.suffix},"
        f" got {str(found).splitlines()[0]}; save it again"
    )
