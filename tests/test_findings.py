"""What a run may have missed is part of what it reports: bounds, verdicts, and that nothing loses them on the way."""

from __future__ import annotations

import json
import math
import pickle
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import poisson
from typer.testing import CliRunner

import transport as tp
from tests.bench.trust import judge_rooms, named_runs
from tests.html_pages import page
from tests.specular_scenes import CASES
from transport.cli.commands import app
from transport.compile.detectors import EDGES
from transport.compile.layout import SIZE_CELLS
from transport.compile.next_event import _bound_by_angles
from transport.results.diagnostics import proofs
from transport.results.diagnostics.path_classes import ALL_LIGHT, cell_path_findings
from transport.results.diagnostics.proofs import DirectView, Probe, specular_surfaces_of
from transport.results.diagnostics.table import DIAGNOSTICS
from transport.statistics import findings
from transport.statistics.batches import MIN_SCORES_FOR_ERROR
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.findings import Finding, error_uncertainty, propagated_findings, unseen_scores
from transport.statistics.quality import quality_of
from transport.statistics.replicates import Batches

RUN = Batches(np.full(32, 100))
LAMP = tp.Source(tp.Disk(center=(0, 0, 1.9), normal=(0, 0, -1), radius=0.05), tp.Lambertian(power=100.0))
EYE = tp.Detector(tp.Disk(center=(1.5, 0, -0.5), normal=(-1, 0, 0), radius=1e-3), "m")
PANEL = tp.Rectangle(center=(-1, 0, 0), normal=(1, 0, 0), up=(0, 0, 1), width=3, height=3)


def estimate(
    value: float, error: float, bound: float | None = None, what: str = "light via 'mirror' not sampled"
):
    """An estimate of this value and standard error, of which so much may be missing."""
    signs = np.resize([1.0, -1.0], 32)
    made = Estimate(value + error * math.sqrt(31) * signs, RUN, "W")
    found = (
        ()
        if bound is None
        else (Finding("doubtful", "detector 'm'", "flux_in", what, bound, "use more particles"),)
    )
    return made._with_findings(lambda: found)


def mirror(material=None, **more):
    """The scene of a mirror whose light no ray connects."""
    return tp.Scene(
        [LAMP], [tp.Surface(PANEL, material or tp.Mirror(1.0), "mirror")], more.get("detectors", [EYE])
    )


# ---- bounds ----


def test_the_bound_of_unseen_scores_holds_in_95_of_100_runs():
    """Of Poisson's law with any mean: n + unseen(n) is above the mean in at least 95 %, where few have come."""
    for mean in (0.5, 2.0, 2.99, 5.0, 9.0, 14.0):
        scores = np.arange(MIN_SCORES_FOR_ERROR)
        covered = scores + unseen_scores(scores) >= mean
        assert (poisson.pmf(scores, mean) * covered).sum() + poisson.sf(
            MIN_SCORES_FOR_ERROR - 1, mean
        ) >= 0.95
    assert unseen_scores(0) == pytest.approx(-math.log(0.05)) and unseen_scores(MIN_SCORES_FOR_ERROR) == 0


def test_an_error_that_few_scores_carry_may_be_too_small_by_the_law_of_chi_squared():
    rng = np.random.default_rng(3)
    for carriers in (3, 6, 12):
        ratios = np.sqrt(rng.chisquare(2 * carriers, 20_000) / (2 * carriers))  # claimed over true errors
        covered = 1.96 + error_uncertainty(carriers) >= 1.96 / ratios
        assert covered.mean() == pytest.approx(0.95, abs=0.01)


# ---- verdicts ----


@pytest.mark.parametrize(
    ("bound", "verdict"),
    [(0.009, "sound"), (0.011, "bounded"), (0.099, "bounded"), (0.101, "doubtful"), (math.nan, "doubtful")],
)
def test_a_bound_is_compared_with_the_error_then_with_what_is_allowed(bound, verdict):
    found = estimate(10.0, 0.01, bound)
    assert found.verdict == verdict and found.is_doubtful == (verdict == "doubtful")
    low, high = found.interval()
    plain = estimate(10.0, 0.01).interval()
    assert low == pytest.approx(plain[0])
    assert high == pytest.approx(plain[1] + (0.0 if verdict == "sound" or math.isnan(bound) else bound))


def test_what_is_printed():
    assert str(estimate(10.0, 0.01)) == "(10.000 ± 0.010) W"
    assert (
        str(estimate(10.0, 0.01, 0.05))
        == "(10.000 ± 0.010) W, or up to 0.05 more: light via 'mirror' not sampled"
    )
    assert str(estimate(10.0, 0.01, 3.0)) == "(10.000 ± 0.010) W, doubtful: light via 'mirror' not sampled"


# ---- nothing loses them ----


def test_arithmetic_moves_bounds_as_it_moves_values():
    a, b = estimate(10.0, 0.01, 1.0), estimate(4.0, 0.02)
    for found, bound in (
        (a + b, 1.0), (a - b, 1.0), (b - a, -1.0), (a * b, 4.0), (a / b, 0.25), (b / a, 4 / 11 - 0.4), (2 * a, 2.0), (a**2, 21.0),
        (-a, -1.0), (abs(-a), 1.0), (a + a, 2.0),
    ):  # fmt: skip
        (finding,) = found.findings
        assert finding.bound == pytest.approx(bound) and finding.object == "detector 'm'", finding
        assert found.is_doubtful
    low, high = (b - a).interval()
    assert low < -7 + 0.0 and high == pytest.approx((b - estimate(10.0, 0.01)).interval()[1])
    assert (b + estimate(1.0, 0.01)).findings == ()
    both = a + estimate(1.0, 0.1, 1.0, "another")
    assert sorted(finding.what for finding in both.findings) == ["another", "light via 'mirror' not sampled"]


