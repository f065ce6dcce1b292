"""Known failures of similar programs, each reproduced by a run."""

from __future__ import annotations

import math

import numpy as np

import transport as tp
from transport.theory import emitters
from transport.verification.hard.cases import CaseResult, case

GLOW = tp.Isotropic(power=1.0)
DOWN = tp.Beam((0, 0, -1), power=1.0)
TRANSMITTED_20 = (
    2.9361861e-9  # ordinates.slab(20.0, 0.2, mu0=1.0), diffuse and unscattered, which takes seconds
)


def _run(scene: tp.Scene, particles: int = 20_000, seed: int = 1, **options) -> tp.Result:
    return tp.simulate(scene, particles, seed=seed, progress=False, **options)


# ---- 1: distances ----


@case(
    "a lamp 8 m away from a meter", naive="arriving light carries the lamp's radiance, whatever the distance"
)
def inverse_square() -> CaseResult:
    """Rays drawn towards the detector must carry the solid angle that it subtends; a renderer's light
    tracer once omitted it.
    """
    meter = tp.Disk(center=(0, 0, 8), normal=(0, 0, -1), radius=0.1)
    lamp = tp.Source(tp.Disk(radius=0.1), tp.Lambertian(radiance=100.0), aim=meter)
    found = _run(tp.Scene(lamp, detectors=tp.Detector(meter, "meter")))["meter"].irradiance
    return CaseResult(found, emitters.mean_disk_irradiance(100.0, 0.1, 0.1, 8.0), naive=math.pi * 100.0)


# ---- 2: float32 ----


@case("a million scores of a tenth in one bin", naive="a float32 sum")
def float32_accumulation() -> CaseResult:
    """Each addition rounds to 24 bits of the current sum: the error grows with the number of particles."""
    slab = tp.Surface(tp.Slab(thickness=1.0), tp.Transparent(), inside=tp.Medium(absorption=math.log(10)))
    lamp = tp.Source(tp.Point(position=(0, 0, 1)), DOWN)
    scene = tp.Scene(lamp, slab, tp.Detector(tp.Plane(center=(0, 0, -0.5)), "far", side="back"))
    found = _run(scene, 1_000_000)["far"].flux_out.value
    naive = np.cumsum(np.full(1_000_000, 0.1, np.float32))[-1] / 1e6
    return CaseResult(found, 0.1, float(naive))


# ---- 3: thresholds of weight ----


@case("a microwatt in a room of albedo 0.9", naive="histories end below a weight of 1e-7 W")
def absolute_weight() -> CaseResult:
    """A threshold in watts depends on the user's unit: in a dim room light is lost that is kept in a
    bright one.
    """
    walls = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.9), "walls")
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1e-6))
    found = _run(tp.Scene(lamp, walls, tp.Detector("walls", side="inside")))["walls"].flux_in
    carried = 1e-6 * 0.9 ** np.arange(1000)
    return CaseResult(found, 1e-5, naive=carried[carried >= 1e-7].sum())


# ---- 4: variances, and an error of zero ----


@case("batches of mean 1e8 and variance 1", naive="sqrt(Σx²/n - (Σx/n)²)")
def sum_of_squares() -> CaseResult:
    """Both terms are 1e16, so that no digit of their difference remains; where it is negative the error
    is reported as 0.
    """
    from transport.statistics.batches import standard_error

    values, sizes = 1e8 + np.tile([-1.0, 1.0], 16), np.full(32, 10)
    naive = math.sqrt(max((values**2).mean() - values.mean() ** 2, 0.0) / 31)
    return CaseResult(float(standard_error(values, sizes)), math.sqrt(1 / 31), naive)


@case("what comes through 20 mean free paths", naive="count those of 20 000 that pass: 0 with an error of 0")
def deep_penetration() -> CaseResult:
    """An error of 0 below a small value hides that almost nothing arrived: the exact value is 2.9e-9,
    with a known error.
    """
    slab = tp.Slab(center=(0, 0, -10), thickness=20.0)
    fog = tp.Surface(slab, tp.Transparent(), inside=tp.Medium(absorption=0.8, scattering=0.2))
    lamp = tp.Source(tp.Point(position=(0, 0, 1)), DOWN)
    scene = tp.Scene(lamp, fog, tp.Detector(tp.Plane(center=(0, 0, -20)), "far", side="back"))
    split = tp.Tracking(splitting=tp.Splitting(start=(0, 0, 0), end=(0, 0, -20), gain=1e8))
    found = _run(scene, tracking=split)["far"].flux_out
    return CaseResult(found, TRANSMITTED_20, naive=0.0)


# ---- 5: absolute epsilons, coincident surfaces ----


@case(
    "a grey room a tenth of a nanometre wide",
    naive="particles start 1e-9 m off a wall: outside the room",
)
def tiny_room() -> CaseResult:
    """An offset in metres is larger than the scene: all histories leak at their first reflection."""
    walls = tp.Surface(tp.Box(size=1e-10), tp.Diffuse(0.5), "walls")
    lamp = tp.Source("walls", tp.Lambertian(power=1.0), side="inside")
    found = _run(tp.Scene(lamp, walls, tp.Detector("walls", side="inside")))["walls"].flux_in
    return CaseResult(found, 2.0, naive=0.0)


