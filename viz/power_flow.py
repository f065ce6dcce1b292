"""Where the power went: the ledger as a flow, from what was emitted to what absorbed it, let it escape or holds it still."""

from __future__ import annotations

import math
import os
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path

from transport import Estimate
from transport.viz.style import BLUE, GREEN, INK, MUTED, ORANGE, PURPLE, SKY, VERMILLION, figure
from transport.viz.wording import as_it_stands, estimate_text

WORDS = {  # ledger entry -> how it reads, and its colour
    "escaped": ("escaped", SKY),
    "in_flight": ("in flight at the end", GREEN),
    "unsampled": ("not followed: it missed the aim", "#b8b8b8"),
    "roulette": ("killed by roulette, less what survived more", PURPLE),
    "lost": ("lost: a fault of the scene, see the warnings", INK),
}
ABSORBED = (VERMILLION, ORANGE)  # by surfaces and media, in turn
ROUNDING = 1e-12  # of what was emitted: less is no gain or loss of the roulette
LEFT, RIGHT, THICK = 0.02, 0.46, 0.035  # of the figure's width
WIDTH, WHOLE = 16.0, 4.6  # inches: the figure's, and the height of what was emitted
PITCH, GAP = 0.82, 0.14  # inches: the least distance of two labels, and between two ends


class End(NamedTuple):
    """Where a part went: its words, how much, and its colour."""

    words: str
    amount: Estimate
    colour: str


def power_flow(
    result: object,
    path: str | os.PathLike | None = None,
    most: int = 9,
    title: str | None = None,
    note: str | None = None,
) -> Figure:
    """Draw `result.ledger` as a flow whose widths are to scale, each end with its number, error and share.

    Surfaces and media that absorbed stand one by one, up to `most` ends in all, the least of them together.  Parts thinner than a
    line are drawn as one.  What roulette has gained is said in words: it is no part of what was emitted.
    Raises ValueError for a run backwards, whose ledger is of histories and not of power.
    """
    if result.plan.adjoint is not None:
        raise ValueError(
            "power_flow: the ledger of a run backwards is no power; run the scene with estimator='analog'"
        )
    ledger = result.ledger
    emitted = ledger["emitted"]
    ends = ends_of(result, most)
    heights = [max(WHOLE * end.amount.value / emitted.value, 0.0) if emitted.value else 0.0 for end in ends]
    places = _places(heights)
    tall = max(places[-1][2] if places else 0.0, WHOLE + 1.0)
    above = 1.2 if title else 0.4
    with figure((WIDTH, tall + above + 0.6), title, note, path, "none") as page:
        axes = page.add_axes((0, 0.6 / (tall + above + 0.6), 1, tall / (tall + above + 0.6)))
        axes.set_axis_off()
        axes.set(xlim=(0, 1), ylim=(-tall, 0))
        start = 0.5 * (sum(heights) - tall)
        axes.add_patch(Rectangle((LEFT, start - sum(heights)), THICK, sum(heights), color=BLUE, lw=0))
        _say(axes, LEFT, start + 0.4, "emitted", estimate_text(emitted))
        for end, height, (top, bottom, _) in zip(ends, heights, places, strict=True):
            _draw_band(axes, (start - height, start), (-bottom, -top), end.colour)
            _say(axes, RIGHT + THICK + 0.012, -0.5 * (bottom + top), end.words, _told(end.amount, emitted))
            start -= height
    return page


def ends_of(result: object, most: int = 9) -> list[End]:
    """All entries but those that are surely 0, the greatest first, with what absorbs split by surface and medium."""
    ledger = result.ledger
    parts = {_absorber(name): each for name, each in ledger.absorbed_by.items() if _is_there(each)}
    others = {name: ledger[name] for name in WORDS if _is_there(ledger[name])}
    if "roulette" in others and abs(others["roulette"].value) <= ROUNDING * abs(ledger["emitted"].value):
        del others["roulette"]
    many = sorted(parts, key=lambda name: -parts[name].value)
    room = max(most - len(others), 1)
    if len(many) > room:
        least = many[room - 1 :]
        parts[f"absorbed by {len(least)} others"] = sum((parts[n] for n in least[1:]), parts[least[0]])
        parts = {name: each for name, each in parts.items() if name not in least}
    by_size = sorted(parts.items(), key=lambda item: -item[1].value)
    ends = [End(words, each, ABSORBED[k % 2]) for k, (words, each) in enumerate(by_size)]
    ends += [End(WORDS[name][0], each, WORDS[name][1]) for name, each in others.items()]
    return sorted(ends, key=lambda end: -end.amount.value)


def _absorber(name: str) -> str:
    """A surface absorbs, and so does what fills it, which the ledger calls "inside fog"."""
    return f"absorbed {'' if name.startswith('inside ') else 'by '}{as_it_stands(name)}"


def _is_there(estimate: Estimate) -> bool:
    return estimate.value != 0 or not (estimate.exact or estimate.reason is not None)


def _places(heights: list[float]) -> list[tuple[float, float, float]]:
    """(top, bottom, end of its room) of the ends at the right, downwards [inches]; none nearer than two labels need."""
    places, top = [], 0.0
    for height in heights:
        room = max(height, PITCH)
        middle = top + room / 2
        top += room + GAP
        places.append((middle - height / 2, middle + height / 2, top))
    return places


def _draw_band(axes: Axes, begin: tuple[float, float], end: tuple[float, float], colour: str) -> None:
    """A band from the source to an end, between two curves that leave and arrive level."""
    x0, x1 = LEFT + THICK, RIGHT
    middle = 0.5 * (x0 + x1)
    vertices = [
        (x0, begin[1]), (middle, begin[1]), (middle, end[1]), (x1, end[1]),
        (x1, end[0]), (middle, end[0]), (middle, begin[0]), (x0, begin[0]), (x0, begin[1]),
    ]  # fmt: skip
    codes = [Path.MOVETO, *[Path.CURVE4] * 3, Path.LINETO, *[Path.CURVE4] * 3, Path.CLOSEPOLY]
    axes.add_patch(PathPatch(Path(vertices, codes), facecolor=colour, edgecolor=colour, alpha=0.45, lw=0.6))
    axes.add_patch(Rectangle((RIGHT, end[0]), THICK, end[1] - end[0], color=colour, lw=0.8))


def _say(axes: Axes, x: float, y: float, words: str, number: str) -> None:
    axes.text(x, y + 0.02, words, va="bottom", fontsize=18, fontweight="bold")
    axes.text(x, y - 0.02, number, va="top", fontsize=16, color=MUTED)


def _told(amount: Estimate, emitted: Estimate) -> str:
    """The number with its error, and its share of what was emitted, to the digit that is uncertain."""
    share, error = (
        100 * each / emitted.value if emitted.value else np.nan for each in (amount.value, amount.error)
    )
    if error > 0 and np.isfinite(share):
        share = round(share, -math.floor(math.log10(error)))
    return f"{estimate_text(amount)},  {share:.3g} %".replace(" -", " −")