def test_slices_sums_means_and_pickles_keep_them():
    signs = np.resize([1.0, -1.0], 32)[:, None, None]
    values = np.arange(1.0, 7.0).reshape(2, 3)
    array = EstimateArray(values + 0.01 * signs, RUN, "W", ("u", "v"), {"u": np.arange(3), "v": np.arange(4)})
    finding = Finding("doubtful", "detector 'm'", "", "what", np.full((2, 3), 0.035), "")
    array._with_findings(lambda: (finding,))
    assert array.verdict.tolist() == [["doubtful"] * 3, ["bounded"] * 3]
    assert array[0, 0].findings[0].bound == 0.035 and array[1].findings[0].bound.shape == (3,)
    assert array.sum().findings[0].bound == pytest.approx(0.035)  # a score falls into one bin only
    assert array.sum("u").findings[0].bound == pytest.approx([0.035] * 3)
    assert array.mean().findings[0].bound == pytest.approx(0.035 / 6)
    assert (array * estimate(2.0, 0.1)).findings[0].bound[1, 2] == pytest.approx(0.07)
    again = pickle.loads(pickle.dumps(array))
    assert again.findings[0].what == "what" and again.is_doubtful.tolist() == array.is_doubtful.tolist()


def test_merged_resumed_and_saved_runs_keep_them(tmp_path):
    scene, how = mirror(), {"estimator": "expected", "threads": 1, "progress": False}
    parts = [tp.simulate(scene, 40_000, seed=2, part=(k, 2), **how) for k in (1, 2)]
    whole = tp.simulate(scene, 40_000, seed=2, **how)
    path = tmp_path / "run.nc"
    whole.save(path)
    longer = tp.simulate(scene, 80_000, resume=whole, **how)
    bound = whole["m"].irradiance.findings[0].bound
    for result in (tp.merge(*parts), tp.load(path), whole):
        (finding,) = result["m"].irradiance.findings
        assert finding.what == "light via 'mirror' not sampled" and finding.bound == pytest.approx(bound)
    assert (
        0.8 < longer["m"].irradiance.findings[0].bound <= bound
    )  # by a probe: more histories do not lessen it
    h5netcdf = pytest.importorskip("h5netcdf")
    with h5netcdf.File(path) as stored:
        attributes = stored["m"].variables["irradiance"].attrs
        assert attributes["verdict"] == "doubtful"
        assert json.loads(attributes["findings"])[0]["what"] == "light via 'mirror' not sampled"


# ---- proofs of emptiness ----


def test_a_mirror_is_left_out_only_where_it_cannot_be_the_last_that_light_meets():
    disk = tp.Disk(radius=0.1)
    places = {"above": (0, 0, 1), "below": (0, 0, -1), "beside": (2, 0, 0)}
    for name, place in places.items():
        ball = tp.Surface(tp.Sphere(center=place, radius=0.5), tp.Mirror(0.9), name)
        scene = tp.Scene(tp.Source(tp.Point(position=(0, 0, 5)), tp.Isotropic(power=1.0)), [ball])
        assert specular_surfaces_of(scene, disk, "front") == ([] if name == "below" else [0])
        assert specular_surfaces_of(scene, disk, None) == [0]
    box = tp.Surface(tp.Box(center=(0, 0, 1), size=1.5), tp.Diffuse(0.5), "box")
    scene = tp.Scene(
        scene.sources, [tp.Surface(tp.Sphere(center=(0, 0, 1), radius=0.5), tp.Mirror(0.9), "in a box"), box]
    )
    assert specular_surfaces_of(scene, disk, "front") == []
    away = tp.TwoSided(tp.Diffuse(0.5), tp.Mirror(0.9))  # its back mirrors
    for normal, found in (((0, 0, -1), []), ((0, 0, 1), [0])):
        panel = tp.Surface(tp.Rectangle(center=(0, 0, 3), normal=normal, width=1, height=1), away, "panel")
        assert specular_surfaces_of(tp.Scene(scene.sources, [panel]), disk, "front") == found


@pytest.mark.parametrize(
    "material",
    [tp.Mirror(0.5, 0.5), tp.Glossy(0.05, 0.9), tp.Mixture({tp.Mirror(1.0): 0.2, tp.Diffuse(0.5): 0.8})],
)
def test_every_material_that_no_ray_connects_is_named(material):
    result = tp.simulate(mirror(material), 20_000, seed=1, estimator="expected", threads=1, progress=False)
    assert "light via 'mirror'" in str(result["m"].irradiance) and result["m"].irradiance.is_doubtful
    (warning,) = [text for text in result.warnings if "flux_in" in text]
    assert "Use estimator='backward'" in warning


def test_a_beam_from_behind_or_beside_is_no_doubt():
    lamp = tp.Source(tp.Point(position=(0, 0.3, 1)), tp.Isotropic(power=1.0))
    meter = tp.Detector(tp.Disk(radius=1e-3), "m")
    for place, direction, is_doubtful in (
        ((0, 0, -1), (0, 0, 1), False), ((1, 0, 1), (0, 0, -1), False), ((0, 0.01, 1), (0, 0, -1), True),
    ):  # fmt: skip
        beam = tp.Source(tp.Disk(center=place, normal=direction, radius=0.05), tp.Beam(direction, power=1.0))
        result = tp.simulate(
            tp.Scene([lamp, beam], (), meter), 2000, seed=1, estimator="expected", threads=1, progress=False
        )
        assert result["m"].irradiance.is_doubtful == is_doubtful, place


# ---- light that once was missed without a word; values by long runs of other estimators ----


def run(sources, surfaces, detector, particles, estimator="expected", seed=0, **more):
    scene = tp.Scene(sources, surfaces, detector, **more)
    return tp.simulate(scene, particles, seed=seed, estimator=estimator, threads=1, progress=False)["m"]


def disk_lamp(center, normal, radius, power):
    return tp.Source(tp.Disk(center=center, normal=normal, radius=radius), tp.Lambertian(power=power))


def test_a_wall_that_lets_a_thousandth_straight_through_is_a_class():
    """No ray passes it, flights do: 0.00716 W m^-2, of which rays through the hole bring an eighth."""
    veil = tp.Mixture({tp.Transparent(): 0.001, tp.Black(): 0.999})
    curtain = tp.Surface(tp.Disk(center=(0, 0, 1), radius=20.0, inner_radius=0.005), veil, "curtain")
    lamp = disk_lamp((0, 0, 2), (0, 0, -1), 1.0, 100.0)
    found = run(lamp, curtain, tp.Detector(tp.Disk(radius=0.005), "m"), 1e5).irradiance
    assert found.value < 0.002 and found.is_doubtful and "curtain" in str(found)
    clear = tp.Surface(curtain.shape, tp.Transparent(), "clear")
    assert run(lamp, clear, tp.Detector(tp.Disk(radius=0.005), "m"), 1e5).irradiance.verdict == "sound"


