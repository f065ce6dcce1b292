"""`transport view`: which files it writes and names, what it refuses; without OpenGL all but 3-D pictures works."""

from __future__ import annotations

import ctypes.util
import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import transport as tp
from tests.processes import python
from transport.cli import show
from transport.cli.commands import app
from transport.viz import scene, screen

needs_screen = pytest.mark.skipif(not screen.has_screen(), reason="no OpenGL here")
LIBRARIES = (
    *("libEGL.so.1", "libEGL.so", "libGL.so.1", "libGL.so"),
    *("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"),
)
CALL = """
from pathlib import Path
from typer.testing import CliRunner
from transport.cli import commands as cli

for words in ("view disk.py", "view disk.py --html", "run disk.py --particles 1e3", "view disk.py --vtk --particles 1e3"):
    answer = CliRunner().invoke(cli.app, words.split())
    print(words, "|", answer.exit_code, "|", " ".join(answer.output.split()))
print(Path("out/disk.png").read_bytes()[:4], Path("out/view_disk.vtm").exists(), Path("out/view_disk.png").exists())
"""
DRAW = """
import transport as tp
from transport.viz import scene, screen
from transport.viz.style import figure

assert "pyvista" not in sys.modules and "vtkmodules" not in sys.modules or sys.modules["pyvista"] is None
disk = tp.Disk(radius=1.0)
lit = tp.Scene(tp.Source(disk, tp.Lambertian(power=1.0)), detectors=tp.Detector(disk, "disk"))
for _ in range(2):
    try:
        scene.draw_scene(lit, path="scene.png")
        print("DRAWN")
    except screen.NoScreen as refused:
        print("NO SCREEN", refused)
with figure((4, 3), "a chart", path="chart.png"):
    pass
print("CHART")
"""

HIDE = """
class Hidden:
    @staticmethod
    def find_spec(name, path=None, target=None):
        if name.partition(".")[0] in {hidden}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Hidden)
import transport as tp

disk = tp.Disk(radius=1.0)
lit = tp.Scene(tp.Source(disk, tp.Lambertian(power=1.0)), detectors=tp.Detector(disk, "disk", directions=tp.Directions(mu=2)))
result = tp.simulate(lit, particles=100, progress=False)
for call in {calls}:
    try:
        eval(call)
    except tp.SceneError as refused:
        print(refused)
"""
EXTRAS = {  # packages that are not there: the extra of each call that needs them
    ("vtkmodules", "pyvista"): ("viz", ["lit.view('x.html')", "lit.view('x.png')"]),
    ("matplotlib",): ("plot", ["lit.plot()", "result.plot()", "result['disk'].plot()", "result['disk'].radiance.plot()"]),
    ("xarray",): ("files", ["result['disk'].to_dataset()", "result['disk'].radiance.to_xarray()"]),
    ("pandas",): ("files", ["result['disk'].to_dataframe()", "result['disk'].radiance.to_dataframe()"]),
    ("h5netcdf",): ("files", ["result.save('x.nc')"]),
}  # fmt: skip


