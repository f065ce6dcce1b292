"""How 3-D pictures look: light on a dark ground, decade scales, text in a font that has every sign.

The renderer's own fonts drop signs such as φ, and the minus of an exponent, without a word.  So all text is in a font
that has them, units are mathtext, and bars say their decades as text.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.viz.wording import SUPERSCRIPTS, raised

if TYPE_CHECKING:
    import pyvista
    from vtkmodules.vtkRenderingCore import vtkTextProperty

GROUND, TEXT, FAINT = "#0d1017", "#e8ebf0", "#9aa4b2"
UNKNOWN = "#3b414d"  # cells of too few hits
WALL, STEEL, GLASS = "#59616f", "#aab4c2", "#7fd4e6"
FOG, GLOWING = "#9fb8d8", "#ffb070"
GLOW, METER = "#fff1c2", "#56b4e9"
VALUES, CELLS, WAYS = "inferno", "Blues_r", "viridis"  # measured on surfaces, in volumes; and tracks
MOST_DECADES = 6
FEW_DECADES = 2  # up to so many, a bar also says 2 and 5
MARGIN = 0.008  # of the window, beside words
BAR, WIDE = 0.075, 0.22  # width of a bar with its words, of the window, and the share of it that is coloured
LEGIBLE = 10  # pixels of the type of marks and names, at least
TICK = 12  # pixels from the colours of a bar to its marks
BETWEEN = "   ·   "  # the pieces of a caption
HEIGHT = 900  # pixels of the window for which type sizes are given
FROM_FILE = 4  # how the renderer calls a font that is read from a file


class Scale(NamedTuple):
    """low, high: where its colours end, in `of` what is shown;  marks: what its bar says, and where."""

    low: float
    high: float
    marks: tuple[tuple[float, str], ...]
    is_log: bool

    def of(self, values: np.ndarray) -> np.ndarray:
        """What the colours go by: the values, or their decimal logarithms; nan for what has none."""
        if not self.is_log:
            return values
        return np.log10(values, out=np.full(np.shape(values), np.nan), where=np.asarray(values) > 0)


def decades(values: np.ndarray) -> Scale | None:
    """A logarithmic scale over whole decades that holds the positive values, the upper six at most; None without any."""
    known = values[np.isfinite(values) & (values > 0)]
    if len(known) == 0:
        return None
    first, last = math.floor(math.log10(known.min()) + 1e-9), math.ceil(math.log10(known.max()) - 1e-9)
    last = max(last, first + 1)
    first = max(first, last - MOST_DECADES)
    marks = [(float(k), _power(k)) for k in range(first, last + 1)]
    if last - first <= FEW_DECADES:
        marks += [(k + math.log10(m), _between(m, k)) for k in range(first, last) for m in (2, 5)]
    return Scale(first, last, tuple(sorted(marks)), True)


def evenly(values: np.ndarray) -> Scale | None:
    """A linear scale from 0 to a round number above the values; None without a positive one."""
    known = values[np.isfinite(values)]
    if len(known) == 0 or known.max() <= 0:
        return None
    unit = 10.0 ** math.floor(math.log10(known.max()))
    high = next(k * unit for k in (1, 2, 3, 4, 5, 6, 8, 10) if k * unit >= known.max() * (1 - 1e-9))
    return Scale(0.0, high, tuple((share * high, f"{share * high:.3g}") for share in (0, 0.5, 1)), False)


def font() -> str:
    """The file of a font that has every sign in use."""
    import matplotlib

    return str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")


def sized(plotter: pyvista.Plotter, size: float, least: int = 5) -> int:
    """A type size that is meant for a window of HEIGHT pixels, in the plotter's."""
    return max(least, round(size * min(1.5, plotter.window_size[1] / HEIGHT)))


