"""Cases of which the default suite runs a few."""

from collections.abc import Iterable
from typing import Any

import pytest

SLOW = pytest.mark.slow


def quick(cases: Iterable[Any], *chosen: Any) -> list[Any]:
    """Parameters of a test, all but the chosen ones marked slow."""
    return [pytest.param(case, marks=() if case in chosen else SLOW) for case in cases]
