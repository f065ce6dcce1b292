"""The course: every statement has a case, a row and a picture that exist; page, numbers and listing are in step with the table."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

import transport as tp
from tests.experiments.test_sims import FIGURES
from transport.cli.course import (
    PAGE,
    entries_of,
    key_of,
    measured,
    numbers_of,
    page_text,
    reduce_picture,
    sims_of_course,
)
from transport.verification.course import COURSE, PLANNED, Statement, counts, numbered
from transport.verification.experiment import cases_of, experiment, experiment_names, run_experiment

PICTURES = Path(__file__).resolve().parents[1] / "viz" / "gallery" / "course"
MOST_BYTES = 3_000_000  # of all pictures of the course in the repository
ENTRIES = list(numbered())


def missing_parts(statement):
    """Names of what a statement points to that does not exist: experiment, case, row, picture and its file."""
    if not statement.row:
        return []
    if statement.sim not in experiment_names():
        return ["sim"]
    module = experiment(statement.sim)
    if statement.case not in cases_of(module, {}):
        return ["case"]
    drawn = {f"{statement.sim}{word}.png" for word in FIGURES.get(statement.sim, ("",))}
    parts = {
        "row": statement.row in module.exact(**statement.case),
        "picture": statement.picture in drawn or not statement.picture,
        "file": (PICTURES / statement.picture).exists(),
    }
    return [name for name, exists in parts.items() if not exists]


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.label)
def test_a_statement_has_a_case_a_row_and_a_picture_that_exist(entry):
    assert missing_parts(entry.statement) == []


@pytest.mark.parametrize(("part", "wrong"), [
    ("sim", "lambert_disc"), ("case", {"distance": 21.0}), ("row", "radiance in the disc"),
    ("picture", "lambert_disk_turn.png"), ("picture", "flows.png"),
])  # fmt: skip
def test_a_wrong_name_is_found(part, wrong):
    [right] = [e.statement for e in entries_of("lambert_disk") if e.statement.picture == "lambert_disk.png"]
    assert missing_parts(right) == []
    assert part in missing_parts(replace(right, **{part: wrong}))


def test_the_course_has_all_topics_in_order_and_plans_only_what_the_library_cannot_do():
    assert list(COURSE) == ["Particles", "Angles", "Quantities", "Laws", "Fields", "Eye"]
    found = counts()
    assert found["topics"] == 66 and len({entry.label for entry in ENTRIES}) == found["statements"]
    assert found["shown"] + found["not yet"] + found["planned"] == found["statements"]
    planned = {entry.statement.planned for entry in ENTRIES} - {""}
    assert planned == set(PLANNED) == {"mirages", "wavelength", "photometry", "polarisation"}


@pytest.mark.parametrize(("change", "words"), [
    ({"picture": ""}, "must have sim, row and picture"), ({"missing": "a picture"}, "must have sim, row and"),
    ({"picture": "", "planned": "magic"}, "planned must be one of mirages"), ({"source": "X 3"}, "source must begin"),
])  # fmt: skip
def test_a_statement_is_refused(change, words):
    whole = Statement("Light is fast", "c", "H Title", "sun", {}, "radiance", "sun.png")
    with pytest.raises(tp.SceneError, match=words):
        replace(whole, **change)


def test_the_page_is_the_table_with_the_numbers_that_it_has():
    page = PAGE.read_text(encoding="utf-8")
    numbers = numbers_of(page)
    assert set(numbers) == {key_of(entry.statement) for entry in ENTRIES if entry.statement.row}
    assert page == page_text(numbers), "run python -m transport.cli.course"


def test_a_statement_that_has_not_been_run_is_named():
    numbers = numbers_of(PAGE.read_text(encoding="utf-8"))
    del numbers["`furnace`", "χ² of all bins / expectation"]
    with pytest.raises(
        tp.SceneError, match=r"statement 48 has no numbers; run .* transport\.cli\.course furnace"
    ):
        page_text(numbers)


def test_every_number_of_the_page_agrees_with_the_exact_value():
    """Within six standard errors; an estimate without an error is the exact value."""
    for key, (estimate, exact) in numbers_of(PAGE.read_text(encoding="utf-8")).items():
        found = re.match(r"\(?(-?[\d.]+)(?: ± ([\d.]+)\))?(e[+-]\d+)?", estimate)
        value, error = (float(f"{part or 0}{found[3] or ''}") for part in found.group(1, 2))
        assert abs(value - float(exact)) <= 6 * error + 1e-6 * abs(float(exact)), key


@pytest.mark.slow
@pytest.mark.parametrize("sim", sims_of_course())
def test_the_numbers_of_the_page_come_out(sim):
    """With the experiment's own number of particles: the same digits."""
    page = numbers_of(PAGE.read_text(encoding="utf-8"))
    found = measured(sim, run_experiment(experiment(sim), seed=0, threads=2))
    assert found and found == {key: page[key] for key in found}


def test_the_pictures_are_few_and_small():
    used = {entry.statement.picture for entry in ENTRIES} - {""}
    assert {path.name for path in PICTURES.iterdir()} == used
    assert sum(path.stat().st_size for path in PICTURES.iterdir()) < MOST_BYTES
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in PICTURES.iterdir())


def test_a_picture_is_reduced(tmp_path):
    image = pytest.importorskip("PIL.Image")
    image.radial_gradient("L").resize((2400, 1000)).convert("RGB").save(tmp_path / "large.png")
    reduce_picture(tmp_path / "large.png", tmp_path / "small.png")
    small = image.open(tmp_path / "small.png")
    assert small.size == (1200, 500) and small.mode == "P" and len(small.getcolors()) <= 80


def test_the_list_of_the_course_fits_a_terminal_and_names_all(call):
    answer = call("list", "--course")
    assert answer.exit_code == 0, answer.output
    lines = answer.output.splitlines()
    assert max(map(len, lines)) <= 110
    assert [line.split()[0] for line in lines if re.match(r"  \d", line)] == [e.label for e in ENTRIES]
    assert "transport run flows; histories that differ: 0 (exact), exact 0; flows_space.png" in answer.output


def test_the_list_of_the_course_as_json(call):
    answer = call("list", "--course", "--json")
    record = json.loads(answer.stdout)
    assert [each["label"] for each in record] == [entry.label for entry in ENTRIES]
    [face] = [each for each in record if "dodecahedron" in each["statement"]]
    assert face["state"] == "shown" and face["refuted"] and face["case"] == {"subject": "dodecahedron"}
    assert face["exact"] == "1.047198" and face["command"] == "transport run directions"
    [mirage] = [each for each in record if each["topic"] == "Mirages"]
    assert mirage["state"] == "planned" and mirage["lacks"] == "rays are straight" and mirage["row"] == ""
