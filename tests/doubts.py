"""What a result doubts, for tests."""

from __future__ import annotations

from transport.statistics.findings import DOUBTFUL, NOTE


def doubts(result, name: str) -> list[str]:
    """The doubts about a detector, and why it counted nothing."""
    about = [each for each in result.findings if repr(name) in each.object]
    return [
        str(each) if each.severity == DOUBTFUL else each.what
        for each in about
        if each.severity in (DOUBTFUL, NOTE)
    ]


def doubt(result, name: str) -> str | None:
    """The same as one text; None where there are none."""
    return "; ".join(doubts(result, name)) or None
