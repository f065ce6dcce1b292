"""Slivers, needles and extreme lengths: computed correctly, or rejected with a message."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

import transport as tp
from transport.theory import fresnel
from transport.verification.hard.cases import CaseResult, case

GLOW = tp.Lambertian(power=1.0)
CLEAR = tp.Transparent()
AXIS, MIDDLE = np.array([1.0, 2.0, 3.0]) / math.sqrt(14), np.array([3.0, -2.0, 1.0])


def _run(scene: tp.Scene, particles: int = 64) -> tp.Result:
    return tp.simulate(scene, particles, seed=1, progress=False)


def _beam(start: tuple, direction: tuple) -> tp.Source:
    return tp.Source(tp.Point(position=tuple(start)), tp.Beam(tuple(direction), power=1.0))


def _absorbed(scene: tp.Scene) -> float:
    ledger = _run(scene).ledger
    return ledger["absorbed"].value if ledger["lost"].value == 0 else math.nan


def _is_rejected(make: Callable[[], object], words: str) -> float:
    """1 if a SceneError contains these words, else 0."""
    try:
        make()
    except tp.SceneError as refusal:
        return float(words in str(refusal))
    return 0.0


# ---- slivers ----


@case("irradiance of a triangle of aspect 1e8 in a furnace", naive="its area by Heron's formula")
def sliver_triangle() -> CaseResult:
    """Half the perimeter minus the longest side is 1e-16 of it, a rounding error, and so is the area."""
    corners = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.3, 1e-8, 0.0))
    shape = tp.Triangle(vertices=corners)
    room = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="inside", aim=shape)
    result = _run(tp.Scene(room, detectors=tp.Detector(shape, "meter")), 100_000)
    a, b, c = (math.dist(corners[k], corners[k - 1]) for k in range(3))
    s = (a + b + c) / 2
    area = math.sqrt(max(s * (s - a) * (s - b) * (s - c), 0.0))
    naive = result["meter"].flux_in.value / area if area else math.nan
    return CaseResult(result["meter"].irradiance, math.pi, naive)


def _through_pane(pane: tp.Box | tp.Mesh) -> tp.Estimate:
    below = tp.Detector(tp.Plane(center=(0, 0, -1)), "below", side="back")
    scene = tp.Scene(_beam((0.1, 0.2, 0.5), (0.3, 0.1, -1)), tp.Surface(pane, tp.Dielectric(1.5)), below)
    return _run(scene, 50_000)["below"].flux_out


SLANT = 1 / math.sqrt(1.1)
ONE_FACE = float(fresnel.transmittance(SLANT, 1.5))


@case("through a pane of glass 1e-8 of its width, aslant", naive="faces nearer than 1e-6 are ignored")
def sliver_of_glass() -> CaseResult:
    """The second face is ignored, and all light that enters counts as transmitted."""
    exact = float(fresnel.plate_transmittance(SLANT, 1.5))
    return CaseResult(_through_pane(tp.Box(size=(1, 1, 1e-8))), exact, naive=ONE_FACE)


@case("through the same pane as a mesh", naive="facets nearer than 1e-6 are ignored")
def mesh_of_slivers() -> CaseResult:
    """Eight of its twelve triangles have an aspect ratio of 1e8."""
    exact = float(fresnel.plate_transmittance(SLANT, 1.5))
    return CaseResult(_through_pane(tp.Mesh.box(size=(1, 1, 1e-8))), exact, naive=ONE_FACE)


@case(
    "a black strip 1e-13 of its length",
    naive="edges widened by rounding: rays that pass beside it are absorbed",
)
def sliver_of_roundings() -> CaseResult:
    """Edges extend by the rounding of the intersection, here 1 % of the width. Rejected; the message
    gives the least width.
    """
    strip = tp.Surface(tp.Rectangle(width=1e-13, height=1.0), tp.Black(), "strip")
    scene = tp.Scene(_beam((0.505e-13, 0, 1), (0, 0, -1)), strip)
    return CaseResult(
        _is_rejected(lambda: _run(scene), "Surface 'strip': a flat surface here must be wider"), 1.0, 0.0
    )


# ---- needles ----


def _needle(radius: float, medium: tp.Medium, middle: np.ndarray, axis: np.ndarray) -> list[tp.Surface]:
    """A closed cylinder of length 1 filled with a medium."""
    side = tp.Cylinder(center=tuple(middle), axis=tuple(axis), radius=radius, height=1.0)
    lids = [
        tp.Disk(center=tuple(middle + end / 2 * axis), normal=tuple(end * axis), radius=radius)
        for end in (1, -1)
    ]
    return [
        tp.Surface(side, CLEAR, inside=medium),
        *(tp.Surface(lid, CLEAR, back=medium) for lid in lids),
    ]


@case("across a needle of fog of radius 1e-8", naive="b² - a c from the start of the ray")
def across_a_needle() -> CaseResult:
    """The squared distance to it is 1e16 times that of the chord: the discriminant is a rounding error."""
    radius = 1e-8
    fog = tp.Medium(absorption=1 / radius)
    needle = _needle(radius, fog, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    exact = -math.expm1(-math.sqrt(3 * 1.04))
    b2, c = 0.7**2, 0.7**2 + (radius / 2) ** 2 - radius**2
    naive = -math.expm1(-2 * math.sqrt(max(b2 - c, 0.0) * 1.04) / radius)
    scene = tp.Scene(_beam((0.7, radius / 2, 0.1), (-1, 0, 0.2)), needle)
    return CaseResult(_absorbed(scene), exact, naive, within=1e-7)


@case("along a needle of fog of radius 1e-8, anywhere, turned", naive="t = (-b - √d) / a, a = 1 - (u·axis)²")
def along_a_needle() -> CaseResult:
    """The ray is parallel to the side up to rounding: a is 0 or a rounding error, and t is not a number."""
    needle = _needle(1e-8, tp.Medium(absorption=1.0), MIDDLE, AXIS)
    return CaseResult(
        _absorbed(tp.Scene(_beam(MIDDLE + 0.9 * AXIS, -AXIS), needle)), -math.expm1(-1), naive=math.nan
    )


@case("a needle of radius 1e-300 and length 1", naive="division by radius²")
def vanishing_needle() -> CaseResult:
    """The square of its radius underflows to 0."""
    found = _is_rejected(
        lambda: tp.Cylinder(radius=1e-300, height=1.0), "squares of its lengths must not vanish"
    )
    return CaseResult(found, 1.0, naive=0.0)


@case("light that leaves the outside of a cone 1e-15 high", naive="the cone without a check")
def flat_cone() -> CaseResult:
    """The cone and its mirror image agree within rounding: 78 % of the light seemed to hit the cone
    again. Rejected.
    """
    found = _is_rejected(lambda: tp.Cone(radius=1.0, height=1e-15), "use a Disk for a flat shape")
    return CaseResult(found, 1.0, naive=0.22)


# ---- lengths ----


def _exitance_ratio(length: float) -> float:
    """Exitance measured by a detector on a disk of that radius, times its area, per emitted power."""
    disk = tp.Disk(radius=length)
    scene = tp.Scene(tp.Source(disk, GLOW), detectors=tp.Detector(disk, "meter"))
    return _run(scene, 2000)["meter"].exitance.value * disk.area


@case("the exitance of a disk of radius 1e-120", naive="r⁴, as in products of areas")
def tiny_lengths() -> CaseResult:
    """Areas are 1e-240, and their squares underflow to 0."""
    return CaseResult(_exitance_ratio(1e-120), 1.0, naive=1e-240 * 1e-240)


@case("the exitance of a disk of radius 1e120", naive="r⁴, as in products of areas")
def huge_lengths() -> CaseResult:
    """Areas are 1e240, and their squares overflow."""
    return CaseResult(_exitance_ratio(1e120), 1.0, naive=1e240 * 1e240)


@case("a ball of radius 1e-300", naive="an area of 0")
def vanishing_lengths() -> CaseResult:
    """No quantity per area is finite. Rejected; the message names the cure."""
    return CaseResult(
        _is_rejected(lambda: tp.Sphere(radius=1e-300), "Sphere: area must be positive and finite"), 1.0, 0.0
    )


@case("a strip of length 1e300", naive="an extent whose square is infinite")
def overflowing_lengths() -> CaseResult:
    """Its area is finite, but squared distances on it overflow. Rejected; the message gives the range."""
    strip = tp.Rectangle(width=1.0, height=1e300)
    scene = tp.Scene(tp.Source(strip, GLOW))
    return CaseResult(
        _is_rejected(lambda: _run(scene), "size must be between 1e-140 and 1e+140 m"), 1.0, math.nan
    )
