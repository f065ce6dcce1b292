"""What several test files are given."""

import gc
from importlib.util import find_spec
from pathlib import Path

import pytest
from hypothesis import settings

from tests.own_experiments import CASES, EXPERIMENT, PI_FORGOTTEN, PICTURE, UNLIKE_UNITS
from tests.processes import ROOT, pressing_ctrl_c

# Files that take longest: they begin first, so that the workers end together.
LONGEST = ("test_machine_code.py", "test_reproducible.py", "test_sims.py", "test_fuzz.py")


settings.register_profile("suite", derandomize=True, deadline=None)
settings.load_profile("suite")

APPROX = pytest.approx


def approx(expected, rel=None, abs=None, nan_ok=False):
    """pytest.approx without the absolute tolerance of 1e-12 that it adds to a relative one: what is tiny must agree as well."""
    return APPROX(expected, rel, 0.0 if rel is not None and abs is None else abs, nan_ok)


pytest.approx = approx


def pytest_configure(config):
    place = {
        Path(find_spec(name).origin).parents[1]
        for name in ("transport.sims", "transport.viz")
        if find_spec(name)
    }
    if place not in ({ROOT}, {ROOT / "transport"}):
        raise pytest.UsageError("transport.sims is not of this clone: pip install -e '.[test]' in it")
    gc.set_threshold(
        100_000, 50, 100
    )  # by the usual 700 charts and theory take 8 % longer, among so many modules
    if hasattr(config.option, "loadscopereorder"):  # of pytest-xdist: by the number of tests in a file
        config.option.loadscopereorder = False


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Order the files, and mark as slow the cases that a test's `quick_cases` does not name."""
    missing = set()
    for item in items:
        if quick := item.get_closest_marker("quick_cases"):
            if not hasattr(item, "callspec"):
                raise pytest.UsageError(f"{item.nodeid} has quick_cases but no cases")
            missing |= {f"{item.nodeid.partition('[')[0]}[{name}]" for name in quick.args}
            if item.callspec.id not in quick.args:
                item.add_marker(pytest.mark.slow)
    missing -= {item.nodeid for item in items}
    if missing and runs_all(config):  # a misspelt name would leave the test to the slow ones
        raise pytest.UsageError(f"quick_cases names cases that are not there: {', '.join(sorted(missing))}")
    places = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: places.get(item.path.name, len(LONGEST)))


def runs_all(config):
    """Whether no file was named, here or to the process that started this worker."""
    given = getattr(config, "workerinput", None)
    return given["runs_all"] if given else config.args_source is pytest.Config.ArgsSource.TESTPATHS


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node):
    """Tell a worker whether the whole suite is run."""
    node.workerinput["runs_all"] = runs_all(node.config)


def pytest_sessionstart(session):
    """Compile all passes before the tests of a whole run, each worker its share: else several would compile the same."""
    given = getattr(session.config, "workerinput", None)
    if given and given["runs_all"]:
        from transport.engine.registry import PASSES

        rank = int(given["workerid"].removeprefix("gw"))
        for name in list(PASSES)[rank :: given["workercount"]]:
            PASSES[name].entry  # noqa: B018


@pytest.fixture
def press_ctrl_c():
    """A function that presses Ctrl-C, now or after=seconds."""
    with pressing_ctrl_c() as press:
        yield press


@pytest.fixture
def small_groups(monkeypatch):
    """Of a cluster: so that many are out when something happens."""
    monkeypatch.setattr("transport.run.dask.executor.GROUP_SECONDS", 0.01)


@pytest.fixture
def call(tmp_path, monkeypatch):
    """Call the command line in a folder of its own, with experiment files written there: call("run", "disk.py")."""
    from typer.testing import CliRunner

    from transport.cli import commands

    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("COLUMNS", raising=False)  # which readline sets for the suite's workers
    for name, more in {
        "disk": PICTURE,
        "disks": CASES + PICTURE,
        "unlike": UNLIKE_UNITS,
        "wrong": PI_FORGOTTEN,
        "endless": "\nparticles = 10**11\n",
    }.items():
        Path(f"{name}.py").write_text(EXPERIMENT + more, encoding="utf-8")
    return lambda *arguments: CliRunner().invoke(commands.app, list(map(str, arguments)))
