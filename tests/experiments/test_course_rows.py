"""The rows of the course's experiments with few particles, in the default suite: what `tests/mutants` plants is seen here.

Each case shares a false-alarm rate of 1e-5 among its rows; the seed is 1.  The slow tests of each experiment judge
all of its cases with more particles.
"""

from __future__ import annotations

import math

import pytest

from tests.sim_runs import judge
from transport.sims import (
    directions,
    far_lamp,
    goniophotometer,
    light_fills_a_room,
    photon_gas,
    quantities,
    two_elements,
)
from transport.verification.experiment import run_experiment

TILTED = {"size_1": 0.05, "size_2": 0.02, "tilt_1": math.radians(75), "tilt_2": math.radians(45)}
CASES = [
    (two_elements, TILTED, 200_000),
    *[(quantities, {"show": show}, 100_000) for show in quantities.SHOWS],
    (light_fills_a_room, {"albedo": 0.7}, 100_000),
    (goniophotometer, {"lamp": "tube"}, 200_000),
    (goniophotometer, {"lamp": "sphere"}, 200_000),
    (far_lamp, {"height": 1.0}, 200_000),
    (directions, {"subject": "arc and area"}, 200_000),
    (directions, {"subject": "one steradian"}, 200_000),
    (directions, {"subject": "footprint", "tilt": math.radians(60)}, 200_000),
    (photon_gas, {"motion": "stream", "tilt": math.radians(60), "stuff": "energy"}, 200_000),
]


@pytest.mark.parametrize(
    ("module", "parameters", "particles"),
    CASES,
    ids=[f"{m.__name__.rpartition('.')[2]}-{next(iter(p.values()))}" for m, p, _ in CASES],
)
def test_rows_agree_with_few_particles(module, parameters, particles):
    outcome = run_experiment(module, parameters, particles=particles, seed=1)[0]
    judge([outcome])