def test_a_mirror_that_faces_away_but_lets_light_through_is_a_class():
    sheet = tp.TwoSided(tp.Mirror(0.2, 0.7), tp.Black())
    surface = tp.Surface(tp.Disk(center=(0, 0, 1), normal=(0, 0, 1), radius=5.0), sheet, "sheet")
    lamps = [disk_lamp((0, 0, 2), (0, 0, -1), 0.3, 100.0), disk_lamp((0, 2, 0.5), (0, -1, 0), 0.1, 100.0)]
    found = run(lamps, surface, tp.Detector(tp.Disk(radius=0.002), "m"), 1e5).irradiance
    assert found.value < 2 and found.is_doubtful and "sheet" in str(found)  # 7.20 W m^-2


def test_a_ball_in_a_room_of_many_small_walls_is_not_outside():
    """96 squares or 6: the mirror in the room sends light to the ball."""
    walls = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            normal = tuple(-sign * (k == axis) for k in range(3))
            up = tuple(1.0 * (k == (axis + 1) % 3) for k in range(3))
            for a in (-0.75, -0.25, 0.25, 0.75):
                for b in (-0.75, -0.25, 0.25, 0.75):
                    place = [0.0, 0.0, 0.0]
                    place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = sign, a, b
                    square = tp.Rectangle(center=tuple(place), normal=normal, up=up, width=0.5, height=0.5)
                    walls.append(tp.Surface(square, tp.Diffuse(0.1)))
    panel = tp.Surface(tp.Disk(center=(0, 0, 0.5), normal=(0, 0, -1), radius=0.3), tp.Mirror(1.0), "mirror")
    ball = tp.Sphere(radius=0.003)
    scene = tp.Scene(
        disk_lamp((0, 0, -0.99), (0, 0, 1), 0.05, 100.0), [*walls, panel], tp.Detector(ball, "m")
    )
    assert specular_surfaces_of(scene, ball, "front") == [scene.surfaces.index(panel)]


# ---- probes ----

MIRRORED = 0.824336  # [W m^-2], by the lamp's image


@pytest.mark.parametrize("material", [tp.Mirror(1.0), tp.Mirror(1e-6), tp.Mirror(0.3, 0.6)])
def test_a_probe_finds_what_a_mirror_sends_and_bounds_it(material):
    exact = MIRRORED * material.reflectance * math.pi * 1e-6
    bound, found = Probe(mirror(material), EYE, [0])._measure(1 << 22)
    assert abs(found - exact) < 2 * (bound - found) < 0.2 * exact  # four standard errors


def test_a_probe_from_the_lamp_finds_what_a_mirror_sends_on_to_diffuse_walls():
    """What the lamp sends to the mirror first: a wall that the mirror alone lights, behind a screen beside the lamp."""
    wall = tp.Surface(tp.Rectangle(center=(1.5, 0, -1.5), width=1, height=1), tp.Diffuse(0.6), "wall")
    screen = tp.Surface(tp.Disk(center=(0.5, 0, 1.2), normal=(0.6, 0, 0.8), radius=0.5), tp.Black(), "screen")
    meter = tp.Detector(tp.Disk(center=(1.5, 0, 0), normal=(0, 0, -1), radius=0.2), "m")
    scene = tp.Scene(LAMP, [tp.Surface(PANEL, tp.Mirror(0.9), "mirror"), wall, screen], meter)
    by_lamp = Probe(scene, meter, [0], scene.sources[0]).bound(1e6, 0.0)
    with_mirror, without = (
        tp.simulate(each, 1e6, seed=1, estimator="expected", progress=False)["m"].flux_in
        for each in (scene, tp.Scene(LAMP, [tp.Surface(PANEL, tp.Black()), wall, screen], meter))
    )
    first = with_mirror - without  # first and later: this much at most
    assert first.value > 10 * first.error and 0.8 * first.value < by_lamp[1] < 1.1 * first.value
    assert by_lamp[0] > by_lamp[1]


@pytest.mark.parametrize("name", [name for name in CASES if "window" not in name and "behind" not in name])
def test_no_probe_is_below_what_specular_surfaces_send(name):
    """Of whatever kind they are: the exact value is not above what a probe finds by more than twice the reach of its bound."""
    case = CASES[name]
    radius = case.radii[0]
    scene, sensor = case.scene(radius), case.scene(radius).detectors[0]
    surfaces = specular_surfaces_of(scene, scene.shape_of(sensor), sensor.side)
    assert surfaces
    bound, found = Probe(scene, sensor, surfaces).bound(1e6, 0.0)
    mirrored = sum(
        light.value for light in case.lights(radius) if light.rates.get("expected", math.inf) < math.inf
    )
    assert found + 2 * (bound - found) >= mirrored * scene.shape_of(sensor).area


def test_a_probe_of_long_histories_is_as_short_as_its_run(monkeypatch, tmp_path):
    """A box of mirrors in which a history meets a thousand walls: 65 536 of them would be far more work than the run."""
    lamp = tp.Source(tp.Disk(center=(0, 0, 0.3), normal=(0, 0, -1), radius=0.05), tp.Lambertian(power=1.0))
    eye = tp.Detector(tp.Disk(center=(0.1, 0.2, -0.3), radius=1e-5), "m")
    scene = tp.Scene(lamp, tp.Surface(tp.Box(size=1.0), tp.Mirror(0.999), "box"), eye)
    result = tp.simulate(scene, 500, seed=1, estimator="expected", threads=1, progress=False)
    probes, run_probe = [], Probe.run

    def recorded(*args):
        probes.append(run_probe(*args))
        return probes[-1]

    monkeypatch.setattr(Probe, "run", recorded)
    finding = result["m"].irradiance.findings[0]
    events = sum(probe.cost.crossings + probe.cost.collisions for probe in probes)
    assert 1e6 < events < 2**23 * 1.25
    assert 0 < finding.bound < unseen_scores(0) / 500 / scene.shape_of(eye).area
    path = tmp_path / "run.nc"
    result.save(path)
    assert tp.load(path)["m"].irradiance.findings[0].bound == finding.bound


