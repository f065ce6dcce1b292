"""The library's text as HTML, with typographic minus signs, powers of ten and exponents."""

from __future__ import annotations

import html
import re

_POWER_OF_TEN = re.compile(r"(?<=[\d)])e([+-]\d+)")
_MINUS = re.compile(r"(?<![\w.)])-(?=[\d.]|inf)")
_EXPONENT = re.compile(r"(?<=[A-Za-z])\^(?:\((-?\d+/\d+)\)|(-?\d+))")
_RAISED = str.maketrans("-0123456789/", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹⸍")

SYMBOLS = {"mu": "μ", "theta": "θ", "phi": "φ"}


def escaped(text: object) -> str:
    """Any text as HTML with special characters escaped: a name may be "<b>"."""
    return html.escape(str(text), quote=True)


def typeset(text: object) -> str:
    """Text with numbers and units, such as "(2.0 ± 0.3)e-09 W m^-2", as HTML."""
    said = _POWER_OF_TEN.sub(lambda hit: f"\u00a0×\u00a010<sup>{_minus(int(hit[1]))}</sup>", escaped(text))
    said = _EXPONENT.sub(lambda hit: f"<sup>{_minus(hit[1] or hit[2])}</sup>", said)
    return _MINUS.sub("−", said)


def plain_typeset(text: object) -> str:
    """The same without HTML elements, for text in an SVG: exponents are superscript characters."""
    said = _POWER_OF_TEN.sub(lambda hit: f"\u00a0×\u00a010{_raised(int(hit[1]))}", escaped(text))
    said = _EXPONENT.sub(lambda hit: _raised(hit[1] or hit[2]), said)
    return _MINUS.sub("−", said)


def symbol_of(axis: str) -> str:
    """The printed symbol of an axis."""
    return SYMBOLS.get(axis, axis)


def _minus(number: object) -> str:
    return str(number).replace("-", "−")


def _raised(number: object) -> str:
    return str(number).translate(_RAISED)
