"""Media at their limits: depths from 1e-18 to 1e13, albedo next to 1, sharp peaks, layers and boxes that touch, births on faces.

Each scene has an exact value, its energy balance closes and nothing is lost.  Seed 1 unless stated; each judgement fails right
code in one of 10^5 seeds.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.slow import quick
from transport.engine import tally
from transport.theory import attenuation
from transport.theory.turbid import solved

FALSE_ALARM = 1e-5
CLEAR = tp.Transparent()
DARK = tp.Medium(absorption=1.0)
FORCED = tp.Tracking(forced=True)
SPLIT = tp.Tracking(splitting=tp.Splitting(end=(0, 0, -1), start=(0, 0, 0), gain=4))
VAN_DE_HULST = (
    0.0973946386719247,
    0.6609577001638116,
)  # E.vandehulst_hg: R, T of tau 2, albedo 0.9, g 0.75, normal beam
LAMP = tp.Isotropic(power=1.0)
trackings = pytest.mark.parametrize(
    "tracking", ["weighted", "analog", FORCED], ids=["weighted", "analog", "forced"]
)
by_weight_or_chance = pytest.mark.parametrize("tracking", ["weighted", "analog"])


def beam(position, direction):
    return tp.Source(tp.Point(position=tuple(position)), tp.Beam(tuple(direction), power=1.0))


def body(shape, medium, name=None):
    return tp.Surface(shape, CLEAR, name, inside=medium)


def fog(tau, albedo, g=0.0, thickness=1.0):
    phase = tp.HenyeyGreenstein(g) if g else tp.Isotropic()
    sigma = tau / thickness
    return tp.Medium(absorption=(1 - albedo) * sigma, scattering=albedo * sigma, phase=phase)


def faces(thickness=1.0, center=(0.0, 0.0, 0.0)):
    """Detectors a little above z = 0 and below z = -thickness."""
    x, y, z = center
    above, below = (x, y, z + 0.25 * thickness), (x, y, z - 1.25 * thickness)
    return [
        tp.Detector(tp.Plane(center=above), "above", side="back"),
        tp.Detector(tp.Plane(center=below), "below"),
    ]


def under_beam(surfaces, detectors=None):
    """A pencil beam straight down onto z = 0."""
    return tp.Scene(beam((0, 0, 1), (0, 0, -1)), surfaces, faces() if detectors is None else detectors)


def slab(medium, thickness=1.0):
    return body(tp.Slab(center=(0, 0, -thickness / 2), thickness=thickness), medium)


def run(scene, tracking=None, particles=50_000):
    result = tp.simulate(scene, particles, seed=1, threads=1, tracking=tracking, progress=False)
    parts = math.fsum(result.ledger[name].value for name in result.ledger if name != "emitted")
    assert parts == pytest.approx(result.ledger["emitted"].value, rel=1e-14)
    assert result.ledger["lost"].value == 0
    return result


def returned_and_passed(result):
    return result["above"].flux_in, result["below"].flux_in


def exact_slab(tau, albedo, g=0.0):
    """R and T of a normal beam; an albedo of 1 is one of 1 - 1e-6, which is 3e-6 off."""
    light = solved(min(albedo, 1 - 1e-6), round(g, 9), 1.0, 1.0, math.inf if tau > 1e3 else tau)
    return light.reflectance, light.transmittance


def assert_agree(estimates, exact):
    for estimate, value in zip(estimates, exact, strict=True):
        assert_agrees(estimate, value, FALSE_ALARM)


def absorbed(scene, tracking=None):
    """Of a beam or a few, which all of their histories share."""
    return run(scene, tracking, 64 * len(scene.sources)).ledger["absorbed"].value


# ---- depth, albedo and phase function at their ends ----


@pytest.mark.slow
@pytest.mark.parametrize("tau", [1e-12, 1e-4])
@pytest.mark.parametrize("absorption", ["weighted", "analog"])
def test_a_thin_slab_scatters_once_where_collisions_are_forced(tau, absorption):
    """Half of tau scatters, half of that upwards; second collisions are of the order tau^2 log tau."""
    up, down = returned_and_passed(
        run(under_beam(slab(fog(tau, 0.5))), tp.Tracking(absorption=absorption, forced=True))
    )
    exact = 0.25 * tau, 1 - 0.75 * tau
    if tau > 1e-6:
        exact = exact_slab(tau, 0.5)
    assert_agree((up, down), exact)
    assert up.relative_error < 0.01
    with pytest.raises(AssertionError):
        assert_agrees(up, 0.5 * tau, FALSE_ALARM)


@pytest.mark.parametrize("tau", [1e-12, 1e-9])
@by_weight_or_chance
def test_a_thin_slab_transmits_all(tau, tracking):
    result = run(under_beam(slab(fog(tau, 0.5))), tracking)
    assert result["below"].flux_in.value == pytest.approx(1.0, abs=tau)
    if tracking == "weighted":
        assert result.ledger["absorbed"].value == pytest.approx(tau / 2, rel=1e-3)


AT_LIMITS = [
    (1e4, 0.9, 0.75),
    (1e4, 0.99, -0.5),
    (2.0, 1 - 1e-9, 0.0),
    (2.0, 0.9, -1e-15),
    (2.0, 0.9, 1e-300),
]


@pytest.mark.quick_cases("case0-weighted", "case0-analog")
@trackings
@pytest.mark.parametrize("case", quick(AT_LIMITS, (1e4, 0.9, 0.75), (2.0, 1 - 1e-9, 0.0), (2.0, 0.9, 1e-300)))
def test_slabs_at_their_limits_agree_with_radiative_transfer(case, tracking):
    """Ten thousand mean free paths are a half space; an asymmetry of next to nothing is none; hardly any absorption is none."""
    tau, albedo, g = case
    result = run(under_beam(slab(fog(*case))), tracking, 20_000 if tau > 1e3 else 50_000)
    up, down = returned_and_passed(result)
    exact = exact_slab(tau, albedo, g)
    assert_agrees(up, exact[0], FALSE_ALARM)
    if tau > 1e3:
        assert down.value == 0
        return
    assert_agrees(down, exact[1], FALSE_ALARM)
    if albedo > 0.99:
        assert up.value + down.value == pytest.approx(1, abs=1e-7)
        if tracking == "weighted":
            collisions = result.cost.collisions / 50_000
            assert result.ledger["absorbed"].value == pytest.approx(1e-9 * collisions, rel=0.02)


def along_a_line(tau, albedo, g):
    """R and T where g is next to 1, so that only absorption counts, or next to -1: two streams with backward scattering."""
    if g > 0:
        return 0.0, math.exp(-(1 - albedo) * tau)
    rate = math.sqrt(1 - albedo**2)
    denominator = rate * math.cosh(rate * tau) + math.sinh(rate * tau)
    return albedo * math.sinh(rate * tau) / denominator, rate / denominator


@trackings
@pytest.mark.parametrize("g", [1 - 1e-9, -1 + 1e-9])
def test_peaks_straight_on_and_straight_back_are_lines(g, tracking):
    up, down = returned_and_passed(run(under_beam(slab(fog(2.0, 0.9, g))), tracking))
    exact = along_a_line(2.0, 0.9, g)
    assert abs(up.value - exact[0]) <= 4.42 * (up.error if exact[0] else 0) + 1e-4
    assert abs(down.value - exact[1]) <= 4.42 * (down.error if np.isfinite(down.error) else 0) + 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("g", [0.999, -0.999])
def test_narrow_peaks_are_alike_by_all_trackings(g):
    scene = under_beam(slab(fog(2.0, 0.9, g)))
    weighted, *others = (returned_and_passed(run(scene, t, 100_000)) for t in ("weighted", "analog", FORCED))
    for part, line in enumerate(along_a_line(2.0, 0.9, g)):
        for other in others:
            assert_agrees(weighted[part] - other[part], 0.0, FALSE_ALARM)
        assert weighted[part].value == pytest.approx(line, abs=0.02)


@pytest.mark.parametrize(
    "wall", [tp.Mirror(), tp.Dielectric(1.5, 1.5), tp.Diffuse(1.0)], ids=["mirror", "no change", "white"]
)
def test_a_box_of_conservative_fog_keeps_or_transmits_all(wall):
    mist = tp.Medium(scattering=3.0, phase=tp.HenyeyGreenstein(0.5), index=1.5)
    is_open = isinstance(wall, tp.Dielectric)
    surfaces = tp.Surface(tp.Box(size=1.0), wall, "box", inside=mist)
    around = tp.Medium(index=1.5) if is_open else None
    lamp = tp.Source(tp.Point(position=(0.1, 0.2, 0.3)), LAMP)
    ledger = run(tp.Scene(lamp, surfaces, (), medium=around, duration=1e-7), "analog", 2_000).ledger
    assert ledger["absorbed"].value == 0
    assert ledger["in_flight"].value == pytest.approx(1e-7, rel=1e-14)
    if is_open:
        ledger = run(tp.Scene(lamp, surfaces, (), medium=around), None, 2_000).ledger
        assert ledger["escaped"].value == pytest.approx(1, rel=1e-14)


@pytest.mark.parametrize("gap", [0.0, 1e-15, 1e-13, 1e-12, 1e-11])
def test_a_detector_a_thin_gap_beyond_the_outermost_face_sees_what_leaves(gap):
    milk = body(tp.Slab(center=(0, 0, -1 - gap), thickness=2.0), tp.Medium(absorption=0.1, scattering=0.9))
    result = run(under_beam(milk, tp.Detector(tp.Plane(), "top")), "analog")
    assert_agrees(result["top"].flux_out, exact_slab(2.0, 0.9)[0], FALSE_ALARM)


# ---- layers that touch, gaps between them, any unit and place ----


def layers(count, gap=0.0, are_alike=False, scale=1.0):
    """One slab as many; each differs from the next, or else they might be taken for one."""
    thickness = scale / count
    return [
        body(
            tp.Slab(center=(0, 0, -(k + 0.5) * thickness - k * gap), thickness=thickness),
            fog(2.0, 0.9, 0.75 if are_alike else 0.75 * (1 + 1e-12 * k), scale),
        )
        for k in range(count)
    ]


def far_slab(offset):
    center = np.array([1.0, -0.7, 0.3]) * offset
    milk = body(tp.Slab(center=tuple(center - [0, 0, 0.5]), thickness=1.0), fog(2.0, 0.9, 0.75))
    return tp.Scene(beam(center + [0, 0, 0.1], (0, 0, -1)), milk, faces(1.0, tuple(center)))


LAYERED = {f"{n} layers": under_beam(layers(n)) for n in (3, 20, 60)}
LAYERED["20 alike"] = under_beam(layers(20, are_alike=True))
LAYERED |= {f"gaps of {gap:g}": under_beam(layers(3, gap)) for gap in (1e-3, 1e-12, 1e-14)}
LAYERED |= {f"{offset:g} from the origin": far_slab(offset) for offset in (1e3, 1e6)}


@pytest.mark.quick_cases("20 layers-weighted", "20 layers-analog")
@trackings
@pytest.mark.parametrize("name", quick(LAYERED, "20 layers", "gaps of 1e-12", "1e+06 from the origin"))
def test_layers_are_one_slab(name, tracking):
    particles = 5_000 if name.startswith("60") else 20_000
    assert_agree(returned_and_passed(run(LAYERED[name], tracking, particles)), VAN_DE_HULST)


def test_layers_are_one_slab_where_histories_split():
    assert_agree(returned_and_passed(run(under_beam(layers(5)), SPLIT, 20_000)), VAN_DE_HULST)


def test_a_layer_left_out_is_seen():
    with pytest.raises(AssertionError):
        assert_agree(returned_and_passed(run(under_beam(layers(20)[:-1]), None, 20_000)), VAN_DE_HULST)


# ---- boxes at their edges and corners, and two side by side ----


def chord(low, high, start, way):
    """Length of a ray in a box; along a face it is inside."""
    with np.errstate(divide="ignore", invalid="ignore"):
        near, far = (low - start) / way, (high - start) / way
    first = np.where(way != 0, np.minimum(near, far), -np.inf).max()
    last = np.where(way != 0, np.maximum(near, far), np.inf).min()
    return max(0.0, last - max(first, 0.0))


@pytest.mark.parametrize("number", quick(range(12), 0, 1, 2))
def test_beams_through_edges_and_corners_are_absorbed_by_their_chord(number):
    """Twenty beams at exact points of edges, twenty at corners, from within and from outside; no coordinate is round."""
    random = np.random.default_rng(number)
    size = random.uniform(0.3, 2, 3) if number % 3 else random.choice([0.5, 1, 2], 3)
    center = random.normal(size=3) * random.choice([0, 1, 1000])
    sources, exact = [], 0.0
    for k in range(40):
        side = random.choice([-1.0, 1.0], 3)
        if k % 2:
            side[random.integers(3)] = random.choice([0, 0.5, random.uniform(-1, 1)])
        target = center + side * size / 2
        start = (
            center + random.uniform(-0.45, 0.45, 3) * size if k < 16 else target + 2 * random.normal(size=3)
        )
        if k >= 32:  # along a diagonal
            start = target + random.choice([-1, 1], 3) * size
        way = (target - start) / np.linalg.norm(target - start)
        sources.append(beam(start, way))
        exact -= math.expm1(-chord(center - size / 2, center + size / 2, start, way))
    found = absorbed(tp.Scene(sources, body(tp.Box(center=tuple(center), size=tuple(size)), DARK), ()))
    assert found == pytest.approx(exact, abs=1e-6)
    assert found != pytest.approx(exact + 0.01, abs=1e-6)


HALVES = [tp.Box(center=(x, 0, 0), size=1.0) for x in (-0.5, 0.5)]
WHOLE = tp.Box(size=(2, 1, 1))
RAYS = {  # start, direction, chord
    "across the shared face": ((3, 0.1, 0.2), (-1, 0, 0), 2.0),
    "in the shared face": ((0, 0, 2), (0, 0, -1), 1.0),
    "in it, aslant": ((0, 2, 2), (0, -1, -1), math.sqrt(2)),
    "through its edge": ((1, 0.1, 1), (-1, 0, -0.5), 0.5 * math.sqrt(5)),
    "through its corner": ((1, 1.5, 1.5), (-1, -1, -1), math.sqrt(3)),
    "along a diagonal": ((2, 2, 2), (-1, -1, -1), math.sqrt(3)),
    "into the far corner": ((3, 1.5, 1.5), (-2, -1, -1), math.sqrt(6)),
}


def one_box_as(medium, other):
    """One box; two side by side; one in another, of which they share faces; two that fill a third."""
    halves = [body(HALVES[0], medium), body(HALVES[1], other)]
    return {
        "one box": [body(WHOLE, medium)],
        "two boxes": halves,
        "a box in another": [body(WHOLE, medium), halves[1]],
        "two in one": [body(WHOLE, tp.Medium(absorption=7.0)), *halves],
    }


@pytest.mark.quick_cases("one box-across the shared face", "one box-in the shared face")
@pytest.mark.parametrize("ray", RAYS)
@pytest.mark.parametrize("kind", ["one box", "two boxes", "a box in another", "two in one"])
def test_two_boxes_side_by_side_are_one(ray, kind):
    """Their media differ by the last digit."""
    start, way, length = RAYS[ray]
    surfaces = one_box_as(DARK, tp.Medium(absorption=1.0 + 2.0**-52))[kind]
    scene = tp.Scene(beam(start, np.array(way) / np.linalg.norm(way)), surfaces, ())
    assert absorbed(scene) == pytest.approx(-math.expm1(-length), abs=1e-12)


@pytest.mark.quick_cases("shared face-weighted", "shared face-analog")
@trackings
@pytest.mark.parametrize(
    "place", [(0.0, 0.0), (0.0, 0.5), (0.3, 0.2)], ids=["shared face", "its edge", "within"]
)
def test_light_that_scatters_in_a_shared_face_is_lost_to_neither_box(place, tracking):
    """A beam down the very face between two boxes, and between one and a twin within a larger one: as in one box."""
    small = 1e-9 if place[1] else 0  # beside the outermost face, where only what is within counts
    lamp = beam((place[0], place[1] - small, 2), (0, 0, -1))
    whole, *others = list(one_box_as(fog(2.0, 0.9, 0.5), fog(2.0, 0.9, 0.5 * (1 + 1e-12))).values())[:3]
    exact = run(tp.Scene(lamp, whole, ()), tracking).ledger["escaped"]
    for surfaces in others:
        assert_agrees(run(tp.Scene(lamp, surfaces, ()), tracking).ledger["escaped"] - exact, 0.0, FALSE_ALARM)


# ---- lamps and beams that begin exactly on a boundary ----


def absorbed_in_a_ball_from_its_surface():
    """Of isotropic light from a place on a ball of radius 1, absorption 1: half enters, with chords 2 mu."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    return 0.5 * ((weights / 2) @ -np.expm1(-(nodes + 1)))


