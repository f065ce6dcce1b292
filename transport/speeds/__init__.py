"""How fast particles are: Maxwellian, tabulated, or by any inverse cumulative distribution."""

from transport.speeds.maxwellian import Maxwellian, SpeedDistribution
from transport.speeds.tables import InverseCDF, SpeedTable

__all__ = ["InverseCDF", "Maxwellian", "SpeedDistribution", "SpeedTable"]
