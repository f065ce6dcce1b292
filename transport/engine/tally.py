"""Score, and count scores by size where they differ: a few heavy scores may dominate a mean.

Sizes are binned by quarters of an octave, from the bits of the weight, so counts are exact and independent of
order.
"""

import math

import numpy as np
from numba import float64, int64, uint64

from transport.compile.layout import COUNT_BITS, GRAZING_CUT, LOST, SIZE_CELLS, SIZE_OCTAVE, SIZE_PARTS, SIZES
from transport.engine.bundle import add_to_row, view
from transport.engine.registry import lane_pass
from transport.physics.bits import bits_of
from transport.physics.device import device

# ---- Crossings below the grazing cut |mu| <= GRAZING_CUT: a test whether they come as from constant radiance.
#
# Constant radiance gives them in proportion to |mu|: half of them below cut/sqrt(2). The excess of those below
# cut/sqrt(2) over those above it is counted in the upper bits of a row's number of scores. This costs nothing
# where none comes: one in 10^6 for isotropic light.

HALF_CUT = GRAZING_CUT * 0.5**0.5


@device
def is_grazing(here, mu):
    """Return 1 for a scored crossing below the cut, else 0."""
    return 1 if here & (abs(mu) <= GRAZING_CUT) else 0


@device
def count_grazing(b, first, live):
    """Count lanes that have just scored below the cut: +1 below cut/sqrt(2), -1 above it.

    Fields: reads `mu`, `bin`, `is_grazing`.
    """
    if b.any_grazing != 0:
        for k in range(first, live):
            mu = abs(b.mu[k])
            if b.bin[k] != 0 and mu <= GRAZING_CUT:
                side = 1 if mu < HALF_CUT else -1
                add_to_row(b.tallies + 32 * b.bin[k], 0, 0, side << COUNT_BITS, 0)


# ---- Score, and count scores by size where they differ: a few heavy scores may dominate a mean.

SHIFT = 50  # bits of a float64 below those of its octave and quarter
LOWEST = (1023 + SIZE_OCTAVE) * SIZE_PARTS  # those bits of the least size that has a cell of its own


@device
def size_cell(weight):
    """Return the size cell of a score; the first and last cells take all beyond them."""
    return min(max((bits_of(weight) >> SHIFT) - LOWEST, 0), SIZE_CELLS - 1)


@lane_pass(SIZES)
def score_and_size(b, table, first, live):
    """Score like detectors.score, and count the score's size on this side of the detector.

    A batch whose number has a bit of `resting` counts none.

    Fields: reads `weight`, `mu`, `detector_row`, `bin`, `high`, `low`, `slant`, `is_grazing`.
    """
    numbers, sizes = view(table.numbers, table.count, np.int64), view(b.sizes, table.cells, np.int64)
    n, one = 0, 1 if b.batch & table.resting == 0 else 0
    for k in range(first, live):  # no branch, so no misprediction
        b.listed[n] = k
        n += 1 if b.bin[k] != 0 else 0
    for j in range(n):
        k = uint64(b.listed[j])
        add_to_row(b.tallies + 32 * b.bin[k], b.high[k], b.low[k], 1, b.slant[k])
        sizes[uint64(numbers[uint64(b.detector_row[k])] + size_cell(b.weight[k]))] += one
    count_grazing(b, first, live)
    return live


@lane_pass(SIZES)
def score_all_and_size(b, table, first, live):
    """The same where nearly every lane has a bin.

    Row 0 and the first cells take the others and are never read.

    Fields: reads `weight`, `mu`, `detector_row`, `bin`, `high`, `low`, `slant`, `is_grazing`.
    """
    numbers, sizes = view(table.numbers, table.count, np.int64), view(b.sizes, table.cells, np.int64)
    if b.batch & table.resting != 0:
        for k in range(first, live):
            add_to_row(b.tallies + 32 * b.bin[k], b.high[k], b.low[k], 1, b.slant[k])
        count_grazing(b, first, live)
        return live
    for k in range(first, live):
        cell = numbers[uint64(b.detector_row[k])] + size_cell(b.weight[k])
        b.listed[k] = cell if b.bin[k] != 0 else 0
    for k in range(first, live):  # one loop for both, whose memory accesses overlap
        add_to_row(b.tallies + 32 * b.bin[k], b.high[k], b.low[k], 1, b.slant[k])
        sizes[uint64(b.listed[k])] += 1
    count_grazing(b, first, live)
    return live


# ---- Exact sums: a weight becomes two integers, whose total does not depend on the order.

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
def unbiased_limbs(weight, chance):
    """The same, but a weight below FAINT, of which limbs would keep few digits or none, is unbiased.

    It is rounded up with the probability of its remainder. chance: uniform in [0, 1). Zero stays zero.
    """
    scaled = weight * 4294967296.0
    high = int64(scaled)
    rest = (scaled - float64(high)) * 2147483648.0
    return high, int64(rest + (chance if weight < FAINT else 0.0))


@device
def hashed_uniform(bits, salt):
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
def hash_salt(seed_low, batch):
    """Return the salt of `hashed_uniform` for a run and batch; history numbers are added to it."""
    return (seed_low * SALT ^ batch) * SALT


# ---- Energy balance (ledger): rows of exact sums, and lost histories.


@device
def add_to_ledger(b, row, high, low):
    """Add limbs to a row of the ledger."""
    ledger = view(b.ledger, b.ledger_words, np.int64)
    ledger[4 * row] += high
    ledger[4 * row + 1] += low


@device
def add_lost(b, weight):
    """Add one lost history to the ledger, with its weight if that is not NaN."""
    high, low = limbs(weight if weight == weight else 0.0)
    add_to_ledger(b, LOST, high, low)
    view(b.ledger, b.ledger_words, np.int64)[4 * LOST + 2] += 1
