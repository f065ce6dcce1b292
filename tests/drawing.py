"""What a figure shows, for tests of pictures: its words, its points with bars, and whether all of it is inside."""

from __future__ import annotations

import math
from types import SimpleNamespace

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.image import imread

from tests.synthetic import EVEN_RUN
from transport.statistics.estimates import EstimateArray


def words(page: Figure) -> str:
    """All that a figure says."""
    return "\n".join(text.get_text() for text in page.findobj(matplotlib.text.Text))


def points_of(axes) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """x, y and half bars of each series of points with bars."""
    found = []
    for container in axes.containers:
        line, _, (bars,) = container.lines
        lengths = np.array(bars.get_segments())[:, :, 1]
        found.append((*line.get_data(), (lengths[:, 1] - lengths[:, 0]) / 2))
    return found


def assert_drawn(page: Figure, path=None) -> None:
    """No label is cut off at an edge; the file, if there is one, has more than one colour on white."""
    page.draw_without_rendering()  # so that the layout is done
    box, (width, height) = page.get_tightbbox(), page.get_size_inches()
    assert min(box.x0, box.y0, width - box.x1, height - box.y1) > -0.01
    if path is not None:
        assert np.mean((imread(path)[..., :3] < 0.9).any(axis=2)) > 0.01


def estimates(values, dims, edges, unit="W m^-2 sr^-1", relative=0.1, counts=None):
    """An array of these values with these relative standard errors; nothing was counted where it is 0."""
    values = np.asarray(values, dtype=float)
    signs = math.sqrt(31) * np.tile([-1.0, 1.0], 16).reshape(-1, *(1,) * values.ndim)
    coords = dict(zip(dims, map(np.asarray, edges), strict=True))
    counts = values != 0 if counts is None else counts
    return EstimateArray(values * (1 + relative * signs), EVEN_RUN, unit, dims, coords, counts=counts)


def reading(array, shape=None, name="meter"):
    """What looks like a tally with this one quantity."""
    return SimpleNamespace(name=name, shape=shape, named=lambda quantity: array)
