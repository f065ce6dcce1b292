"""Media at their limits: layers that touch, gaps of nothing, edges and corners, births on boundaries, depths from 1e-12 to 1e4.

Each scene has an exact value; its ledger closes and nothing is lost.  Runs have seed 1; each judgement fails right code in
one of 10^5 seeds.  A comment such as `E.slab_HG` names the entry of the project's reference collection.
"""

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.theory import ordinates

FALSE_ALARM = 1e-5
CLEAR = tp.Transparent()
R, T = 0.0973946386719247, 0.6609577001638116  # E.vandehulst_hg: tau 2, albedo 0.9, g 0.75, normal beam
DARK = tp.Medium(absorption=1.0)
FORCED = tp.Tracking(forced=True)


def beam(position, direction):
    return tp.Source(tp.Point(position=tuple(position)), tp.Beam(tuple(direction), power=1.0))


def body(shape, medium, name=None):
    return tp.Surface(shape, CLEAR, name, inside=medium)


def fog(tau, albedo, g=0.0, thickness=1.0):
    phase = tp.HenyeyGreenstein(g) if g else tp.Isotropic()
    sigma = tau / thickness
    return tp.Medium(absorption=(1 - albedo) * sigma, scattering=albedo * sigma, phase=phase)


def faces(thickness=1.0, center=(0.0, 0.0, 0.0)):
    """Meters a little above z = 0 and below z = -thickness."""
    x, y, z = center
    above, below = (x, y, z + 0.25 * thickness), (x, y, z - 1.25 * thickness)
    return [
        tp.Detector(tp.Plane(center=above), "above", side="back"),
        tp.Detector(tp.Plane(center=below), "below"),
    ]


def run(scene, tracking=None, particles=50_000):
    result = tp.simulate(scene, particles, seed=1, threads=1, tracking=tracking, progress=False)
    ledger = result.ledger
    parts = math.fsum(ledger[name].value for name in ledger if name != "emitted")
    assert parts == pytest.approx(ledger["emitted"].value, rel=1e-14)
    assert ledger["lost"].value == 0
    return result


def returned_and_passed(result):
    return result["above"].flux_in, result["below"].flux_in


def assert_is_van_de_hulst_s_slab(result):
    for estimate, exact in zip(returned_and_passed(result), (R, T), strict=True):
        assert_agrees(estimate, exact, FALSE_ALARM)


def absorbed(scene, tracking=None):
    """Of a beam or a few, which all of their histories share."""
    return run(scene, tracking, 64 * len(scene.sources)).ledger["absorbed"].value


# ---- layers ----


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


@pytest.mark.parametrize("tracking", ["weighted", "analog"])
@pytest.mark.parametrize("are_alike", [True, False])
@pytest.mark.parametrize("count", [1, 3, 20, 60])
def test_many_thin_slabs_are_one(count, are_alike, tracking):
    """Interfaces coincide; the path from one collision to the next leads through many."""
    scene = tp.Scene(beam((0, 0, 1), (0, 0, -1)), layers(count, are_alike=are_alike), faces())
    assert_is_van_de_hulst_s_slab(run(scene, tracking, 30_000))


@pytest.mark.parametrize(
    "tracking", [FORCED, tp.Tracking(splitting=tp.Splitting(end=(0, 0, -1), start=(0, 0, 0), gain=4))]
)
def test_many_thin_slabs_are_one_for_copies_too(tracking):
    scene = tp.Scene(beam((0, 0, 1), (0, 0, -1)), layers(5), faces())
    assert_is_van_de_hulst_s_slab(run(scene, tracking, 20_000))


@pytest.mark.parametrize("gap", [1e-3, 1e-9, 1e-12, 1e-14])
@pytest.mark.parametrize("tracking", [None, "analog", FORCED])
def test_a_gap_of_vacuum_between_layers_changes_nothing(gap, tracking):
    scene = tp.Scene(beam((0, 0, 1), (0, 0, -1)), layers(3, gap), faces())
    assert_is_van_de_hulst_s_slab(run(scene, tracking))


def test_a_layer_left_out_is_seen():
    scene = tp.Scene(beam((0, 0, 1), (0, 0, -1)), layers(20)[:-1], faces())
    with pytest.raises(AssertionError):
        assert_is_van_de_hulst_s_slab(run(scene))