def test_a_finding_that_no_probe_bounds_gives_the_reason():
    many = [
        tp.Surface(tp.Disk(center=(-1, y, 0), normal=(1, 0, 0), radius=0.05), tp.Mirror(1.0))
        for y in np.linspace(-1, 1, proofs.MAX_PROBE_SURFACES + 1)
    ]
    plane = [tp.Surface(tp.Plane(center=(-1, 0, 0), normal=(1, 0, 0)), tp.Mirror(1.0), "sea")]
    for surfaces, why in (
        (many, f"more than {proofs.MAX_PROBE_SURFACES} surfaces"),
        (plane, "'sea' is infinite"),
    ):
        finding = run(LAMP, surfaces, EYE, 500, seed=1).irradiance.findings[0]
        assert finding.seen.endswith(f"no probe bounds it: {why}")
        assert finding.cure.startswith("use estimator=")


def test_a_dark_mirror_is_no_doubt_and_a_bright_one_is_one_by_how_much():
    wall = tp.Surface(tp.Rectangle(center=(0, 0, -1), width=9, height=9), tp.Diffuse(0.5), "floor")
    for share, verdict in ((1e-6, "sound"), (0.004, "bounded"), (0.9, "doubtful")):
        scene = tp.Scene(LAMP, [tp.Surface(PANEL, tp.Mirror(share), "mirror"), wall], EYE)
        found = run(scene.sources, scene.surfaces, EYE, 2e5, seed=1).irradiance
        assert found.verdict == verdict, share
        if verdict == "doubtful":
            assert (
                0.41 < found.findings[0].share < 0.8
            )  # 0.9 MIRRORED of the direct 1.785, and the error of the probe


def test_departures_are_probed_from_their_own_side():
    """A detector turned round: what was to come to it leaves from it, and is missed as much."""
    turned = tp.Detector(tp.Disk(center=EYE.shape.center, normal=(1, 0, 0), radius=1e-3), "m")
    small = disk_lamp((2.5, 0, -0.5), (-1, 0, 0), 0.1, 1e-6)
    found = run([LAMP, small], mirror().surfaces, turned, 1e5).flux_out
    assert found.is_doubtful and found.interval()[1] > (1.785380 + MIRRORED) * math.pi * 1e-6


def test_a_mean_of_pixels_misses_what_the_pixels_miss():
    """A small lamp beside balls: 5.29 by most runs of 1e6, 6.22 ± 0.14 W m^-2 by 6e7."""
    balls = [
        tp.Surface(tp.Box(center=(0, 0, 1.5), size=3.0), tp.Diffuse(0.6), "room"),
        tp.Surface(tp.Sphere(center=(0.2, 0, 0.4), radius=0.35), tp.Dielectric(index_inside=1.5), "ball"),
        tp.Surface(tp.Sphere(center=(-0.5, -0.6, 0.3), radius=0.25), tp.Mirror(0.9), "mirror"),
    ]
    lamp = tp.Source(tp.Sphere(center=(0.6, 0.6, 2.5), radius=0.005), tp.Lambertian(power=60.0))
    around = tp.EnvironmentMap(name="m", position=(-1.0, -0.8, 1.2), theta=12, phi=24)
    reading = run([lamp], balls, around, 1e5, "backward")
    total = (reading.radiance * around.solid_angles()).sum()
    for each in (total, reading.fluence_rate):
        assert each.is_doubtful and each.interval()[1] > 6.2
    assert total.interval()[1] == pytest.approx(reading.fluence_rate.interval()[1], rel=1e-6)


def test_one_score_is_no_sound_number():
    lamp = tp.Source(tp.Disk(center=(0, 0, 1), radius=0.02), tp.Lambertian(radiance=1000.0))
    ceiling = tp.Surface(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.5), tp.Mirror(0.8), "ceiling")
    meter = tp.Detector(tp.Disk(center=(0.3, 0, 0.5), radius=1e-3), "m")
    for estimator, histories in (("expected", 1e6), ("backward", 1e4)):
        found = [run([lamp], [ceiling], meter, histories, estimator, seed).irradiance for seed in range(12)]
        assert any(each.value > 0 for each in found) and all(each.is_doubtful for each in found)


def test_findings_of_a_result_are_in_the_unit_of_their_quantity():
    result = tp.simulate(mirror(), 1e5, seed=1, estimator="expected", progress=False)
    (finding,) = [each for each in result.findings if each.quantity == "flux_in"]
    assert finding.bound == pytest.approx(result["m"].flux_in.findings[0].bound)
    assert finding.value == pytest.approx(result["m"].flux_in.value)


def test_no_ray_from_a_wall_brings_more_than_its_plane_allows():
    rng, compared = np.random.default_rng(5), 0
    for _ in range(300):
        place, normal = rng.normal(size=3), rng.normal(size=3)
        detector = tp.Disk(normal=tuple(rng.normal(size=3)), radius=0.05)
        wall = tp.Disk(center=tuple(place), normal=tuple(normal), radius=3.0)
        most = _bound_by_angles(wall, detector, "front")
        if not math.isfinite(most):
            continue
        here, facing = proofs.even_points_on(detector, rng.random((20_000, 2)))
        there, emitting = proofs.even_points_on(wall, rng.random((20_000, 2)))
        ways = there - here
        distances = np.linalg.norm(ways, axis=1)
        cosines = (ways * facing).sum(axis=1).clip(0) * np.abs((ways * emitting).sum(axis=1)) / distances**2
        brought = cosines * detector.area / (math.pi * distances**2)
        assert brought.max() <= most
        compared += brought.max() > 0.1 * most  # it is no loose bound, either
    assert compared > 30


def test_a_beam_that_passes_by_in_thin_haze_is_no_surprise():
    """Of its 0.00062 ± 0.00006 W m^-2, by 1e9 histories, most runs of 2e5 see nothing; a lamp far away is known to 1e-4."""
    beam = tp.Source(tp.Disk(center=(0, 0.003, -1), radius=0.0003), tp.Beam(direction=(0, 0, 1), power=1.0))
    haze = tp.Surface(tp.Box(size=4.0), tp.Black(), inside=tp.Medium(scattering=1e-5))
    meter = tp.Detector(tp.Disk(normal=(0, 1, 0), radius=1e-3), "m")
    found = run([beam, disk_lamp((0, 1.9, 0), (0, -1, 0), 0.3, 1.0)], haze, meter, 2e5)
    assert found.irradiance.error < 1e-5 and found.irradiance.verdict != "sound"
    assert found.irradiance.interval()[1] > 0.08602 + 0.00062


