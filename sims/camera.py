"""A pinhole camera in a room, and a map of all directions in a white sphere: radiance where it is known exactly.

Derivation.  A camera's pixel is the mean radiance over its solid angle.  Along a ray radiance stays (first law of
radiometry: Cornell CS 6620, lecture 2), so a pixel that a lamp of radiance L fills reads L, however far away it is; a
mirror of reflectance R keeps the rays, and the lamp seen in a mirror ball reads R L, however small and bent it looks.
In a sphere of area A, of which the share f is a diffuse wall of albedo ρ and the rest a black lamp of power Φ, reflected
light is the same everywhere, L = ρ Φ/(π A(1 - ρ f)) (Ulbricht 1900; Jacquez and Kuppenheim 1955): every bin of an
environment map that does not see the lamp reads it, from any place.

Scene.  The lamp hangs a little below the ceiling, black where it does not shine: a source without a surface would be
looked through, at what is lit behind it.  In the room are a box, a mirror ball, a ball of glass and a glossy one; histories start at
the pinhole, a number of them in every pixel, and run backwards.  They know nothing of the lamp but by coming to it, or
by the rays that diffuse walls send there: smooth walls cost little, what only the glass ball lights costs most.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import constant, figures, furthest, main, of_scene, one_of
from transport.verification.experiment import Outcome

law = "L along a ray, R L by a mirror (first law of radiometry); L = ρ Φ/(π A(1 - ρ f)) in a diffuse sphere (Ulbricht 1900)"
question = "Does a camera read the radiance of what it looks at?"
particles = 3_000_000
intended = {
    "bins": "single pixels of the picture are grainy; the rows are means over many pixels",
}

RADIANCE, MIRROR = 100.0, 0.95  # W m^-2 sr^-1 of the lamp; of the ball
LAMP = tp.Rectangle(center=(0, 0.3, 2.45), normal=(0, 0, -1), width=1.6, height=2.0)
BALL = tp.Sphere(center=(0.7, 0.5, 0.55), radius=0.5)
RADIUS, CAP, ALBEDO = 1.0, 0.99, 0.8  # of the sphere; cosine from which on it is lamp; of the rest
BRIGHTER = 5  # the lamp than what the picture shows as white
GLASS, GLOSS = (tp.Sphere(center=(x, -0.7, 0.3), radius=0.28) for x in (-0.45, 1.1))
DIRECT, MIRRORED, SPHERE = "lamp", "lamp in the mirror ball", "radiance of the wall"


def cases() -> list[dict[str, str]]:
    return [{"place": "room"}, {"place": "sphere"}]


def scene(place: str = "room", width: int = 120, height: int = 90) -> tp.Scene:
    """place: a "room" with a camera of so many pixels, or a white "sphere" with an environment map."""
    one_of("camera", place=(place, ("room", "sphere")))
    if place == "sphere":
        return _sphere()
    return tp.Scene(tp.Source("lamp", tp.Lambertian(radiance=RADIANCE)), _room(), _camera(width, height))


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    if "map" in result:
        lower = result["map"].radiance[8:]  # half of the bins
        return {SPHERE: lower.sum("theta").sum("phi") / constant(result, 8.0 * 8.0, "1")}
    view = result["view"]
    direct, mirrored = pixel_of_lamp(view.detector), pixel_of_mirrored_lamp(view.detector)
    return {DIRECT: view.radiance[direct], MIRRORED: view.radiance[mirrored]}


@of_scene(scene)
def exact(place: str) -> dict[str, float]:
    if place == "room":
        return {DIRECT: RADIANCE, MIRRORED: MIRROR * RADIANCE}
    area, lamp = 4 * math.pi * RADIUS**2, 2 * math.pi * RADIUS**2 * (1 - CAP)
    power = math.pi * RADIANCE * lamp
    return {SPHERE: ALBEDO * power / (math.pi * area * (1 - ALBEDO * (1 - lamp / area)))}


def verdict(outcomes: list[Outcome]) -> str:
    return f"It does, straight, by a mirror and by way of white walls: {furthest(outcomes)}."


def draw_view(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The room as a photograph, in grey, with the names of what stands in it, and the error of every pixel beside it."""
    from matplotlib.colors import PowerNorm

    from transport.viz.maps import plot_map
    from transport.viz.style import figure

    result = outcomes[0].result
    if "map" in result:
        title = "A white sphere: the same radiance from every wall"
        plot_map(result["map"], path, decades=2.5, title=title, note=note)
        return
    view = result["view"]
    with figure((23, 9.6), "A room, by histories that start at the camera", note, path) as page:
        image, errors = page.subplots(1, 2, width_ratios=(1.25, 1))
        plot_map(view, ax=(image, errors), norm=PowerNorm(1 / 2.2, 0, RADIANCE / BRIGHTER, clip=True))
        for drawn in (*image.images, *image.collections):
            drawn.set_cmap("gray")
        _name_things(image, view.detector)


