"""Scenes in which light reaches a small detector, "m", by a mirror, gloss, glass or a window, with what is exact about them.

Each scene has a twin in which its specular object stands where no light comes by it to the detector.  A `Case` knows the irradiance and of
what classes of light it is made, so that it can be said beforehand which estimator may miss which of them.

Derivations.  A flat mirror: the lamp's mirror image shines through it, times the reflectance.  Irradiance by a disk of equal radiance is the
contour integral of Lambert (1760) along its rim, averaged over the detector by Gauss's rule.  Gloss and diffuse panels: Gauss's rule over
panel, lamp and detector.  The dish: each point of a detector near the focus sees the whole dish as bright as the lamp, so that the
irradiance is pi L times the view factor from the detector to the rim of the dish (two coaxial disks).  The window of black
walls: Lambert's contour integral along its four edges.  The ball of glass and the window of white walls have no formula: stored are runs.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial

import numpy as np

import transport as tp
from transport.scene.materials import Material
from transport.theory import microfacets, view_factors

RADII = (1e-3, 1e-2, 1e-1)  # of detectors [m]
DISH_RADII = (1e-3, 1e-2, 5e-2)
ESTIMATORS = ("analog", "aimed", "expected", "backward")

LAMP, POWER = 0.05, 100.0  # [m], [W]
RADIANCE = POWER / (math.pi * math.pi * LAMP**2)
PLACE = np.array((1.5, 0.0, -0.5))  # of the detector, which faces -x
LAMP_PLACE, IMAGE_PLACE = np.array((0.0, 0.0, 1.9)), np.array((-2.0, 0.0, 1.9))  # the mirror is at x = -1
HALF = 1.5  # of the panel's width [m]


@dataclass(frozen=True)
class Light:
    """One class of paths: the irradiance that it brings, and how many scores of it a history makes on average, by estimator.

    rates: infinite where the estimator connects the class exactly; estimators that are left out connect it.
    """

    value: float
    rates: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Case:
    """A scene for detectors of several radii.

    value: irradiance and its error (0: exact), by radius [W m^-2];  lights: its classes, by radius;  histories: what share of a
    benchmark's histories it needs, of which each takes long.
    """

    name: str
    scene: Callable[[float], tp.Scene]
    value: Callable[[float], tuple[float, float]]
    lights: Callable[[float], list[Light]]
    radii: tuple[float, ...] = RADII
    histories: float = 1.0


# ---- what is exact ----


def disk_nodes(radius: float, rings: int = 8, turns: int = 16) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (u, v) and weights, which add up to 1, of a rule for means over a disk."""
    nodes, weights = np.polynomial.legendre.leggauss(rings)
    r, share = radius * (nodes + 1) / 2, weights * (nodes + 1) / 2
    phi = 2 * math.pi * (np.arange(turns) + 0.5) / turns
    u, v = np.outer(r, np.cos(phi)).ravel(), np.outer(r, np.sin(phi)).ravel()
    return u, v, np.repeat(share / turns, turns)


