"""Labels of axes and positions of bins, in a few words."""

from __future__ import annotations

import math

import numpy as np

from transport.html.typesetting import plain_typeset, symbol_of
from transport.results.estimates import AXIS_UNITS

ANGLES = ("theta", "phi")


def axis_words(name: str) -> str:
    """The label of an axis, with its unit if it has one: "φ [°]", "time [s]"."""
    unit = "°" if name in ANGLES else AXIS_UNITS.get(name, "1")
    return plain_typeset(symbol_of(name)) + (f" [{plain_typeset(unit)}]" if unit != "1" else "")


def place_text(name: str, place: float) -> str:
    """A position on the axis as a number; angles in degrees."""
    number = math.degrees(place) if name in ANGLES else float(place)
    return plain_typeset(f"{number + 0.0:.4g}")


def bin_text(name: str, edges: np.ndarray, number: int, bins: int) -> str:
    """The range of a bin, "0.5 … 0.6", or its instant."""
    if len(edges) == bins:
        return place_text(name, edges[number])
    return f"{place_text(name, edges[number])} … {place_text(name, edges[number + 1])}"
