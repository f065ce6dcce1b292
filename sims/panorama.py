"""One room in six projections: a map of all directions is the same light, however it is laid flat.

Derivation.  "Environment maps = radiance at a point", L(θ, φ), shown on a cylinder, on a cube, by a fisheye or in a
mirrored ball (Hanrahan 2001, Stanford CS 348B, lecture 4; Miller and Hoffman 1984).  Whatever the projection, the fluence
rate at the point and the irradiance on any plane there are sums over its pixels,

    φ = ∫L dω = Σ L_i Ω_i,      E = ∫L max(cosθ, 0) dω = Σ L_i P_i,

with the solid angle Ω_i and the projected solid angle P_i of a pixel.  The walls of the room are black and shine, each
with one radiance, and so do window, lamps, tiles and a letter a little before them.  Then φ and E are closed forms: of a
polygon Van Oosterom and Strackee 1983, and Lambert 1760 on a plane that may cut it (theory/solid_angles.py), of the lamp that
is a ball the cone that it fills (geometry/solid_angles.py).  What hides a part of a wall counts by the difference of
both radiances.

A mirrored ball.  At the distance r' from the middle of its image, over its radius, the normal is tilted by asin r', and
light comes from twice that angle: r = 2 sin(θ/2) is Lambert's equal-area projection about the direction to the eye.  To
prove it, a real mirror of 0.1 mm hangs in the place of the map, and a camera takes its picture from 2.2 m away.  Past
its rim the camera sees the wall behind, of radiance L_w, so that with pixels of the area a in an image of radius 2
φ = 4π L_w + Σ(L_i - L_w) a, and E likewise.  The ball's radius shifts the room by less than one part in 10 000.

Bins.  In a pixel that an edge divides, Σ L_i P_i takes the mean cosine of the pixel for that of its bright part; φ has
no such error.  It falls with the square of the pixels' size.  Here it is below 0.04 % of E, yet up to a standard
error.  So the exact value of E is that of the map's own pixels: the closed form, and the covariance of radiance and
cosine within the pixels with an edge, which is integrated from the geometry of the room alone.

Conversions.  `resampled` turns each map into the next of the list: φ stays to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import transport as tp
from transport.geometry.solid_angles import cone_projected_solid_angle
from transport.scene.cameras import BALL, CUBE, CYLINDER, EQUAL_AREA, FISHEYE, LATITUDE_LONGITUDE, PROJECTIONS
from transport.scene.projections import image_radius
from transport.sims import constant, figures, furthest, main, of_scene, one_of, require, sharp, where
from transport.theory.solid_angles import (
    cap_solid_angle,
    polygon_projected_solid_angle,
    polygon_solid_angle,
)
from transport.verification.experiment import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from transport.results.backward import ViewReading

law = "φ = Σ L Ω and E = Σ L P of all pixels, in each projection (Hanrahan 2001; Miller and Hoffman 1984)"
question = "Does an environment map hold the same light in every projection?"
particles = 3_000_000
intended = {
    "bins": "single pixels of the maps are grainy; the rows are sums over all",
}

GOLDEN = (1 + math.sqrt(5)) / 2
PHOTO = "photograph of a ball"
SHOWN = (*PROJECTIONS, PHOTO)
FORMULAS = {
    LATITUDE_LONGITUDE: "φ to the left, θ down", CYLINDER: "φ to the left, z = cos θ up", CUBE: "r = tan θ on each face",
    FISHEYE: "r = θ about +z", EQUAL_AREA: "r = 2 sin(θ/2) about +z", BALL: "r = 2 sin(θ/2) about −y",
}  # fmt: skip
PLACE = (0.3, -0.2, 1.2)  # of the maps [m]
LOW, HIGH = np.array((-2.0, -2.5, 0.0)), np.array((2.0, 2.5, 2.5))  # corners of the room [m]
WALLS = {"floor": 3.0, "ceiling": 16.0, "+x": 7.0, "-x": 10.0, "+y": 13.0, "-y": 9.0}  # W m^-2 sr^-1
BEFORE = 5e-3  # m, of what is before a wall
GLOBE = tp.Sphere(center=(-1.1, -1.2, 1.6), radius=0.2)  # a lamp before the wall -x
GLOBE_RADIANCE = 80.0
MIRROR = tp.Sphere(center=PLACE, radius=1e-4)
DISTANCE = 2.2  # m, of the camera from it
PLANES = {"upward": (0.0, 0.0, 1.0), "to the window": (1.0, 0.0, 0.0), "aslant": (-1.0, 2.0, -1.0)}
FLUENCE, IRRADIANCE, HALF = "fluence rate φ", "irradiance E {}", "E upward, by a fisheye of 180°"
CONVERTED = "φ as {} / φ"
WHITE = 40.0  # radiance [W m^-2 sr^-1] that is drawn white
HALF_PIXELS = 64
COARSE, FINE = (  # places in a bin, off all lines of symmetry
    tuple(((k + 0.5) / n, (0.5 + k / GOLDEN) % 1.0) for k in range(n)) for n in (16, 144)
)


class Panel(NamedTuple):
    """A rectangle that shines: corners counterclockwise as the room sees them, its radiance and that behind."""

    name: str
    corners: np.ndarray
    radiance: float
    behind: float


def cases() -> list[dict[str, str]]:
    return [{"projection": projection} for projection in SHOWN]


def scene(projection: str = LATITUDE_LONGITUDE, pixels: int = 128) -> tp.Scene:
    """projection: of the map, or "photograph of a ball";  pixels: along a side of its image, as many bins otherwise."""
    one_of("panorama", projection=(projection, SHOWN))
    is_allowed = isinstance(pixels, int) and 8 <= pixels <= 512
    require("panorama", pixels=(pixels, is_allowed, "a whole number from 8 to 512"))
    meshes, radiances = _meshes()
    surfaces = [tp.Surface(mesh, tp.Black(), name) for name, mesh in meshes.items()]
    sources = [tp.Source(name, tp.Lambertian(radiance=radiances[name])) for name in meshes]
    surfaces.append(tp.Surface(GLOBE, tp.Black(), "globe"))
    sources.append(tp.Source("globe", tp.Lambertian(radiance=GLOBE_RADIANCE)))
    if projection == PHOTO:
        surfaces.append(tp.Surface(MIRROR, tp.Mirror(), "ball"))
        return tp.Scene(sources, surfaces, _photographer(pixels))
    detectors = [environment_map(projection, pixels)]
    if projection == FISHEYE:
        view = {"position": PLACE, "direction": (0, 0, 1), "up": (0, 1, 0), "lens": FISHEYE}
        detectors.append(tp.Camera(name="half", pixels=(HALF_PIXELS, HALF_PIXELS), **view))
    return tp.Scene(sources, surfaces, detectors)


def environment_map(projection: str, pixels: int) -> tp.EnvironmentMap:
    """The map of the room in a projection, with about as many bins in each."""
    if projection in (LATITUDE_LONGITUDE, CYLINDER):
        rows = max(2, round(pixels / math.sqrt(2)))
        return tp.EnvironmentMap(name="map", position=PLACE, projection=projection, theta=rows, phi=2 * rows)
    side = max(2, round(pixels / math.sqrt(6))) if projection == CUBE else pixels
    return tp.EnvironmentMap(name="map", position=PLACE, projection=projection, pixels=side)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    if "photo" in result:
        return _of_photograph(result)
    seen = result["map"]
    view, found = seen.detector, {FLUENCE: seen.fluence_rate}
    for name, normal in PLANES.items():
        found[IRRADIANCE.format(name)] = _sum(result, seen.radiance, view.projected_solid_angles(normal))
    other = _next(view)
    converted = view.resampled(seen.radiance, other)
    ratio = _sum(result, converted, other.solid_angles()) / seen.fluence_rate
    found[CONVERTED.format(other.projection)] = sharp(ratio, of=ratio)
    if "half" in result:
        found[HALF] = _sum(result, result["half"].radiance, _above(result["half"].detector))
    return found


@of_scene(scene)
def exact(projection: str, pixels: int) -> dict[str, float]:
    seen_as = BALL if projection == PHOTO else projection
    found = {FLUENCE: fluence_rate()} | {
        IRRADIANCE.format(name): irradiance(normal) + binning(seen_as, pixels, normal)
        for name, normal in PLANES.items()
    }
    if projection == PHOTO:
        return found
    found[CONVERTED.format(following(projection))] = 1.0
    return found | ({HALF: irradiance(PLANES["upward"])} if projection == FISHEYE else {})


def verdict(outcomes: list[Outcome]) -> str:
    return f"It does, and so does the photograph of a real mirror ball: {furthest(outcomes)}."


def draw_room(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The maps in grey on one scale, each with its projection, its formula and its fluence rate."""
    from transport.viz.style import figure

    columns = min(3, len(outcomes))
    rows = math.ceil(len(outcomes) / columns)
    title = "One room, the same light in every projection" if len(outcomes) > 1 else None
    exact_value = f"φ is {outcomes[0][FLUENCE].exact:.2f} W m⁻² (exact)"
    with figure((6.8 * columns + 0.4, 6.4 * rows + 1.2), title, f"{exact_value}; {note}", path) as page:
        for axes, outcome in zip(
            np.ravel(page.subplots(rows, columns, squeeze=False)), outcomes, strict=False
        ):
            projection = outcome.given["projection"]
            _draw_grey(axes, outcome.result["map"])
            axes.set_title(f"{projection}\n{FORMULAS[projection]}")
            below = f"φ = {outcome[FLUENCE].estimate!s}".replace(" W m^-2", " W m⁻²")
            axes.text(0.5, -0.04, below, ha="center", va="top", transform=axes.transAxes)
        for axes in page.axes[len(outcomes) :]:
            axes.set_axis_off()


