"""The README's first experiment, run as it stands, prints what the README says."""

import contextlib
import io
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_the_readmes_first_experiment_is_short_and_prints_what_it_says():
    blocks = (ROOT / "README.md").read_text(encoding="utf-8").split("```")
    place = next(i for i, block in enumerate(blocks) if block.startswith("python\n"))
    code, said = blocks[place].removeprefix("python\n"), blocks[place + 2].removeprefix("text\n")
    assert len([line for line in code.splitlines() if line.strip()]) <= 12
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, "README.md", "exec"), {})
    assert _without_times(printed.getvalue()) == _without_times(said)


def _without_times(text):
    return [
        line.rstrip() for line in text.strip().splitlines() if not line.startswith(("cost:", "next digit:"))
    ]