HALF_OF_A_SLAB = 0.5 * (1 - float(attenuation.exponential_integral(2, 1.0)))
ON_FACES = {  # a body of depth 1 that a lamp touches, where the lamp is, the absorbed share
    "ball": (body(tp.Sphere(radius=1.0), DARK), (0, 0, 1), absorbed_in_a_ball_from_its_surface()),
    "above a slab": (
        body(tp.Slab(center=(0.3, 0, -0.25), thickness=0.5), tp.Medium(2.0)),
        (0, 0, 0),
        HALF_OF_A_SLAB,
    ),
    "below a slab": (
        body(tp.Slab(center=(0.3, 0, 0.25), thickness=0.5), tp.Medium(2.0)),
        (0, 0, 0),
        HALF_OF_A_SLAB,
    ),
}


@pytest.mark.parametrize(("dark", "place", "exact"), ON_FACES.values(), ids=ON_FACES)
def test_a_lamp_on_a_face_lights_the_body_with_half_of_its_light(dark, place, exact):
    result = run(tp.Scene(tp.Source(tp.Point(position=place), LAMP), dark, ()))
    assert_agrees(result.ledger["absorbed"], exact, FALSE_ALARM)


@trackings
def test_a_lamp_in_the_interface_of_two_layers_is_a_lamp_in_one(tracking):
    lamp, mist = tp.Source(tp.Point(), LAMP), {"absorption": 0.3, "scattering": 2.0}
    two = [
        body(tp.Slab(center=(0, 0, z), thickness=1.0), tp.Medium(**mist, phase=tp.HenyeyGreenstein(g)))
        for z, g in ((0.5, 1e-12), (-0.5, 2e-12))
    ]
    one = body(tp.Slab(thickness=2.0), tp.Medium(**mist))
    apart, together = (
        run(tp.Scene(lamp, surfaces, ()), tracking).ledger["escaped"] for surfaces in (two, one)
    )
    assert_agrees(apart - together, 0.0, FALSE_ALARM)
    assert together.relative_error < 0.01