@pytest.mark.parametrize(("side", "same"), [("inside", "back"), ("outside", "front")])
def test_the_inside_of_a_ball_is_judged_as_its_back_is(side, same):
    lamp = tp.Source(tp.Disk(radius=0.1), tp.Lambertian(power=1.0))
    ball = tp.Sphere(center=(0, 0, 0.5), radius=2.0 if side == "inside" else 0.2)
    verdicts = []
    for name in (side, same):
        scene = tp.Scene(lamp, detectors=tp.Detector(ball, "ball", side=name))
        seen = tp.simulate(scene, particles=4096, estimator="expected", seed=1)["ball"].flux_in
        verdicts.append((seen.value, seen.verdict, [finding.what for finding in seen.findings]))
    assert verdicts[0] == verdicts[1] and verdicts[0][0] > 0


def test_few_strong_rays_among_many_weak_ones_are_a_class():
    """A pinhole right above the detector is seen by few rays, each of which brings much."""
    screen = tp.Surface(tp.Disk(center=(0, 0, 0.2), radius=20, inner_radius=0.001), tp.Black(), "screen")
    lamps = [disk_lamp((0, 0, 0.4), (0, 0, -1), 0.5, 50.0), disk_lamp((3, 0, 0.1), (-1, 0, 0), 0.05, 50.0)]
    found = run(lamps, screen, tp.Detector(tp.Disk(radius=0.001), "m"), 1e5).irradiance
    assert abs(found.value - 0.06037) > 5 * found.error  # ± 0.00011, by 5e7 histories
    assert found.verdict != "sound" and found.interval()[1] > 0.06037


def lamp_before_a_reflector(size, *more):
    """A lamp that shines on a white disk of that radius [m], so near that it lights the room by it alone; seen from 3 m away."""
    paper = tp.Surface(tp.Disk(radius=size), tp.Diffuse(0.9), "reflector")
    lamp = disk_lamp((0, 0, 0.8 * size), (0, 0, -1), 0.5 * size, 100.0)
    detector = tp.Detector(tp.Disk(center=(0, 0, 3), normal=(0, 0, -1), radius=0.01), "m")
    return [lamp], [tp.Surface(tp.Box(size=8.0), tp.Diffuse(0.5), "room"), paper], [detector, *more]


@pytest.mark.parametrize("others", [0, 1])
def test_weak_rays_to_a_lamp_do_not_tell_of_a_reflector_before_it(others):
    """Nor do the strong ones of another detector, which lies at the reflector."""
    there = tp.Detector(tp.Disk(center=(8e-4, 0, 3e-4), normal=(0, 0, -1), radius=1e-4), "there")
    found = run(*lamp_before_a_reflector(1e-3, *[there][:others]), 1e4, "backward").irradiance
    assert found.value < 0.2 and found.verdict == "doubtful"  # of 2.046 ± 0.002, by "expected"
    assert any("via walls near it not sampled" in each.what for each in found.findings)


def test_a_reflector_that_enough_rays_come_from_is_no_doubt():
    found = run(*lamp_before_a_reflector(0.1), 1e5, "backward").irradiance
    exact = run(*lamp_before_a_reflector(0.1), 1e5, "expected").irradiance
    assert found.verdict == "sound"
    assert abs(found.value - exact.value) < 4 * math.hypot(found.error, exact.error)


@pytest.mark.parametrize("kind", ["disk", "ball", "mesh"])
def test_no_ray_to_a_lamp_is_stronger_than_its_walls_allow_and_a_wall_behind_it_does_not_count(kind):
    """A lamp below the ceiling that it does not light, which a histogram of its rays is compared with."""
    shape = tp.Sphere(center=(0, 0, 1.2), radius=0.1)
    shape = shape if kind == "ball" else tp.Disk(center=(0, 0, 1.4999), normal=(0, 0, -1), radius=0.1)
    room = tp.Box(size=(5, 4, 3)) if kind != "mesh" else tp.Mesh.box(size=(5, 4, 3))
    walls = tp.Surface(room, tp.Diffuse(0.5), "room")
    lamp = tp.Source(shape, tp.Lambertian(power=10.0))
    detector = tp.Detector(tp.Disk(center=(0, 0, -1), radius=0.05, normal=(0, 0, -1)), "m")
    scene = tp.Scene(lamp, walls, detector)
    result = tp.simulate(scene, 20_000, seed=1, estimator="backward", threads=1, progress=False)
    (expected,), blocks = result.plan.expectations, result.plan.size_blocks["lamp sources[0]", 0]
    counts = sum(batch.sizes[blocks[1] : blocks[1] + SIZE_CELLS] for batch in result.batches)
    largest = EDGES[:-1][counts > 0][-1] / expected.scale
    strongest = expected.largest_score["front"]
    assert largest <= strongest < 4 * largest
    assert result["m"].irradiance.verdict == "sound"


def test_scores_in_narrow_bins_do_not_tell_of_a_wide_one():
    """All narrow bins see the lamp, the wide one sees its image in a mirror, by 80 of its histories."""
    lamp = tp.Source(tp.Disk(center=(0.1, 0, 10), normal=(0, 0, -1), radius=0.3), tp.Lambertian(radiance=1.0))
    panel = tp.Rectangle(center=(3, 0, 5), normal=(-1, 0, 0), up=(0, 0, 1), width=10, height=10)
    edges = np.concatenate([[0.0], np.linspace(0.999, 1, 500)])
    bins = tp.Directions(mu=edges)
    detector = tp.Detector(tp.Disk(radius=0.01), "m", directions=bins)
    found = run([lamp], [tp.Surface(panel, tp.Mirror(1.0), "mirror")], [detector], 4e4, "backward").irradiance
    assert abs(found.value - 0.00431) > 5 * found.error  # without bins, of 3e6 histories
    assert found.verdict == "doubtful" and found.interval()[1] > 0.00431


