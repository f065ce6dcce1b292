"""`transport run --tracking`: what a warning advises can be followed on the command line, and machines read the warning too."""

from __future__ import annotations

import json

from typer.testing import CliRunner

from transport.cli.commands import app

DEEP = ("run", "slab", "--set", "tau=20", "--set", "albedo=0.2", "--set", "g=0", "--set", "mu0=1", "--set", "incidence=beam",
    "--set", "phase=henyey-greenstein", "--particles", "2e4",
)  # fmt: skip


def told(*arguments):
    answer = CliRunner().invoke(app, [*DEEP, "--no-picture", *arguments])
    assert answer.exit_code == 0, answer.output
    return answer.output


def doubts(*arguments):
    return [text for text in json.loads(told("--json", *arguments))["warnings"] if "survivor" in text]


def test_a_warning_is_in_the_json_and_its_cure_is_an_option():
    """Followed once for the totals, and once more for the bins of direction; then nothing is in doubt."""
    found, advised = doubts(), []
    while found and len(advised) < 3:
        advised.append(
            min((text.partition("Tracking(roulette=")[2].partition(")")[0] for text in found), key=float)
        )
        found = doubts("--tracking", f"roulette={advised[-1]}")
    assert not found and 0 < len(advised) < 3, advised


def test_the_report_says_which_tracking_was_taken():
    for said, words in (("analog", "analog absorption"), ("weighted", "by weight"), ("forced", "forced")):
        assert words in told("--tracking", said)


def test_words_that_are_no_tracking_are_refused():
    for said in ("analogue", "roulette=much", "roulette=2", "roulet=0.1"):
        answer = CliRunner().invoke(app, [*DEEP, "--tracking", said])
        assert answer.exit_code != 0 and "racking" in answer.output, answer.output
