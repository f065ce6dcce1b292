"""Speed distributions: Maxwellian, tabulated, or any inverse cumulative distribution."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from transport.geometry.flat import FlatShape
from transport.statistics import normal
from transport.statistics.quantiles import LARGEST_U, PiecewiseQuadraticDensity, SelfWeightedQuantile
from transport.units import BOLTZMANN
from transport.validation import (
    NumbersField,
    VectorField,
    as_floats,
    coerce_positive,
    coerce_vector,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)
from transport.vectors import dot

# ---- The base class of speed distributions, and the Maxwellian: a gas in thermal equilibrium.
#
# Quantiles are accurate relatively in both tails: for u > 1/2 the exact 1 - u is inverted.

MAX_SPEED_SIGMAS = 9.0  # standard deviations; chi with 4 degrees of freedom is 8.996 at u = 1 - 2^-53
MAX_DRIFT_SIGMAS = 30.0  # largest drift through a plane, in standard deviations


class SpeedDistribution:
    """Base class of distributions of speeds of a gas at rest; not instantiated directly.

    `quantile(u)` is the speed [m/s], `line_quantile(u)` the signed velocity along a line [m/s], and
    `flux_quantile(u)` the speed [m/s] of particles that cross a surface, weighted by the speed. All take
    arrays of u in [0, 1).
    """

    mean_speed: float  # mean of |speed| [m/s]
    fastest: float  # upper bound of |speed| [m/s] for u up to 1 - 2^-53, plus the drift
    is_signed = False  # whether speeds may be negative: against the direction of a Gas
    has_drift = False

    def __getstate__(self) -> dict[str, object]:
        """Return the fields, without cached attributes (names that start with `_`)."""
        return {name: value for name, value in self.__dict__.items() if not name.startswith("_")}


@scene_object(kw_only=True)
class Maxwellian(SpeedDistribution):
    """The Maxwellian distribution: each velocity component is normal about that of the drift.

    Give `temperature` and `mass`, or `sigma`. All parameters are keywords. Methods of u ignore the drift.

    Parameters
    ----------
    temperature : float, default None
        Temperature [K]; needs `mass`.
    mass : float, default None
        Mass of a particle [kg].
    sigma : float, default sqrt(k temperature / mass)
        Standard deviation of a velocity component [m/s].
    drift : vector, default (0, 0, 0)
        Mean velocity of the gas [m/s].

    Raises
    ------
    SceneError
        If neither temperature and mass nor sigma are given, or if they contradict each other.

    Examples
    --------
    >>> import transport as tp
    >>> nitrogen = tp.Maxwellian(temperature=300, mass=4.65e-26)
    >>> round(nitrogen.sigma, 2), round(nitrogen.mean_speed, 2)  # [m/s]
    (298.45, 476.26)
    """

    temperature: float | None = None
    mass: float | None = None
    sigma: float | None = None
    drift: VectorField = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        coerce_vector(self, "drift")
        if self.mass is not None:
            coerce_positive(self, "mass")
        if self.temperature is not None:
            self._coerce_temperature()
        elif self.sigma is None:
            refuse(
                self,
                "temperature and mass, or sigma, must be given, got neither; write temperature=..., mass=...",
            )
        coerce_positive(self, "sigma")
        if not 0 < self.fastest < math.inf:
            refuse(
                self,
                f"its speeds must be finite, got sigma={self.sigma} and drift={self.drift}; change the unit",
            )

    def _coerce_temperature(self) -> None:
        coerce_positive(self, "temperature")
        if self.mass is None:
            refuse(
                self,
                f"mass must be given with temperature={self.temperature}, got None; write mass=... in kg",
            )
        sigma = math.sqrt(BOLTZMANN * self.temperature / self.mass)
        if self.sigma is not None and self.sigma != sigma:
            refuse(
                self,
                f"sigma follows from temperature and mass as {sigma}, got {short_repr(self.sigma)};"
                " leave it out",
            )
        set_fields(self, sigma=sigma)

    @property
    def has_drift(self) -> bool:
        """Whether the mean velocity differs from 0.

        Returns
        -------
        bool
        """
        return any(self.drift)

    @property
    def mean_speed(self) -> float:
        """Mean speed of the gas at rest, sqrt(8/pi) sigma (Reif 1965, 7.10).

        Returns
        -------
        float
            Speed [m/s].
        """
        return math.sqrt(8 / math.pi) * self.sigma

    @property
    def fastest(self) -> float:
        """Upper bound of every speed that is drawn; with a drift, of three components plus the drift.

        Returns
        -------
        float
            Speed [m/s].
        """
        bound = MAX_SPEED_SIGMAS * self.sigma
        return math.sqrt(3) * bound + math.hypot(*self.drift) if self.has_drift else bound

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Return speeds: sigma times chi with 3 degrees of freedom.

        Parameters
        ----------
        u : array
            Uniform numbers in [0, 1).

        Returns
        -------
        array
            Speeds [m/s], of the shape of u.
        """
        return self.sigma * _chi_quantile(1.5, u)

    def line_quantile(self, u: np.ndarray) -> np.ndarray:
        """Return signed velocities along a line: normal; u below 2^-54 counts as 2^-54.

        Parameters
        ----------
        u : array
            Uniform numbers in [0, 1).

        Returns
        -------
        array
            Speeds [m/s], of the shape of u.
        """
        return self.sigma * normal.normal_quantile(u)

    def flux_quantile(self, u: np.ndarray) -> np.ndarray:
        """Return speeds of effusing particles: sigma times chi with 4 degrees of freedom.

        Parameters
        ----------
        u : array
            Uniform numbers in [0, 1).

        Returns
        -------
        array
            Speeds [m/s], of the shape of u.
        """
        return self.sigma * _chi_quantile(2.0, u)

    def normal_quantile(self, u: np.ndarray, d: float) -> np.ndarray:
        """Return normal velocities of particles that cross a plane through which the gas drifts.

        Parameters
        ----------
        u : array
            Uniform numbers in [0, 1).
        d : float
            Drift through the plane [m/s].

        Returns
        -------
        array
            Velocities w > 0 [m/s], with a density proportional to w exp(-(w - d)²/(2 sigma²)).

        Raises
        ------
        SceneError
            If `|d|` exceeds 30 sigma.
        """
        return self.sigma * normal.crossing_quantile(u, self._drift_in_sigmas(d))

    def one_way_flux(self, d: float) -> float:
        """Return the one-way flux density through a plane, divided by the density of the gas.

        Parameters
        ----------
        d : float
            Drift through the plane [m/s].

        Returns
        -------
        float
            Velocity [m/s].

        Raises
        ------
        SceneError
            If `|d|` exceeds 30 sigma.

        Notes
        -----
        sigma/sqrt(2 pi) exp(-s²) + d/2 erfc(-s) with s = d/(sqrt2 sigma) (Bird 1994, 4.22), to a relative
        accuracy of (2 s²) 2^-52.
        """
        return self.sigma * float(normal.crossing_rate(self._drift_in_sigmas(d)))

    def drift_through(self, shape: FlatShape, is_back: bool) -> float:
        """Return the component of the drift out of one side of a flat shape.

        Returns
        -------
        float
            Velocity [m/s].
        """
        return dot(self.drift, shape.normal) * (-1.0 if is_back else 1.0)

    def _drift_in_sigmas(self, d: float) -> float:
        if not abs(d) <= MAX_DRIFT_SIGMAS * self.sigma:
            refuse(
                self,
                f"drift through a plane must be within {MAX_DRIFT_SIGMAS:g} sigma ="
                f" {MAX_DRIFT_SIGMAS * self.sigma:g} m/s either way, got {d:g} m/s; use a Gas of one speed"
                " along a direction",
            )
        return d / self.sigma


