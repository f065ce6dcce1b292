"""Media: depths from 1e-18 to 1e6, albedo near 1, sharp phase functions, extreme angles and indices."""

from __future__ import annotations

import math

import numpy as np

import transport as tp
from transport.theory import fresnel, half_space, ordinates
from transport.verification.hard.cases import CaseResult, case

CLEAR = tp.Transparent()
DOWN = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
UP = tp.Detector(tp.Plane(center=(0, 0, 0.1)), "up")
TRANSMITTED = {20: 2.9361861e-9, 45: 4.652334e-20}  # from ordinates.slab(depth, 0.2), which takes ten seconds
ULP = 2.0**-52


def _run(scene: tp.Scene, particles: int = 20_000, **options) -> tp.Result:
    return tp.simulate(scene, particles, seed=1, progress=False, **options)


def _fog(depth: float, albedo: float, g: float = 0.0) -> tp.Medium:
    phase = tp.HenyeyGreenstein(g) if g else tp.Isotropic()
    return tp.Medium(absorption=(1 - albedo) * depth, scattering=albedo * depth, phase=phase)


def _slab(medium: tp.Medium, thickness: float = 1.0) -> tp.Surface:
    return tp.Surface(tp.Slab(center=(0, 0, -thickness / 2), thickness=thickness), CLEAR, inside=medium)


# ---- depths ----


def _absorbed_in_thin_box(depth: float) -> CaseResult:
    box = tp.Box(size=1.0)
    scene = tp.Scene(
        DOWN, tp.Surface(box, CLEAR, inside=tp.Medium(absorption=depth)), tp.VolumeDetector(box, "box")
    )
    return CaseResult(_run(scene, 2000)["box"].absorbed_power, depth, naive=1 - math.exp(-depth))


@case("what a depth of 1e-12 absorbs", naive="1 - exp(-τ)")
def thin() -> CaseResult:
    """exp(-τ) is 1 minus thousands of roundings: four digits of the difference remain."""
    return _absorbed_in_thin_box(1e-12)


@case("what a depth of 1e-18 absorbs", naive="1 - exp(-τ)")
def thinner_than_rounding() -> CaseResult:
    """exp(-τ) rounds to 1. A score of nine units of 2^-63 is rounded randomly, and its mean is right."""
    return _absorbed_in_thin_box(1e-18)


@case("reflection of a depth of 1e6, albedo 0.999", naive="free paths below 1e-5 m are ignored")
def dense() -> CaseResult:
    """A thousand collisions occur between a millionth and a thousandth of the slab's thickness. A
    tracer that ignores short paths reflects nothing.
    """
    found = _run(tp.Scene(DOWN, _slab(_fog(1e6, 0.999)), UP))["up"].flux_out
    return CaseResult(found, float(half_space.plane_albedo(1.0, 0.999)), naive=0.0)


def _through_slab(depth: float) -> CaseResult:
    far = tp.Detector(tp.Plane(center=(0, 0, -depth)), "far", side="back")
    gain = tp.Splitting(start=(0, 0, 0), end=(0, 0, -depth), gain=1 / TRANSMITTED[depth])
    scene = tp.Scene(DOWN, _slab(_fog(1.0, 0.2), depth), far)
    found = _run(scene, 50_000, tracking=tp.Tracking(splitting=gain))["far"].flux_out
    return CaseResult(found, TRANSMITTED[depth], naive=0.0)


@case("through 20 mean free paths, 3e-9", naive="analogue histories: none passes")
def deep() -> CaseResult:
    """One history in 3e8 passes."""
    return _through_slab(20)


@case("through 45 mean free paths, 5e-20", naive="analogue histories: none passes")
def deeper() -> CaseResult:
    """A score is less than the unit of the sums, 2^-63, and is rounded randomly."""
    return _through_slab(45)


@case("a ball of radius 1e-12 in ten mean free paths of fog", naive="analogue histories: none hits it")
def ball_in_fog() -> CaseResult:
    """One history in 1e29 hits it: all are aimed and attenuated on the way."""
    ball = tp.Sphere(center=(0.6, 0.8, 0), radius=1e-12)
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0), aim=ball)
    meter = tp.Detector("ball", "meter", events=0)
    scene = tp.Scene(lamp, tp.Surface(ball, tp.Black(), "ball"), meter, medium=_fog(10.0, 0.5))
    return CaseResult(_run(scene, 50_000)["meter"].flux_in, 2.5e-25 * math.exp(-10), naive=0.0)


# ---- albedo and phase ----


def _absorbed_in_ball(g: float) -> CaseResult:
    """Diffuse light in a ball has a mean path of 4R/3 for any scattering (Blanco and Fournier 2003)."""
    fog = _fog(10.0, 1 - 1e-12, g)
    ball = tp.Surface(tp.Sphere(radius=1.0), CLEAR, "ball", inside=fog)
    scene = tp.Scene(tp.Source("ball", tp.Lambertian(power=1.0), side="inside"), ball)
    return CaseResult(_run(scene).ledger["absorbed"], fog.absorption * 4 / 3, naive=0.0)


ABSORBED_COUNT = "count absorbed histories: none is"


@case("absorption by a ball of albedo 1 - 1e-12", naive=ABSORBED_COUNT)
def next_to_conservative() -> CaseResult:
    """One history in 1e11 is absorbed; the weight falls by thousands of roundings per collision."""
    return _absorbed_in_ball(0.0)


@case("the same, g = 0.9999", naive=ABSORBED_COUNT)
def sharp_forwards() -> CaseResult:
    """Deflections are 0.01 rad; their cosines differ from 1 in the fourth digit."""
    return _absorbed_in_ball(0.9999)


