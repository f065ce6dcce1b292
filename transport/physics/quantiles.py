"""Speeds by inverse CDF: polynomials in cells that become finer towards both tails.

Octave k of a tail holds the probabilities from 2^-(k+1) to 2^-k, from the lower or the upper end, so a tail
is as exact as the middle (hierarchical segmentation: Lee, Cheung, Villasenor, Luk 2007).
"""

import math

from numba import float64

from transport.physics.bits import bits_of, float_of
from transport.physics.device import device

MANTISSA, EXPONENT_OF_ONE = 0x000FFFFFFFFFFFFF, 0x3FF0000000000000
LAST = 53  # octave of the smallest probability that a uniform can have


@device
def octave_of(u):
    """Return the octave, numbered through both tails, and the place in it as a mantissa, for u in [0, 1)."""
    is_upper = u >= 0.5
    x = 1.0 - u if is_upper else u
    bits = bits_of(x)
    k = 1022 - (bits >> 52)
    inside = k <= LAST
    return (k if inside else LAST) + (LAST + 1 if is_upper else 0), (bits & MANTISSA) if inside else 0


@device
def cell_place(mantissa, level):
    """Return the cell within an octave of 2^level cells, and the coordinate in the cell in [-1, 1)."""
    place = float_of(((mantissa << level) & MANTISSA) | EXPONENT_OF_ONE)
    return mantissa >> (52 - level), 2.0 * float64(place) - 3.0


@device
def polynomial(c0, c1, c2, c3, c4, c5, t):
    """Return a polynomial of degree 5 by Horner's scheme."""
    return c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5))))


@device
def cell_value(c0, c1, c2, c3, c4, c5, split, t):
    """Return the value of a cell at t: a polynomial of degree 5, or two quadratics in sqrt|t - split|.

    A cell is split if `split` lies within [-1, 1].
    """
    s = math.sqrt(abs(t - split))
    pieces = c0 + s * (c1 + s * c2) if t < split else c3 + s * (c4 + s * c5)
    return pieces if split <= 1.0 else polynomial(c0, c1, c2, c3, c4, c5, t)
