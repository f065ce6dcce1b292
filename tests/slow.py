"""Tables of cases of which only some run in the default suite."""

from collections.abc import Callable, Iterable

import pytest

SLOW = pytest.mark.slow


def slow_but(is_quick: Callable[..., bool], cases: Iterable) -> list:
    """The cases for parametrize: all but the quick ones, which every run has, are marked slow."""
    rows = (case if isinstance(case, tuple) else (case,) for case in cases)
    return [pytest.param(*row, marks=() if is_quick(*row) else SLOW) for row in rows]
