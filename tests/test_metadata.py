"""What a stranger looks for first: licence, citation, changelog, and a README that says what the project is."""

from __future__ import annotations

import re
import tomllib

import pytest
import yaml

from tests.own_experiments import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
README = (ROOT / "README.md").read_text(encoding="utf-8")
FIRST_SCREEN = README.partition("\n## ")[0]


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
    text = FIRST_SCREEN.partition("![")[0]
    assert word in text
    assert len(text.splitlines()) <= 40