def test_alike_bins_are_judged_as_no_bins_are():
    """Four bins of one projected solid angle: the bound of what may be missing is the same to the last digit."""
    lamp = tp.Source(
        tp.Disk(center=(0.1, 0, 10), normal=(0, 0, -1), radius=0.01), tp.Lambertian(radiance=1.0)
    )
    panel = tp.Rectangle(center=(3, 0, 5), normal=(-1, 0, 0), up=(0, 0, 1), width=10, height=10)
    bounds = []
    for bins in (None, tp.Directions(mu=np.sqrt(np.linspace(0, 1, 5)))):
        detector = tp.Detector(tp.Disk(radius=0.01), "m", directions=bins)
        scene = tp.Scene([lamp], [tp.Surface(panel, tp.Mirror(1.0), "mirror")], [detector])
        result = tp.simulate(scene, 1e4, seed=1, estimator="backward", threads=1, progress=False)
        reading = result["m"]
        bounds.append([each.bound for each in cell_path_findings(reading, reading.extents)])
        assert bounds[-1] == [each.bound for each in cell_path_findings(reading)]
    assert bounds[0] == pytest.approx(bounds[1], rel=1e-12) and bounds[0]


def test_what_leaves_a_surface_is_judged_by_its_own_scores():
    """Both estimators count it as it comes: of 1.607 W m^-2 few scores, and the difference from what arrives as well."""
    patch = tp.Surface(
        tp.Disk(center=(1.5, 0, -0.5), normal=(-1, 0, 0), radius=0.03), tp.Diffuse(0.9), "patch"
    )
    for estimator in ("expected", "analog"):
        found = run(LAMP, patch, tp.Detector("patch", "m"), 1e5, estimator, seed=7)
        assert found.exitance.is_doubtful, estimator
    assert found.irradiance.is_doubtful and found.net_flux_density.is_doubtful


def test_a_medium_that_absorbs_by_chance_and_scatters_nothing_is_judged():
    fog = tp.Surface(tp.Box(size=1.0), tp.Transparent(), inside=tp.Medium(absorption=2.0))
    lamp = disk_lamp((0, 0, 1), (0, 0, -1), 0.2, 1.0)
    scene = tp.Scene(lamp, fog, tp.Detector(tp.Disk(center=(0, 0, -1), radius=0.2), "m"))
    result = tp.simulate(
        scene, 20_000, seed=1, estimator="expected", tracking="analog", threads=1, progress=False
    )
    assert result["m"].irradiance.verdict in ("sound", "bounded") and result.warnings == []


def test_a_wall_behind_a_detector_is_no_doubt():
    room = tp.Surface(tp.Box(size=(6, 6, 3)), tp.Diffuse(0.5), "room")
    holder = tp.Surface(tp.Disk(center=(0, 0, -1.01), radius=0.003), tp.Diffuse(0.5), "holder")
    lamp = disk_lamp((0, 0, 1.4), (0, 0, -1), 0.3, 100.0)
    found = run(lamp, [room, holder], tp.Detector(tp.Disk(center=(0, 0, -1), radius=0.01), "m"), 2e5)
    assert not any("holder" in finding.what for finding in found.irradiance.findings)


def test_a_lone_bin_of_eight_batches_is_judged_as_a_number_is():
    detector = tp.Detector(
        tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.5), "m", directions=tp.Directions(mu=2)
    )
    scene = tp.Scene(disk_lamp((0, 0, 0), (0, 0, 1), 0.5, 1.0), (), detector)
    result = tp.simulate(scene, 1e5, seed=1, batches=8, threads=1, progress=False)
    assert not result["m"].radiance.is_doubtful[-1] and result.warnings == []


def test_a_guard_counts_the_flights_that_pass_by():
    """Within 5 cm of the detector: the fluence rate of the mirror's light times the cross section of that ball, in histories."""
    flux = run(mirror().sources, mirror().surfaces, EYE, 1e6, seed=1).irradiance
    (finding,) = flux.findings
    number, _, words = finding.seen.partition(" ")
    cosine = 3.5 / math.hypot(3.5, 2.4)
    expected = 1e6 * 0.824336 / cosine * math.pi * (1e-3 * 2.5) / 100
    assert words == "flights from 'mirror' passed within 0.05 m"
    assert abs(float(number) - expected) < 4.5 * math.sqrt(expected)


# ---- what is printed, shown and saved agrees ----


def screen(particles):
    """A screen of 400 bins before a lamp: of 2e4 particles too few come in a few of them, of 1e4 in a third."""
    lamp = tp.Source(tp.Disk(radius=0.5), tp.Lambertian(power=1.0))
    shape = tp.Rectangle(center=(0, 0, 2), normal=(0, 0, -1), width=4, height=4)
    scene = tp.Scene(lamp, (), tp.Detector(shape, "m", positions=tp.Positions(u=20, v=20)))
    return tp.simulate(scene, particles, seed=1, threads=1, progress=False)


def test_a_report_without_warnings_names_the_bins_that_are_doubtful():
    result = screen(2e4)
    array = result["m"].irradiance
    known = np.isfinite(array.error)
    many, of = np.count_nonzero(array.is_doubtful & known), np.count_nonzero(known)
    assert 0 < many < 0.05 * of and result.warnings == []
    told = f"those of the totals; {many} of {of} bins of 'm.irradiance' are doubtful"
    assert result.report().endswith(f"error bars: no finding against {told}")
    assert told in page(result).text
    assert f"doubtful in {many} of {of} bins" in repr(array)
    clear = screen(3e5)
    assert "no finding against them" in clear.report().splitlines()[-1]


def test_a_bin_is_not_counted_as_unknown_and_as_doubtful():
    array = screen(1e4)["m"].irradiance
    unknown = np.isnan(array.error).sum()
    others = array.is_doubtful.sum() - unknown
    told = f"error unknown in {unknown} of 400 bins, doubtful in {others} of the other {400 - unknown}"
    assert unknown > 0 and others > 0 and told in repr(array)
    assert told in page(array).text


def test_what_is_doubtful_has_no_price():
    result = tp.simulate(mirror(), 1e5, seed=1, estimator="expected", threads=1, progress=False)
    assert result["m"].flux_in.is_doubtful and "price of" not in result.report()
    assert math.isnan(result.price("m.flux_in", 0.01))
    few = screen(1e4)
    array = few["m"].irradiance
    worst = array.relative_error[np.isfinite(array.error) & ~array.is_doubtful].max()
    assert few.price("m.irradiance", worst) == pytest.approx(few.cost.seconds)
    assert math.isnan(screen(3e3).price("m.irradiance", 0.1))


