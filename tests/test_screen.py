"""Without the libraries of OpenGL all but 3-D pictures works, and what to install is said; in child processes without them."""

from __future__ import annotations

import ctypes.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TRY = """
import sys
import transport as tp
from transport.viz import screen
from transport.viz.scene_view import scene_view
disk = tp.Disk(radius=1.0)
scene = tp.Scene(tp.Source(disk, tp.Lambertian(power=1.0)), detectors=tp.Detector(disk, "disk"))
try:
    scene_view(scene, sys.argv[1])
except screen.NoScreen as refused:
    print("NO SCREEN", refused)
    try:
        scene_view(scene, sys.argv[1])
    except screen.NoScreen:
        print("AGAIN")
from transport.viz.style import figure_at
with figure_at(sys.argv[2], (4, 3), "a chart", None):
    pass
print("CHART")
"""


def child(code, folder, **environment):
    """What a new interpreter says, in which no window can open."""
    kept = {
        k: v
        for k, v in os.environ.items()
        if k not in ("DISPLAY", "WAYLAND_DISPLAY", "VTK_DEFAULT_OPENGL_WINDOW")
    }
    arguments = [str(folder / "scene.png"), str(folder / "chart.png")]
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=ROOT,
        env=kept | environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def without_libraries(tmp_path):
    """An environment in which the loader finds another library, without their functions, under their names."""
    other = ctypes.util.find_library("m")
    found = next((p for p in Path("/").glob(f"lib*/*/{other}")), None) if other else None
    if sys.platform != "linux" or found is None:
        pytest.skip("how to hide a library is known for Linux")
    hidden = tmp_path / "hidden"
    hidden.mkdir()
    for name in ("libEGL.so.1", "libGL.so.1", "libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"):
        shutil.copy(found, hidden / name)
    return {"LD_LIBRARY_PATH": str(hidden)}


def test_without_the_libraries_it_says_which_two_packages_to_install(without_libraries, tmp_path):
    done = child(TRY, tmp_path, **without_libraries)
    assert done.returncode == 0, done.stderr
    assert "NO SCREEN" in done.stdout and "AGAIN" in done.stdout and "CHART" in done.stdout
    assert "apt-get install -y libegl1 libgl1-mesa-dri" in done.stdout
    assert (tmp_path / "chart.png").exists() and not (tmp_path / "scene.png").exists()


def test_with_them_the_picture_is_drawn(tmp_path):
    done = child(TRY, tmp_path)
    if "NO SCREEN" in done.stdout:
        pytest.skip("no libraries of OpenGL here")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "scene.png").exists() and "CHART" in done.stdout
    assert done.stderr == ""


def test_without_pyvista_it_says_how_to_install_it(tmp_path):
    done = child("import sys\nsys.modules['pyvista'] = None\n" + TRY, tmp_path)
    assert done.returncode == 0, done.stderr
    assert "NO SCREEN" in done.stdout and "pip install '.[viz]'" in done.stdout and "CHART" in done.stdout


def test_nothing_of_it_is_loaded_before_a_picture_is_asked_for():
    code = "import sys, transport.viz.scene_view, transport.viz.screen, transport.viz.lobes_in_place; print('pyvista' in sys.modules, 'vtkmodules' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "False False", done.stdout + done.stderr
