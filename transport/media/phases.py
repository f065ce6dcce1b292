"""Phase functions of theory and of tables; densities per solid angle over the cosine of the scattering angle.

The isotropic one is `Isotropic()`, the emission of that name without an amount.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from transport.fields import ArrayField, Converted
from transport.media.base import Phase, digest_of, settled_array
from transport.validation import SceneError, as_float, as_floats, refuse, scene_object, shown, store

NEUTRAL = 1 / (4 * math.pi)  # [sr^-1]
ROUNDING = 16 * 2.0**-53  # of the integral of a table that has been normalised: a dozen roundings


@scene_object
class HenyeyGreenstein(Phase):
    """The phase function of Henyey and Greenstein (1941, ApJ 93, 70) with the mean cosine `g`, -1 < g < 1.

        p(mu) = (1 - g^2) / (4 pi (1 + g^2 - 2 g mu)^(3/2))   [sr^-1]

    g = 0 scatters isotropically, g near 1 forwards, g < 0 backwards.
    """

    g: float

    def __post_init__(self) -> None:
        number = as_float(self.g)
        if number is None or not -1 < number < 1:
            must = "g must be a number above -1 and below 1"
            refuse(self, f"{must}, got {shown(self.g)}; straight on (g = 1) is no scattering at all")
        store(self, g=number)

    def density(self, mu: np.ndarray | float) -> np.ndarray | float:
        """Density [sr^-1] at cosines mu; 1 + g^2 - 2 g mu without cancellation on either side."""
        g, mu = self.g, np.asarray(mu, float)
        forwards = (1 - g) * (1 - g) + 2 * g * (1 - mu)
        backwards = (1 + g) * (1 + g) - 2 * g * (1 + mu)
        chord = forwards if g >= 0 else backwards
        return NEUTRAL * (1 - g) * (1 + g) / (chord * np.sqrt(chord))


@scene_object
class Rayleigh(Phase):
    """Scattering of unpolarised light by what is small against the wavelength (Rayleigh 1871).

    p(mu) = 3 (1 + mu^2) / (16 pi)   [sr^-1],   g = 0
    """

    g = 0.0

    def density(self, mu: np.ndarray | float) -> np.ndarray | float:
        """Density [sr^-1] at cosines mu."""
        mu = np.asarray(mu, float)
        return 0.75 * NEUTRAL * (1 + mu * mu)


class PiecewiseLinear:
    """A function of the cosine that is linear between the points of a table: `values` [sr^-1] at `mu`."""

    def __init__(self, mu: np.ndarray, values: np.ndarray) -> None:
        self.mu, self.values = mu, values

    def __call__(self, mu: np.ndarray | float) -> np.ndarray | float:
        """Density [sr^-1] at cosines mu."""
        return np.interp(mu, self.mu, self.values)

    def __repr__(self) -> str:
        return f"{len(self.mu)} points"


@scene_object(kw_only=True)
class Tabulated(Phase):
    """A phase function of a table, as of Mie's theory: linear in the cosine between the points.

    mu: (n,) cosines of the scattering angle, rising from -1 (backwards) to 1 (straight on);  density: (n,) relative
    densities per solid angle, zero or positive, of any unit: they are normalised.  The arrays are copied and kept
    read-only; afterwards `density(mu)` is the density [sr^-1], `values` what it is at the points `mu`.
    """

    mu: ArrayField = field(compare=False, repr=False)
    density: Converted[ArrayLike, Callable[[Any], Any]] = field(compare=False)
    values: np.ndarray = field(init=False, compare=False, repr=False)
    g: float = field(init=False, compare=False)
    digest: bytes = field(init=False, repr=False)  # of the arrays' bytes: what equality and hash go by

    def __post_init__(self) -> None:
        relative = self.density.values if isinstance(self.density, PiecewiseLinear) else self.density
        mu = self._settled_mu()
        relative = settled_array(self, "density", relative, 1)
        if len(relative) != len(mu):
            refuse(self, f"density must have as many values as mu, {len(mu)}, got {len(relative)}")
        if not relative.any():
            refuse(self, "density must be positive somewhere, got zeros only")
        values = relative / relative.max()
        steps, sums = np.diff(mu), values[:-1] + values[1:]
        whole = math.pi * math.fsum(steps * sums)
        # A table that is normalised already is kept bit by bit, so that one of its values is the same table.
        values = relative if abs(whole * relative.max() - 1) <= ROUNDING else values / whole
        both = values[:-1] + values[1:]
        inner = steps * (mu[:-1] * (values[:-1] + both) + mu[1:] * (values[1:] + both))
        store(self, mu=mu, values=values, density=PiecewiseLinear(mu, values))
        store(self, g=math.pi / 3 * math.fsum(inner), digest=digest_of(mu, values))
        self._freeze()

    @classmethod
    def from_file(cls, path: str | PathLike) -> Tabulated:
        """The table of a text file of two columns: scattering angle, and relative intensity.

        The angle in degrees from 0 (straight on) to 180, or its cosine from -1 to 1, rising or falling: its range tells
        which.  Blanks or commas between the columns; "#" begins a remark.  Raises SceneError for anything else.
        """
        rows = _rows_of(path)
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        ends = rows[0, 0], rows[-1, 0]
        if ends == (0.0, 180.0):
            rows = np.stack([np.cos(np.radians(rows[:, 0])), rows[:, 1]], axis=1)[::-1]
        elif ends != (-1.0, 1.0):
            got = f"the first column of {str(path)!r} goes from {ends[0]:g} to {ends[1]:g}"
            cure = "write degrees from 0 to 180, or cosines from -1 to 1, both ends included"
            raise SceneError(f"Tabulated.from_file: {got}; {cure}")
        return cls(mu=rows[:, 0], density=rows[:, 1])

    def _settled_mu(self) -> np.ndarray:
        cosines = as_floats(self.mu)
        if cosines is None or len(cosines) < 2:
            refuse(self, f"mu must be two cosines or more, got {shown(self.mu)}")
        mu = np.array(cosines)
        if (np.diff(mu) <= 0).any():
            refuse(self, f"mu must rise from -1 to 1, got {shown(self.mu)}; sort both columns by mu")
        if (mu[0], mu[-1]) != (-1.0, 1.0):
            must = "mu must reach from -1 to 1"
            refuse(self, f"{must}, got {mu[0]} to {mu[-1]}; add the densities straight on and backwards")
        return mu

    def _freeze(self) -> None:
        for array in (self.mu, self.values):
            array.flags.writeable = False

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._freeze()


def _rows_of(path: str | PathLike) -> np.ndarray:
    """The numbers (n, 2) of a text file; SceneError with the line that is wrong."""
    title = "Tabulated.from_file"
    try:
        with open(path, encoding="utf-8-sig") as file:
            lines = [line.split("#")[0].replace(",", " ").replace(";", " ").split() for line in file]
    except (OSError, UnicodeDecodeError, TypeError) as error:
        raise SceneError(f"{title}: {shown(path)} cannot be read: {error}; name a text file") from None
    rows = []
    for number, words in enumerate(lines, start=1):
        if not words:
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            row = []
        if len(row) != 2 or not all(map(math.isfinite, row)):
            cure = "write an angle and an intensity, and # before remarks"
            raise SceneError(
                f"{title}: line {number} of {str(path)!r} must be two numbers, got {shown(' '.join(words))}; {cure}"
            )
        rows.append(row)
    if len(rows) < 2:
        raise SceneError(f"{title}: {str(path)!r} must hold two lines of numbers or more, got {len(rows)}")
    return np.array(rows)
