"""The tutorial runs as it is stored: the same numbers, all of them right, and without a screen as well."""

import ast
import copy
import importlib
import json
import re
import tomllib

import nbformat
import pytest
from scipy.special import ndtri

from tests.notebooks import executed, paths, text_of

TUTORIAL = next(path for path in paths() if path.stem == "photons_to_pictures")
FALSE_ALARM = 1e-4  # of all comparisons together
NO_SCREEN = "from transport.viz import screen; screen._lack = lambda: screen.NO_LIBRARIES"
COMPARED = "import json; print(json.dumps(compared))"


@pytest.fixture(scope="module")
def stored():
    return nbformat.read(TUTORIAL, as_version=4)


def code_cells(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def limit(comparisons):
    """Standard errors that one of so many right comparisons passes with the chance FALSE_ALARM."""
    return -ndtri(FALSE_ALARM / 2 / comparisons)


@pytest.mark.slow
def test_it_shows_what_is_stored_and_its_estimates_agree_with_the_exact_values(stored):
    """Cells show the same wherever they run, but for timings and screens; comparisons are judged together, by Bonferroni."""
    done = executed(stored, COMPARED)
    scores = [z for _, z in json.loads(text_of(done.cells.pop()))]
    for before, after in zip(code_cells(stored), code_cells(done), strict=True):
        assert before.source == after.source
        if not {"timings", "screen"} & set(before.metadata.get("tags", [])):
            assert text_of(after) == text_of(before), "python -m tests.notebooks stores what it shows now"
            kinds = [[sorted(o.data) for o in cell.outputs if "data" in o] for cell in (before, after)]
            assert kinds[0] == kinds[1]
    assert len(scores) > 20
    assert max(map(abs, scores)) < limit(len(scores)) < 6
    said = re.search(r"(\d+) comparisons; the worst is ([+-][\d.]+)", text_of(code_cells(done)[-1]))
    assert (int(said[1]), float(said[2])) == (len(scores), round(max(scores, key=abs), 1))


@pytest.mark.slow
def test_a_wrong_law_in_it_is_seen_and_without_a_screen_a_sentence_says_what_to_install(stored):
    """The gas of which, by a wrong law, n v/2 would cross one way; and the scene in space where nothing can be drawn."""
    first, *others = copy.deepcopy(code_cells(stored))
    (gas,) = (cell for cell in others if "n, v = 1e13" in cell.source)
    gas.source = gas.source.replace("n * v / 4)", "n * v / 2)").replace("2_000_000", "20_000")
    (space,) = (cell for cell in others if "screen" in cell.metadata.get("tags", []))
    space.source = space.source.replace("1_000_000", "1_000")
    few = nbformat.v4.new_notebook(cells=[first, gas], metadata=stored.metadata)
    *_, drawn, compared = executed(few, NO_SCREEN, space.source, COMPARED).cells
    assert max(abs(z) for _, z in json.loads(text_of(compared))) > limit(20)
    assert "libegl1 libgl1-mesa-dri" in text_of(drawn)


def test_it_is_stored_with_outputs_and_without_what_differs_from_run_to_run(stored):
    nbformat.validate(stored)
    cells = code_cells(stored)
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    assert sum(bool(cell.outputs) for cell in cells) >= len(cells) - 1
    assert all(set(cell.metadata) <= {"tags"} for cell in stored.cells)
    assert all(output.get("name") != "stderr" for cell in cells for output in cell.outputs)
    assert not re.search(r"/(home|root|tmp|work)/", TUTORIAL.read_text(encoding="utf-8"))
    assert TUTORIAL.stat().st_size < 2e6
    for cell in cells:  # short ones
        ast.parse(cell.source)
        assert len(cell.source.splitlines()) <= 32
        assert all(len(line) <= 120 for line in cell.source.splitlines())
        assert len(text_of(cell).splitlines()) <= 20


def test_what_it_imports_exists(stored):
    """So that a renamed function is seen without running it."""
    tree = ast.parse("\n".join(cell.source for cell in code_cells(stored)))
    imports = [
        node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and "transport" in node.module
    ]
    assert len(imports) > 1
    for node in imports:
        module = importlib.import_module(node.module)
        assert all(hasattr(module, alias.name) for alias in node.names)


def test_it_comes_with_the_package():
    """Among the package's data; what it needs is in two extras."""
    project = tomllib.loads((TUTORIAL.parents[2] / "pyproject.toml").read_text(encoding="utf-8"))
    assert "notebooks/*.ipynb" in project["tool"]["setuptools"]["package-data"]["transport.sims"]
    assert TUTORIAL.parent.name == "notebooks"
    for extra in ("notebook", "test"):
        packages = project["project"]["optional-dependencies"][extra]
        assert {"nbclient", "ipykernel"} <= {re.match(r"[\w-]+", each)[0] for each in packages}
