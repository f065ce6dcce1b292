"""Units: SI constants, conversion factors for input and output, and units as powers of symbols."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

speed_of_light = 299792458.0  # m s^-1, exact by the definition of the metre (SI Brochure 2019, 2.2)
BOLTZMANN = 1.380649e-23  # J K^-1, exact by the definition of the kelvin (SI Brochure 2019, 2.2)

pm, nm, um, mm, cm, km = 1e-12, 1e-9, 1e-6, 1e-3, 1e-2, 1e3  # m
au = 1.495978707e11  # m, exact by definition (IAU 2012, resolution B2)
fs, ps, ns, us, ms = 1e-15, 1e-12, 1e-9, 1e-6, 1e-3  # s
minute, hour, day = 60.0, 3600.0, 86400.0  # s
deg = math.pi / 180  # rad
arcmin, arcsec, mrad = deg / 60, deg / 3600, 1e-3  # rad

_PRINT_ORDER = ("W", "J", "lm", "cd", "s", "m", "sr")  # order in text; other symbols follow alphabetically
_FACTOR = re.compile(r"\s*([/*]?)\s*(1|[A-Za-z]+)(?:\^\(?(-?\d+(?:/\d+)?)\)?)?")


class UnitError(TypeError):
    """Error raised if quantities of different units are added, or a plain number to one with a unit."""


@dataclass(frozen=True)
class Unit:
    """A unit: a product of powers of symbols, such as W m^-2 sr^-1; `Unit()` is dimensionless.

    Units support `*`, `/`, `**` and comparison.

    Parameters
    ----------
    powers : tuple of (str, Fraction), default ()
        Pairs (symbol, exponent) in any order.

    Notes
    -----
    W s and J are the same unit, so that equal units compare equal.

    Examples
    --------
    >>> import transport as tp
    >>> irradiance = tp.Unit.parse("W m^-2")
    >>> irradiance * tp.Unit.parse("m^2")
    Unit('W')
    >>> tp.Unit.parse("J/s") == tp.Unit.parse("W")
    True
    """

    powers: tuple[tuple[str, Fraction], ...] = ()

    def __post_init__(self) -> None:
        totals: dict[str, Fraction] = {}
        for symbol, exponent in self.powers:
            totals[symbol] = totals.get(symbol, Fraction(0)) + Fraction(exponent)
        totals = _normalize_watts_and_joules(totals)
        powers = sorted(((s, e) for s, e in totals.items() if e != 0), key=_print_key)
        object.__setattr__(self, "powers", tuple(powers))

    @classmethod
    @cache
    def parse(cls, text: str) -> Unit:
        """Parse a unit from text.

        Parameters
        ----------
        text : str
            Such as "W m^-2 sr^-1", "W/m^2" or "1"; a "/" applies to the one symbol after it.

        Returns
        -------
        Unit

        Raises
        ------
        UnitError
            If the text cannot be parsed.
        """
        powers, end = [], 0
        while match := _FACTOR.match(text, end):
            sign = -1 if match[1] == "/" else 1
            powers.append((match[2], sign * Fraction(match[3] or 1)))
            end = match.end()
        if not powers or text[end:].strip():
            raise UnitError(f"Cannot parse the unit {text!r}; write it like 'W m^-2 sr^-1', or '1' for none")
        return cls(tuple((symbol, exponent) for symbol, exponent in powers if symbol != "1"))

    @property
    def is_dimensionless(self) -> bool:
        """Whether no symbol is left.

        Returns
        -------
        bool
        """
        return not self.powers

    def __mul__(self, other: Unit) -> Unit:
        return Unit(self.powers + other.powers) if isinstance(other, Unit) else NotImplemented

    def __truediv__(self, other: Unit) -> Unit:
        return self * other**-1 if isinstance(other, Unit) else NotImplemented

    def __pow__(self, exponent: float) -> Unit:
        exponent = Fraction(exponent).limit_denominator(1000)
        return Unit(tuple((symbol, power * exponent) for symbol, power in self.powers))

    def __str__(self) -> str:
        return " ".join(_format_power(*power) for power in self.powers) or "1"

    def __repr__(self) -> str:
        return f"Unit({str(self)!r})"


def _normalize_watts_and_joules(totals: dict[str, Fraction]) -> dict[str, Fraction]:
    """Normalize W, J and s: W s becomes J, and J s^-1 becomes W.

    As many watts are kept as there are joules per second, and no more.
    """
    energy = totals.get("J", Fraction(0)) + totals.get("W", Fraction(0))
    time = totals.get("s", Fraction(0)) - totals.get("W", Fraction(0))
    watts = Fraction(0)
    if energy * time < 0:
        watts = min(energy, -time) if energy > 0 else max(energy, -time)
    return totals | {"W": watts, "J": energy - watts, "s": time + watts}


def _print_key(power: tuple[str, Fraction]) -> tuple[bool, int, str]:
    symbol, exponent = power
    return exponent < 0, _PRINT_ORDER.index(symbol) if symbol in _PRINT_ORDER else len(_PRINT_ORDER), symbol


def _format_power(symbol: str, exponent: Fraction) -> str:
    if exponent == 1:
        return symbol
    return f"{symbol}^{exponent}" if exponent.denominator == 1 else f"{symbol}^({exponent})"