def write(
    plotter: pyvista.Plotter, words: str, place: tuple[float, float], size: int, colour: str = TEXT
) -> None:
    """Words at a place in the window, (0, 0) lower left to (1, 1): their lower left corner; further left where they would be cut.

    Pieces of them that BETWEEN parts go into further lines where one is too short.
    """
    text = plotter.add_text(
        words,
        position=place,
        viewport=True,
        font_size=sized(plotter, size),
        color=colour,
        font_file=font(),
    )
    look = text.GetTextProperty()
    lines = _folded(words, lambda line: _width(plotter, look, line) <= 1 - 2 * MARGIN)
    text.SetInput("\n".join(lines))
    width = max(_width(plotter, look, line) for line in lines)
    text.SetPosition(max(min(place[0], 1 - MARGIN - width), MARGIN), place[1])


def _folded(words: str, fits: Callable[[str], bool]) -> list[str]:
    """Lines that fit, as far as they can be parted."""
    first, *rest = words.split(BETWEEN)
    lines = [first]
    for piece in rest:
        longer = lines[-1] + BETWEEN + piece
        lines = [*lines[:-1], longer] if fits(longer) else [*lines, piece]
    return lines


def width_of(plotter: pyvista.Plotter, words: str, size: int) -> float:
    """Of a line of words of that type size, as a share of the window."""
    from vtkmodules.vtkRenderingCore import vtkTextProperty

    look = vtkTextProperty()
    look.SetFontFamily(FROM_FILE)
    look.SetFontFile(font())
    look.SetFontSize(size)
    return _width(plotter, look, words)


def _width(plotter: pyvista.Plotter, look: vtkTextProperty, words: str) -> float:
    """Of a line of words, as a share of the window."""
    from vtkmodules.vtkRenderingCore import vtkTextRenderer

    window = plotter.render_window
    box = [0, 0, 0, 0]
    vtkTextRenderer.GetInstance().GetBoundingBox(look, words, box, window.GetDPI())
    return (box[1] - box[0] + 1) / window.GetSize()[0]


def add_bar(
    plotter: pyvista.Plotter,
    actor: object,
    title: str,
    scale: Scale,
    place: tuple[float, float],
    height: float,
) -> None:
    """A bar of colours with its marks; title: mathtext;  place: of the lower left corner of its colours, in shares of the window.

    It stands further left where its marks would be cut: of 5·10²⁰ a narrow window would leave 5·10².
    """
    bar = plotter.add_scalar_bar(
        title=title,
        mapper=actor.mapper,
        vertical=True,
        position_x=place[0] - (1 - WIDE) * BAR,
        position_y=place[1],
        width=BAR,
        height=height,
        n_labels=0,
        color=TEXT,
        unconstrained_font_size=True,
        nan_annotation=False,
    )
    for value, words in scale.marks:
        actor.mapper.lookup_table.SetAnnotation(value, words)
    bar.SetTitle("")
    bar.SetTextPositionToPrecedeScalarBar()
    bar.SetDrawAnnotations(True)
    bar.SetDrawTickLabels(False)
    bar.SetBarRatio(WIDE)
    words = bar.GetAnnotationTextProperty()
    words.SetFontFamily(FROM_FILE)
    words.SetFontFile(font())
    words.SetFontSize(sized(plotter, 16, LEGIBLE))
    words.SetColor(*(int(TEXT[k : k + 2], 16) / 255 for k in (1, 3, 5)))
    widest = max(_width(plotter, words, said) for _, said in scale.marks)
    room = 1 - MARGIN - widest - TICK / plotter.window_size[0] - WIDE * BAR
    left = min(place[0], room)
    bar.SetPosition(left - (1 - WIDE) * BAR, place[1])
    write(plotter, title, (left, place[1] + height + 0.02), 12)


def in_words(estimate: object) -> str:
    """The estimate with its error, its unit with raised exponents; why an error is unknown has no room in a picture."""
    short = re.sub(r"\(error unknown: .*\)", "(error unknown)", str(estimate))
    return raised(short)


def _power(k: int) -> str:
    return f"{10.0**k:g}" if -2 < k < 4 else "10" + str(k).translate(SUPERSCRIPTS)


def _between(m: int, k: int) -> str:
    return f"{m * 10.0**k:g}" if -2 < k < 4 else f"{m}·{_power(k)}"
