"""Geometry: distant, tiny and huge spheres; grazing rays; narrow gaps; corners; distant positions."""

from __future__ import annotations

import math

import numpy as np

import transport as tp
from transport.verification.hard.cases import CaseResult, case

INK = tp.Medium(absorption=1.0)
GLOW = tp.Lambertian(power=1.0)
CLEAR = tp.Transparent()
PANE_PAIR, PANE = 6 / 7, 12 / 13  # transmittance of four faces that reflect 4 %, all orders, and of two


def _run(scene: tp.Scene, particles: int = 64) -> tp.Result:
    return tp.simulate(scene, particles, seed=1, progress=False)


def _beam(start: tuple, direction: tuple) -> tp.Source:
    return tp.Source(tp.Point(position=tuple(start)), tp.Beam(tuple(direction), power=1.0))


def _absorbed(scene: tp.Scene, particles: int = 64) -> float:
    ledger = _run(scene, particles).ledger
    return ledger["absorbed"].value if ledger["lost"].value == 0 else math.nan


def _escaped(scene: tp.Scene, particles: int) -> float:
    ledger = _run(scene, particles).ledger
    return ledger["escaped"].value if ledger["lost"].value == 0 else math.nan


# ---- spheres ----


@case("what a lamp sends into a ball 1e12 radii away", naive="the discriminant b² - (o² - r²)")
def far_ball() -> CaseResult:
    """r² is 1e-24 of o² and vanishes in the sum: every ray misses."""
    ball = tp.Sphere(center=(0.6, 0.8, 0), radius=1e-12)
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0), aim=ball)
    found = _absorbed(tp.Scene(lamp, tp.Surface(ball, tp.Black())), 2000)
    discriminant = 1.0 - (0.6**2 + 0.8**2 - 1e-24)
    return CaseResult(found, 2.5e-25, naive=2.5e-25 * (discriminant > 0))


@case("a slanting way through fog, down to a ground of radius 1e12 a metre below", naive="c = o² - r²")
def huge_ball() -> CaseResult:
    """o and r agree in 12 digits, their squares in all but the last four: c is accurate to 1e-4 only."""
    radius, cosine = 1e12, math.sqrt(0.5)
    ground = tp.Surface(tp.Sphere(center=(0, 0, -radius), radius=radius), tp.Black(), "ground")
    scene = tp.Scene(_beam((0, 0, 1), (1, 0, -1)), ground, tp.Detector("ground", "meter"), medium=INK)
    b, c = (radius + 1) * cosine, 2 * radius + 1
    naive = b - math.sqrt(b * b - ((radius + 1) ** 2 - radius**2))
    exact = math.exp(-c / (b + math.sqrt(b * b - c)))
    return CaseResult(_run(scene)["meter"].flux_in.value, exact, math.exp(-naive), within=1e-9)


@case("a ray that dips 1e-12 into a ball, from 1000 radii away", naive="the discriminant b² - (o² - r²)")
def grazing_from_within() -> CaseResult:
    """The chord is 2.8e-6 long; its square is less than the rounding of 1000²."""
    height = 1 - 1e-12
    ball = tp.Surface(tp.Sphere(radius=1.0), CLEAR, inside=INK)
    chord = 2 * math.sqrt((1 - height) * (1 + height))
    discriminant = 1e6 - (1e6 + height**2 - 1)
    naive = -math.expm1(-2 * math.sqrt(max(discriminant, 0)))
    return CaseResult(
        _absorbed(tp.Scene(_beam((-1e3, height, 0), (1, 0, 0)), ball)), -math.expm1(-chord), naive, 1e-5
    )


@case("a ray that passes 1e-12 beside a ball, from 1000 radii away", naive="the same discriminant in float32")
def grazing_from_outside() -> CaseResult:
    """In float32 the ray touches the sphere: rays that miss and rays that hit are indistinguishable."""
    ball = tp.Surface(tp.Sphere(radius=1.0), tp.Black())
    scene = tp.Scene(_beam((-1e3, 1 + 1e-12, 0), (1, 0, 0)), ball)
    return CaseResult(_absorbed(scene), 0.0, naive=float(np.float32(1 + 1e-12) <= 1), within=0)


@case(
    "light that runs along the inside of a mirror ball at 1e-6 rad",
    naive="intersections nearer than 1e-4 are ignored",
)
def whispering_gallery() -> CaseResult:
    """Successive reflections are 2e-6 apart. A tracer that ignores near intersections leaves the sphere
    at the first reflection.
    """
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Mirror(0.9), "wall")
    scene = tp.Scene(
        _beam((0, math.sqrt(1 - 1e-12), 0), (1, 0, 0)), wall, tp.Detector("wall", "meter", side="inside")
    )
    return CaseResult(_run(scene, 20_000)["meter"].flux_in, 10.0, naive=0.0)


@case("two balls of fog that touch, and a ray through the point", naive="the second ball begins at t > 1e-9")
def touching_balls() -> CaseResult:
    """Leaving one sphere and entering the other occur at the same distance."""
    direction = np.array([0.3, 1.0, -1.0]) / math.sqrt(2.09)
    balls = [
        tp.Surface(tp.Sphere(center=tuple(side * direction), radius=1.0), CLEAR, inside=INK)
        for side in (1, -1)
    ]
    return CaseResult(
        _absorbed(tp.Scene(_beam(3 * direction, -direction), balls)), -math.expm1(-4), naive=-math.expm1(-2)
    )


