"""A raster of numbers as a PNG of a few hundred bytes, written without an image library.

The colours are points of viridis and magma (Smith, van der Walt 2015), which work on light and dark pages.
"""

from __future__ import annotations

import base64
import struct
import zlib

import numpy as np

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
