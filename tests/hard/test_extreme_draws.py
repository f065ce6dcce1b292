"""Draws of 0 and of 1 - 2^-52 in every sampler: no NaN, no infinity, no endless loop, and the ledger closes.

All scenes of plain_scenes.py, between which every pass is run, as plain Python with half of all draws extreme.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.plain_scenes import SCENES

ROOT = Path(__file__).resolve().parents[2]
HISTORIES = 5
RUN = """
import json, sys
from tests.hard import extreme_draws as extreme
print(json.dumps({name: extreme.told(extreme.run(name, int(sys.argv[1]))) for name in sys.argv[2:]}))
"""
PLANTED = """
import math
from transport.engine.passes import emission as births
def sample_isotropic(u, turn):
    mu = 2.0 * u - 1.0
    s = math.sqrt(1.0 - mu * mu)
    x, y, _ = real(u, turn)
    return s * x / (s + 0.0 if s > 0 else math.nan), y, mu
real, births.sample_isotropic = births.sample_isotropic, sample_isotropic
"""


def plainly(code: str, *arguments: str) -> subprocess.CompletedProcess:
    """Run code in a new interpreter without compilation."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-c", code, str(HISTORIES), *arguments]
    return subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False, timeout=300
    )


@pytest.fixture(scope="module")
def found():
    done = plainly(RUN, *SCENES)
    assert done.returncode == 0, done.stderr[-3000:]
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.parametrize("name", SCENES)
def test_extreme_draws_lead_nowhere_but_to_an_end(found, name):
    """That it ended and its ledger closed to the last bit is told by its being here.

    In media a collision may come within the last digit of a wall, on its other side: such histories are lost, and counted.
    """
    sums = found[name]
    assert sums["is_finite"]
    assert sums["astray"] == 0
    assert sums["lost"] == 0 or 0 < sums["lost"] <= sums["collisions"]


def test_between_them_something_was_met(found):
    assert np.sum([sums["crossings"] for sums in found.values()]) > 100


def test_a_sampler_that_divides_by_a_sine_of_zero_is_caught():
    """Planted: a direction whose sine is divided by; only the two poles break it, which are never drawn by chance."""
    assert "FloatingPointError" in plainly(PLANTED + RUN, "beams", "vessel", "glow").stderr