@case(
    "a grey room a billion kilometres wide",
    naive="the offset of 1e-9 m vanishes beside 1e12 m: walls hit themselves",
)
def vast_room() -> CaseResult:
    """The offset that should separate a particle from its wall is rounded away, and the particle hits
    the wall repeatedly.
    """
    walls = tp.Surface(tp.Box(size=1e12), tp.Diffuse(0.5), "walls")
    lamp = tp.Source("walls", tp.Lambertian(power=1.0), side="inside")
    found = _run(tp.Scene(lamp, walls, tp.Detector("walls", side="inside")))["walls"].flux_in
    return CaseResult(found, 2.0)


@case(
    "a meter that lies in the very plane of a wall",
    naive="one of two surfaces at equal distance scores, the other does not",
)
def detector_on_a_wall() -> CaseResult:
    """Rounding decides which of two coplanar surfaces is hit first; both must score every ray."""
    floor = tp.Rectangle(normal=(1, 2, 3), width=1.0, height=1.0)
    patch = tp.Detector(tp.Rectangle(normal=(1, 2, 3), width=0.5, height=0.5), "patch")
    light = tp.Source(
        tp.Disk(center=(1, 2, 3), normal=(-1, -2, -3), radius=0.8), tp.Beam((-1, -2, -3), irradiance=1.0)
    )
    scene = tp.Scene(light, tp.Surface(floor, tp.Black(), "floor"), [patch, tp.Detector("floor")])
    result = _run(scene)
    return CaseResult(result["patch"].flux_in / result["floor"].flux_in, 0.25, naive=0.0)


# ---- 6: bounds of a patch; increments ----


@case("a patch of 20 cm, 1 m below a lamp", naive="all crossings of the patch's plane are counted")
def patch_of_a_plane() -> CaseResult:
    """A surface's equation has no bounds: half of all light crosses the plane, a four-hundredth the patch."""
    patch = tp.Detector(tp.Disk(center=(0, 0, 1), radius=0.1), "patch", side="back")
    found = _run(tp.Scene(tp.Source(tp.Point(), GLOW), detectors=patch), 500_000)["patch"].flux_in
    return CaseResult(found, emitters.point_flux_through_disk(1.0, 0.1, 1.0), naive=0.5)


@case(
    "a window of a nanometre, a thousand reflections away", naive="a million steps of a millimetre added to x"
)
def many_reflections() -> CaseResult:
    """Rounding errors of the steps add up until the beam misses the window; here each position is one
    product from the flight's start.
    """
    mirrors = [tp.Surface(tp.Plane(center=(0, 0, z)), tp.Mirror()) for z in (-0.5, 0.5)]
    window = tp.Disk(center=(1000, 0, 0), normal=(-1, 0, 0), radius=1e-9)
    beam = tp.Source(tp.Point(), tp.Beam((1, 0, 1), power=1.0))
    end = tp.Surface(tp.Plane(center=(1001, 0, 0), normal=(-1, 0, 0)), tp.Black())
    found = _run(tp.Scene(beam, [*mirrors, end], tp.Detector(window, "window")), 320)["window"].flux_in.value
    walked = np.cumsum(np.full(1_000_000, 1e-3))[-1]
    return CaseResult(found, 1.0, naive=float(abs(walked - 1000) < 1e-9))


# ---- 7: fluence at grazing incidence ----


@case(
    "the fluence rate on a disk in uniform light",
    naive="the mean of weight / |μ|, with a ray at μ = 0 among them",
)
def grazing_fluence() -> CaseResult:
    """1/|μ| has infinite variance, and a ray in the surface gives 0/0; below a cut its mean is scored
    instead.
    """
    room = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="inside")
    scene = tp.Scene(room, detectors=tp.Detector(tp.Disk(radius=1.0), "disk"))
    found = _run(scene, 200_000)["disk"].fluence_rate
    mu = np.array([0.9, 0.4, 0.0])
    with np.errstate(invalid="ignore"):
        naive = 4 * math.pi * (mu / abs(mu)).mean()
    return CaseResult(found, 4 * math.pi, naive=float(naive))


# ---- 8: overlapping streams ----


@case("the spread of z over 120 seeds", naive="the next history's random numbers begin one draw later")
def overlapping_streams() -> CaseResult:
    """Means are right, and so is every single run: only the errors are too small, because neighbours
    share random numbers.
    """
    meter = tp.Disk(center=(0, 0, 0.5), normal=(0, 0, -1), radius=0.5)
    lamp = tp.Source(tp.Disk(radius=0.5), tp.Lambertian(power=1.0))
    scene, share = tp.Scene(lamp, detectors=tp.Detector(meter, "meter")), (3 - math.sqrt(5)) / 2
    flux = [_run(scene, 640, seed, threads=1)["meter"].flux_in for seed in range(120)]
    z = np.array([one.z(share) for one in flux])
    draws = np.random.default_rng(1).random((120, 642))
    scores = draws[:, :-2] + draws[:, 1:-1] + draws[:, 2:]  # two of the three draws are the next one's
    naive = (scores.mean(axis=1) - 1.5) / (scores.std(axis=1) / math.sqrt(640))
    return CaseResult(
        float(z.std()), 1.0, float(naive.std()), within=0.32
    )  # five standard errors of the spread


