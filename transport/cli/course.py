"""The course: its table in the terminal, as JSON, and as the page `guides/course.md`.

`python -m transport.cli.course` runs the experiments of the course with their own numbers of particles and
writes the page and its pictures; with names of experiments it renews these alone.
"""

import re
import sys
from collections.abc import Iterable, Mapping
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory

from transport.cli.output import print_labelled, print_rich
from transport.validation import SceneError
from transport.verification.course import PLANNED, SOURCES, STATES, Numbered, Statement, counts, numbered
from transport.verification.experiment import Outcome, experiment, run_experiment

PAGE = Path(__file__).resolve().parents[1] / "guides" / "course.md"
PICTURES = "../../viz/gallery/course"  # from the page
WIDTH, COLOURS = 1200, 56  # pixels and colours of a picture on the page
Key = tuple[str, str]  # experiment with case, and row, as the page writes them
Numbers = Mapping[Key, tuple[str, str]]  # estimate and exact value as text
NOT_RUN = "not run yet", "unknown"

INTRODUCTION = """\
# The course

Statements of four introductions to radiometry, in their order, each with the experiment that shows it, the
measured row beside its exact value, and the picture to project. Estimates have one standard error; the exact
value of a row is that of its own bin or element.

{counts}

| | source |
|---|---|
{sources}

`transport list --course` prints this table, with `--json` for programs. A command below a picture draws it
into `out/`. This page is written by `python -m transport.cli.course`: its numbers are of the experiments' own
numbers of particles and seed 0, its pictures have fewer pixels and colours.
"""


def print_course() -> None:
    """Print the statements by chapter, each with its command, row and picture."""
    numbers = numbers_of(PAGE.read_text(encoding="utf-8"))
    for chapter, entries in groupby(numbered(), key=lambda entry: entry.chapter):
        print_rich(chapter, style="bold")
        for entry in entries:
            print_labelled(f"  {entry.label:4}", statement_text(entry.statement), style="cyan")
            print_labelled(" " * 6, _where_shown(entry, numbers))
    print_rich(_counts_text())


def course_record() -> list[dict[str, object]]:
    """Return the statements as JSON-ready types; estimate and exact value are those of the page."""
    numbers = numbers_of(PAGE.read_text(encoding="utf-8"))
    return [
        {
            "label": entry.label,
            "chapter": entry.chapter,
            "topic": entry.topic,
            "statement": entry.statement.text,
            "formula": entry.statement.formula,
            "source": entry.statement.source,
            "state": entry.statement.state,
            "refuted": entry.statement.is_refuted,
            "remark": entry.statement.remark,
            "sim": entry.statement.sim,
            "case": entry.statement.case,
            "row": entry.statement.row,
            "estimate": numbers.get(key_of(entry.statement), NOT_RUN)[0] if entry.statement.row else "",
            "exact": numbers.get(key_of(entry.statement), NOT_RUN)[1] if entry.statement.row else "",
            "picture": entry.statement.picture,
            "command": _command(entry.statement),
            "lacks": entry.statement.missing or PLANNED.get(entry.statement.planned, ""),
        }
        for entry in numbered()
    ]


def page_text(numbers: Numbers) -> str:
    """Return the page with these numbers.  Raises SceneError if one is missing."""
    sources = "\n".join(f"| {letter} | {title} |" for letter, title in SOURCES.items())
    parts = [INTRODUCTION.format(counts=_counts_text(), sources=sources)]
    for chapter, entries in groupby(numbered(), key=lambda entry: entry.chapter):
        parts.append(f"## {chapter}\n")
        for number, topic in groupby(entries, key=lambda entry: entry.number):
            parts += _topic_text(number, list(topic), numbers)
    return "\n".join(parts).rstrip() + "\n"


def numbers_of(page: str) -> dict[Key, tuple[str, str]]:
    """Read estimates and exact values back from the text of a page."""
    rows = re.findall(r"^\| \d+[a-z]? \| (.+) \| (.+) \| (.+) \| (.+) \|$", page, re.M)
    return {(case, row): (estimate, exact) for case, row, estimate, exact in rows}


def key_of(statement: Statement) -> Key:
    """Return experiment with case, and row, by which a page's numbers are found."""
    return f"`{statement.sim}` {_case_text(statement)}".rstrip(), statement.row


def measured(sim: str, outcomes: Iterable[Outcome]) -> dict[Key, tuple[str, str]]:
    """Return estimate and exact value as text of one experiment's statements."""
    found = {}
    known = list(outcomes)
    for entry in entries_of(sim):
        outcome = next(each for each in known if each.parameters == entry.statement.case)
        row = outcome[entry.statement.row]
        found[key_of(entry.statement)] = str(row.estimate), f"{row.exact:.7g}"
    return found


def entries_of(sim: str) -> list[Numbered]:
    """Return the statements that an experiment measures."""
    return [entry for entry in numbered() if entry.statement.sim == sim]


def sims_of_course() -> list[str]:
    """Names of the experiments of the course, in its order."""
    return list(dict.fromkeys(entry.statement.sim for entry in numbered() if entry.statement.sim))


