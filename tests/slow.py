"""Tables of cases of which only some run in the default suite."""

from collections.abc import Iterable
from typing import Any

import pytest


def quick(cases: Iterable[Any], *chosen: Any) -> list[Any]:
    """Plain values for parametrize: all but the chosen ones are marked slow.  Raises ValueError for a choice that is no case.

    Where several parametrize stand on one test, `quick_cases` (conftest.py) names the quick ones by their ids.
    """
    cases = list(cases)
    if missing := [case for case in chosen if case not in cases]:
        raise ValueError(f"quick: {missing} are no cases of {cases}")
    return [pytest.param(case, marks=() if case in chosen else pytest.mark.slow) for case in cases]
