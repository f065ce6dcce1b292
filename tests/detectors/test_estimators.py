"""Expected and backward estimators agree with counted flights and closed forms; cameras and maps show what they should.

Expected crossings are right down to 1e-20 of the sphere; backward histories cost the same however small a bin is.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ndtri

import transport as tp
from tests import backward_scenes, expected_scenes
from tests.agreement import assert_agrees
from tests.expected_scenes import WALLS, lamp, pane
from tests.refusals import assert_refused
from tests.slow import quick
from tests.test_reproducible import digest
from transport.theory import emitters


def run(scene, particles=1000, **how):
    return tp.simulate(scene, particles, progress=False, **how)


def expected(scene, particles, **how):
    return run(scene, particles, estimator="expected", **how)


def backward(scene, particles=300_000, seed=5, **how):
    return run(scene, particles, seed=seed, estimator="backward", **how)


# ---- expected crossings ----

SIDES = ("flux_in", "flux_out", "fluence_rate")
QUICK = ("room", "half_mirrors", "fog", "disks", "hollow")


def quantities(result, scene):
    """All that detectors read, each once."""
    for detector in scene.meters:
        reading = result[detector.name]
        yield from (getattr(reading, side) for side in SIDES)
        if detector.directions is not None:
            yield reading.radiance
        if detector.positions is not None:
            yield reading.irradiance


@pytest.mark.parametrize("name", quick(expected_scenes.SCENES, *QUICK))
def test_expected_crossings_agree_with_counted_ones(name):
    scene = expected_scenes.SCENES[name]()
    counted, told = run(scene, 150_000, seed=1, estimator="analog"), expected(scene, 150_000, seed=2)
    pairs = list(zip(quantities(counted, scene), quantities(told, scene), strict=True))
    compared = 0
    for one, other in pairs:
        if np.any(np.asarray(one.value)) or np.any(np.asarray(other.value)):
            assert_agrees(other - one, 0.0, 1e-5 / len(pairs))
            compared += 1
    assert compared >= 2 * len(scene.meters)
    assert told.ledger["lost"].value == 0


@pytest.mark.parametrize("share", [1e-2, 1e-10, 1e-20, 1e-100])
def test_a_speck_takes_its_share_of_a_point_to_rounding(share):
    """One minus the cosine of the half angle over two, told by every birth alike: share of 4 pi."""
    half_angle = math.acos(1 - 2 * share) if share > 1e-8 else 2 * math.sqrt(share)
    speck = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=math.tan(half_angle)), "speck")
    source = tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=1.0))
    flux = expected(tp.Scene(source, (), speck), 10_000, seed=1)["speck"].flux_in
    if share > 1e-8:
        assert_agrees(flux, share)
        assert flux.relative_error < 1e-3
    else:
        assert flux.value == pytest.approx(share, rel=3 * share + 1e-12, abs=0)


def test_disk_to_disk_is_the_closed_form():
    meter = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1), "meter")
    scene = tp.Scene(tp.Source(tp.Disk(radius=1), tp.Lambertian(radiance=1.0)), (), meter)
    flux = expected(scene, 1_000_000, seed=1)["meter"].flux_in
    assert_agrees(flux, math.pi * emitters.mean_disk_irradiance(1.0, 1.0, 1.0, 1.0))
    assert flux.relative_error < 8e-4


def test_births_on_a_detector_depart_from_it():
    """All of the power that a disk without a surface sends out departs from the meter on it: no ray has told that."""
    source = lamp(0.0)
    own = tp.Detector(source.shape, "own", directions=tp.Directions(mu=2))
    told = expected(tp.Scene(source, (), [own, pane("meter", 0.5)]), 10_000, seed=1)
    power = told.ledger["emitted"].value
    assert told["own"].flux_out.value == pytest.approx(power, rel=1e-12)
    assert_agrees(told["own"].radiance_out, 1.0)


@pytest.mark.parametrize("reach", [1e-12, 1.0, 1e12])
def test_the_unit_of_length_does_not_matter(reach):
    """What is told is the same to rounding in a room of any size."""

    def room(size):
        meter = tp.Detector(tp.Disk(center=(0, 0.3 * size, 0.8 * size), radius=0.1 * size), "meter")
        source = tp.Source(tp.Disk(radius=0.2 * size), tp.Lambertian(power=1.0))
        walls = tp.Surface(tp.Box(size=2 * size), tp.Diffuse(0.5), "walls")
        return expected(tp.Scene(source, walls, meter), 20_000, seed=3)["meter"].flux_out

    assert room(reach).value == pytest.approx(room(0.25).value, rel=1e-9)


def test_a_ball_that_shines_is_as_bright_everywhere():
    """Radiance emitted / (1 - albedo), whoever looks from wherever: a small ball in it, a patch close to it."""
    walls = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.8), "walls")
    small = tp.Detector(tp.Sphere(center=(0.3, 0, -0.5), radius=0.01), "small")
    close = tp.Detector(tp.Disk(center=(0, 0, 0.9), radius=0.2), "close")
    source = tp.Source("walls", tp.Lambertian(radiance=1.0), side="inside")
    scene = tp.Scene(source, walls, [tp.Detector("walls", side="inside"), small, close])
    told = expected(scene, 100_000, seed=1)
    for name in ("walls", "small", "close"):
        assert_agrees(told[name].irradiance, 5 * math.pi)
    assert_agrees(told["close"].exitance, 5 * math.pi)
    assert_agrees(told["small"].fluence_rate, 20 * math.pi)


@pytest.mark.quick_cases("room", "half_mirrors")
@pytest.mark.parametrize("name", ["room", "fog", "half_mirrors"])
def test_threads_do_not_change_a_bit(name):
    scene = expected_scenes.SCENES[name]()
    assert len({digest(scene, threads=threads, estimator="expected") for threads in (1, 2, 3)}) == 1


def test_a_detector_that_no_point_is_drawn_on_counts_as_flights_come():
    rod = tp.Detector(tp.Cylinder(center=(0, 0, 0.5), radius=0.1, height=0.2), "rod")
    scene = tp.Scene(lamp(0.0), WALLS, [rod, pane("meter", 0.5)])
    counted, told = (run(scene, 50_000, seed=4, estimator=way) for way in ("analog", "expected"))
    assert told["rod"].flux_in.value == counted["rod"].flux_in.value
    assert "rod" in told.report().split("estimator")[1].split("\n")[0]


# ---- backward histories ----

FALSE_ALARM = 1e-6  # of a scene; of all nine 1e-5
RADIANCE, INDEX = 7.0, 1.5
BACKWARD_QUICK = ("occluded", "glass_ball", "forward_fog")


@pytest.mark.parametrize("name", quick(backward_scenes.SCENES, *BACKWARD_QUICK))
def test_forward_and_backward_runs_agree(name):
    """Bin by bin, through Student's t; errors of both together are 1 to 3 % of irradiances, so that 5 to 15 % would show."""
    scene = backward_scenes.SCENES[name]()
    particles = 1_000_000 if name == "glowing_glass" else 300_000  # a tenth of its volume is to be seen
    forward, back = run(scene, particles, seed=4), backward(scene, particles)
    assert back.ledger["lost"].value == 0
    for detector in scene.detectors:
        for quantity in {"irradiance", "radiance"} & back[detector.name].quantities.keys():
            one, other = (getattr(result[detector.name], quantity) for result in (forward, back))
            z = np.atleast_1d((one - other).z(0)).ravel()
            is_known = np.isfinite(z)
            assert is_known.sum() >= 0.8 * len(z)  # but for bins at the horizon, which are nearly never met
            assert np.abs(z[is_known]).max() < -ndtri(FALSE_ALARM / 2 / len(z)), (detector.name, quantity, z)


