"""Every pass runs as plain Python too (NUMBA_DISABLE_JIT=1) and counts what the compiled one counts.

The same few hundred histories are followed by both.  Counts are equal; weights agree to rounding, as compiled code
contracts a product and a sum into one operation and plain Python does not.
"""

from __future__ import annotations

import importlib
import json
import os
import pkgutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests import media_scenes
from tests.plain_scenes import METHODS, SCENES
from transport import engine
from transport.compile.compiler import compile_scene
from transport.compile.methods import ANALOG
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program
from transport.engine.registry import Pass

ROOT = Path(__file__).resolve().parents[1]
HISTORIES = 200


def sums_of(names):
    """What these scenes count, as lists; their passes by name."""
    results, passes = {}, set()
    for name in names:
        asked = media_scenes.TRACKINGS.get(name), METHODS.get(name, ANALOG)
        machine = compile_program(build_program(compile_scene(SCENES[name](), *asked)))
        raw = run_batch(machine, seed=12345678901, batch=1, histories=HISTORIES)
        passes |= {lane_pass.name for lane_pass in machine.program.passes}
        results[name] = {
            "meters": raw.detectors.tolist(),
            "ledger": raw.ledger.tolist(),
            "moments": raw.moments.tolist(),
            "records": [list(map(float, record)) for record in raw.records.tolist()],
            "crossings": raw.crossings,
            "collisions": raw.collisions,
        }
    return {"sums": results, "passes": sorted(passes)}


@pytest.fixture(scope="module")
def plain():
    """The same in a new interpreter without compilation."""
    code = "import json, numba; from tests import test_plain_python as t; assert numba.config.DISABLE_JIT; "
    code += "print(json.dumps(t.sums_of(t.SCENES)))"
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return json.loads(done.stdout)


@pytest.mark.parametrize("name", SCENES)
def test_plain_python_counts_what_compiled_code_counts(plain, name):
    compiled = sums_of([name])["sums"][name]
    interpreted = plain["sums"][name]
    assert interpreted["crossings"] == compiled["crossings"] > HISTORIES // 20
    assert interpreted["collisions"] == compiled["collisions"]
    for table in ("meters", "ledger"):
        one, other = (np.array(sums[table]) for sums in (interpreted, compiled))
        assert (one[:, 2] == other[:, 2]).all()
        weights, others = (w[:, 0] * 2.0**-32 + w[:, 1] * 2.0**-63 for w in (one, other))
        assert np.abs(weights - others).max() <= 1e-12 * HISTORIES
        assert (
            np.abs(one[:, 3] - other[:, 3]).max() <= 2 * other[:, 2].max()
        )  # slants, each rounded to its unit
    one, other = (np.array(sums["moments"]).reshape(-1, 4) for sums in (interpreted, compiled))
    limbs = np.array([2.0**-32, 2.0**-63, 2.0**-94, 2.0**-125])
    assert np.abs((one - other) @ limbs).max(initial=0.0) <= 1e-12 * HISTORIES
    one, other = (np.array(sums["records"]) for sums in (interpreted, compiled))
    assert one == pytest.approx(other, rel=1e-9, abs=1e-12)
    assert np.array(compiled["meters"])[:, 2].sum() > HISTORIES // 20


def test_every_pass_is_run(plain):
    """A new pass must be called for by one of these scenes."""
    modules = [
        importlib.import_module(f"{engine.__name__}.passes.{m.name}")
        for m in pkgutil.iter_modules([f"{engine.__path__[0]}/passes"])
    ]
    passes = {p.name for module in modules for p in vars(module).values() if isinstance(p, Pass)}
    assert passes - set(plain["passes"]) == {"record_tracks"}  # of pictures: see detectors/test_tracks.py
