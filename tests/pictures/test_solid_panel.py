"""Panels in space: places of text and things agree, what is in front hides what is behind, and nothing is left outside."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import Normalize, to_rgb

from transport.viz.screen import NoScreen, has_screen
from transport.viz.solid_panel import SolidPanel
from transport.viz.style import BLUE, VERMILLION, figure

needs_screen = pytest.mark.skipif(not has_screen(), reason="no OpenGL here")
SQUARE = np.array([(1, 1, 0), (1, -1, 0), (-1, -1, 0), (-1, 1, 0)])


def drawn(panel, **how):
    """The axes, and the colours (rows from above, columns, 3) of what the panel shows."""
    with figure((4, 4)) as page:
        axes = page.subplots()
        panel.show(axes, **how)
    [image] = axes.images
    return axes, np.asarray(image.get_array())


def colour_at(panel, axes, image, place):
    """The colour and opacity of the pixel at a place in space."""
    (x, y), (left, right), (low, high) = panel.projected(place), axes.get_xlim(), axes.get_ylim()
    rows, columns = image.shape[:2]
    return image[int((high - y) / (high - low) * rows), int((x - left) / (right - left) * columns)]


def is_alike(colour, name):
    return np.abs(colour[:3] / 255 - to_rgb(name)).max() < 0.03


@needs_screen
def test_things_stand_where_their_text_does():
    panel = SolidPanel(viewer=(1, -2, 1.5))
    panel.polygon(SQUARE, BLUE)
    panel.polygon(SQUARE + (0, 0, 2), VERMILLION)
    panel.text((0.9, 0.9, 2), "corner")
    axes, image = drawn(panel)
    assert is_alike(colour_at(panel, axes, image, (0.9, 0.9, 2)), VERMILLION)
    assert is_alike(colour_at(panel, axes, image, (0.9, -0.9, 0)), BLUE)
    [text] = axes.texts
    assert text.get_position() == pytest.approx(panel.projected((0.9, 0.9, 2)))


@needs_screen
def test_what_is_in_front_hides_what_is_behind():
    """Planted: a viewer on the other side sees the other one."""
    for viewer, seen in (((0, 0, 1), VERMILLION), ((0, 0, -1), BLUE)):
        panel = SolidPanel(viewer=viewer, up=(1, 0, 0))
        panel.polygon(SQUARE, BLUE)
        panel.polygon(SQUARE + (0, 0, 0.5), VERMILLION)
        axes, image = drawn(panel)
        assert is_alike(colour_at(panel, axes, image, (0.1, 0.1, 0.2)), seen)


@needs_screen
def test_parallel_lines_stay_parallel_and_lengths_across_the_view_are_true():
    panel = SolidPanel(viewer=(3, -4, 2))
    ends = panel.projected([(0, 0, 0), (0, 0, 1), (9, -12, 6), (9, -12, 7)])
    assert ends[1] - ends[0] == pytest.approx(ends[3] - ends[2])
    assert np.linalg.norm(panel.projected((4, 3, 0))) == pytest.approx(5.0)
    assert panel.projected((3, -4, 2)) == pytest.approx([0, 0])


@needs_screen
def test_limits_hold_all_that_is_drawn():
    panel = SolidPanel(viewer=(0, -1, 0))
    panel.line([(0, 0, 0), (2, 0, 0)], BLUE, 0.01)
    panel.loop(SQUARE, BLUE, 0.01, is_dashed=True)
    panel.arrow((0, 0, 0), (0, 0, 3), BLUE, 0.1, "up")
    panel.balls(np.zeros((0, 3)), BLUE, 0.1)
    panel.balls([(-2, 0, -1)], BLUE, 0.5)
    low, high = panel.limits(margin=0.0)
    assert low == pytest.approx([-2.5, -1.5], abs=0.05)
    assert high == pytest.approx([2.0, 3.0], abs=0.05)
    axes, image = drawn(panel, limits=[(-4, -4), (4, 4)])
    assert axes.get_xlim() == (-4, 4) and axes.get_ylim() == (-4, 4)
    assert not image[0, 0, 3] and not image[-1, -1, 3]  # the ground is left to the page


@needs_screen
def test_bins_have_the_colours_of_their_values():
    from matplotlib import colormaps

    panel = SolidPanel(viewer=(0, 0, 1), up=(0, 1, 0))
    x, y = np.meshgrid(np.arange(3.0), np.arange(3.0), indexing="ij")
    values = np.array([[0.0, 0.3], [0.6, 1.0]])
    panel.bins(np.stack([x, y, 0 * x], axis=-1), values, Normalize(0, 1))
    axes, image = drawn(panel)
    for i in range(2):
        for j in range(2):
            seen = colour_at(panel, axes, image, (i + 0.5, j + 0.5, 0))
            assert is_alike(seen, colormaps["inferno"](values[i, j])[:3])


def test_without_a_screen_it_says_what_is_missing(monkeypatch):
    def lacking():
        raise NoScreen("no OpenGL")

    monkeypatch.setattr("transport.viz.solid_panel.require_screen", lacking)
    with pytest.raises(NoScreen, match="no OpenGL"):
        SolidPanel(viewer=(1, 0, 0))
