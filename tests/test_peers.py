"""The comparison with other programs: its exact values agree with runs of this one, its own methods with each other."""

import pytest

from tests.bench.peers import PROBLEMS

OWN = [
    (name, number)
    for name, problem in PROBLEMS.items()
    for number, method in enumerate(problem.methods)
    if method.package == "transport"
]


@pytest.mark.parametrize(("name", "number"), OWN)
def test_exact_values_of_the_comparison_are_those_of_runs(name, number):
    problem = PROBLEMS[name]
    method = problem.methods[number]
    value, error, _ = method.prepare(count=method.count)(1)
    assert 0 < error < 2e-3 * value
    assert abs(value - problem.exact()) < 4 * error