def test_numbers_are_saved_with_their_doubt_as_bins_are(tmp_path):
    h5netcdf = pytest.importorskip("h5netcdf")
    path = tmp_path / "run.nc"
    result = tp.simulate(mirror(), 1e5, seed=1, estimator="expected", threads=1, progress=False)
    result.save(path)
    with h5netcdf.File(path) as stored:
        saved = stored["m"].variables
        for name in ("flux_in", "irradiance"):
            assert result["m"].quantities[name].is_doubtful and saved[f"{name}_doubtful"][()] == 1
        assert not result.ledger["absorbed"].is_doubtful and "absorbed_doubtful" not in stored.variables


# ---- runs ----


def test_a_run_for_an_error_stops_where_running_on_would_not_settle_a_doubt():
    result = tp.simulate(mirror(), error={"m.irradiance": 1e-6}, seed=1, estimator="expected", progress=False)
    assert result.particles < 1e6 and result["m"].irradiance.is_doubtful  # the error would take six million
    assert any(
        "times as many particles to resolve a finding: light via 'mirror' not sampled" in each
        for each in result.warnings
    )
    wide = tp.Detector(tp.Disk(center=(1.5, 0, -0.5), normal=(-1, 0, 0), radius=0.1), "m")
    settled = tp.simulate(
        mirror(detectors=[wide]), error={"m.irradiance": 0.03}, seed=1, estimator="expected", progress=False
    )
    assert settled["m"].irradiance.verdict == "sound" and settled["m"].irradiance.relative_error < 0.03


@pytest.mark.parametrize(
    ("name", "bins"), [("irradiance", {}), ("radiance", {"directions": tp.Directions(mu=3)})]
)
def test_a_run_for_the_error_of_bins_names_what_it_leaves_in_doubt_as_one_for_a_number_does(name, bins):
    scene = mirror(detectors=[tp.Detector(EYE.shape, "m", **bins)])
    result = tp.simulate(
        scene, error={f"m.{name}": 0.02}, seed=1, estimator="expected", threads=1, progress=False
    )
    assert np.any(result["m"].quantities[name].is_doubtful)
    (line,) = [each for each in result.warnings if each.startswith(f"m.{name}: stopped after")]
    assert "times as many particles to resolve a finding: light via 'mirror' not sampled" in line


def test_pixels_are_followed_to_their_error_whatever_else_is_in_doubt():
    """A lamp so small that no history comes to it by the mirror.  Of a number that stays doubtful nothing is worth having; a picture is."""
    camera = tp.Camera(name="cam", position=(3, 0, 1.5), look_at=(0, 0, -1), pixels=(4, 3))
    floor = tp.Surface(tp.Rectangle(center=(0, 0, -1), width=9, height=9), tp.Diffuse(0.5), "floor")
    panel = tp.Surface(PANEL, tp.Mirror(1.0), "mirror")
    scene = tp.Scene([disk_lamp((0, 0, 1.9), (0, 0, -1), 1e-3, 100.0)], [floor, panel], [camera])
    result = tp.simulate(scene, error={"cam.radiance": 2e-3}, seed=1, progress=False)
    assert result.particles > 1 << 18 and result["cam"].radiance.relative_error.max() <= 2e-3
    (line,) = [each for each in result.warnings if each.startswith("cam.radiance: stopped after")]
    short = tp.simulate(scene, 1e4, error={"cam.radiance": 2e-3}, seed=1, progress=False)
    assert any(
        "times the requested error, and running on to its limits would not" in each for each in short.warnings
    )
    assert "resolve a finding: light" in line and "via 'mirror'" in line


@pytest.mark.parametrize("name", [name for name in CASES if name not in ("ball", "ball, behind")])
def test_wrong_runs_of_a_named_scene_are_doubtful_and_complete_ones_are_not(name):
    """Two seeds of three radii and every estimator; a run of 30 complete ones may be doubtful, or wrong by chance."""
    case = CASES[name]
    methods = ("analog", "expected", "backward")
    judged = [run for r in case.radii for run in named_runs(case, r, 2, 3e5, methods)]
    assert sum(run.is_missed for run in judged) <= (1 if any(run.is_complete for run in judged) else 0)
    complete = [run for run in judged if run.is_complete]
    assert sum(run.run.verdict == "doubtful" for run in complete) <= 1


def test_sound_estimates_of_random_rooms_agree():
    """30 rooms: the family's false-alarm rate is 1e-3, for pairs of estimates and against the references each."""
    found = judge_rooms(range(0, 300, 10), 1e5)
    assert found["pairs"] > 25 and found["disagreements"] == [] and found["off reference"] == []
    assert found["missed"] == 0


def test_the_table_of_diagnostics_is_printed_and_knows_every_finding():
    printed = CliRunner().invoke(app, ["checks"]).output
    assert all(diagnostic.name in printed for diagnostic in DIAGNOSTICS)
    names = {diagnostic.name for diagnostic in DIAGNOSTICS}
    result = tp.simulate(mirror(), 2000, seed=1, estimator="analog", progress=False)
    assert {finding.name for finding in result.findings} <= names
    library = Path(tp.__file__).parent
    code = "".join(
        path.read_text()
        for room in ("statistics", "results")
        for path in (library / room).rglob("*.py")
        if path.name != "table.py"
    )
    written = set(re.findall(r"""(?:\bname=|\b(?:note|doubtful)\()"(.+?)\"""", code))
    assert len(written) > 10 and written <= names
    examined = [check.name for check in DIAGNOSTICS if check.run is None]
    assert all(f'"{name}"' in code for name in examined)
    assert {findings.FEW_CARRIERS, findings.UNKNOWN, ALL_LIGHT} <= names


def test_a_lamp_outside_the_image_is_not_missed_by_a_camera():
    """One that looks at the floor has all of its light; one whose image the lamp may be in has to meet it."""
    lamp = tp.Source(tp.Disk(center=(0, 0, 3), normal=(0, 0, -1), radius=0.2), tp.Lambertian(power=10.0))
    floor = tp.Surface(tp.Rectangle(center=(0, 0, -1), width=9.0, height=9.0), tp.Diffuse(0.5))
    for turned, may_see in (
        (-1.0, False),
        (0.5, False),
        (0.8, True),
        (1.2, True),
    ):  # of 0.32 rad upwards from level, where the lamp is
        view = {"look_at": (0, 0, 2 + 3 * math.tan(turned * 0.32)), "field_of_view": 0.05, "pixels": (4, 3)}
        camera = tp.Camera(name="view", position=(0, -3, 2), **view)
        assert camera.may_see(lamp.shape) == may_see
    down = tp.Camera(name="view", position=(0, -3, 2), look_at=(0, 0, -1), field_of_view=0.8, pixels=(8, 6))
    result = tp.simulate(
        tp.Scene(lamp, floor, down), 20_000, seed=1, estimator="backward", threads=1, progress=False
    )
    assert result.warnings == [] and result.quality("view.radiance").verdict == "sound"


