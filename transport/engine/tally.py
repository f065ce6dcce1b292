"""Exact integer sums: weights as limbs, rows of tallies, energy balance, crossings below the grazing cut."""

import numpy as np
from numba import float64, int64

from transport.compile.layout import COUNT_BITS, GRAZING_CUT, LOST
from transport.engine.bundle import add_to_row, view
from transport.physics.bits import real, whole
from transport.physics.device import device

# ---- Crossings below the grazing cut |mu| <= GRAZING_CUT: test whether they follow constant radiance.
#
# Constant radiance gives them in proportion to |mu|: half of them below cut/sqrt(2). The excess of those
# below cut/sqrt(2) over those above it is counted in the upper bits of a row's number of scores. This costs
# nothing where none comes: one in 10^6 for isotropic light.

HALF_CUT = GRAZING_CUT * 0.5**0.5


@device
def count_of_score(mu):
    """Return what a score adds to the word of counts.

    1, and in the upper bits +1 or -1 for a crossing below the cut.
    """
    m = abs(mu)
    return 1 + (((1 if m < HALF_CUT else -1) << COUNT_BITS) if m <= GRAZING_CUT else 0)


# ---- Exact sums: a weight becomes two integers, whose total does not depend on the order.

HASH = int64(-7046029254386353131)  # 2^64 over the golden ratio
SALT = int64(-4417276706812531889)  # 2^64 / 1.32, odd
MANTISSA = (1 << 52) - 1
FAINT = 2.0**-33  # below it limbs keep fewer than nine digits


@device
def limbs(weight):
    """Return the weight in units of 2^-32 and its remainder in units of 2^-63."""
    scaled = weight * 4294967296.0
    high = whole(scaled)
    return high, whole((scaled - real(high)) * 2147483648.0)


@device
def limbs_of_loss(before, after):
    """Return the weight lost from before to after, as a difference of exact sums."""
    high, low = limbs(before)
    left_high, left_low = limbs(after)
    return high - left_high, low - left_low


def _by_conversions(whole, real):
    """Return `unbiased_limbs` and `hashed_uniform` with these conversions to integers and back."""

    @device
    def unbiased_limbs(weight, chance):
        """Return limbs unbiased for a weight below FAINT; `limbs` would keep few digits of it or none.

        It is rounded up with the probability of its remainder. chance: uniform in [0, 1). Zero stays zero.
        """
        scaled = weight * 4294967296.0
        high = whole(scaled)
        rest = (scaled - real(high)) * 2147483648.0
        return high, whole(rest + (chance if weight < FAINT else 0.0))

    @device
    def hashed_uniform(bits, salt):
        """Return a pseudo-random number in [0, 1): Fibonacci hash of the score's bits, salted by history."""
        return real(((bits ^ salt) * HASH >> 12) & MANTISSA) * 2.0**-52

    return unbiased_limbs, hashed_uniform


unbiased_limbs, hashed_uniform = _by_conversions(whole, real)
# the same for loops without vectors, in which the processor's own conversions are faster
unbiased_limbs_of_one, hashed_uniform_of_one = _by_conversions(int64, float64)


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
def add_long(address, value):
    """Add a value to the row of four limbs at an address."""
    high, middle, low, rest = long_limbs(value)
    add_to_row(address, high, middle, low, rest)


@device
def slant(weight, mu, chance):
    """Return weight/|mu| in units of 2^-22, for the fluence rate; below GRAZING_CUT weight * 2/cut.

    2/cut is the mean of 1/|mu| there under constant radiance. The result is rounded up with the probability
    of its remainder, so weights below the unit are unbiased. A score is at most 2^33 units.
    """
    m = abs(mu)
    inverse = 1.0 / m if m > GRAZING_CUT else 2.0 / GRAZING_CUT
    return whole(weight * inverse * 4194304.0 + chance)


@device
def hash_salt(seed_low, batch):
    """Return the salt of `hashed_uniform` for a run and batch; history numbers are added to it."""
    return (seed_low * SALT ^ batch) * SALT


# ---- Energy balance (ledger): rows of exact sums, and lost histories.


@device
def add_to_ledger(lane, row, high, low):
    """Add limbs to a row of the ledger."""
    ledger = view(lane.ledger, lane.ledger_words, np.int64)
    ledger[4 * row] += high
    ledger[4 * row + 1] += low


@device
def add_lost(lane, weight):
    """Add one lost history to the ledger, with its weight if that is not NaN."""
    high, low = limbs(weight if weight == weight else 0.0)
    add_to_ledger(lane, LOST, high, low)
    view(lane.ledger, lane.ledger_words, np.int64)[4 * LOST + 2] += 1


# ---- What the totals of a pass are added to: values of `sums` (engine/bodies.py).


def to_ledger(row):
    """Return sums that add limbs to one row of the ledger."""

    @device
    def add(lane, table, high, low):
        add_to_ledger(lane, row, high, low)

    return add


def to_spare_word(row):
    """Return sums that add a number to the spare word of one row of the ledger."""

    @device
    def add(lane, table, number):
        view(lane.ledger, lane.ledger_words, np.int64)[4 * row + 3] += number

    return add


@device
def to_row_of_table(lane, table, high, low):
    """Add limbs to the row of the ledger that the table names."""
    add_to_ledger(lane, table.ledger, high, low)


@device
def to_scored(lane, table, scored):
    """Add to the bound of the sums of scores (driver.MAX_SCORED)."""
    lane.scored += scored