@pytest.mark.parametrize(("corner", "octants"), [((0.5, 0, 0), 4), ((0.5, 0.5, 0), 2), ((0.5, 0.5, 0.5), 1)])
def test_a_lamp_on_a_face_an_edge_or_a_corner_of_a_box(corner, octants):
    """The light that enters is that of octants; it is compared with that of a place just within."""
    on, within = (
        run(tp.Scene(tp.Source(tp.Point(position=place), LAMP), body(tp.Box(size=1.0), DARK), ())).ledger[
            "absorbed"
        ]
        for place in (corner, [x * (1 - 1e-9) for x in corner])
    )
    assert_agrees(on - within, 0.0, FALSE_ALARM)
    assert on.value < octants / 8


@pytest.mark.parametrize(
    ("place", "way", "length"),
    [
        ((0.5, 0, 0), (-1, 0, 0), 1.0),
        ((0.5, 0, 0), (1, 0, 0), 0.0),
        ((0.5, 0.5, 0), (-1, -1, 0), math.sqrt(2)),
        ((0.5, 0.5, 0.5), (-1, -1, -1), math.sqrt(3)),
    ],
)
def test_beams_from_a_face_an_edge_or_a_corner(place, way, length):
    scene = tp.Scene(beam(place, np.array(way) / np.linalg.norm(way)), body(tp.Box(size=1.0), DARK), ())
    assert absorbed(scene) == pytest.approx(-math.expm1(-length), rel=1e-12)


