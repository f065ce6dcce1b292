"""Tabulated and user-defined speed distributions, as functions of a uniform number u in [0, 1)."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from transport.fields import Numbers
from transport.speeds.inversion import LAST, PiecewiseLaw, WeightedByItself
from transport.speeds.maxwellian import Maxwellian, SpeedDistribution
from transport.validation import as_floats, refuse, scene_object, shown, store

__all__ = ["InverseCDF", "Maxwellian", "SpeedDistribution", "SpeedTable"]

RISING = 1e-12  # relative decrease of a quantile that counts as rounding
GRID = np.unique(
    np.concatenate([2.0 ** np.arange(-53, 0), np.arange(1024) / 1024, 1 - 2.0 ** np.arange(-53, 0)])
)


@scene_object
class SpeedTable(SpeedDistribution):
    """A tabulated distribution of speeds: the density is linear between the points and 0 outside.

    Parameters
    ----------
    speeds : sequence of float
        Increasing speeds [m/s]; negative ones fly against the direction of a Gas.
    density : sequence of float
        Relative density at these speeds, zero or positive, on any scale.

    Raises
    ------
    SceneError
        If the speeds do not increase, or if the density is negative or all zero.

    Examples
    --------
    >>> import transport as tp
    >>> table = tp.SpeedTable(speeds=(0.0, 1.0), density=(0.0, 1.0))
    >>> round(float(table.quantile(0.25)), 6), round(table.mean_speed, 6)  # [m/s]
    (0.5, 0.666667)
    """

    speeds: Numbers
    density: Numbers

    def __post_init__(self) -> None:
        for name in ("speeds", "density"):
            values = as_floats(getattr(self, name))
            if values is None or len(values) < 2:
                refuse(self, f"{name} must be two finite numbers or more, got {shown(getattr(self, name))}")
            store(self, **{name: values})
        if len(self.speeds) != len(self.density):
            refuse(
                self,
                f"density must be as many numbers as speeds, {len(self.speeds)}, got {len(self.density)}",
            )
        is_rising = np.greater(self.speeds[1:], self.speeds[:-1])
        if not is_rising.all():
            refuse(
                self,
                f"speeds must be increasing, got {_at(self.speeds, int(np.argmin(is_rising)))}; sort them",
            )
        if not np.isfinite(self.speeds[-1] - self.speeds[0]):
            refuse(self, f"speeds must span a finite range, got {shown(self.speeds)}; change the unit")
        if min(self.density) < 0 or max(self.density) == 0:
            refuse(self, f"density must be zero or positive, and not all zero, got {shown(self.density)}")

    @property
    def is_signed(self) -> bool:
        """Whether speeds are negative.

        Returns
        -------
        bool
        """
        return self.speeds[0] < 0

    @property
    def fastest(self) -> float:
        """Largest `|speed|` of the table.

        Returns
        -------
        float
            Speed [m/s].
        """
        return max(abs(self.speeds[0]), abs(self.speeds[-1]))

    @property
    def mean_speed(self) -> float:
        """Mean of `|speed|`.

        Returns
        -------
        float
            Speed [m/s].
        """
        plain, weighted = self._laws
        return weighted.mass / plain.mass * self.fastest

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Return speeds, which may be negative.

        Parameters
        ----------
        u : array
            Uniform numbers in [0, 1).

        Returns
        -------
        array
            Speeds [m/s], of the shape of u.
        """
        return self._laws[0].quantile(u) * self.fastest

    line_quantile = quantile

    def flux_quantile(self, u: np.ndarray) -> np.ndarray:
        """Return speeds of the density weighted by `|speed|`.

        Parameters
        ----------
        u : array
            Uniform numbers in [0, 1).

        Returns
        -------
        array
            Speeds [m/s], of the shape of u.
        """
        return self._laws[1].quantile(u) * self.fastest

    @cached_property
    def _laws(self) -> tuple[PiecewiseLaw, PiecewiseLaw]:
        """Return the density and its product with `|speed|`, relative to fastest speed and peak density."""
        # Scale speeds and density, and add a knot at speed 0, where |speed| has a kink.
        v, f = np.array(self.speeds) / self.fastest, np.array(self.density) / max(self.density)
        if v[0] < 0 < v[-1] and 0.0 not in v:
            place = int(np.searchsorted(v, 0.0))
            f = np.insert(f, place, np.interp(0.0, v, f))
            v = np.insert(v, place, 0.0)
        ends = f[:-1], f[1:]
        return PiecewiseLaw(v, _product(*ends, 1.0, 1.0)), PiecewiseLaw(
            v, _product(*ends, *np.abs((v[:-1], v[1:])))
        )


