"""Radiance by the optical length of rays through glowing matter, on 1 - e^(-τ) where they come from the dark."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from transport import Estimate
from transport.viz.profiles import FURTHEST, in_standard_errors
from transport.viz.style import INK, MARKERS, MUTED, PALETTE, POINTS, VERMILLION, WITHIN_TWO, figure_at

FINE = 500  # points of the curve


class Rays(NamedTuple):
    """Optical lengths (n,), n estimates of L/L₀, and what they should be, (n,)."""

    lengths: np.ndarray
    found: Sequence[Estimate]
    expected: np.ndarray

    def of_all(self, name: str) -> np.ndarray:
        """An attribute of all estimates, (n,)."""
        return np.array([getattr(each, name) for each in self.found], dtype=float)


def glowing_rays(
    rays: Mapping[str, Rays],
    path: str | os.PathLike,
    dark: Callable[[np.ndarray], np.ndarray],
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw L/L₀ with bars of two standard errors by the optical length, residuals below; returns the path.

    dark: L/L₀ by the optical length of a ray from the dark.
    """
    with figure_at(path, (14.5, 10), title, note) as figure:
        main, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.8, 1))
        lengths = np.concatenate([each.lengths for each in rays.values()])
        fine = np.geomspace(0.7 * lengths.min(), 1.4 * lengths.max(), FINE)
        main.plot(fine, dark(fine), color=INK, lw=2.4, label=r"from the dark: $1 - e^{-\tau}$", zorder=2)
        main.plot(fine, fine, ls=":", color=MUTED, lw=2, label=r"thin: $\tau$", zorder=1)
        main.axhline(1, color=VERMILLION, lw=2.4, ls="--", label="black body, equilibrium: 1", zorder=1)
        lower.axhspan(-2, 2, color=WITHIN_TWO, lw=0)
        lower.axhline(0, color=INK, lw=1.6)
        reach = 3.4
        for place, (label, each) in enumerate(rays.items()):
            colour, marker = PALETTE[place % len(PALETTE)], MARKERS[place % len(MARKERS)]
            value, error = each.of_all("value"), each.of_all("error")
            bars = 2 * np.nan_to_num(error)
            main.errorbar(
                each.lengths, value, bars, fmt=marker, color=colour, label=label, zorder=4, **POINTS
            )
            residual = np.clip(in_standard_errors(value, error, each.expected), -FURTHEST, FURTHEST)
            lower.plot(each.lengths, residual, marker, color=colour, mec="white", mew=0.8)
            reach = max(reach, 1.15 * np.abs(residual[np.isfinite(residual)]).max(initial=0.0))
        main.set(
            xscale="log", yscale="log", ylabel="radiance / that of a black body", xlim=(fine[0], fine[-1])
        )
        main.set_ylim(0.7 * dark(fine[:1])[0], 2)
        main.legend(loc="lower right", title="points: simulated, ± 2 standard errors", title_fontsize=15)
        lower.set(xlabel="optical length of the (mean) ray  $\\tau = \\sigma_a s$", ylim=(-reach, reach))
        lower.set_ylabel("residual\n[std. errors]")
        figure.align_ylabels()
    return path
