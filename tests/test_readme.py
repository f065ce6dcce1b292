"""The README's experiments, run as they stand, print what the README says."""

import contextlib
import io
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_the_readmes_experiments_print_what_it_says():
    """Each block of Python is followed by what it prints; the first is a whole experiment in a dozen lines."""
    blocks = (ROOT / "README.md").read_text(encoding="utf-8").split("```")
    places = [i for i, block in enumerate(blocks) if block.startswith("python\n")]
    assert len(places) == 5
    first = blocks[places[0]].removeprefix("python\n")
    assert len([line for line in first.splitlines() if line.strip()]) <= 12
    for place in places:
        code, said = blocks[place].removeprefix("python\n"), blocks[place + 2].removeprefix("text\n")
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, "README.md", "exec"), {})
        assert _without_times(printed.getvalue()) == _without_times(said)


def _without_times(text):
    return [
        line.rstrip()
        for line in text.strip().splitlines()
        if not line.strip().startswith(("cost:", "next digit:", "price of"))
    ]
