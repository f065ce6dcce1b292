"""`transport view`: which files it writes and names, what it refuses, and that nothing else needs OpenGL."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import transport as tp
from tests.own_experiments import ROOT
from transport.cli import show
from transport.viz import scene_view, screen
from transport.viz.screen import has_screen

needs_screen = pytest.mark.skipif(not has_screen(), reason="no OpenGL here")
LIBRARIES = ("libEGL.so.1", "libEGL.so", "libGL.so.1", "libGL.so", "libOSMesa.so.8", "libOSMesa.so")
WITHOUT_OPENGL = """
import sys
from pathlib import Path
from typer.testing import CliRunner
from transport.cli import commands as cli

for words in ("view disk.py", "view disk.py --html", "run disk.py --particles 1e3", "view disk.py --vtk --particles 1e3"):
    answer = CliRunner().invoke(cli.app, words.split())
    print(words, "|", answer.exit_code, "|", " ".join(answer.output.split()))
print(Path("out/disk.png").read_bytes()[:4], Path("out/view_disk.vtm").exists(), Path("out/view_disk.png").exists())
"""


@pytest.fixture
def without_a_display(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)


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
    told = json.loads(answer.output)
    assert told["pictures"] == [f"figures/view_disk.{kind}" for kind in ("html", "vtm", "gif")]
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
    monkeypatch.setattr(scene_view, "scene_plotter", plotter)
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
def test_what_cannot_be_seen_is_refused_in_one_line(call, options, words):
    answer = call("view", "disks.py", "--vtk", *options)
    assert answer.exit_code == 2
    assert words in answer.output
    assert len(answer.output.splitlines()) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="libraries are hidden as Linux finds them")
def test_without_opengl_it_says_which_two_packages_to_install_and_all_else_works(call, tmp_path):
    """In a child process without OpenGL: 3-D pictures are errors; charts, pages and ParaView files work."""
    hidden = tmp_path / "hidden"
    hidden.mkdir()
    for name in LIBRARIES:
        (hidden / name).touch()
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    environment |= {"LD_LIBRARY_PATH": str(hidden), "PYTHONPATH": str(ROOT), "COLUMNS": "400"}
    command = [sys.executable, "-c", WITHOUT_OPENGL]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", env=environment, check=False)
    assert done.returncode == 0, done.stderr
    picture, page, run, files, written = done.stdout.splitlines()
    assert "| 2 | error: view: " in picture and "libegl1 libgl1-mesa-dri" in picture
    assert "| 0 |" in page and "picture out/view_disk.html" in page and "vtk" not in done.stderr
    assert "| 0 |" in run and "picture out/disk.png" in run
    assert "| 0 |" in files and "picture out/view_disk.vtm" in files
    assert written == r"b'\x89PNG' True False"


def test_files_that_cannot_be_written_are_told(call):
    Path("out/view_disk.vtm").mkdir(parents=True)
    answer = call("view", "disk.py", "--vtk", "--particles", "0", "--tracks", "0")
    assert answer.exit_code == 2
    assert "cannot write out/view_disk.vtm" in answer.output


def test_tracks_without_end_are_drawn_as_far_as_there_is_room(monkeypatch):
    """A room of mirrors: fewer tracks, then the start of one; a number from the user is not reduced."""
    walls = tp.Surface(tp.Box(size=2.0), tp.Mirror(0.99), "room")
    scene = tp.Scene(tp.Source(tp.Point(), tp.Isotropic(power=1.0)), walls)
    monkeypatch.setattr(show, "MAX_FLIGHTS", 5_000)
    few, note = show._find_tracks(scene, 300, 0, True)
    drawn = len(np.unique(few.histories))
    assert 1 < drawn < 100 and len(few) <= 5_000 and note.startswith(f"{drawn} of 300 tracks")
    assert len(np.unique(show._find_tracks(scene, 300, 0, False)[0].histories)) == 300
    monkeypatch.setattr(show, "MAX_FLIGHTS", 10)
    one, note = show._find_tracks(scene, 300, 0, True)
    assert len(one) == 10 and note.startswith("the first 10 flights of 1 of 300 tracks")
