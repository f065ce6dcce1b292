"""Directions close to a pole, to the horizon and to each other."""

from __future__ import annotations

import math

import numpy as np

import transport as tp
from transport.verification.hard.cases import CaseResult, case

GLOW = tp.Lambertian(power=1.0)


def _run(scene: tp.Scene, particles: int = 2000) -> tp.Result:
    return tp.simulate(scene, particles, seed=1, progress=False)


def _beam(start: tuple, direction: tuple) -> tp.Source:
    return tp.Source(tp.Point(position=tuple(start)), tp.Beam(tuple(direction), power=1.0))


# ---- small solid angles ----


@case("a disk 1e9 radii away, seen by what a point lamp sends into it", naive="Ω = 2π (1 - cos θ)")
def far_disk() -> CaseResult:
    """cos θ rounds to 1 below θ = 1e-8, so that the difference is 0: no light at all."""
    meter = tp.Disk(center=(0, 0, 1e9), normal=(0, 0, -1), radius=1.0)
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0), aim=meter)
    found = _run(tp.Scene(lamp, detectors=tp.Detector(meter, "meter")))["meter"].flux_in
    naive = (1 - math.cos(1e-9)) / 2
    return CaseResult(found, 2.5e-19, naive)


@case(
    "a ball of 1e-13 m, 1e-12 above the horizon of a lamp that shines by the cosine",
    naive="cos θ from θ in float32",
)
def low_ball() -> CaseResult:
    """The cosine is 1e-12 and the solid angle 3e-26 sr. In float32, π/2 - 1e-12 lies beyond the horizon."""
    ball = tp.Sphere(center=(1.0, 0, 1e-12), radius=1e-13)
    lamp = tp.Source(tp.Disk(radius=1e-6), GLOW, aim=ball)
    scene = tp.Scene(lamp, tp.Surface(ball, tp.Black(), "ball"), tp.Detector("ball", "meter"))
    naive = 1e-26 * max(math.cos(float(np.float32(math.pi / 2 - 1e-12))), 0.0)
    return CaseResult(_run(scene, 20_000)["meter"].flux_in, 1e-38, naive)


def _under_a_lamp(angle: float, directions: tp.Directions) -> tp.Estimate:
    """Radiance in the first bin of a detector under a lamp of radiance 1 and half angle 2 `angle` [rad]."""
    disk = tp.Disk(radius=1e-4)
    lamp = tp.Disk(center=(0, 0, 1 / angle), normal=(0, 0, -1), radius=2.0)
    source = tp.Source(lamp, tp.Lambertian(radiance=1.0), aim=disk)
    scene = tp.Scene(source, detectors=tp.Detector(disk, "meter", directions=directions))
    return _run(scene, 50_000)["meter"].radiance[0]


@case("radiance within 1e-9 rad of the zenith", naive="a bin from cos 1e-9 to 1, whose width is 0")
def cone_at_the_pole() -> CaseResult:
    """All light falls outside the bin of width 0, and its radiance is 0/0."""
    return CaseResult(_under_a_lamp(1e-9, tp.Directions.cone((0, 0, 1), 1e-9)), 1.0, naive=math.nan)


@case("radiance in a bin of 1e-6 rad at the pole", naive="cosines in float32")
def bin_at_the_pole() -> CaseResult:
    """The edge is 1 - 5e-13: double precision resolves it to 1e-4; in float32 it equals 1."""
    return CaseResult(_under_a_lamp(1e-6, tp.Directions(theta=(0, 1e-6, 1.5))), 1.0, naive=math.nan)


@case("a bin of 1e-9 rad at the pole", naive="0/0, or a bin that is never hit")
def bin_below_rounding() -> CaseResult:
    """No double lies between the bin's edges. The bin is rejected, and the message names the alternative."""
    try:
        tp.Directions(theta=(0, 1e-9, 1.5))
    except tp.SceneError as refusal:
        return CaseResult(
            float("Directions.cone(axis, half_angle) resolves any angle" in str(refusal)), 1.0, math.nan
        )
    return CaseResult(0.0, 1.0, math.nan)