@case("the same, g = -0.9999", naive=ABSORBED_COUNT)
def sharp_backwards() -> CaseResult:
    """Each collision reverses the direction along the same line; light moves back and forth."""
    return _absorbed_in_ball(-0.9999)


def _reflected_by_thin_slab(g: float) -> CaseResult:
    scene = tp.Scene(DOWN, _slab(_fog(1e-3, 1.0, g)), UP)
    found = _run(scene, 50_000, tracking=tp.Tracking(forced=True))["up"].flux_out
    u = (np.arange(1000) + 0.5) / 1000
    with np.errstate(all="ignore"):
        cosines = (1 + g * g - ((1 - g * g) / (1 - g + 2 * g * u)) ** 2) / (2 * g)
    exact = ordinates.slab(1e-3, 1.0).reflected
    return CaseResult(found, exact, naive=1e-3 * float(np.mean(cosines < 0)))


INVERSE = "μ = (1 + g² - ((1 - g²)/(1 - g + 2gu))²) / 2g"


@case("what a thin slab throws back, g = 1e-17", naive=INVERSE)
def hardly_forwards() -> CaseResult:
    """The difference is 0: every history continues at right angles, and none returns."""
    return _reflected_by_thin_slab(1e-17)


@case("what a thin slab throws back, g = -1e-300", naive=INVERSE)
def hardly_backwards() -> CaseResult:
    """Its square is 0 as well, and 0/0 gives no direction."""
    return _reflected_by_thin_slab(-1e-300)


# ---- faces ----


def _onto_face(cosine: float, index: float, below: float, particles: int) -> tp.Result:
    """A beam onto a face between two indices, at a given cosine of incidence."""
    beam = tp.Source(tp.Point(position=(-1, 0, cosine)), tp.Beam((1, 0, -cosine), power=1.0))
    face = tp.Surface(tp.Plane(), tp.Dielectric(below, index), "face")
    return _run(tp.Scene(beam, face, tp.Detector("face", "meter")), particles)


@case(
    "reflection by an index greater by one rounding, 0.7e-8 rad from grazing",
    naive="cos θt = √(1 - sin²θ / n²)",
)
def index_of_one_rounding() -> CaseResult:
    """1 - cos²θ rounds to 1: the angle of incidence is lost, and only the index remains."""
    cosine, n = 0.7e-8, 1 + ULP
    g = math.sqrt(ULP * (2 + ULP) + cosine**2)
    s, p = (g - cosine) / (g + cosine), (n * n * cosine - g) / (n * n * cosine + g)
    bent = math.sqrt(1 - (1 - cosine**2) / n**2)
    naive = ((bent - cosine) / (bent + cosine)) ** 2
    return CaseResult(_onto_face(cosine, 1.0, n, 200_000)["meter"].flux_out, (s * s + p * p) / 2, naive)


@case("reflection by an index of 1 + 1e-12, 1e-6 rad from grazing", naive="Schlick's approximation")
def index_next_to_one() -> CaseResult:
    """At grazing incidence it gives full reflection for any index."""
    found = _onto_face(1e-6, 1.0, 1 + 1e-12, 100_000)["meter"].flux_out
    return CaseResult(found, float(fresnel.reflectance(1e-6, 1 + 1e-12)), naive=(1 - 1e-6) ** 5)


def _near_critical(beyond: float, particles: int) -> tuple[tp.Estimate, float]:
    """Flux out of glass at a relative offset from its critical angle, and its exact value."""
    angle = math.asin(1 / 1.5) * (1 + beyond)
    direction = (math.sin(angle), 0, -math.cos(angle))
    beam = tp.Source(tp.Point(position=tuple(-x for x in direction)), tp.Beam(direction, power=1.0))
    face = tp.Surface(tp.Plane(), tp.Dielectric(1.0, 1.5), "face")
    scene = tp.Scene(beam, face, tp.Detector("face", "meter", side="back"))
    exact = float(fresnel.transmittance(math.cos(angle), 1 / 1.5))
    return _run(scene, particles)["meter"].flux_out, exact


@case("out of glass 1e-12 before the critical angle", naive="√(1 - (n sin θ)²) in float32")
def below_critical() -> CaseResult:
    """7e-6 of the light is transmitted; in float32 the angle lies beyond the critical one, and nothing is."""
    found, exact = _near_critical(-1e-12, 4_000_000)
    return CaseResult(found, exact, naive=0.0)


@case("out of glass 1e-12 beyond the critical angle", naive="asin(n sin θ)")
def beyond_critical() -> CaseResult:
    """The sine is above 1: asin is nan, and without a check it becomes a direction."""
    found, exact = _near_critical(1e-12, 100_000)
    return CaseResult(found.value, exact, naive=math.nan, within=0)


@case("reflection at Brewster's angle", naive="Schlick's approximation")
def brewster() -> CaseResult:
    """p-polarised light is not reflected: the reflectance is half that of s-polarised light."""
    beam = tp.Source(tp.Point(position=(-1.5, 0, 1)), tp.Beam((1.5, 0, -1), power=1.0))
    face = tp.Surface(tp.Plane(), tp.Dielectric(1.5), "face")
    found = _run(tp.Scene(beam, face, tp.Detector("face", "meter")), 100_000)["meter"].flux_out
    return CaseResult(found, (1.25 / 3.25) ** 2 / 2, naive=0.04 + 0.96 * (1 - 1 / math.hypot(1, 1.5)) ** 5)
