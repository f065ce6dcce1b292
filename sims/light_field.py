"""Light fields: the radiance of all rays through two planes, or through a sphere, and the pictures that are in them.

Derivation.  Radiance stays along a ray, so that light in free space is a function of rays, which have four coordinates
(Levoy and Hanrahan 1996; Gortler et al. 1996; Hanrahan 2001, Stanford CS 348B, lecture 4).  On two planes they are the
places where a ray crosses both: L(u, v, s, t).  On a sphere they are a place and a direction: L(θp, φp, θ, φ).  Whoever
knows L needs the scene no more:

    picture   a pixel is the mean of L over its rays; through a lens, over the rays of the lens, focused afterwards
    flux      Φ = ∬ L dG with the throughput dG = cosθ₁ cosθ₂/r² dA₁ dA₂; of a uniform L it is π L A₁ F₁₂ (Howell, C-13)
    distance  a point at the distance z is seen at s = u + (X − u) D/z: its line in the slice (u, s) has the slope 1 − D/z

Exact pictures.  A light field is known by cells.  A picture of it is exact where L is the same in each cell, and where
pixels end where cells do.  The scene "view" is such a one: a test card of grey lamps lies in the far plane, black panes
stand in the near one, and the camera stands so far behind that its pixels end at the edges of both.  The light field and
the camera are then two measurements of the same picture, of separate histories.  The mean product of differences in two
batches is 0 if they agree, whatever their distributions and correlations are (Chen, Qin 2010): χ² over its expectation
is 1.  Pixels of black panes have no noise, and show a ray that goes astray at once.

Sphere.  Light leaves a Lambertian ball of radius a in the middle of a sphere of radius R within the angle asin(a/R) of
the normal.  A bin of sin²θ that this edge divides holds the share of it that is lit, and the flux is π L 4π a².
"""

from __future__ import annotations

import math
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import transport as tp
from transport.sims import constant, figures, furthest, main, of_scene, one_of, where
from transport.theory.enclosures import chi_square_values
from transport.theory.view_factors import opposed_rectangles
from transport.verification.experiment import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes

law = "L(u, v, s, t) holds all pictures and Φ = ∬ L dG (Levoy and Hanrahan 1996; Gortler et al. 1996)"
question = "Are all pictures of a scene in its light field?"
particles = 6_000_000
intended = {
    "bins": "single cells of a light field hold few histories; the rows are means over many",
}
run = {"estimator": "backward"}  # light fields are read by no other

SHOWS = ("view", "planes", "refocus", "parallax", "ball", "cube")
DISTANCE = 1.5  # m, between the planes
BEHIND = 0.25  # m, of the camera behind the near plane
CELL = 0.01  # m, of the card in the far plane
CARD = (120, 92)  # cells
FOOTPRINT = CELL * BEHIND / (BEHIND + DISTANCE)  # of a pixel on the near plane
WINDOW = (3, 2)  # panes
PANE = (42 * FOOTPRINT, 50 * FOOTPRINT)  # m
BLACK = ((0, 0), (1, 1))  # panes
GREYS = (15.0, 35.0, 65.0, 100.0)  # W m^-2 sr^-1
FRAME = {"position": (0, 0, 0), "direction": (0, 1, 0), "distance": DISTANCE}
CARD_SIZE = tuple(CELL * number for number in CARD)
SEEN = (112, 84)  # pixels of the camera
ASIDE = (CELL, -CELL)  # of the camera from the axis: x, z
LENS = 0.12  # m, diameter
THINGS = {  # distance from the near plane [m], middle x and z [m], size [m], radiance [W m^-2 sr^-1]
    "near": (0.75, (0.05, 0.02), 0.05, 100.0),
    "on the plane": (1.5, (0.55, -0.03), 0.2, 50.0),
    "far": (3.0, (-1.0, 0.1), 0.24, 75.0),
}
VIEWS, FINE, NEAR_CELL = (9, 5), (64, 48), 0.05  # of the field of the things; m
FAR_CELL = 0.025  # m
RADIUS = 1.0  # m, of the sphere
CUBE = {"+x": 100.0, "-x": 25.0, "+y": 70.0, "-y": 45.0, "+z": 85.0, "-z": 15.0}  # W m^-2 sr^-1
EDGE = 0.9  # m, of the cube
PLACES, TURNS = (16, 32), 28  # bins on the sphere; of azimuth
TILTS = (*np.linspace(0.0, 0.92, 13).tolist(), math.pi / 2)  # rad; the cube is seen within 0.9
CHI_SQUARE, MEAN = "χ²/(number of pixels)", "light field / camera"
LEVEL, FLUX, COUNTED = "L of the light field", "Φ of the light field", "Φ on a detector"
LIT, DIVIDED, LEFT = "L of the ball", "L, bin at its edge", "Φ through the sphere"
WHERE = {"near": "distance of the near disk", "far": "distance of the far star"}