def _chi_quantile(half_degrees: float, u: np.ndarray) -> np.ndarray:
    """Return the quantile of chi with 2 half_degrees degrees of freedom."""
    from scipy.special import gammainccinv, gammaincinv

    u = np.asarray(u, float)
    energy = np.where(u > 0.5, gammainccinv(half_degrees, 1 - u), gammaincinv(half_degrees, u))
    return np.sqrt(2 * energy)


# ---- Tabulated and user-defined speed distributions, as functions of a uniform number u in [0, 1).

DECREASE_TOLERANCE = 1e-12  # relative decrease of a quantile that counts as rounding
TRIAL_U = np.unique(
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

    speeds: NumbersField
    density: NumbersField

    def __post_init__(self) -> None:
        for name in ("speeds", "density"):
            values = as_floats(getattr(self, name))
            if values is None or len(values) < 2:
                refuse(
                    self, f"{name} must be two finite numbers or more, got {short_repr(getattr(self, name))}"
                )
            set_fields(self, **{name: values})
        if len(self.speeds) != len(self.density):
            refuse(
                self,
                f"density must be as many numbers as speeds, {len(self.speeds)}, got {len(self.density)}",
            )
        is_rising = np.greater(self.speeds[1:], self.speeds[:-1])
        if not is_rising.all():
            refuse(
                self,
                f"speeds must be increasing, got {_describe_step(self.speeds, int(np.argmin(is_rising)))};"
                " sort them",
            )
        if not np.isfinite(self.speeds[-1] - self.speeds[0]):
            refuse(self, f"speeds must span a finite range, got {short_repr(self.speeds)}; change the unit")
        if min(self.density) < 0 or max(self.density) == 0:
            refuse(
                self, f"density must be zero or positive, and not all zero, got {short_repr(self.density)}"
            )

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
        plain, weighted = self._densities
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
        return self._densities[0].quantile(u) * self.fastest

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
        return self._densities[1].quantile(u) * self.fastest

    @cached_property
    def _densities(self) -> tuple[PiecewiseQuadraticDensity, PiecewiseQuadraticDensity]:
        """Return the density and its product with `|speed|`, relative to fastest speed and peak density."""
        # Scale speeds and density, and add a knot at speed 0, where |speed| has a kink.
        v, f = np.array(self.speeds) / self.fastest, np.array(self.density) / max(self.density)
        if v[0] < 0 < v[-1] and 0.0 not in v:
            place = int(np.searchsorted(v, 0.0))
            f = np.insert(f, place, np.interp(0.0, v, f))
            v = np.insert(v, place, 0.0)
        ends = f[:-1], f[1:]
        return PiecewiseQuadraticDensity(v, _bernstein_product(*ends, 1.0, 1.0)), PiecewiseQuadraticDensity(
            v, _bernstein_product(*ends, *np.abs((v[:-1], v[1:])))
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
        if isinstance(self.quantile, _VectorizedQuantile):
            return
        if not callable(self.quantile):
            refuse(self, f"quantile must be a function of u in [0, 1), got {short_repr(self.quantile)}")
        try:
            hash(self.quantile)
        except TypeError:
            refuse(
                self,
                f"quantile must be hashable, as functions are, got {short_repr(self.quantile)};"
                " use a function",
            )
        self._check(_trial_speeds(self))
        set_fields(self, quantile=_VectorizedQuantile(self.quantile))

    def _check(self, v: np.ndarray) -> None:
        if not np.isfinite(v).all():
            refuse(
                self,
                f"quantile must be finite, got {_describe_at_u(v, ~np.isfinite(v))};"
                " clip u to 2**-54 or more",
            )
        if not v.any():
            refuse(self, "quantile must not be 0 everywhere; a Gas at rest is Gas(speed=0)")
        falls = np.diff(v, prepend=v[0]) < -DECREASE_TOLERANCE * np.abs(v)
        if falls.any():
            refuse(
                self,
                f"quantile must not fall with u, got {_describe_at_u(v, falls)}, less than before;"
                " reverse it",
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
        return float(np.abs(self.quantile([0.0, LARGEST_U])).max())

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
        """Return speeds weighted by `|speed|`; for the accuracy see quantiles.SelfWeightedQuantile.

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
    def _weighted(self) -> SelfWeightedQuantile:
        return SelfWeightedQuantile(self.quantile)


@dataclass(frozen=True)
class _VectorizedQuantile:
    """A user's function for u of any shape; equal if the function is equal."""

    function: Callable[[np.ndarray], np.ndarray]

    def __call__(self, u: np.ndarray) -> np.ndarray:
        u = np.asarray(u, float)
        return np.asarray(self.function(u.ravel()), float).reshape(u.shape)

    def __repr__(self) -> str:
        return getattr(self.function, "__qualname__", type(self.function).__name__)


def _trial_speeds(subject: InverseCDF) -> np.ndarray:
    """Return the speeds on a grid that is fine towards both ends."""
    must = "quantile must take an array of u and give as many real numbers"
    try:
        with np.errstate(all="ignore"):
            v = np.asarray(subject.quantile(TRIAL_U.copy()))
    except Exception as error:
        raise_from = f"{type(error).__name__}: {error}"
        refuse(subject, f"{must}, got {short_repr(raise_from)}; write it with NumPy")
    if v.shape != TRIAL_U.shape or v.dtype.kind not in "fiu":
        refuse(
            subject,
            f"{must}, got shape {v.shape} of {v.dtype} from shape {TRIAL_U.shape}; write it with NumPy",
        )
    return v.astype(float)


def _bernstein_product(f0: np.ndarray, f1: np.ndarray, g0: np.ndarray, g1: np.ndarray) -> np.ndarray:
    """Return the Bernstein coefficients of the product of two linear functions, given by their end values."""
    return np.stack(np.broadcast_arrays(f0 * g0, 0.5 * (f0 * g1 + f1 * g0), f1 * g1), axis=1)


def _describe_step(values: Iterable[float], place: int) -> str:
    values = tuple(values)
    return f"{values[place + 1]} after {values[place]}"


def _describe_at_u(v: np.ndarray, where: np.ndarray) -> str:
    place = int(np.argmax(where))
    return f"{v[place]} at u = {TRIAL_U[place]}"
