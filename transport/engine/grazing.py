"""Crossings below the grazing cut |mu| <= GRAZING_CUT: a test whether they come as from constant radiance.

Constant radiance gives them in proportion to |mu|: half of them below cut/sqrt(2). The excess of those below
cut/sqrt(2) over those above it is counted in the upper bits of a row's number of scores. This costs nothing
where none comes: one in 10^6 for isotropic light.
"""

from transport.compile.layout import COUNT_BITS, GRAZING_CUT
from transport.engine.addresses import add_to_row
from transport.physics.device import device

HALFWAY = GRAZING_CUT * 0.5**0.5


@device
def grazes(here, mu):
    """Return 1 for a scored crossing below the cut, else 0."""
    return 1 if here & (abs(mu) <= GRAZING_CUT) else 0


@device
def balance_grazing(b, first, live):
    """Count lanes that have just scored below the cut: +1 below cut/sqrt(2), -1 above it.

    Fields: reads `mu`, `bin`, `grazes`.
    """
    if b.grazes != 0:
        for k in range(first, live):
            mu = abs(b.mu[k])
            if b.bin[k] != 0 and mu <= GRAZING_CUT:
                side = 1 if mu < HALFWAY else -1
                add_to_row(b.tallies + 32 * b.bin[k], 0, 0, side << COUNT_BITS, 0)