def statement_text(statement: Statement) -> str:
    """Return statement, formula and source in one line."""
    formula = f": {statement.formula}" if statement.formula else ""
    return f"{statement.text}{formula} ({statement.source})"


def write_course(sims: Iterable[str]) -> None:
    """Run these experiments, and write their numbers and pictures into page and folder.

    Raises SceneError before any run where the page lacks numbers of other experiments.
    """
    from transport.cli.docs import package_folder

    folder, sims = package_folder("viz", "gallery") / "course", list(sims)
    folder.mkdir(exist_ok=True)
    numbers = numbers_of(PAGE.read_text(encoding="utf-8")) if PAGE.is_file() else {}
    page_text(numbers | {key_of(each.statement): NOT_RUN for sim in sims for each in entries_of(sim)})
    for sim in sims:
        module = experiment(sim)
        outcomes = run_experiment(module, seed=0)
        numbers |= measured(sim, outcomes)
        wanted = {entry.statement.picture for entry in entries_of(sim)} - {""}
        with TemporaryDirectory() as drawn:
            paths = module.draw(outcomes, Path(drawn) / f"{sim}.png")
            for path in paths:
                if path.name in wanted:
                    reduce_picture(path, folder / path.name)
        print_rich(f"{sim}: {len(entries_of(sim))} statements, {len(wanted)} pictures")
    used = {entry.statement.picture for entry in numbered()}
    for path in folder.glob("*.png"):
        if path.name not in used:
            path.unlink()
    PAGE.write_text(page_text(numbers), encoding="utf-8")


def reduce_picture(source: Path, destination: Path) -> None:
    """Write a picture with fewer pixels and colours, a tenth of its bytes."""
    from PIL import Image

    with Image.open(source) as picture:
        size = WIDTH, round(picture.height * WIDTH / picture.width)
        small = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)
    small.quantize(COLOURS, kmeans=2, dither=Image.Dither.NONE).save(destination, optimize=True)


# ---- Parts of the page and of the listing.


def _counts_text() -> str:
    found = counts()
    by_state = ", ".join(f"{found[state]} {state}" for state in STATES)
    return f"{found['topics']} topics with {found['statements']} statements: {by_state}."


def _topic_text(number: int, entries: list[Numbered], numbers: Numbers) -> list[str]:
    """Heading, statements, table of rows, pictures with their commands."""
    lines = [f"### {number}. {entries[0].topic}\n"]
    for entry in entries:
        lines.append(f"**{entry.label}** {_paragraph(entry.statement)}\n")
    rows = [entry for entry in entries if entry.statement.row]
    if rows:
        lines += ["| | experiment and case | row | estimate | exact |", "|---|---|---|---|---|"]
        for entry in rows:
            key = key_of(entry.statement)
            if key not in numbers:
                cure = f"python -m transport.cli.course {entry.statement.sim}"
                raise SceneError(f"course: statement {entry.label} has no numbers; run {cure}")
            lines.append(f"| {' | '.join((entry.label, *key, *numbers[key]))} |")
        lines.append("")
    pictures = {entry.statement.picture: entry for entry in rows if entry.statement.picture}
    for picture, entry in pictures.items():
        lines += [f"![{entry.topic}: {picture}]({PICTURES}/{picture})\n"]
        lines += [f"`{_command(entry.statement)}` draws `{picture}`.\n"]
    return lines


def _paragraph(statement: Statement) -> str:
    formula = f": `{statement.formula}`" if statement.formula else ""
    sentences = [f"{statement.text}{formula} ({statement.source})."]
    if statement.is_refuted:
        sentences.append("*Refuted.*")
    if statement.remark:
        sentences.append(statement.remark)
    if statement.missing:
        sentences.append(f"*Not yet shown: {statement.missing}.*")
    if statement.planned:
        sentences.append(f"*Planned: {PLANNED[statement.planned]}.*")
    return " ".join(sentences)


def _where_shown(entry: Numbered, numbers: Numbers) -> str:
    """Return command, row, numbers and picture in one line, or the reason why there are none."""
    statement, parts = entry.statement, []
    if statement.row:
        estimate, exact = numbers.get(key_of(statement), NOT_RUN)
        parts = [_command(statement), f"{statement.row}: {estimate}, exact {exact}", statement.picture]
    if statement.is_refuted:
        parts.append("refuted")
    if statement.missing:
        parts.append(f"not yet: {statement.missing}")
    if statement.planned:
        parts.append(f"planned: {PLANNED[statement.planned]}")
    return "; ".join(part for part in parts if part)


def _command(statement: Statement) -> str:
    """Return the command that draws the picture and prints the row, among others."""
    return f"transport run {statement.sim}" if statement.sim else ""


def _case_text(statement: Statement) -> str:
    """Return the parameters of the case in one line."""
    return ", ".join(
        f"{name}={value:.6g}" if isinstance(value, float) else f"{name}={value}"
        for name, value in statement.case.items()
    )


if __name__ == "__main__":
    write_course(sys.argv[1:] or sims_of_course())
