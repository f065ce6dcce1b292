"""Count crossings: which meter, which bin, and the exact sums.

Layer l of a sheet holds at most one meter; a lane finds it by (sheet, layer).  Bins lie as (u, v, azimuth, cosine),
the last one fastest, behind one row for what falls outside all of them; departures follow all arrivals.
"""

import numpy as np
from numba import int64

from transport.engine.addresses import view
from transport.engine.passes import lane_pass
from transport.engine.sums import slant
from transport.layout import LAYER, LAYERS, NO_TABLE, SHEET_SHIFT


@lane_pass(LAYERS)
def look_up_meter(b, table, first, live):
    """The meter of this layer where the hit is covered by one."""
    rows, layer = view(table.rows, table.count, LAYER), table.layer
    for k in range(first, live):
        row = rows[b.hit[k] >> SHEET_SHIFT]
        covered = (b.hit[k] >> layer) & 1
        b.sign[k] = row.sign if covered else 0.0
        b.base[k], b.cells[k] = row.base, row.cells
    return live


@lane_pass(LAYERS)
def bin_arrivals(b, table, first, live):
    """The cosine bin of what comes towards the meter's side."""
    for k in range(first, live):
        mu, cells = abs(b.mu[k]), b.cells[k]
        here = b.sign[k] * b.mu[k] < 0.0
        b.bin[k] = b.base[k] + 1 + min(int64(mu * cells), int64(cells) - 1) if here else 0
        b.slant[k] = slant(b.weight[k], mu)
    return live


@lane_pass(LAYERS)
def bin_departures(b, table, first, live):
    """The cosine bin of what leaves from the meter's side."""
    half = table.half
    for k in range(first, live):
        mu, cells = abs(b.mu[k]), b.cells[k]
        here = (b.sign[k] * b.mu[k] > 0.0) & (b.weight[k] != 0.0)
        b.base[k] += half
        b.bin[k] = b.base[k] + 1 + min(int64(mu * cells), int64(cells) - 1) if here else 0
        b.slant[k] = slant(b.weight[k], mu)
    return live


@lane_pass(LAYERS)
def bin_crossings(b, table, first, live):
    """Where nothing acts, a crossing is an arrival on one side and a departure from the other."""
    half = table.half
    for k in range(first, live):
        mu, cells = abs(b.mu[k]), b.cells[k]
        s = b.sign[k] * b.mu[k]
        b.base[k] += half if s > 0.0 else 0
        b.bin[k] = b.base[k] + 1 + min(int64(mu * cells), int64(cells) - 1) if s != 0.0 else 0
        b.slant[k] = slant(b.weight[k], mu)
    return live


@lane_pass(NO_TABLE)
def score(b, table, first, live):
    """Add the weight, its count and its slant to the bin's row."""
    sums = view(b.tallies, b.tally_words, np.int64)
    n = 0
    for k in range(first, live):
        b.listed[n] = k
        n += 1 if b.bin[k] != 0 else 0
    for j in range(n):
        k = b.listed[j]
        i = 4 * b.bin[k]
        sums[i] += b.high[k]
        sums[i + 1] += b.low[k]
        sums[i + 2] += 1
        sums[i + 3] += b.slant[k]
    return live
