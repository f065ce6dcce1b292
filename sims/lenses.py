"""Lenses of a camera: where a direction lies in the picture, how bright the film is, and what is sharp.

Derivation.  A lens decides which rays a pixel is a mean of; radiance along them stays.

    place        a direction at the angle θ from the axis lies at r = tan θ (pinhole), θ (fisheye), 2 sin(θ/2) (equal areas);
                 parallel rays (orthographic) show a width as it is, at any distance, where a pinhole shows width/d
    brightness   the film at v behind a thin lens of diameter D sees the lens, of radiance L, as a disk: on the axis
                 E = π L (D/2)²/((D/2)² + v²), not π L (D/2v)²; off the axis, for a small lens, it falls as cos⁴θ: two
                 cosines of lens and film, and (cosθ/v)² of the distance (Hanrahan 2001; Foote 1915 for any lens)
    sharpness    a ray from the place a of the lens, for the place u of the picture, goes through u s in the plane of
                 focus, at the distance s; at the distance d it is at u d + a (1 − d/s).  So a point there is smeared over
                 u by D |1/d − 1/s|, in the plane of focus by the circle of confusion c = D |d − s|/d, and an edge has
                 the profile of the share of the lens beyond a chord, a > −u/(1/d − 1/s)

The share is of light: each place of the lens counts by cos⁴ of its line from the film.  The integral across the lens has
a closed form, that along it is a quadrature.

Lamps at an angle are small balls.  Their r is that of the middles of the pixels that they light, by solid angle, and the
exact value is the mean of the same over the cap that they fill: with pixels of 1/720 it differs from r(θ) by 1e-4 of it.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import camera as room
from transport.sims import constant, figures, furthest, main, of_scene, one_of, require, where
from transport.theory.emitters import disk_irradiance
from transport.theory.enclosures import chi_square_values
from transport.theory.solid_angles import cap_solid_angle
from transport.verification.experiment import Outcome

law = "E = π L (D/2)²/((D/2)² + v²), cos⁴θ off the axis; c = D |d − s|/d; r = tan θ, θ, 2 sin(θ/2) (Foote 1915; Hanrahan 2001)"
question = "What do lenses change in a picture: places, brightness and sharpness?"
particles = 6_000_000
intended = {
    "bins": "single pixels of the pictures are grainy; the rows are means over many",
}
run = {"estimator": "backward"}  # cameras are read by no other

SHOWS = ("room", "film", "edge", "size", "wide", "foci")
FOCAL = 0.05  # m
F_NUMBERS = (0.7, 1.4, 2.8, 8.0)
STRIP, STRIP_VIEW, STRIP_STOP = 81, math.radians(88), 16.0  # pixels, rad, f-number
OFF_AXIS = (20, 40)  # deg
FOCUS, STOP = 1.0, 2.0  # m, f-number: of the edge
EDGES = (0.6, 1.0, 2.0)  # m
COLUMNS, HALF = 9000, 0.012  # pixels, and half of their picture [1]
ROW = 300  # half the pixels of a row
WIDTH, SIZES = 0.5, (1.0, 2.0, 4.0)  # m
ORTHOGRAPHIC, PINHOLE = (0.9, 50), (0.8, 64)  # widths of the pictures [m], [1], and pixels
AT, LAMP = (20, 40, 60), math.radians(2)  # deg; half angle of a lamp
BEHIND = math.radians(30)  # half angle of the lamp behind the camera
STRIPS = (720, 24)  # pixels
WIDE = {"pinhole": math.radians(140), "fisheye": math.pi, "equal-area fisheye": math.pi}
LAW_OF_PLACE = {
    "pinhole": (np.tan, "tan θ"),
    "fisheye": (lambda theta: theta, "θ"),
    "equal-area fisheye": (lambda theta: 2 * np.sin(theta / 2), "2 sin(θ/2)"),
}
BOARDS = {1.0: (-0.36, 0.05), 1.8: (0.0, 0.09), 3.5: (1.2, 0.17)}  # distance: middle x, cell [m]
BACKDROP = 0.3  # of the radiance of a board
CHI_SQUARE = "χ²/(number of pixels)"
ALL, MAP = "φ, fisheye of 360°", "φ, environment map"
ON_EDGE, BEFORE, BEYOND = "L on the edge", "L at u = −c/4", "L at u = +c/4"


def cases() -> list[dict[str, object]]:
    edges = [{"show": "edge", "distance": distance} for distance in EDGES]
    sizes = [{"show": "size", "distance": distance} for distance in SIZES]
    return [{"show": "room"}, {"show": "film"}, *edges, *sizes, {"show": "wide"}, {"show": "foci"}]


def scene(show: str = "room", distance: float = 1.0, radiance: float = 100.0) -> tp.Scene:
    """show: what is photographed;  distance: of the edge or the panel [m];  radiance: of the lamps, not of that in the
    room [W m^-2 sr^-1]."""
    one_of("lenses", show=(show, SHOWS))
    require("lenses", distance=(distance, 0.3 <= distance <= 100, "from 0.3 to 100 m"))
    made = {"edge": _edge, "size": _panel}
    if show in made:
        return made[show](distance, radiance)
    return {"film": _page, "wide": _lamps, "foci": _boards}[show](radiance) if show != "room" else _room()


def _camera(name: str, lens: str = "pinhole", **how: object) -> tp.Camera:
    """At the origin, looking along +y."""
    place = {"position": (0, 0, 0), "direction": (0, 1, 0)} | how
    return tp.Camera(name=name, lens=lens, **place)


def _thin(
    name: str,
    f_number: float,
    half: float,
    pixels: tuple[int, int],
    focus: float | None,
    focal: float = FOCAL,
) -> tp.Camera:
    lens = {"aperture": focal / f_number, "focal_length": focal, "focus": focus}
    return _camera(name, "thin lens", field_of_view=2 * math.atan(half), pixels=pixels, **lens)


def _lit(
    shape: tp.Rectangle | tp.Mesh | tp.Sphere, name: str, radiance: float
) -> tuple[tp.Source, tp.Surface]:
    return tp.Source(name, tp.Lambertian(radiance=radiance)), tp.Surface(shape, tp.Black(), name)


def _wall(distance: float, width: float, height: float, x: float = 0.0) -> tp.Rectangle:
    """A rectangle that faces the camera."""
    return tp.Rectangle(center=(x, distance, 0), normal=(0, -1, 0), up=(0, 0, 1), width=width, height=height)


def _room() -> tp.Scene:
    """The room of the experiment `camera`, through five lenses, one of them in two foci."""
    known = room.scene()
    ahead = {"position": (0.1, -2.3, 1.4), "look_at": (0, 0.5, 0.95)}
    small = ahead | {"pixels": (100, 75)}
    level = {"position": (0.1, -2.3, 1.2), "direction": (0, 1, 0), "pixels": (100, 75)}
    lens = {"lens": "thin lens", "field_of_view": 80 * tp.deg, "aperture": 0.25, "focal_length": 1.0}
    round_ = ahead | {"pixels": (80, 80)}
    views = [
        tp.Camera(name="pinhole", lens="pinhole", field_of_view=80 * tp.deg, **small),
        tp.Camera(name="fisheye", lens="fisheye", field_of_view=math.pi, **round_),
        tp.Camera(name="equal-area fisheye", lens="equal-area fisheye", field_of_view=math.pi, **round_),
        tp.Camera(name="orthographic", lens="orthographic", width=2.9, **level),
        tp.Camera(name="thin lens", focus=1.7, **lens, **small),
        tp.Camera(name="far focus", focus=4.6, **lens, **small),
    ]
    return tp.Scene(known.sources, known.surfaces, views)


def _page(radiance: float) -> tp.Scene:
    """A page that fills all pictures; cameras with one pixel on the axis, and one with a strip of them."""
    source, surface = _lit(_wall(1.0, 6.0, 6.0), "page", radiance)
    cameras = [_thin(_stop(number), number, 5e-4, (1, 1), None) for number in F_NUMBERS]
    half = math.tan(STRIP_VIEW / 2)
    return tp.Scene(source, surface, [*cameras, _thin("strip", STRIP_STOP, half, (STRIP, 1), None)])


def _stop(number: float) -> str:
    """Name of the camera with this f-number; no name has a point."""
    return f"f over {number:g}".replace(".", "_")


def _edge(distance: float, radiance: float) -> tp.Scene:
    """A lamp right of the axis, whose edge is on it."""
    source, surface = _lit(_wall(distance, 0.4 * distance, distance, 0.2 * distance), "lamp", radiance)
    return tp.Scene(source, surface, _thin("view", STOP, HALF, (COLUMNS, 1), FOCUS))


def _panel(distance: float, radiance: float) -> tp.Scene:
    source, surface = _lit(_wall(distance, WIDTH, 1.0), "panel", radiance)
    (width, columns), (reach, pixels) = ORTHOGRAPHIC, PINHOLE
    straight = _camera("orthographic", "orthographic", width=width, pixels=(columns, 1))
    angle = 2 * math.atan(reach / 2)
    return tp.Scene(source, surface, [straight, _camera("pinhole", field_of_view=angle, pixels=(pixels, 1))])


def _lamps(radiance: float) -> tp.Scene:
    """Small balls at some angles to the right, and a large one behind the camera."""
    parts = []
    for degrees in AT:
        x, y = 2 * math.sin(math.radians(degrees)), 2 * math.cos(math.radians(degrees))
        parts.append(
            _lit(tp.Sphere(center=(x, y, 0), radius=2 * math.sin(LAMP)), f"lamp at {degrees}°", radiance)
        )
    parts.append(_lit(tp.Sphere(center=(0, -2, 0), radius=2 * math.sin(BEHIND)), "lamp behind", radiance))
    sources, surfaces = zip(*parts, strict=True)
    strips = [_camera(lens, lens, field_of_view=angle, pixels=STRIPS) for lens, angle in WIDE.items()]
    whole = _camera("all", "fisheye", field_of_view=2 * math.pi, pixels=(64, 64))
    return tp.Scene(sources, surfaces, [*strips, whole, tp.EnvironmentMap(name="map", position=(0, 0, 0))])


def _boards(radiance: float) -> tp.Scene:
    """Chequered boards at three distances before a bright wall, focused on each of them."""
    parts = [_lit(_wall(6.0, 12.0, 12.0), "backdrop", BACKDROP * radiance)]
    blacks = []
    for k, (distance, (x, cell)) in enumerate(BOARDS.items(), 1):
        blacks.append(tp.Surface(_wall(distance + 1e-3, 6 * cell, 6 * cell, x), tp.Black(), f"board {k}"))
        vertices, faces = [], []
        for i, j in ((i, j) for i in range(6) for j in range(6) if (i + j) % 2 == 0):
            n, left, low = len(vertices), x + cell * (i - 3), cell * (j - 3)
            vertices += [
                (left + cell * a, distance, low + cell * b) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))
            ]
            faces += [(n, n + 1, n + 2), (n, n + 2, n + 3)]
        parts.append(_lit(tp.Mesh(vertices=vertices, faces=faces), f"white {k}", radiance))
    sources, surfaces = zip(*parts, strict=True)
    half = math.tan(math.radians(28))
    views = [_thin(f"focus {k}", 2.0, half, (140, 70), d, focal=0.2) for k, d in enumerate(BOARDS, 1)]
    return tp.Scene(sources, [*surfaces, *blacks], views)


# ---- rows ----


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    if "strip" in result:
        return _on_film(result)
    if "map" in result:
        return _places(result) | {ALL: result["all"].fluence_rate, MAP: result["map"].fluence_rate}
    if "orthographic" in result and "fisheye" not in result:
        return {f"width, {name}": width_of(result, name) for name in ("orthographic", "pinhole")}
    if "view" in result:
        return _profile(result)
    if "fisheye" in result:
        views = [result[lens] for lens in room_lenses()]
        return {f"L of the lamp, {view.name}": view.radiance[pixel_of_lamp(view.detector)] for view in views}
    return {
        f"L of the wall, focus at {distance:g} m": result[f"focus {k}"].radiance[60:, 60:80].mean()
        for k, distance in enumerate(BOARDS, 1)
    }


def room_lenses() -> list[str]:
    """Lenses that see the lamp of the room, and whose rays differ in weight: others read it without an error."""
    return ["pinhole", "fisheye", "thin lens"]


def pixel_of_lamp(camera: tp.Camera) -> tuple[int, int]:
    """The pixel that looks closest to the middle of the lamp."""
    _, rays, weights = camera.rays(0.5, 0.5)
    wanted = np.subtract(room.LAMP.center, camera.position)
    found = int(np.where(weights > 0, rays @ wanted, -np.inf).argmax())
    return divmod(found, camera.pixels[0])


def _on_film(result: tp.Result) -> dict[str, tp.Estimate]:
    axis = {f"E on the axis, f/{n:g}": result[_stop(n)].irradiance[0, 0] for n in F_NUMBERS}
    strip = result["strip"].irradiance[0]
    middle = strip[STRIP // 2]
    return axis | {f"E({angle}°)/E(0°)": strip[column_at(angle)] / middle for angle in OFF_AXIS}


def column_at(angle: float) -> int:
    """The pixel of the strip in which a direction at this angle [deg] lies."""
    half = math.tan(STRIP_VIEW / 2)
    return int((math.tan(math.radians(angle)) / half + 1) / 2 * STRIP)


def film_irradiances(radiance: float) -> np.ndarray:
    """Mean irradiance of each pixel of the strip (Foote 1915) [W m^-2]."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    half = math.tan(STRIP_VIEW / 2)
    edges = np.linspace(-half, half, STRIP + 1)
    u = (edges[1:] + edges[:-1])[:, None] / 2 + half / STRIP * nodes
    off = np.hypot(u[:, :, None], half / STRIP * nodes)
    found = disk_irradiance(radiance, 1 / STRIP_STOP / 2, 1.0, off)
    return found @ weights @ weights / 4


