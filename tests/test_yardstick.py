"""The yardstick and the engine solve the same problems: their answers agree, so that their speeds may be compared."""

import numpy as np
import pytest

from tests.agreement import assert_agrees
from transport.cli.bench.benchmarks import bench, box_scene, disks_scene, render
from transport.cli.bench.yardstick import run_box, run_disks
from transport.cli.effects.costs import pass_costs
from transport.compile.compiler import compile_scene
from transport.geometry.flat import Disk
from transport.scene.detectors import Detector
from transport.scene.emissions import Lambertian
from transport.scene.scene import Scene
from transport.scene.sources import Source
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


def test_yardstick_and_engine_agree_on_every_wall(engine):
    arrivals, departures = walls_one_by_one()
    for wall, name in enumerate(WALLS):
        assert_agrees(engine[name].irradiance - estimated(arrivals[:, wall].sum(-1)), 0.0)
        assert_agrees(engine[name].exitance - estimated(departures[:, wall].sum(-1)), 0.0)


def test_yardstick_and_engine_agree_on_the_radiance_of_every_wall(engine):
    for tallies, quantity in zip(walls_one_by_one(), ("radiance", "radiance_out"), strict=True):
        for wall, name in enumerate(WALLS):
            radiance = tallies[:, wall] / (np.pi * np.diff(MU**2))
            by_one = EstimateArray(radiance, RUN, "s^-1 m^-2 sr^-1", ("mu",), {"mu": MU})
            assert_agrees(getattr(engine[name], quantity) - by_one, 0.0)


def test_a_yardstick_of_another_albedo_does_not_agree(engine):
    arrivals, _ = walls_one_by_one(albedo=0.52)
    with pytest.raises(AssertionError, match="z ="):
        assert_agrees(engine["-z"].irradiance - estimated(arrivals[:, 4].sum(-1)), 0.0)


def test_a_history_lands_twice_at_an_albedo_of_a_half():
    arrivals, departures = walls_one_by_one()
    assert_agrees(estimated(arrivals.sum((1, 2)), "1"), 2.0)
    assert_agrees(estimated(departures.sum((1, 2)), "1"), 2.0)


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


def passes_of(scene):
    from transport.engine.program import build_program

    return {lane_pass.name for lane_pass in build_program(compile_scene(scene)).passes}


def test_every_pass_of_a_program_has_a_cost():
    costs = pass_costs(box_scene())
    assert set(costs) == passes_of(box_scene())
    assert all(0.0 <= cost < 1000.0 for cost in costs.values())
    assert sum(costs.values()) > 0.1  # ns: less than one random block takes


def test_a_pass_that_no_particle_comes_to_costs_nan():
    behind = Detector(Disk(center=(0, 0, -1), radius=0.1), name="behind")
    scene = Scene([Source(Disk(radius=0.5), Lambertian(radiance=1.0))], detectors=[behind])
    costs = pass_costs(scene)
    assert set(costs) == passes_of(scene)
    assert costs["cover_disk"] > 0.0
    assert np.isnan(costs["bin_crossings"])


def test_ratios_are_shown_first_and_few_repeats_are_refused():
    with pytest.raises(ValueError, match="at least 5"):
        bench(repeats=3)
    rows = [
        {"name": "lost", "value": 0.0, "unit": "particles", "ratio": None},
        {"name": "box", "value": 3e7, "unit": "crossings/s", "ratio": 3.5},
    ]
    columns = [list(column.cells) for column in render(rows).columns]
    assert columns == [["box", "lost"], ["3.50", ""], ["30.0 M", "0"], ["crossings/s", "particles"]]
