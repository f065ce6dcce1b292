"""The shared judge of the tests: does a result agree with its exact value, a sample with its law?

Every judgement states its rate of false alarms: the probability that it fails right code, over all seeds.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import bdtr, bdtrc, chdtr, chdtrc, nctdtrinc, ndtr, ndtri

from transport.statistics.any_estimate import AnyEstimate
from transport.statistics.batches import normal_score, student_quantile

_SMALLEST_EXPECTATION = 20.0  # counts in a bin below which chi-square would not be trusted far out


def assert_agrees(estimate: AnyEstimate, exact: float | np.ndarray, false_alarm: float = 1e-5) -> None:
    """Fail unless the estimate lies within its error of the exact value, two-sided, through Student's t.

    An array of estimates shares the false-alarm rate among its bins.  An unknown error fails.
    """
    z = np.asarray(estimate.z(exact))
    limit = -ndtri(false_alarm / z.size / 2)
    size = np.where(np.isnan(z), np.inf, np.abs(z))
    worst = np.unravel_index(np.argmax(size), z.shape)
    if size[worst] <= limit:
        return
    value, error, reason = (
        np.asarray(part)[worst] for part in (estimate.value, estimate.error, estimate.reason)
    )
    place = f" in bin {tuple(map(int, worst))}" if z.ndim else ""
    raise AssertionError(
        f"value {value:.10g}, error {error:.3g}, exact {np.broadcast_to(exact, z.shape)[worst]:.10g} "
        f"[{estimate.unit}]{place}: z = {z[worst]:.2f}, limit {limit:.2f} (false alarm {false_alarm:.0e})"
        + (f"; error unknown: {reason}" if reason is not None else "")
    )


def agrees(estimate: AnyEstimate, exact: float | np.ndarray, false_alarm: float = 1e-5) -> bool:
    """Whether `assert_agrees` passes."""
    try:
        assert_agrees(estimate, exact, false_alarm)
    except AssertionError:
        return False
    return True


def assert_rejected(estimate: AnyEstimate, wrong: float | np.ndarray, false_alarm: float = 1e-5) -> None:
    """Fail unless `assert_agrees` fails: it tells this value from a wrong one."""
    assert not agrees(estimate, wrong, false_alarm), f"{estimate} is not told from {wrong}"


def smallest_bias(
    estimate: AnyEstimate, false_alarm: float = 1e-5, power: float = 0.95
) -> float | np.ndarray:
    """Relative bias that `assert_agrees` would catch with this power: noncentral Student's t."""
    if estimate.exact:
        return 1e-12
    bins = np.size(estimate.value)
    limit = student_quantile(1 - false_alarm / bins / 2, estimate.dof)
    return nctdtrinc(estimate.dof, 1 - power, limit) * estimate.relative_error


def assert_follows(counts: np.ndarray, expected_probabilities: np.ndarray, false_alarm: float = 1e-5) -> None:
    """Fail unless independent draws, counted in bins, follow the law: chi-square, small bins pooled.

    Raises ValueError where the probabilities do not add up to 1 or too few draws leave a single bin.
    """
    counts, probabilities = np.ravel(counts).astype(float), np.ravel(expected_probabilities)
    if not math.isclose(probabilities.sum(), 1.0, rel_tol=1e-9):
        raise ValueError(f"The probabilities of all bins must add up to 1, got {probabilities.sum()!r}")
    impossible = (probabilities == 0) & (counts > 0)
    assert not impossible.any(), f"draws in bins of probability 0: {np.flatnonzero(impossible)[:10]}"
    observed, expected = _pooled(counts, probabilities * counts.sum())
    chi_square = ((observed - expected) ** 2 / expected).sum()
    probability = chdtrc(len(expected) - 1, chi_square)
    assert probability >= false_alarm, (
        f"chi-square {chi_square:.1f} for {len(expected) - 1} degrees of freedom: "
        f"probability {probability:.2g}, limit {false_alarm:.2g}"
    )


def assert_z_spread(z_values: np.ndarray, dof: float, false_alarm: float = 1e-5) -> None:
    """Fail unless z over many seeds has mean 0, spread 1 and 95 % within the 95 % interval.

    z_values: (value - exact) / error of each seed, which follow Student's t of `dof`; dof is math.inf for
    scores that are normal already, as from `Estimate.z`.  They are judged as normal scores: then the three
    figures follow known laws (normal, chi-square, binomial), each with a third of the false alarms.
    """
    z = normal_score(np.ravel(z_values), dof)
    n = len(z)
    assert np.isfinite(z).all(), f"{np.count_nonzero(~np.isfinite(z))} of {n} z are not finite"
    inside = int(np.count_nonzero(np.abs(z) <= ndtri(0.975)))
    squares = ((z - z.mean()) ** 2).sum()
    tails = {
        f"mean {z.mean():+.4f}, not 0": 2 * ndtr(-abs(z.mean()) * math.sqrt(n)),
        f"spread {math.sqrt(squares / (n - 1)):.4f}, not 1": 2
        * min(chdtr(n - 1, squares), chdtrc(n - 1, squares)),
        f"coverage {inside / n:.4f}, not 0.95": 2 * min(bdtr(inside, n, 0.95), bdtrc(inside - 1, n, 0.95)),
    }
    wrong = [f"{what} (probability {tail:.1e})" for what, tail in tails.items() if tail < false_alarm / 3]
    assert not wrong, f"z of {n} seeds, false alarm {false_alarm:.1e}: " + "; ".join(wrong)


def _pooled(observed: np.ndarray, expected: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Observed and expected counts with bins of small expectation put together, the smallest first."""
    pools: list[list[float]] = []
    for bin_ in np.argsort(expected, kind="stable"):
        if not pools or pools[-1][1] >= _SMALLEST_EXPECTATION:
            pools.append([0.0, 0.0])
        pools[-1][0] += observed[bin_]
        pools[-1][1] += expected[bin_]
    if len(pools) > 1 and pools[-1][1] < _SMALLEST_EXPECTATION:
        last = pools.pop()
        pools[-1] = [pools[-1][0] + last[0], pools[-1][1] + last[1]]
    if len(pools) < 2:
        raise ValueError(
            f"{observed.sum():.0f} draws are too few to tell bins apart; draw more, or use fewer bins"
        )
    return tuple(np.transpose(pools))
