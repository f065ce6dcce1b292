"""Phase functions: analytic and tabulated densities over the cosine of the scattering angle.

The isotropic phase function is `Isotropic()`, the emission of that name without an amount.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from transport.validation import (
    MASKED_VALUES_HINT,
    ArrayField,
    Converted,
    SceneError,
    as_float,
    as_floats,
    is_masked,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)

# ---- Base class of phase functions, and immutable arrays that are compared by content.


class Phase:
    """Base class of phase functions; not instantiated directly.

    A phase function is a density of directions over the cosine mu of the scattering angle: `density(mu)`
    [sr^-1] integrates to 1 over the sphere, and `g` is the mean cosine.
    """

    is_phase = True  # False for an Isotropic with an amount, which is an emission only
    g: float  # mean cosine of the scattering angle

    def density(self, mu: np.ndarray | float) -> np.ndarray | float:
        """Return the phase function at cosines mu of the scattering angle.

        Parameters
        ----------
        mu : float or array
            Cosines of the scattering angle, from -1 (backward) to 1 (forward).

        Returns
        -------
        float or array
            Density per solid angle [sr^-1], of the shape of mu.
        """
        raise NotImplementedError

    @property
    def law(self) -> str:
        """Name of its law in the engine, which has passes `scatter_<law>` and `add_<law>_pdf`."""
        raise NotImplementedError(f"{type(self).__name__} has no law in the engine")

    @property
    def parameter(self) -> float:
        """The number by which its law is told from others of the same name; the mean cosine by default."""
        return self.g

    @property
    def max_density(self) -> float:
        """Greatest density [sr^-1]."""
        raise NotImplementedError(f"{type(self).__name__} does not state its greatest density")

    @property
    def weighted_parts(self) -> tuple[tuple[Phase, float], ...]:
        """The phase functions of a mixture with their shares; else itself, with the share 1."""
        return ((self, 1.0),)


def is_phase(value: object) -> bool:
    """Return whether a value is a phase function."""
    return isinstance(value, Phase) and value.is_phase


def coerce_phase(subject: object, value: object) -> Phase:
    """Return the phase function of a medium; raise SceneError for anything else."""
    if is_phase(value):
        return value
    if isinstance(value, type) and issubclass(value, Phase):
        refuse(subject, f"phase must be an instance, got the class {value.__name__}; write phase=...(...)")
    if isinstance(value, Phase):
        kind = type(value).__name__
        cure = "leave its amount out" if kind == "Isotropic" else "mix phases, not materials"
        refuse(subject, f"phase must be a phase function, got {short_repr(value)}; {cure}")
    refuse(
        subject, f"phase must be one such as HenyeyGreenstein(g=0.9) or Isotropic(), got {short_repr(value)}"
    )


def coerce_array(subject: object, name: str, value: object, dims: int) -> np.ndarray:
    """Return a read-only copy of an array with `dims` dimensions.

    Raises SceneError if a value is negative, not finite or masked.
    """
    # Check type and shape.
    if is_masked(value):
        got = f"{np.ma.count_masked(value)} of {value.size} values masked"
        refuse(subject, f"{name} must have all its values, got {got}; {MASKED_VALUES_HINT}")
    try:
        given = np.asarray(value)
    except (ValueError, TypeError):
        given = None
    if given is None or given.dtype.kind not in "iuf":
        refuse(subject, f"{name} must be an array of numbers, got {short_repr(value)}")
    if given.ndim != dims:
        refuse(subject, f"{name} must have {dims} dimension{'s' * (dims > 1)}, got shape {given.shape}")
    if given.size == 0:
        refuse(subject, f"{name} must not be empty, got shape {given.shape}")
    # Copy, and name the first invalid value.
    array = np.array(given, dtype=np.float64, order="C")
    wrong = ~((array >= 0) & (array < math.inf))
    if wrong.any():
        place = tuple(int(k) for k in np.argwhere(wrong)[0])
        where = place if dims > 1 else place[0]
        refuse(subject, f"{name} must be zero or positive, and finite, got {array[place]} at {where}")
    array += 0.0  # -0.0 becomes 0.0
    array.flags.writeable = False
    return array


def digest_of(*arrays: np.ndarray) -> bytes:
    """Return a digest of 16 bytes of the contents of arrays, used for equality and hash."""
    code = hashlib.blake2b(digest_size=16)
    for array in arrays:
        code.update(repr((array.shape, any(array.strides))).encode())
        code.update(array if any(array.strides) else array.flat[0].tobytes())
    return code.digest()


# ---- The phase functions.

ISOTROPIC_DENSITY = 1 / (4 * math.pi)  # isotropic density [sr^-1]
NORMALISATION_TOLERANCE = 16 * 2.0**-53  # tolerance of a normalised table's integral: a dozen roundings


@scene_object
class HenyeyGreenstein(Phase):
    """The phase function of Henyey and Greenstein.

    Parameters
    ----------
    g : float
        Mean cosine of the scattering angle, -1 < g < 1: 0 is isotropic, near 1 forward, negative
        backward.

    Raises
    ------
    SceneError
        If g is not in (-1, 1).

    Notes
    -----
    Henyey and Greenstein (1941, ApJ 93, 70)::

        p(mu) = (1 - g^2) / (4 pi (1 + g^2 - 2 g mu)^(3/2))   [sr^-1]

    Examples
    --------
    >>> import transport as tp
    >>> round(float(tp.HenyeyGreenstein(0.75).density(1.0)), 4)  # forward [sr^-1]
    2.2282
    """

    g: float

    def __post_init__(self) -> None:
        number = as_float(self.g)
        if number is None or not -1 < number < 1:
            must = "g must be a number above -1 and below 1"
            cure = (
                "g = 1 (forward) means no scattering" if number == 1 else "write g=0.9 for forward scattering"
            )
            refuse(self, f"{must}, got {short_repr(self.g)}; {cure}")
        set_fields(self, g=number)

    @property
    def law(self) -> str:
        return "henyey_greenstein" if self.g else "isotropic"

    @property
    def max_density(self) -> float:
        return float(self.density(math.copysign(1.0, self.g)))

    def density(self, mu: np.ndarray | float) -> np.ndarray | float:
        """Return the phase function at cosines mu of the scattering angle.

        Parameters
        ----------
        mu : float or array
            Cosines of the scattering angle, from -1 (backward) to 1 (forward).

        Returns
        -------
        float or array
            Density per solid angle [sr^-1], of the shape of mu.

        Notes
        -----
        1 + g^2 - 2 g mu is computed without cancellation for either sign of g.
        """
        g, mu = self.g, np.asarray(mu, float)
        forwards = (1 - g) * (1 - g) + 2 * g * (1 - mu)
        backwards = (1 + g) * (1 + g) - 2 * g * (1 + mu)
        chord = forwards if g >= 0 else backwards
        return ISOTROPIC_DENSITY * (1 - g) * (1 + g) / (chord * np.sqrt(chord))


@scene_object
class Rayleigh(Phase):
    """The Rayleigh phase function: unpolarised light scattered by particles small against the wavelength.

    Notes
    -----
    Rayleigh (1871)::

        p(mu) = 3 (1 + mu^2) / (16 pi)   [sr^-1],   g = 0

    Examples
    --------
    >>> import transport as tp
    >>> tp.Rayleigh().density([-1, 0, 1]).round(4)  # [sr^-1]
    array([0.1194, 0.0597, 0.1194])
    """

    g, law = 0.0, "rayleigh"
    max_density = 1.5 * ISOTROPIC_DENSITY

    def density(self, mu: np.ndarray | float) -> np.ndarray | float:
        """Return the phase function at cosines mu of the scattering angle.

        Parameters
        ----------
        mu : float or array
            Cosines of the scattering angle, from -1 (backward) to 1 (forward).

        Returns
        -------
        float or array
            Density per solid angle [sr^-1], of the shape of mu.
        """
        mu = np.asarray(mu, float)
        return 0.75 * ISOTROPIC_DENSITY * (1 + mu * mu)


class PiecewiseLinear:
    """A piecewise linear function of the cosine through the points (`mu`, `values` [sr^-1])."""

    def __init__(self, mu: np.ndarray, values: np.ndarray) -> None:
        self.mu, self.values = mu, values

    def __call__(self, mu: np.ndarray | float) -> np.ndarray | float:
        """Return the density [sr^-1] at cosines mu."""
        return np.interp(mu, self.mu, self.values)

    def __repr__(self) -> str:
        return f"{len(self.mu)} points"


@scene_object(kw_only=True)
class Tabulated(Phase):
    """A tabulated phase function, as from Mie theory: linear in the cosine between the points.

    All parameters are keywords.

    Parameters
    ----------
    mu : array (n,)
        Cosines of the scattering angle, increasing from -1 (backward) to 1 (forward).
    density : array (n,)
        Relative density per solid angle, zero or positive, in any unit; it is normalised.

    Raises
    ------
    SceneError
        If mu does not increase from -1 to 1, or if the density is negative or all zero.

    Notes
    -----
    Arrays are copied and read-only. Afterwards `density(mu)` returns the density per solid angle [sr^-1],
    `values` is the density at the points `mu`, and `g` is the mean cosine of the scattering angle.

    Examples
    --------
    >>> import transport as tp
    >>> phase = tp.Tabulated(mu=[-1, 0, 1], density=[0, 1, 2])
    >>> round(phase.g, 4)
    0.3333
    >>> phase.values.round(4)  # [sr^-1]
    array([0.    , 0.0796, 0.1592])
    """

    mu: ArrayField = field(compare=False, repr=False)
    density: Converted[ArrayLike, Callable[[Any], Any]] = field(compare=False)
    values: np.ndarray = field(init=False, compare=False, repr=False)
    g: float = field(init=False, compare=False)
    digest: bytes = field(init=False, repr=False)  # of the arrays, for equality and hash

    law = "tabulated"

    @property
    def max_density(self) -> float:
        return float(np.max(self.values))

    def __post_init__(self) -> None:
        # Read the columns, and check them.
        relative = self.density.values if isinstance(self.density, PiecewiseLinear) else self.density
        mu = self._coerced_mu()
        relative = coerce_array(self, "density", relative, 1)
        if len(relative) != len(mu):
            refuse(self, f"density must have as many values as mu, {len(mu)}, got {len(relative)}")
        if not relative.any():
            refuse(self, "density must be positive somewhere, got zeros only")
        # Normalise the density: its integral over the sphere is 2 pi times that over mu (trapezoids).
        values = relative / relative.max()
        steps, sums = np.diff(mu), values[:-1] + values[1:]
        whole = math.pi * math.fsum(steps * sums)
        # Keep a normalised table bit by bit, so that a table made from its values is equal.
        values = relative if abs(whole * relative.max() - 1) <= NORMALISATION_TOLERANCE else values / whole
        # Compute the mean cosine, exactly for linear pieces.
        both = values[:-1] + values[1:]
        inner = steps * (mu[:-1] * (values[:-1] + both) + mu[1:] * (values[1:] + both))
        set_fields(self, mu=mu, values=values, density=PiecewiseLinear(mu, values))
        set_fields(self, g=math.pi / 3 * math.fsum(inner), digest=digest_of(mu, values))
        self._freeze()

    @classmethod
    def from_file(cls, path: str | PathLike) -> Tabulated:
        """Read a table from a text file of two columns: scattering angle and relative intensity.

        Parameters
        ----------
        path : str or PathLike
            Columns separated by blanks or commas; "#" starts a comment. The first column is the angle from
            0 (forward) to 180 degrees, or its cosine from -1 to 1, increasing or decreasing; its range
            decides.

        Returns
        -------
        Tabulated

        Raises
        ------
        SceneError
            If the file cannot be read or has another form.
        """
        rows = _read_rows(path)
        # Sort by the first column, and distinguish angles from cosines by its range.
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        ends = rows[0, 0], rows[-1, 0]
        if ends == (0.0, 180.0):
            rows = np.stack([np.cos(np.radians(rows[:, 0])), rows[:, 1]], axis=1)[::-1]
        elif ends != (-1.0, 1.0):
            got = f"the first column of {str(path)!r} goes from {ends[0]:g} to {ends[1]:g}"
            cure = "write degrees from 0 to 180, or cosines from -1 to 1, both ends included"
            raise SceneError(f"Tabulated.from_file: {got}; {cure}")
        return cls(mu=rows[:, 0], density=rows[:, 1])

    def _coerced_mu(self) -> np.ndarray:
        cosines = as_floats(self.mu)
        if cosines is None or len(cosines) < 2:
            refuse(self, f"mu must have two cosines or more, got {short_repr(self.mu)}")
        mu = np.array(cosines)
        if (np.diff(mu) <= 0).any():
            refuse(self, f"mu must increase from -1 to 1, got {short_repr(self.mu)}; sort both columns by mu")
        if (mu[0], mu[-1]) != (-1.0, 1.0):
            must = "mu must reach from -1 to 1"
            refuse(self, f"{must}, got {mu[0]} to {mu[-1]}; add the forward and backward densities")
        return mu

    def _freeze(self) -> None:
        for array in (self.mu, self.values):
            array.flags.writeable = False

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._freeze()


def _read_rows(path: str | PathLike) -> np.ndarray:
    """Read an array (n, 2) from a text file; the SceneError names the invalid line."""
    title = "Tabulated.from_file"
    try:
        with open(path, encoding="utf-8-sig") as file:
            lines = [line.split("#")[0].replace(",", " ").replace(";", " ").split() for line in file]
    except (OSError, UnicodeDecodeError, TypeError) as error:
        reason = getattr(error, "strerror", None) or error
        cure = "pass the path of a text file"
        raise SceneError(f"{title}: {short_repr(path)} cannot be read: {reason}; {cure}") from None
    rows = []
    for number, words in enumerate(lines, start=1):
        if not words:
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            row = []
        if len(row) != 2 or not all(map(math.isfinite, row)):
            cure = "write an angle and an intensity, and # before comments"
            raise SceneError(
                f"{title}: line {number} of {str(path)!r} must be two numbers,"
                f" got {short_repr(' '.join(words))}; {cure}"
            )
        rows.append(row)
    if len(rows) < 2:
        raise SceneError(f"{title}: {str(path)!r} must contain two lines of numbers or more, got {len(rows)}")
    return np.array(rows)