def width_of(result: tp.Result, name: str) -> tp.Estimate:
    """The width of the panel in a picture: the sum of L over that of the panel, times the width of a pixel."""
    view = result[name]
    edges = view.radiance.coords["u"]
    level = constant(result, result.scene.sources[0].emission.radiance, "W m^-2 sr^-1")
    return (
        view.radiance.sum()
        / level
        * constant(result, float(edges[1] - edges[0]), "m" if name[0] == "o" else "1")
    )


def _places(result: tp.Result) -> dict[str, tp.Estimate]:
    """The mean r of each lamp in each picture, by solid angle."""
    rows = {}
    for lens in WIDE:
        view = result[lens]
        v, u = ((e[1:] + e[:-1]) / 2 for e in view.detector.edges().values())
        radii, angles = np.hypot(u, v[:, None]).ravel(), view.detector.solid_angles().ravel()
        for degrees in AT:
            values = view.by_source[f"lamp at {degrees}°"].radiance.values
            seen = values.reshape(len(values), -1) * angles
            moment, amount = (
                tp.Estimate(seen @ by, result.run, "W m^-2") for by in (radii, np.ones_like(radii))
            )
            rows[f"r at {degrees}°, {lens}"] = moment / amount
    return rows


def mean_place(lens: str, theta: float, points: int = 1000) -> float:
    """The mean r of the middles of the pixels in which the directions of a lamp at the angle theta [rad] lie.

    points: along both sides of a grid of even directions of the cap, of which the upper half is enough.
    """
    even = (np.arange(points) + 0.5) / points
    mu = 1 - (1 - math.cos(LAMP)) * even[:, None]
    aside, turn = np.sqrt((1 - mu) * (1 + mu)), math.pi * even
    inward, up = aside * np.cos(turn), aside * np.sin(turn)
    right = math.sin(theta) * mu + math.cos(theta) * inward
    along = math.cos(theta) * mu - math.sin(theta) * inward
    across = np.hypot(right, up)
    rule = LAW_OF_PLACE[lens][0]
    stretch = rule(np.arctan2(across, along)) / across
    pixel = 2 * float(rule(WIDE[lens] / 2)) / STRIPS[0]
    u, v = ((np.floor(stretch * each / pixel) + 0.5) * pixel for each in (right, up))
    return float(np.hypot(u, v).mean())


