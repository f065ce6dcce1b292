"""Radiance by direction where it was measured: a lobe on the detector's shape, under a hemisphere of wire.

The distance to the lobe in a direction, and its colour, are the radiance from there (or towards there). Directions are
those of the detector: theta from the normal of its side, phi from e_u towards e_v; on the back, e_u has the other sign,
so that the frame stays right-handed.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.flat import FlatShape
from transport.geometry.revolved import Revolved
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.vectors import Frame, local_frame, unit_vector
from transport.viz import scene_style as style
from transport.viz.directions import DirectionBins, direction_bins
from transport.viz.facets import TURN, as_polydata, grid_facets, places_on, polyline, refined
from transport.viz.scene_parts import by_place
from transport.viz.style import unit_label

if TYPE_CHECKING:
    import pyvista

STEP = TURN / 72  # [rad] largest step of an angle
LOBE_SHARE = 0.13  # radius of a lobe, of the diagonal of what is drawn
RINGS = (30, 60, 90)  # [degrees] from the normal


def add_lobe(
    plotter: pyvista.Plotter,
    reading: object,
    quantity: str = "radiance",
    at: tuple[int, ...] = (),
    size: float | None = None,
    bar: bool = True,
) -> pyvista.PolyData:
    """Draw the lobe of a detector with `directions` into a picture.

    Parameters
    ----------
    plotter : pyvista.Plotter
        As `draw_scene` returns it.
    reading : Reading
        With bins over one hemisphere.
    quantity : {"radiance", "radiance_out"}
        From there, or towards there.
    at : ints
        Bin of place of a detector with `positions`.
    size : float, optional
        Distance at which the largest value is drawn [m].
    bar : bool, default True
        Whether to add a colour bar at the left.

    Returns
    -------
    pyvista.PolyData
        The lobe.

    Raises
    ------
    ValueError
        If the detector has no bins over one hemisphere, or a shape without normals.
    """
    place, frame = place_and_frame(reading, at)
    radiance = by_place(getattr(reading, quantity))
    bins = direction_bins(radiance[at] if at else radiance)
    if size is None:
        size = LOBE_SHARE * float(np.linalg.norm(np.diff(np.reshape(plotter.bounds, (3, 2)))))
    drawn = lobe(bins, place, frame, size)
    scale = style.linear(bins.value) or style.Scale(0.0, 1.0, (), False)
    actor = style.add_coloured(
        plotter, drawn, drawn.cell_data["radiance"], scale, style.ON_SURFACES, opacity=0.92
    )
    wire = hemisphere(place, frame, size)
    plotter.add_mesh(wire, color=style.FAINT, opacity=0.45, line_width=1.0, lighting=False)
    if bar and scale.marks:
        title = rf"$L\;[{unit_label(bins.unit).strip('$')}]$"
        style.add_bar(plotter, actor, title, scale, (0.035, 0.40), 0.4)
    return drawn


def lobe(bins: DirectionBins, place: np.ndarray, frame: Frame, size: float) -> pyvista.PolyData:
    """Return the surface at distance size times radiance over its maximum from `place`; cell array "radiance".

    Corners are at the mean of the bins that meet there; bins without score are at the place itself.
    """
    value = np.nan_to_num(bins.value)
    theta, of_theta = refined(bins.theta, STEP)
    phi, of_phi = refined(bins.phi, STEP)
    cells = value[np.ix_(of_theta, of_phi)]
    is_whole_turn = math.isclose(bins.phi[-1] - bins.phi[0], TURN)
    radius = size * corner_means(cells / (value.max() or 1.0), is_whole_turn)
    points = np.asarray(place) + radius[..., None] * _directions(theta[:, None], phi, frame)
    drawn = as_polydata(grid_facets(points, cells))
    drawn.cell_data["radiance"] = cells.ravel()
    return drawn


def hemisphere(place: np.ndarray, frame: Frame, size: float) -> pyvista.PolyData:
    """Return rings of polar angle and spokes of azimuth, lines [m]; the spoke along e_u goes beyond the rim."""
    around, over = np.linspace(0, TURN, 97), np.linspace(0, math.pi / 2, 25)
    lines = [_directions(math.radians(angle), around, frame) for angle in RINGS]
    lines += [_directions(over, turn, frame) for turn in np.arange(8) * TURN / 8]
    lines.append(np.array([1.0, 1.15])[:, None] * np.array(frame[0]))
    first, *others = (polyline(np.asarray(place) + size * line) for line in lines)
    return first.append_polydata(*others)


def place_and_frame(reading: object, at: tuple[int, ...] = ()) -> tuple[np.ndarray, Frame]:
    """Return the detector's bin of place [m], or the middle of its shape, and (e_u, e_v, n) of its side there."""
    detector, shape = reading.detector, reading.shape
    edges = {} if detector.positions is None else detector.positions.edges(shape)
    if len(at) != len(edges):
        raise ValueError(f"add_lobe: at must name one bin of each of {tuple(edges)}, got {at!r}")
    middles = {name: along[k : k + 2].mean() for k, (name, along) in zip(at, edges.items(), strict=True)}
    place, (e_u, e_v, n) = _local(shape, middles)
    if detector.is_back:
        e_u, n = (tuple(-x + 0.0 for x in axis) for axis in (e_u, n))
    return place, (e_u, e_v, n)


def _local(shape: Shape, middles: dict[str, float]) -> tuple[np.ndarray, Frame]:
    """Place and frame at the middle of a bin."""
    if isinstance(shape, FlatShape) and not middles:
        return np.array(shape.center), shape.frame
    if not isinstance(shape, FlatShape | Revolved):
        raise ValueError(
            f"add_lobe: a {type(shape).__name__} has no frame; put the detector on one of its faces"
        )
    whole = {name: sum(limits[:2]) / 2 for name, limits in shape.coordinates().items()}
    if isinstance(shape, Revolved):
        whole["v"] = 0.0
    u, v = (whole | middles).values()
    place = places_on(shape, u, v)
    if isinstance(shape, FlatShape):
        return place, shape.frame
    e_u, e_v, axis = (np.array(vector) for vector in shape.frame)
    outwards = math.cos(v) * e_u + math.sin(v) * e_v
    if isinstance(shape, Sphere):
        normal = math.sin(u) * outwards + math.cos(u) * axis
    else:
        profile, height = shape.profile, u - shape.profile.lift
        normal = profile.radius_at(height) * outwards - (profile.beta / 2 + profile.gamma * height) * axis
    return place, local_frame(unit_vector(tuple(normal.tolist())), shape.axis)


def _directions(theta: np.ndarray, phi: np.ndarray, frame: Frame) -> np.ndarray:
    """Unit vectors (..., 3) at angles [rad]."""
    e_u, e_v, n = (np.array(axis) for axis in frame)
    theta, phi = (each[..., None] for each in np.broadcast_arrays(theta, phi))
    return np.sin(theta) * (np.cos(phi) * e_u + np.sin(phi) * e_v) + np.cos(theta) * n


def corner_means(cells: np.ndarray, is_whole_turn: bool) -> np.ndarray:
    """Return means of the cells that meet at each corner, (n + 1, m + 1), also across the seam of a whole turn."""
    wrapped = np.pad(cells, ((1, 1), (0, 0)), mode="edge")
    wrapped = np.pad(wrapped, ((0, 0), (1, 1)), mode="wrap" if is_whole_turn else "edge")
    return (wrapped[:-1, :-1] + wrapped[1:, :-1] + wrapped[:-1, 1:] + wrapped[1:, 1:]) / 4