# ---- absorption of next to nothing ----


def weakly_absorbed(depth, particles=20_000, grid=False):
    """By weight, of a beam through the middle of an absorber of this optical depth, 2 m long."""
    shape = tp.Box(size=2.0) if grid else tp.Sphere(radius=1.0)
    inside = (
        tp.Grid(box=shape, absorption=np.full((2, 3, 4), depth / 2))
        if grid
        else tp.Medium(absorption=depth / 2)
    )
    return run(tp.Scene(beam((0, 0, -3), (0, 0, 1)), body(shape, inside)), "weighted", particles).ledger[
        "absorbed"
    ]


@pytest.mark.parametrize("grid", [False, True], ids=["medium", "grid"])
@pytest.mark.parametrize("depth", [1e-3, 1.5e-6, 7e-7, 1e-9, 1e-12])
def test_weak_absorption_is_known_to_all_digits(depth, grid):
    """Of 20 000 histories the last places of a weight average out to 1e-18, 1e-6 of a depth of 1e-12."""
    exact = -math.expm1(-depth)
    assert weakly_absorbed(depth, grid=grid).value == pytest.approx(exact, rel=max(1e-13, 5e-18 / depth))


@pytest.mark.parametrize("grid", [False, True], ids=["medium", "grid"])
@pytest.mark.parametrize("depth", [1e-16, 1e-18])
def test_absorption_below_the_last_place_of_a_weight_is_right_in_the_mean(depth, grid):
    """One history in a hundred loses 1e-16: a difference of weights would be 0, every time."""
    found = weakly_absorbed(depth, particles=400_000, grid=grid)
    assert_agrees(found, depth, 1e-6)
    assert found.value > 0