def blur(distance: float) -> float:
    """Width in u over which an edge at this distance is smeared."""
    return FOCAL / STOP * abs(1 / distance - 1 / FOCUS)


def edge_profile(distance: float) -> np.ndarray:
    """Share of the light of each pixel's lens that comes from right of the edge."""
    edges = np.linspace(-HALF, HALF, COLUMNS + 1)
    u, power = (edges[1:] + edges[:-1]) / 2, 1 / distance - 1 / FOCUS
    film = 1 / (1 / FOCAL - 1 / FOCUS)
    radius = FOCAL / STOP / 2
    if power == 0:
        return (u > 0).astype(float)
    chord = np.arcsin(np.clip(-u / power / radius, -1.0, 1.0))  # its place, as the sine of an angle
    low, high = (chord, np.full_like(u, math.pi / 2)) if power > 0 else (np.full_like(u, -math.pi / 2), chord)
    whole = _light_between(u, np.full_like(u, -math.pi / 2), np.full_like(u, math.pi / 2), radius / film)
    return _light_between(u, low, high, radius / film) / whole


def _light_between(u: np.ndarray, low: np.ndarray, high: np.ndarray, radius: float) -> np.ndarray:
    """Integral of cos⁴ from film at the distance 1 over the part of a lens between two chords, at sines of angles.

    Across the lens, from -h to h: h/(A(A + h²)) + atan(h/√A)/A^(3/2) with A = 1 + (u + a)².
    """
    nodes, weights = np.polynomial.legendre.leggauss(48)
    angle = (high + low)[:, None] / 2 + (high - low)[:, None] / 2 * nodes
    place, half = radius * np.sin(angle), radius * np.cos(angle)
    along = 1 + (u[:, None] + place) ** 2
    across = half / (along * (along + half**2)) + np.arctan(half / np.sqrt(along)) / along**1.5
    return (high - low) / 2 * ((across * half) @ weights)


