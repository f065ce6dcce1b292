"""Every command's help has examples, and every example is a valid command."""

from __future__ import annotations

import re
import shlex

import pytest
import typer

from transport.cli.commands import app
from transport.cli.docs import command_pages
from transport.cli.options import named_errors, named_values, number, parse_tracking, whole_number
from transport.compile.methods import ESTIMATORS, SAMPLINGS
from transport.verification.experiment import experiment
from transport.verification.hard.cases import families

HELP = dict(command_pages(typer.main.get_command(app)))


def examples():
    return [
        line.strip()
        for text in HELP.values()
        for line in text.partition("Examples:")[2].partition("\n\n")[0].splitlines()
        if line.strip()
    ]


def parsed(command):
    """The values of a command's parameters, each looked at as the command would."""
    words = shlex.split(command)
    assert words[0] == "transport"
    group = typer.main.get_command(app)
    parent = group.make_context("transport", [], resilient_parsing=True)
    name, *arguments = [word for word in words[1:] if word != "--debug"]
    values = group.commands[name].make_context(name, arguments, parent=parent, resilient_parsing=False).params
    for key, read in READ.items():
        if values.get(key) is not None:
            read(values[key])
    names = values.get("sims") or [values.get("sim")]
    for each in names:
        if values.get("hard"):
            assert each is None or each in families()
        elif each and not each.endswith((".py", ".json")):
            _known(each, values)
    return values


READ = {
    "particles": lambda text: whole_number("--particles", text),
    "seconds": lambda text: number("--seconds", text),
    "error": named_errors,
    "tracking": parse_tracking,
    "estimator": lambda word: (*ESTIMATORS, "auto").index(word),
    "sampling": SAMPLINGS.index,
}


def _known(sim, values):
    """The experiment is there, and its scene takes what is set."""
    module = experiment(sim)
    if values.get("set_"):
        module.scene(**named_values(values["set_"]))


def test_every_command_has_examples():
    for name, text in HELP.items():
        assert re.search(rf"^\s+Examples:\n\s+transport {name}", text, re.M), name
    assert len(examples()) >= 2 * len(HELP)


@pytest.mark.parametrize("command", examples())
def test_an_example_is_a_command(command):
    parsed(command)


@pytest.mark.parametrize(
    "command",
    [
        "transport run sunn",
        "transport run sun --partikles 3",
        "transport run sun --particles many",
        "transport run sun --set distnace=3",
        "transport run sun --estimator backwards",
        "transport verify --hard sum",
        "transport cost sun --threads often",
    ],
)
def test_a_wrong_example_is_seen(command):
    with pytest.raises(Exception, match=r"\w"):
        parsed(command)