def test_a_side_that_nothing_came_to_is_warned_of_though_light_crossed_the_other():
    """A detector that looks away from the lamp, at a mirror: rays connect nothing, and its back counts."""
    lamp = tp.Source(tp.Disk(radius=1.0), tp.Lambertian(power=1.0))
    mirror = tp.Surface(
        tp.Disk(center=(0, 0, 5), radius=3.0, normal=(0, 0, -1)), tp.Mirror(0.9), name="mirror"
    )
    up = tp.Detector(tp.Disk(center=(0, 0, 2), radius=1e-3), "up")
    result = tp.simulate(
        tp.Scene(lamp, mirror, up), 2000, seed=1, estimator="expected", threads=1, progress=False
    )
    assert result["up"].flux_in.reason == "no score" and result["up"].flux_in.verdict == "doubtful"
    (warning,) = result.warnings
    assert warning.startswith("flux_in of detector 'up' is doubtful: light via 'mirror' not sampled")


def test_what_lies_on_a_floor_leaves_it_again():
    """A detector of its own in the plane of a floor: nothing proves that the floor sends nothing back, and a sum tells so."""
    lamp = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.1), tp.Lambertian(power=1.0))
    floor = tp.Surface(tp.Rectangle(width=4.0, height=4.0), tp.Diffuse(0.5), "floor")
    meter = tp.Detector(tp.Disk(radius=1e-3), "meter")
    result = tp.simulate(
        tp.Scene(lamp, floor, meter), 20_000, seed=1, estimator="expected", threads=1, progress=False
    )
    read = result["meter"]
    assert read.irradiance.verdict == "sound" and read.exitance.reason == "no score"
    assert read.net_flux_density.verdict == read.fluence_rate.verdict == "doubtful"
    assert str(read.net_flux_density).endswith("doubtful: a part of it has no score")
    free = tp.Detector(tp.Disk(center=(0, 0, 0.5), radius=1e-3), "free")
    above = tp.simulate(
        tp.Scene(lamp, (), free), 2000, seed=1, estimator="expected", threads=1, progress=False
    )["free"]
    assert str(above.exitance) == "0 W m^-2 (exact)" and above.net_flux_density.verdict == "sound"


def test_a_sum_of_few_scores_is_no_sound_number():
    """Of bins, each rightly doubtful: their sum knows how many scores it has, as does what is made of it."""
    run, counts = Batches(np.full(32, 100)), np.array([2, 3, 0, 40])
    values = np.zeros((32, 4))
    for b, count in enumerate(counts):
        values[np.arange(count) % 32, b] += 32.0
    array = EstimateArray(values, run, "W", ("x",), {"x": np.arange(5.0)}, counts=counts)
    few, many = array[:3].sum(), array.sum()
    assert few.verdict == "doubtful" and "only 5 scores, too few to know the error" in str(few)
    assert many.verdict == "sound" and (few / many).verdict == (2 * few).verdict == "doubtful"
    assert (many + few).interval()[1] > (many + few).value + unseen_scores(5) / 5 * few.value


def test_a_product_misses_what_both_factors_miss_together():
    """Of 1 and 1 that may each be 4: 16."""
    one = estimate(1.0, 0.01, bound=3.0)
    assert (one * one).interval()[1] >= 16.0


@pytest.mark.parametrize("gap", [1e-10, 1e-12])
def test_lines_between_plates_know_how_near_these_are(gap):
    """Light comes through a pinhole of a mask between two plates: no even line is as short as those that count."""
    size, hole = 0.1, 1e-4
    lamp = tp.Source(tp.Disk(center=(0, 0, gap), normal=(0, 0, -1), radius=size), tp.Lambertian(radiance=1.0))
    mask = tp.Disk(center=(0, 0, gap / 2), radius=size, inner_radius=hole)
    plate = tp.Detector(tp.Disk(radius=size), name="plate")
    scene = tp.Scene(lamp, tp.Surface(mask, tp.Diffuse(0.0)), detectors=plate)
    parts = [SimpleNamespace(shape=plate.shape)]
    bound, is_shown = DirectView(scene, plate, parts, 0, lamp.shape, "front").bound(0.0)
    most = (hole / size) ** 2  # of what all of the plate sees through the hole, nearly all of it
    assert not is_shown and 0.9 * most < bound <= 1.0


def test_bins_that_are_not_pooled_need_as_many_scores_as_single_numbers():
    """Of a bin of time with a few late scores the error is not known, though that of the total is."""
    run = Batches(np.full(32, 1000))
    scores = np.stack([np.arange(32) == 7, np.arange(32) % 2 == 0, np.arange(32) % 16 + 5]).T / 1000
    numbers = (scores * 1000).sum(axis=0).astype(int)
    times = {"time": np.array([0.0, 1.0, 2.0, 3.0])}
    energies = EstimateArray(scores, run, "J", ("time",), times, counts=numbers)
    assert numbers.tolist() == [1, 16, 400]
    assert energies.verdict.tolist() == ["doubtful", "doubtful", "sound"]
    assert energies[1].is_doubtful and "scores" in str(energies[1])


def test_a_carried_finding_takes_the_longer_of_two_times_whatever_the_order():
    """As many histories settle a sum as settle the part that takes most."""
    few, many = (Finding("doubtful", "", "", "light not sampled", 1.0, times=times) for times in (2.0, 100.0))
    for pair in ((few, many), (many, few)):
        (sum_of_both,) = propagated_findings(np.add, *((np.array(1.0), [each]) for each in pair))
        assert (sum_of_both.bound, sum_of_both.times) == (2.0, 100.0)


def test_quality_keeps_the_error_that_was_asked_for():
    """A bound within 1 % of the value, and above what was asked for, is a doubt in both."""
    run = Batches(np.full(32, 1000))
    estimate = Estimate(1.0 + 1e-6 * np.arange(32), run, "W")
    estimate._with_findings(lambda: (Finding("doubtful", "", "", "light not sampled", 5e-3),), allowed=1e-4)
    assert estimate.verdict == quality_of(estimate).verdict == "doubtful"