@pytest.fixture
def without_a_display(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "VTK_DEFAULT_OPENGL_WINDOW"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def child(call, without_a_display):
    """A function that runs code in a new interpreter, in a folder with experiments, and returns what it printed."""

    def run(code, **environment):
        return python("-c", "import sys\n" + code, folder=Path.cwd(), **{"COLUMNS": "400"} | environment)

    return run


@pytest.fixture
def hidden(tmp_path):
    """An environment in which the loader finds, under the names of OpenGL's libraries, one without their functions."""
    other = ctypes.util.find_library("m")
    found = next((p for p in Path("/").glob(f"lib*/*/{other}")), None) if other else None
    if sys.platform != "linux" or found is None:
        pytest.skip("libraries are hidden as Linux finds them")
    folder = tmp_path / "hidden"
    folder.mkdir()
    for name in LIBRARIES:
        shutil.copy(found, folder / name)
    return {"LD_LIBRARY_PATH": str(folder)}


@pytest.mark.slow
@needs_screen
def test_without_a_display_it_draws_a_picture_and_names_it(call, without_a_display):
    from PIL import Image

    answer = call("view", "disks.py", "--case", "2", "--tracks", "20", "--particles", "1e4")
    assert answer.exit_code == 0, answer.output
    assert answer.output.splitlines() == ["disks: distance = 4.0", "picture     out/view_disks_2.png"]
    picture = np.asarray(Image.open("out/view_disks_2.png").convert("RGB")).astype(int)
    assert (abs(picture - picture[0, 0]).sum(axis=2) > 30).mean() > 0.01


@needs_screen
def test_all_kinds_of_files_are_named_at_the_end(call, monkeypatch):
    import pyvista as pv

    films = []

    def film(scene, path, tracks, **more):
        films.append((len(np.unique(tracks.histories)), more))
        Path(path).write_bytes(b"GIF89a")
        return path

    monkeypatch.setattr("transport.viz.movie.tracks_movie", film)
    options = ["--html", "--vtk", "--movie", "--colour", "weight", "--tracks", "15", "--particles", "0"]
    answer = call("view", "disk.py", *options, "--out", "figures", "--json")
    assert answer.exit_code == 0, answer.output
    kinds = ("html", "vtm", "gif")
    assert json.loads(answer.output)["pictures"] == [f"figures/view_disk.{kind}" for kind in kinds]
    assert films == [(15, {"colour": "weight", "title": "disk"})]
    blocks = pv.read("figures/view_disk.vtm")
    assert len(np.unique(blocks["tracks"].cell_data["history"])) == 15
    assert Path("figures/view_disk.html").read_text(encoding="utf-8").startswith("<!doctype html>")


@needs_screen
def test_with_a_display_it_opens_a_window_and_writes_nothing(call, monkeypatch):
    opened = []

    class Window:
        def show(self, title):
            opened.append(title)

    def plotter(scene, result, tracks, off_screen):
        opened.append(off_screen)
        return Window()

    monkeypatch.setattr(screen, "has_display", lambda: True)
    monkeypatch.setattr(scene, "draw_scene", plotter)
    answer = call("view", "disk.py", "--particles", "0", "--tracks", "0")
    assert answer.exit_code == 0, answer.output
    assert opened == [False, "disk"]
    assert not Path("out").exists()


@pytest.mark.parametrize("options, words", [
    (["--case", "3"], "no case 3; disks has 2 cases"),
    (["--case", "0"], "no case 0; disks has 2 cases"),
    (["--colour", "age"], "--colour must be direction or weight, got 'age'"),
    (["--particles", "0.5"], "--particles must be a whole number"),
    (["--set", "dist=1"], "no parameter 'dist'"),
])  # fmt: skip
def test_invalid_options_are_refused_in_one_line(call, options, words):
    answer = call("view", "disks.py", "--vtk", *options)
    assert answer.exit_code == 2
    assert words in answer.output
    assert len(answer.output.splitlines()) == 1


def test_files_that_cannot_be_written_are_named(call):
    Path("out/view_disk.vtm").mkdir(parents=True)
    answer = call("view", "disk.py", "--vtk", "--particles", "0", "--tracks", "0")
    assert answer.exit_code == 2
    assert "cannot write out/view_disk.vtm" in answer.output


@pytest.mark.slow
def test_without_opengl_it_names_two_packages_and_all_else_works(child, hidden):
    """3-D pictures are errors; charts, pages and ParaView files work."""
    done = child(CALL + DRAW.replace("assert", "True or "), **hidden)
    picture, page, run, files, written, *drawn = done.stdout.splitlines()
    assert "| 2 | error: view: " in picture and "libegl1 libgl1-mesa-dri" in picture
    assert "| 0 |" in page and "picture out/view_disk.html" in page and "vtk" not in done.stderr
    assert "| 0 |" in run and "picture out/disk.png" in run
    assert "| 0 |" in files and "picture out/view_disk.vtm" in files
    assert written == r"b'\x89PNG' True False"
    assert [line[:9] for line in drawn] == ["NO SCREEN", "NO SCREEN", "CHART"]
    assert "apt-get install -y libegl1 libgl1-mesa-dri" in drawn[0]
    assert Path("chart.png").exists() and not Path("scene.png").exists()


@pytest.mark.slow
@needs_screen
def test_with_opengl_the_picture_is_drawn_and_nothing_is_loaded_before(child):
    done = child(DRAW)
    assert done.stdout.split() == ["DRAWN", "DRAWN", "CHART"] and done.stderr == ""
    assert Path("scene.png").exists()


@pytest.mark.slow
def test_without_pyvista_the_error_names_the_extra(child):
    done = child("sys.modules['pyvista'] = None\n" + DRAW)
    assert "NO SCREEN" in done.stdout and "pip install '.[viz]'" in done.stdout and "CHART" in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("hidden", EXTRAS)
def test_what_is_not_installed_is_named_with_its_extra(child, hidden):
    extra, calls = EXTRAS[hidden]
    lines = child(HIDE.format(hidden=hidden, calls=calls)).stdout.splitlines()
    assert len(lines) == len(calls), lines
    for line in lines:
        assert "is not installed" in line and f"pip install '.[{extra}]'" in line


def test_a_file_that_is_not_there_is_named_before_what_is_not_installed(monkeypatch):
    monkeypatch.setitem(sys.modules, "transport.viz.screen", None)
    answer = CliRunner().invoke(app, ["view", "nofile.json", "--html"])
    assert "nofile.json: cannot be read" in answer.output and "installed" not in answer.output


def test_endless_tracks_are_drawn_as_far_as_there_is_room(monkeypatch):
    """A room of mirrors: fewer tracks, then the start of one; a number from the user is not reduced."""
    walls = tp.Surface(tp.Box(size=2.0), tp.Mirror(0.99), "room")
    mirrors = tp.Scene(tp.Source(tp.Point(), tp.Isotropic(power=1.0)), walls)
    monkeypatch.setattr(show, "MAX_FLIGHTS", 5_000)
    few, note = show._find_tracks(mirrors, 300, 0, True)
    drawn = len(np.unique(few.histories))
    assert 1 < drawn < 100 and len(few) <= 5_000 and note.startswith(f"{drawn} of 300 tracks")
    assert len(np.unique(show._find_tracks(mirrors, 300, 0, False)[0].histories)) == 300
    monkeypatch.setattr(show, "MAX_FLIGHTS", 10)
    one, note = show._find_tracks(mirrors, 300, 0, True)
    assert len(one) == 10 and note.startswith("the first 10 flights of 1 of 300 tracks")