@pytest.mark.parametrize("offset", [1e3, 1e6])
@pytest.mark.parametrize("tracking", [None, "analog", FORCED])
def test_a_slab_far_from_the_origin(offset, tracking):
    center = np.array([1.0, -0.7, 0.3]) * offset
    slab = tp.Slab(center=tuple(center - [0, 0, 0.5]), thickness=1.0)
    scene = tp.Scene(
        beam(center + [0, 0, 0.1], (0, 0, -1)), body(slab, fog(2.0, 0.9, 0.75)), faces(1.0, tuple(center))
    )
    assert_is_van_de_hulst_s_slab(run(scene, tracking))


@pytest.mark.parametrize("scale", [1e-12, 1e-6, 1e12])
def test_slabs_of_picometres_and_of_a_light_hour(scale):
    """The same digits as of a metre."""
    found = []
    for size in (1.0, scale):
        scene = tp.Scene(beam((0, 0, size), (0, 0, -1)), layers(3, scale=size), faces(size))
        found.append([estimate.value for estimate in returned_and_passed(run(scene, None, 5_000))])
    assert found[1] == pytest.approx(found[0], rel=1e-12)


# ---- boxes ----


def _chord(low, high, start, way):
    """How far a ray flies in a box; along a face it is inside."""
    with np.errstate(divide="ignore", invalid="ignore"):
        near, far = (low - start) / way, (high - start) / way
    first = np.where(way != 0, np.minimum(near, far), -np.inf).max()
    last = np.where(way != 0, np.maximum(near, far), np.inf).min()
    return max(0.0, last - max(first, 0.0))


@pytest.mark.parametrize("number", range(12))
def test_beams_through_edges_and_corners_are_absorbed_by_their_chord(number):
    """Twenty beams aimed at exact points of edges, twenty at corners, from within and from outside; no coordinate is round."""
    random = np.random.default_rng(number)
    size = random.uniform(0.3, 2, 3) if number % 3 else random.choice([0.5, 1, 2], 3)
    center = random.normal(size=3) * random.choice([0, 1, 1000])
    low, high = center - size / 2, center + size / 2
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
        exact -= math.expm1(-_chord(low, high, start, way))
    box = tp.Box(center=tuple(center), size=tuple(size))
    found = absorbed(tp.Scene(sources, body(box, DARK), ()))
    assert found == pytest.approx(exact, abs=1e-6)
    assert found != pytest.approx(exact + 0.01, abs=1e-6)


HALVES = [tp.Box(center=(x, 0, 0), size=1.0) for x in (-0.5, 0.5)]
WHOLE = tp.Box(size=(2, 1, 1))
RAYS = {  # start, direction, way within
    "across the shared face": ((3, 0.1, 0.2), (-1, 0, 0), 2.0),
    "in the shared face": ((0, 0, 2), (0, 0, -1), 1.0),
    "in it, aslant": ((0, 2, 2), (0, -1, -1), math.sqrt(2)),
    "through its edge": ((1, 0.1, 1), (-1, 0, -0.5), 0.5 * math.sqrt(5)),
    "through its corner": ((1, 1.5, 1.5), (-1, -1, -1), math.sqrt(3)),
    "along a diagonal": ((2, 2, 2), (-1, -1, -1), math.sqrt(3)),
    "into the far corner": ((3, 1.5, 1.5), (-2, -1, -1), math.sqrt(6)),
}


@pytest.mark.parametrize("ray", RAYS)
@pytest.mark.parametrize("kind", ["one box", "two boxes", "a box in another", "two in one"])
def test_two_boxes_side_by_side_are_one(ray, kind):
    """Nested boxes share faces, or two fill a third; their media differ by the last digit."""
    start, way, chord = RAYS[ray]
    other = tp.Medium(absorption=1.0 + 2.0**-52)
    surfaces = {
        "one box": [body(WHOLE, DARK)],
        "two boxes": [body(HALVES[0], DARK), body(HALVES[1], other)],
        "a box in another": [body(WHOLE, DARK), body(HALVES[1], other)],
        "two in one": [body(WHOLE, tp.Medium(absorption=7.0)), body(HALVES[0], DARK), body(HALVES[1], other)],
    }[kind]
    scene = tp.Scene(beam(start, np.array(way) / np.linalg.norm(way)), surfaces, ())
    assert absorbed(scene) == pytest.approx(-math.expm1(-chord), rel=1e-12)


