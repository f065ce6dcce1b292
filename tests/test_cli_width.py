"""Width of the output: COLUMNS if set, and never so narrow that a word or number is cut."""

import pytest

from transport.cli.output import print_labelled, print_rich, table_of

CELLS = (
    "a room that is told of in more words than eighty columns hold",
    "(2.9985 ± 0.0009)e+21",
    "s^-1 m^-2 sr^-1",
    "holds",
)


@pytest.fixture
def written(capsys, monkeypatch):
    """What a table and a text come to in a pipe, line by line, with these variables of the environment."""

    def write(**environment):
        for name in ("COLUMNS", "TERM", "FORCE_COLOR", "NO_COLOR"):
            monkeypatch.delenv(name, raising=False)
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        table = table_of(("quantity~", "estimate ± error>", "unit", ""), ())
        table.add_row(*CELLS)
        print_rich(table)
        rows = capsys.readouterr().out.splitlines()
        print_labelled("note", "word " * 40)
        return rows, capsys.readouterr().out.splitlines()

    return write


@pytest.mark.parametrize("terminal", [{}, {"TERM": "dumb", "FORCE_COLOR": "1"}], ids=["plain", "dumb"])
def test_a_pipe_is_as_wide_as_the_table_needs(written, terminal):
    rows, _ = written(**terminal)
    assert len(rows) == 3 and all(cell in rows[2] for cell in CELLS)


def test_columns_is_obeyed_and_words_fold(written):
    rows, text = written(COLUMNS="60")
    assert max(map(len, rows)) <= 60 and len(rows) > 3 and max(map(len, text)) <= 60
    assert max(map(len, written(COLUMNS="100")[1])) > 60


@pytest.mark.parametrize("columns", ["20", "1", "0"])
def test_what_does_not_fit_is_not_cut(written, columns):
    rows, _ = written(COLUMNS=columns)
    assert CELLS[1] in rows[2] and CELLS[2] in rows[2] and CELLS[3] in rows[2]
    assert {word for row in rows[2:] for word in row.split()} >= {*CELLS[0].split()}