def test_weights_that_have_been_lessened_before_are_lessened_right():
    """Weights of any digits, behind an absorber: of each length in the ball the same as where plain arithmetic will do."""
    found = []
    for absorption in (1e-3, 2e-17):
        ball = body(tp.Sphere(radius=1.0), tp.Medium(absorption=absorption), "ball")
        room = body(tp.Sphere(radius=1.9), tp.Medium(absorption=0.3))
        lamp = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(power=1.0), side="inside")
        scene = tp.Scene(lamp, [ball, room])
        result = tp.simulate(scene, particles=100_000, tracking="weighted", seed=2, progress=False)
        found.append(result.ledger.absorbed_by["inside ball"] * (1 / absorption))
    assert_agrees(found[1], found[0].value, 1e-6)
    assert found[1].relative_error < 0.02


# ---- light fainter than the digits of the sums, 2^-63 of a birth weight ----


def test_light_brighter_than_the_unit_has_no_noise_and_too_faint_light_has_no_score():
    bright, faint = (
        run(under_beam(slab(DARK, tau), faces(tau)), None, 1000)["below"].flux_in for tau in (20.0, 80.0)
    )
    assert bright.value == pytest.approx(math.exp(-20), abs=2.0**-63) and math.isnan(bright.error)
    assert faint.value == 0 and faint.reason == "no score"