def detector_nodes(radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Points on the detector at PLACE, and their weights."""
    u, v, share = disk_nodes(radius, 6, 12)
    return PLACE + np.stack([np.zeros_like(u), u, v], axis=1), share


def contour_irradiance(points: np.ndarray, normal: tuple[float, float, float], rim: np.ndarray) -> np.ndarray:
    """Irradiance at points from a polygon of radiance 1, all of which lies before them: Lambert's sum over its edges.

    rim: corners, seen from the points in the sense in which the result is positive.  E = 1/2 sum_k angle_k (n . g_k).
    """
    to = rim[None] - points[:, None]
    to /= np.linalg.norm(to, axis=2, keepdims=True)
    after = np.roll(to, -1, axis=1)
    cross = np.cross(to, after)
    size = np.linalg.norm(cross, axis=2)
    angle = np.arctan2(size, (to * after).sum(axis=2))
    return 0.5 * ((cross @ np.array(normal)) * angle / size).sum(axis=1)


def disk_irradiance(
    points: np.ndarray, normal: tuple[float, float, float], center: np.ndarray, radius: float
) -> np.ndarray:
    """The same of a horizontal disk: polygons of 512 and 1024 corners, extrapolated (the error falls as their number^-2)."""

    def by(corners: int) -> np.ndarray:
        phi = 2 * math.pi * np.arange(corners) / corners
        rim = center + radius * np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=1)
        return np.abs(contour_irradiance(points, normal, rim))

    return (4 * by(1024) - by(512)) / 3


@cache
def by_disk(radius: float, center: tuple[float, float, float]) -> float:
    """Mean irradiance of the detector at PLACE by the lamp, were it there [W m^-2]."""
    points, share = detector_nodes(radius)
    return float(RADIANCE * (disk_irradiance(points, (-1.0, 0.0, 0.0), np.array(center), LAMP) * share).sum())


def direct(radius: float) -> float:
    """Irradiance by the lamp itself."""
    return by_disk(radius, tuple(LAMP_PLACE))


def mirrored(radius: float) -> float:
    """Irradiance by way of a perfect mirror."""
    return by_disk(radius, tuple(IMAGE_PLACE))


def by_point(radius: float, source: np.ndarray, power: float = POWER) -> float:
    """Irradiance by a point: the mean of P cos / (4 pi d^2)."""
    points, share = detector_nodes(radius)
    to = points - source
    d2 = (to**2).sum(axis=1)
    return float((power / (4 * math.pi) * to[:, 0] / d2**1.5 * share).sum())


def panel_nodes() -> tuple[np.ndarray, np.ndarray]:
    """Points on the panel and their areas [m^2], dense about the place where a mirror would show the lamp."""
    place = 1.9 - 2.4 * 1.0 / 3.5
    steps = np.array([0.0, 0.03, 0.07, 0.13, 0.22, 0.36, 0.6, 1.0, 1.5])
    y, wy = _rule(np.concatenate([-steps[:0:-1], steps]))
    z, wz = _rule(np.unique(np.clip(np.concatenate([place - 2 * steps, place + steps]), -HALF, HALF)))
    points = np.stack(np.broadcast_arrays(-1.0, y[:, None], z[None, :]), axis=-1).reshape(-1, 3)
    return points, np.outer(wy, wz).ravel()


def _rule(edges: np.ndarray, order: int = 8) -> tuple[np.ndarray, np.ndarray]:
    """Gauss's rule on each of the intervals."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    half = np.diff(edges) / 2
    places = (edges[:-1] + half)[:, None] + half[:, None] * nodes
    return places.ravel(), (half[:, None] * weights).ravel()


@cache
def by_panel(radius: float, law: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> float:
    """Irradiance by way of a panel whose f [sr^-1] is law(to the lamp, to the detector), unit vectors from the panel, whose normal is x."""
    panel, areas = panel_nodes()
    u, v, lamp_share = disk_nodes(LAMP, 3, 8)
    lamp = LAMP_PLACE + np.stack([u, v, np.zeros_like(u)], axis=1)
    points, share = detector_nodes(radius) if radius > 0.02 else (PLACE[None], np.ones(1))
    total = 0.0
    for place, lamp_weight in zip(lamp, lamp_share, strict=True):
        to_lamp, d2 = _towards(panel, place)
        arriving = RADIANCE * math.pi * LAMP**2 * lamp_weight * to_lamp[:, 0] * to_lamp[:, 2] / d2
        for point, weight in zip(points, share, strict=True):
            to_point, r2 = _towards(panel, point)
            total += weight * float(
                (areas * arriving * law(to_lamp, to_point) * to_point[:, 0] ** 2 / r2).sum()
            )
    return total


def _towards(places: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors from places to a point, and squared distances."""
    to = point - places
    d2 = (to**2).sum(axis=1)
    return to / np.sqrt(d2)[:, None], d2


def diffuse_law(to_lamp: np.ndarray, to_point: np.ndarray) -> np.ndarray:
    """Lambert's, of albedo 1."""
    return np.full(len(to_lamp), 1 / math.pi)


def glossy_law(to_lamp: np.ndarray, to_point: np.ndarray) -> np.ndarray:
    """The law of Glossy(0.05)."""
    one, other = (np.arctan2(to[:, 2], to[:, 1]) for to in (to_lamp, to_point))
    return microfacets.brdf(to_lamp[:, 0], to_point[:, 0], one - other, 0.05)


# ---- the lamp and the panel ----


def lamp() -> tp.Source:
    """A disk of 5 cm that shines down."""
    return tp.Source(
        tp.Disk(center=tuple(LAMP_PLACE), normal=(0, 0, -1), radius=LAMP), tp.Lambertian(power=POWER)
    )


def point_lamp() -> tp.Source:
    """A point in its place."""
    return tp.Source(tp.Point(position=tuple(LAMP_PLACE)), tp.Isotropic(power=POWER))


def panel_scene(radius: float, source: tp.Source, material: Material, is_behind: bool) -> tp.Scene:
    """A lamp, a square panel at x = -1, or behind the detector at x = 3, and the detector."""
    place = (3.0 if is_behind else -1.0, 0.0, 0.0)
    square = tp.Rectangle(center=place, normal=(1, 0, 0), up=(0, 0, 1), width=2 * HALF, height=2 * HALF)
    disk = tp.Disk(center=tuple(PLACE), normal=(-1, 0, 0), radius=radius)
    return tp.Scene([source], [tp.Surface(square, material, "panel")], [tp.Detector(disk, "m")])


def panel_lights(radius: float, material: Material, is_behind: bool) -> list[Light]:
    """Direct light; what the panel mirrors; what it scatters, or reflects glossily."""
    found = [_light(direct(radius), radius, None, None)]
    if is_behind:
        return found
    parts = material.parts if isinstance(material, tp.Mixture) else [(material, 1.0)]
    for part, share in parts:
        if isinstance(part, tp.Mirror):
            kind, value = "specular", part.reflectance * mirrored(radius)
        elif isinstance(part, tp.Glossy):
            kind, value = "connected", part.albedo * by_panel(radius, glossy_law)
        else:
            kind, value = "connected", part.albedo * by_panel(radius, diffuse_law)
        found.append(_light(share * value, radius, kind, kind))
    return found


def point_lights(radius: float, is_behind: bool) -> list[Light]:
    """The same of the point, to which no history from the detector comes."""
    found = [_light(by_point(radius, LAMP_PLACE), radius, None, None, None)]
    if not is_behind:
        found.append(_light(by_point(radius, IMAGE_PLACE), radius, "specular", "specular", None))
    return found


def _light(
    value: float,
    radius: float,
    first: str | None,
    last: str | None,
    radiance: float | None = RADIANCE,
    power: float = POWER,
) -> Light:
    """A class of paths by what it meets first behind the lamp, and last before the detector; power: of all lamps [W].

    Rays connect diffuse and glossy surfaces, not specular ones.
    """
    per_history = value * math.pi * radius**2 / power
    rates = {"analog": per_history}
    if last == "specular":
        rates["expected"] = per_history
    if first != "connected":
        rates["backward"] = value / (math.pi * radiance) if radiance else 0.0
    return Light(value, rates)


# ---- the dish ----

FOCAL, RIM, DISH_LAMP = 0.5, 0.3, 0.6  # [m]
SMALL_LAMP = 0.02
SMALL_PLACE = (0.6, 0.0, 0.05)
SMALL_POWER, DISH_POWER, BEAM_POWER = 10.0, 100.0, 1e-3


def dish_scene(radius: float, is_beam: bool, is_behind: bool) -> tp.Scene:
    """A paraboloid that gathers the light of a lamp, or of a beam, on a detector at its focus, which a small lamp lights directly."""
    place = (0.0, 0.0, 3.0 if is_behind else 0.0)
    dish = tp.Surface(tp.Paraboloid(center=place, focal_length=FOCAL, radius=RIM), tp.Mirror(1.0), "dish")
    wide = tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.25 if is_beam else DISH_LAMP)
    emission = tp.Beam((0, 0, -1), power=BEAM_POWER) if is_beam else tp.Lambertian(power=DISH_POWER)
    small = tp.Source(tp.Disk(center=SMALL_PLACE, radius=SMALL_LAMP), tp.Lambertian(power=SMALL_POWER))
    disk = tp.Disk(center=(0, 0, FOCAL), normal=(0, 0, -1), radius=radius)
    return tp.Scene([tp.Source(wide, emission), small], [dish], [tp.Detector(disk, "m")])


def dish_lights(radius: float, is_beam: bool, is_behind: bool) -> list[Light]:
    """What the dish gathers, and what the small lamp sends."""
    power = SMALL_POWER + (BEAM_POWER if is_beam else DISH_POWER)
    small = SMALL_POWER / (math.pi * math.pi * SMALL_LAMP**2)
    found = [_light(by_small_lamp(radius), radius, None, None, small, power)]
    if is_behind:
        return found
    if is_beam:
        return [
            *found,
            _light(BEAM_POWER / (math.pi * radius**2), radius, "specular", "specular", None, power),
        ]
    radiance = DISH_POWER / (math.pi * math.pi * DISH_LAMP**2)
    gathered = math.pi * radiance * view_factors.coaxial_disks(radius, RIM, FOCAL - RIM**2 / (4 * FOCAL))
    return [*found, _light(gathered, radius, "specular", "specular", radiance, power)]


@cache
def by_small_lamp(radius: float) -> float:
    """Direct irradiance of the detector at the focus."""
    u, v, share = disk_nodes(radius, 6, 12)
    points = np.stack([u, v, np.full_like(u, FOCAL)], axis=1)
    shape = disk_irradiance(points, (0.0, 0.0, -1.0), np.array(SMALL_PLACE), SMALL_LAMP)
    return float(SMALL_POWER / (math.pi * math.pi * SMALL_LAMP**2) * (shape * share).sum())


# ---- the ball of glass ----


def ball_scene(radius: float, is_behind: bool) -> tp.Scene:
    """A ball of glass gathers the light of a lamp in the ceiling on the floor of a diffuse room, or lies below that floor."""
    room = tp.Surface(tp.Box(size=4.0), tp.Diffuse(0.5), "room")
    ball = tp.Sphere(center=(0, 0, -3.5 if is_behind else 0.0), radius=0.7)
    source = tp.Source(tp.Disk(center=(0, 0, 1.9), normal=(0, 0, -1), radius=0.1), tp.Lambertian(power=POWER))
    disk = tp.Disk(center=(0, 0, -1.9), radius=radius)
    return tp.Scene(
        [source], [room, tp.Surface(ball, tp.Dielectric(1.5, 1.0), "ball")], [tp.Detector(disk, "m")]
    )


# ---- the window ----

SKY = 5e4  # [m]


def window_scene(radius: float, is_black: bool) -> tp.Scene:
    """A room lit by the sky through a window; of black walls only direct light comes in."""
    sky = tp.Surface(tp.Sphere(radius=SKY, mu_min=0, mu_max=1), tp.Black(), "sky")
    material = tp.Black() if is_black else tp.Diffuse(0.5)

    def wall(center: tuple, normal: tuple, hole: tp.Rectangle | None = None) -> tp.Surface:
        up = (0, 0, 1) if normal[2] == 0 else (0, 1, 0)
        shape = tp.Rectangle(center=center, normal=normal, up=up, width=4, height=4, hole=hole)
        return tp.Surface(shape, material)

    hole = tp.Rectangle(center=(0, 0, 2), normal=(1, 0, 0), up=(0, 0, 1), width=2, height=1)
    walls = [
        wall((0, 0, 2), (1, 0, 0), hole), wall((4, 0, 2), (-1, 0, 0)), wall((2, -2, 2), (0, 1, 0)),
        wall((2, 2, 2), (0, -1, 0)), wall((2, 0, 0), (0, 0, 1)), wall((2, 0, 4), (0, 0, -1)),
    ]  # fmt: skip
    source = tp.Source("sky", tp.Lambertian(radiance=1.0), side="back")
    disk = tp.Disk(center=(3.5, 0, 0.8), radius=radius)
    return tp.Scene([source], [sky, *walls], [tp.Detector(disk, "m")])


@cache
def by_window(radius: float) -> float:
    """Direct irradiance by the window, of radiance 1."""
    u, v, share = disk_nodes(radius, 6, 12)
    points = np.stack([3.5 + u, v, np.full_like(u, 0.8)], axis=1)
    rim = np.array([(0, -1, 1.5), (0, 1, 1.5), (0, 1, 2.5), (0, -1, 2.5)], dtype=float)
    return float(np.abs((contour_irradiance(points, (0.0, 0.0, 1.0), rim) * share).sum()))


# ---- the table ----

# Irradiance and its error, by radius [m], as run_of(scene, estimator, histories, seed=20260101) of tests/bench/trust_references.py gave them.
# By "backward", 1e8 histories, the first without a guide, 1e9 of seed 20261127; then the shares of light that met glass last before the detector, and glass or nothing first.  At 10 cm
# "analog", 1e8, gave 161.243 +- 0.079 and "expected", 3e7, 161.00 +- 0.14.
BALL = {
    1e-3: (189.075, 0.020, 0.994, 0.9948),
    1e-2: (189.054, 0.087, 0.994, 0.9948),
    1e-1: (161.238, 0.080, 0.994, 0.9940),
}
# By "expected", 3e7; then the share of direct light (two coaxial disks).  At 10 cm "analog", 3e7, gave 3.242 +- 0.017.
BALL_BEHIND = {
    1e-3: (3.25209, 0.00012, 0.0, 0.6774),
    1e-2: (3.25208, 0.00012, 0.0, 0.6774),
    1e-1: (3.25054, 0.00012, 0.0, 0.6774),
}
# By "backward", 5e7.  At 10 cm "analog" with the source's aim at the window, 1e8, gave 0.07581 +- 0.00051.
WINDOW = {1e-3: (0.076128, 6.5e-5), 1e-2: (0.076126, 6.5e-5), 1e-1: (0.076160, 6.5e-5)}


# A metal to which no light comes: in a scene with it no ray connects the light of a flat mirror.
UNLIT_METAL = tp.Surface(
    tp.Disk(center=(0, 0, 50), radius=1.0), tp.TwoSided(tp.Conductor(0.2, 3.4), tp.Black()), "metal"
)


def _sum(lights: Callable[[float], list[Light]]) -> Callable[[float], tuple[float, float]]:
    """The exact value of a scene of which all classes are known."""
    return lambda radius: (math.fsum(light.value for light in lights(radius)), 0.0)


def _exact(
    name: str,
    scene: Callable[[float], tp.Scene],
    lights: Callable[[float], list[Light]],
    radii: tuple[float, ...] = RADII,
) -> Case:
    return Case(name, scene, _sum(lights), lights, radii)


def _twins(name: str, scene: Callable, lights: Callable, radii: tuple[float, ...] = RADII) -> list[Case]:
    """A scene, and its twin, by functions of the radius and of whether its specular object stands aside."""
    return [
        _exact(
            name + is_behind * ", behind",
            partial(scene, is_behind=is_behind),
            partial(lights, is_behind=is_behind),
            radii,
        )
        for is_behind in (False, True)
    ]


def _panel(name: str, material: Material) -> list[Case]:
    scene = partial(panel_scene, source=lamp(), material=material)
    return _twins(name, scene, partial(panel_lights, material=material))


def _dish(name: str, is_beam: bool) -> list[Case]:
    return _twins(
        name, partial(dish_scene, is_beam=is_beam), partial(dish_lights, is_beam=is_beam), DISH_RADII
    )


def _stored(name: str, scene: Callable[[float], tp.Scene], values: dict, lights: Callable) -> Case:
    """A scene of which a long run is stored; values: irradiance, its error and more, by radius."""
    return Case(name, scene, lambda radius: values[radius][:2], lights, histories=0.5)


def _window_lights(radius: float, is_black: bool) -> list[Light]:
    """Direct light of the sky, and by way of the walls: "expected" connects the walls, but hardly any history comes to them."""
    power = math.pi * 2 * math.pi * SKY**2
    area = math.pi * radius**2
    sky = Light(
        by_window(radius),
        {"analog": by_window(radius) * area / power, "backward": by_window(radius) / math.pi},
    )
    if is_black:
        return [sky]
    rest = WINDOW[radius][0] - by_window(radius)
    return [sky, Light(rest, {"analog": rest * area / power, "expected": math.pi * 2 / power})]


def _ball_lights(radius: float, is_behind: bool) -> list[Light]:
    """What glass sends to the detector; what comes from the lamp directly or by glass: nearly all is the one and the other."""
    value, _, last, first = (BALL_BEHIND if is_behind else BALL)[radius]
    found = []
    power, area, radiance = POWER, math.pi * radius**2, POWER / (math.pi * math.pi * 0.1**2)
    by_glass = {"analog": value * last * area / power, "expected": value * last * area / power}
    if last:
        found.append(Light(value * last, by_glass))
    if first:
        found.append(Light(value * first, {"backward": value * first / (math.pi * radiance)}))
    rest = value * (1 - last)
    return [*found, Light(rest, {"analog": rest * area / power})]


CASES = {
    case.name: case
    for case in (
        *_panel("mirror", tp.Mirror(1.0)),
        *_panel("half mirror", tp.Mirror(0.5, 0.5)),
        *_panel("glossy", tp.Glossy(0.05, 0.9)),
        *_panel("mixture", tp.Mixture({tp.Mirror(0.9): 0.5, tp.Diffuse(0.8): 0.5})),
        *_twins(
            "point lamp", partial(panel_scene, source=point_lamp(), material=tp.Mirror(1.0)), point_lights
        ),
        *(
            _stored(
                "ball" + is_behind * ", behind",
                lambda radius, b=is_behind: ball_scene(radius, b),
                BALL_BEHIND if is_behind else BALL,
                lambda radius, b=is_behind: _ball_lights(radius, b),
            )
            for is_behind in (False, True)
        ),
        *_dish("dish, lamp", is_beam=False),
        *_dish("dish, beam", is_beam=True),
        _stored("window", lambda r: window_scene(r, False), WINDOW, lambda r: _window_lights(r, False)),
        _exact("window, black walls", lambda r: window_scene(r, True), lambda r: _window_lights(r, True)),
    )
}
