"""Bundles of any size count the same: in a process of its own, whose bundles have 64 lanes, every bit is as in this one's."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests import test_grid, test_reproducible, test_reproducible_media
from tests.detectors import test_histories
from tests.hard import test_hard_points

ROOT = Path(__file__).resolve().parents[1]
DIGESTS = {
    "a bit of everything": lambda: test_reproducible.digest(test_reproducible.scene()),
    "clocks and snapshots": test_histories.digest,
    "grids": lambda: test_grid.digest("analog"),
    "grids, weighted": lambda: test_grid.digest("weighted"),
    # Where a copy lies in the bank, and when it is taken up, is nothing to it.
    "forced copies": lambda: test_reproducible_media.digest("forced"),
    "split copies": lambda: test_reproducible_media.digest("split"),
    "shadow rays": test_hard_points.digest,
}


@pytest.fixture(scope="module")
def elsewhere() -> dict[str, str]:
    """The digests in bundles of 64 lanes."""
    code = "import json; from tests.test_bundle_sizes import DIGESTS; from transport.engine.bundle import LANES; "
    code += "assert LANES == 64; print(json.dumps({name: digest() for name, digest in DIGESTS.items()}))"
    environment = os.environ | {"TRANSPORT_LANES": "64", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.parametrize("name", DIGESTS)
def test_bundles_of_64_lanes_count_the_same(name, elsewhere):
    assert elsewhere[name] == DIGESTS[name]()
