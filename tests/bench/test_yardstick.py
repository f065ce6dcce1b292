"""The benchmarks: yardstick and engine agree, so that their speeds may be compared; prices; the list of benchmarks."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from tests.agreement import assert_agrees
from tests.bench.__main__ import FOLDER, main
from tests.bench.prices import ADDITIONS, base_room, prices_of
from tests.bench.speed import bench, box_scene, disks_scene, render
from tests.bench.yardstick import run_box, run_disks
from transport.analysis.effects import Treatment
from transport.simulate import simulate
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.replicates import Batches
from transport.theory.view_factors import coaxial_disks

RUN = Batches(np.full(32, 8000))
WALLS = "-x", "+x", "-y", "+y", "-z", "+z"
MU = np.linspace(0.0, 1.0, 17)


@pytest.fixture(scope="module")
def engine():
    return simulate(box_scene(), particles=400_000, seed=1, threads=1)


def walls_one_by_one(albedo=0.5):
    """Arrivals and departures per history, a batch a row: (batches, walls, cosines)."""
    runs = [run_box(int(size), 1000 + k, albedo=albedo)[1:] for k, size in enumerate(RUN.sizes)]
    return [np.array(tallies) / RUN.sizes[:, None, None] for tallies in zip(*runs, strict=True)]


def estimated(values, unit="s^-1 m^-2"):
    """An exitance of 1 W/m² on one wall of six alike: what a history brings to a wall is in W/m²."""
    return Estimate(values, RUN, unit)


@pytest.mark.slow
def test_yardstick_and_engine_agree_on_every_wall(engine):
    arrivals, departures = walls_one_by_one()
    for wall, name in enumerate(WALLS):
        assert_agrees(engine[name].irradiance - estimated(arrivals[:, wall].sum(-1)), 0.0)
        assert_agrees(engine[name].exitance - estimated(departures[:, wall].sum(-1)), 0.0)


@pytest.mark.slow
def test_yardstick_and_engine_agree_on_the_radiance_of_every_wall(engine):
    for tallies, quantity in zip(walls_one_by_one(), ("radiance", "radiance_out"), strict=True):
        for wall, name in enumerate(WALLS):
            radiance = tallies[:, wall] / (np.pi * np.diff(MU**2))
            by_one = EstimateArray(radiance, RUN, "s^-1 m^-2 sr^-1", ("mu",), {"mu": MU})
            assert_agrees(getattr(engine[name], quantity) - by_one, 0.0)


@pytest.mark.slow
def test_a_yardstick_of_another_albedo_does_not_agree(engine):
    arrivals, _ = walls_one_by_one(albedo=0.52)
    with pytest.raises(AssertionError, match="z ="):
        assert_agrees(engine["-z"].irradiance - estimated(arrivals[:, 4].sum(-1)), 0.0)


@pytest.mark.slow
def test_a_history_lands_twice_at_an_albedo_of_a_half():
    arrivals, departures = walls_one_by_one()
    assert_agrees(estimated(arrivals.sum((1, 2)), "1"), 2.0)
    assert_agrees(estimated(departures.sum((1, 2)), "1"), 2.0)


@pytest.mark.slow
def test_yardstick_engine_and_view_factor_agree_on_coaxial_disks():
    sizes = np.full(32, 40_000)
    hits = np.array([run_disks(int(size), 2000 + k)[0] for k, size in enumerate(sizes)])
    by_one = Estimate(hits / sizes, Batches(sizes), "1")
    result = simulate(disks_scene(), particles=1_000_000, seed=1, threads=1)
    exact = coaxial_disks(0.5, 0.1, 2.0)
    assert_agrees(by_one, exact)
    assert_agrees(result["meter"].flux_in / result.ledger["emitted"], exact)
    with pytest.raises(AssertionError, match="z ="):
        assert_agrees(by_one, exact / 2)  # what a dropped cosine gives


def test_ratios_are_shown_first_and_few_repeats_are_refused():
    with pytest.raises(ValueError, match="at least 5"):
        bench(repeats=3)
    rows = [
        {"name": "lost", "value": 0.0, "unit": "particles", "ratio": None},
        {"name": "box", "value": 3e7, "unit": "crossings/s", "ratio": 3.5},
    ]
    columns = [list(column.cells) for column in render(rows).columns]
    assert columns == [["box", "lost"], ["3.50", ""], ["30.0 M", "0"], ["crossings/s", "particles"]]


# The price list, with runs so short that only its shape is looked at.


@pytest.mark.slow
def test_additions_are_priced_over_the_scene_or_over_the_addition_that_they_need():
    names = ("a clock", "... bins of time, 16", "scattering", "... Rayleigh", "estimator aimed")
    few = [ADDITIONS[name] for name in names]
    found = prices_of(base_room(), few, turns=2, seconds=1e-4)
    assert [(price.name, price.over) for price in found.prices] == [
        ("unchanged", None),
        ("a clock", "unchanged"),
        ("... bins of time, 16", "a clock"),
        ("scattering", "unchanged"),
        ("... Rayleigh", "absorption and scattering"),
    ]
    assert list(found.refused) == ["estimator aimed"]
    assert all(price.ns > 0 and price.ratio > 0 for price in found.prices)
    clocked = Treatment(replace(base_room().scene, duration=1.0))
    again = prices_of(clocked, few[:2], turns=2, seconds=1e-4)
    assert again.idle == ("a clock",)
    assert [(price.name, price.over) for price in again.prices][1:] == [("... bins of time, 16", "unchanged")]


@pytest.mark.slow
def test_cells_of_a_volume_detector_cost_half_as_much_again_as_the_base_room():
    """Medians of many turns, so that other work on the machine takes from both alike."""
    addition = ADDITIONS["a volume detector of 8 x 8 x 8 cells"]
    (base, price) = prices_of(base_room(), [addition], turns=25, seconds=0.02).prices
    assert price.ratio > 1.5 and price.added > 0.5 * base.ns
    assert base.ratio == 1 and base.added == 0


# The list of benchmarks.


def test_every_benchmark_is_listed_with_a_sentence_and_runs_by_name(capsys, monkeypatch):
    assert main([]) == 0
    lines = capsys.readouterr().out.splitlines()[1:]
    files = {path.stem for path in FOLDER.glob("*.py")}
    assert {line.split()[0] for line in lines} == files - {
        "__main__", "frame", "yardstick", "trust_references", "test_yardstick",
    }  # fmt: skip
    assert all(len(line.split()) > 6 for line in lines)
    ran = []
    monkeypatch.setattr("runpy.run_module", lambda name, **_: ran.append((name, sys.argv[1:])))
    monkeypatch.setattr(sys, "argv", [])
    assert main(["mesh", "speed", "--repeats", "7"]) == 0
    assert ran == [("tests.bench.mesh", ["--repeats", "7"]), ("tests.bench.speed", ["--repeats", "7"])]
    assert main(["mehs"]) == 2 and "no benchmark 'mehs'" in capsys.readouterr().err
