"""Cases of a table of which only a few are in the default suite."""

from collections.abc import Iterable

import pytest


def mostly_slow(cases: Iterable, quick: Iterable) -> list:
    """All cases for `parametrize`, marked slow but for the quick ones."""
    return [case if case in quick else pytest.param(case, marks=pytest.mark.slow) for case in cases]
