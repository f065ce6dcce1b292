"""Speed distributions: Maxwellian, tabulated, or any inverse cumulative distribution."""

from transport.speeds.maxwellian import Maxwellian, SpeedDistribution
from transport.speeds.tables import InverseCDF, SpeedTable

__all__ = ["InverseCDF", "Maxwellian", "SpeedDistribution", "SpeedTable"]
