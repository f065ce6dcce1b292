"""Error bars of the ways to estimate are right: over 2000 seeds z follows Student's t of batches - 1.

One way of each kind; all ways on all cost scenes: `python -m tests.bench.error_bars` (its results are in the guide on cost).
"""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest

from tests.agreement import assert_z_spread
from tests.bench.error_bars import Way, scores
from transport.compile.methods import Method

WAYS = (
    Way("cost_disks", 0, "flux", Method("aimed", "sobol")),
    Way("cost_disks", 0, "flux", Method("expected", "stratified")),
    Way("cost_enclosure", 0, "irradiance", Method("expected", "sobol")),
    Way("cost_enclosure", 0, "irradiance", Method("backward")),
)
FALSE_ALARM = 1e-3 / len(WAYS)


@pytest.fixture(scope="module")
def found():
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        return dict(zip(WAYS, pool.map(scores, WAYS), strict=True))


@pytest.mark.parametrize("way", WAYS, ids=str)
def test_scores_over_seeds_follow_students_t(way, found):
    assert_z_spread(*found[way], FALSE_ALARM)


@pytest.mark.parametrize("factor", [1.1, 1 / 1.1])
def test_error_bars_that_are_ten_percent_wrong_are_rejected(factor, found):
    """Each with a probability of 90 %, so at least two of the four in all but 1 of 270 choices of seeds."""
    rejected = 0
    for z, dof in found.values():
        try:
            assert_z_spread(factor * z, dof, FALSE_ALARM)
        except AssertionError:
            rejected += 1
    assert rejected >= 2


def test_a_bias_of_a_fifth_of_the_error_is_rejected(found):
    for z, dof in found.values():
        with pytest.raises(AssertionError, match="mean"):
            assert_z_spread(z + 0.2, dof, FALSE_ALARM)