def _name_things(axes, camera: tp.Camera) -> None:
    """The names of the three balls, where the camera sees them."""
    from transport.viz.style import outlined

    left, up, forward = (np.array(axis) for axis in camera.frame)
    for name, ball in (("mirror", BALL), ("glass", GLASS), ("glossy", GLOSS)):
        apart = np.array(ball.center) - camera.position
        seen = np.array([-(apart @ left), apart @ up]) / (apart @ forward)
        style = {"color": "white", "fontsize": 22, "ha": "center", "va": "center", "path_effects": outlined()}
        axes.text(*seen, name, **style)


draw = figures(view=draw_view)


def pixel_of_lamp(camera: tp.Camera) -> tuple[int, int]:
    """The pixel that looks at the middle of what is seen of the lamp."""
    return _middle(_on_lamp(np.array(camera.position), _rays(camera)))


def pixel_of_mirrored_lamp(camera: tp.Camera) -> tuple[int, int]:
    """The pixel that looks at the middle of the lamp in the mirror ball."""
    rays, start = _rays(camera), np.array(camera.position)
    apart = np.array(BALL.center) - start
    along = rays @ apart
    half = BALL.radius**2 - (apart @ apart - along**2)
    place = start + (along - np.sqrt(np.maximum(half, 0)))[..., None] * rays
    normal = (place - np.array(BALL.center)) / BALL.radius
    mirrored = rays - 2 * np.sum(rays * normal, axis=-1)[..., None] * normal
    return _middle(_on_lamp(place, mirrored) & (half > 0))


def _rays(camera: tp.Camera) -> np.ndarray:
    """Unit vectors through the middles of the pixels, (v, u, 3)."""
    left, up, forward = (np.array(axis) for axis in camera.frame)
    v, u = (0.5 * (edges[1:] + edges[:-1]) for edges in camera.edges().values())
    rays = forward + v[:, None, None] * up - u[None, :, None] * left
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def _on_lamp(start: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Which rays meet the lamp."""
    with np.errstate(divide="ignore", invalid="ignore"):
        way = (LAMP.center[2] - start[..., 2]) / rays[..., 2]
        x, y = (start[..., k] + way * rays[..., k] - LAMP.center[k] for k in (0, 1))
    return (way > 0) & (np.abs(x) < LAMP.width / 2) & (np.abs(y) < LAMP.height / 2)


def _middle(hits: np.ndarray) -> tuple[int, int]:
    """The pixel among these that has most of them about itself."""
    inner = hits.astype(int)
    for axis in (0, 1):
        inner = sum(np.roll(inner, step, axis) for step in (-1, 0, 1))
    places = np.argwhere(inner * hits == (inner * hits).max())
    v, u = places[len(places) // 2]
    return int(v), int(u)


def _camera(width: int, height: int) -> tp.Camera:
    ahead = {"position": (0.1, -2.3, 1.4), "look_at": (0, 0.5, 0.95), "field_of_view": 70 * tp.deg}
    return tp.Camera(name="view", pixels=(width, height), **ahead)


def _room() -> list[tp.Surface]:
    albedos = {"-x": 0.3, "+x": 0.5}
    walls = tp.Box(center=(0, 0, 1.25), size=(4, 5, 2.5)).faces().items()
    box = tp.Box(center=(-0.8, 0.7, 0.5), size=(0.8, 0.8, 1.0)).faces().items()
    return [
        *(tp.Surface(face, tp.Diffuse(albedos.get(name, 0.7)), f"wall {name}") for name, face in walls),
        *(tp.Surface(face, tp.Diffuse(0.6), f"box {name}") for name, face in box if name != "-z"),
        tp.Surface(LAMP, tp.Black(), "lamp"),
        tp.Surface(BALL, tp.Mirror(MIRROR), "mirror"),
        tp.Surface(GLASS, tp.Dielectric(1.5), "glass"),
        tp.Surface(GLOSS, tp.Glossy(0.25, 0.9), "gloss"),
    ]


def _sphere() -> tp.Scene:
    """A sphere whose top is a lamp, black where it shines, and a map a little off its middle."""
    top = tp.Surface(tp.Sphere(radius=RADIUS, mu_min=CAP), tp.Black(), "top")
    rest = tp.Surface(tp.Sphere(radius=RADIUS, mu_max=CAP), tp.Diffuse(ALBEDO), "rest")
    source = tp.Source("top", tp.Lambertian(radiance=RADIANCE), side="back")
    return tp.Scene(
        source, [top, rest], tp.EnvironmentMap(name="map", position=(0.3, 0, -0.2), theta=16, phi=8)
    )


if __name__ == "__main__":
    main(__file__)
