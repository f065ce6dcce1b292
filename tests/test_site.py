"""The pages of the reference: every public name is on one of them, and they are built without a fault."""

from __future__ import annotations

import re
from html import unescape

import pytest
import typer

import transport as tp
from transport.cli.commands import app
from transport.cli.docs import GUIDE_ORDER, _is_internal, build_site, pages, write_sources
from transport.results.backward import ViewReading
from transport.results.detectors import Reading
from transport.results.phase_space import PhaseReading
from transport.results.points import PointReading
from transport.results.volumes import VolumeReading

COMMANDS = typer.main.get_command(app)


def test_every_public_name_is_on_one_page():
    names = [name for page in pages() for name in page.names]
    assert sorted(names) == sorted(tp.__all__)
    for page in pages():
        assert (page.names or page.pictures) and all(
            re.search(rf"\b{name}\b", page.text) for name in page.names
        )


def test_the_quantities_of_each_tally_are_in_a_table_with_their_meaning():
    (text,) = [page.text for page in pages() if page.file == "results"]
    for kind in (Reading, VolumeReading, PointReading, PhaseReading, ViewReading):
        table = text.partition(f"Quantities of `{kind.__name__}`")[2].partition(".. autoclass")[0]
        cells = [" ".join(cell.split()) for cell in re.split(r"\n   [* ] -(?= |\n)", table)]
        assert re.findall(r"^   \* - `(\w+)`", table, re.M) == list(kind.known)
        for name in kind.known:
            place = cells.index(f"`{name}`")
            quantity = getattr(kind, name)
            assert cells[place + 1].startswith(quantity.summary)
            assert cells[place + 2] == ", ".join(quantity.needs)


def test_a_name_of_a_module_without_a_page_is_seen(monkeypatch):
    stray = type("Stray", (), {"__module__": "transport.strays"})
    monkeypatch.setattr(tp, "Stray", stray, raising=False)
    monkeypatch.setattr(tp, "__all__", [*tp.__all__, "Stray"])
    with pytest.raises(LookupError, match=r"transport\.Stray"):
        pages()


def test_what_sphinx_reads_is_written(tmp_path):
    """README, guides, reference, help; every link of theirs leads to a page or a picture."""
    write_sources(tmp_path, COMMANDS)
    first = (tmp_path / "index.md").read_text()
    files = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.md")}
    assert files == {"index.md", "reference/commands.md"} | {f"guides/{name}.md" for name in GUIDE_ORDER} | {
        f"reference/{page.file}.md" for page in pages()
    }
    for file in files - {"index.md"}:
        assert file.removesuffix(".md") in first.split()
    for file in files:
        page = tmp_path / file
        lost = [
            link
            for link in re.findall(r"\]\(([^)]+)\)", page.read_text())
            if not (page.parent / link).exists()
        ]
        assert lost == [], file
    assert "transport run sun" in (tmp_path / "reference" / "commands.md").read_text()


def test_without_sphinx_the_error_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setattr("transport.cli.docs.REQUIRED_PACKAGES", ("sphinx_that_is_not_there",))
    with pytest.raises(tp.SceneError, match=r"pip install '\.\[docs\]'"):
        build_site(tmp_path, COMMANDS)


@pytest.mark.slow
def test_the_site_is_built_without_a_fault(tmp_path):
    """About 10 s, and needs the extra `docs`; .ci/run builds it with the installed command."""
    pytest.importorskip("sphinx")
    site = build_site(tmp_path, COMMANDS).parent
    for page in pages():
        html = unescape((site / "reference" / f"{page.file}.html").read_text())
        assert all(f'id="transport.{name}"' in html or f'id="{name}"' in html for name in page.names)
    assert (site / "_images").is_dir()
    files = (site / "reference" / "files.html").read_text()
    assert "Parameters" in files and "Examples" in files and "<strong>path</strong>" in files


def test_what_the_package_asks_of_shapes_and_materials_is_not_for_users():
    """Members whose base class has no sections in its docstring; a member of one class alone is shown."""

    def is_left_out(kind, name):
        return _is_internal(None, "class", name, getattr(kind, name), False, None) is True

    assert all(
        is_left_out(tp.Mirror, name) for name in ("row", "is_specular", "weighted_parts", "brightened")
    )
    assert all(is_left_out(tp.Disk, name) for name in ("primitives", "rims", "strip_areas", "contains"))
    shown = [(tp.Conductor, "reflectance"), (tp.Cone, "slope"), (tp.Disk, "bounds"), (tp.Cylinder, "area")]
    shown += [(tp.Rayleigh, "density"), (tp.Lambertian, "rate"), (Reading, "to_dataset")]
    assert not any(is_left_out(*each) for each in shown)
