"""The bodies of passes serve another form than the bundle's loops: a whole program as one function of one particle, bit for bit."""

from __future__ import annotations

import pytest
from numba import config

from tests.one_particle import differences, program_of_sim, program_of_world

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="compares two forms of machine code")


@pytest.mark.quick_cases("sun", "slab")
@pytest.mark.parametrize("name", ["sun", "slab", "fog", "dogleg", "effusion", "refraction", "tube"])
def test_single_particles_give_the_sums_of_the_bundle(name):
    assert differences(program_of_sim(name)) == {}


@pytest.mark.slow
@pytest.mark.parametrize("sampling", ["sobol", "stratified"])
def test_single_particles_give_the_sums_of_the_bundle_by_quasi_random_numbers(sampling):
    assert differences(program_of_sim("cloud", sampling=sampling)) == {}


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 2, 3])
def test_single_particles_give_the_sums_of_the_bundle_in_random_scenes(number):
    assert differences(program_of_world(number)) == {}
