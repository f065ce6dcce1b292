"""Exact sums: a weight becomes two integers, and integers add up to the same total in any order."""

import math

from numba import float64, int64

from transport.layout import GRAZING_CUT
from transport.physics.device import device

ROW = 4  # int64 words of a row: high, low, count, slant
HIGH_UNIT, LOW_UNIT, SLANT_UNIT = 2.0**-32, 2.0**-63, 2.0**-22  # [largest birth weight]


@device
def limbs(weight):
    """The weight in units of 2^-32, and what is left in units of 2^-63."""
    scaled = weight * 4294967296.0
    high = int64(scaled)
    return high, int64((scaled - float64(high)) * 2147483648.0)


@device
def slant(weight, mu):
    """weight/|mu| in units of 2^-22, for the fluence rate; below the cut its mean under constant radiance, 2/cut.

    Rounded up with the chance of its remainder, so that weights below the unit count rightly in the mean; chance is
    the far digits of mu.  A score is at most 2^33 units.
    """
    m = abs(mu)
    inverse = 1.0 / m if m > GRAZING_CUT else 2.0 / GRAZING_CUT
    digits = m * 1073741824.0
    return int64(math.floor(weight * inverse * 4194304.0 + (digits - math.floor(digits))))