# ---- 9: nan and infinity ----


@case(
    "particles at rest, 1 m from a wall",
    naive="compiled with fastmath, where an infinite time of arrival is undefined",
)
def never_arrives() -> CaseResult:
    """Such code takes isfinite(nan) for True and an infinity for a number: checks are removed, and
    particles at rest arrive.
    """
    wall = tp.Surface(tp.Box(size=2.0), tp.Black(), "wall")
    gas = tp.Source(tp.Point(), tp.Gas(number=7.0, speed=0.0))
    ledger = _run(tp.Scene(gas, wall, duration=1e300)).ledger
    return CaseResult(ledger["in_flight"].value, 7.0)


# ---- 10: energy from nowhere ----


@case("one scene run twice", naive="sums continue from the first run's values")
def twice() -> CaseResult:
    """Sums that belong to the scene instead of the run double the result."""
    walls = tp.Surface(tp.Sphere(radius=1.0), tp.Black(), "walls")
    scene = tp.Scene(tp.Source(tp.Point(), GLOW), walls, tp.Detector("walls", side="inside"))
    first, second = (_run(scene)["walls"].flux_in.value for _ in range(2))
    return CaseResult(second, 1.0, naive=first + second)


@case("1000 histories in 7 batches", naive="7 batches of ceil(1000 / 7) histories, divided by 1000")
def batches_make_no_energy() -> CaseResult:
    """Batches of different sizes carry their own numbers of histories; exactly the whole power is emitted."""
    walls = tp.Surface(tp.Sphere(radius=1.0), tp.Black(), "walls")
    scene = tp.Scene(tp.Source(tp.Point(), GLOW), walls, tp.Detector("walls", side="inside"))
    found = _run(scene, 1000, batches=7)["walls"].flux_in.value
    return CaseResult(found, 1.0, naive=7 * math.ceil(1000 / 7) / 1000)


# ---- 11: overflow bins; specular and diffuse parts ----


@case(
    "the outermost of two rings, with light outside of both",
    naive="values beyond the last bin are added to it",
)
def overflow_of_bins() -> CaseResult:
    """The last bin then holds all values outside the range, and its mean has no meaning."""
    sun = tp.Source(
        tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0), tp.Beam((0, 0, -1), irradiance=1.0)
    )
    rings = tp.Detector(tp.Disk(radius=1.0), "rings", positions=tp.Positions(u=(0.0, 0.25, 0.5)))
    found = _run(tp.Scene(sun, detectors=rings))["rings"].irradiance[-1]
    ring = 0.5**2 - 0.25**2
    return CaseResult(found, 1.0, naive=(1 - 0.25**2) / ring)


@case("what a pond of ink sends back", naive="diffuse light only: the specular reflection is not counted")
def specular_part() -> CaseResult:
    """Reflectance with and without the specular part are two quantities; both are called "R"."""
    ink = tp.Medium(absorption=1e6, index=1.5)
    pond = tp.Surface(tp.Plane(), tp.Dielectric(1.5), back=ink)
    lamp = tp.Source(tp.Point(position=(0, 0, 1)), DOWN)
    scene = tp.Scene(lamp, pond, tp.Detector(tp.Plane(center=(0, 0, 0.5)), "sky"))
    return CaseResult(_run(scene)["sky"].flux_out, 0.04, naive=0.0)


# ---- 12: apparent convergence ----


@case("a pinhole that sends three quarters of the light", naive="the claimed error of 2 % is trusted")
def unsampled_pinhole() -> CaseResult:
    """No sampled particle has passed the pinhole: the result is a quarter of the exact value, and its
    batches agree.

    1 where the run is right or reports that its error is not to be trusted.
    """
    height, ring, spot = 0.05, 0.8, 3.24e-3
    meter = tp.Disk(center=(0, 0, height), radius=3e-4, normal=(0, 0, -1))
    mask = tp.Disk(center=(0, 0, height / 2), radius=ring / 2, inner_radius=spot / 2)
    lamp = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(radiance=1.0), aim=meter)
    result = _run(tp.Scene(lamp, tp.Surface(mask, tp.Black()), tp.Detector(meter, "meter")), 4400)
    through = [math.pi * r**2 / (r**2 + height**2) for r in (1.0, ring, spot)]
    found, truth = result["meter"].irradiance, through[0] - through[1] + through[2]
    is_right = abs(found.value - truth) < 5 * found.error
    is_reported = not result.quality("meter.irradiance").is_sound
    return CaseResult(float(is_right or is_reported), 1.0, naive=float(is_right))