@pytest.fixture(scope="module")
def furnace():
    """Black walls of one radiance about a ball of glass with a mirror: every detector sees it whole."""
    walls = tp.Surface(tp.Box(size=(1.0, 1.2, 0.8)), tp.Black(), name="walls")
    ball = tp.Surface(tp.Sphere(center=(0.1, 0, 0), radius=0.2), tp.Dielectric(INDEX), name="ball")
    mirror = tp.Surface(tp.Disk(center=(-0.3, 0, 0), normal=(1, 1, 0.3), radius=0.15), tp.Mirror())
    places = tp.Positions(u=2, v=3)
    within = tp.Disk(center=(0.1, 0, 0.05), normal=(0, 1, 1), radius=0.05)
    disk = tp.Disk(center=(0.1, 0, 0.25), radius=0.05)
    around = tp.Cylinder(center=(0.35, 0, 0), radius=0.05, height=0.2)
    cone = tp.Directions.cone((0, 0.5, 1), 1e-3)
    here = (-0.4, -0.3, 0.2)
    detectors = [
        tp.Detector(within, name="within", directions=tp.Directions(theta=4, phi=5), positions=places),
        tp.Detector("ball", directions=tp.Directions(mu=(0, 0.1, 1), phi=3), positions=places),
        tp.Detector("walls", side="back", directions=tp.Directions(mu=3)),
        tp.Detector(around, name="round", directions=tp.Directions(theta=3, phi=4)),
        tp.Detector(disk, name="cone", directions=cone),
        tp.Camera(name="camera", position=here, look_at=(0.1, 0, 0), pixels=(8, 6), field_of_view=1.2),
        tp.EnvironmentMap(name="map", position=here, theta=4, phi=5),
        tp.EnvironmentMap(name="inner map", position=(0.1, 0.0, 0.0), theta=4, phi=5),
    ]
    lamp = tp.Source("walls", tp.Lambertian(radiance=RADIANCE), side="back")
    return backward(tp.Scene([lamp], [walls, ball, mirror], detectors), 100_000)


