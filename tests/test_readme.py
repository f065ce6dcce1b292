"""README and guides: their experiments print what they say; commands, links and files exist; licence and changelog."""

from __future__ import annotations

import contextlib
import io
import re
import tomllib
from itertools import pairwise
from pathlib import Path

import matplotlib
import pytest
import yaml
from matplotlib import pyplot

from transport.cli.docs import CONTINUED, GUIDE_ORDER, GUIDES

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
PAGES = (README, *(GUIDES / f"{name}.md" for name in GUIDE_ORDER))
TIMED = ("cost:", "next digit:", "price of")  # lines that tell how fast this machine is


def fences(page):
    """Blocks between fences: language and text, in order."""
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S)
    return [(language, text) for language, text in blocks]


def experiments():
    """Each block of Python with the blocks before it that it goes on from, and what it prints."""
    for page in PAGES:
        before = []
        for (language, code), (after, said) in pairwise([*fences(page), ("", "")]):
            if language != "python":
                continue
            goes_on = page.stem in CONTINUED
            assert after == "text" or goes_on, f"{page.name} does not say what a block prints"
            if after == "text":
                yield pytest.param(tuple(before), code, said, id=f"{page.stem}")
            before = [*before, code] if goes_on else []


@pytest.mark.quick_cases("README", "numbers")
@pytest.mark.parametrize(("before", "code", "said"), list(experiments()))
def test_an_experiment_prints_what_the_page_says(before, code, said, tmp_path, monkeypatch):
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)  # where it saves its pictures
    variables = {}
    for block in (*before, code):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(block, "experiment", "exec"), variables)
    assert _without_times(printed.getvalue()) == _without_times(said)
    pyplot.close("all")


def _without_times(text):
    return [line.rstrip() for line in text.strip().splitlines() if not line.strip().startswith(TIMED)]


def test_the_first_experiment_is_a_dozen_lines():
    first = next(code for language, code in fences(README) if language == "python")
    assert len([line for line in first.splitlines() if line.strip()]) <= 12


def test_the_readme_is_one_page():
    """Words outside of blocks and tables, and bytes."""
    assert len(README.read_bytes()) < 7500
    text = re.sub(r"^```.*?^```$", "", README.read_text(encoding="utf-8"), flags=re.M | re.S)
    words = [word for line in text.splitlines() if not line.startswith("|") for word in line.split()]
    assert 300 < len(words) < 700


@pytest.mark.slow
def test_a_command_answers_as_the_page_of_commands_says(call):
    """`transport run sun`: the lines of its block are among what it prints, but for times."""
    said = next(
        text
        for language, text in fences(GUIDES / "commands.md")
        if language == "text" and text.startswith("sun\n")
    )
    printed = [line.rstrip() for line in call("run", "sun", "--no-picture").output.splitlines()]
    lines = [
        line.rstrip()
        for line in said.splitlines()
        if not line.startswith(("cost ", "next digit ", "picture "))
    ]
    assert len(lines) > 8 and [line for line in lines if line.strip() != "..." and line not in printed] == []


def links(page):
    return re.findall(r"\]\(([^)]+)\)", page.read_text(encoding="utf-8"))


def is_there(page, link):
    """Whether the file of a link exists and has a heading of its anchor."""
    name, _, anchor = link.partition("#")
    target = page.parent / name if name else page
    return target.exists() and (not anchor or anchor in anchors(target))


