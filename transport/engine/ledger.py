"""Energy balance (ledger): rows of exact sums, and lost histories."""

import numpy as np

from transport.compile.layout import LOST
from transport.engine.addresses import view
from transport.engine.sums import limbs
from transport.physics.device import device


@device
def enter(b, row, high, low):
    """Add limbs to a row of the ledger."""
    ledger = view(b.ledger, b.ledger_words, np.int64)
    ledger[4 * row] += high
    ledger[4 * row + 1] += low


@device
def lose(b, weight):
    """Add one lost history to the ledger, with its weight if that is not NaN."""
    high, low = limbs(weight if weight == weight else 0.0)
    enter(b, LOST, high, low)
    view(b.ledger, b.ledger_words, np.int64)[4 * LOST + 2] += 1
