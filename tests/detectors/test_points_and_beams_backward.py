"""Backward runs of scenes with Points and Beams: exact radiance and irradiance, and agreement with forward runs.

Shadow rays alone find such sources, so that everything that no ray finds must be refused by name.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected, assert_z_spread
from tests.refusals import assert_refused
from tests.slow import quick
from transport.theory import point_source

ALBEDO, HEIGHT = 0.6, 2.0
FLOOR = tp.Surface(tp.Rectangle(width=10, height=10), tp.Diffuse(ALBEDO), "floor")
LAMP = tp.Source(tp.Point(position=(0.3, 0, HEIGHT)), tp.Isotropic(intensity=5.0))
SKY = tp.Rectangle(center=(0, 0, 5), normal=(0, 0, -1), width=20, height=20)
SUN = tp.Source(SKY, tp.Beam((0.3, 0, -1), irradiance=1000.0))
SLANT = 1 / math.sqrt(1.09)  # cosine of the sun's height


def run(scene, particles=100_000, seed=1, **how):
    how = {"estimator": "backward"} | how
    return tp.simulate(scene, particles, seed=seed, progress=False, **how)


def pixel(place, position=(0, -3, 6)):
    """A camera with one very small pixel, which shows a place."""
    return tp.Camera(name="view", position=position, look_at=place, field_of_view=1e-5, pixels=(1, 1))


def speck(place, normal=(0, 0, 1), radius=1e-5, **how):
    return tp.Detector(tp.Disk(center=place, normal=normal, radius=radius), name="speck", **how)


def radiance_of(scene, *particles):
    return float(run(scene, *particles)["view"].radiance.value[0, 0])


# ---- one diffuse wall: L = albedo E/pi, with E = I cos/r^2 of a Point, and E cos of a Beam ----


@pytest.mark.parametrize("unit", [1.0, 1e-9, 1.5e11])
def test_a_camera_sees_a_wall_that_a_point_lamp_lights(unit):
    place, lamp = (1.0, 0.2, 0.0), tp.Point(position=tuple(unit * x for x in LAMP.shape.position))
    floor = replace(FLOOR, shape=tp.Rectangle(width=10 * unit, height=10 * unit))
    camera = pixel(*(tuple(unit * x for x in each) for each in (place, (0, -3, 1))))
    r2 = 0.7**2 + 0.2**2 + HEIGHT**2
    exact = ALBEDO * 5.0 * HEIGHT / r2**1.5 / math.pi / unit**2
    assert radiance_of(tp.Scene(replace(LAMP, shape=lamp), floor, camera), 10_000) == pytest.approx(
        exact, 1e-6
    )


@pytest.mark.parametrize("normal", [(0, 0, 1), (1, 0.5, 2)])
def test_detectors_and_points_read_the_direct_light_of_a_point_lamp(normal):
    place = np.array((1.0, 0.5, 0.5))
    toward = np.array(LAMP.shape.position) - place
    r = np.linalg.norm(toward)
    cosine = toward @ normal / r / np.linalg.norm(normal)
    point = tp.PointDetector(tuple(place), "point")
    result = run(tp.Scene(LAMP, (), [speck(tuple(place), normal), point]), 10_000)
    assert float(result["speck"].irradiance.value) == pytest.approx(5.0 * cosine / r**2, rel=1e-6)
    assert float(result["point"].fluence_rate.value) == pytest.approx(5.0 / r**2, rel=1e-12)


@pytest.mark.parametrize(("side", "share"), [("front", 1.0), ("back", 0.0)])
def test_a_beam_lights_one_side_of_a_detector_and_a_point_in_it(side, share):
    point = tp.PointDetector((0, 1, 1), "point")
    result = run(tp.Scene(SUN, (), [speck((0, 0, 1), side=side), point]), 1000)
    assert float(result["speck"].irradiance.value) == pytest.approx(share * 1000 * SLANT, rel=1e-9)
    assert float(result["point"].fluence_rate.value) == pytest.approx(1000.0, rel=1e-9)


@pytest.mark.parametrize(("x", "is_lit"), [(0.79, False), (0.81, True)])
@pytest.mark.parametrize("unit", [1e-9, 1.5e11])
def test_a_shadow_is_as_sharp_in_any_unit(unit, x, is_lit):
    sky = tp.Rectangle(center=(0, 0, 5 * unit), normal=(0, 0, -1), width=20 * unit, height=20 * unit)
    box = tp.Surface(tp.Box(center=(0, 0, 0.51 * unit), size=unit), tp.Black())
    scene = tp.Scene(replace(SUN, shape=sky), box, speck((x * unit, 0, 0), radius=1e-4 * unit))
    found = float(run(scene, 1000)["speck"].irradiance.value)
    assert found == pytest.approx(is_lit * 1000 * SLANT, rel=1e-9)


def test_a_sun_a_million_metres_away():
    sky = tp.Disk(center=(-3e5, 0, 1e6), normal=(0.3, 0, -1), radius=100.0)
    scene = tp.Scene(replace(SUN, shape=sky), FLOOR, speck((0, 0, 1e-3)))
    assert float(run(scene, 1000)["speck"].irradiance.value) == pytest.approx(1000 * SLANT, rel=1e-9)


@pytest.mark.parametrize("place", [(0.81, 0, 0), (0.79, 0, 0), (0, 0.49, 0), (0, 0.51, 0), (-0.51, 0, 0)])
def test_a_box_in_the_sun_casts_a_sharp_shadow_on_the_ground(place):
    """A box of side 1, 0.01 over the ground: its top edge at x = 0.5 shades up to 0.5 + 0.3 * 1.01."""
    box = tp.Surface(tp.Box(center=(0, 0, 0.51), size=1.0), tp.Black())
    x, y, _ = place
    is_lit = abs(y) > 0.5 or not -0.5 + 0.3 * 0.01 < x < 0.5 + 0.3 * 1.01
    camera = pixel(place, position=(0.5 * x, 3.0 * (y or 0.001), 0.005))
    found = radiance_of(tp.Scene(SUN, [FLOOR, box], camera), 1000)
    assert found == pytest.approx(is_lit * ALBEDO * 1000 * SLANT / math.pi, rel=1e-9)


@pytest.mark.parametrize(
    "shape",
    [
        tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1.0, inner_radius=0.5),
        tp.Triangle(vertices=[(0, 0, 2), (0, 1, 2), (1, 0, 2)]),
        tp.Polygon(vertices=[(0, 0, 2), (1, 0, 2), (1, 1, 2), (0.5, 0.2, 2), (0, 1, 2)][::-1]),
        tp.Rectangle(center=(0.2, 0, 2), normal=(0, 0, -1), up=(1, 2, 0), width=1, height=0.5),
    ],
    ids=["annulus", "triangle", "polygon", "rectangle"],
)
def test_all_power_of_a_beam_arrives_whatever_its_shape(shape):
    beam = tp.Source(shape, tp.Beam((0.2, 0.1, -1), power=3.0))
    detector = tp.Detector(tp.Rectangle(width=5, height=5), name="all")
    assert_agrees(run(tp.Scene(beam, (), detector), 400_000)["all"].flux_in, 3.0)


def test_a_beam_fades_in_an_absorbing_slab():
    slab = tp.Surface(
        tp.Box(center=(0, 0, 2), size=(8, 8, 0.7)), tp.Transparent(), inside=tp.Medium(absorption=1.3)
    )
    result = run(tp.Scene(SUN, [slab], speck((0, 0, 0.1))), 1000)
    exact = 1000 * SLANT * math.exp(-1.3 * 0.7 / SLANT)
    assert float(result["speck"].irradiance.value) == pytest.approx(exact, rel=1e-9)


def test_a_beam_of_a_named_surface_starts_at_its_front():
    """The panel itself blocks no light of its own, and neither does what touches its plane."""
    panel = tp.Surface(SKY, tp.Diffuse(0.5), "panel")
    beam = tp.Source("panel", SUN.emission)
    found = run(tp.Scene(beam, [panel], speck((0, 0, 1))), 1000)["speck"].irradiance
    assert float(found.value) == pytest.approx(1000 * SLANT, rel=1e-9)


# ---- a white sphere: after the first reflection light is everywhere the same ----


@pytest.mark.parametrize("place", [(0.5, 0.7, -1.0), (0, 0, 0), (1.9, 0, 0)])
def test_a_point_lamp_anywhere_in_a_white_sphere(place):
    """From the centre the mean over all directions is that over the wall: L = rho Phi / (4 pi^2 R^2 (1 - rho))."""
    ball = tp.Surface(tp.Sphere(radius=2.0), tp.Diffuse(0.8))
    lamp = tp.Source(tp.Point(position=place), tp.Isotropic(power=10.0))
    seen = tp.EnvironmentMap(name="map", position=(0, 0, 0), theta=1, phi=1)
    result = run(tp.Scene(lamp, ball, seen), 400_000)
    exact = 0.8 * 10 / (4 * math.pi**2 * 4 * (1 - 0.8))
    assert_agrees(result["map"].radiance, exact)
    assert_rejected(result["map"].radiance, 1.05 * exact)
    assert result["map"].radiance.value == pytest.approx(exact, rel=0.03)


CLOSED = {
    "sphere": tp.Sphere(radius=1.0),
    "box": tp.Box(size=(1, 2, 1.5)),
    "mesh of a sphere": tp.Mesh.sphere(radius=1.0, triangles=320),
}


@pytest.mark.parametrize("shape", CLOSED.values(), ids=CLOSED)
def test_what_arrives_at_all_walls_of_a_closed_room_is_the_power_over_its_absorptance(shape):
    wall = tp.Surface(shape, tp.Diffuse(0.6), "wall")
    lamp = tp.Source(tp.Point(position=(0.1, 0.2, -0.1)), tp.Isotropic(power=3.0))
    found = run(tp.Scene(lamp, wall, tp.Detector("wall", side="inside")), 300_000)["wall"].flux_in
    assert_agrees(found, 3.0 / 0.4)
    assert found.relative_error < 0.002


# ---- in media ----

FOG = tp.Medium(absorption=0.1, scattering=0.9)


@pytest.mark.parametrize("distance", [0.1, 1.0, 3.0])
def test_a_point_lamp_in_endless_fog(distance):
    lamp = tp.Source(tp.Point(position=(distance, 0, 0)), tp.Isotropic(power=2.0))
    point = tp.PointDetector((0, 0, 0), "point")
    ball = tp.Detector(tp.Sphere(radius=1e-4 * distance), name="ball")
    result = run(tp.Scene(lamp, (), [point, ball], medium=FOG), 100_000)
    exact = 2 * point_source.fluence_rate(distance, 1.0, 0.9)
    assert_agrees(result["point"].fluence_rate, exact)
    assert result["point"].fluence_rate.relative_error < 0.02
    assert_agrees(result["ball"].irradiance, exact / 4)


def test_a_map_sees_all_light_that_fog_scatters():
    """Of a Point that no map sees itself: the fluence rate less the direct light."""
    lamp = tp.Source(tp.Point(position=(1, 0, 0)), tp.Isotropic(power=2.0))
    seen = tp.EnvironmentMap(name="map", position=(0, 0, 0), theta=4, phi=4)
    result = run(tp.Scene(lamp, (), seen, medium=FOG), 200_000)
    scattered = (result["map"].radiance * seen.solid_angles()).sum()
    exact = 2 * (point_source.fluence_rate(1.0, 1.0, 0.9) - math.exp(-1) / (4 * math.pi))
    assert_agrees(scattered, exact)
    assert scattered.relative_error < 0.02


# ---- against forward runs ----

POINT = tp.Source(tp.Point(position=(0.1, 0.2, 0.3)), tp.Isotropic(power=10.0))
DISK = tp.Source(tp.Disk(center=(0, 0.5, 0.9), normal=(0, 0, -1), radius=0.2), tp.Lambertian(power=10.0))
GLOW = tp.Source(tp.Sphere(center=(0.75, -0.7, 0.2), radius=0.1), tp.Isotropic(power=5.0))
BEAM = tp.Source(
    tp.Disk(center=(0.1, 0, 0.95), normal=(0, 0, -1), radius=0.3), tp.Beam((0.2, 0.1, -1), power=10.0)
)
STAR = tp.Source(
    tp.Polygon(vertices=[(-0.5, -0.5, -0.8), (0.1, -0.5, -0.8), (-0.2, -0.3, -0.8), (-0.3, 0.2, -0.8)]),
    tp.Beam((0.2, 0.1, 1), power=7.0),
)
ROOM = tp.Surface(tp.Box(size=2.0), tp.Diffuse(0.5))
SHEET = tp.Surface(
    tp.Rectangle(center=(0.2, 0, 0.1), normal=(1, 0, 0.3), width=0.5, height=0.4),
    tp.Diffuse(0.3, transmission=0.4),
)
MIST = tp.Medium(absorption=0.3, scattering=1.2, phase=tp.HenyeyGreenstein(0.4))
CLOUD = tp.Surface(tp.Box(size=(1, 1, 0.8)), tp.Transparent(), inside=MIST)
SMOKE = tp.Surface(
    tp.Box(center=(0, 0, -0.4), size=(1, 1, 0.3)),
    tp.Transparent(),
    inside=tp.Grid(
        box=tp.Box(center=(0, 0, -0.4), size=(1, 1, 0.3)),
        scattering=np.arange(1, 9).reshape(2, 2, 2) / 2,
        absorption=np.full((2, 2, 2), 0.3),
    ),
)
DETECTORS = (
    tp.Detector(tp.Disk(center=(-0.4, 0.3, -0.7), normal=(0.3, 0, 1), radius=0.2), name="disk"),
    tp.Detector(
        tp.Sphere(center=(-0.3, -0.3, 0.2), radius=0.12), name="ball", positions=tp.Positions(u=2, v=2)
    ),
    tp.Detector(
        tp.Rectangle(center=(0.3, -0.2, -0.7), normal=(0, -1, -1), width=0.3, height=0.2),
        name="back",
        side="back",
    ),
)
PLACE = (-0.3, -0.2, 0.1)
SCENES = {
    "a point in a room": ([POINT], [ROOM, SHEET], None),
    "a beam in a room": ([BEAM], [ROOM, SHEET], None),
    "a point in mist": ([POINT], [CLOUD], None),
    "a point beside smoke": ([POINT], [SMOKE], None),
    "beams through smoke": ([BEAM, STAR], [SMOKE, ROOM], None),
    "a point and a disk in a misty room": ([POINT, DISK], [ROOM, SHEET], MIST),
    "lamps of all kinds": ([POINT, DISK, BEAM, GLOW, STAR], [ROOM, SHEET, CLOUD], None),
}


@pytest.mark.parametrize(
    "name", quick(SCENES, "a beam in a room", "a point beside smoke", "lamps of all kinds")
)
def test_forward_and_backward_runs_agree(name):
    sources, surfaces, medium = SCENES[name]
    scene = tp.Scene(sources, surfaces, DETECTORS, medium)
    there, back = run(scene, 1_000_000, 2, estimator="expected"), run(scene, 600_000)
    pairs = [tuple(result[detector.name].irradiance for result in (there, back)) for detector in DETECTORS]
    lit = [np.any(one.value) for one, _ in pairs]
    assert any(lit) and lit == [np.any(other.value) for _, other in pairs]
    for one, other in itertools.compress(pairs, lit):
        assert_agrees(one - other, 0)
    # A point detector of a forward run leaves out the direct light of a Beam; the place is in none.
    point = tp.Scene(sources, surfaces, tp.PointDetector(PLACE, "point"), medium)
    there, back = run(point, 300_000, 2, estimator="analog"), run(point, 300_000)
    assert_agrees(there["point"].fluence_rate - back["point"].fluence_rate, 0)


def random_room(number):
    """A grey box with one to four grey objects and one to three lamps, and in half of the rooms mist."""
    rng = np.random.default_rng(number)
    size = rng.uniform(1.5, 3.0, 3)
    reach = 0.3 * size.min() / 2

    def direction():
        return tuple(rng.normal(size=3))

    surfaces = [tp.Surface(tp.Box(size=tuple(size)), tp.Diffuse(rng.uniform(0.2, 0.8)))]
    for corner in ((-1, -1, -1), (1, -1, 1), (-1, 1, 1), (1, 1, -1))[: rng.integers(1, 5)]:
        place = tuple(0.225 * size * corner)
        shape = (
            tp.Sphere(center=place, radius=reach),
            tp.Box(center=place, size=tuple(rng.uniform(0.5, 1.0, 3) * reach)),
            tp.Rectangle(center=place, normal=direction(), width=reach, height=0.8 * reach),
            tp.Disk(center=place, normal=direction(), radius=0.6 * reach),
        )[rng.integers(4)]
        through = rng.uniform(0, 0.4) if shape.is_flat else 0.0
        surfaces.append(tp.Surface(shape, tp.Diffuse(rng.uniform(0.1, 0.6), transmission=through)))
    lamps = []
    for _ in range(rng.integers(1, 4)):
        place, power = tuple(rng.uniform(-0.12, 0.12, 3) * size), rng.uniform(1, 10)
        roof = (*rng.uniform(-0.3, 0.3, 2), 0.47 * size[2])
        sky = (
            tp.Disk(center=roof, normal=(0, 0, -1), radius=0.3),
            tp.Rectangle(center=roof, normal=(0, 0, -1), width=0.5, height=0.4),
        )[rng.integers(2)]
        beam = tp.Beam((*rng.uniform(-0.5, 0.5, 2), -1), power=power)
        lamps.append(
            (
                tp.Source(tp.Point(position=place), tp.Isotropic(power=power)),
                tp.Source(sky, beam),
                tp.Source(tp.Sphere(center=place, radius=0.05), tp.Lambertian(power=power)),
            )[rng.integers(3)]
        )
    phase = (tp.Isotropic(), tp.HenyeyGreenstein(0.5), tp.Rayleigh())[rng.integers(3)]
    mist = tp.Medium(absorption=0.3, scattering=rng.uniform(0.1, 1.5), phase=phase)
    meter = tp.Disk(center=(0, 0, -0.4 * size[2]), normal=direction(), radius=reach / 6)
    return tp.Scene(lamps, surfaces, tp.Detector(meter, name="meter"), mist if rng.random() < 0.5 else None)


@pytest.mark.parametrize("number", quick(range(1, 21), 1, 2))
def test_forward_and_backward_runs_agree_in_random_rooms(number):
    scene = random_room(number)
    there, back = run(scene, 600_000, 2, estimator="expected"), run(scene, 300_000)
    assert_agrees(there["meter"].irradiance - back["meter"].irradiance, 0, 1e-6)


def test_lamps_are_told_apart():
    scene = tp.Scene([POINT, DISK, BEAM], [ROOM], DETECTORS[:1])
    whole = run(scene)["disk"]
    parts = [whole.by_source[name].irradiance.value for name in ("sources[0]", "sources[1]", "sources[2]")]
    assert sum(parts) == pytest.approx(float(whole.irradiance.value), rel=1e-12)
    for source, part in zip((POINT, DISK, BEAM), parts, strict=True):
        alone = run(tp.Scene(source, [ROOM], DETECTORS[:1]), 400_000, 2)["disk"].irradiance
        assert part == pytest.approx(float(alone.value), rel=0.05)


def test_errors_hold_over_many_seeds():
    scene = tp.Scene([POINT, BEAM], [ROOM, SHEET], DETECTORS[:1])
    exact = float(run(scene, 4_000_000, 99, estimator="expected")["disk"].irradiance.value)
    z = [run(scene, 20_000, seed)["disk"].irradiance.z(exact) for seed in range(1, 61)]
    assert_z_spread(np.array(z), math.inf)


# ---- what a run may have missed ----


def test_a_lamp_that_nearly_touches_a_detector_or_a_wall_is_doubtful():
    near = tp.Source(tp.Point(position=(0, 0, 1e-3)), tp.Isotropic(power=1.0))
    detector = tp.Detector(tp.Disk(radius=1.0), name="plate")
    plate = run(tp.Scene(near, (), detector), 20_000)["plate"].flux_in
    assert plate.verdict == "doubtful" and any("very near it" in str(each) for each in plate.findings)
    assert plate.interval()[1] > 0.5  # half of the power goes to the plate
    over = speck((0, 0, 1), (0, 0, -1))
    assert run(tp.Scene(near, FLOOR, over), 20_000)["speck"].irradiance.verdict == "doubtful"


def test_a_lamp_in_the_plane_of_a_wall_lights_it_not():
    flat = tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=1.0))
    beside = tp.Surface(tp.Rectangle(center=(3, 0, 0), width=4.5, height=4.5), tp.Diffuse(0.5), "beside")
    result = run(tp.Scene(flat, beside, [pixel((1, 0, 0)), speck((0, 0, 1), (0, 0, -1))]), 10_000)
    assert float(result["view"].radiance.value[0, 0]) < 1e-12
    assert float(result["speck"].irradiance.value) == pytest.approx(0.25 / math.pi, rel=1e-3)


# ---- refused by name, with the cure ----

MIRROR, GLASS = tp.Mirror(0.9), tp.Dielectric(1.5)
CAMERA = pixel((0, 0, 0))


FLAT = tp.Rectangle(center=(3, 0, 1), normal=(-1, 0, 0), width=1, height=1)
PANES = {
    "mirror": (FLAT, MIRROR),
    "half transparent": (FLAT, tp.Mixture([(tp.Transparent(), 0.5), (tp.Diffuse(0.4), 0.5)])),
    "curved mirror": (tp.Sphere(center=(3, 0, 1), radius=0.5), MIRROR),
    "metal": (FLAT, tp.Conductor(0.2, 3.4)),
    "glass": (FLAT, GLASS),
    "gloss": (FLAT, tp.Glossy(0.2)),
}
OF_LAMP, OF_SUN = (LAMP, "a small Sphere"), (SUN, "a Disk that shines by Lambertian() from far away")


@pytest.mark.parametrize(
    ("name", "source", "cure"),
    [(name, *each) for name in PANES for each in (OF_LAMP, OF_SUN)[name in ("mirror", "half transparent") :]],
)
def test_light_by_specular_surfaces_is_refused(name, source, cure):
    """But of a Point in flat mirrors, and through screens: test_mirror_images.py."""
    pane = tp.Surface(*PANES[name], "pane")
    kind = "glossy" if name == "gloss" else "specular"
    words = f"no ray finds light of the ... of sources[0] by way of Surface 'pane', which is {kind}; "
    # Rays from gloss find all light.
    forward = f"{words}write estimator='expected'{' with guide=1_000_000' * (name != 'gloss')}, or use {cure}"
    assert_refused(lambda: run(tp.Scene(source, [FLOOR, pane], tp.Detector("floor"))), forward)
    scene = tp.Scene(source, [FLOOR, pane], CAMERA)
    for estimator in (None, "analog", "expected", "auto"):
        other = f"{words}use {cure}, or take out Camera 'view'"
        assert_refused(lambda e=estimator: run(scene, estimator=e), other)


WIDE = replace(FLAT, width=5, height=1.9)
FACING = replace(WIDE, center=(-3, 0, 1), normal=(1, 0, 0))


@pytest.mark.parametrize(
    ("others", "medium", "guide"),
    [([], FOG, ""), ([tp.Surface(FACING, MIRROR)], None, " with guide=1_000_000")],
    ids=["a medium that scatters", "facing mirrors"],
)
def test_light_by_flat_mirrors_is_refused_where_no_ray_finds_all_of_it(others, medium, guide):
    pane = tp.Surface(WIDE, MIRROR, "pane")
    scene = tp.Scene(LAMP, [FLOOR, pane, *others], tp.Detector("floor"), medium=medium or tp.Medium())
    words = "no ray finds light of the Point of sources[0] by way of Surface 'pane', which is specular; "
    assert_refused(lambda: run(scene), f"{words}write estimator='expected'{guide}, or use a small Sphere")


@pytest.mark.parametrize(
    ("shape", "got"),
    [
        (tp.Point(position=(0, 0, 1)), "a Point"),
        (tp.Sphere(center=(0, 0, 1), radius=0.1), "a Sphere"),
        (replace(SKY, hole=tp.Disk(center=SKY.center, radius=0.1)), "a Rectangle with a hole"),
    ],
    ids=["pencil", "ball", "hole"],
)
def test_beams_from_other_shapes_are_refused(shape, got):
    beam = tp.Source(shape, tp.Beam((0, 0, -1), power=1.0))
    words = f"rays find a Beam from a whole flat shape only, got {got} in sources[0]; use a Disk, or "
    assert_refused(lambda: run(tp.Scene(beam, FLOOR, CAMERA)), f"{words}take out Camera 'view'")
    assert_refused(
        lambda: run(tp.Scene(beam, FLOOR, tp.Detector("floor"))), f"{words}write estimator='analog'"
    )


@pytest.mark.parametrize("directions", [tp.Directions(mu=3), tp.Directions.cone((0, 0, 1), 0.1)])
def test_bins_of_direction_are_refused(directions):
    scene = tp.Scene(LAMP, FLOOR, tp.Detector("floor", directions=directions))
    words = "no bin of directions of Detector 'floor' holds the direct light of the Point of sources[0], got "
    cure = "write estimator='expected', or leave directions out, or use a small Sphere"
    assert_refused(lambda: run(scene), f"{words} ... ; {cure}")


def test_a_map_has_no_fluence_rate_of_light_without_radiance():
    result = run(tp.Scene(LAMP, FLOOR, tp.EnvironmentMap(name="map", position=(0, 0, 1))), 1000)
    words = "EnvironmentMap 'map': fluence_rate needs the direct light of each Point and Beam"
    assert_refused(lambda: result["map"].fluence_rate, f"{words}, which has no radiance; use a PointDetector")
    assert "fluence_rate" not in result["map"].available


def test_a_camera_at_the_lamp_sees_the_wall_but_no_fog():
    at_lamp = pixel((0.3, 0.5, 0), LAMP.shape.position)
    exact = ALBEDO * 5.0 * HEIGHT / (0.5**2 + HEIGHT**2) ** 1.5 / math.pi
    assert radiance_of(tp.Scene(LAMP, FLOOR, at_lamp), 1000) == pytest.approx(exact, rel=1e-6)
    words = "Camera 'view' must not be at the Point of sources[0] where a medium scatters; move one of them"
    assert_refused(lambda: run(tp.Scene(LAMP, FLOOR, at_lamp, medium=FOG)), words)


def test_a_guide_is_refused_where_no_history_arrives():
    words = "guide=10000 ... no history arrives at sources[0], a Point or a Beam; leave guide out"
    assert_refused(lambda: run(tp.Scene(LAMP, FLOOR, tp.Detector("floor")), guide=10_000), words)
