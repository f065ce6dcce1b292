"""Notation of numbers: a value with its standard error, a ratio, a percentage, a duration."""

from __future__ import annotations

import math
import re

_POWERS_WITHOUT_EXPONENT = range(-4, 6)  # powers of ten that are written without an exponent
_DURATION_UNITS = (
    (365.25 * 86400, "years"),
    (86400, "days"),
    (3600, "h"),
    (60, "min"),
    (1, "s"),
    (1e-3, "ms"),
    (0, "µs"),
)
MAX_PRINTED_RATIO = 10_000  # a larger ratio is of no use to a reader, and not known to two digits
# fill, sign, width, number
_FORMAT = re.compile(r"((?:.?[<>^])?)([-+ ]?)(\d*)(?:s|([,_]?(?:\.\d+)?[eEfFgGn%]?))")


def plus_minus(value: float, error: float) -> str:
    """ "(18.44 ± 0.01)": two digits of the error where it begins with 1 or 2, one otherwise.

    value: finite;  error: finite and above zero.
    """
    leading, exponent = f"{error:.1e}".split("e")
    place = int(exponent) - (leading[0] in "12")  # the power of ten of the last digit shown
    error = round(error, -place)
    value = round(value, -place) + 0.0  # a zero without a minus sign
    power = math.floor(math.log10(max(abs(value), error)))
    if power in _POWERS_WITHOUT_EXPONENT:
        decimals = max(0, -place)
        return f"({value:.{decimals}f} ± {error:.{decimals}f})"
    decimals = max(0, power - place)
    scale = 10.0**power
    return f"({value / scale:.{decimals}f} ± {error / scale:.{decimals}f})e{power:+03d}"


def ratio_text(factor: float) -> str:
    """A ratio for a sentence: two digits, such as "2.5" or "3 800", and "over 10 000" from there on.

    Examples
    --------
    >>> ratio_text(2.51), ratio_text(3841.0), ratio_text(9999.0), ratio_text(3.7e7)
    ('2.5', '3 800', 'over 10 000', 'over 10 000')
    """
    if float(f"{factor:.2g}") >= MAX_PRINTED_RATIO:
        return f"over {with_thousands_spaces(MAX_PRINTED_RATIO)}"
    return f"{factor:.2g}" if factor < 99.5 else with_thousands_spaces(float(f"{factor:.2g}"))


def percent(error: float) -> str:
    """Relative error in percent, or as a power of ten if that is too small to read."""
    return f"{100 * error:.6g} %" if error >= 0.99e-6 else f"{error:.0e}"


def duration(seconds: float) -> str:
    """Duration with two digits, in a suitable unit."""
    length, unit = next(
        (length, unit) for length, unit in _DURATION_UNITS if seconds >= length * (2 if length >= 60 else 1)
    )
    number = seconds / (length or 1e-6)
    return f"{number:.0f} {unit}" if 99.5 <= number < 1e5 else f"{number:.2g} {unit}"


def with_thousands_spaces(number: float) -> str:
    """A whole number with spaces between groups of three digits."""
    return f"{number:,.0f}".replace(",", " ")


def estimate_text(
    value: float,
    error: float,
    unit: str,
    exact: bool,
    reason: str | None,
    number: str = "",
    sign: str = "",
    limit: str | None = None,
) -> str:
    """An estimate as text: with its error, or "(exact)", or the reason for an unknown error.

    number: format of value and error, such as ".3f"; by default the error determines it;  sign: "+", "-" or "
    ";  limit: text in place of an unknown error.
    """
    unit = "" if unit == "1" else f" {unit}"
    if reason is not None:
        return f"{value:{sign}{number or '.4g'}}{unit} ({limit or f'error unknown: {reason}'})"
    if exact:
        return f"{value:{sign}{number or '.7g'}}{unit} (exact)"
    if number or sign:
        number = number or ".7g"
        return f"({value:{sign}{number}} ± {error:{number}}){unit}"
    return plus_minus(value, error) + unit


def split_format(spec: str) -> tuple[str, str, str]:
    """Split ">40.3f" into the format of the text, ">40", that of its numbers, ".3f", and the value's sign.

    Raises ValueError for a specification of another form.
    """
    if not (match := _FORMAT.fullmatch(spec)):
        raise ValueError(f"Invalid format {spec!r} of an estimate; write it like '.3f', '>40' or '>40.3f'")
    fill, sign, width, number = match.groups(default="")
    return fill + width, number, sign