@pytest.mark.parametrize("weight", [0.0, 2.0**-63, 2.0**-40, 1e-15, 1e-20, 1e-30, 0.3, 1.0])
def test_chance_rounds_up_only_what_is_less_than_a_unit(weight):
    """The mean over even chances is the weight; a whole number of units is left alone; nothing stays nothing."""
    chances = (np.arange(4096) + 0.5) / 4096
    units = np.array([tally.unbiased_limbs(weight, chance) for chance in chances], dtype=object)
    found = [high * 2**31 + low for high, low in units]
    exact = weight * 2.0**63
    assert abs(np.mean([float(one) for one in found]) - exact) <= max(1 / 4096, 1e-9 * exact)
    assert exact != int(exact) or set(found) == {int(exact)}


@pytest.mark.parametrize("weight", [0.0, 2.0**-63, 1e-15, 1 / 3, 0.7, 1.0])
def test_the_energy_balance_keeps_every_unit_of_a_weight(weight):
    """Both limbs together are its whole number of units of 2^-63: with the upper one alone 2^-32 would be the end."""
    high, low = tally.limbs(weight)
    assert high * 2**31 + low == int(weight * 2.0**63)


# ---- free paths far below the scene's size: right as long as coordinates have digits for them, then refused ----


def milk(mfp, lamp=1.0):
    """A thick slab of albedo 0.9 below z = 0, under a pencil beam from `lamp` metres above."""
    white = slab(tp.Medium(absorption=0.1 / mfp, scattering=0.9 / mfp))
    return tp.Scene(beam((0, 0, lamp), (0, 0, -1)), white, tp.Detector(tp.Plane(), "up"))