def test_furnace_is_seen_whole_by_every_history(furnace):
    """L is the same everywhere, eta^2 L in the glass: exactly, for each history brings the same."""
    for name in ("ball", "walls", "round", "map"):
        np.testing.assert_allclose(furnace[name].radiance.value, RADIANCE, rtol=1e-12)
    for name in ("within", "inner map"):
        np.testing.assert_allclose(furnace[name].radiance.value, INDEX**2 * RADIANCE, rtol=1e-12)
    np.testing.assert_allclose(furnace["map"].fluence_rate.value, 4 * math.pi * RADIANCE, rtol=1e-12)
    np.testing.assert_allclose(furnace["walls"].irradiance.value, math.pi * RADIANCE, rtol=1e-12)


def test_weighted_directions_see_the_furnace_within_their_errors(furnace):
    assert_agrees(furnace["cone"].radiance, RADIANCE)
    assert_agrees(furnace["camera"].radiance, RADIANCE)
    assert furnace["camera"].radiance.relative_error.max() < 0.01


def test_ledger_is_of_the_histories_and_closes(furnace):
    ledger = furnace.ledger
    parts = sum(ledger[name].value for name in ledger if name != "emitted")
    assert ledger["emitted"].value == pytest.approx(1, rel=1e-15) and str(ledger["emitted"].unit) == "1"
    assert parts == pytest.approx(1, rel=1e-12)
    assert "estimator: backward" in furnace.report()


def test_bin_of_a_ten_thousandth_costs_as_much_as_the_whole_hemisphere():
    """Where a million forward histories bring some ten scores, 20 000 that start in the bin know it to 1 %."""
    forward, back = run(narrow_bin(), 1_000_000, seed=1)["meter"], backward(narrow_bin(), 20_000)["meter"]
    assert forward.counts.value.sum() < 100
    assert back.radiance.relative_error.max() < 0.01
    assert_agrees(forward.radiance - back.radiance, 0)


