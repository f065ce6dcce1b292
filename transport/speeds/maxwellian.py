"""What a distribution of speeds answers, and the Maxwellian: the gas in thermal equilibrium.

Accurate relatively in both tails: where u > 1/2 it is the exact 1 - u that is inverted.
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
MOST_DRIFT = 30.0  # standard deviations of the drift through a plane


class SpeedDistribution:
    """What all of them answer for a gas at rest; not made itself.

    quantile(u): speed [m/s].  line_quantile(u): signed velocity along a line [m/s].  flux_quantile(u): speed
    [m/s] of what crosses a surface, weighted by the speed.  All take arrays of u in [0, 1).
    """

    mean_speed: float  # mean of |speed| [m/s]
    fastest: float  # bound of every |speed| [m/s] for u up to 1 - 2^-53, a drift added
    is_signed = False  # whether there are negative speeds, which fly against a Gas's direction
    has_drift = False

    def __getstate__(self) -> dict[str, object]:
        """Without what has been worked out from the fields, which `_` begins."""
        return {name: value for name, value in self.__dict__.items() if not name.startswith("_")}


@scene_object(kw_only=True)
class Maxwellian(SpeedDistribution):
    """Speeds in thermal equilibrium: each velocity component is normal about that of `drift` [m/s].

    Either `temperature` [K] and `mass` [kg] of a particle, or `sigma` = sqrt(k T/m) [m/s], the standard
    deviation of a component, to which a mass may be added.  Its functions of u leave the drift out.
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
        """Whether the gas moves as a whole."""
        return any(self.drift)

    @property
    def mean_speed(self) -> float:
        """sqrt(8/pi) sigma [m/s], of the gas at rest (Reif 1965, 7.10)."""
        return math.sqrt(8 / math.pi) * self.sigma

    @property
    def fastest(self) -> float:
        """Bound of every speed [m/s]; with a drift, of every sum of three components and the drift."""
        bound = FASTEST * self.sigma
        return math.sqrt(3) * bound + math.hypot(*self.drift) if self.has_drift else bound

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Speed [m/s]: sigma times chi with 3 degrees of freedom."""
        return self.sigma * _chi(1.5, u)

    def line_quantile(self, u: np.ndarray) -> np.ndarray:
        """Signed component along a line [m/s]: normal; u below 2^-54 stands for 2^-54."""
        return self.sigma * normals.line(u)

    def flux_quantile(self, u: np.ndarray) -> np.ndarray:
        """Speed of what effuses [m/s]: sigma times chi with 4 degrees of freedom."""
        return self.sigma * _chi(2.0, u)

    def normal_quantile(self, u: np.ndarray, d: float) -> np.ndarray:
        """Normal speed [m/s] of what crosses a plane through which the gas drifts at `d` [m/s].

        Its density is proportional to w exp(-(w - d)²/(2 sigma²)), w > 0.  Raises SceneError for |d| above 30
        sigma.
        """
        return self.sigma * normals.crossing(u, self._drift_in_sigmas(d))

    def one_way_flux(self, d: float) -> float:
        """What crosses a plane one way, over the density [m/s], with a drift `d` [m/s] through it.

        sigma/sqrt(2 pi) exp(-s²) + d/2 erfc(-s), s = d/(sqrt2 sigma) (Bird 1994, 4.22), to a relative (2 s²)
        2^-52.  Raises SceneError for |d| above 30 sigma.
        """
        return self.sigma * float(normals.crossing_rate(self._drift_in_sigmas(d)))

    def drift_through(self, shape: FlatShape, is_back: bool) -> float:
        """The drift's component out of one side of a flat shape [m/s]."""
        return dot(self.drift, shape.normal) * (-1.0 if is_back else 1.0)

    def _drift_in_sigmas(self, d: float) -> float:
        if not abs(d) <= MOST_DRIFT * self.sigma:
            refuse(
                self,
                f"drift through a plane must be within {MOST_DRIFT:g} sigma = {MOST_DRIFT * self.sigma:g} m/s"
                f" either way, got {d:g} m/s; so narrow a stream is a Gas of one speed along a direction",
            )
        return d / self.sigma


def _chi(half_degrees: float, u: np.ndarray) -> np.ndarray:
    """Quantile of chi with 2 half_degrees degrees of freedom."""
    from scipy.special import gammainccinv, gammaincinv

    u = np.asarray(u, float)
    energy = np.where(u > 0.5, gammainccinv(half_degrees, 1 - u), gammaincinv(half_degrees, u))
    return np.sqrt(2 * energy)
