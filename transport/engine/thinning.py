"""Absorption too weak for the digits of a weight: right in the mean, to the last unit of the ledger.

before * exp(-depth), rounded, is off by half a unit in its last place, 1e-16 / depth of what is absorbed, and always alike
where all go the same way; below 1e-16 nothing is absorbed at all.  What is absorbed, before * (1 - exp(-depth)), is known to all
its digits; so the weight that is left is rounded up or down with the chance that gives it that mean.
"""

from transport.engine.sums import chance_of
from transport.physics.bits import bits_of, float_of
from transport.physics.device import device

# optical depth below which this is done: above it rounding takes 1e-10 of what is absorbed at most
THIN = 2.0**-20


@device
def is_thin(depth):
    """Whether a way absorbs so little."""
    return (depth > 0.0) & (depth < THIN)


@device
def thinned(before, depth, salt):
    """before * exp(-depth) for a depth below THIN, in the mean over salts."""
    kept = before * (depth - depth * depth * (0.5 - depth / 6.0))
    after = before - kept
    excess = (before - after) - kept  # by which rounding has taken too much
    other = float_of(bits_of(after) + (1 if excess > 0.0 else -1))
    return other if chance_of(bits_of(depth), salt) * abs(other - after) < abs(excess) else after