def narrow_bin():
    lamp = tp.Rectangle(center=(0, 0, 0.5), normal=(0, 0, -1), width=0.9, height=0.9)
    walls = tp.Surface(tp.Box(size=(1, 1, 1)), tp.Diffuse(0.5))
    cone = tp.Directions.cone((0.0, 0.5, math.sqrt(0.75)), 2 * math.asin(math.sqrt(0.5e-4)))
    meter = tp.Detector(tp.Disk(radius=0.1), name="meter", directions=cone)
    return tp.Scene([tp.Source(lamp, tp.Lambertian(radiance=10.0))], [walls], [meter])


def test_threads_do_not_change_a_bit_backwards():
    fog = backward_scenes.fog()
    one, two = (backward(fog, 50_000, threads=n)["meter"].radiance.values for n in (1, 2))
    np.testing.assert_array_equal(one, two)


def test_sources_add_up():
    reading = backward(backward_scenes.fog(), 50_000)["side"]
    lamp, cloud = (reading.by_source[name].flux_in for name in ("sources[0]", "sources[1]"))
    assert reading.flux_in.value == pytest.approx((lamp + cloud).value, rel=1e-12, abs=0)
    assert 0 < lamp.value < cloud.value


def test_two_sources_on_one_surface_have_names_of_their_own():
    wall = tp.Surface(tp.Rectangle(width=1, height=1), tp.Black(), "wall")
    sources = [
        tp.Source("wall", tp.Lambertian(radiance=radiance), side=side)
        for radiance, side in ((1.0, "front"), (2.0, "back"))
    ]
    meter = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.3), "meter")
    reading = tp.simulate(
        tp.Scene(sources, wall, meter), 10_000, seed=1, estimator="backward", progress=False
    )["meter"]
    parts = {name: float(part.flux_in.value) for name, part in reading.by_source.items()}
    assert list(parts) == ["sources[0]", "sources[1]"]
    assert sum(parts.values()) == pytest.approx(float(reading.flux_in.value), rel=1e-12)


def test_every_cell_gets_its_share_of_histories():
    """As many, or one more, in each batch, whatever the number of cells."""
    result = backward(backward_scenes.occluded(), 50_021)
    turned = result.plan.adjoint
    born = np.array([batch.counts[turned.first : turned.first + turned.cells] for batch in result.batches])
    np.testing.assert_array_equal(born.sum(axis=1), result.run.sizes)
    assert (born.max(axis=1) - born.min(axis=1) <= 1).all()


@pytest.mark.slow
def test_batches_smaller_than_the_cells_stay_unbiased():
    """15 histories a batch for 24 cells: those without one count as 0, and all are divided by what was expected.

    Divided by its own number, where there is one, the flux would be 38 % too low; its error is 2 %.
    """
    scene = backward_scenes.occluded()
    whole, thin = backward(scene), backward(scene, 30_000, batches=2000)
    assert_agrees(whole["meter"].flux_in - thin["meter"].flux_in, 0)
    assert any("batches are smaller" in warning for warning in thin.warnings)


def test_a_small_bright_lamp_that_is_never_met_is_reported():
    lamps = [
        tp.Source(tp.Disk(radius=0.5), tp.Lambertian(power=1.0)),
        tp.Source(tp.Disk(center=(0, 0, 0.01), radius=1e-5), tp.Lambertian(power=1.0)),
    ]
    meter = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.1), name="meter")
    result = backward(tp.Scene(lamps, (), [meter]), 10_000)
    assert any("light from 'sources[1]' not sampled" in warning for warning in result.warnings)
    assert not backward(tp.Scene(lamps[:1], (), [meter]), 10_000).warnings


def test_quantities_of_forward_histories_are_refused_when_read():
    reading = backward(narrow_bin(), 1000)["meter"]
    for name in ("flux_out", "fluence_rate", "flux_in", "irradiance"):
        with pytest.raises(tp.SceneError, match="needs"):
            getattr(reading, name)
    assert set(reading.quantities) == {"flux_density", "radiance", "intensity", "counts"}


