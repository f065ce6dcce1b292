"""The look of 3-D pictures: light on a dark ground, colour scales, and text in a font that has every sign.

The renderer's own fonts drop signs such as φ, and the minus of an exponent. So all text has another font, units are
mathtext, and bars write their decades as text.
"""

from __future__ import annotations

import math
import re
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
GLOW, DETECTOR, TRACK = "#fff1c2", "#56b4e9", "#ffe7a8"
ON_SURFACES, IN_VOLUMES, ON_TRACKS = "inferno", "Blues_r", "viridis"  # colour maps
DARK = {"inferno": 0.12, "viridis": 0.3}  # share of a map that is left out: too dark to be seen on the ground
MAX_DECADES = 6  # of a scale
MIN_MARKS = 3  # of a bar
EQUAL = 1e-4  # relative difference up to which values have one colour, in the middle of the scale
MARGIN = 0.008  # of the window, beside text
BAR, BAR_SHARE = (
    0.075,
    0.22,
)  # width of a bar with its text, of the window, and the share of it that is coloured
LEGIBLE = 10  # [pixels] least type size of marks and names
TICK = 12  # [pixels] from the colours of a bar to its marks
BETWEEN = "   ·   "  # separates the pieces of a caption
HEIGHT = 900  # [pixels] of the window for which type sizes are given
FONT_FROM_FILE = 4  # VTK's number of a font that is read from a file


class Scale(NamedTuple):
    """A colour scale: its ends (of `of` the values), and marks as (place, text)."""

    low: float
    high: float
    marks: tuple[tuple[float, str], ...]
    is_log: bool

    def of(self, values: np.ndarray) -> np.ndarray:
        """Return the values, or their decimal logarithms, nan for those that have none."""
        if not self.is_log:
            return values
        return np.log10(values, out=np.full(np.shape(values), np.nan), where=np.asarray(values) > 0)


def logarithmic(values: np.ndarray) -> Scale | None:
    """Return a scale over the range of the positive values, at most the upper six decades; None without any."""
    known = values[np.isfinite(values) & (values > 0)]
    if len(known) == 0:
        return None
    low, high = _apart(float(known.min()), float(known.max()))
    low = max(low, high / 10.0**MAX_DECADES)
    marks = tuple((math.log10(value), text) for value, text in round_marks(low, high, is_log=True))
    return Scale(math.log10(low), math.log10(high), marks, True)


def linear(values: np.ndarray) -> Scale | None:
    """Return a scale over the range of the values; None without a positive one."""
    known = values[np.isfinite(values)]
    if known.max(initial=0.0) <= 0:
        return None
    low, high = _apart(float(known.min()), float(known.max()))
    return Scale(low, high, tuple(round_marks(low, high, is_log=False)), False)


def _apart(low: float, high: float) -> tuple[float, float]:
    """Return the ends of a scale: those of the data, or a tenth around values that are all equal."""
    return (low, high) if high - low > EQUAL * high else (high / 1.1, high * 1.1)


def round_marks(low: float, high: float, is_log: bool) -> list[tuple[float, str]]:
    """Return round numbers from low to high, each with its text.

    They are powers of ten on a long logarithmic scale, 1, 2 and 5 times those on a shorter one, else equal steps.
    """
    for factors in ((1,), (1, 2, 5)) if is_log else ():
        powers = range(math.floor(math.log10(low)), math.floor(math.log10(high) + 1e-9) + 1)
        values = [m * 10.0**k for k in powers for m in factors]
        found = [value for value in values if low * (1 - 1e-9) <= value <= high * (1 + 1e-9)]
        if len(found) >= MIN_MARKS:
            return [(value, _number(value)) for value in found]
    unit = 10.0 ** math.floor(math.log10((high - low) / MIN_MARKS))
    step = max(m * unit for m in (1, 2, 5) if MIN_MARKS * m * unit <= (high - low) * (1 + 1e-9))
    counts = range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)
    return [(k * step, _number(k * step)) for k in counts]


def _number(value: float) -> str:
    """Return a round number: 0.02, 5000, or 2·10⁻⁵."""
    k = math.floor(math.log10(abs(value)) + 1e-9) if value else 0
    if -3 < k < 4:
        return f"{value:.8g}".replace("-", "−")
    factor = f"{value / 10.0**k:.8g}·".replace("-", "−")
    return ("" if factor == "1·" else factor) + "10" + str(k).translate(SUPERSCRIPTS)


def short_estimate(estimate: object) -> str:
    """Return an estimate with its error in one line, exponents raised, without the reason of an unknown error."""
    return raised(re.sub(r"\(error unknown: .*\)", "(error unknown)", str(estimate)))


# ---- Text and bars in a window.


def font() -> str:
    """Return the file of a font that has every sign in use."""
    import matplotlib

    return str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")


def load_mathtext() -> None:
    """Load VTK's renderer of mathtext. It must precede the first text of a process; pyvista 0.45 does not load it."""
    import vtkmodules.vtkRenderingMatplotlib  # noqa: F401


