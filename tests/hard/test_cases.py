"""Every hard case agrees with its exact value, and breaks the formula that it names."""

import pytest

from transport.verification.hard.cases import FALSE_ALARM, cases_of

CASES = {f"{case.family}: {case.title}": case for case in cases_of()}


@pytest.mark.parametrize("title", CASES)
def test_it_is_right_where_the_naive_way_is_not(title):
    seen = CASES[title].run()
    rate = FALSE_ALARM / len(CASES)
    assert seen.holds(rate), f"{seen.value} for {seen.exact}, off by {seen.off}"
    assert seen.naive_fails, f"the naive way gives {seen.naive} for {seen.exact}"
    assert CASES[title].reason and CASES[title].naive