@pytest.mark.parametrize("tracking", [None, "analog", FORCED])
@pytest.mark.parametrize(
    "place", [(0.0, 0.0), (0.0, 0.5), (0.3, 0.2)], ids=["shared face", "its edge", "within"]
)
def test_light_that_scatters_in_a_shared_face_is_lost_to_neither_box(place, tracking):
    """A beam down the very face between two boxes, and between one and a twin within a larger one: as in one box."""
    mist, other = fog(2.0, 0.9, 0.5), fog(2.0, 0.9, 0.5 * (1 + 1e-12))
    small = 1e-9  # beside the outermost face, where only what is within counts
    lamp = beam((place[0], place[1] - (small if place[1] else 0), 2), (0, 0, -1))
    found = []
    for surfaces in (
        [body(WHOLE, mist)],
        [body(HALVES[0], mist), body(HALVES[1], other)],
        [body(WHOLE, mist), body(HALVES[1], other)],
    ):
        result = run(tp.Scene(lamp, surfaces, ()), tracking)
        found.append(result.ledger["escaped"])
    for one in found[1:]:
        assert_agrees(one - found[0], 0.0, FALSE_ALARM)


# ---- births on boundaries ----


def _absorbed_in_a_ball_from_its_surface():
    """Of isotropic light from a place on a ball of radius 1, absorption 1: half enters, with chords 2 mu."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    mu = (nodes + 1) / 2
    return 0.5 * ((weights / 2) @ -np.expm1(-2 * mu))


def _absorbed_in_a_slab_from_its_face(tau):
    from transport.theory import attenuation

    return 0.5 * (1 - float(attenuation.exponential_integral(2, tau)))


LAMP = tp.Isotropic(power=1.0)


def test_a_lamp_on_the_face_of_a_ball_lights_it_with_half_of_its_light():
    lamp = tp.Source(tp.Point(position=(0, 0, 1)), LAMP)
    result = run(tp.Scene(lamp, body(tp.Sphere(radius=1.0), DARK), ()))
    assert_agrees(result.ledger["absorbed"], _absorbed_in_a_ball_from_its_surface(), FALSE_ALARM)


@pytest.mark.parametrize("way", [1, -1])
def test_a_lamp_on_the_face_of_a_slab_lights_it_with_half_of_its_light(way):
    slab = tp.Slab(center=(0.3, 0, -0.25 * way), thickness=0.5)
    result = run(tp.Scene(tp.Source(tp.Point(), LAMP), body(slab, tp.Medium(absorption=2.0)), ()))
    assert_agrees(result.ledger["absorbed"], _absorbed_in_a_slab_from_its_face(1.0), FALSE_ALARM)


@pytest.mark.parametrize("tracking", [None, "analog", FORCED])
def test_a_lamp_in_the_interface_of_two_layers_is_a_lamp_in_one(tracking):
    lamp, mist = tp.Source(tp.Point(), LAMP), {"absorption": 0.3, "scattering": 2.0}
    two = [
        body(tp.Slab(center=(0, 0, z), thickness=1.0), tp.Medium(**mist, phase=tp.HenyeyGreenstein(g)))
        for z, g in ((0.5, 1e-12), (-0.5, 2e-12))
    ]
    one = [body(tp.Slab(thickness=2.0), tp.Medium(**mist))]
    apart, together = (run(tp.Scene(lamp, surfaces, ()), tracking).ledger for surfaces in (two, one))
    assert_agrees(apart["escaped"] - together["escaped"], 0.0, FALSE_ALARM)
    assert together["escaped"].relative_error < 0.01


@pytest.mark.parametrize(("corner", "octants"), [((0.5, 0, 0), 4), ((0.5, 0.5, 0), 2), ((0.5, 0.5, 0.5), 1)])
def test_a_lamp_on_a_face_an_edge_or_a_corner_of_a_box(corner, octants):
    """The light that enters is that of octants; it is compared with that of a place just within."""
    box = body(tp.Box(size=1.0), DARK)
    on, within = (
        run(tp.Scene(tp.Source(tp.Point(position=place), LAMP), box, ())).ledger
        for place in (corner, [x * (1 - 1e-9) for x in corner])
    )
    assert_agrees(on["absorbed"] - within["absorbed"], 0.0, FALSE_ALARM)
    assert on["absorbed"].value < octants / 8


@pytest.mark.parametrize(
    ("place", "way", "chord"),
    [
        ((0.5, 0, 0), (-1, 0, 0), 1.0),
        ((0.5, 0, 0), (1, 0, 0), 0.0),
        ((0.5, 0.5, 0), (-1, -1, 0), math.sqrt(2)),
        ((0.5, 0.5, 0.5), (-1, -1, -1), math.sqrt(3)),
    ],
)
def test_beams_from_a_face_an_edge_or_a_corner(place, way, chord):
    scene = tp.Scene(beam(place, np.array(way) / np.linalg.norm(way)), body(tp.Box(size=1.0), DARK), ())
    assert absorbed(scene) == pytest.approx(-math.expm1(-chord), rel=1e-12)


# ---- numbers at their ends ----


@pytest.mark.parametrize("tau", [1e-12, 1e-9, 1e-4])
@pytest.mark.parametrize("absorption", ["weighted", "analog"])
def test_next_to_nothing_scatters_once_where_that_is_forced(tau, absorption):
    """Half of tau scatters, half of that upwards; second collisions are of the order tau^2 log tau."""
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)), body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(tau, 0.5)), faces()
    )
    result = run(scene, tp.Tracking(absorption=absorption, forced=True))
    up, down = returned_and_passed(result)
    exact = ordinates.slab(tau, 0.5) if tau > 1e-6 else None
    upwards = exact.reflected if exact else 0.25 * tau
    assert_agrees(up, upwards, FALSE_ALARM)
    assert up.relative_error < 0.01
    assert_agrees(down, 1 - 3 * upwards, FALSE_ALARM * 10) if exact is None else assert_agrees(
        down, exact.transmitted, FALSE_ALARM
    )
    with pytest.raises(AssertionError):
        assert_agrees(up, 0.5 * tau, FALSE_ALARM)


@pytest.mark.parametrize("tau", [1e-12, 1e-9])
@pytest.mark.parametrize("tracking", ["weighted", "analog"])
def test_next_to_nothing_lets_all_through(tau, tracking):
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)), body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(tau, 0.5)), faces()
    )
    result = run(scene, tracking)
    assert result["below"].flux_in.value == pytest.approx(1.0, abs=tau)
    if tracking == "weighted":
        assert result.ledger["absorbed"].value == pytest.approx(tau / 2, rel=1e-3)


@pytest.mark.parametrize("tracking", ["weighted", "analog", FORCED])
@pytest.mark.parametrize(("albedo", "g"), [(0.5, 0.0), (0.9, 0.75), (0.99, -0.5)])
def test_ten_thousand_mean_free_paths_are_a_half_space(albedo, g, tracking):
    exact = ordinates.half_space(albedo, ordinates.henyey_greenstein(g))
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)),
        body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(1e4, albedo, g)),
        faces(),
    )
    result = run(scene, tracking, 20_000)
    assert_agrees(result["above"].flux_in, exact.reflected, FALSE_ALARM)
    assert result["below"].flux_in.value == 0


@pytest.mark.parametrize("tracking", ["weighted", "analog", FORCED])
def test_an_albedo_of_one_less_a_billionth(tracking):
    exact = ordinates.slab(2.0, 1.0)
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)),
        body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(2.0, 1 - 1e-9)),
        faces(),
    )
    result = run(scene, tracking)
    up, down = returned_and_passed(result)
    assert_agrees(up, exact.reflected, FALSE_ALARM)
    assert up.value + down.value == pytest.approx(1, abs=1e-7)
    if tracking == "weighted":  # absorbed: 1e-9 of the collisions
        collisions = result.cost.collisions / 50_000
        assert result.ledger["absorbed"].value == pytest.approx(1e-9 * collisions, rel=0.02)


@pytest.mark.parametrize("tracking", ["weighted", "analog", FORCED])
@pytest.mark.parametrize("g", [1e-15, -1e-15, 1e-300])
def test_next_to_no_asymmetry_is_none(g, tracking):
    """To the last digit what isotropic scattering in a loop of its own gives, or as near as errors tell."""
    exact = ordinates.slab(2.0, 0.9)
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)),
        body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(2.0, 0.9, g)),
        faces(),
    )
    for estimate, value in zip(
        returned_and_passed(run(scene, tracking)), (exact.reflected, exact.transmitted), strict=True
    ):
        assert_agrees(estimate, value, FALSE_ALARM)


def _small_angles(tau, albedo, g):
    """Of scattering through angles of g -> 1: straight on, so that only absorption counts.  Of g -> -1: the two-stream slab.

    With every scattering back along the same line, up and down: R, T of two streams with backward scattering.
    """
    if g > 0:
        return 0.0, math.exp(-(1 - albedo) * tau)
    rate = math.sqrt(1 - albedo**2)
    denominator = rate * math.cosh(rate * tau) + math.sinh(rate * tau)
    return albedo * math.sinh(rate * tau) / denominator, rate / denominator


@pytest.mark.parametrize("tracking", ["weighted", "analog", FORCED])
@pytest.mark.parametrize("g", [1 - 1e-9, -1 + 1e-9])
def test_peaks_straight_on_and_straight_back_are_lines(g, tracking):
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)),
        body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(2.0, 0.9, g)),
        faces(),
    )
    up, down = returned_and_passed(run(scene, tracking))
    exact = _small_angles(2.0, 0.9, g)
    assert abs(up.value - exact[0]) <= 4.42 * (up.error if exact[0] else 0) + 1e-4
    assert abs(down.value - exact[1]) <= 4.42 * (down.error if np.isfinite(down.error) else 0) + 1e-4


@pytest.mark.parametrize("g", [0.999, -0.999])
def test_narrow_peaks_keep_what_all_phases_keep(g):
    """R + T + A = 1 and, all ways of following them, the same R and T."""
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)),
        body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(2.0, 0.9, g)),
        faces(),
    )
    weighted, analog, forced = (
        returned_and_passed(run(scene, t, 100_000)) for t in ("weighted", "analog", FORCED)
    )
    lines = _small_angles(2.0, 0.9, g)
    for part in (0, 1):
        for other in (analog, forced):
            assert_agrees(weighted[part] - other[part], 0.0, FALSE_ALARM)
        assert weighted[part].value == pytest.approx(lines[part], abs=0.02)


@pytest.mark.parametrize(
    "wall", [tp.Mirror(), tp.Dielectric(1.5, 1.5), tp.Diffuse(1.0)], ids=["mirror", "no change", "white"]
)
def test_a_box_of_conservative_fog_keeps_or_passes_all(wall):
    """Nothing is absorbed: against the clock all is in flight; without one all gets out of what lets light out."""
    mist = tp.Medium(scattering=3.0, phase=tp.HenyeyGreenstein(0.5), index=1.5)
    is_open = isinstance(wall, tp.Dielectric)
    surfaces = tp.Surface(tp.Box(size=1.0), wall, "box", inside=mist)
    around = tp.Medium(index=1.5) if is_open else None
    lamp = tp.Source(tp.Point(position=(0.1, 0.2, 0.3)), tp.Isotropic(power=1.0))
    ledger = run(tp.Scene(lamp, surfaces, (), medium=around, duration=1e-7), "analog", 2_000).ledger
    assert ledger["absorbed"].value == 0
    assert ledger["in_flight"].value == pytest.approx(1e-7, rel=1e-14)
    if is_open:
        ledger = run(tp.Scene(lamp, surfaces, (), medium=around), None, 2_000).ledger
        assert ledger["escaped"].value == pytest.approx(1, rel=1e-14)


@pytest.mark.parametrize("gap", [0.0, 1e-15, 1e-13, 1e-12, 1e-11])
def test_a_meter_a_thin_gap_beyond_the_outermost_face_sees_what_leaves(gap):
    """What is taken for gone at the last face must not have a meter before it, however near."""
    slab = body(tp.Slab(center=(0, 0, -1 - gap), thickness=2.0), tp.Medium(absorption=0.1, scattering=0.9))
    scene = tp.Scene(beam((0, 0, 1), (0, 0, -1)), slab, tp.Detector(tp.Plane(), "top"))
    result = run(scene, "analog")
    exact = ordinates.slab(2.0, 0.9, mu0=1.0).reflected
    assert_agrees(result["top"].flux_out, float(exact), FALSE_ALARM)