@case("radiance in a bin of 1e-12 rad at the horizon", naive="its edge as an angle in float32")
def bin_at_the_horizon() -> CaseResult:
    """A rim of that height emits all around. By the cosine law the bin holds 1e-24 of a hemisphere."""
    low, disk = 1e-12, tp.Disk(radius=1e-4)
    rim = tp.Cylinder(center=(0, 0, 2 * low), radius=1.0, height=4 * low)
    lamp = tp.Source(rim, tp.Lambertian(radiance=1.0), side="back", aim=disk)
    meter = tp.Detector(disk, "meter", directions=tp.Directions(mu=(0, low, 1)))
    found = _run(tp.Scene(lamp, detectors=meter), 100_000)["meter"].radiance[0]
    return CaseResult(found, 1.0, naive=(low / math.cos(float(np.float32(math.pi / 2 - low)))) ** 2)


@case("beams that meet a meter at a cosine of 1e-12, from above and below", naive="cosines below 1e-6 are 0")
def sides_at_the_horizon() -> CaseResult:
    """Whether a particle enters or leaves is the sign of a number close to 0, and a tilted plane has no
    round coordinates.
    """
    normal = np.array([1.0, 2.0, 3.0]) / math.sqrt(14)
    along = np.array([0.0, 3.0, -2.0]) / math.sqrt(13)
    beams = [
        _beam(-0.25 * direction, direction) for direction in (along - 1e-12 * normal, along + 1e-12 * normal)
    ]
    meter = tp.Detector(
        tp.Disk(radius=0.5, normal=normal), "meter", directions=tp.Directions(mu=(5e-13, 2e-12))
    )
    reading = (
        _run(tp.Scene(beams[:1], detectors=meter), 64)["meter"],
        _run(tp.Scene(beams[1:], detectors=meter), 64)["meter"],
    )
    return CaseResult(float(reading[0].counts[0].value + reading[1].flux_out.value), 65.0, naive=0.0)


@case("fluence in a furnace, one in 1e6 of its crossings below a cosine of 1e-3", naive="the mean of 1/|μ|")
def grazing_fluence() -> CaseResult:
    """1/|μ| has infinite variance, and is infinite for a ray in the plane."""
    disk = tp.Disk(radius=0.5)
    room = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="inside", aim=disk)
    result = _run(tp.Scene(room, detectors=tp.Detector(disk, "meter")), 100_000)
    return CaseResult(result["meter"].fluence_rate, 4 * math.pi, naive=math.inf)


# ---- deflection near a pole ----

NARROW, DEPTH = 1e-9, 2.0  # width of the peak [rad]; mean number of scatterings


def _share_within(times: float, angle: float) -> float:
    """Share of light within an angle after a number of scatterings with a narrow Henyey-Greenstein peak.

    For small angles its Hankel transform is exp(-NARROW k), so that n scatterings equal one with a peak
    n times as wide.
    """
    return 1 - times * NARROW / math.hypot(times * NARROW, angle)


def _halo(direction: float) -> CaseResult:
    haze = tp.Medium(scattering=DEPTH, phase=tp.HenyeyGreenstein(1 - NARROW))
    slab = tp.Surface(tp.Slab(thickness=1.0), tp.Transparent(), inside=haze)
    side = "back" if direction > 0 else "front"
    meter = tp.Detector(tp.Disk(center=(0, 0, direction / NARROW), radius=3.0), "meter", side=side)
    found = _run(tp.Scene(_beam((0, 0, -direction), (0, 0, direction)), slab, meter), 100_000)[
        "meter"
    ].flux_in
    share = [math.exp(-DEPTH) * DEPTH**n / math.factorial(n) for n in range(40)]
    exact = sum(share[n] * _share_within(n, 3 * NARROW) for n in range(40))
    return CaseResult(found, exact, naive=share[0] + (1 - share[0]) * _share_within(1, 3 * NARROW))


POLE_SHORTCUT = "within 0.3° of ±z a direction is set to the last deflection"


@case("several deflections of 1e-9 rad, upwards", naive=POLE_SHORTCUT)
def halo_about_the_zenith() -> CaseResult:
    """The usual rotation divides by the sine of the angle to z; near the pole many codes discard the
    previous direction.
    """
    return _halo(1.0)


@case("several deflections of 1e-9 rad, downwards", naive=POLE_SHORTCUT)
def halo_about_the_nadir() -> CaseResult:
    """-z is the pole of coordinate frames that have no pole at +z."""
    return _halo(-1.0)
