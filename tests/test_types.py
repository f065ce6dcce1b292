"""The hints of the public names: what the pages and users write passes mypy, and wrong uses do not."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests import typed_sample
from tests.test_readme import PAGES, fences
from transport.cli.docs import CONTINUED

ROOT = Path(__file__).resolve().parents[1]
BEFORE_WRONG = """\
import transport as tp
scene = tp.Scene(tp.Source(tp.Disk(radius=1), tp.Lambertian(power=1)))
result = tp.simulate(scene, particles=1000)
"""
WRONG = {  # what users write by mistake: the name of mypy's error
    "tp.Sceen(sources=[])": "attr-defined",
    "tp.Scene(sources=3)": "arg-type",
    "tp.Scene(sources=['lamp'])": "list-item",
    "tp.Scene(sources=[], detectors=[tp.Disk(radius=1)])": "list-item",
    "tp.Disk(radius='1 m')": "arg-type",
    "tp.Disk(radius=1, centre=(0, 0, 1))": "call-arg",
    "tp.Disk()": "call-arg",
    "tp.Disk(center='abc', radius=1)": "arg-type",
    "tp.Detector('wall', speeds=3)": "arg-type",
    "tp.Detector(3)": "arg-type",
    "tp.Box(size=None)": "arg-type",
    "tp.Source(tp.Lambertian(power=1), tp.Disk(radius=1))": "arg-type",
    "tp.Detector('wall', directions=tp.Positions(u=3))": "arg-type",
    "tp.simulate(scene, particle=1000)": "call-arg",
    "tp.simulate(scene, seed='1')": "arg-type",
    "scene.duration = 1.0": "misc",
    "result.leger": "attr-defined",
    "result['meter'].irradience": "attr-defined",
    "result['meter'].irradiance.valu": "union-attr",
    "result['meter'].radiance[-1].eror": "union-attr",
    "result['meter'].irradiance + '1 W'": "operator",
    "result['meter'].flux_in < 3": "operator",
    "result.ledger['emitted'].valu": "attr-defined",
    "result.ledger['emitted'][0]": "index",
}


@pytest.fixture(scope="module")
def errors(tmp_path_factory) -> dict[str, list[tuple[int, str, str]]]:
    """What mypy reports of each file: line, name of the error, text; one run of it for all."""
    folder = tmp_path_factory.mktemp("typed")
    files = blocks() | {
        "sample": Path(typed_sample.__file__).read_text(encoding="utf-8"),
        "wrong": BEFORE_WRONG + "\n".join(WRONG),
    }
    for name, text in files.items():
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    options = ["--config-file", ROOT / "pyproject.toml", "--cache-dir", folder / "cache", "--output", "json"]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *options, *sorted(folder.glob("*.py"))],
        env=os.environ | {"MYPYPATH": str(as_installed(tmp_path_factory.mktemp("library")))},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1 and not done.stderr, done.stdout + done.stderr
    found: dict[str, list[tuple[int, str, str]]] = {name: [] for name in files}
    for line in map(json.loads, done.stdout.splitlines()):
        if line["severity"] == "error":
            found[Path(line["file"]).stem].append((line["line"], line["code"], line["message"]))
    return found


def as_installed(folder: Path) -> Path:
    """The package as a wheel lays it out, with `viz` and `sims` within it."""
    package = folder / "transport"
    package.mkdir()
    for path in [*(ROOT / "transport").iterdir(), ROOT / "viz", ROOT / "sims"]:
        (package / path.name).symlink_to(path)
    return folder


def blocks() -> dict[str, str]:
    """The blocks of Python in README and guides that stand by themselves, or go on from one another."""
    found = {}
    for page in PAGES:
        texts = [text for language, text in fences(page) if language in ("python", "py")]
        texts = ["\n".join(texts)] if page.stem in CONTINUED else texts
        found |= {
            f"{page.stem}_{place}": text for place, text in enumerate(texts) if "import transport" in text
        }
    return found


@pytest.mark.slow
def test_mypy_reports_nothing_of_what_the_pages_and_users_write(errors):
    assert len(blocks()) >= 7 and any(name.startswith("README") for name in errors)
    assert {name: found for name, found in errors.items() if found and name != "wrong"} == {}


@pytest.mark.slow
def test_mypy_reports_each_wrong_use(errors):
    first = len(BEFORE_WRONG.splitlines()) + 1
    found = {line: code for line, code, _ in errors["wrong"]}
    assert found == dict(enumerate(WRONG.values(), start=first)), errors["wrong"]