@pytest.mark.quick_cases("lengths2-weighted", "lengths2-analog")
@by_weight_or_chance
@pytest.mark.parametrize(
    "lengths", quick([(1e-3, 1.0), (1e-6, 1.0), (1e-9, 1.0), (1e-6, 1e3)], (1e-9, 1.0), (1e-6, 1e3))
)
def test_dense_media_reflect_as_a_half_space(lengths, tracking):
    """A code that goes on without digits reports 0.008 for 0.415 of milk under the sun at its true distance."""
    result = tp.simulate(milk(*lengths), particles=200_000, seed=2, threads=1, tracking=tracking)
    assert_agrees(result["up"].flux_out, exact_slab(math.inf, 0.9)[0], 1e-4)
    assert result.ledger["lost"].value == 0


BLOCK = tp.Box(size=1.0)
DENSE_VOXEL = tp.Grid(box=BLOCK, scattering=np.array([[[1.0, 1e13]]]))


def block(absorption, *detectors):
    """An absorber under a wide, slanting beam."""
    lamp = tp.Source(
        tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.3), tp.Beam((0.1, 0, -1), power=1.0)
    )
    return tp.Scene(lamp, body(BLOCK, tp.Medium(absorption=absorption)), detectors)


INSIDE = tp.VolumeDetector(BLOCK, "box")
TOO_DENSE = {  # a scene, the words of its refusal
    "mfp 1e-10": (milk(1e-10), "Medium: mean free paths must be above .* bring far objects nearer"),
    "mfp 1e-13": (milk(1e-13), "Medium: mean free paths must be above .* bring far objects nearer"),
    "mfp 1e-4, far lamp": (
        milk(1e-4, 1.5e11),
        "Medium: mean free paths must be above .* bring far objects nearer",
    ),
    "a voxel": (
        tp.Scene(beam((0, 0, 2), (0, 0, -1)), body(BLOCK, DENSE_VOXEL)),
        "Grid: mean free paths must be above",
    ),
    "a volume, 1e13": (block(1e13, INSIDE), "mean free paths must be above .* omit the VolumeDetectors"),
    "a volume, 1e25": (block(1e25, INSIDE), "mean free paths must be above .* omit the VolumeDetectors"),
}


@by_weight_or_chance
@pytest.mark.parametrize(("scene", "words"), TOO_DENSE.values(), ids=TOO_DENSE)
def test_free_paths_without_digits_are_refused(scene, words, tracking):
    """Volumes would measure roundings: a fluence 30 % too high at 1e13 per metre, negative at 1e25."""
    with pytest.raises(tp.SceneError, match=words):
        tp.simulate(scene, particles=10, threads=1, tracking=tracking)


@pytest.mark.parametrize(("tracking", "within"), [("weighted", 1e-6), ("analog", 0.01)])
def test_dense_absorbers_are_right_as_long_as_there_are_digits(tracking, within):
    assert tp.simulate(block(1e15), particles=10, threads=1).ledger["absorbed"].value == 1.0
    result = tp.simulate(block(5e8, INSIDE), particles=200_000, seed=2, threads=1, tracking=tracking)
    assert result["box"].absorbed_power.value == pytest.approx(1.0, rel=within)