def draw_ball(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The projection beside the photograph of a real mirror ball."""
    from transport.viz.style import figure

    seen = {"map, r = 2 sin(θ/2)": "map", "photograph of a mirror ball of 0.1 mm": "photo"}
    drawn = [(words, o) for words, name in seen.items() for o in outcomes if name in o.result]
    title = "A mirrored ball is an equal-area map of all directions" if len(drawn) > 1 else None
    with figure((9.0 * len(drawn), 10.2), title, note, path) as page:
        for axes, (words, outcome) in zip(page.subplots(1, len(drawn), squeeze=False)[0], drawn, strict=True):
            _draw_grey(axes, outcome.result[seen[words]])
            axes.set_title(words)
            below = f"φ = {outcome[FLUENCE].estimate!s}".replace(" W m^-2", " W m⁻²")
            axes.text(0.5, -0.02, below, ha="center", va="top", transform=axes.transAxes)


def _draw_grey(axes: Axes, seen: ViewReading) -> None:
    """A map as a photograph, without ticks; a circle about the hemisphere of a fisheye."""
    from matplotlib.colors import PowerNorm
    from matplotlib.patches import Circle

    from transport.viz.maps import bins_of, draw_values
    from transport.viz.style import outlined

    draw_values(axes, bins_of(seen), PowerNorm(1 / 2.2, 0, WHITE, clip=True)).set_cmap("gray")
    axes.set(xticks=[], yticks=[], xlabel="", ylabel="")
    axes.spines[:].set_visible(False)
    if getattr(seen.detector, "projection", None) in (FISHEYE, EQUAL_AREA):
        horizon = image_radius(seen.detector.projection, math.pi / 2)
        style = {"color": "white", "path_effects": outlined(2.0)}
        axes.add_patch(Circle((0, 0), horizon, fill=False, ls=(0, (4, 3)), lw=1.4, **style))
        axes.text(0, -horizon, "180°", ha="center", va="top", fontsize="small", **style)


def _with_photograph(outcomes: Sequence[Outcome]) -> list[Outcome]:
    """The photograph, with the map beside it where there is one; none without a photograph."""
    found = where(projection=(BALL, PHOTO))(outcomes)
    return found if any("photo" in o.result for o in found) else []


draw = figures(room=(draw_room, where(projection=PROJECTIONS)), ball=(draw_ball, _with_photograph))


# ---- Exact values


def fluence_rate() -> float:
    """φ of the room [W m^-2]."""
    shares = [(p.radiance - p.behind) * polygon_solid_angle(p.corners.tolist(), PLACE) for p in panels()]
    return math.fsum(shares) + (GLOBE_RADIANCE - WALLS["-x"]) * cap_solid_angle(_globe_half_angle())


def irradiance(normal: tuple[float, float, float]) -> float:
    """E on the front of a plane with this normal [W m^-2]."""
    shares = [
        (p.radiance - p.behind) * polygon_projected_solid_angle(p.corners, normal, PLACE) for p in panels()
    ]
    mu = float(np.dot(_to_globe(), normal) / (np.linalg.norm(_to_globe()) * np.linalg.norm(normal)))
    cone = float(cone_projected_solid_angle(_globe_half_angle(), mu))
    return math.fsum(shares) + (GLOBE_RADIANCE - WALLS["-x"]) * cone


@cache
def binning(projection: str, pixels: int, normal: tuple[float, float, float]) -> float:
    """What the bins of a map add to E [W m^-2]: -∫(L - L_i)(cos - cos_i) dω, with the means of each bin."""
    view = environment_map(projection, pixels)
    across = np.array(normal) / np.linalg.norm(normal)
    cells = np.flatnonzero(view.solid_angles().ravel() > 0)
    for points in (COARSE, FINE):  # where all rays of the first pass see one radiance, there is no edge
        weights, radiances, cosines = [], [], []
        for a, b in points:
            rays, weight = view.rays(a, b, cells)
            weights.append(weight)
            radiances.append(radiance_along(rays))
            cosines.append(np.maximum(rays @ across, 0.0))
        seen = np.array(weights) > 0
        low, high = (
            each(np.where(seen, radiances, fill), axis=0)
            for each, fill in ((np.min, np.inf), (np.max, -np.inf))
        )
        cells = cells[high > low] if points is COARSE else cells
    shares = np.array(weights) / np.maximum(np.sum(weights, axis=0), 1e-300)
    means = [np.sum(shares * each, axis=0) for each in (radiances, cosines)]
    both = np.sum(shares * np.array(radiances) * np.array(cosines), axis=0)
    return float(view.solid_angles().ravel()[cells] @ (means[0] * means[1] - both))


def radiance_along(rays: np.ndarray) -> np.ndarray:
    """The radiance that comes to PLACE against unit vectors, (n, 3) [W m^-2 sr^-1]."""
    found, nearest = np.zeros(len(rays)), np.full(len(rays), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for panel in panels():  # each lies in a plane of the axes, those before a wall later than the wall
            low, high = panel.corners.min(axis=0), panel.corners.max(axis=0)
            axis = int(np.argmin(high - low))
            others = [k for k in range(3) if k != axis]
            way = (low[axis] - PLACE[axis]) / rays[:, axis]
            is_hit = (way > 0) & (way < nearest)
            for k in others:
                met = PLACE[k] + way * rays[:, k]
                is_hit &= (met >= low[k]) & (met <= high[k])
            found[is_hit], nearest[is_hit] = panel.radiance, way[is_hit]
    towards = _to_globe() / np.linalg.norm(_to_globe())
    found[rays @ towards > math.cos(_globe_half_angle())] = GLOBE_RADIANCE
    return found


def following(projection: str) -> str:
    """The next projection of the cycle."""
    return PROJECTIONS[(PROJECTIONS.index(projection) + 1) % len(PROJECTIONS)]


def _next(view: tp.EnvironmentMap) -> tp.EnvironmentMap:
    """A coarse map in the next projection."""
    return environment_map(following(view.projection), 32)


def _to_globe() -> np.ndarray:
    return np.subtract(GLOBE.center, PLACE)


def _globe_half_angle() -> float:
    return math.asin(GLOBE.radius / float(np.linalg.norm(_to_globe())))


def _sum(result: tp.Result, radiance: tp.EstimateArray, angles: np.ndarray) -> tp.Estimate:
    """The sum of radiance times solid angle [W m^-2]."""
    products = radiance * angles
    return products.sum(products.dims) * constant(result, 1.0, "sr")


def _above(camera: tp.Camera) -> np.ndarray:
    """∫max(cosθ, 0) dω over each pixel about its line of sight [sr]; corners of the image see below it."""
    v, u = camera.edges().values()
    area = (v[1] - v[0]) * (u[1] - u[0]) / len(FINE)
    seen = [camera.rays(a, b)[1:] for a, b in FINE]
    return sum(area * w * np.maximum(rays @ camera.forward, 0.0) for rays, w in seen).reshape(camera.pixels)


def _of_photograph(result: tp.Result) -> dict[str, tp.Estimate]:
    """φ and E by the picture of the ball, as its projection has them."""
    photo = result["photo"].radiance
    view = environment_map(BALL, photo.shape[0])
    angles, wall = view.solid_angles(), WALLS["+y"]
    pixel = (view.edges()["u"][1] - view.edges()["u"][0]) ** 2
    weights = {FLUENCE: (np.full(angles.shape, pixel), 4 * math.pi)}
    for name, normal in PLANES.items():
        cosines = np.divide(
            view.projected_solid_angles(normal), angles, out=np.zeros_like(angles), where=angles > 0
        )
        weights[IRRADIANCE.format(name)] = pixel * cosines, math.pi
    return {
        name: _sum(result, photo, weight) + constant(result, wall * (whole - float(weight.sum())), "W m^-2")
        for name, (weight, whole) in weights.items()
    }


# ---- The room


def _photographer(pixels: int) -> tp.Camera:
    """A camera whose square image the ball fills."""
    x, y, z = PLACE
    rim = 2 * math.asin(MIRROR.radius / DISTANCE)
    return tp.Camera(
        name="photo", position=(x, y - DISTANCE, z), look_at=PLACE, field_of_view=rim, pixels=(pixels, pixels)
    )


@cache
def panels() -> tuple[Panel, ...]:
    """All rectangles that shine."""
    return tuple(_panels())


def _panels() -> Iterator[Panel]:
    sides = {"x": (LOW[1], HIGH[1], LOW[2], HIGH[2]), "y": (LOW[0], HIGH[0], LOW[2], HIGH[2])}
    level = LOW[0], HIGH[0], LOW[1], HIGH[1]
    for wall, radiance in WALLS.items():
        yield Panel(wall, _corners(wall, sides.get(wall[1:], level), 0.0), radiance, 0.0)
    for i in range(8):
        for j in range(i % 2, 10, 2):
            x, y = LOW[0] + 0.5 * i, LOW[1] + 0.5 * j
            yield _before("tiles", "floor", (x + 0.03, x + 0.47, y + 0.03, y + 0.47), 9.0)
    yield _before("lamp", "ceiling", (-0.9, 0.5, 0.4, 1.1), 100.0)
    for y in (-0.3, 0.35):
        for z in (0.95, 1.55):
            yield _before("window", "+x", (y, y + 0.6, z, z + 0.55), 60.0)
    yield _before("door", "-y", (-1.2, -0.3, 0.05, 2.05), 2.0)
    for strip in ((-1.5, -1.3, 0.7, 1.9), (-1.3, -0.7, 1.7, 1.9), (-1.3, -0.9, 1.25, 1.45)):  # F
        yield _before("letter", "+y", strip, 45.0)
    yield _before("frame", "-x", (0.1, 1.5, 0.8, 1.8), 3.0)
    yield _before("picture", "-x", (0.2, 1.4, 0.9, 1.7), 25.0, layers=2, behind=3.0)


def _before(
    name: str,
    wall: str,
    sides: tuple[float, ...],
    radiance: float,
    layers: int = 1,
    behind: float | None = None,
) -> Panel:
    corners = _corners(wall, sides, layers * BEFORE)
    return Panel(name, corners, radiance, WALLS[wall] if behind is None else behind)


def _corners(wall: str, sides: tuple[float, ...], before: float) -> np.ndarray:
    """Corners of a rectangle before a wall, by its lowest and highest places along the two axes of the wall."""
    axis = {"floor": 2, "ceiling": 2}.get(wall, "xyz".find(wall[-1]))
    is_high = wall == "ceiling" or wall[0] == "+"
    a, b, c, d = sides
    flat = np.array([(a, c), (b, c), (b, d), (a, d)])
    corners = np.insert(flat, axis, HIGH[axis] - before if is_high else LOW[axis] + before, axis=1)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[1])
    return corners[::-1] if (normal[axis] > 0) == is_high else corners


@cache
def _meshes() -> tuple[dict[str, tp.Mesh], dict[str, float]]:
    """Surfaces that shine, by name, and their radiances."""
    corners, radiances = {}, {}
    for panel in panels():
        corners.setdefault(panel.name, []).append(panel.corners)
        radiances[panel.name] = panel.radiance
    meshes = {}
    for name, many in corners.items():
        first = 4 * np.arange(len(many))[:, None, None]
        meshes[name] = tp.Mesh(
            vertices=np.concatenate(many), faces=(first + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
        )
    return meshes, radiances


if __name__ == "__main__":
    main(__file__)
