"""Every closed form of every sim, and the sims' manners.

All runs have seed 1.  The rows of all sims together fail right code in one of a thousand seeds.
"""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest

import transport as tp
from tests.agreement import assert_agrees, smallest_bias
from transport.sims import sun
from transport.verification.experiment import cases_of, experiment, experiment_names, run_experiment

SIMS = (
    "camera", "cloud", "cost_caustic", "cost_disks", "cost_enclosure", "cost_fog", "cost_glint", "cost_speck", "diffuse_box",
    "directions", "dogleg", "effusion", "flows", "fog", "furnace", "glow", "gonioreflectometer", "half_space",
    "integrating_sphere", "inverse_square", "lambert_disk", "limits", "magnifier", "milk", "penumbra",
    "phase_functions", "phase_space", "photon_gas", "point_in_fog", "pressure", "refraction", "slab", "sun",
    "throughput", "tube", "two_elements", "two_panes", "view_factors", "wall_distance",
)  # fmt: skip
FALSE_ALARM = 1e-3  # of all rows of all sims together
PARTICLES = 10_000_000
FEWER = {  # where histories are long, or fewer show a bias of a tenth; `transport verify --particles 1e7` runs all with more
    "camera": 1_000_000, "cloud": 6_000_000, "cost_enclosure": 1_000_000, "cost_fog": 700_000, "cost_glint": 300_000,
    "cost_speck": 300_000, "diffuse_box": 1_000_000, "directions": 3_000_000, "dogleg": 1_200_000, "effusion": 6_000_000,
    "flows": 1_000_000, "furnace": 5_000_000, "glow": 1_500_000, "gonioreflectometer": 8_000_000, "half_space": 4_500_000, "integrating_sphere": 1_000_000,
    "lambert_disk": 2_000_000, "magnifier": 2_000_000, "milk": 350_000,
    "phase_functions": 1_000_000, "phase_space": 5_000_000, "point_in_fog": 1_000_000, "pressure": 1_000_000,
    "throughput": 2_000_000, "tube": 1_000_000, "two_elements": 1_000_000,
    "two_panes": 1_000_000,
    "view_factors": 2_500_000, "wall_distance": 2_000_000,
}  # fmt: skip
MOST_DRAWN = 12  # of a sim's cases alone; what else its pictures are is tested in its own file


@pytest.fixture(scope="module")
def tables():
    return {
        name: run_experiment(experiment(name), particles=FEWER.get(name, PARTICLES), seed=1, threads=2)
        for name in SIMS
    }


@pytest.fixture(scope="module")
def false_alarm(tables):
    """Of one row (Bonferroni)."""
    return FALSE_ALARM / sum(len(outcome.rows) for outcomes in tables.values() for outcome in outcomes)


def rows_of(outcomes):
    """Rows that are estimates; a bin that nothing may reach must have counted nothing, and is left out."""
    for outcome in outcomes:
        for row in outcome.rows:
            if row.exact == 0 and row.estimate.reason == "no score":
                assert row.estimate.value == 0
            else:
                yield outcome, row


@pytest.mark.parametrize("name", SIMS)
def test_every_closed_form_is_met(name, tables, false_alarm):
    wrong = []
    for outcome, row in rows_of(tables[name]):
        try:
            assert_agrees(row.estimate, row.exact, false_alarm)
        except AssertionError as error:
            wrong.append(f"{outcome.title}: {row.name}: {error}")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", SIMS)
def test_a_bias_of_a_tenth_would_be_caught_in_every_row(name, tables, false_alarm):
    """But for the last degree above the horizon, into which 1 in 3000 particles fly."""
    for outcome, row in rows_of(tables[name]):
        if row.exact != 0 and "89° to 90°" not in row.name:
            bias = smallest_bias(row.estimate, false_alarm)
            assert bias < 0.1, f"{outcome.title}: {row.name}: {bias:.1%}"


@pytest.mark.parametrize("name", SIMS)
def test_the_ledger_closes_and_nothing_is_lost(name, tables):
    for outcome in tables[name]:
        ledger = outcome.result.ledger
        ends = math.fsum(entry.value for key, entry in ledger.items() if key != "emitted")
        assert ledger["lost"].value == 0
        assert ends == pytest.approx(ledger["emitted"].value, rel=1e-13)


def test_every_experiment_is_tested_here():
    assert set(SIMS) <= set(experiment_names())


@pytest.mark.parametrize("name", SIMS)
def test_a_sim_keeps_its_contract(name, tables, tmp_path, monkeypatch):
    monkeypatch.setattr("transport.viz.style.RESOLUTION", 30)  # takes a third less of the time
    module, outcomes = experiment(name), tables[name]
    assert module.law
    assert module.question.endswith("?")
    assert module.particles > 0
    for outcome in outcomes:
        assert {row.name for row in outcome.rows} == set(module.exact(**outcome.parameters))
    assert module.verdict(outcomes).endswith(".")
    module.draw(outcomes, tmp_path / "all.png")
    for k, outcome in enumerate(outcomes):  # each case alone, as by `--set`
        assert module.verdict([outcome]).endswith(".")
        if k % math.ceil(len(outcomes) / MOST_DRAWN) == 0:
            module.draw([outcome], tmp_path / f"{k}.png")
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in tmp_path.iterdir())


