"""A first run: the cost that it reports leaves compilation out, and it works in the folder of the clone."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import transport as tp
from transport.compile.compiler import compile_scene
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program

ROOT = Path(__file__).resolve().parents[1]
LAMP = tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0))
FOG = tp.Surface(tp.Sphere(radius=0.5), tp.Transparent(), inside=tp.Medium(scattering=1.0))
SPLIT = tp.Tracking(splitting=tp.Splitting(start=(0, 0, 1), end=(0, 0, -1), gain=10.0))
SETTINGS = {
    "clock": (tp.Scene(LAMP, FOG, tp.Snapshot(1e-9, particles=10), duration=1e-8), None),
    "rays": (tp.Scene(LAMP, FOG, tp.PointDetector((0, 0, 2), "p")), None),
    "splitting": (tp.Scene(LAMP, FOG), SPLIT),
}


@pytest.mark.parametrize("setting", SETTINGS)
def test_a_batch_of_no_histories_counts_nothing(setting):
    """By it the driver is compiled before the clock of a first run starts."""
    raw = run_batch(
        compile_program(build_program(compile_scene(*SETTINGS[setting]))), seed=1, batch=0, histories=0
    )
    assert raw.crossings == raw.collisions == len(raw.records) == 0
    assert not raw.detectors.any() and not raw.ledger.any()


def test_the_driver_is_compiled_before_the_clock_starts(monkeypatch):
    driven, told = [], []

    class Fresh:
        __name__, signatures = "drive", ()

        def __call__(self, *arguments):
            driven.append(arguments[-1])

    monkeypatch.setattr("transport.engine.driver.drive", Fresh())
    program = build_program(compile_scene(tp.Scene(LAMP)))
    compile_program(program, lambda *said: told.append(said))
    assert driven == [0]
    assert told[-1] == (len(program.passes), len(program.passes), "drive")


def test_a_script_in_a_clone_finds_pictures_and_experiments():
    """Its folder comes first on the path: what is installed elsewhere does not help."""
    code = (
        "import sys; sys.meta_path = [each for each in sys.meta_path if 'editable' not in repr(each)];"
        f" sys.path.insert(0, {str(ROOT)!r}); import transport.viz.plots, transport.sims.sun;"
        " print(transport.viz.__file__)"
    )
    answer = subprocess.run([sys.executable, "-I", "-c", code], capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.strip() == str(ROOT / "viz" / "__init__.py")
