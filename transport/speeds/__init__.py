"""Speed distributions: Maxwellian, tabulated, or any inverse cumulative distribution."""

from transport.speeds.maxwellian import BOLTZMANN, Maxwellian, SpeedDistribution
from transport.speeds.tables import InverseCDF, SpeedTable

__all__ = ["BOLTZMANN", "InverseCDF", "Maxwellian", "SpeedDistribution", "SpeedTable"]
