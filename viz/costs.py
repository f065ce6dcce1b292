"""What accuracy costs: error against seconds for each way to the same number; beside it, what bins cost."""

from __future__ import annotations

import os
import time

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogFormatterMathtext, LogLocator, NullFormatter

from transport.analysis.binning import BinsAgainstNoise
from transport.analysis.cost import CostOfAccuracy, price_text
from transport.analysis.work_precision import MethodCost
from transport.statistics.notation import duration, percent
from transport.viz.style import (
    ESTIMATOR_COLOURS,
    INK,
    MUTED,
    ORANGE,
    SAMPLING_MARKS,
    SKY,
    TRACKING_MARKS,
    Mark,
    figure,
)

SHAPES = {"o": "●", "s": "■", "^": "▲", "D": "◆", "v": "▼", "P": "✚"}
OWN = ("X", "p", "h", "<")  # markers of ways with names of their own, in turn
APART = 0.062  # of the height, between labels
Look = tuple[str, str, str | tuple]  # colour, marker, line


def cost_diagram(
    cost: CostOfAccuracy,
    path: str | os.PathLike | None = None,
    bins: BinsAgainstNoise | None = None,
    title: str | None = None,
    note: str | None = None,
) -> Figure:
    """Draw the error of each way to estimate against seconds: true (filled) and claimed (open).

    Parameters
    ----------
    cost : CostOfAccuracy
        What `transport.cost_of_accuracy` measured.
    path : str or os.PathLike, optional
        File to write [default: none].
    bins : BinsAgainstNoise, optional
        For a second panel, noise and blur against the number of bins.
    title, note : str, optional
        Headline, and provenance in small type; machine, threads and date are added to it.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        If no way has a known error.

    Notes
    -----
    Both axes are logarithmic.  Each line is labelled with its slope beside the last point.  Horizontal
    lines are the target errors with the least price, a dashed one is the slope of independent histories.
    The colour is the estimator's; marker and line are those of the sampling or of the tracking.  They are
    the same in all figures (`transport.viz.style`), whatever is drawn beside.

    Examples
    --------
    >>> cost_diagram(tp.cost_of_accuracy(scene, "meter.flux_in"), "cost.png")  # doctest: +SKIP
    """
    shown = [way for way in cost.ways if any(_is_seen(point.true) for point in way.points)]
    if not shown:
        raise ValueError("cost_diagram: at least one way with a known error is needed, got none")
    small = (
        f"{cost.machine}, {cost.threads} thread{'s' if cost.threads > 1 else ''}, {time.strftime('%Y-%m-%d')}"
    )
    note = small if note is None else f"{note}, {small}"
    with figure((15.5 if bins is None else 24, 10), title, note, path) as page:
        if bins is None:
            axes = page.subplots()
        else:
            axes, beside = page.subplots(1, 2, width_ratios=(15, 8))
            _draw_bins(beside, bins)
        _draw_ways(axes, cost, shown)
    return page


def _draw_ways(axes: Axes, cost: CostOfAccuracy, shown: list[MethodCost]) -> None:
    looks = _looks(shown)
    for way in shown:
        _draw_way(axes, way, *looks[way.name])
    axes.set_xscale("log")
    axes.set_yscale("log")
    _set_limits(axes, cost, shown)
    _draw_targets(axes, cost)
    _draw_guide(axes)
    _label(axes, shown, looks)
    axes.set_xlabel("seconds of CPU")
    axes.set_ylabel(f"relative error of {cost.quantity}")
    axes.xaxis.set_major_locator(LogLocator(10))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: duration(value)))
    in_percent = axes.get_ylim()[0] > 1e-7
    percents = FuncFormatter(lambda value, _: percent(value))
    axes.yaxis.set_major_formatter(percents if in_percent else LogFormatterMathtext())
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter(NullFormatter())
    axes.set_title(_legend(shown), loc="left", fontsize=16, color=MUTED, pad=10)


