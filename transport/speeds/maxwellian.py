"""The base class of speed distributions, and the Maxwellian: a gas in thermal equilibrium.

Quantiles are accurate relatively in both tails: for u > 1/2 the exact 1 - u is inverted.
"""

import math

import numpy as np

from transport import normals
from transport.fields import VectorField
from transport.shapes import FlatShape
from transport.units import BOLTZMANN
from transport.validation import refuse, scene_object, settle_positive, settle_vector, shown, store
from transport.vectors import dot

FASTEST = 9.0  # standard deviations; chi with 4 degrees of freedom is 8.996 at u = 1 - 2^-53
MOST_DRIFT = 30.0  # largest drift through a plane, in standard deviations


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
        settle_vector(self, "drift")
        if self.mass is not None:
            settle_positive(self, "mass")
        if self.temperature is not None:
            self._settle_temperature()
        elif self.sigma is None:
            refuse(
                self,
                "temperature and mass, or sigma, must be given, got neither; write temperature=..., mass=...",
            )
        settle_positive(self, "sigma")
        if not 0 < self.fastest < math.inf:
            refuse(
                self,
                f"its speeds must be finite, got sigma={self.sigma} and drift={self.drift}; change the unit",
            )

    def _settle_temperature(self) -> None:
        settle_positive(self, "temperature")
        if self.mass is None:
            refuse(
                self,
                f"mass must be given with temperature={self.temperature}, got None; write mass=... in kg",
            )
        sigma = math.sqrt(BOLTZMANN * self.temperature / self.mass)
        if self.sigma is not None and self.sigma != sigma:
            refuse(
                self,
                f"sigma follows from temperature and mass as {sigma}, got {shown(self.sigma)}; leave it out",
            )
        store(self, sigma=sigma)

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
        bound = FASTEST * self.sigma
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
        return self.sigma * _chi(1.5, u)

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
        return self.sigma * normals.line(u)

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
        return self.sigma * _chi(2.0, u)

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
        return self.sigma * normals.crossing(u, self._drift_in_sigmas(d))

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
        return self.sigma * float(normals.crossing_rate(self._drift_in_sigmas(d)))

    def drift_through(self, shape: FlatShape, is_back: bool) -> float:
        """Return the component of the drift out of one side of a flat shape.

        Returns
        -------
        float
            Velocity [m/s].
        """
        return dot(self.drift, shape.normal) * (-1.0 if is_back else 1.0)

    def _drift_in_sigmas(self, d: float) -> float:
        if not abs(d) <= MOST_DRIFT * self.sigma:
            refuse(
                self,
                f"drift through a plane must be within {MOST_DRIFT:g} sigma = {MOST_DRIFT * self.sigma:g} m/s"
                f" either way, got {d:g} m/s; use a Gas of one speed along a direction",
            )
        return d / self.sigma


def _chi(half_degrees: float, u: np.ndarray) -> np.ndarray:
    """Return the quantile of chi with 2 half_degrees degrees of freedom."""
    from scipy.special import gammainccinv, gammaincinv

    u = np.asarray(u, float)
    energy = np.where(u > 0.5, gammainccinv(half_degrees, 1 - u), gammaincinv(half_degrees, u))
    return np.sqrt(2 * energy)