# ---- cameras and maps ----

CAMERA = tp.Camera(name="view", position=(0, 0, 0), direction=(1, 0, 0), field_of_view=1.0, pixels=(8, 6))


def lamp_at(center, radiance=3.0, radius=0.2):
    """A luminous ball."""
    return tp.Source(tp.Sphere(center=center, radius=radius), tp.Lambertian(radiance=radiance))


def test_pixels_fill_the_solid_angle_of_the_image():
    """Of a rectangle of half sides a, b at distance 1, 4 asin(a b / sqrt((1 + a^2)(1 + b^2)))."""
    a = math.tan(0.5)
    b = 0.75 * a
    exact = 4 * math.asin(a * b / math.sqrt((1 + a * a) * (1 + b * b)))
    assert CAMERA.solid_angles().sum() == pytest.approx(exact, rel=1e-13)
    whole = tp.EnvironmentMap(name="map", position=(0, 0, 0)).solid_angles().sum()
    assert whole == pytest.approx(4 * math.pi)


def test_image_is_upright_and_not_mirrored():
    """Looking along +x with +z up, +y is on the left."""
    result = run(tp.Scene(lamp_at((4, 1.2, 0.9)), (), CAMERA), 50_000)
    row, column = np.unravel_index(np.argmax(result["view"].image()), (6, 8))
    assert row < 3 and column < 4


@pytest.mark.parametrize("kind", ["lamp in fog", "fog that glows"])
@pytest.mark.parametrize("distance", [0.0, 1.0, 2.5])
def test_a_glow_behind_fog_is_as_bright_as_what_fades_on_the_way_leaves(kind, distance):
    """Along one ray: (1 - exp(-depth)) / absorption of the glow, times exp(-tau) of the fog before it."""
    thick, before, within = 1.5, 0.6, 1.3  # m and m^-1
    box = tp.Box(center=(distance + thick / 2, 0, 0), size=(thick, 1.0, 2.0))
    eye = tp.Camera(name="eye", position=(-1e-9, 0, 0), look_at=(1, 0, 0), pixels=(2, 1), field_of_view=1e-6)
    if kind == "lamp in fog":
        lit = {"sources": tp.Source(box, tp.Isotropic(power=4 * math.pi * box.volume)), "surfaces": ()}
        within = before
    else:
        glow = tp.Medium(absorption=within, emission=1.0)
        lit = {"sources": (), "surfaces": tp.Surface(box, tp.Transparent(), "body", inside=glow)}
    scene = tp.Scene(**lit, detectors=eye, medium=tp.Medium(absorption=before))
    radiance = run(scene, seed=1)["eye"].radiance
    exact = math.exp(-before * distance) * -math.expm1(-within * thick) / within
    np.testing.assert_allclose(radiance.value, exact, rtol=1e-8)


def test_a_map_shows_where_light_comes_from():
    view = tp.EnvironmentMap(name="map", position=(0, 0, 0), theta=4, phi=4)
    radiance = run(tp.Scene(lamp_at((0, 2, 2)), (), view), 50_000)["map"].radiance
    assert radiance.dims == ("theta", "phi")
    lit = set(map(tuple, np.argwhere(radiance.value > 0).tolist()))
    assert lit == {(0, 0), (0, 1), (1, 0), (1, 1)}  # on the edge at 45 and at 90 degrees


def test_pixels_on_a_lamp_show_its_radiance_and_shares_of_it_at_its_edge():
    """The flux through the image is L times the solid angle of the ball, 2 pi (1 - cos)."""
    radiance = run(tp.Scene(lamp_at((4, 0, 0), radius=1.0), (), CAMERA), 200_000)["view"].radiance
    assert_agrees(radiance[2, 3], 3.0)
    whole = (radiance * CAMERA.solid_angles()).sum()
    assert_agrees(whole, 3.0 * 2 * math.pi * (1 - math.sqrt(15) / 4))


