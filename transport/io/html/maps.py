"""Estimates over two axes as a small SVG.

A map of the values beside a map of their relative standard errors.
"""

from __future__ import annotations

import base64
import struct
import zlib

import numpy as np

from transport.io.html.charts import (
    LOGARITHMIC_RATIO,
    axis_label,
    block_edges,
    block_means,
    position_text,
    svg_text,
)
from transport.io.html.elements import plain_typeset

# ---- A raster of numbers as a PNG of a few hundred bytes, written without an image library.
#
# The colours are points of viridis and magma (Smith, van der Walt 2015), which work on light and dark pages.

VIRIDIS = ("440154", "482878", "3e4989", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725")
MAGMA = ("221150", "5f187f", "982d80", "d3436e", "f8765c", "febb81", "fcfdbf")
BLANK = 255  # index of the transparent colour, for unknown values
SHADES = 255


def shade(numbers: np.ndarray, low: float, high: float) -> np.ndarray:
    """Indices of colours, from 0 at `low` to the last at `high`; BLANK for values that are not finite."""
    width = high - low
    places = np.clip((numbers - low) / width, 0.0, 1.0) if width > 0 else np.zeros(np.shape(numbers))
    return np.where(np.isfinite(numbers), np.nan_to_num(places) * (SHADES - 1) + 0.5, BLANK).astype(np.uint8)


def png_url(shades: np.ndarray, colours: tuple[str, ...]) -> str:
    """Encode colour indices (rows from the top, columns) as a PNG in a data URL."""
    rows, columns = shades.shape
    lines = np.zeros((rows, columns + 1), np.uint8)  # each begins with its filter type: 0, none
    lines[:, 1:] = shades
    parts = [
        _chunk(b"IHDR", struct.pack(">2I5B", columns, rows, 8, 3, 0, 0, 0)),
        _chunk(b"PLTE", _palette(colours)),
        _chunk(b"tRNS", b"\xff" * BLANK + b"\x00"),
        _chunk(b"IDAT", zlib.compress(lines.tobytes(), 9)),
        _chunk(b"IEND", b""),
    ]
    whole = b"\x89PNG\r\n\x1a\n" + b"".join(parts)
    return "data:image/png;base64," + base64.b64encode(whole).decode("ascii")


def _palette(colours: tuple[str, ...]) -> bytes:
    """256 colours interpolated between the given ones; the last one is BLANK."""
    points = np.array([list(bytes.fromhex(colour)) for colour in colours], dtype=float)
    places = np.linspace(0, len(points) - 1, SHADES)
    mixed = np.stack([np.interp(places, np.arange(len(points)), points[:, c]) for c in range(3)], axis=1)
    return mixed.round().astype(np.uint8).tobytes() + bytes(3)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


# ---- The maps.

MAX_CELLS = 96
WIDTH, TALL, LOW, GAP, LEFT, TOP, BELOW = 190, 190, 80, 24, 52, 18, 52
VERTICAL_AXES = ("mu", "theta", "v")  # vertical axes if they come first; all others are horizontal
TOP_DOWN_AXES = ("theta",)  # axes with their small end on top: the zenith
POLAR_AXES = ("mu", "theta")  # of a map of directions beside an azimuth, which grows to the left
EQUAL_WIDTH_TOLERANCE = 1e-6  # relative spread of bin widths that are drawn as equal
AXES_TO_SCALE = ({"u", "v"}, {"x", "y"}, {"x", "z"}, {"y", "z"})  # pairs of axes drawn to scale


def value_and_error_maps(
    value: np.ndarray, relative: np.ndarray, names: tuple[str, str], edges: list[np.ndarray], unit: str
) -> str:
    """The maps as SVG; value, relative (relative standard errors): (*names)."""
    if names[0] not in VERTICAL_AXES:
        value, relative, names, edges = value.T, relative.T, names[::-1], edges[::-1]
    most = (MAX_CELLS, MAX_CELLS)
    (means, sizes), (errors, _) = block_means(value, most), block_means(relative, most)
    means, errors = (_resampled_to_scale(numbers, edges, value.shape, sizes) for numbers in (means, errors))
    tall = _map_height(names, edges, value.shape)
    unit = f" [{unit}]" if unit != "1" else ""
    panels = [(means, VIRIDIS, f"value{unit}", 1.0)]
    if relative[np.isfinite(relative)].any():  # otherwise the values are exact, or no error is known
        panels.append((errors, MAGMA, "relative standard error [%]", 100.0))
    drawn = [
        _panel(LEFT + k * (WIDTH + GAP), tall, numbers * times, names, edges, colours, title)
        for k, (numbers, colours, title, times) in enumerate(panels)
    ]
    width, height = LEFT + len(panels) * (WIDTH + GAP) + 12, TOP + tall + BELOW
    blocks = f"; each cell is the mean of {' × '.join(map(str, sizes))} bins" if max(sizes) > 1 else ""
    return (
        f'<svg width="{width}" height="{height}" viewBox="0 0 {width} {height}" role="img"'
        f' fill="currentColor" font-size="11"><title>values and their relative standard errors; blank:'
        f" not known{blocks}</title>"
        f"{_vertical_axis(names[0], edges[0], tall)}{''.join(drawn)}</svg>"
    )


def map_thumbnail(value: np.ndarray, names: tuple[str, str], edges: list[np.ndarray]) -> str:
    """The map of the values alone, as high as a line of text."""
    if names[0] not in VERTICAL_AXES:
        value, names, edges = value.T, names[::-1], edges[::-1]
    means, sizes = block_means(value, (20, 110))
    means = _resampled_to_scale(means, edges, value.shape, sizes)
    rows, columns = value.shape
    width = min(max(round(20 * columns / rows), 20), 110) if set(names) in AXES_TO_SCALE else 110
    picture = _image(0, 0, width, 20, _in_image_order(means, names), VIRIDIS)[0]
    return f'<svg width="{width}" height="20" role="img">{picture}</svg>'


def _resampled_to_scale(
    numbers: np.ndarray, edges: list[np.ndarray], shape: tuple, sizes: tuple
) -> np.ndarray:
    """Resample blocks of unequal bins to a raster of WIDTH cells.

    Equal bins, instants and infinite ones stay.
    """
    share = (np.arange(WIDTH) + 0.5) / WIDTH
    for axis, (along, bins, size) in enumerate(zip(edges, shape, sizes, strict=True)):
        widths = np.diff(along)
        if len(widths) != bins or not np.isfinite(widths).all() or _have_equal_widths(widths):
            continue
        ends = block_edges(along, bins, size)
        places = along[0] + share * (along[-1] - along[0])
        numbers = np.take(numbers, np.searchsorted(ends, places, side="right") - 1, axis)
    return numbers


def _have_equal_widths(widths: np.ndarray) -> bool:
    return bool(np.ptp(widths) <= EQUAL_WIDTH_TOLERANCE * widths.max())


def _panel(x: float, tall: float, numbers: np.ndarray, names, edges, colours, title: str) -> str:
    """One map with its title, the ends of the axis below it, and its colour scale."""
    picture, low, high, is_log = _image(x, TOP, WIDTH, tall, _in_image_order(numbers, names), colours)
    y, note = TOP + tall, ", log" if is_log else ""
    left, right = edges[1][0], edges[1][-1]
    if has_azimuth_to_the_left(names):
        left, right = right, left
    ramp = png_url(np.arange(255, dtype=np.uint8)[None, :], colours)
    return "".join(
        [
            svg_text(x, 12, "start", plain_typeset(title + note)),
            picture,
            f'<rect x="{x}" y="{TOP}" width="{WIDTH}" height="{tall}" fill="none" stroke="currentColor"'
            ' opacity=".35"/>',
            svg_text(x, y + 13, "start", position_text(names[1], left)),
            svg_text(x + WIDTH / 2, y + 13, "middle", axis_label(names[1]) + azimuth_note(names)),
            svg_text(x + WIDTH, y + 13, "end", position_text(names[1], right)),
            f'<image x="{x}" y="{y + 22}" width="{WIDTH}" height="8" preserveAspectRatio="none"'
            f' href="{ramp}"/>',
            svg_text(x, y + 43, "start", plain_typeset(f"{low:.3g}")),
            svg_text(x + WIDTH, y + 43, "end", plain_typeset(f"{high:.3g}")),
        ]
    )


def _image(x, y, width, height, numbers: np.ndarray, colours) -> tuple[str, float, float, bool]:
    """The image itself, the ends of its scale, and whether the scale is logarithmic."""
    known = numbers[np.isfinite(numbers)]
    low, high = (known.min(), known.max()) if known.size else (0.0, 0.0)
    positive = known[known > 0]
    is_log = bool(low >= 0 and positive.size and high > LOGARITHMIC_RATIO * positive.min())
    if is_log:
        low = max(positive.min(), high * 1e-6)
        with np.errstate(divide="ignore"):
            logarithms = np.log(np.where(numbers > 0, np.fmax(numbers, low), np.nan))
        shades = shade(logarithms, np.log(low), np.log(high))
    else:
        low = min(low, 0.0) if low < 0.5 * high else low
        shades = shade(numbers, low, high)
    picture = (
        f'<image x="{x}" y="{y}" width="{width}" height="{height}" preserveAspectRatio="none"'
        f' style="image-rendering:pixelated" href="{png_url(shades, colours)}"/>'
    )
    return picture, float(low), float(high), is_log


def _in_image_order(numbers: np.ndarray, names: tuple[str, str]) -> np.ndarray:
    """Arrange rows from the top and columns from the left."""
    upright = numbers if names[0] in TOP_DOWN_AXES else numbers[::-1]
    return upright[:, ::-1] if has_azimuth_to_the_left(names) else upright


def has_azimuth_to_the_left(names: tuple[str, str]) -> bool:
    """Return whether it is a map of directions, by polar angle and azimuth."""
    return names[0] in POLAR_AXES and names[1] == "phi"


def azimuth_note(names: tuple[str, str]) -> str:
    """Return what follows the label of the azimuth of a map with the zenith on top.

    With bins of mu it is empty: they may be directions of flight, as in a volume.
    """
    return ", seen from inside" if names == ("theta", "phi") else ""


def _vertical_axis(name: str, edges: np.ndarray, tall: float) -> str:
    """The vertical axis on the left: its ends, and its name between them."""
    words = axis_label(name)
    turned = (
        f'<text transform="translate({LEFT - 34} {TOP + tall / 2:.1f}) rotate(-90)"'
        f' text-anchor="middle">{words}</text>'
    )
    top, bottom = (edges[0], edges[-1]) if name in TOP_DOWN_AXES else (edges[-1], edges[0])
    return "".join(
        [
            svg_text(LEFT - 4, TOP + 9, "end", position_text(name, top)),
            svg_text(LEFT - 18, TOP + tall / 2 + 4, "end", words) if len(words) < 3 else turned,
            svg_text(LEFT - 4, TOP + tall, "end", position_text(name, bottom)),
        ]
    )


def _map_height(names: tuple[str, str], edges: list[np.ndarray], shape: tuple[int, int]) -> float:
    """The height that draws both axes to scale if they have one unit, else a fixed one."""
    if set(names) not in AXES_TO_SCALE:
        return 110.0
    tall, wide = (float(abs(along[-1] - along[0])) for along in edges)
    return min(max(WIDTH * tall / wide, LOW), TALL) if wide > 0 else float(LOW)
