"""Tables of cases of which only some run in the default suite."""

from collections.abc import Callable, Iterable
from typing import Any

import pytest

SLOW = pytest.mark.slow


def quick(cases: Iterable[Any], *chosen: Any) -> list[Any]:
    """The cases for parametrize: all but the chosen ones are marked slow."""
    return [pytest.param(case, marks=() if case in chosen else SLOW) for case in cases]


def slow_but(is_quick: Callable[..., bool], cases: Iterable[Any]) -> list[Any]:
    """The cases for parametrize, values or rows of values: all but those for which `is_quick(*row)` are marked slow."""
    rows = (case if isinstance(case, tuple) else (case,) for case in cases)
    return [pytest.param(*row, marks=() if is_quick(*row) else SLOW) for row in rows]