def cases() -> list[dict[str, object]]:
    return [{"show": show} for show in SHOWS]


def scene(show: str = "view", radiance: float = 100.0, radius: float = 0.4) -> tp.Scene:
    """show: what is photographed;  radiance: of the lamp of "planes" and of the ball [W m^-2 sr^-1];  radius: of the
    ball [m]."""
    one_of("light_field", show=(show, SHOWS))
    made = {"view": _window, "refocus": _card_in_focus, "parallax": _things, "cube": _cube}
    if show in made:
        return made[show]()
    if not 0.05 <= radius <= 0.9 * RADIUS:
        raise tp.SceneError(f"light_field: radius must be from 0.05 m to {0.9 * RADIUS:g} m, got {radius}")
    return _ball(radiance, radius) if show == "ball" else _planes(radiance)


def levels() -> np.ndarray:
    """Radiance of the cells of the card, (s, t): a checkerboard, a disk and a grey scale [W m^-2 sr^-1]."""
    s, t = np.meshgrid(*(np.arange(n) for n in CARD), indexing="ij")
    black, dark, light, white = GREYS
    is_odd = (s // 8 + t // 8) % 2 == 0
    from_middle = np.hypot(s + 0.5 - CARD[0] / 2, t + 0.5 - CARD[1] / 2)
    found = np.where(is_odd, white, black)
    found = np.where(from_middle < 28, np.where(is_odd, dark, light), found)
    found = np.where(from_middle < 14, np.where(s // 2 % 2 == 0, white, black), found)
    return found


def _card() -> tuple[list[tp.Source], list[tp.Surface]]:
    """A lamp of each grey: a mesh of the strips of cells that have it."""
    strips: dict[float, list[tuple[int, int, int]]] = {grey: [] for grey in GREYS}
    for t, row in enumerate(levels().T):
        first = 0
        for grey, cells in groupby(row.tolist()):
            past = first + len(list(cells))
            strips[grey].append((first, past, t))
            first = past
    left, low = -CARD_SIZE[0] / 2, -CARD_SIZE[1] / 2
    sources, surfaces = [], []
    for grey, found in strips.items():
        vertices = [
            (left + CELL * s, DISTANCE, low + CELL * (t + up))
            for first, past, t in found
            for s, up in ((first, 0), (past, 0), (past, 1), (first, 1))
        ]
        faces = [(4 * k, 4 * k + a, 4 * k + a + 1) for k in range(len(found)) for a in (1, 2)]
        name = f"grey {grey:g}"
        surfaces.append(tp.Surface(tp.Mesh(vertices=vertices, faces=faces), tp.Black(), name))
        sources.append(tp.Source(name, tp.Lambertian(radiance=grey)))
    return sources, surfaces


def _field(
    views: tuple[int, int], size: tuple[float, float], pixels=CARD, far_size=CARD_SIZE
) -> tp.LightField:
    return tp.LightField(name="field", views=views, size=size, pixels=pixels, far_size=far_size, **FRAME)


def view_camera() -> tp.Camera:
    """The camera behind the window; its pixels end at the edges of cells of the card and of panes."""
    half = math.atan(SEEN[0] * CELL / 2 / (BEHIND + DISTANCE))
    place = (ASIDE[0], -BEHIND, ASIDE[1])
    return tp.Camera(name="view", position=place, direction=(0, 1, 0), field_of_view=2 * half, pixels=SEEN)


def _window() -> tp.Scene:
    """The card, and black panes in the near plane, close in front of it."""
    sources, surfaces = _card()
    (width, height), (columns, rows) = PANE, WINDOW
    for k, (i, j) in enumerate(BLACK):
        middle = (width * (i + 0.5 - columns / 2), 1e-7, height * (j + 0.5 - rows / 2))
        pane = tp.Rectangle(center=middle, normal=(0, 1, 0), width=width, height=height)
        surfaces.append(tp.Surface(pane, tp.Black(), f"pane {k + 1}"))
    return tp.Scene(sources, surfaces, [_field(WINDOW, (columns * width, rows * height)), view_camera()])


def lens_camera(focus: float = DISTANCE, name: str = "lens") -> tp.Camera:
    """A camera whose lens lies in the near plane; in focus at the far one its pixels are cells of the card."""
    half = math.atan(SEEN[0] * CELL / 2 / DISTANCE)
    ahead = {"position": (0, 0, 0), "direction": (0, 1, 0), "field_of_view": 2 * half, "pixels": SEEN}
    return tp.Camera(name=name, lens="thin lens", aperture=LENS, focal_length=0.1, focus=focus, **ahead)


def _card_in_focus() -> tp.Scene:
    sources, surfaces = _card()
    return tp.Scene(sources, surfaces, [_field(WINDOW, (1.05 * LENS, 1.05 * LENS)), lens_camera()])


def _planes(radiance: float) -> tp.Scene:
    """A lamp that is the far plane; the near plane is a detector, too."""
    sides = {"center": (0, DISTANCE, 0), "normal": (0, -1, 0), "up": (0, 0, 1)}
    lamp = tp.Rectangle(width=CARD_SIZE[0], height=CARD_SIZE[1], **sides)
    field = _field((5, 4), (0.5, 0.4), (16, 12))
    source = tp.Source("lamp", tp.Lambertian(radiance=radiance))
    return tp.Scene(
        source, tp.Surface(lamp, tp.Black(), "lamp"), [field, tp.Detector(field.shape, "detector")]
    )


def things_field() -> tp.LightField:
    """The light field of the things: cells of both planes fit, so that edges are smeared over whole cells."""
    size = tuple(NEAR_CELL * number for number in VIEWS)
    return _field(VIEWS, size, FINE, tuple(FAR_CELL * number for number in FINE))


def _things() -> tp.Scene:
    """A disk, a square and a star, one behind the other."""
    sources, surfaces = [], []
    for name, (_, _, _, radiance) in THINGS.items():
        surfaces.append(tp.Surface(_thing(name), tp.Black(), name))
        sources.append(tp.Source(name, tp.Lambertian(radiance=radiance)))
    return tp.Scene(sources, surfaces, things_field())


def _thing(name: str) -> tp.Disk | tp.Rectangle | tp.Polygon:
    away, (x, z), size, _ = THINGS[name]
    if name == "near":
        return tp.Disk(center=(x, away, z), normal=(0, -1, 0), radius=size)
    if name == "far":
        turns = math.pi * (0.5 + np.arange(10) / 5)
        reach = size * np.where(np.arange(10) % 2 == 0, 1.0, 0.45)
        corners = zip(x + reach * np.cos(turns), z + reach * np.sin(turns), strict=True)
        return tp.Polygon(vertices=[(float(right), away, float(up)) for right, up in corners])
    return tp.Rectangle(center=(x, away, z), normal=(0, -1, 0), up=(0, 0, 1), width=size, height=size)


def _sphere(theta: tuple[float, ...] | np.ndarray, phi: int, places: tuple[int, int]) -> tp.Detector:
    """A spherical light field: what leaves through a sphere, by place and direction."""
    bins = tp.Positions(polar_angle=places[0], azimuth=places[1])
    return tp.Detector(
        tp.Sphere(radius=RADIUS),
        "sphere",
        side="inside",
        positions=bins,
        directions=tp.Directions(theta=theta, phi=phi),
    )


def _theta_edges(radius: float) -> np.ndarray:
    """Edges of bins of direction, the second of which is half lit."""
    within = (radius / RADIUS) ** 2
    return np.arcsin(np.sqrt([0.0, 0.5 * within, min(1.5 * within, 0.5 * (1 + within)), 1.0]))


def _ball(radiance: float, radius: float) -> tp.Scene:
    ball = tp.Surface(tp.Sphere(radius=radius), tp.Black(), "ball")
    source = tp.Source("ball", tp.Lambertian(radiance=radiance))
    return tp.Scene(source, ball, _sphere(_theta_edges(radius), 4, (6, 12)))


def _cube() -> tp.Scene:
    faces = tp.Box(size=(EDGE, EDGE, EDGE)).faces()
    surfaces = [tp.Surface(faces[name], tp.Black(), f"face {name}") for name in CUBE]
    sources = [tp.Source(f"face {name}", tp.Lambertian(radiance=grey)) for name, grey in CUBE.items()]
    return tp.Scene(sources, surfaces, _sphere(TILTS, TURNS, PLACES))


# ---- rows ----


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    if "sphere" in result:
        return _of_sphere(result)
    field = result["field"]
    if "detector" in result:
        rows = {LEVEL: field.radiance.mean(), FLUX: flux_of(field)}
        return rows | {COUNTED: result["detector"].flux_in}
    for name in ("view", "lens"):
        if name in result:
            return _compared(
                field.detector.view(field.radiance, result[name].detector), result[name].radiance
            )
    return {row: distance_of(field, name) for name, row in WHERE.items()}


def _compared(found: tp.EstimateArray, camera: tp.EstimateArray) -> dict[str, tp.Estimate]:
    """χ² over its expectation, and the mean of both pictures over each other."""
    off = (found.values - camera.values).reshape(len(found.values), -1)
    # Noise is that of the weights in a pixel: it grows with radiance and with the distance from the middle.
    v, u = ((edges[1:] + edges[:-1]) / 2 for edges in (camera.coords["v"], camera.coords["u"]))
    scale = np.maximum(camera.value, GREYS[0]) * np.sqrt(0.01 + u**2 + v[:, None] ** 2)
    chi_square = chi_square_values(off, scale.ravel() ** -2.0, found.run.sizes)
    return {CHI_SQUARE: tp.Estimate(chi_square, found.run, "1"), MEAN: found.sum() / camera.sum()}


def flux_of(field: object) -> tp.Estimate:
    """The sum of radiance times throughput [W]."""
    extent = field.detector.cell_measures().values
    values = np.tensordot(field.radiance.values, extent, axes=4)
    return tp.Estimate(values, field.radiance.run, "W")


def distance_of(field: object, name: str) -> tp.Estimate:
    """The distance of a thing, by the slope of its line from the first to the last view [m]."""
    made = field.detector
    middles = {axis: (edges[1:] + edges[:-1]) / 2 for axis, edges in made.edges().items()}
    first, last = (_place_in_view(field, name, view, middles["s"]) for view in (0, -1))
    slope = (last - first) / constant(field, float(middles["u"][-1] - middles["u"][0]), "m")
    return constant(field, made.distance, "m") / (1.0 - slope)


def _place_in_view(field: object, name: str, view: int, middles: np.ndarray) -> tp.Estimate:
    """The mean s of a thing in a column of the views [m]."""
    seen = field.by_source[name].radiance[view]
    totals = seen.values.sum(axis=(1, 3))
    run, unit = seen.run, "W m^-2 sr^-1"
    amount = tp.Estimate(totals.sum(axis=1), run, unit)
    return tp.Estimate(totals @ middles, run, f"{unit} m") / amount


def _of_sphere(result: tp.Result) -> dict[str, tp.Estimate]:
    sphere = result["sphere"]
    rows = {LEFT: sphere.flux_in}
    if sphere.radiance.shape[2] == len(TILTS) - 1:
        return rows
    return {DIVIDED: sphere.radiance[:, :, 1].mean()} | rows


@of_scene(scene)
def exact(show: str, radiance: float, radius: float) -> dict[str, float]:
    if show in ("view", "refocus"):
        return {CHI_SQUARE: 1.0, MEAN: 1.0}
    if show == "planes":
        flux = math.pi * radiance * 0.5 * 0.4 * opposed_rectangles((0.5, 0.4), CARD_SIZE, DISTANCE)
        return {LEVEL: radiance, FLUX: flux, COUNTED: flux}
    if show == "parallax":
        return {row: THINGS[name][0] for name, row in WHERE.items()}
    if show == "cube":
        return {LEFT: math.pi * EDGE**2 * sum(CUBE.values())}
    low, high = np.sin(_theta_edges(radius)[1:3]) ** 2
    share = ((radius / RADIUS) ** 2 - low) / (high - low)
    return {DIVIDED: float(radiance * share), LEFT: 4 * math.pi**2 * radius**2 * radiance}


def verdict(outcomes: list[Outcome]) -> str:
    return f"They are, from any place and in any focus, and so are flux and distances: {furthest(outcomes)}."


# ---- pictures ----


def draw_view(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The card through the window: out of the light field, by a camera, and how far apart they are."""
    from transport.viz.style import figure

    result = outcomes[0].result
    found, camera = picture_and_camera(result)
    off = found - camera
    with np.errstate(divide="ignore", invalid="ignore"):
        scores = np.where(off.value == 0, 0.0, off.value / off.error)
    with figure((22, 7.2), "A picture out of the light field, and a camera's", note, path) as page:
        left, middle, right = page.subplots(1, 3)
        for axes, values, title in ((left, found, "from L(u, v, s, t)"), (middle, camera, "by a camera")):
            image = _show(axes, values.value, title)
        page.colorbar(image, ax=[left, middle], label=r"L  [W m$^{-2}$ sr$^{-1}$]", shrink=0.85)
        image = right.imshow(scores[::-1], cmap="RdBu_r", vmin=-4, vmax=4, interpolation="nearest")
        right.set_title("difference")
        _bare(right)
        page.colorbar(image, ax=right, label="standard errors", shrink=0.85)


def picture_and_camera(result: tp.Result) -> tuple[tp.EstimateArray, tp.EstimateArray]:
    """The picture that the field gives, and that of the camera."""
    field, camera = result["field"], result["view"]
    return field.detector.view(field.radiance, camera.detector), camera.radiance


def _show(axes: Axes, values: np.ndarray, title: str, most: float = GREYS[-1], **how: object) -> object:
    """Radiances (v, u) as a grey picture."""
    image = axes.imshow(values[::-1], cmap="gray", vmin=0, vmax=most, interpolation="nearest", **how)
    axes.set_title(title)
    _bare(axes)
    return image


def _bare(axes: Axes) -> None:
    axes.set(xticks=[], yticks=[])
    axes.grid(False)


def draw_array(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Views from places on the near plane, side by side."""
    from transport.viz.style import INK, figure

    field = outcomes[0].result["field"]
    edges = field.detector.edges()
    u, v = ((edges[name][1:] + edges[name][:-1]) / 2 for name in "uv")
    columns, rows = (0, 2, 4, 6, 8), (4, 2, 0)
    title = "An array of pictures: near things move against the far ones"
    with figure((19, 10.2), title, note, path) as page:
        panels = page.subplots(len(rows), len(columns))
        for line, j in zip(panels, rows, strict=True):
            for axes, i in zip(line, columns, strict=True):
                _show(axes, field.radiance.value[i, j].T, "")
                axes.axvline(FINE[0] / 2 - 0.5, color="#56B4E9", lw=1.2, ls=":")
                if j == rows[0]:
                    axes.set_title(f"u = {100 * u[i]:.0f} cm", color=INK)
                if i == columns[0]:
                    axes.set_ylabel(f"v = {100 * v[j]:.0f} cm")


def draw_slice(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The slice (u, s) in the middle of v and t: a line for each thing, whose slope gives its distance."""
    from transport.viz.style import BLUE, GREEN, VERMILLION, figure

    outcome = outcomes[0]
    field = outcome.result["field"]
    made = field.detector
    edges, middle = made.edges(), VIEWS[1] // 2
    row = field.radiance.value[:, middle, :, FINE[1] // 2]
    with figure((13, 8.6), "The slope of a line gives the distance", note, path) as page:
        axes = page.subplots()
        span = [100 * edges["s"][0], 100 * edges["s"][-1], 100 * edges["u"][0], 100 * edges["u"][-1]]
        axes.imshow(
            row,
            cmap="gray",
            vmin=0,
            vmax=GREYS[-1],
            origin="lower",
            extent=span,
            aspect="auto",
            interpolation="nearest",
        )
        u = np.array(span[2:])
        for (name, (away, (x, _), _, _)), colour in zip(
            THINGS.items(), (VERMILLION, GREEN, BLUE), strict=True
        ):
            s = u + (100 * x - u) * made.distance / away
            axes.plot(
                s,
                u,
                color=colour,
                lw=4,
                label=f"{name}: z = {away:g} m, ds/du = {1 - made.distance / away:g}",
            )
        axes.set(
            xlabel="s on the far plane  [cm]",
            ylabel="u on the near plane  [cm]",
            xlim=span[:2],
            ylim=span[2:],
        )
        axes.grid(False)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=1)


def draw_refocus(outcomes: list[Outcome], path: Path, note: str) -> None:
    """One light field, focused at three distances afterwards."""
    from transport.viz.style import figure

    field = outcomes[0].result["field"]
    half = math.atan(0.7 / DISTANCE)
    ahead = {"position": (0, 0, 0), "direction": (0, 1, 0), "field_of_view": 2 * half, "pixels": (84, 48)}
    with figure((22, 6.4), "Focused after the light was counted", note, path) as page:
        for axes, (name, (away, *_)) in zip(page.subplots(1, 3), THINGS.items(), strict=True):
            lens = tp.Camera(
                name=name, lens="thin lens", aperture=0.22, focal_length=0.11, focus=away, **ahead
            )
            picture = field.detector.view(field.radiance.value, lens)
            _show(axes, picture, f"focus at {away:g} m: {name}")


def draw_sphere(outcomes: list[Outcome], path: Path, note: str) -> None:
    """A cube from three sides, out of its spherical light field, and above it what is there."""
    from transport.viz.style import figure

    result = outcomes[0].result
    sides = {
        "from the front": (0.3, 1.0, -0.25),
        "from the right": (-1.0, 0.45, -0.35),
        "from above": (-0.35, 0.3, -1.0),
    }
    with figure((16, 11), "All light that leaves a cube, as a hologram", note, path) as page:
        upper, lower = page.subplots(2, 3)
        for k, (name, sight) in enumerate(sides.items()):
            along = np.array(sight) / np.linalg.norm(sight)
            camera = tp.Camera(
                name="c",
                position=tuple(-3 * along),
                direction=sight,
                lens="orthographic",
                width=1.7,
                pixels=(120, 120),
            )
            _show(upper[k], cube_picture(camera), name)
            image = _show(lower[k], hologram_picture(result["sphere"], camera), "")
        upper[0].set_ylabel("the cube"), lower[0].set_ylabel("from L(θp, φp, θ, φ)")
        page.colorbar(image, ax=[*upper, *lower], label=r"L  [W m$^{-2}$ sr$^{-1}$]", shrink=0.7)


def cube_picture(camera: tp.Camera) -> np.ndarray:
    """Radiance of the cube's face that each pixel's ray meets, (v, u)."""
    places, rays, _ = camera.rays(0.5, 0.5)
    with np.errstate(divide="ignore"):
        ways = (-np.sign(rays) * EDGE / 2 - places) / rays
    axis, enters = ways.argmax(axis=1), ways.max(axis=1)
    met = places + enters[:, None] * rays
    is_met = (np.abs(met) <= EDGE / 2 * (1 + 1e-9)).all(axis=1)
    greys = np.array([[CUBE[f"{sign}{name}"] for sign in "+-"] for name in "xyz"])
    ahead = rays[np.arange(len(rays)), axis] > 0
    return np.where(is_met, greys[axis, ahead.astype(int)], 0.0).reshape(camera.pixels[::-1])


def hologram_picture(sphere: object, camera: tp.Camera, rays_per_side: int = 3) -> np.ndarray:
    """Radiance of the bin of place and direction that each pixel's rays come by, (v, u)."""
    values, edges = sphere.radiance.value, sphere.radiance.coords
    total = np.zeros(math.prod(camera.pixels))
    shares = (np.arange(rays_per_side) + 0.5) / rays_per_side
    for across, up in ((a, b) for a in shares for b in shares):
        places, rays, _ = camera.rays(across, up)
        bins = bins_of(places, rays)
        index = [np.clip(np.searchsorted(edges[name], x, "right") - 1, 0, n - 1)
                 for name, x, n in zip(sphere.radiance.dims, bins, values.shape, strict=True)]  # fmt: skip
        total += np.where(np.isnan(bins[0]), 0.0, values[tuple(index)])
    return (total / rays_per_side**2).reshape(camera.pixels[::-1])


def bins_of(places: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, ...]:
    """Polar angle and azimuth of where rays enter the sphere, and of their direction there; nan of those that miss."""
    along = np.sum(places * rays, axis=1)
    less = along**2 - np.sum(places * places, axis=1) + RADIUS**2
    met = places - (along + np.sqrt(np.where(less > 0, less, np.nan)))[:, None] * rays
    inward = -met / RADIUS
    up = np.array([0.0, 0.0, 1.0]) - inward[:, 2:] * inward
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    right = np.cross(up, inward)
    turn = np.arctan2(np.sum(rays * up, axis=1), np.sum(rays * right, axis=1))
    cosine = np.clip(np.sum(rays * inward, axis=1), -1, 1)
    azimuth = np.arctan2(met[:, 1], met[:, 0])
    return np.arccos(met[:, 2] / RADIUS), azimuth % (2 * math.pi), np.arccos(cosine), turn % (2 * math.pi)


draw = figures(
    view=(draw_view, where(show="view")),
    array=(draw_array, where(show="parallax")),
    slice=(draw_slice, where(show="parallax")),
    refocus=(draw_refocus, where(show="parallax")),
    sphere=(draw_sphere, where(show="cube")),
)


if __name__ == "__main__":
    main(__file__)