def occluded(extra):
    """A room's corner with a lamp, and something in the way."""
    floor = tp.Surface(tp.Rectangle(center=(0, 0, -1), width=6, height=6), tp.Diffuse(0.6))
    block = tp.Surface(tp.Sphere(center=(0.4, 0.3, 0.8), radius=0.4), tp.Diffuse(0.3))
    lamp = tp.Source(tp.Disk(center=(0.5, 0, 2), normal=(0, 0, -1), radius=0.8), tp.Lambertian(radiance=5.0))
    return tp.Scene([lamp], [floor, block], [extra])


def foggy(extra):
    """A lamp in a fog that fills a box."""
    fog = tp.Medium(absorption=0.3, scattering=1.2, phase=tp.HenyeyGreenstein(0.4))
    body = tp.Surface(tp.Box(size=(3, 3, 3)), tp.Transparent(), inside=fog)
    lamp = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.5), tp.Lambertian(radiance=5.0))
    return tp.Scene([lamp], [body], [extra])


@pytest.mark.parametrize("scene", [occluded, foggy])
def test_fluence_rate_is_the_same_seen_from_the_lamp_and_from_the_point(scene):
    """Next-event estimation forwards, and a map and a point backwards."""
    place = (0.1, -0.2, 0.1)
    point, view = tp.PointDetector(place, "here"), tp.EnvironmentMap(name="here", position=place)
    ways = [(point, {"seed": 1}), (point, {"seed": 2, "estimator": "backward"}), (view, {"seed": 3})]
    there, back, seen = (run(scene(each), 300_000, **how)["here"].fluence_rate for each, how in ways)
    assert_agrees(there - back, 0)
    assert_agrees(there - seen, 0)
    assert seen.relative_error < 0.02


def test_cameras_alone_run_backwards_by_themselves_and_forward_histories_are_refused():
    assert run(occluded(CAMERA)).plan.method.estimator == "backward"
    words = "only backward histories reach Camera 'view'; write estimator='backward'"
    assert_refused(lambda: run(occluded(CAMERA), estimator="analog"), words)


@pytest.mark.parametrize(
    ("source", "says"),
    [
        (
            tp.Source(tp.Sphere(radius=1), tp.Beam((0, 0, 1), power=1.0)),
            "got a Sphere in sources[0]; use a Disk",
        ),
        (
            tp.Source(tp.Point(position=(0, 0, 2)), tp.Beam((0, 0, 1), power=1.0)),
            "got a Point in sources[0]; use a Disk",
        ),
    ],
    ids=["ball", "pencil"],
)
@pytest.mark.parametrize("estimator", [None, "backward", "analog", "expected", "auto"])
def test_sources_that_a_camera_cannot_see_are_refused_by_any_estimator_with_one_cure(source, says, estimator):
    scene = tp.Scene(source, (), CAMERA)
    with pytest.raises(tp.SceneError) as caught:
        tp.simulate(scene, 1000, estimator=estimator, progress=False)
    told = str(caught.value)
    assert says in told and told.endswith("take out Camera 'view'") and "write estimator" not in told


def test_cameras_and_meters_go_together_backwards():
    meter = tp.Detector(tp.Disk(center=(0, 0, -0.5), radius=0.3), name="meter")
    scene = tp.Scene(lamp_at((2, 0, 0.5)), (), [CAMERA, meter])
    assert_refused(lambda: run(scene, estimator="analog"), "estimator='backward'")
    result = run(scene, 100_000)
    assert "camera 'view'" in result.report() and result["meter"].irradiance.value > 0


def test_a_run_stops_at_the_error_of_a_map():
    scene = occluded(tp.EnvironmentMap(name="map", position=(0, 0, 0), theta=2, phi=2))
    result = tp.simulate(scene, error={"map.fluence_rate": 0.05}, progress=False)
    assert result["map"].fluence_rate.relative_error <= 0.05
