"""The speeds that the engine is held to; not in the default run, since a busy machine fails them.

pytest -m bench tests/bench
"""

import pytest

from tests.bench.speed import bench

pytestmark = pytest.mark.bench


@pytest.fixture(scope="module")
def rows():
    return {row["name"]: row for row in bench(repeats=7)}


def test_closed_box_is_three_and_a_half_times_as_fast_as_one_particle_at_a_time(rows):
    assert rows["closed box, against one particle at a time"]["ratio"] >= 3.5


def test_coaxial_disks_pass_120_million_particles_a_second(rows):
    assert rows["coaxial disks, against one particle at a time"]["value"] >= 120e6


def test_two_threads_are_1_7_times_as_fast_as_one(rows):
    assert rows["closed box, two threads against one"]["ratio"] >= 1.7


def test_no_particle_of_the_closed_box_is_lost(rows):
    assert rows["closed box, lost"]["value"] == 0