def _legend(shown: list[MethodCost]) -> str:
    """What marks mean: a shape per sampling and per tracking, filled where true."""
    found = {_kind(way) for way in shown}
    marks = SAMPLING_MARKS | TRACKING_MARKS
    shapes = "   ".join(f"{SHAPES[marker]} {name}" for name, (marker, _) in marks.items() if name in found)
    between = "\n" if found & TRACKING_MARKS.keys() else ";   "
    return f"{shapes}{between if shapes else ''}filled: true error, open: claimed;   * extrapolated"


def _looks(shown: list[MethodCost]) -> dict[str, Look]:
    """Colour, marker and line of each way: a colour per estimator, the rest per sampling or tracking."""
    marks: dict[str, Mark] = SAMPLING_MARKS | TRACKING_MARKS
    own = [way.name for way in shown if _kind(way) not in marks]
    marks |= {name: (OWN[place % len(OWN)], "-") for place, name in enumerate(own)}
    return {way.name: (ESTIMATOR_COLOURS.get(_estimator(way), INK), *marks[_kind(way)]) for way in shown}


def _kind(way: MethodCost) -> str:
    """The sampling of a way that is named by its estimator, the tracking of another, or a name of its own."""
    family, _, sampling = way.name.partition(", ")
    if family in ESTIMATOR_COLOURS and (sampling or "random") in SAMPLING_MARKS:
        return sampling or "random"
    return next((name for name in TRACKING_MARKS if way.name.startswith(name)), way.name)


def _estimator(way: MethodCost) -> str:
    """The estimator of a way; where it is not known the one in its name, or the usual one."""
    named = way.name.partition(", ")[0]
    return way.estimator or (named if named in ESTIMATOR_COLOURS else "analog")


def _draw_way(axes: Axes, way: MethodCost, colour: str, marker: str, line: str | tuple) -> None:
    points = [point for point in way.points if _is_seen(point.true)]
    seconds, true = np.array([(p.seconds, p.true) for p in points]).T
    bars = np.array([min(2 * p.true_error, 0.9 * p.true) for p in points])
    axes.errorbar(seconds, true, bars, fmt=marker, color=colour, ms=9, lw=1.6, mec="white", mew=0.8, zorder=4)
    claims = [(p.seconds, p.claimed) for p in way.points if _is_seen(p.claimed)]
    if claims:
        axes.plot(
            *zip(*claims, strict=True), marker, mfc="none", mec=colour, mew=1.5, ms=12, ls="none", zorder=3
        )
    if way.line is not None:
        histories = np.geomspace(points[0].particles, points[-1].particles, 100)
        spent = way.pace.per_particle * histories
        axes.plot(way.pace.latency + spent, way.line.error_at(spent), color=colour, ls=line, lw=2.2, zorder=2)


def _set_limits(axes: Axes, cost: CostOfAccuracy, shown: list[MethodCost]) -> None:
    seconds = [point.seconds for way in shown for point in way.points]
    errors = [e for way in shown for p in way.points for e in (p.true, p.claimed) if _is_seen(e)]
    axes.set_xlim(min(seconds) / 6, 1.5 * max(seconds))  # on the left there is room for prices
    axes.set_ylim(0.5 * min(*errors, *cost.targets), min(3.0, 2.5 * max(errors)))


def _draw_targets(axes: Axes, cost: CostOfAccuracy) -> None:
    """The errors asked for, each with the way that is cheapest there."""
    known = [way for way in cost.ways if way.line is not None]
    for target in cost.targets:
        axes.axhline(target, color=INK, lw=1.0, zorder=1)
        if known:
            best = min(known, key=lambda way: way.price(target).seconds)
            words = f"{percent(target)} in {price_text(best.price(target))}\n{best.name}"
            at = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
            axes.annotate(words, (0.01, target), (0, 0), **at, va="center", fontsize=15, linespacing=1.5)


def _draw_guide(axes: Axes) -> None:
    """A dashed line that falls with the square root of time, from the top left to the right."""
    (left, right), (_, top) = axes.get_xlim(), axes.get_ylim()
    seconds = np.array([left * (right / left) ** 0.6, left * (right / left) ** 0.95])
    errors = 0.75 * top * (seconds / seconds[0]) ** -0.5
    axes.plot(seconds, errors, "--", color=MUTED, lw=2.0, zorder=1)
    axes.annotate(
        "$N^{-1/2}$", (seconds[0], errors[0]), (-8, 0), textcoords="offset points", ha="right", va="center",
        color=MUTED, fontsize=19,
    )  # fmt: skip


