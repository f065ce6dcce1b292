"""Absorption too weak for the digits of a weight: unbiased to the last unit of the ledger.

before * exp(-depth), rounded, is off by half a unit in its last place: 1e-16 / depth of the absorbed weight,
with the same sign where all paths are equal; below 1e-16 nothing is absorbed at all. The absorbed weight
before * (1 - exp(-depth)) is known to all digits, so the remaining weight is rounded up or down at random
with the right mean.
"""

from transport.engine.sums import chance_of
from transport.physics.bits import bits_of, float_of
from transport.physics.device import device

# optical depth below which this is done: above it rounding errs by at most 1e-10 of the absorbed weight
THIN = 2.0**-20


@device
def is_thin(depth):
    """Return whether a path absorbs so little."""
    return (depth > 0.0) & (depth < THIN)


@device
def thinned(before, depth, salt):
    """Return before * exp(-depth) for depth < THIN, rounded at random to be exact in the mean over salts."""
    kept = before * (depth - depth * depth * (0.5 - depth / 6.0))
    after = before - kept
    excess = (before - after) - kept  # by which rounding has absorbed too much
    other = float_of(bits_of(after) + (1 if excess > 0.0 else -1))
    return other if chance_of(bits_of(depth), salt) * abs(other - after) < abs(excess) else after