@scene_object
class InverseCDF(SpeedDistribution):
    """A distribution of speeds by its inverse cumulative distribution function.

    Parameters
    ----------
    quantile : callable
        Function of an array of u, uniform in [0, 1), that returns speeds [m/s]: vectorised, finite,
        nowhere decreasing.

    Raises
    ------
    SceneError
        If it is no such function.

    Examples
    --------
    >>> import transport as tp
    >>> speeds = tp.InverseCDF(lambda u: 100.0 * (1.0 + u))  # uniform from 100 to 200 m/s
    >>> round(speeds.mean_speed, 6), speeds.fastest
    (150.0, 200.0)
    """

    quantile: Callable[[np.ndarray], np.ndarray] = field()

    def __post_init__(self) -> None:
        if isinstance(self.quantile, _Vectorised):
            return
        if not callable(self.quantile):
            refuse(self, f"quantile must be a function of u in [0, 1), got {shown(self.quantile)}")
        try:
            hash(self.quantile)
        except TypeError:
            refuse(
                self,
                f"quantile must be hashable, as functions are, got {shown(self.quantile)}; use a function",
            )
        self._check(_tried(self))
        store(self, quantile=_Vectorised(self.quantile))

    def _check(self, v: np.ndarray) -> None:
        if not np.isfinite(v).all():
            refuse(
                self,
                f"quantile must be finite, got {_at_u(v, ~np.isfinite(v))}; clip u to 2**-54 or more",
            )
        if not v.any():
            refuse(self, "quantile must not be 0 everywhere; a Gas at rest is Gas(speed=0)")
        falls = np.diff(v, prepend=v[0]) < -RISING * np.abs(v)
        if falls.any():
            refuse(
                self,
                f"quantile must not fall with u, got {_at_u(v, falls)}, less than before; reverse it",
            )

    @property
    def is_signed(self) -> bool:
        """Whether speeds are negative.

        Returns
        -------
        bool
        """
        return bool(self.quantile(0.0) < 0)

    @property
    def fastest(self) -> float:
        """Larger `|speed|` of both ends.

        Returns
        -------
        float
            Speed [m/s].
        """
        return float(np.abs(self.quantile([0.0, LAST])).max())

    @property
    def mean_speed(self) -> float:
        """Mean of `|speed|`.

        Returns
        -------
        float
            Speed [m/s].
        """
        return self._weighted.mean

    def line_quantile(self, u: np.ndarray) -> np.ndarray:
        """Return signed speeds along a line: `quantile` itself.

        Parameters
        ----------
        u : array
            Uniform numbers in [0, 1).

        Returns
        -------
        array
            Speeds [m/s], of the shape of u.
        """
        return self.quantile(u)

    def flux_quantile(self, u: np.ndarray) -> np.ndarray:
        """Return speeds weighted by `|speed|`; for the accuracy see inversion.WeightedByItself.

        Parameters
        ----------
        u : array
            Uniform numbers in [0, 1).

        Returns
        -------
        array
            Speeds [m/s], of the shape of u.
        """
        return self._weighted.quantile(u)

    @cached_property
    def _weighted(self) -> WeightedByItself:
        return WeightedByItself(self.quantile)


@dataclass(frozen=True)
class _Vectorised:
    """A user's function for u of any shape; equal if the function is equal."""

    function: Callable[[np.ndarray], np.ndarray]

    def __call__(self, u: np.ndarray) -> np.ndarray:
        u = np.asarray(u, float)
        return np.asarray(self.function(u.ravel()), float).reshape(u.shape)

    def __repr__(self) -> str:
        return getattr(self.function, "__qualname__", type(self.function).__name__)


def _tried(subject: InverseCDF) -> np.ndarray:
    """Return the speeds on a grid that is fine towards both ends."""
    must = "quantile must take an array of u and give as many real numbers"
    try:
        with np.errstate(all="ignore"):
            v = np.asarray(subject.quantile(GRID.copy()))
    except Exception as error:
        raise_from = f"{type(error).__name__}: {error}"
        refuse(subject, f"{must}, got {shown(raise_from)}; write it with NumPy")
    if v.shape != GRID.shape or v.dtype.kind not in "fiu":
        refuse(
            subject, f"{must}, got shape {v.shape} of {v.dtype} from shape {GRID.shape}; write it with NumPy"
        )
    return v.astype(float)


def _product(f0: np.ndarray, f1: np.ndarray, g0: np.ndarray, g1: np.ndarray) -> np.ndarray:
    """Return the Bernstein coefficients of the product of two linear functions, given by their end values."""
    return np.stack(np.broadcast_arrays(f0 * g0, 0.5 * (f0 * g1 + f1 * g0), f1 * g1), axis=1)


def _at(values: Iterable[float], place: int) -> str:
    values = tuple(values)
    return f"{values[place + 1]} after {values[place]}"


def _at_u(v: np.ndarray, where: np.ndarray) -> str:
    place = int(np.argmax(where))
    return f"{v[place]} at u = {GRID[place]}"
