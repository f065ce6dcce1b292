"""Point detectors against exact fluence rates: straight, through media, and after scattering.

What does not depend on chance is asked to 1e-12; the rest with 1e-6 false alarms each and fixed seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import transport as tp
from tests.agreement import assert_agrees, assert_z_spread, smallest_bias
from transport.theory import point_source

T, M, V = tp.Transparent(), tp.Medium, tp.Vacuum()
LAMP = tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=2.0))
FOG = M(absorption=0.1, scattering=0.9)


def filled(shape, medium, material=T):
    return tp.Surface(shape, material, inside=medium)


def seen(sources, places, surfaces=(), particles=1000, seed=1, tracking=None, extra=(), **options):
    """Readings at these places, as they are named by their number; the result last."""
    points = [tp.PointDetector(place, f"p{k}") for k, place in enumerate(places)]
    scene = tp.Scene(sources, surfaces, [*points, *extra], **options)
    result = tp.simulate(scene, particles=particles, seed=seed, threads=1, progress=False, tracking=tracking)
    return *(result[point.name].fluence_rate for point in points), result


def straight(distance, depth=0.0, power=2.0):
    """From a point source: power exp(-tau) / (4 pi r^2)."""
    return power * math.exp(-depth) / (4 * math.pi * distance**2)


def assert_is(estimate, exact):
    assert estimate.exact
    assert estimate.value == pytest.approx(exact, rel=1e-12, abs=0)


# ---- straight from where light is born ----


@pytest.mark.parametrize("unit", [1.0, 1e-6, 1.5e11])
def test_a_point_source_in_vacuum_falls_with_the_square_of_the_distance(unit):
    lamp = tp.Source(tp.Point(position=(unit, 0, 0)), tp.Isotropic(power=2.0))
    *found, result = seen(lamp, [(4 * unit, 4 * unit, 0), (-9 * unit, 0, 0), (unit, 0, 0.01 * unit)])
    for estimate, distance in zip(found, (5.0, 10.0, 0.01), strict=True):
        assert_is(estimate, straight(distance * unit))
        assert str(estimate.unit) == "W m^-2"
    assert result["p0"].counts.value == 1000
    assert not result.warnings


def test_an_absorber_dims_by_its_optical_depth():
    for tracking in ("weighted", "analog"):
        near, far, _ = seen(LAMP, [(0, 0.5, 0), (3, 0, 4)], medium=M(absorption=0.7), tracking=tracking)
        assert_is(near, straight(0.5, 0.35))
        assert_is(far, straight(5.0, 3.5))


def test_nested_boxes_a_ball_and_a_void_dim_each_by_its_own_way():
    surfaces = [
        filled(tp.Box(size=2.0), M(0.7)),
        filled(tp.Box(size=1.0), M(0.2)),
        filled(tp.Box(center=(3, 0, 0), size=2.0), V),
        filled(tp.Sphere(center=(3, 0, 0), radius=0.5), M(1.3)),
    ]
    places = [(5, 0, 0), (0.8, 0.1, 0), (0, 0, 0.3), (2.5, 0.25, 0), (3, 0, 0.2)]
    *found, _ = seen(LAMP, places, surfaces, medium=M(0.1))
    ways = [
        [(0.2, 0.5), (0.7, 0.5), (0.1, 1.0), (1.3, 1.0), (0.1, 1.0)],
        [(0.2, 0.5), (0.7, 0.3)],
        [(0.2, 0.0)],
        [(0.2, 0.5), (0.7, 0.5), (0.1, 1.0)],
        [(0.2, 0.5), (0.7, 0.5), (0.1, 1.0)],
    ]
    for k, (estimate, place, way) in enumerate(zip(found, places, ways, strict=True)):
        distance = math.hypot(*place)
        slope = place[0] / distance or 1.0
        depth = sum(sigma * length / slope for sigma, length in way)
        if k == 2:
            depth = 0.2 * 0.3
        if k in (3, 4):
            depth += 1.3 * way_in_ball(place)
        assert_is(estimate, straight(distance, depth))


def way_in_ball(place, center=3.0, radius=0.5):
    """Length in the ball of the straight way from the origin to a place in it."""
    distance = math.hypot(*place)
    foot = center * place[0] / distance
    entry = foot - math.sqrt(radius**2 - (center**2 - foot**2))
    return max(0.0, distance - entry)


def test_a_mesh_that_is_filled_dims_what_passes_through_it():
    ball = tp.Mesh.sphere(radius=1.0, triangles=320)
    (found, _) = seen(LAMP, [(2.0, 0.3, 0.1)], [filled(ball, M(0.8))])
    box, _ = seen(LAMP, [(2.0, 0.3, 0.1)], [filled(tp.Sphere(radius=1.0), M(0.8))])
    assert found.value == pytest.approx(box.value, rel=0.03)
    assert box.value < found.value < straight(math.hypot(2.0, 0.3, 0.1))


def test_a_grid_dims_voxel_by_voxel():
    absorption = np.array([0.1, 0.9, 0.3, 1.7]).reshape(4, 1, 1)
    grid = tp.Grid(box=tp.Box(center=(2, 0, 0), size=2.0), absorption=absorption)
    beyond, within, _ = seen(LAMP, [(4, 0, 0), (2.25, 0, 0)], [filled(grid.box, grid)])
    assert_is(beyond, straight(4.0, 0.5 * 3.0))
    assert_is(within, straight(2.25, 0.5 * 1.0 + 0.25 * 0.3))


def test_a_diffuse_disk_is_seen_by_its_solid_angle():
    """phi = L Omega, from its front only."""
    disk = tp.Disk(radius=1.0)
    lamp = tp.Source(disk, tp.Lambertian(radiance=3.0))
    above, beside, behind, _ = seen(lamp, [(0, 0, 1.5), (0.7, 0, 0.6), (0, 0, -1)], particles=400_000)
    assert_agrees(above, 6 * math.pi * (1 - 1.5 / math.hypot(1.5, 1)), 1e-6)
    assert_agrees(beside, 3 * tp.solid_angle(disk, (0.7, 0, 0.6)).value, 1e-6)
    assert behind.value == 0
    assert smallest_bias(above) < 0.003


@pytest.mark.parametrize("kind", ["ball", "mesh", "triangle", "back"])
def test_other_diffuse_emitters_are_seen_by_their_solid_angles(kind):
    place, side = (0.3, 0.2, 2.5), "front"
    shape = {
        "ball": tp.Sphere(radius=1.0),
        "mesh": tp.Mesh.sphere(radius=1.0, triangles=80),
        "triangle": tp.Triangle(vertices=[(0, 0, 0), (2, 0, 0), (0, 1, 0)]),
        "back": tp.Rectangle(width=2, height=1, normal=(0, 0, -1)),
    }[kind]
    exact = 2 * math.pi * (1 - math.sqrt(1 - 1 / math.hypot(*place) ** 2))
    if kind != "ball":
        exact = tp.solid_angle(shape, place).value
    if kind == "back":
        side = "back"
    lamp = tp.Source(shape, tp.Lambertian(radiance=1.0), side=side)
    found, _ = seen(lamp, [place], particles=200_000)
    assert_agrees(found, exact, 1e-6)


def glow_of_ball(distance):
    """Of a ball of radius 1 that emits 1 W m^-3 sr^-1: the integral of 1/r^2 over it."""
    if distance == 0:
        return 4 * math.pi
    ratio = abs((1 + distance) / (1 - distance))
    return 2 * math.pi * (1 + (1 - distance**2) / (2 * distance) * math.log(ratio))


def test_a_glowing_ball_is_seen_from_inside_from_close_by_and_from_afar():
    lamp = tp.Source(tp.Sphere(radius=1.0), tp.Isotropic(power=16 * math.pi**2 / 3))
    distances = [0.0, 0.7, 1.0, 1.2, 1.6, 3.0]
    *found, _ = seen(lamp, [(0, 0.6 * d, 0.8 * d) for d in distances], particles=300_000)
    assert found[0].value == pytest.approx(glow_of_ball(0.0), rel=1e-12)  # all chords are alike
    for estimate, distance in zip(found[1:], distances[1:], strict=True):
        exact = glow_of_ball(distance) if distance != 1.0 else 2 * math.pi
        assert_agrees(estimate, exact, 1e-6)


def test_a_glowing_box_that_absorbs_is_seen_as_thick_as_it_is():
    """Within a thick glowing medium phi is 4 pi emission / absorption, half of that on its face."""
    box = tp.Box(size=2.0)
    medium = M(absorption=40.0, emission=5.0)
    within, face, beside, _ = seen(
        (), [(0, 0.1, 0.2), (0, 0, 1.0), (0.3, 0, 0)], [filled(box, medium)], particles=200_000
    )
    assert_agrees(within, 4 * math.pi * 5 / 40, 1e-6)
    assert_agrees(beside, 4 * math.pi * 5 / 40, 1e-6)
    assert_agrees(face, 2 * math.pi * 5 / 40, 1e-6)


# ---- walls ----


def test_a_black_disk_stands_in_the_way():
    disk = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(radiance=1.0))
    moon = tp.Surface(tp.Disk(center=(0, 0, 0.75), radius=0.25), tp.Black())
    found, _ = seen(disk, [(0, 0, 1.5)], [moon], particles=400_000)
    assert_agrees(found, 2 * math.pi * (1.5 / math.hypot(1.5, 0.5) - 1.5 / math.hypot(1.5, 1)), 1e-6)
    hidden, beside, _ = seen(LAMP, [(0, 0, 1), (0.5, 0, 1)], [moon])
    assert hidden.value == 0
    assert_is(beside, straight(math.hypot(0.5, 1)))


def test_a_lit_spot_on_a_diffuse_wall_sends_by_the_cosine_law():
    """A pencil of light: phi = share P cos / (pi r^2), of what is reflected or let through."""
    pencil = tp.Source(tp.Point(position=(0, 0, 2)), tp.Beam((0, 0, -1), power=3.0))
    places = [(0, 1.2, 1.6), (0, -0.6, -0.8), (0.4, 0, 0.1)]
    wall = tp.Surface(tp.Disk(radius=1.0), tp.Diffuse(0.6))
    above, behind, low, _ = seen(pencil, places, [wall])
    assert above.value == pytest.approx(0.6 * 3 * 0.8 / (math.pi * 4), rel=1e-12)
    assert low.value == pytest.approx(0.6 * 3 * 0.1 / math.hypot(0.4, 0.1) / (math.pi * 0.17), rel=1e-12)
    assert behind.value == 0
    veil = tp.Surface(tp.Disk(radius=1.0), tp.Diffuse(0.5, transmission=0.3))
    above, behind, _, _ = seen(pencil, places, [veil], particles=100_000)
    assert_agrees(above, 0.5 * 3 * 0.8 / (math.pi * 4), 1e-6)
    assert_agrees(behind, 0.3 * 3 * 0.8 / math.pi, 1e-6)


def test_in_a_diffuse_ball_the_walls_radiosity_adds_up():
    """The wall has B = albedo E / (1 - albedo) of the direct E: phi = direct + 4 B inside."""
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.6))
    places = [(0.3, 0.2, 0.1), (0.8, 0, 0)]
    *found, _ = seen(LAMP, places, [wall], particles=200_000)
    for estimate, place in zip(found, places, strict=True):
        assert_agrees(estimate, straight(math.hypot(*place)) + 4 * 1.5 * 2 / (4 * math.pi), 1e-6)


# ---- scattering ----


@pytest.mark.parametrize("tracking", ["weighted", "analog"])
def test_a_point_source_in_fog_against_its_transform(tracking):
    distances = (0.1, 0.5, 1.0, 2.0, 5.0)
    places = [(0.6 * r, 0, 0.8 * r) for r in distances]
    *found, _ = seen(LAMP, places, particles=300_000, medium=FOG, tracking=tracking, seed=2)
    for estimate, r in zip(found, distances, strict=True):
        assert_agrees(estimate, 2 * point_source.fluence_rate(r, 1.0, 0.9), 1e-6)
    assert smallest_bias(found[0]) < 0.01 and smallest_bias(found[2]) < 0.06


def test_in_a_fog_that_seldom_scatters_it_is_not_the_source_alone():
    """What scattering adds stands out by tens of errors."""
    near, _ = seen(LAMP, [(1, 0, 0)], particles=300_000, medium=M(0.1, 0.05))
    assert_agrees(near, 2 * point_source.fluence_rate(1.0, 0.15, 1 / 3), 1e-6)
    assert near.value - straight(1, 0.15) > 30 * near.error


PHASES = {
    "isotropic": tp.Isotropic(),
    "forwards": tp.HenyeyGreenstein(0.7),
    "backwards": tp.HenyeyGreenstein(-0.4),
    "rayleigh": tp.Rayleigh(),
    "table": tp.Tabulated(mu=[-1, -0.2, 0.5, 1], density=[0.3, 0.1, 0.6, 2.0]),
    "mixture": tp.Mixture({tp.HenyeyGreenstein(0.8): 0.6, tp.Rayleigh(): 0.4}),
}


@pytest.mark.parametrize("name", PHASES)
def test_light_scattered_once_from_a_pencil_beam(name):
    """In a box so thin that light is scattered once at most: the integral along the beam of p(mu) / r^2."""
    sigma, phase = 1e-12, PHASES[name]
    pencil = tp.Source(tp.Point(position=(0, 0, -1)), tp.Beam((0, 0, 1), power=1.0))
    places = [(0.5, 0, 0.2), (0.3, 0.4, 2.0), (0, -0.6, -1.5)]
    *found, result = seen(
        pencil, places, [filled(tp.Box(size=2.0), M(scattering=sigma, phase=phase))], particles=200_000
    )
    for estimate, (x, y, z) in zip(found, places, strict=True):

        def density(t, d2=x * x + y * y, z=z):
            r = math.sqrt(d2 + (z - t) ** 2)
            return phase.density((z - t) / r) / r**2

        corners = [z] if -1 < z < 1 else None
        exact = sigma * quad(density, -1, 1, points=corners, epsabs=0, epsrel=1e-10, limit=500)[0]
        if phase == tp.Isotropic():  # then all scores are alike
            assert estimate.value == pytest.approx(exact, rel=1e-9)
        else:
            assert_agrees(estimate, exact, 1e-6)
        assert smallest_bias(estimate) < 0.03
    assert not result.warnings


def test_it_agrees_with_a_small_volume_detector():
    ball = tp.Sphere(center=(0.4, 0.2, 0.3), radius=0.05)
    voxels = np.random.default_rng(3).uniform(0.2, 2.0, (3, 4, 5))
    grid = tp.Grid(box=tp.Box(size=2.0), absorption=0.3 * voxels, scattering=voxels, phase=tp.Rayleigh())
    lamp = tp.Source(tp.Point(position=(-0.5, 0, 0)), tp.Isotropic(power=1.0))
    volume = tp.VolumeDetector(ball, name="ball")
    for tracking in ("weighted", "analog"):
        medium = M(0.3, 1.5, phase=tp.HenyeyGreenstein(0.5))
        for filling in (medium, grid):
            body = filled(tp.Box(size=2.0), filling)
            point, result = seen(
                lamp, [ball.center], [body], particles=200_000, extra=[volume], tracking=tracking
            )
            assert_agrees(point - result["ball"].fluence_rate, 0.0, 1e-6)
            assert 3 * point.error < result["ball"].fluence_rate.error


def test_a_point_beyond_a_scattering_slab_sees_what_leaks_through():
    """A wide source: beyond the slab the point sees what a large flat box about it does."""
    slab = tp.Slab(center=(0, 0, -1), thickness=2.0)
    medium = M(0.2, 1.0, phase=tp.HenyeyGreenstein(0.5))
    lamp = tp.Source(tp.Disk(center=(0, 0, -2.5), radius=30.0), tp.Lambertian(radiance=1.0))
    meter = tp.VolumeDetector(tp.Box(center=(0, 0, 1), size=(6, 6, 0.2)), name="beyond")
    point, result = seen(lamp, [(0, 0, 1)], [filled(slab, medium)], particles=200_000, extra=[meter])
    assert_agrees(point - result["beyond"].fluence_rate, 0.0, 1e-6)
    assert point.error < 0.05 * point.value


def test_splitting_and_weights_leave_the_mean_as_it_is():
    splitting = tp.Splitting(start=(0, 0, 0), end=(0, 0, 3), gain=20)
    found = [
        seen(LAMP, [(0, 0, 3)], particles=50_000, medium=FOG, seed=4, tracking=tracking)[0]
        for tracking in (
            "analog",
            "weighted",
            tp.Tracking(roulette=0.9),
            tp.Tracking(forced=True),
            tp.Tracking(splitting=splitting),
        )
    ]
    for estimate in found:
        assert_agrees(estimate, 2 * point_source.fluence_rate(3.0, 1.0, 0.9), 1e-6)


def test_what_scatters_elsewhere_is_told_from_flights_the_rest_by_detours():
    """The fog in pieces: about the point one body, elsewhere others of the very same medium."""
    pieces = [
        filled(tp.Sphere(center=(1, 0, 0), radius=0.3), FOG),
        filled(tp.Box(center=(-1, 0, 0), size=1.0), FOG),
        filled(tp.Box(center=(1, 0, 0), size=1.0), FOG),
    ]
    for tracking in ("weighted", "analog"):
        inside, beside, _ = seen(
            LAMP, [(1, 0.1, 0), (0, 1, 0)], pieces, particles=100_000, medium=FOG, tracking=tracking
        )
        for estimate, r in ((inside, math.hypot(1, 0.1)), (beside, 1.0)):
            assert_agrees(estimate, 2 * point_source.fluence_rate(r, 1.0, 0.9), 1e-6)
            assert smallest_bias(estimate) < 0.06


@pytest.mark.parametrize("filling", ["glow", "forwards", "grid", "ball"])
def test_in_a_furnace_light_is_the_same_everywhere(filling):
    """Walls and media that all emit by the radiance 1 give phi = 4 pi, whatever they do."""
    phase = {"forwards": tp.HenyeyGreenstein(0.5), "ball": tp.Rayleigh()}.get(filling, tp.Isotropic())
    medium = M(0.5, 2.0, phase, emission=0.5) if filling != "forwards" else M(0.0, 3.0, phase)
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.6), "wall", inside=medium)
    surfaces, place = [wall], (0.3, 0.1, 0.2)
    if filling in ("grid", "ball"):
        surfaces = [tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.6), "wall", inside=V)]
        voxels = np.random.default_rng(5).uniform(0.5, 4.0, (3, 2, 4))
        inner = tp.Grid(box=tp.Box(size=0.9), scattering=voxels, phase=phase)
        surfaces.append(filled(inner.box, inner))
    if filling == "ball":
        surfaces.append(
            filled(tp.Sphere(center=(0.1, 0, 0), radius=0.3), M(0.0, 2.0, tp.HenyeyGreenstein(-0.5)))
        )
    lamp = tp.Source("wall", tp.Lambertian(exitance=0.4 * math.pi), side="back")
    inside, outer, _ = seen(lamp, [place, (0, 0.75, 0.1)], surfaces, particles=200_000, seed=11)
    for estimate in (inside, outer):
        assert_agrees(estimate, 4 * math.pi, 1e-6)
        assert smallest_bias(estimate) < 0.09


# ---- how sure it is ----


def test_the_error_falls_with_the_root_of_the_number_of_particles():
    """2048 batches of 200 histories each, one by one and together in groups: N^(-1/2) but for a logarithm."""
    scene = tp.Scene(LAMP, detectors=tp.PointDetector((1, 0, 0), "p"), medium=FOG)
    result = tp.simulate(scene, particles=200 * 2048, batches=2048, seed=3, threads=1, progress=False)
    exact = 2 * point_source.fluence_rate(1.0, 1.0, 0.9)
    values = result["p"].batch_values / exact - 1
    sizes = 4 ** np.arange(5)
    errors = [float(np.sqrt((values.reshape(-1, n).mean(axis=1) ** 2).mean())) for n in sizes]
    slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert -0.56 < slope < -0.44, (slope, errors)
    assert abs(values.mean()) < 5 * values.std() / math.sqrt(len(values))


def test_its_error_bars_are_right():
    """z over 300 short runs has mean 0 and spread 1: the variance is finite, and known from 32 batches."""
    scene = tp.Scene(LAMP, detectors=tp.PointDetector((1, 0, 0), "p"), medium=FOG)
    exact = 2 * point_source.fluence_rate(1.0, 1.0, 0.9)
    runs = (tp.simulate(scene, particles=4000, seed=seed, threads=1, progress=False) for seed in range(300))
    assert_z_spread(np.array([run["p"].fluence_rate.z(exact) for run in runs]), math.inf, 1e-6)


def test_scores_that_stand_out_are_told():
    """Behind a thick shield the few histories that got through it carry all."""
    slab = filled(tp.Slab(center=(0, 0, 8), thickness=12.0), M(0.7, 0.3))
    _, result = seen(LAMP, [(0, 0, 15)], [slab], particles=2000)
    assert any("'p0'" in warning and "not to be trusted" in warning for warning in result.warnings)
    assert "not to be trusted" in result.report()
    *_, result = seen(LAMP, [(0, 0, 1), (3, 0, 0)], [slab], particles=20_000)
    assert not result.warnings


def test_a_score_of_any_size_is_counted():
    """On the very line of a pencil beam in a fog phi is infinite: the scores are huge, finite and told."""
    pencil = tp.Source(tp.Point(position=(0, 0, -1)), tp.Beam((0, 0, 1), power=1.0))
    huge, faint, _ = seen(pencil, [(0, 0, 0), (0, 600, 0)], particles=1000, medium=FOG)
    assert 1e60 < huge.value < math.inf
    assert 0 < faint.value < 1e-100


def test_what_it_scores_does_not_depend_on_threads_batches_or_other_detectors():
    places, surfaces = [(1, 0, 0), (0, 0.5, 0)], [filled(tp.Box(size=3.0), M(0.1, 1.0, tp.Rayleigh()))]
    scene = tp.Scene(LAMP, surfaces, [tp.PointDetector(place, f"p{k}") for k, place in enumerate(places)])
    options = {"particles": 20_000, "seed": 7, "batches": 8, "progress": False}
    one, two = (tp.simulate(scene, threads=threads, **options) for threads in (1, 2))
    alone = tp.simulate(tp.Scene(LAMP, surfaces, tp.PointDetector(places[0], "p0")), threads=1, **options)
    for name in ("p0", "p1"):
        assert (one[name].batch_values == two[name].batch_values).all()
    assert (one["p0"].batch_values == alone["p0"].batch_values).all()
    assert (one["p0"].counts.value, one["p1"].counts.value) == (
        two["p0"].counts.value,
        two["p1"].counts.value,
    )


def test_it_leaves_everything_else_as_it_is():
    """Flights draw what they draw without it."""
    surfaces = [
        filled(tp.Box(size=3.0), M(0.1, 1.0)),
        tp.Surface(tp.Plane(center=(0, 0, -2)), tp.Diffuse(0.5)),
    ]
    meter = tp.Detector(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1.0), name="meter")
    options = {"particles": 20_000, "seed": 7, "threads": 1, "progress": False}
    without = tp.simulate(tp.Scene(LAMP, surfaces, [meter]), **options)
    with_it = tp.simulate(tp.Scene(LAMP, surfaces, [meter, tp.PointDetector((1, 0, 0.2), "p")]), **options)
    assert without["meter"].flux_in.value == with_it["meter"].flux_in.value
    assert without.cost.collisions == with_it.cost.collisions
    for name, entry in without.ledger.items():
        assert entry.value == with_it.ledger[name].value


def test_a_scene_without_it_has_none_of_its_passes():
    from transport.compile import compile_scene
    from transport.engine import casting, densities, detours, shadows
    from transport.engine.passes import Pass
    from transport.engine.program import program_of

    plain = tp.Scene(LAMP, medium=FOG)
    program = program_of(compile_scene(plain))
    names = {lane_pass.name for lane_pass in program.passes}
    assert not program.sight
    assert not names & {
        p.name
        for module in (casting, densities, detours, shadows)
        for p in vars(module).values()
        if isinstance(p, Pass)
    }
    absorbing = tp.Scene(LAMP, detectors=tp.PointDetector((1, 0, 0), "p"), medium=M(0.3))
    names = {lane_pass.name for lane_pass in program_of(compile_scene(absorbing)).passes}
    assert "cast_from_births" in names and "cast_from_flights" not in names


# ---- what is refused ----


def refused(message, sources=LAMP, surfaces=(), place=(1, 0, 0), tracking=None, **options):
    with pytest.raises(tp.SceneError) as raised:
        scene = tp.Scene(sources, surfaces, tp.PointDetector(place, "p"), **options)
        tp.simulate(scene, particles=100, progress=False, tracking=tracking)
    text = str(raised.value)
    assert text.startswith("PointDetector 'p'") and message in text, text


@pytest.mark.parametrize(
    "material",
    [
        tp.Mirror(),
        tp.Dielectric(1.5),
        tp.Glossy(0.2),
        tp.ThinLens(1.0),
        tp.Mixture({T: 0.5, tp.Black(): 0.5}),
    ],
)
def test_surfaces_that_it_cannot_see_by_are_refused_by_name(material):
    part = next(
        part for part in (*getattr(material, "parts", ((material,),)),) if not isinstance(part[0], tp.Black)
    )[0]
    disk = tp.Surface(tp.Disk(center=(5, 0, 0), radius=1.0), material, name="glass")
    refused(type(part).__name__, surfaces=[disk])
    refused("'glass'", surfaces=[disk])


def test_points_on_surfaces_and_sources_are_refused():
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.5), name="wall")
    refused("must not lie on Surface 'wall'", surfaces=[wall], place=(0.6, 0.8, 0))
    refused("point source", place=(0, 0, 0))
    disk = tp.Source(tp.Disk(radius=2.0), tp.Lambertian(power=1.0))
    refused("must not lie on a source", sources=disk)
    tp.Scene(disk, detectors=tp.PointDetector((3, 0, 0), "beside"))


def test_clocks_aims_gas_and_forced_flights_are_refused():
    refused("steady", duration=1.0)
    aim = tp.Disk(center=(0, 0, 3), radius=1.0)
    refused("aim", sources=tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=1.0), aim=aim))
    gas = tp.Effusive(exitance=1.0, speed=1.0)
    refused("Effusive", sources=tp.Source(tp.Disk(radius=0.5), gas))
    box = filled(tp.Box(size=1.0), FOG)
    refused("forced", surfaces=[box], tracking=tp.Tracking(forced=True))


@pytest.mark.parametrize(
    "wrong, message",
    [
        ({"position": (0, 0), "name": "p"}, "position"),
        ({"position": (0, 0, math.inf), "name": "p"}, "position"),
        ({"position": (0, 0, 1)}, "name missing"),
        ({"position": (0, 0, 1), "name": None}, "name"),
        ({"position": (0, 0, 1), "name": "a.b"}, "name"),
        ({"center": (0, 0, 1), "name": "p"}, "'position'"),
    ],
)
def test_its_parameters_are_checked(wrong, message):
    with pytest.raises(tp.SceneError, match=message):
        tp.PointDetector(**wrong)


def test_errors_can_be_asked_for_and_unknown_quantities_are_told():
    scene = tp.Scene(LAMP, detectors=tp.PointDetector((1, 0, 0), "p"), medium=FOG)
    result = tp.simulate(
        scene, error={"p.fluence_rate": 0.05}, particles=100_000, seed=1, threads=1, progress=False
    )
    assert result["p"].fluence_rate.relative_error < 0.05
    with pytest.raises(tp.SceneError, match="fluence_rate"):
        tp.simulate(scene, error={"p.fluence": 0.1}, particles=1000)
    with pytest.raises(AttributeError, match="fluence_rate"):
        _ = result["p"].fluence
    assert "point detector 'p'" in result.report()
