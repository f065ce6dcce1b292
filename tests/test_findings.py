"""What a run may have missed is part of what it reports: bounds, verdicts, and that nothing loses them on the way."""

from __future__ import annotations

import json
import math
import pickle

import numpy as np
import pytest
from scipy.stats import poisson
from typer.testing import CliRunner

import transport as tp
from tests.bench.trust import judge_rooms, named_runs
from tests.specular_scenes import CASES
from transport.command.cli import app
from transport.results.diagnostics import DIAGNOSTICS
from transport.results.estimates import Batches, Estimate, EstimateArray
from transport.results.findings import MIN_SCORES, Finding, unknown_of_error, unseen_scores
from transport.results.path_classes import mirrors_of

RUN = Batches(np.full(32, 100))
LAMP = tp.Source(tp.Disk(center=(0, 0, 1.9), normal=(0, 0, -1), radius=0.05), tp.Lambertian(power=100.0))
EYE = tp.Detector(tp.Disk(center=(1.5, 0, -0.5), normal=(-1, 0, 0), radius=1e-3), "m")
PANEL = tp.Rectangle(center=(-1, 0, 0), normal=(1, 0, 0), up=(0, 0, 1), width=3, height=3)


def estimate(
    value: float, error: float, bound: float | None = None, what: str = "light by 'mirror' not sampled"
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
        scores = np.arange(MIN_SCORES)
        covered = scores + unseen_scores(scores) >= mean
        assert (poisson.pmf(scores, mean) * covered).sum() + poisson.sf(MIN_SCORES - 1, mean) >= 0.95
    assert unseen_scores(0) == pytest.approx(-math.log(0.05)) and unseen_scores(MIN_SCORES) == 0


def test_an_error_that_few_scores_carry_may_be_too_small_by_the_law_of_chi_squared():
    rng = np.random.default_rng(3)
    for carriers in (3, 6, 12):
        ratios = np.sqrt(rng.chisquare(2 * carriers, 20_000) / (2 * carriers))  # claimed over true errors
        covered = 1.96 + unknown_of_error(carriers) >= 1.96 / ratios
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
        == "(10.000 ± 0.010) W, or up to 0.05 more: light by 'mirror' not sampled"
    )
    assert str(estimate(10.0, 0.01, 3.0)) == "(10.000 ± 0.010) W, doubtful: light by 'mirror' not sampled"


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
    assert sorted(finding.what for finding in both.findings) == ["another", "light by 'mirror' not sampled"]


def test_slices_sums_means_and_pickles_keep_them():
    signs = np.resize([1.0, -1.0], 32)[:, None, None]
    values = np.arange(1.0, 7.0).reshape(2, 3)
    array = EstimateArray(values + 0.01 * signs, RUN, "W", ("u", "v"), {"u": np.arange(3), "v": np.arange(4)})
    finding = Finding("doubtful", "detector 'm'", "", "what", np.full((2, 3), 0.03), "")
    array._with_findings(lambda: (finding,))
    assert (
        array.verdict.tolist() == [["doubtful", "doubtful", "sound"], ["bounded"] * 3]
        or array.verdict[0, 0] == "doubtful"
    )
    assert array[0, 0].findings[0].bound == 0.03 and array[1].findings[0].bound.shape == (3,)
    assert array.sum().findings[0].bound == pytest.approx(0.03)  # a score falls into one bin only
    assert array.sum("u").findings[0].bound == pytest.approx([0.03] * 3)
    assert array.mean().findings[0].bound == pytest.approx(0.005)
    assert (array * estimate(2.0, 0.1)).findings[0].bound[1, 2] == pytest.approx(0.06)
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
        assert finding.what == "light by 'mirror' not sampled" and finding.bound == pytest.approx(bound)
    assert longer["m"].irradiance.findings[0].bound == pytest.approx(bound / 2)
    h5netcdf = pytest.importorskip("h5netcdf")
    with h5netcdf.File(path) as stored:
        attributes = stored["m"].variables["irradiance"].attrs
        assert attributes["verdict"] == "doubtful"
        assert json.loads(attributes["findings"])[0]["what"] == "light by 'mirror' not sampled"


# ---- proofs of emptiness ----


def test_a_mirror_is_left_out_only_where_it_cannot_be_the_last_that_light_meets():
    disk = tp.Disk(radius=0.1)
    places = {"above": (0, 0, 1), "below": (0, 0, -1), "beside": (2, 0, 0)}
    for name, place in places.items():
        ball = tp.Surface(tp.Sphere(center=place, radius=0.5), tp.Mirror(0.9), name)
        scene = tp.Scene(tp.Source(tp.Point(position=(0, 0, 5)), tp.Isotropic(power=1.0)), [ball])
        assert mirrors_of(scene, disk, "front") == ([] if name == "below" else [repr(name)])
        assert mirrors_of(scene, disk, None) == [repr(name)]
    box = tp.Surface(tp.Box(center=(0, 0, 1), size=1.5), tp.Diffuse(0.5), "box")
    scene = tp.Scene(
        scene.sources, [tp.Surface(tp.Sphere(center=(0, 0, 1), radius=0.5), tp.Mirror(0.9), "in a box"), box]
    )
    assert mirrors_of(scene, disk, "front") == []
    away = tp.TwoSided(tp.Diffuse(0.5), tp.Mirror(0.9))  # its back mirrors
    for normal, found in (((0, 0, -1), []), ((0, 0, 1), ["'panel'"])):
        panel = tp.Surface(tp.Rectangle(center=(0, 0, 3), normal=normal, width=1, height=1), away, "panel")
        assert mirrors_of(tp.Scene(scene.sources, [panel]), disk, "front") == found


@pytest.mark.parametrize(
    "material",
    [tp.Mirror(0.5, 0.5), tp.Glossy(0.05, 0.9), tp.Mixture({tp.Mirror(1.0): 0.2, tp.Diffuse(0.5): 0.8})],
)
def test_every_material_that_no_ray_connects_is_named(material):
    result = tp.simulate(mirror(material), 20_000, seed=1, estimator="expected", threads=1, progress=False)
    assert "light by 'mirror'" in str(result["m"].irradiance) and result["m"].irradiance.is_doubtful
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


# ---- runs ----


def test_a_run_for_an_error_stops_where_nothing_within_its_limits_settles_a_doubt():
    result = tp.simulate(mirror(), error={"m.irradiance": 1e-3}, seed=1, estimator="expected", progress=False)
    assert result.particles < 1e6 and result["m"].irradiance.is_doubtful
    assert any(
        "because no run within its limits settles a doubt: light by 'mirror' not sampled" in each
        for each in result.warnings
    )
    wide = tp.Detector(tp.Disk(center=(1.5, 0, -0.5), normal=(-1, 0, 0), radius=0.1), "m")
    settled = tp.simulate(
        mirror(detectors=[wide]), error={"m.irradiance": 0.03}, seed=1, estimator="expected", progress=False
    )
    assert settled["m"].irradiance.verdict == "sound" and settled["m"].irradiance.relative_error < 0.03


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