def anchors(page):
    """Anchors of the headings of a page, as hosts of code and the site make them."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    headings = re.findall(r"^#+ (.+)$", text, re.M)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_links_and_pictures_are_there():
    assert is_there(README, "#start") and not is_there(README, "#no-such-heading")
    missing = [f"{page.name}: {link}" for page in PAGES for link in links(page) if not is_there(page, link)]
    assert missing == [] and len(links(README)) >= 15


def test_every_guide_is_in_the_order_of_the_site():
    assert sorted(path.stem for path in GUIDES.glob("*.md")) == sorted(GUIDE_ORDER)


def test_files_that_the_pages_name_are_there():
    named = {
        name
        for page in PAGES
        for name in re.findall(r"\b(?:transport|sims|viz|tests)/[\w/]+\.(?:py|ipynb)\b", page.read_text())
    }
    assert named
    assert [name for name in sorted(named) if not (ROOT / name).is_file()] == []


def commands():
    """Every `transport ...` that the pages say, in blocks or between backticks."""
    found = set()
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        spans = [
            *re.findall(r"`(transport [^`]+)`", text),
            *(
                command
                for _, block in fences(page)
                for command in re.findall(r"^(?:\.venv/bin/)?(transport .+)$", block, re.M)
            ),
        ]
        found.update(span for span in spans if re.match(r"transport [a-z]+( |$)", span) and "..." not in span)
    return sorted(found)


@pytest.mark.quick_cases("transport checks", "transport cost SIM")
@pytest.mark.parametrize("command", commands())
def test_a_command_of_the_pages_is_one(command):
    """Its names, options and values are taken; `run sun` itself is run by tests/experiments/test_sims.py and by .ci/run."""
    from tests.cli.test_output import parsed

    parsed(command.replace(" SIM", " sun").replace(" COMMAND", " run"))


@pytest.mark.slow
def test_rows_of_the_table_of_laws_come_out(call):
    """The rows of two quick experiments, run again: the same digits."""
    import json

    text = (GUIDES / "laws.md").read_text(encoding="utf-8")
    table = [
        re.split(r"(?<!\\) \| ", line.strip("| ")) for line in text.splitlines() if line.startswith("| ")
    ]
    for sim in ("lambert_disk", "pressure"):
        rows = [row for row in table if len(row) == 6 and row[5].strip("`") == sim]
        found = json.loads(call("verify", sim, "--json").output)
        assert len(rows) > 2
        for _, _, estimate, exact, _, _ in rows:
            assert any(_agrees(row, estimate, exact) for row in found), (sim, estimate, exact)


def _agrees(row, estimate, exact):
    from transport.statistics.notation import estimate_text

    if estimate.endswith("(exact)") or " (exact) " in estimate:
        return row["error"] is None or row["error"] == 0
    unit = "" if row["unit"] == "1" else row["unit"]
    said = row["error"] is not None and estimate_text(row["value"], row["error"], unit, False, None).strip()
    return said == estimate and float(exact) == pytest.approx(row["exact"], rel=1e-5)


# Licence, citation, changelog, and a first screen that says what the project is

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_the_licence_is_stated_alike_everywhere():
    licence = (ROOT / "LICENSE").read_text()
    assert licence.startswith("BSD 3-Clause License\n\nCopyright (c) 2026, The transport authors\n")
    assert all(f"\n{clause}. " in licence for clause in (1, 2, 3))
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert PROJECT["license"] == citation["license"] == "BSD-3-Clause"
    assert PROJECT["license-files"] == ["LICENSE"]


def test_the_package_can_be_found_and_cited():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["cff-version"] == "1.2.0" and citation["version"] == PROJECT["version"]
    assert citation["authors"] == [{"name": "The transport authors"}]
    assert {"message", "title"} <= citation.keys() and not {"doi", "url", "identifiers"} & citation.keys()
    assert {"Monte Carlo", "radiometry"} <= {*PROJECT["keywords"]} & {*citation["keywords"]}
    groups = {classifier.split(" :: ")[0] for classifier in PROJECT["classifiers"]}
    assert {"Development Status", "Intended Audience", "Programming Language", "Topic"} <= groups
    assert (
        "License" not in groups
    )  # the expression says it; both together are refused when the package is built


def test_the_changelog_has_the_version_and_what_is_not_released_yet():
    """Keep a Changelog: versions in order, the newest first, changes under one of six headings."""
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    versions = re.findall(r"^## \[(.+?)\]", changelog, re.M)
    assert versions[:2] == ["Unreleased", PROJECT["version"]]
    kinds = set(re.findall(r"^### (.+)$", changelog, re.M))
    assert kinds and kinds <= {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}


@pytest.mark.parametrize("word", [
    "Monte Carlo", "Python library", "standard error", "pip install", "teach", "Limits", "one wavelength", "straight",
    "Mitsuba 3", "OpenMC", "MCX", "Raysect", "pvtrace", "Molflow+",
])  # fmt: skip
def test_the_first_screen_says_what_it_is_for_whom_and_what_to_use_instead(word):
    text = README.read_text(encoding="utf-8").partition("\n## ")[0].partition("![")[0]
    assert word in text
    assert len(text.splitlines()) <= 40