def _label(axes: Axes, shown: list[MethodCost], looks: dict[str, Look]) -> None:
    """Names and slopes to the right of the axes, in the lines' order, apart from one another, joined to last points."""
    ends = []
    for way in shown:
        last = [point for point in way.points if _is_seen(point.true)][-1]
        ends.append((axes.transLimits.transform((np.log10(last.seconds), np.log10(last.true)))[1], way, last))
    ends.sort(key=lambda end: end[0])
    heights = _apart(np.array([end[0] for end in ends]))
    for height, (_, way, last) in zip(heights, ends, strict=True):
        slope = (
            ""
            if way.line is None
            else f"  {way.line.slope:.2f} ± {way.line.slope_error:.2f}".replace("-", "−")
        )
        axes.annotate(
            f"{way.name}{slope}",
            (last.seconds, last.true),
            (1.02, height),
            textcoords="axes fraction",
            color=looks[way.name][0],
            fontsize=16,
            va="center",
            arrowprops={
                "arrowstyle": "-",
                "color": looks[way.name][0],
                "lw": 0.8,
                "alpha": 0.5,
                "shrinkB": 6,
                "relpos": (0, 0.5),
            },
        )


def _apart(heights: np.ndarray) -> np.ndarray:
    """Rising heights moved as little as needed, so that none are closer than labels are high, within [0, 1]."""
    room = np.arange(len(heights)) * min(APART, 1.0 / max(1, len(heights) - 1))
    lowered = heights - room
    pooled = [[value] for value in lowered]  # pools of neighbours that are in one another's way
    place = 0
    while place + 1 < len(pooled):
        if np.mean(pooled[place]) > np.mean(pooled[place + 1]):
            pooled[place : place + 2] = [pooled[place] + pooled[place + 1]]
            place = max(0, place - 1)
        else:
            place += 1
    level = np.array([np.mean(pool) for pool in pooled for _ in pool])
    return np.clip(level, 0.0, max(0.0, 1.0 - room[-1])) + room


def _draw_bins(axes: Axes, bins: BinsAgainstNoise) -> None:
    """Noise rises with the number of bins, blur falls; both together for these particles, and for a hundred times as many."""
    numbers = np.array(bins.bins)
    axes.plot(numbers, bins.blur, "--", color=INK, lw=2.2)
    seen = [(n, b) for n, b in zip(bins.bins, bins.blur, strict=True) if b > 0]
    _name(axes, seen[0] if seen else (numbers[0], bins.noise[0]), "blur of the bins", (6, 6))
    for times, colour in ((1, SKY), (100, ORANGE)):  # no estimator's
        noise, total = np.array(bins.noise) / times**0.5, np.array(bins.total(times))
        axes.plot(numbers, noise, ":", color=colour, lw=2.0)
        axes.plot(numbers, total, "o-", color=colour, lw=2.2, mec="white")
        best = bins.best(times)
        axes.plot(best, total[bins.bins.index(best)], "*", color=INK, mec="white", ms=26, zorder=5)
        words = f"noise, {bins.particles * times:.2g} particles"
        _name(axes, (numbers[len(numbers) // 3], noise[len(numbers) // 3]), words, (0, -20))
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    in_percent = axes.get_ylim()[0] > 1e-7
    percents = FuncFormatter(lambda value, _: percent(value))
    axes.yaxis.set_major_formatter(percents if in_percent else LogFormatterMathtext())
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(f"bins along {bins.dim}")
    axes.set_ylabel("rms error, taken as constant over a bin")
    axes.set_title("★ best number of bins", loc="left", fontsize=17, color=MUTED, pad=10)


def _name(axes: Axes, place: tuple[float, float], words: str, shift: tuple[int, int]) -> None:
    axes.annotate(words, place, shift, textcoords="offset points", fontsize=16)


def _is_seen(error: float) -> bool:
    return bool(np.isfinite(error)) and error > 0
