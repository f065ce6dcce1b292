"""Menu, list, version, help and benchmarks; tables and texts as wide as they may be; what an interruption leaves."""

import json
import re
import shlex
from types import SimpleNamespace

import pytest
import typer

from tests.processes import python
from transport import __version__
from transport.cli import commands
from transport.cli.docs import command_pages
from transport.cli.options import named_errors, named_values, number, parse_tracking, whole_number
from transport.cli.output import print_labelled, print_rich, table_of
from transport.compile.methods import ESTIMATORS, SAMPLINGS
from transport.verification.experiment import experiment, experiment_names
from transport.verification.hard.cases import families


def test_version(call):
    assert call("--version").output.split() == ["transport", __version__]


def test_bare_command_is_a_menu_of_all_experiments_on_one_screen(call):
    lines = call().output.splitlines()
    assert len(lines) <= 30 and max(map(len, lines)) <= 110
    assert "start here" in lines[2] and "transport run sun" in lines[3]
    named = [name for names in commands.GROUPS.values() for name in names]
    assert sorted(named) == sorted(experiment_names()) and len(commands.GROUPS) == 7  # and the commands
    told = {word.strip(",") for line in lines for word in line.split()}
    assert set(named) <= told
    for name in ("plot", "run", "verify", "docs"):
        assert name in told


def test_experiments_are_listed_by_question(call, monkeypatch):
    asked = {"a": ("Why?", "A = 1"), "b": ("How?", "B = 2"), "c": ("Why?", "C = 3")}
    modules = {name: SimpleNamespace(question=question, law=law) for name, (question, law) in asked.items()}
    monkeypatch.setattr(commands, "experiment_names", lambda: list(modules))
    monkeypatch.setattr(commands, "experiment", modules.__getitem__)
    assert "..." not in call("--help").output.partition("Commands:")[2]  # each command in a line of 80
    lines = [line.split() for line in call("list").output.splitlines()]
    order = [lines.index(words.split()) for words in ("Why?", "a A = 1", "c C = 3", "How?", "b B = 2")]
    assert order == sorted(order)
    assert json.loads(call("list", "--json").stdout)[1] == {"sim": "b", "question": "How?"}


@pytest.mark.slow
def test_list_loads_no_compiler_and_no_plotting():
    code = (
        "import sys\nfrom transport.cli.commands import app\napp(['list'], standalone_mode=False)\n"
        "heavy = {'numba', 'scipy', 'matplotlib', 'pyvista', 'xarray'} & set(sys.modules)\nassert not heavy, heavy"
    )
    python("-c", code)


@pytest.mark.parametrize("options", [(), ("--quick", "--json"), ("--effects", "--repeats", "7")])
def test_bench_prints_where_the_benchmarks_are(call, options):
    answer = call("bench", *options)
    assert answer.exit_code == 0 and "python -m tests.bench" in answer.output


@pytest.mark.slow
def test_interruption_prints_the_batches_done_as_incomplete_with_status_130(call, press_ctrl_c):
    call("run", "disk.py", "--no-picture")  # so that nothing is left to compile
    press_ctrl_c(after=1.0)
    answer = call("run", "endless.py", "--seconds", "60", "--estimator", "analog")
    assert answer.exit_code == 130
    assert "verdict     incomplete: interrupted" in answer.output and "irradiance" in answer.output


def test_interruption_before_the_first_batch_has_status_130(call, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("transport.verification.experiment.simulate_all_quantities", interrupted)
    answer = call("run", "disk.py")
    assert answer.exit_code == 130 and len(answer.output.splitlines()) == 1


# Width: COLUMNS if set, and never so narrow that a word or number is cut

CELLS = (
    "a room that is described in more words than eighty columns hold",
    "(2.9985 ± 0.0009)e+21",
    "s^-1 m^-2 sr^-1",
    "holds",
)


@pytest.fixture
def written(capsys, monkeypatch):
    """Lines of a table and of a text in a pipe, with these variables of the environment."""

    def write(**environment):
        for name in ("COLUMNS", "TERM", "FORCE_COLOR", "NO_COLOR"):
            monkeypatch.delenv(name, raising=False)
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        print_rich(table_of(("quantity~", "estimate ± error>", "unit", ""), [CELLS]))
        rows = capsys.readouterr().out.splitlines()
        print_labelled("note", "word " * 40)
        return rows, capsys.readouterr().out.splitlines()

    return write


@pytest.mark.parametrize("terminal", [{}, {"TERM": "dumb", "FORCE_COLOR": "1"}], ids=["plain", "dumb"])
def test_a_pipe_is_as_wide_as_the_table_needs(written, terminal):
    rows, _ = written(**terminal)
    assert len(rows) == 3 and all(cell in rows[2] for cell in CELLS)


def test_words_fold_at_columns(written):
    rows, text = written(COLUMNS="60")
    assert max(map(len, rows)) <= 60 and len(rows) > 3 and max(map(len, text)) <= 60
    assert max(map(len, written(COLUMNS="100")[1])) > 60


@pytest.mark.parametrize("columns", ["20", "1", "0"])
def test_a_table_that_does_not_fit_is_not_cut(written, columns):
    rows, _ = written(COLUMNS=columns)
    assert all(cell in rows[2] for cell in CELLS[1:])
    assert {word for row in rows[2:] for word in row.split()} >= {*CELLS[0].split()}


# Help: every command has examples, and every example is a valid command

HELP = dict(command_pages(typer.main.get_command(commands.app)))
READ = {
    "particles": lambda text: whole_number("--particles", text),
    "seconds": lambda text: number("--seconds", text),
    "error": named_errors,
    "tracking": parse_tracking,
    "estimator": lambda word: (*ESTIMATORS, "auto").index(word),
    "sampling": SAMPLINGS.index,
}


def examples():
    blocks = (text.partition("Examples:")[2].partition("\n\n")[0] for text in HELP.values())
    return [line.strip() for block in blocks for line in block.splitlines() if line.strip()]


def parsed(command):
    """The values of a command's parameters, each read as the command would read it."""
    words = shlex.split(command)
    assert words[0] == "transport"
    group = typer.main.get_command(commands.app)
    parent = group.make_context("transport", [], resilient_parsing=True)
    name, *arguments = [word for word in words[1:] if word != "--debug"]
    values = group.commands[name].make_context(name, arguments, parent=parent, resilient_parsing=False).params
    for key, read in READ.items():
        if values.get(key) is not None:
            read(values[key])
    for each in values.get("sims") or [values.get("sim")]:
        if values.get("hard"):
            assert each is None or each in families()
        elif each and not each.endswith((".py", ".json")):
            module = experiment(each)  # it exists, and its scene takes the settings
            if values.get("set_"):
                module.scene(**named_values(values["set_"]))
    return values


def test_every_command_has_examples():
    for name, text in HELP.items():
        assert re.search(rf"^\s+Examples:\n\s+transport {name}", text, re.M), name
    assert len(examples()) >= 2 * len(HELP)


@pytest.mark.quick_cases("transport run sun", "transport run mine.py --seconds 10 --json")
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
