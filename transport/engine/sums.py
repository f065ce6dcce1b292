"""Exact sums: a weight becomes two integers, whose total does not depend on the order."""

import math

from numba import float64, int64

from transport.compile.layout import GRAZING_CUT
from transport.physics.device import device

HASH = int64(-7046029254386353131)  # 2^64 over the golden ratio
SALT = int64(-4417276706812531889)  # 2^64 / 1.32, odd
MANTISSA = (1 << 52) - 1
FAINT = 2.0**-33  # below it limbs keep fewer than nine digits


@device
def limbs(weight):
    """Return the weight in units of 2^-32 and its remainder in units of 2^-63."""
    scaled = weight * 4294967296.0
    high = int64(scaled)
    return high, int64((scaled - float64(high)) * 2147483648.0)


@device
def fair_limbs(weight, chance):
    """The same, but a weight below FAINT, of which limbs would keep few digits or none, is unbiased.

    It is rounded up with the probability of its remainder. chance: uniform in [0, 1). Zero stays zero.
    """
    scaled = weight * 4294967296.0
    high = int64(scaled)
    rest = (scaled - float64(high)) * 2147483648.0
    return high, int64(rest + (chance if weight < FAINT else 0.0))


@device
def chance_of(bits, salt):
    """Return a pseudo-random number in [0, 1): Fibonacci hash of the score's bits, salted by history."""
    return float64(((bits ^ salt) * HASH >> 12) & MANTISSA) * 2.0**-52


@device
def long_limbs(value):
    """Return a value of size at most 1 in units of 2^-32, and remainders in units of 2^-63, 2^-94, 2^-125."""
    scaled = value * 4294967296.0
    high = int64(scaled)
    rest = (scaled - float64(high)) * 2147483648.0
    middle = int64(rest)
    rest = (rest - float64(middle)) * 2147483648.0
    low = int64(rest)
    return high, middle, low, int64((rest - float64(low)) * 2147483648.0)


@device
def slant(weight, mu, chance):
    """Return weight/|mu| in units of 2^-22, for the fluence rate; below GRAZING_CUT weight * 2/cut.

    2/cut is the mean of 1/|mu| there under constant radiance. The result is rounded up with the probability
    of its remainder, so weights below the unit are unbiased. A score is at most 2^33 units.
    """
    m = abs(mu)
    inverse = 1.0 / m if m > GRAZING_CUT else 2.0 / GRAZING_CUT
    return int64(math.floor(weight * inverse * 4194304.0 + chance))


@device
def salt_of(seed_low, batch):
    """Return the salt of `chance_of` for a run and batch; history numbers are added to it."""
    return (seed_low * SALT ^ batch) * SALT
