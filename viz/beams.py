"""A beam in phase space at several places: its shape changes, its area and the radiance within do not."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from transport.viz.style import PURPLE, SKY, figure_at, outlined

CM = 100.0  # of a metre
RADIANCE = "inferno"
HIGHEST = 1.25  # radiance over that of the source, at the end of the scale


class Portrait(NamedTuple):
    """Radiance over that of the source [1], (n, m), in bins with edges x [m] and p, a direction cosine;
    outline: (k, 2) of x and p, closed, and its area [m];  other: label, outline and area to compare with."""

    x: np.ndarray
    p: np.ndarray
    share: np.ndarray
    outline: np.ndarray
    area: float
    other: tuple[str, np.ndarray, float] | None = None


def beam_portraits(
    panels: Mapping[str, Portrait],
    path: str | os.PathLike,
    title: str = "A beam through a lens: another shape, the same area, the same radiance",
    note: str | None = None,
) -> str | os.PathLike:
    """Draw a beam by place and direction in its plane, a panel a place; returns the path.  Raises ValueError for none."""
    if not panels:
        raise ValueError("beam_portraits: at least one panel is needed, got none")
    scale = Normalize(0, HIGHEST)
    with figure_at(path, (5.0 * len(panels) + 1.8, 7.2), title, note) as figure:
        axes = figure.subplots(1, len(panels), squeeze=False)[0]
        for each, (label, portrait) in zip(axes, panels.items(), strict=True):
            _draw(each, portrait, scale)
            each.set_title(label)
        axes[0].set_ylabel("direction cosine p")
        bar = figure.colorbar(ScalarMappable(scale, RADIANCE), ax=axes, extend="max", aspect=30)
        bar.set_label("radiance / that of the source")
    return path


def _draw(axes: Axes, portrait: Portrait, scale: Normalize) -> None:
    axes.set_facecolor("black")
    axes.grid(False)
    axes.pcolormesh(CM * portrait.x, portrait.p, portrait.share.T, norm=scale, cmap=RADIANCE, rasterized=True)
    closed = np.concatenate([portrait.outline, portrait.outline[:1]])
    axes.plot(CM * closed[:, 0], closed[:, 1], color=SKY, lw=2.6, label="exact outline")
    words = f"area {1e3 * portrait.area:.3f} mm"
    if portrait.other is not None:
        label, outline, area = portrait.other
        closed = np.concatenate([outline, outline[:1]])
        axes.plot(CM * closed[:, 0], closed[:, 1], "--", color=PURPLE, lw=2.2)
        axes.text(
            0.97,
            0.96,
            f"{label}:\n{1e3 * area:.3f} mm",
            color=PURPLE,
            ha="right",
            va="top",
            transform=axes.transAxes,
        )
    axes.text(0.5, 0.03, words, color="white", ha="center", transform=axes.transAxes, path_effects=outlined())
    axes.set_xlim(CM * portrait.x[[0, -1]])
    axes.set_ylim(portrait.p[[0, -1]])
    axes.set_xlabel("place x  [cm]")