# ---- gaps ----


@case("a shell of fog 1e-9 thick, crossed aslant", naive="both radii in float32")
def nested_shells() -> CaseResult:
    """In float32 the shell does not exist; in double its thickness has seven digits."""
    gap, fog = 1e-9, tp.Medium(absorption=1e9)
    core = tp.Surface(tp.Sphere(radius=1.0), tp.Black(), "core", outside=fog)
    shell = tp.Surface(tp.Sphere(radius=1 + gap), CLEAR, inside=fog)
    across = math.hypot(0.3, 0.1)
    path = gap * (2 + gap) / (math.sqrt((1 + gap) ** 2 - across**2) + math.sqrt(1 - across**2))
    scene = tp.Scene(_beam((2, 0.3, 0.1), (-1, 0, 0)), [core, shell], tp.Detector("core", "meter"))
    return CaseResult(_run(scene)["meter"].flux_in.value, math.exp(-path / gap), naive=1.0, within=1e-6)


@case("light from a ball in a diffuse shell 1e-12 about it", naive="rays start 1e-9 off their surface")
def nested_walls() -> CaseResult:
    """A start 1e-9 off the sphere lies outside the shell: no light returns."""
    walls = [
        tp.Surface(tp.Sphere(radius=1.0), tp.Black(), "ball"),
        tp.Surface(tp.Sphere(radius=1 + 1e-12), tp.Diffuse(0.5)),
    ]
    result = _run(tp.Scene(tp.Source("ball", GLOW), walls, tp.Detector("ball", "meter")), 2000)
    return CaseResult(
        result["meter"].flux_in.value + result.ledger["escaped"].value, 0.5, naive=0.0, within=1e-9
    )


def _panes(gap: float, height: float) -> tp.Scene:
    middles = (height - 0.5, height - 1.5 - gap)
    panes = [tp.Surface(tp.Slab(center=(0, 0, z), thickness=1.0), tp.Dielectric(1.5)) for z in middles]
    below = tp.Detector(tp.Plane(center=(0, 0, height - 3)), "below", side="back")
    return tp.Scene(_beam((0, 0, height + 1), (0, 0, -1)), panes, below)


@case("two panes of glass with 1e-12 of air between them", naive="rays start 1e-9 beyond a face")
def thin_gap() -> CaseResult:
    """A start 1e-9 beyond a face lies in the other pane: two reflecting faces remain instead of four."""
    return CaseResult(_run(_panes(1e-12, 0.0), 50_000)["below"].flux_out, PANE_PAIR, naive=PANE)


@case("the same with a gap of 1e-4, a billion off the origin", naive="coordinates in float32")
def thin_gap_far_off() -> CaseResult:
    """Coordinates there have steps of 1e-7 in double, of 64 in float32, where both panes and the lamp
    coincide.
    """
    return CaseResult(_run(_panes(1e-4, 1e9), 50_000)["below"].flux_out, PANE_PAIR, naive=PANE)


@case(
    "the same with a gap of eight roundings of its coordinates",
    naive="four faces in an order that rounding decides",
)
def gap_of_roundings() -> CaseResult:
    """At 1e9 a gap of 1e-6 is eight steps of a double. Rejected; the message names the cure."""
    try:
        _run(_panes(1e-6, 1e9))
    except tp.SceneError as refusal:
        return CaseResult(
            float("overlap on one plane; define the common face once" in str(refusal)), 1.0, PANE
        )
    return CaseResult(math.nan, 1.0, PANE)


# ---- corners and places ----


@case(
    "a beam into the exact corner of three walls", naive="an intersection must lie within the wall's bounds"
)
def corner_of_three() -> CaseResult:
    """By rounding the corner lies beyond the edges of all three walls, and the beam leaves the box."""
    turn, _ = np.linalg.qr(np.array([[1.0, 0.3, 0.2], [0.1, 1.0, -0.4], [-0.2, 0.5, 1.0]]))
    walls = [
        tp.Surface(
            tp.Rectangle(center=side * axis, normal=side * axis, up=turn[:, k - 1], width=2.0, height=2.0),
            tp.Mirror(0.5),
        )
        for k, axis in enumerate(turn.T)
        for side in (1, -1)
    ]
    corners = [turn @ np.array([x, y, z]) for x in (1, -1) for y in (1, -1) for z in (1, -1)]
    beams = [_beam(0.1 * turn[:, 0], corner - 0.1 * turn[:, 0]) for corner in corners]
    return CaseResult(_escaped(tp.Scene(beams, walls), 8000), 0.0, within=0)


@case("a ball that shines, a billion radii off the origin", naive="rays start 1e-9 off the ball")
def far_off_the_origin() -> CaseResult:
    """1e-9 is less than the step of a coordinate there: the sphere is hit by half of its own light."""
    ball = tp.Surface(tp.Sphere(center=(1e9, -3e8, 2e8), radius=1.0), tp.Black(), "ball")
    return CaseResult(_escaped(tp.Scene(tp.Source("ball", GLOW), ball), 20_000), 1.0)
