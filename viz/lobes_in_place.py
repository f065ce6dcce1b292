"""Radiance by direction where it was measured: a lobe that stands on the detector's shape, under a hemisphere of wire.

How far the lobe reaches in a direction, and its colour, say the radiance that comes from there (or leaves to there).
Directions are those of the detector: theta from the normal of its side, phi from e_u towards e_v; seen from behind, e_u
has the other sign, so that the frame stays right-handed (transport.compile.detectors).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.flat import FlatShape
from transport.geometry.revolved import Revolved
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.statistics.estimates import EstimateArray
from transport.vectors import Frame, local_frame, unit_vector
from transport.viz import night
from transport.viz.directions import DirectionBins, direction_bins
from transport.viz.facets import TURN, places_on, ranges_of
from transport.viz.painted import by_place
from transport.viz.solids import polylines
from transport.viz.style import unit_label

if TYPE_CHECKING:
    import pyvista

STEP = TURN / 72  # the finest step of an angle [rad]
OF_PICTURE = 0.13  # radius of a lobe, of the diagonal of what is drawn
RINGS = (30, 60, 90)  # degrees from the normal


def add_lobe(
    plotter: pyvista.Plotter,
    reading: object,
    quantity: str = "radiance",
    at: tuple[int, ...] = (),
    size: float | None = None,
    bar: bool = True,
) -> pyvista.PolyData:
    """Draw the lobe of a detector with `directions` into a picture; returns what was drawn.

    quantity: "radiance" or "radiance_out";  at: which bin of place, for a detector that has them;  size: how far the
    largest value reaches [m];  bar: whether to add a bar of colours, at the left.
    Raises ValueError for a detector that has no bins over one hemisphere, or on a shape without normals.
    """
    place, frame = place_and_frame(reading, at)
    bins = direction_bins(_one_place(getattr(reading, quantity), at))
    if size is None:
        low, high = np.reshape(plotter.bounds, (3, 2)).T
        size = OF_PICTURE * float(np.linalg.norm(high - low))
    drawn = lobe(bins, place, frame, size)
    scale = night.evenly(bins.value)
    actor = plotter.add_mesh(
        drawn,
        scalars="radiance",
        cmap=night.VALUES,
        clim=(0.0, scale.high if scale else 1.0),
        lighting=False,
        split_sharp_edges=False,
        opacity=0.92,
        show_scalar_bar=False,
    )
    wire = hemisphere(place, frame, size)
    plotter.add_mesh(wire, color=night.FAINT, opacity=0.45, line_width=1.0, lighting=False)
    if bar and scale:
        title = rf"$L\;[{unit_label(bins.unit).strip('$')}]$"
        night.add_bar(plotter, actor, title, scale, (0.035, 0.40), 0.4)
    return drawn


def lobe(bins: DirectionBins, place: np.ndarray, frame: Frame, size: float) -> pyvista.PolyData:
    """The surface at distance size times radiance over its maximum from `place`, in each direction; cell array "radiance".

    Corners are at the mean of the bins that meet there; what was not scored is at the place itself.
    """
    import pyvista

    value = np.nan_to_num(bins.value)
    highest = value.max()
    shares = value / highest if highest > 0 else value
    theta, of_theta = _fine(bins.theta)
    phi, of_phi = _fine(bins.phi)
    turns, rises = np.meshgrid(phi, theta)
    ways = _ways(rises, turns, frame)
    radius = size * _at_corners(shares[np.ix_(of_theta, of_phi)], bins.is_round or _is_whole(bins.phi))
    points = np.asarray(place) + radius[..., None] * ways
    count = len(phi)
    first = (np.arange(len(theta) - 1)[:, None] * count + np.arange(count - 1)).ravel()
    drawn = pyvista.PolyData.from_regular_faces(
        points.reshape(-1, 3), first[:, None] + np.array((0, count, count + 1, 1))
    )
    drawn.cell_data["radiance"] = value[np.ix_(of_theta, of_phi)].ravel()
    return drawn


def hemisphere(place: np.ndarray, frame: Frame, size: float) -> pyvista.PolyData:
    """Rings of polar angle and spokes of azimuth, lines [m]; the first spoke, along e_u, goes beyond the rim."""
    around = np.linspace(0, TURN, 97)
    rings = [_ways(np.full(97, math.radians(angle)), around, frame) for angle in RINGS]
    over = np.linspace(0, math.pi / 2, 25)
    spokes = [_ways(over, np.full(25, turn), frame) for turn in np.arange(8) * TURN / 8]
    spokes[0] = np.vstack([spokes[0], 1.15 * spokes[0][-1:]])
    return polylines([np.asarray(place) + size * line for line in rings + spokes])


def place_and_frame(reading: object, at: tuple[int, ...] = ()) -> tuple[np.ndarray, Frame]:
    """Where the detector's bin of place is [m], the middle of its shape without, and (e_u, e_v, n) of its side there."""
    detector, shape = reading.detector, reading.shape
    edges = {} if detector.positions is None else detector.positions.edges(shape)
    if len(at) != len(edges):
        raise ValueError(f"add_lobe: at must name one bin of each of {tuple(edges)}, got {at!r}")
    middles = {
        name: (along[k] + along[k + 1]) / 2 for k, (name, along) in zip(at, edges.items(), strict=True)
    }
    place, (e_u, e_v, n) = _local(shape, middles)
    if detector.is_back:
        e_u, n = (tuple(-x + 0.0 for x in axis) for axis in (e_u, n))
    return place, (e_u, e_v, n)