# ---- a detector behind media so thick that nothing reaches it: the warning names the reason and the cure ----

DETECTOR = tp.Detector(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1000.0), "meter")
UPWARDS = beam((0, 0, -1), (0, 0, 1))


def behind_slab(tracking=None, particles=4096, **medium):
    """A beam, a slab from 0 to 1 m and a detector behind it."""
    inside = body(tp.Slab(center=(0, 0, 0.5), thickness=1.0), tp.Medium(**medium))
    scene = tp.Scene(UPWARDS, inside, DETECTOR)
    return tp.simulate(scene, particles=particles, tracking=tracking, seed=1, progress=False)


DEEP = {  # tracking, medium, what the one warning says, what it does not
    "analog": ("analog", {"absorption": 12.0}, r"12 mean free paths of media; exp\(-12\) of it is transmitted: use tracking='weighted'"),
    "faint, analog": ("analog", {"absorption": 60.0}, r"exp\(-60\) of it is transmitted, and no run resolves less than 1e-19"),
    "faint, weighted": ("weighted", {"absorption": 60.0}, r"exp\(-60\) of it is transmitted, and no run resolves less than 1e-19"),
} | {
    f"roulette {least:g}": (
        tp.Tracking(roulette=least),
        {"absorption": 20.0, "scattering": 180.0},
        r"^(?!.*roulette).*200 mean free paths.*about exp\(-110\) of the diffusing light is transmitted, and no run resolves less",
    )
    for least in (1e-2, 1e-20, 1e-90)
}  # fmt: skip


@pytest.mark.parametrize(("tracking", "medium", "words"), DEEP.values(), ids=DEEP)
def test_a_detector_behind_a_thick_medium_names_its_depth_and_the_cure(tracking, medium, words):
    (warning,) = behind_slab(tracking, **medium).warnings
    assert re.search(words, warning, re.DOTALL)


def test_the_cures_for_thick_media_work():
    """Weights for an absorber; for diffusion the splitting that is advised, to what a tenth of its gain gives as well."""
    result = behind_slab("weighted", absorption=12.0)
    assert result["meter"].flux_in.value == pytest.approx(math.exp(-12), rel=1e-9) and not result.warnings
    mist = {"absorption": 0.6, "scattering": 149.4}
    (warning,) = behind_slab(particles=256, **mist).warnings
    advised = eval(re.search(r"Splitting\(.*gain=[^)]*\)", warning)[0], vars(tp))
    found = []
    for splitting in (advised, replace(advised, gain=advised.gain / 10)):
        result = behind_slab(tp.Tracking(splitting=splitting), particles=512, **mist)
        assert not any("mean free paths" in warning for warning in result.warnings)
        found.append(result["meter"].flux_in)
    assert found[0].value > 0
    assert_agrees(found[0] - found[1], 0.0)


@pytest.mark.parametrize("look", ["ball", DETECTOR.shape], ids=["on the ball", "afar"])
def test_a_dense_glowing_ball_is_reported_to_shine_from_its_skin(look):
    ball = body(tp.Sphere(radius=1.0), tp.Medium(absorption=1e7, emission=1e7), "ball")
    warning = tp.simulate(
        tp.Scene([], ball, tp.Detector(look, "meter")), particles=1000, progress=False
    ).warnings[0]
    assert (
        "only the outer mean free path" in warning and "Lambertian(radiance=emission / absorption)" in warning
    )


@pytest.mark.parametrize("medium", [None, tp.Medium(absorption=0.5)], ids=["vacuum", "thin fog"])
def test_a_detector_in_the_dark_of_a_screen_is_not_reported_to_lie_deep(medium):
    screen = tp.Surface(tp.Disk(center=(0, 0, 1), radius=0.5), tp.Black())
    result = tp.simulate(tp.Scene(UPWARDS, screen, DETECTOR, medium=medium), particles=1000, progress=False)
    assert result["meter"].flux_in.value == 0
    assert not any("mean free paths" in warning for warning in result.warnings)