def type_size(plotter: pyvista.Plotter, size: float, least: int = 5) -> int:
    """Scale a type size for a window of HEIGHT pixels to the plotter's window."""
    return max(least, round(size * min(1.5, plotter.window_size[1] / HEIGHT)))


def write(
    plotter: pyvista.Plotter, text: str, place: tuple[float, float], size: int, colour: str = TEXT
) -> object:
    """Write text with its lower left corner at a place in the window, (0, 0) to (1, 1); return the actor.

    Text that would be cut begins farther left; pieces between BETWEEN go to further lines if one is too short.
    """
    load_mathtext()
    look = {"font_size": type_size(plotter, size), "color": colour, "font_file": font()}
    actor = plotter.add_text(text, position=place, viewport=True, **look)
    style = actor.GetTextProperty()
    lines: list[str] = []
    for piece in text.split(BETWEEN):
        longer = lines[-1] + BETWEEN + piece if lines else piece
        if lines and _width(plotter, style, longer) <= 1 - 2 * MARGIN:
            lines[-1] = longer
        else:
            lines.append(piece)
    actor.SetInput("\n".join(lines))
    width = max(_width(plotter, style, line) for line in lines)
    actor.SetPosition(max(min(place[0], 1 - MARGIN - width), MARGIN), place[1])
    return actor


def text_width(plotter: pyvista.Plotter, text: str, size: int) -> float:
    """Return the width of a line of that type size, as a share of the window."""
    from vtkmodules.vtkRenderingCore import vtkTextProperty

    load_mathtext()
    style = vtkTextProperty()
    _set_font(style, size)
    return _width(plotter, style, text)


def _set_font(style: vtkTextProperty, size: int) -> None:
    style.SetFontFamily(FONT_FROM_FILE)
    style.SetFontFile(font())
    style.SetFontSize(size)


def _width(plotter: pyvista.Plotter, style: vtkTextProperty, text: str) -> float:
    """Width of a line, as a share of the window."""
    from vtkmodules.vtkRenderingCore import vtkTextRenderer

    window, box = plotter.render_window, [0, 0, 0, 0]
    vtkTextRenderer.GetInstance().GetBoundingBox(style, text, box, window.GetDPI())
    return (box[1] - box[0] + 1) / window.GetSize()[0]


def add_coloured(
    plotter: pyvista.Plotter,
    mesh: pyvista.PolyData,
    values: np.ndarray,
    scale: Scale,
    colours: str,
    **look: object,
) -> object:
    """Draw a mesh whose cells are coloured by values on a scale, grey where they have none; return the actor."""
    from matplotlib.colors import ListedColormap

    mesh.cell_data["shown"] = scale.of(values)
    look |= {
        "cmap": ListedColormap(colours_of(colours)),
        "clim": (scale.low, scale.high),
        "nan_color": UNKNOWN,
        "lighting": False,
    }
    return plotter.add_mesh(mesh, scalars="shown", show_scalar_bar=False, **look)


def colours_of(name: str, count: int = 256) -> np.ndarray:
    """Return the colours (count, 4) of a map of matplotlib from low to high, without its darkest."""
    from matplotlib import colormaps

    return colormaps[name](np.linspace(DARK.get(name, 0.0), 1, count))


def add_bar(
    plotter: pyvista.Plotter,
    actor: object,
    title: str,
    scale: Scale,
    place: tuple[float, float],
    height: float,
) -> None:
    """Add a colour bar with marks; `title`: mathtext; `place`: lower left corner of its colours, as shares of the window.

    It stands farther left where its marks would be cut.
    """
    load_mathtext()
    bar = plotter.add_scalar_bar(
        title=title,
        mapper=actor.mapper,
        vertical=True,
        position_x=place[0] - (1 - BAR_SHARE) * BAR,
        position_y=place[1],
        width=BAR,
        height=height,
        n_labels=0,
        color=TEXT,
        unconstrained_font_size=True,
        nan_annotation=False,
    )
    for value, text in scale.marks:
        actor.mapper.lookup_table.SetAnnotation(value, text)
    bar.SetTitle("")
    bar.SetTextPositionToPrecedeScalarBar()
    bar.SetDrawAnnotations(True)
    bar.SetDrawTickLabels(False)
    bar.SetBarRatio(BAR_SHARE)
    style = bar.GetAnnotationTextProperty()
    _set_font(style, type_size(plotter, 16, LEGIBLE))
    style.SetVerticalJustificationToCentered()  # newer VTKs put it above its mark by default
    style.SetColor(*(int(TEXT[k : k + 2], 16) / 255 for k in (1, 3, 5)))
    widest = max(_width(plotter, style, text) for _, text in scale.marks)
    room = 1 - MARGIN - widest - TICK / plotter.window_size[0] - BAR_SHARE * BAR
    left = min(place[0], room)
    bar.SetPosition(left - (1 - BAR_SHARE) * BAR, place[1])
    write(plotter, title, (left, place[1] + height + 0.02), 12)
