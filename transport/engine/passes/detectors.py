"""Scoring at surface detectors: which detector, which bin, and the exact sums.

Layer l of a sheet holds at most one detector; a lane finds it by (sheet, layer). Bins are ordered (u, v,
azimuth, cosine), the last fastest, after one row for values outside all bins; departures follow all arrivals.
"""

from numba import float64, int64, uint64

from transport.compile import layout
from transport.engine.bundle import add_to_row, view
from transport.engine.registry import lane_pass
from transport.engine.tally import (
    add_long,
    count_grazing,
    hash_salt,
    hashed_uniform,
    is_grazing,
    slant,
    unbiased_limbs,
)
from transport.engine.words import is_covered, sheet_of
from transport.physics.bits import bits_of
from transport.physics.device import device


@lane_pass(layout.LAYERS)
def find_detector(b, table, first, live):
    """Set the packed word of the detector of this layer on the sheet that was hit.

    Fields: reads `hit`; writes `detector_word`.
    """
    rows = view(table.rows, table.count, layout.LAYER)
    for k in range(first, live):
        b.detector_word[k] = rows[uint64(sheet_of(b.hit[k]))].detector_word
    return live


@device
def cosine_to_side(word, hit, layer, mu):
    """Return mu relative to the detector's side: negative for arrivals, positive for departures.

    0 without detector.
    """
    covered = (word != 0) & is_covered(hit, layer)
    return (-mu if word & layout.DETECTOR_BACK else mu) if covered else 0.0


@device
def cosine_bin(word, mu):
    """Return the row of the cosine bin relative to the detector's first row, which is the outside row."""
    cells = (word >> layout.DETECTOR_CELLS_SHIFT) & layout.DETECTOR_CELLS_MASK
    return 1 + min(int64(abs(mu) * float64(cells)), cells - 1)


@device
def bin_cosines(b, table, first, live, arrivals, departures):
    """Find the cosine bin of arrivals at the detector's side, of departures from it, or of both.

    Sets the integers to score too.

    Fields: reads `weight`, `history`, `hit`, `mu`, `detector_word`; writes `detector_row`, `bin`, `high`,
    `low`, `slant`, `is_grazing`.
    """
    layer, half, any_grazes, salt = table.layer, table.half, 0, hash_salt(b.seed_low, b.batch)
    for k in range(first, live):
        word, mu = b.detector_word[k], b.mu[k]
        side = cosine_to_side(word, b.hit[k], layer, mu)
        departs = departures & (side > 0.0)
        here = (departs | (arrivals & (side < 0.0))) & (b.weight[k] != 0.0)
        base = (word & layout.DETECTOR_BASE_MASK) + (half if departs else 0)
        b.detector_row[k], b.bin[k] = base, base + cosine_bin(word, mu) if here else 0
        any_grazes |= is_grazing(here, mu)
        chance = hashed_uniform(bits_of(abs(mu)), salt + b.history[k])
        b.high[k], b.low[k] = unbiased_limbs(b.weight[k], chance)
        b.slant[k] = slant(b.weight[k], mu, chance)
    b.any_grazing = any_grazes


@lane_pass(layout.LAYERS)
def bin_arrivals(b, table, first, live):
    """Find the cosine bin of arrivals at the detector's side (`bin_cosines`)."""
    bin_cosines(b, table, first, live, True, False)
    return live


@lane_pass(layout.LAYERS)
def bin_departures(b, table, first, live):
    """Find the cosine bin of departures from the detector's side (`bin_cosines`)."""
    bin_cosines(b, table, first, live, False, True)
    return live


@lane_pass(layout.LAYERS)
def bin_crossings(b, table, first, live):
    """Find the cosine bin where nothing acts: arrival on one side is departure from the other."""
    bin_cosines(b, table, first, live, True, True)
    return live


@lane_pass(layout.NO_TABLE)
def score(b, table, first, live):
    """Add weight, count and slant (weight/|mu|) to the row of the bin, for the few lanes that have one.

    Fields: reads `mu`, `bin`, `high`, `low`, `slant`, `is_grazing`.
    """
    n = 0
    for k in range(first, live):  # no branch, so no misprediction
        b.listed[n] = k
        n += 1 if b.bin[k] != 0 else 0
    for j in range(n):
        k = uint64(b.listed[j])
        add_to_row(b.tallies + 32 * b.bin[k], b.high[k], b.low[k], 1, b.slant[k])
    count_grazing(b, first, live)
    return live


@lane_pass(layout.NO_TABLE)
def score_all(b, table, first, live):
    """Add weight, count and slant where nearly every lane has a bin; row 0 takes the rest and is never read.

    Fields: reads `mu`, `bin`, `high`, `low`, `slant`, `is_grazing`.
    """
    for k in range(first, live):
        add_to_row(b.tallies + 32 * b.bin[k], b.high[k], b.low[k], 1, b.slant[k])
    count_grazing(b, first, live)
    return live


@lane_pass(layout.MOMENTS)
def score_moments(b, table, first, live):
    """Add normal momentum, speed and squared speed of the lanes with a bin to its three moment rows.

    Matter of speed v has momentum v per unit mass, light of energy w has w/v; both relative to the scene's
    extreme speeds.

    Fields: reads `weight`, `speed`, `mu`, `bin`.
    """
    n, fastest, slowest, is_light = 0, table.fastest, table.slowest, table.is_light
    place, each = table.place, table.each
    for k in range(first, live):
        b.listed[n] = k
        n += 1 if b.bin[k] != 0 else 0
    for j in range(n):
        k = b.listed[j]
        weight, v = b.weight[k], b.speed[k] / fastest
        momentum = slowest / b.speed[k] if is_light != 0 else v
        row = b.moments + 32 * (each * b.bin[k] + place)
        add_long(row, weight * abs(b.mu[k]) * momentum)
        add_long(row + 32, weight * v)
        add_long(row + 64, weight * v * v)
    return live


# ---- Filters by history: marks of visited objects (`via`) and numbers of reflections (`events`).


@lane_pass(layout.LAYERS)
def mark_visit(b, table, first, live):
    """Set the visit bit of the object at this crossing, where a detector has it in `via`.

    Fields: reads `hit`; updates `visited`.
    """
    rows, layer = view(table.rows, table.count, layout.LAYER), table.layer
    for k in range(first, live):
        mark = rows[sheet_of(b.hit[k])].mark
        b.visited[k] |= mark if is_covered(b.hit[k], layer) else 0
    return live


@lane_pass(layout.LAYERS)
def require_visits(b, table, first, live):
    """Drop the bin of lanes that have not visited all objects in the detector's `via`.

    Fields: reads `visited`, `detector_index`; updates `bin`.
    """
    detectors = view(table.detectors, table.detector_count, layout.DETECTOR)
    for k in range(first, live):
        if b.bin[k] != 0:
            via = detectors[b.detector_index[k]].via
            b.bin[k] = b.bin[k] if (b.visited[k] & via) == via else 0
    return live


@lane_pass(layout.LAYERS)
def require_reflections(b, table, first, live):
    """Drop the bin of lanes whose number of reflections lies outside the detector's `events`.

    Fields: reads `reflections`, `detector_index`; updates `bin`.
    """
    detectors = view(table.detectors, table.detector_count, layout.DETECTOR)
    for k in range(first, live):
        if b.bin[k] != 0:
            m = detectors[b.detector_index[k]]
            b.bin[k] = b.bin[k] if (b.reflections[k] >= m.least) & (b.reflections[k] <= m.most) else 0
    return live
