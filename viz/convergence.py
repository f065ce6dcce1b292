"""How a number settles while a run goes on: the mean of the batches so far with its band, and its standard error."""

from __future__ import annotations

import math
import os
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.special import gammaincinv

from transport import Estimate
from transport.statistics.batches import standard_error, student_quantile, weighted_mean
from transport.viz.style import BLUE, INK, MUTED, PALE, SKY, VERMILLION, figure, tick_log, with_unit
from transport.viz.wording import as_it_stands

FIRST = 3  # batches, from which on there is a band
TWO = 0.9772498680518208  # probability below two standard deviations of a normal variable


class Course(NamedTuple):
    """The first 1, 2, ... batches together.  particles, value, error (nan for one), reach: half the band, (B,)."""

    particles: np.ndarray
    value: np.ndarray
    error: np.ndarray
    reach: np.ndarray


def convergence(
    result: object,
    quantity: str | Estimate,
    path: str | os.PathLike | None = None,
    exact: float | None = None,
    name: str | None = None,
    title: str | None = None,
    note: str | None = None,
) -> Figure:
    """Draw the running mean over batches with its band, and below its standard error beside 1/√N.

    quantity: "meter.irradiance", or an Estimate of this run such as result["meter"].radiance[3], whose words are `name`.  The band has the width of two
    standard errors of so few batches, by Student's t, so that it covers with 95.4 %.  Above stand the seconds at the run's mean
    rate.  The standard error is relative unless it is larger than the value.  Raises ValueError for an array, for an estimate
    without a known error or exact, and for fewer than 4 batches.
    """
    estimate = _estimate(result, quantity)
    name = name or (
        as_it_stands(quantity.replace("_", " ").replace(".", ", "))
        if isinstance(quantity, str)
        else "estimate"
    )
    course = course_of(estimate)
    with figure((13.5, 10.4), title, note, path) as page:
        upper, lower = page.subplots(2, 1, sharex=True, height_ratios=(1.3, 1))
        _draw_means(upper, course, exact)
        upper.set_ylabel(with_unit(name, estimate.unit))
        _draw_errors(lower, course, estimate.value, estimate.unit)
        lower.set_xscale("log")
        lower.set_xlim(course.particles[0] / 1.06, course.particles[-1] * 1.06)
        tick_log(lower.xaxis)
        lower.set_xlabel("particles N, batch by batch")
        if result.cost is not None:
            _draw_seconds(upper, result.cost.seconds / course.particles[-1])
        page.draw_without_rendering()  # so that the layout knows how wide the ticks' numbers come out
    return page


def course_of(estimate: Estimate) -> Course:
    """What the first k batches give together, for each k."""
    values, sizes = estimate.values, estimate.run.sizes
    means, errors, reaches = [], [], []
    for k in range(1, len(sizes) + 1):
        error = float(standard_error(values[:k], sizes[:k]))
        means.append(float(weighted_mean(values[:k], sizes[:k])))
        errors.append(error)
        reaches.append(float(student_quantile(TWO, k - 1)) * error if k >= FIRST else math.nan)
    return Course(np.cumsum(sizes), *map(np.array, (means, errors, reaches)))


def _draw_means(axes: Axes, course: Course, exact: float | None) -> None:
    low, high = course.value - course.reach, course.value + course.reach
    axes.fill_between(
        course.particles, low, high, color=SKY, alpha=0.4, lw=0, label="covers with 95 %: ± 2 standard errors"
    )
    axes.plot(
        course.particles,
        course.value,
        "o-",
        color=BLUE,
        mec="white",
        mew=0.8,
        label="mean of the batches so far",
    )
    if exact is not None:
        axes.axhline(exact, color=VERMILLION, lw=2.2, ls="--", label=f"exact {exact:.6g}")
    middle, most = course.value[-1], np.nanmax(course.reach[FIRST - 1 :])
    reach = max(most, *np.abs(course.value - middle)) * 1.08
    axes.set_ylim(middle - reach, middle + reach)
    axes.yaxis.get_major_formatter().set_useOffset(False)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.03), ncol=3, fontsize=16)


def _draw_errors(axes: Axes, course: Course, value: float, unit: object) -> None:
    """The standard error of the batches so far on the guide through the last one, and how far it may stray."""
    is_relative = abs(value) > course.error[-1]
    scale = 100 / abs(value) if is_relative else 1.0
    guide = scale * course.error[-1] * np.sqrt(course.particles[-1] / course.particles)
    n, few, told = course.particles[FIRST - 1 :], guide[FIRST - 1 :], scale * course.error[FIRST - 1 :]
    low, high = (few * each for each in strays(np.arange(FIRST, len(guide) + 1)))
    axes.fill_between(n, low, high, color=PALE, lw=0, label="where 95 % of such errors fall")
    axes.plot(course.particles, guide, "--", color=INK, lw=2.2, label="1/√N through the last")
    axes.plot(n, told, "o-", color=BLUE, mec="white", mew=0.8, label="of the batches so far")
    axes.set_yscale("log")
    axes.set_ylim(0.7 * min(told[told > 0].min(), low[2:].min()), 1.3 * max(told.max(), high.max()))
    tick_log(axes.yaxis)
    axes.set_ylabel("std. error  [%]" if is_relative else with_unit("standard error", unit))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.3), ncol=3, fontsize=16)


def strays(batches: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Between which multiples of the true one 95.4 % of the standard errors from so many batches fall: of a root of χ²/(B - 1)."""
    dof = batches - 1
    return tuple(np.sqrt(2 * gammaincinv(dof / 2, p) / dof) for p in (1 - TWO, TWO))


def _draw_seconds(axes: Axes, each: float) -> None:
    """Seconds along the top, at the mean rate of the run."""
    top = axes.secondary_xaxis("top", functions=(lambda n: n * each, lambda seconds: seconds / each))
    tick_log(top.xaxis)
    top.set_xlabel("seconds, at the run's mean rate", color=MUTED, fontsize=16, labelpad=8)
    top.tick_params(colors=MUTED)


def _estimate(result: object, quantity: str | Estimate) -> Estimate:
    """The estimate that is meant.  Raises ValueError for one that does not settle."""
    estimate = quantity if isinstance(quantity, Estimate) else result.quantity(quantity)
    words = quantity if isinstance(quantity, str) else "the estimate"
    if not isinstance(estimate, Estimate):
        raise ValueError(
            f"convergence: {words} has the axes {estimate.dims}; take one of its bins, an Estimate"
        )
    if estimate.exact or estimate.reason is not None or estimate.run is None or len(estimate.run) <= FIRST:
        raise ValueError(
            f"convergence: {words} needs batches that differ, at least {FIRST + 1}, got {estimate!r}"
        )
    return estimate
