"""What a figure shows, for tests of pictures: its words, its points with bars, and whether all of it is inside."""

from __future__ import annotations

from types import SimpleNamespace

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.image import imread

# Filters of warnings: all fail, but not Matplotlib's use of old names of pyparsing, which a newer Matplotlib does not use.
WARNINGS_FAIL = "error", r"ignore:.*deprecated:DeprecationWarning:(matplotlib|pyparsing)\."


def words(page: Figure) -> str:
    """All that a figure says."""
    return "\n".join(text.get_text() for text in page.findobj(matplotlib.text.Text))


def points_of(axes) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """x, y and upper bars of each series of points with bars."""
    found = []
    for container in axes.containers:
        line, _, (bars,) = container.lines
        x, y = line.get_data()
        found.append((x, y, np.array(bars.get_segments())[:, 1, 1] - y))
    return found


def assert_drawn(page: Figure, path=None) -> None:
    """No label is cut off at an edge; the file, if there is one, has more than one colour on white."""
    page.draw_without_rendering()  # so that the layout is done
    box, (width, height) = page.get_tightbbox(), page.get_size_inches()
    assert min(box.x0, box.y0, width - box.x1, height - box.y1) > -0.01
    if path is not None:
        assert np.mean((imread(path)[..., :3] < 0.9).any(axis=2)) > 0.01


def reading(array, shape=None, name="meter"):
    """What looks like a tally with this one quantity."""
    return SimpleNamespace(name=name, shape=shape, named=lambda quantity: array)
