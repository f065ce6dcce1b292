"""Exact sums: a weight becomes two integers, and integers add up to the same total in any order."""

import math

from numba import float64, int64

from transport.compile.layout import GRAZING_CUT
from transport.physics.device import device

HASH = int64(-7046029254386353131)  # 2^64 over the golden ratio
SALT = int64(-4417276706812531889)  # 2^64 / 1.32, odd
MANTISSA = (1 << 52) - 1
FAINT = 2.0**-33  # below it limbs keep less than nine digits


@device
def limbs(weight):
    """The weight in units of 2^-32, and what is left in units of 2^-63."""
    scaled = weight * 4294967296.0
    high = int64(scaled)
    return high, int64((scaled - float64(high)) * 2147483648.0)


@device
def fair_limbs(weight, chance):
    """The same, but what is fainter than FAINT, of which limbs would keep few digits or none, is right in the mean.

    It is rounded up with the chance of its remainder; chance: uniform from 0 to 1.  Nothing is still nothing.
    """
    scaled = weight * 4294967296.0
    high = int64(scaled)
    rest = (scaled - float64(high)) * 2147483648.0
    return high, int64(rest + (chance if weight < FAINT else 0.0))


@device
def chance_of(bits, salt):
    """A number from 0 to 1 by Fibonacci hashing of what is scored, with a salt that tells whose score it is."""
    return float64(((bits ^ salt) * HASH >> 12) & MANTISSA) * 2.0**-52


@device
def long_limbs(value):
    """A value of size 1 at most in units of 2^-32, and what each leaves in units of 2^-63, 2^-94 and 2^-125."""
    scaled = value * 4294967296.0
    high = int64(scaled)
    rest = (scaled - float64(high)) * 2147483648.0
    middle = int64(rest)
    rest = (rest - float64(middle)) * 2147483648.0
    low = int64(rest)
    return high, middle, low, int64((rest - float64(low)) * 2147483648.0)


@device
def slant(weight, mu, chance):
    """weight/|mu| in units of 2^-22, for the fluence rate; below the cut its mean under constant radiance, 2/cut.

    Rounded up with the chance of its remainder, so that weights below the unit count rightly in the mean.  A score is at most 2^33 units.
    """
    m = abs(mu)
    inverse = 1.0 / m if m > GRAZING_CUT else 2.0 / GRAZING_CUT
    return int64(math.floor(weight * inverse * 4194304.0 + chance))


@device
def salt_of(seed_low, batch):
    """What tells the runs and batches apart in `chance_of`; histories are added to it."""
    return (seed_low * SALT ^ batch) * SALT