def positions(distance: float) -> dict[str, slice]:
    """Pixels of the rows of an edge."""
    step = 0.25 * max(blur(distance), 0.3 * HALF) / (2 * HALF) * COLUMNS
    middles = {BEFORE: COLUMNS / 2 - step, ON_EDGE: COLUMNS / 2, BEYOND: COLUMNS / 2 + step}
    return {name: slice(round(m) - ROW, round(m) + ROW) for name, m in middles.items()}


def _profile(result: tp.Result) -> dict[str, tp.Estimate]:
    view, lamp = result["view"].radiance[0], result.scene.sources[0].emission.radiance
    distance = result.scene.surfaces[0].shape.center[1]
    expected = edge_profile(distance)
    noise = expected * (1 - expected) + 0.003 * expected + 1e-4
    off = view.values / lamp - expected
    chi_square = tp.Estimate(chi_square_values(off, 1 / noise, result.run.sizes), result.run, "1")
    rows = {name: view[pixels].mean() for name, pixels in positions(distance).items()}
    return {CHI_SQUARE: chi_square} | rows


@of_scene(scene)
def exact(show: str, distance: float, radiance: float) -> dict[str, float]:
    if show == "room":
        return {f"L of the lamp, {lens}": room.RADIANCE for lens in room_lenses()}
    if show == "film":
        strip = film_irradiances(radiance)
        axis = {f"E on the axis, f/{n:g}": math.pi * radiance / (1 + 4 * n**2) for n in F_NUMBERS}
        return axis | {f"E({a}°)/E(0°)": float(strip[column_at(a)] / strip[STRIP // 2]) for a in OFF_AXIS}
    if show == "edge":
        profile = radiance * edge_profile(distance)
        rows = {name: float(profile[pixels].mean()) for name, pixels in positions(distance).items()}
        return {CHI_SQUARE: 1.0} | rows
    if show == "size":
        return {"width, orthographic": WIDTH, "width, pinhole": WIDTH / distance}
    if show == "wide":
        rows = {f"r at {a}°, {lens}": mean_place(lens, math.radians(a)) for lens in WIDE for a in AT}
        whole = radiance * (len(AT) * cap_solid_angle(LAMP) + cap_solid_angle(BEHIND))
        return rows | {ALL: whole, MAP: whole}
    return {f"L of the wall, focus at {d:g} m": BACKDROP * radiance for d in BOARDS}


def verdict(outcomes: list[Outcome]) -> str:
    return f"As the laws of each lens say: {furthest(outcomes)}."


# ---- pictures ----


def draw_room(outcomes: list[Outcome], path: Path, note: str) -> None:
    """One room through the lenses, side by side, in grey."""
    from matplotlib.colors import PowerNorm

    from transport.viz.style import figure

    result = outcomes[0].result
    norm = PowerNorm(1 / 2.2, 0, room.RADIANCE / room.BRIGHTER, clip=True)
    titles = {"pinhole": "pinhole", "fisheye": "fisheye", "equal-area fisheye": "equal-area fisheye"}
    titles |= {"orthographic": "orthographic"}
    titles |= {"thin lens": "thin lens, focus near", "far focus": "thin lens, focus on the wall"}
    with figure((21, 13), "One room through five lenses", note, path) as page:
        panels = page.subplots(2, 3).ravel()
        for axes, (lens, title) in zip(panels, titles.items(), strict=True):
            axes.imshow(result[lens].image(), cmap="gray", norm=norm)
            axes.set_title(title), axes.set(xticks=[], yticks=[]), axes.grid(False)


def draw_film(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Irradiance on the film against the aperture, and off the axis, beside the laws that do not hold."""
    from transport.viz.style import BLUE, MUTED, VERMILLION, figure

    outcome = outcomes[0]
    level = outcome.given["radiance"]
    with figure((20, 8.6), "How bright the film is", note, path) as page:
        left, right = page.subplots(1, 2)
        width = np.linspace(0.0, 1.55, 100)
        left.plot(
            width,
            math.pi * level * width**2 / (4 + width**2),
            color=BLUE,
            lw=3,
            label="π L (D/2)²/((D/2)² + v²)",
        )
        left.plot(width, math.pi * level * width**2 / 4, "--", color=MUTED, lw=2.5, label="if it grew as D²")
        rows = [outcome[f"E on the axis, f/{n:g}"].estimate for n in F_NUMBERS]
        left.errorbar(
            [1 / n for n in F_NUMBERS],
            [r.value for r in rows],
            [r.error for r in rows],
            fmt="o",
            color=BLUE,
            ms=13,
        )
        for n, row in zip(F_NUMBERS, rows, strict=True):
            left.annotate(
                f"f/{n:g}",
                (1 / n, row.value),
                (12, -22 if n < 8 else 16),
                textcoords="offset points",
                color=BLUE,
            )
        left.set(
            xlabel="aperture D over the distance v of the film",
            ylabel=r"E on the axis  [W m$^{-2}$]",
            xlim=(0, 1.6),
            ylim=(0, 160),
        )
        left.legend(loc="upper left")
        strip = outcome.result["strip"].irradiance[0] / outcome.result["strip"].irradiance[0][STRIP // 2]
        u = (strip.coords["u"][1:] + strip.coords["u"][:-1]) / 2
        angles, fine = np.degrees(np.arctan(u)), np.radians(np.linspace(-44, 44, 200))
        right.plot(np.degrees(fine), np.cos(fine) ** 4, color=VERMILLION, lw=3, label="cos⁴θ")
        right.plot(
            np.degrees(fine),
            np.cos(fine),
            "--",
            color=MUTED,
            lw=2.5,
            label="if only the film were tilted: cos θ",
        )
        right.plot(angles, strip.value, "o", color=VERMILLION, ms=7, mec="white", label="film behind f/16")
        right.set(xlabel="angle θ off the axis  [°]", ylabel="E(θ)/E(0)", ylim=(0, 1.25))
        right.legend(loc="upper center", ncols=1)


def draw_edge(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The profile of an edge before, in and behind the plane of focus."""
    from transport.viz.style import BLUE, MUTED, figure

    joined = 450  # pixels
    with figure(
        (7.2 * len(outcomes), 7.6), f"An edge, photographed in focus at {FOCUS:g} m", note, path
    ) as page:
        for axes, outcome in zip(page.subplots(1, len(outcomes), squeeze=False)[0], outcomes, strict=True):
            distance, level = outcome.given["distance"], outcome.given["radiance"]
            seen = outcome.result["view"].radiance[0]
            groups = seen.value.reshape(-1, joined).mean(axis=1)
            edges = 1000 * seen.coords["u"]
            middles = edges.reshape(-1)[:-1].reshape(-1, joined).mean(axis=1) + (edges[1] - edges[0]) / 2
            u = (edges[1:] + edges[:-1]) / 2
            axes.plot(u, level * edge_profile(distance), color=BLUE, lw=3, label="share of the lens")
            axes.plot(u, level * (u > 0), "--", color=MUTED, lw=2.5, label="through a pinhole")
            axes.plot(middles, groups, "o", color=BLUE, ms=7, mec="white", label="film")
            c = 1000 * FOCAL / STOP * abs(distance - FOCUS) / distance
            axes.set_title(f"edge at {distance:g} m: c = {c:.1f} mm")
            axes.set(
                xlabel="place in the picture u  [1/1000]",
                ylabel=r"L  [W m$^{-2}$ sr$^{-1}$]",
                ylim=(-4, 1.45 * level),
            )
            axes.legend(loc="upper left")


def draw_size(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The width of a panel in two pictures, by distance."""
    from transport.viz.style import BLUE, VERMILLION, figure

    fine = np.linspace(0.9, 4.3, 100)
    with figure((12, 8.2), f"A panel of {WIDTH:g} m, ever further away", note, path) as page:
        axes = page.subplots()
        for name, curve, colour, mark in (
            ("orthographic", WIDTH + 0 * fine, BLUE, "o"), ("pinhole", WIDTH / fine, VERMILLION, "s"),
        ):  # fmt: skip
            rows = [o[f"width, {name}"].estimate for o in outcomes]
            unit = "width [m]" if name == "orthographic" else "width/d"
            axes.plot(fine, curve, color=colour, lw=3)
            axes.errorbar([o.given["distance"] for o in outcomes], [r.value for r in rows], [r.error for r in rows],
                          fmt=mark, color=colour, ms=22 if name == "orthographic" else 13, label=f"{name}: {unit}")  # fmt: skip
        axes.set(xlabel="distance d  [m]", ylabel="width in the picture", ylim=(0, 0.75))
        axes.legend(loc="upper right")


def draw_wide(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Where a direction lies in the picture, by lens."""
    from transport.viz.style import BLUE, GREEN, VERMILLION, figure

    outcome, fine = outcomes[0], np.linspace(0, 89.5, 200)
    with figure((12.5, 8.6), "Where a lamp lies in the picture", note, path) as page:
        axes = page.subplots()
        for lens, colour, mark in zip(WIDE, (VERMILLION, BLUE, GREEN), "so^", strict=True):
            rule, words = LAW_OF_PLACE[lens]
            axes.plot(fine, rule(np.radians(fine)), color=colour, lw=3)
            rows = [outcome[f"r at {a}°, {lens}"].estimate for a in AT]
            axes.errorbar(AT, [r.value for r in rows], [r.error for r in rows], fmt=mark, color=colour, ms=13,
                          label=f"{lens}: r = {words}")  # fmt: skip
        axes.set(
            xlabel="angle θ of the lamp off the axis  [°]",
            ylabel="distance r from the middle",
            xlim=(0, 92),
            ylim=(0, 2.6),
        )
        axes.legend(loc="upper left")


def draw_foci(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Three boards in three foci, in grey."""
    from transport.viz.style import figure

    outcome = outcomes[0]
    level = outcome.given["radiance"]
    with figure((21, 5.6), "What is in focus is sharp", note, path) as page:
        for k, (axes, distance) in enumerate(zip(page.subplots(1, 3), BOARDS, strict=True), 1):
            axes.imshow(outcome.result[f"focus {k}"].image(), cmap="gray", vmin=0, vmax=level)
            axes.set_title(f"focus at {distance:g} m"), axes.set(xticks=[], yticks=[]), axes.grid(False)


draw = figures(
    **{
        show: (drawing, where(show=show))
        for show, drawing in zip(
            SHOWS, (draw_room, draw_film, draw_edge, draw_size, draw_wide, draw_foci), strict=True
        )
    }
)


if __name__ == "__main__":
    main(__file__)
