"""Crossings beyond the grazing cut: whether they come as from a constant radiance, for which each counts its mean.

From one they come in proportion to |mu|: half of them nearer to grazing than cut/sqrt(2).  How many more come nearer than
farther is counted in the upper bits of a row's number of scores, and costs nothing where none comes: one in 10^6 of even light.
"""

from transport.compile.layout import COUNT_BITS, GRAZING_CUT
from transport.engine.addresses import add_to_row
from transport.physics.device import device

HALFWAY = GRAZING_CUT * 0.5**0.5


@device
def grazes(here, mu):
    """1 where a crossing that counts lies beyond the cut, else 0."""
    return 1 if here & (abs(mu) <= GRAZING_CUT) else 0


@device
def balance_grazing(b, first, live):
    """Of the lanes that have just scored, count those beyond the cut, up or down."""
    if b.grazes != 0:
        for k in range(first, live):
            mu = abs(b.mu[k])
            if b.bin[k] != 0 and mu <= GRAZING_CUT:
                side = 1 if mu < HALFWAY else -1
                add_to_row(b.tallies + 32 * b.bin[k], 0, 0, side << COUNT_BITS, 0)
