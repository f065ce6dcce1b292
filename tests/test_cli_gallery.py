"""`transport gallery`: figures in a folder and a page; a figure that cannot be drawn is reported."""

import json
from pathlib import Path

import pytest

from transport.cli import gallery
from transport.scene.scene import Scene
from transport.validation import SceneError
from transport.verification.experiment import experiment, scene_of

CURATED = Path(__file__).resolve().parents[1] / "viz" / "gallery"
LARGEST = 300_000  # bytes of a picture in the repository


@pytest.fixture
def exhibits(monkeypatch):
    """Two general figures that share one small scene, one that is refused, and one that needs a screen."""
    from transport.viz import exhibits

    shared = {"sim": "lambert_disk", "parameters": {"distance": 2.0}, "particles": 2000}

    def draw(result, tracks, path, note):
        path.write_text(f"{note}, {result.scene.detectors[0].name}")
        return path

    def refuse(result, tracks, path, note):
        raise SceneError("nothing to see")

    found = (
        exhibits.Exhibit("first", "The first.", draw, **shared),
        exhibits.Exhibit("second", "The second.", draw, **shared),
        exhibits.Exhibit("refused", "None.", refuse, **shared),
        exhibits.Exhibit("solid", "In space.", draw, is_solid=True, **shared),
    )
    monkeypatch.setattr(exhibits, "EXHIBITS", found)


@pytest.mark.slow
def test_an_experiment_is_drawn_with_its_answer_and_the_command_that_made_it(call):
    answer = call("gallery", "--only", "sun", "--particles", "2000", "--out", "pictures")
    assert answer.exit_code == 0, answer.output
    assert Path("pictures/experiments/sun.png").read_bytes().startswith(b"\x89PNG")
    page = Path("pictures/README.md").read_text(encoding="utf-8")
    for words in (
        "![sun](experiments/sun.png)",
        "`transport run sun --particles 2000`",
        "at most 2 000 particles",
        "±",
    ):
        assert words in page, words
    assert "What power of the sun falls" in page and "pictures/README.md" in answer.output


def test_figures_of_one_scene_share_one_run(call, exhibits, monkeypatch):
    runs, simulate = [], gallery.simulate
    monkeypatch.setattr(gallery, "simulate", lambda *a, **k: runs.append(a) or simulate(*a, **k))
    answer = call("gallery", "--only", "first", "--only", "second", "--json")
    assert answer.exit_code == 0, answer.output
    assert len(runs) == 1
    record = json.loads(answer.stdout)
    assert [each["name"] for each in record["figures"]] == ["first", "second"]
    assert Path(record["figures"][1]["pictures"][0]).read_text().startswith("2 000 particles, seed 0")
    assert record["page"] == "out/gallery/README.md" and Path(record["page"]).is_file()


def test_a_refused_figure_is_reported_and_the_rest_is_drawn(call, exhibits):
    answer = call("gallery", "--only", "refused", "--only", "first")
    assert answer.exit_code == 1
    assert "refused: no picture: nothing to see" in answer.stderr
    assert Path("out/gallery/first.png").is_file()
    assert "No picture: nothing to see" in Path("out/gallery/README.md").read_text()


def test_without_a_screen_only_pictures_in_space_are_left_out(call, exhibits, monkeypatch):
    from transport.viz import screen

    def lacking():
        raise screen.NoScreen("install libegl1")

    monkeypatch.setattr(screen, "require_screen", lacking)
    answer = call("gallery", "--only", "solid", "--only", "first")
    assert answer.exit_code == 0, answer.output
    assert "solid: no picture: install libegl1" in answer.stderr
    assert Path("out/gallery/first.png").is_file() and not Path("out/gallery/solid.png").exists()


def test_a_figure_that_there_is_not_is_refused(call, exhibits):
    answer = call("gallery", "--only", "frist")
    assert answer.exit_code == 2
    assert "gallery: no figure 'frist'; did you mean 'first'" in answer.stderr


def test_every_exhibit_has_a_scene_and_a_sentence():
    from transport.viz.exhibits import EXHIBITS

    assert len({exhibit.name for exhibit in EXHIBITS}) == len(EXHIBITS) >= 9
    for exhibit in EXHIBITS:
        assert exhibit.says.endswith(".") and 60 < len(exhibit.says) < 300, exhibit.name
        if exhibit.sim is None:
            assert isinstance(exhibit.scene, Scene)
        else:
            assert isinstance(scene_of(experiment(exhibit.sim), dict(exhibit.parameters), {}), Scene)


def test_the_pictures_of_the_repository_are_small():
    sizes = {path.name: path.stat().st_size for path in CURATED.glob("*.png")}
    assert len(sizes) >= 10
    assert not {name: size for name, size in sizes.items() if size >= LARGEST}