def _local(shape: Shape, middles: dict[str, float]) -> tuple[np.ndarray, Frame]:
    if isinstance(shape, FlatShape) and not middles:
        return np.array(shape.center), shape.frame
    if not isinstance(shape, FlatShape | Revolved):
        raise ValueError(f"add_lobe: a {type(shape).__name__} has no frame; meter one of its faces")
    ranges = ranges_of(shape)
    u = middles.get("u", sum(ranges["u"]) / 2)
    v = middles.get("v", 0.0 if isinstance(shape, Revolved) else sum(ranges["v"]) / 2)
    place = places_on(shape)(np.array([u]), np.array([v]))[0]
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


def _one_place(estimate: EstimateArray, at: tuple[int, ...]) -> EstimateArray:
    """Radiance by direction alone: of one bin of place, over all times and speeds."""
    estimate = by_place(estimate)
    return estimate[at] if at else estimate


def _ways(theta: np.ndarray, phi: np.ndarray, frame: Frame) -> np.ndarray:
    """Unit vectors of these angles [rad]."""
    e_u, e_v, n = (np.array(axis) for axis in frame)
    across = np.sin(theta)[..., None]
    return (
        across * (np.cos(phi)[..., None] * e_u + np.sin(phi)[..., None] * e_v) + np.cos(theta)[..., None] * n
    )


def _fine(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Finer edges that hold the given ones, and which bin each step is in."""
    counts = np.maximum(1, np.ceil(np.diff(edges) / STEP * (1 - 1e-9))).astype(int)
    parts = [
        np.linspace(low, high, n, endpoint=False)
        for low, high, n in zip(edges, edges[1:], counts, strict=False)
    ]
    return np.append(np.concatenate(parts), edges[-1]), np.repeat(np.arange(len(counts)), counts)


def _is_whole(phi: np.ndarray) -> bool:
    return math.isclose(phi[-1] - phi[0], TURN)


def _at_corners(cells: np.ndarray, is_whole: bool) -> np.ndarray:
    """Means of the cells that meet at each corner, (n + 1, m + 1); across the seam of a whole turn too."""
    wrapped = np.pad(cells, ((1, 1), (0, 0)), mode="edge")
    wrapped = np.pad(wrapped, ((0, 0), (1, 1)), mode="wrap" if is_whole else "edge")
    corners = (wrapped[:-1, :-1] + wrapped[1:, :-1] + wrapped[:-1, 1:] + wrapped[1:, 1:]) / 4
    if is_whole:
        corners[:, -1] = corners[:, 0]
    return corners
