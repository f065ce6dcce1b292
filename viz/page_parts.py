"""What VTK draws of an actor, as plain arrays: triangles, lines and points with a colour at each corner, and clouds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pyvista as pv
    from vtkmodules.vtkRenderingCore import vtkActor, vtkProp, vtkVolume

OPAQUE = 255
EDGES, POINTS = 1, 0  # representations of an actor, by VTK's numbers
CORNERS = {"triangles": 3, "lines": 2, "points": 1}
DEEPEST = 400.0  # optical depth along a box's diagonal that is told from more


def pieces_of(prop: vtkProp) -> Iterator[dict[str, object]]:
    """What is drawn of an actor or a volume, each with "kind", "points" (n, 3) and their colours "tints" (n, 4), 0 to 255.

    Also "opacity", whether it is "lit", a "round" dot or "clear" (seen through), the "size" of points [pixels], and which side
    is "hidden", "front" or "back".  A cloud is a box, with "dimensions" of a grid, its "cells" as bytes, and in a "table" the
    colour of each byte and the root of its depth as a share of "deepest".
    """
    from vtkmodules.vtkRenderingCore import vtkActor, vtkVolume

    if not prop.GetVisibility() or not isinstance(prop, vtkActor | vtkVolume) or prop.GetMapper() is None:
        return
    yield from (_of_actor if isinstance(prop, vtkActor) else _of_volume)(prop)


def _of_actor(actor: vtkActor) -> Iterator[dict[str, object]]:
    """An actor's triangles, lines and points."""
    import pyvista as pv

    actor.GetMapper().GetInputAlgorithm().Update()  # what was never drawn may not have been made yet
    look, data = actor.GetProperty(), pv.wrap(actor.GetMapper().GetInputDataObject(0, 0))
    if data is None or data.n_points == 0:
        return
    surface = data if isinstance(data, pv.PolyData) else data.extract_geometry()
    colours, of_cells = _colours(actor.GetMapper(), surface, look)
    common = {
        "opacity": look.GetOpacity(),
        "round": bool(look.GetRenderPointsAsSpheres()),
        "lit": bool(look.GetLighting()),
        "size": look.GetPointSize(),
        "hidden": "front" if look.GetFrontfaceCulling() else "back" if look.GetBackfaceCulling() else "",
    }
    for kind, corners, cells in _pieces(surface, look.GetRepresentation()):
        if len(corners):
            tints = np.repeat(colours[cells], CORNERS[kind], axis=0) if of_cells else colours[corners.ravel()]
            clear = bool(common["opacity"] < 1 or (tints[:, 3] < OPAQUE).any())
            yield common | {
                "kind": kind,
                "clear": clear,
                "points": np.asarray(surface.points, dtype=float)[corners.ravel()],
                "tints": np.ascontiguousarray(tints),
                "lit": common["lit"] and kind == "triangles",
            }


def _of_volume(volume: vtkVolume) -> Iterator[dict[str, object]]:
    """A volume on a regular grid: its box as triangles, its values as bytes, and the colour and depth of each byte."""
    import pyvista as pv

    volume.GetMapper().GetInputAlgorithm().Update()
    data = pv.wrap(volume.GetMapper().GetInputDataObject(0, 0))
    if not isinstance(data, pv.ImageData):
        return
    values, look = np.asarray(data.active_scalars, dtype=float), volume.GetProperty()
    low, high = float(values.min()), float(values.max())
    steps = np.linspace(low, high, OPAQUE + 1)
    opacity = np.array([look.GetScalarOpacity().GetValue(step) for step in steps])
    # Depth [1] of a path as long as the box's diagonal.
    depth = -np.log1p(-np.minimum(opacity, 0.999)) * data.length / look.GetScalarOpacityUnitDistance()
    colours = np.array([look.GetRGBTransferFunction().GetColor(step) for step in steps])
    share = np.sqrt(np.minimum(depth / DEEPEST, 1.0))
    box = pv.Box(data.bounds).triangulate()
    yield {
        "kind": "cloud",
        "clear": True,
        "opacity": 1.0,
        "points": box.points[box.regular_faces.ravel()].astype(float),
        "tints": np.zeros((3 * box.n_cells, 4), np.uint8),
        "dimensions": [*data.dimensions],
        "deepest": DEEPEST,
        "cells": np.round(OPAQUE * (values - low) / ((high - low) or 1.0)).astype(np.uint8),
        "table": np.round(OPAQUE * np.column_stack([colours, share])).astype(np.uint8),
    }


def _pieces(surface: pv.PolyData, representation: int) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Kind, the points (n, 1 to 3) of each piece, and which cell (n,) of the surface each is of."""
    cells = np.arange(surface.n_cells)
    kinds = surface.GetVerts(), surface.GetLines(), surface.GetPolys(), surface.GetStrips()
    ends = np.cumsum([kind.GetNumberOfCells() for kind in kinds])
    points, lines, faces, strips = np.split(cells, ends[:-1])
    yield "points", *_chained(surface.GetVerts(), points, 1)
    yield "lines", *_chained(surface.GetLines(), lines, 2)
    if representation == EDGES:
        yield "lines", *_chained(surface.GetPolys(), faces, 2, closed=True)
    elif representation == POINTS:
        yield "points", *_chained(surface.GetPolys(), faces, 1)
    else:
        yield "triangles", *_fanned(surface.GetPolys(), faces)
        yield "triangles", *_chained(surface.GetStrips(), strips, 3)


def _chained(cells, numbers: np.ndarray, width: int, closed: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Each run of `width` neighbours along a cell; closed: its end and its beginning are neighbours, too."""
    ends, points = _arrays(cells)
    lengths = np.diff(ends)
    start = np.repeat(ends[:-1], lengths)
    place = np.arange(len(points)) - start
    last = np.repeat(lengths, lengths)
    kept = (place + width <= last) | closed
    ways = [start + (place + step) % last for step in range(width)]
    corners = (
        np.stack([points[way] for way in ways], axis=1)[kept] if len(points) else np.empty((0, width), int)
    )
    return corners, np.repeat(numbers, lengths)[kept]


def _fanned(cells, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles from the first corner of each convex face."""
    ends, points = _arrays(cells)
    lengths = np.maximum(np.diff(ends) - 2, 0)
    first = np.repeat(ends[:-1], lengths)
    place = np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    corners = np.stack([points[first], points[first + place + 1], points[first + place + 2]], axis=1)
    return corners, np.repeat(numbers, lengths)


def _arrays(cells) -> tuple[np.ndarray, np.ndarray]:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(cells.GetOffsetsArray()).astype(int), vtk_to_numpy(
        cells.GetConnectivityArray()
    ).astype(int)


def _colours(mapper, surface: pv.PolyData, look) -> tuple[np.ndarray, bool]:
    """The colours (n, 4) that VTK gives to points or cells, and whether to cells."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    smooth = mapper.GetInterpolateScalarsBeforeMapping()
    mapper.SetInterpolateScalarsBeforeMapping(False)  # else it gives places in a texture
    mapped = mapper.MapScalars(surface, 1.0) if mapper.GetScalarVisibility() else None
    mapper.SetInterpolateScalarsBeforeMapping(smooth)
    if mapped is None:
        rgb = [round(OPAQUE * share) for share in look.GetColor()]
        return np.tile(np.array([*rgb, OPAQUE], np.uint8), (surface.n_points, 1)), False
    found = vtk_to_numpy(mapped)
    if found.shape[1] == 3:
        found = np.column_stack([found, np.full(len(found), OPAQUE, np.uint8)])
    return found, "Cell" in mapper.GetScalarModeAsString()