@pytest.mark.parametrize("name", SIMS)
def test_parameters_may_be_set_for_all_cases(name):
    module = experiment(name)
    settings = {
        "camera": {"width": 60, "height": 45},
        "cloud": {"zenith": 0.5},
        "cost_caustic": {"index": 1.8, "radiance": 3.0},
        "cost_disks": {"radius": 0.1, "meter": 1e-3, "distance": 1e-3, "radiance": 5.0},
        "cost_enclosure": {"meter": 0.3, "lamp": 0.3, "radius": 1e-3},
        "cost_fog": {"tau": 3.0, "distance": 1.1, "lamp": 0.5, "radius": 1e-6},
        "cost_glint": {"share": 1e-3, "meter": 0.2},
        "cost_speck": {"share": 1e-3, "distance": 2.0, "size": 0.5},
        "dogleg": {"built": "voxels"},
        "diffuse_box": {"exitance": 5.0},
        "directions": {"power": 3.0, "size": 1e-6},
        "effusion": {"temperature": 77.0, "loss": 0.2},
        "flows": {"speed": 3.0, "density": 1e12, "power": 2.0},
        "fog": {"tau": 0.7},
        "furnace": {"radiance": 7.0, "index": 1.3},
        "glow": {"radiance": 7.0, "index": 1.3},
        "gonioreflectometer": {"angle": 0.6},
        "half_space": {"albedo": 0.8},
        "integrating_sphere": {"radius": 2.0},
        "inverse_square": {"power": 3.0},
        "lambert_disk": {"radiance": 7.0, "radius": 0.25},
        "limits": {"radius": 0.1, "separation": 0.6, "burst": 1e-6},
        "magnifier": {"radiance": 7.0, "index": 1.6},
        "milk": {"absorption": 2000.0, "index": 1.5},
        "penumbra": {"radius": 0.1, "gap": 0.4},
        "phase_functions": {"g": 0.5},
        "phase_space": {"length": 1e-6, "speed": 300.0},
        "photon_gas": {"stuff": "charge", "density": 1e20, "speed": 500.0},
        "point_in_fog": {"mean_free_path": 1e-3},
        "pressure": {"energy_density": 3.0, "temperature": 600.0},
        "refraction": {"index": 2.4},
        "slab": {"tau": 3.0, "albedo": 0.7},
        "sun": {"zenith_angle": math.pi / 2},  # the sun half below the horizon
        "throughput": {"radiance": 7.0, "size": 0.008, "index": 1.6},
        "tube": {"radius": 1e-3},
        "two_elements": {"radiance": 7.0, "distance": 2.0},
        "two_panes": {"index": 2.4},
        "view_factors": {"obstacle": 0.3},
        "wall_distance": {"radiance": 7.0, "size": 1.0},
    }[name]
    rows = list(rows_of(run_experiment(module, settings, particles=1_000_000, seed=1)))
    for outcome, row in rows:
        assert outcome.parameters.items() >= settings.items()
        assert_agrees(row.estimate, row.exact, FALSE_ALARM / len(rows))


def test_stuff_flows_in_its_own_unit():
    module = experiment("photon_gas")
    units = {"photons": "s^-1 m^-2", "mass": "kg s^-1 m^-2", "charge": "C s^-1 m^-2", "energy": "W m^-2"}
    for stuff, unit in units.items():
        [outcome] = run_experiment(
            module, {"motion": "stream", "tilt": 0.0, "stuff": stuff}, particles=10_000
        )
        assert outcome["net"].estimate.unit == tp.Unit.parse(unit)


def test_unknown_choices_are_refused_with_the_possible_ones():
    for name, wrong in {
        "diffuse_box": {"emitting": "floor"},
        "directions": {"subject": "cube"},
        "flows": {"meter": "open"},
        "inverse_square": {"emitter": "cube"},
        "phase_functions": {"grains": "dust"},
        "photon_gas": {"stuff": "phlogiston"},
        "sun": {"planet": "Pluto"},
        "two_panes": {"incidence": "normal"},
    }.items():
        with pytest.raises(tp.SceneError, match=next(iter(wrong.values()))):
            experiment(name).scene(**wrong)
    with pytest.raises(tp.SceneError, match="albedo must be below 1"):
        experiment("diffuse_box").scene(albedo=1)
    with pytest.raises(tp.SceneError, match="zenith_angle"):
        cases_of(sun, {"zenith_angel": 0.1})


def test_the_sun_gives_the_figures_of_the_lecture():
    """1373.5 and 598.6 W with L rounded to 2.05e7: 1374 and 599 W; 1390 and 599 W from the planets' distances."""
    exact = [sun.exact(**case) for case in sun.cases()]
    assert [round(rows[sun.POWER]) for rows in exact] == [1374, 599, 1390, 599]
    assert all(round(rows[sun.RADIANCE] / 1e7, 2) == 2.05 for rows in exact)
    assert [rows[sun.POWER] for rows in exact[:2]] == pytest.approx([1373.5, 598.6], rel=3e-4)


def run_python(*arguments):
    """In a process of its own, from the folder that holds the packages."""
    command, folder = [sys.executable, *arguments], Path(__file__).parent.parent
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)


def test_sims_are_silent_and_light_to_import():
    code = f"import sys, {', '.join(f'transport.sims.{name}' for name in SIMS)}; print({{'numba', 'matplotlib'}} & {{*sys.modules}})"
    done = run_python("-c", code)
    assert done.stdout == "set()\n"
    assert done.stderr == ""


def test_a_sim_runs_itself():
    done = run_python("-m", "transport.sims.inverse_square")
    assert "E(1 mm) / E(1 km)" in done.stdout
    assert "emitter=sphere, widths=5" in done.stdout
