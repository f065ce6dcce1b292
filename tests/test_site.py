"""The pages of the reference: every public name is on one of them, and they are built without a fault."""

from __future__ import annotations

import re
from html import unescape

import pytest
import typer

import transport as tp
from tests.test_readme import fences
from transport.cli.commands import app
from transport.cli.docs import GUIDE_ORDER, GUIDES, _is_internal, build_site, pages, write_sources
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
            if not link.startswith("#") and not (page.parent / link.partition("#")[0]).exists()
        ]
        assert lost == [], file
    assert "transport run sun" in (tmp_path / "reference" / "commands.md").read_text()


def test_without_sphinx_the_error_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setattr("transport.cli.docs.REQUIRED_PACKAGES", ("sphinx_that_is_not_there",))
    with pytest.raises(tp.SceneError, match=r"pip install '\.\[docs\]'"):
        build_site(tmp_path, COMMANDS)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The texts of the site's pages by path.

    It takes about 20 s and needs the extra `docs`; .ci/run builds it with the installed command.
    """
    pytest.importorskip("sphinx_codeautolink")
    folder = build_site(tmp_path_factory.mktemp("site"), COMMANDS).parent
    return {path: path.read_text(encoding="utf-8") for path in sorted(folder.rglob("*.html"))}


def page_of(site, name):
    (text,) = [text for path, text in site.items() if path.as_posix().endswith(f"/{name}.html")]
    return unescape(text)


@pytest.mark.slow
def test_the_site_has_every_public_name(site):
    for page in pages():
        html = page_of(site, f"reference/{page.file}")
        assert all(f'id="transport.{name}"' in html or f'id="{name}"' in html for name in page.names)
    files = page_of(site, "reference/files")
    assert "Parameters" in files and "Examples" in files and "<strong>path</strong>" in files


@pytest.mark.slow
def test_no_link_of_the_site_is_dead(site):
    """Every file and every anchor that a page links to, and every picture; nothing comes from a network."""
    anchors = {path: set(re.findall(r'\bid="([^"]+)"', text)) for path, text in site.items()}
    dead, found = [], 0
    for path, text in site.items():
        for link in map(unescape, re.findall(r'\b(?:href|src)="([^"]+)"', text)):
            found += 1
            name, _, anchor = link.partition("#")
            target = (path.parent / name.partition("?")[0]).resolve() if name else path
            if re.match(r"[a-z]+:", link):
                is_dead = re.search(r"\.(js|css|png)$", link) is not None
            elif target in anchors:
                is_dead = bool(anchor) and anchor not in anchors[target]
            else:
                is_dead = not target.is_file()
            if is_dead:
                dead.append(f"{path.name}: {link}")
    assert found > 1000 and dead == []


@pytest.mark.slow
def test_guides_and_reference_link_to_one_another(site):
    """Names in the text and in blocks lead to the reference, whose entries list the blocks that use them."""
    room = page_of(site, "guides/room")
    assert room.count('href="../reference/shapes.html#transport.Box"') >= 4
    for name in GUIDE_ORDER:
        if any(language == "python" for language, _ in fences(GUIDES / f"{name}.md")):
            assert 'href="../reference/' in page_of(site, f"guides/{name}").partition("</h1>")[2], name
    assert "<code" in (code := page_of(site, "guides/code")) and "runs.html#transport.simulate" not in code
    shapes = page_of(site, "reference/shapes")
    assert 'href="../guides/room.html#describe-the-scene"' in shapes


@pytest.mark.slow
def test_the_notebook_is_a_page_with_its_pictures_and_formulas(site):
    notebook = page_of(site, "guides/photons_to_pictures")
    assert notebook.count("<img") >= 3 and "data:image" in notebook
    assert (
        notebook.count("<math") > 10
        and "$"
        not in re.sub(r"<pre>.*?</pre>", "", notebook, flags=re.S)
        .partition("<article")[2]
        .partition("</article>")[0]
    )


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
