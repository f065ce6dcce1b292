"""Point detectors against exact fluence rates: straight from lamps, glowing bodies and walls, and after scattering.

What does not depend on chance is asked to 1e-12; the rest with 1e-6 false alarms each and fixed seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

import transport as tp
from tests.agreement import assert_agrees, assert_z_spread, smallest_bias
from tests.point_scenes import FOG, LAMP, M, V, filled, seen
from tests.slow import quick
from transport.compile import points
from transport.compile.compiler import compile_scene
from transport.scene.phase_functions import Phase
from transport.theory import point_source

DISK, BALL = tp.Disk(radius=1.0), tp.Sphere(radius=1.0)
PENCIL = tp.Source(tp.Point(position=(0, 0, -1)), tp.Beam((0, 0, 1), power=1.0))
BOTH = pytest.mark.parametrize("tracking", ["weighted", "analog"])


def straight(distance, depth=0.0, power=2.0):
    """From a point source: power exp(-tau) / (4 pi r^2)."""
    return power * math.exp(-depth) / (4 * math.pi * distance**2)


def in_fog(distance):
    """From LAMP in FOG without end."""
    return 2 * point_source.fluence_rate(distance, 1.0, 0.9)


def assert_is(estimate, exact):
    assert estimate.exact
    assert estimate.value == pytest.approx(exact, rel=1e-12, abs=0)


def assert_sharp(estimate, exact, bias):
    assert_agrees(estimate, exact, 1e-6)
    assert smallest_bias(estimate) < bias


# ---- straight from where light is born ----


@pytest.mark.parametrize("unit", [1.0, 1e-6, 1.5e11])
def test_a_point_source_in_vacuum_falls_with_the_square_of_the_distance(unit):
    lamp = tp.Source(tp.Point(position=(unit, 0, 0)), tp.Isotropic(power=2.0))
    *found, result = seen(lamp, [(4 * unit, 4 * unit, 0), (-9 * unit, 0, 0), (unit, 0, 0.01 * unit)])
    for estimate, distance in zip(found, (5.0, 10.0, 0.01), strict=True):
        assert_is(estimate, straight(distance * unit))
        assert str(estimate.unit) == "W m^-2"
    assert result["p0"].counts.value == 1000 and not result.warnings


@BOTH
def test_an_absorber_dims_by_its_optical_depth(tracking):
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
    to_void = [(0.2, 0.5), (0.7, 0.5), (0.1, 1.0)]
    ways = {  # (extinction, length along x) on the way to each place
        (5, 0, 0): [*to_void, (1.3, 1.0), (0.1, 1.0)],
        (0.8, 0.1, 0): [(0.2, 0.5), (0.7, 0.3)],
        (2.5, 0.25, 0): to_void,
        (3, 0, 0.2): to_void,
        (0, 0, 0.3): [],
    }
    *found, _ = seen(LAMP, list(ways), surfaces, medium=M(0.1))
    for estimate, (place, way) in zip(found, ways.items(), strict=True):
        distance = math.hypot(*place)
        depth = sum(sigma * length * distance / place[0] for sigma, length in way) or 0.2 * 0.3
        depth += 1.3 * way_in_ball(place) if way is to_void else 0
        assert_is(estimate, straight(distance, depth))


def way_in_ball(place, center=3.0, radius=0.5):
    """Length in the ball of the straight way from the origin to a place in it."""
    distance = math.hypot(*place)
    foot = center * place[0] / distance
    return max(0.0, distance - foot + math.sqrt(radius**2 - (center**2 - foot**2)))


@pytest.mark.slow
def test_a_mesh_that_is_filled_dims_what_passes_through_it():
    mesh, _ = seen(LAMP, [(2.0, 0.3, 0.1)], [filled(tp.Mesh.sphere(radius=1.0, triangles=320), M(0.8))])
    ball, _ = seen(LAMP, [(2.0, 0.3, 0.1)], [filled(BALL, M(0.8))])
    assert mesh.value == pytest.approx(ball.value, rel=0.03)
    assert ball.value < mesh.value < straight(math.hypot(2.0, 0.3, 0.1))


def test_a_grid_dims_voxel_by_voxel():
    absorption = np.array([0.1, 0.9, 0.3, 1.7]).reshape(4, 1, 1)
    grid = tp.Grid(box=tp.Box(center=(2, 0, 0), size=2.0), absorption=absorption)
    beyond, within, _ = seen(LAMP, [(4, 0, 0), (2.25, 0, 0)], [filled(grid.box, grid)])
    assert_is(beyond, straight(4.0, 0.5 * 3.0))
    assert_is(within, straight(2.25, 0.5 * 1.0 + 0.25 * 0.3))


def test_a_diffuse_disk_is_seen_by_its_solid_angle():
    """phi = L Omega, from its front only."""
    lamp = tp.Source(DISK, tp.Lambertian(radiance=3.0))
    above, beside, behind, _ = seen(lamp, [(0, 0, 1.5), (0.7, 0, 0.6), (0, 0, -1)], particles=400_000)
    assert_sharp(above, 6 * math.pi * (1 - 1.5 / math.hypot(1.5, 1)), 0.003)
    assert_agrees(beside, 3 * tp.solid_angle(DISK, (0.7, 0, 0.6)).value, 1e-6)
    assert behind.value == 0


@pytest.mark.quick_cases("ball", "triangle")
@pytest.mark.parametrize(
    ("shape", "side"),
    [
        (BALL, "front"),
        (tp.Mesh.sphere(radius=1.0, triangles=80), "front"),
        (tp.Triangle(vertices=[(0, 0, 0), (2, 0, 0), (0, 1, 0)]), "front"),
        (tp.Rectangle(width=2, height=1, normal=(0, 0, -1)), "back"),
    ],
    ids=["ball", "mesh", "triangle", "back"],
)
def test_other_diffuse_emitters_are_seen_by_their_solid_angles(shape, side):
    place = (0.3, 0.2, 2.5)
    if shape is BALL:
        exact = 2 * math.pi * (1 - math.sqrt(1 - 1 / math.hypot(*place) ** 2))
    else:
        exact = tp.solid_angle(shape, place).value
    found, _ = seen(tp.Source(shape, tp.Lambertian(radiance=1.0), side=side), [place], particles=200_000)
    assert_agrees(found, exact, 1e-6)


def glow_of_ball(distance):
    """Of a ball of radius 1 that emits 1 W m^-3 sr^-1: the integral of 1/r^2 over it."""
    if distance in (0, 1):
        return {0: 4, 1: 2}[distance] * math.pi
    ratio = abs((1 + distance) / (1 - distance))
    return 2 * math.pi * (1 + (1 - distance**2) / (2 * distance) * math.log(ratio))


def test_a_glowing_ball_is_seen_from_inside_from_close_by_and_from_afar():
    lamp = tp.Source(BALL, tp.Isotropic(power=16 * math.pi**2 / 3))
    distances = [0.0, 0.7, 1.0, 1.2, 1.6, 3.0]
    *found, _ = seen(lamp, [(0, 0.6 * d, 0.8 * d) for d in distances], particles=300_000)
    assert found[0].value == pytest.approx(glow_of_ball(0.0), rel=1e-12)  # all chords are alike
    for estimate, distance in zip(found[1:], distances[1:], strict=True):
        assert_agrees(estimate, glow_of_ball(distance), 1e-6)


def glow_of_box(size, place):
    """The integral of 1/r^2 over a box about the origin that emits 1 W m^-3 sr^-1, as cones on its faces.

    A face at the height h adds the integral of h/r^2 over it, with h < 0 where the place is beyond its plane.
    """
    total = 0.0
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1, 1):
            h = size[axis] / 2 - sign * place[axis]
            ends = [(-size[k] / 2 - place[k], size[k] / 2 - place[k]) for k in (i, j)]
            total += h * dblquad(lambda u, v, h=h: 1 / (h * h + u * u + v * v), *ends[0], *ends[1])[0]
    return total


def test_a_glowing_box_is_seen_from_inside_from_close_by_and_from_afar():
    """From within, from both sides of each axis, and from so far that it is treated as any other lamp."""
    size = (1.0, 2.0, 0.5)
    lamp = tp.Source(tp.Box(size=size), tp.Isotropic(power=4 * math.pi * math.prod(size)))
    places = [(0, 0, 0), (0.3, -0.8, 0.1), (0.7, 0, 0), (-0.7, 0, 0), (0.2, 1.2, 0), (0.2, -1.2, 0)]
    places += [(0, 0, 0.4), (0, 0, -0.4), (2.0, 3.0, 1.0)]
    *found, _ = seen(lamp, places, particles=400_000)
    for estimate, place in zip(found, places, strict=True):
        assert_sharp(estimate, glow_of_box(size, place), 0.05)


def test_a_glowing_box_that_absorbs_is_seen_as_thick_as_it_is():
    """Within a thick glowing medium phi is 4 pi emission / absorption, half of that on its face."""
    body, places = filled(tp.Box(size=2.0), M(absorption=40.0, emission=5.0)), [(0, 0.1, 0.2), (0.3, 0, 0)]
    *within, face, _ = seen((), [*places, (0, 0, 1.0)], [body], particles=200_000)
    for estimate in within:
        assert_agrees(estimate, 4 * math.pi * 5 / 40, 1e-6)
    assert_agrees(face, 2 * math.pi * 5 / 40, 1e-6)


# ---- walls ----


def test_a_black_disk_stands_in_the_way():
    moon = tp.Surface(tp.Disk(center=(0, 0, 0.75), radius=0.25), tp.Black())
    found, _ = seen(tp.Source(DISK, tp.Lambertian(radiance=1.0)), [(0, 0, 1.5)], [moon], particles=400_000)
    assert_agrees(found, 2 * math.pi * (1.5 / math.hypot(1.5, 0.5) - 1.5 / math.hypot(1.5, 1)), 1e-6)
    hidden, beside, _ = seen(LAMP, [(0, 0, 1), (0.5, 0, 1)], [moon])
    assert hidden.value == 0
    assert_is(beside, straight(math.hypot(0.5, 1)))


def test_a_lit_spot_on_a_diffuse_wall_sends_by_the_cosine_law():
    """A pencil of light: phi = share P cos / (pi r^2), of what is reflected or let through."""
    pencil = tp.Source(tp.Point(position=(0, 0, 2)), tp.Beam((0, 0, -1), power=3.0))
    places = [(0, 1.2, 1.6), (0, -0.6, -0.8), (0.4, 0, 0.1)]
    above, behind, low, _ = seen(pencil, places, [tp.Surface(DISK, tp.Diffuse(0.6))])
    assert above.value == pytest.approx(0.6 * 3 * 0.8 / (math.pi * 4), rel=1e-12)
    assert low.value == pytest.approx(0.6 * 3 * 0.1 / math.hypot(0.4, 0.1) / (math.pi * 0.17), rel=1e-12)
    assert behind.value == 0
    veil = tp.Surface(DISK, tp.Diffuse(0.5, transmission=0.3))
    above, behind, _, _ = seen(pencil, places, [veil], particles=100_000)
    assert_agrees(above, 0.5 * 3 * 0.8 / (math.pi * 4), 1e-6)
    assert_agrees(behind, 0.3 * 3 * 0.8 / math.pi, 1e-6)


def test_in_a_diffuse_ball_the_walls_radiosity_adds_up():
    """The wall has B = albedo E / (1 - albedo) of the direct E: phi = direct + 4 B inside."""
    places = [(0.3, 0.2, 0.1), (0.8, 0, 0)]
    *found, _ = seen(LAMP, places, [tp.Surface(BALL, tp.Diffuse(0.6))], particles=200_000)
    for estimate, place in zip(found, places, strict=True):
        assert_agrees(estimate, straight(math.hypot(*place)) + 4 * 1.5 * 2 / (4 * math.pi), 1e-6)


# ---- scattered ----


@BOTH
def test_a_point_source_in_fog_against_its_transform(tracking):
    distances = (0.1, 0.5, 1.0, 2.0, 5.0)
    places = [(0.6 * r, 0, 0.8 * r) for r in distances]
    *found, _ = seen(LAMP, places, particles=300_000, medium=FOG, tracking=tracking, seed=2)
    for estimate, r in zip(found, distances, strict=True):
        assert_agrees(estimate, in_fog(r), 1e-6)
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


@pytest.mark.parametrize("name", quick(PHASES, "forwards", "table"))
def test_light_scattered_once_from_a_pencil_beam(name):
    """In a box so thin that light is scattered once at most: the integral along the beam of p(mu) / r^2."""
    sigma, phase = 1e-12, PHASES[name]
    places = [(0.5, 0, 0.2), (0.3, 0.4, 2.0), (0, -0.6, -1.5)]
    box = filled(tp.Box(size=2.0), M(scattering=sigma, phase=phase))
    *found, result = seen(PENCIL, places, [box], particles=200_000)
    for estimate, (x, y, z) in zip(found, places, strict=True):

        def density(t, d2=x * x + y * y, z=z):
            r = math.sqrt(d2 + (z - t) ** 2)
            return phase.density((z - t) / r) / r**2

        corners = [z] if -1 < z < 1 else None
        exact = sigma * quad(density, -1, 1, points=corners, epsabs=0, epsrel=1e-10, limit=500)[0]
        if estimate.relative_error < 1e-9:  # where all scores are alike
            assert estimate.value == pytest.approx(exact, rel=1e-9)
        else:
            assert_agrees(estimate, exact, 1e-6)
        assert smallest_bias(estimate) < 0.03
    assert not result.warnings


@pytest.mark.parametrize("name", PHASES)
def test_a_speck_in_a_beam_scatters_by_its_phase_function(name):
    """All that is scattered is seen under one angle: each point knows p(mu) to a millionth."""
    phase, radius, sigma, r = PHASES[name], 1e-5, 1e-6, 2.0
    cosines = np.array([-0.9, -0.35, 0.0, 0.2, 0.65, 0.999])  # between the table's kinks
    sines = np.sqrt((1 - cosines) * (1 + cosines))
    places = map(tuple, r * np.stack([0.6 * sines, 0.8 * sines, cosines], axis=1))
    *found, _ = seen(PENCIL, places, [filled(tp.Sphere(radius=radius), M(scattering=sigma, phase=phase))])
    exact = sigma * 2 * radius * phase.density(cosines) / r**2
    assert [estimate.value for estimate in found] == pytest.approx(exact, rel=2e-6)


@pytest.mark.slow
@BOTH
@pytest.mark.parametrize("g", [0.6, -0.4])
def test_about_a_lamp_in_a_ball_of_fog_points_read_what_thin_shells_do(g, tracking):
    """Within the fog by detours, beyond it by flights; a cosine of the wrong sign or a lost exp(-tau) shows."""
    ball, radii = filled(tp.Sphere(radius=1.5), M(0.8, 1.2, tp.HenyeyGreenstein(g))), {"in": 0.8, "out": 2.0}
    shells = [
        tp.VolumeDetector(tp.Sphere(radius=1.01 * r), name, (0.99 * r, 1.01 * r)) for name, r in radii.items()
    ]
    places = [(0.6 * r, 0, 0.8 * r) for r in radii.values()]
    *points, result = seen(LAMP, places, [ball], particles=200_000, extra=shells, tracking=tracking)
    for name, point in zip(radii, points, strict=True):
        shell = result[name].fluence_rate[0]
        assert_agrees(point - shell, 0.0, 1e-6)
        assert max(smallest_bias(point), smallest_bias(shell)) < 0.08


def test_a_point_beyond_a_scattering_slab_sees_what_leaks_through():
    """A wide source: beyond the slab the point sees what a large flat box about it does."""
    slab = filled(tp.Slab(center=(0, 0, -1), thickness=2.0), M(0.2, 1.0, phase=tp.HenyeyGreenstein(0.5)))
    lamp = tp.Source(tp.Disk(center=(0, 0, -2.5), radius=30.0), tp.Lambertian(radiance=1.0))
    meter = tp.VolumeDetector(tp.Box(center=(0, 0, 1), size=(6, 6, 0.2)), name="beyond")
    point, result = seen(lamp, [(0, 0, 1)], [slab], particles=200_000, extra=[meter])
    assert_agrees(point - result["beyond"].fluence_rate, 0.0, 1e-6)
    assert point.error < 0.05 * point.value


@pytest.mark.quick_cases("analog", "roulette")
@pytest.mark.parametrize(
    "tracking",
    [
        "analog",
        "weighted",
        tp.Tracking(roulette=0.9),
        tp.Tracking(forced=True),
        tp.Tracking(splitting=tp.Splitting(start=(0, 0, 0), end=(0, 0, 3), gain=20)),
    ],
    ids=["analog", "weighted", "roulette", "forced", "split"],
)
def test_splitting_and_weights_leave_the_mean_as_it_is(tracking):
    found, _ = seen(LAMP, [(0, 0, 3)], particles=50_000, medium=FOG, seed=4, tracking=tracking)
    assert_agrees(found, in_fog(3.0), 1e-6)


@BOTH
def test_light_scattered_elsewhere_comes_from_flights_and_the_rest_by_detours(tracking):
    """The fog in pieces: about the point one body, elsewhere others of the very same medium."""
    shapes = [tp.Sphere(center=(1, 0, 0), radius=0.3), tp.Box(center=(-1, 0, 0), size=1.0)]
    pieces = [filled(shape, FOG) for shape in (*shapes, tp.Box(center=(1, 0, 0), size=1.0))]
    places = [(1, 0.1, 0), (0, 1, 0)]
    *found, _ = seen(LAMP, places, pieces, particles=100_000, medium=FOG, tracking=tracking)
    for estimate, place in zip(found, places, strict=True):
        assert_sharp(estimate, in_fog(math.hypot(*place)), 0.06)


@pytest.mark.slow
@pytest.mark.parametrize("filling", ["glow", "forwards", "grid", "ball"])
def test_in_a_furnace_light_is_the_same_everywhere(filling):
    """Walls and media that all emit by the radiance 1 give phi = 4 pi, whatever they do."""
    phase = {"forwards": tp.HenyeyGreenstein(0.5), "ball": tp.Rayleigh()}.get(filling, tp.Isotropic())
    medium = {"glow": M(0.5, 2.0, phase, emission=0.5), "forwards": M(0.0, 3.0, phase)}.get(filling, V)
    surfaces = [tp.Surface(BALL, tp.Diffuse(0.6), "wall", inside=medium)]
    if medium is V:
        voxels = np.random.default_rng(5).uniform(0.5, 4.0, (3, 2, 4))
        inner = tp.Grid(box=tp.Box(size=0.9), scattering=voxels, phase=phase)
        surfaces.append(filled(inner.box, inner))
    if filling == "ball":
        core = tp.Sphere(center=(0.1, 0, 0), radius=0.3)
        surfaces.append(filled(core, M(0.0, 2.0, tp.HenyeyGreenstein(-0.5))))
    lamp = tp.Source("wall", tp.Lambertian(exitance=0.4 * math.pi), side="back")
    *found, _ = seen(lamp, [(0.3, 0.1, 0.2), (0, 0.75, 0.1)], surfaces, particles=200_000, seed=11)
    for estimate in found:
        assert_sharp(estimate, 4 * math.pi, 0.09)


# ---- errors and scores ----

ONE = tp.Scene(LAMP, detectors=tp.PointDetector((1, 0, 0), "p"), medium=FOG)


@pytest.mark.slow
def test_its_error_bars_are_right():
    """z over 150 short runs has mean 0 and spread 1: the variance is finite, and known from 32 batches."""
    runs = (tp.simulate(ONE, particles=4000, seed=seed, threads=1, progress=False) for seed in range(150))
    assert_z_spread(np.array([run["p"].fluence_rate.z(in_fog(1.0)) for run in runs]), math.inf, 1e-6)


def test_scores_that_stand_out_are_reported():
    """Behind a thick shield the few histories that got through it carry all."""
    slab = filled(tp.Slab(center=(0, 0, 8), thickness=12.0), M(0.7, 0.3))
    _, result = seen(LAMP, [(0, 0, 15)], [slab], particles=2000)
    assert any("'p0'" in warning and "doubtful" in warning for warning in result.warnings)
    assert "doubtful" in result.report()
    *_, result = seen(LAMP, [(0, 0, 1), (3, 0, 0)], [slab], particles=20_000)
    assert not result.warnings


def test_a_score_of_any_size_is_counted():
    """Within 1e-35 m of a lamp of 2 W, and 600 mean free paths from a pencil beam in a fog."""
    huge, _ = seen(LAMP, [(1e-35, 0, 0)])
    assert huge.value == pytest.approx(2e70 / (4 * math.pi))
    faint, _ = seen(PENCIL, [(0, 600, 0)], medium=FOG)
    assert 0 < faint.value < 1e-100


def test_scores_depend_on_neither_threads_nor_other_detectors_and_change_no_flight():
    fog = filled(tp.Box(size=3.0), M(0.1, 1.0, tp.Rayleigh()))
    surfaces = [fog, tp.Surface(tp.Plane(center=(0, 0, -2)), tp.Diffuse(0.5))]
    meter = tp.Detector(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1.0), name="meter")
    points = [tp.PointDetector(place, f"p{k}") for k, place in enumerate([(1, 0, 0), (0, 0.5, 0)])]

    def run(*detectors, threads=1):
        options = {"particles": 20_000, "seed": 7, "batches": 8, "progress": False}
        return tp.simulate(tp.Scene(LAMP, surfaces, [meter, *detectors]), threads=threads, **options)

    one, two, alone, without = run(*points), run(*points, threads=2), run(points[0]), run()
    for name in ("p0", "p1"):
        assert (one[name].batch_values == two[name].batch_values).all()
        assert one[name].counts.value == two[name].counts.value
    assert (one["p0"].batch_values == alone["p0"].batch_values).all()
    assert without["meter"].flux_in.value == one["meter"].flux_in.value
    assert without.cost.collisions == one.cost.collisions
    for name, entry in without.ledger.items():
        assert entry.value == one.ledger[name].value


@pytest.mark.slow
def test_a_run_stops_at_the_error_of_a_point_and_unknown_quantities_are_refused():
    options = {"particles": 100_000, "seed": 1, "threads": 1, "progress": False}
    result = tp.simulate(ONE, error={"p.fluence_rate": 0.05}, **options)
    assert result["p"].fluence_rate.relative_error < 0.05
    with pytest.raises(tp.SceneError, match="fluence_rate"):
        tp.simulate(ONE, error={"p.fluence": 0.1}, particles=1000)
    with pytest.raises(AttributeError, match="fluence_rate"):
        _ = result["p"].fluence
    assert "point detector 'p'" in result.report()


# ---- what is refused, and what beside it is not ----


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_points_on_a_pencil_beam_are_refused_and_those_beside_or_behind_it_or_in_a_wide_one_are_not(scale):
    """There the fluence rate is infinite: a code that goes on tells 1e72 of it."""
    lamp = tp.Source(tp.Point(position=(0, 0, scale)), tp.Beam((0.6, 0, -0.8), power=1.0))

    def look(x, y, z, source=lamp):
        tp.Scene(source, detectors=tp.PointDetector((x * scale, y * scale, z * scale), "p"))

    for way in (0.1, 1.0, 7.0):
        with pytest.raises(tp.SceneError, match=r"PointDetector 'p'.*infinite"):
            look(0.6 * way, 0, 1 - 0.8 * way)
    look(0.6, 1e-9, 0.2)
    look(-0.6, 0, 1.8)
    wide = tp.Disk(center=(0, 0, scale), normal=(0, 0, -1), radius=scale)
    look(0, 0, 0, tp.Source(wide, tp.Beam((0, 0, -1), power=1.0)))
    look(3, 0, 0, tp.Source(tp.Disk(radius=2 * scale), tp.Lambertian(power=1.0)))


def test_the_passes_of_a_phase_function_get_its_parameter_not_its_mean_cosine(monkeypatch):
    monkeypatch.setattr(tp.HenyeyGreenstein, "parameter", property(lambda self: 0.25))
    fog = M(absorption=0.1, scattering=1.0, phase=tp.HenyeyGreenstein(0.5))
    plan = compile_scene(tp.Scene(LAMP, (), tp.PointDetector((0, 0, 1), "p"), medium=fog))
    rows = [row for _, row in (*plan.phase_laws, *points.phase_densities(plan))]
    assert [float(row["g"]) for row in rows] == [0.25, 0.25]


@pytest.mark.parametrize("name", ["law", "max_density"])
def test_a_phase_function_unknown_to_the_engine_is_refused_and_not_taken_for_isotropic(name):
    class Unknown(Phase):
        def density(self, mu):
            return 0.25 / math.pi * (1 + 0 * mu)

    with pytest.raises(NotImplementedError, match="Unknown"):
        getattr(Unknown(), name)
