"""Scoring at surface detectors: which detector, which bin, and the exact sums.

Layer l of a sheet holds at most one detector; a lane finds it by (sheet, layer). Bins are ordered (u, v,
azimuth, cosine), the last fastest, after one row for values outside all bins; departures follow all arrivals.
"""

from numba import int64, uint64

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import add_to_row, view
from transport.engine.tally import (
    add_long,
    count_of_score,
    hash_salt,
    hashed_uniform,
    slant,
    unbiased_limbs,
)
from transport.engine.words import is_covered
from transport.physics.bits import bits_of, real, whole
from transport.physics.device import choose, device


@lane_pass(layout.LAYERS)
def find_detector(lane, table):
    """Set the packed word of the detector of this layer on the sheet that was hit."""
    rows = view(lane.arena + table.rows, table.count, layout.LAYER)
    lane.detector_word = rows[uint64(lane.hit_sheet)].detector_word


@device
def cosine_to_side(word, covered, layer, mu):
    """Return mu relative to the detector's side: negative for arrivals, positive for departures.

    0 without detector.
    """
    is_seen = (word != 0) & is_covered(covered, layer)
    return (-mu if word & layout.DETECTOR_BACK else mu) if is_seen else 0.0


@device
def cosine_bin(word, mu):
    """Return the row of the cosine bin relative to the detector's first row, which is the outside row."""
    cells = (word >> layout.DETECTOR_CELLS_SHIFT) & layout.DETECTOR_CELLS_MASK
    return 1 + min(whole(abs(mu) * real(cells)), cells - 1)


@device
def bin_cosines(lane, table, arrivals, departures):
    """Find the cosine bin of arrivals at the detector's side, of departures from it, or of both.

    Sets the integers to score too.
    """
    word, mu = lane.detector_word, lane.mu
    side = cosine_to_side(word, lane.covered, table.layer, mu)
    departs = departures & (side > 0.0)
    here = (departs | (arrivals & (side < 0.0))) & (lane.weight != 0.0)
    base = (word & layout.DETECTOR_BASE_MASK) + (table.half if departs else 0)
    lane.detector_row, lane.bin = base, base + cosine_bin(word, mu) if here else 0
    lane.count = count_of_score(mu)
    chance = hashed_uniform(bits_of(abs(mu)), hash_salt(lane.seed_low, lane.batch) + lane.history)
    lane.high, lane.low = unbiased_limbs(lane.weight, chance)
    lane.slant = slant(lane.weight, mu, chance)


@lane_pass(layout.LAYERS)
def bin_arrivals(lane, table):
    """Find the cosine bin of arrivals at the detector's side (`bin_cosines`)."""
    bin_cosines(lane, table, True, False)


@lane_pass(layout.LAYERS)
def bin_departures(lane, table):
    """Find the cosine bin of departures from the detector's side (`bin_cosines`)."""
    bin_cosines(lane, table, False, True)


@lane_pass(layout.LAYERS)
def bin_crossings(lane, table):
    """Find the cosine bin where nothing acts: arrival on one side is departure from the other."""
    bin_cosines(lane, table, True, True)


@device
def add_score(lane):
    """Add weight, count and slant to the row of the bin, in a copy of the tallies (driver.Sums)."""
    row = lane.bin + int64(lane.number % uint64(layout.SCORE_COPIES)) * lane.copy_rows
    add_to_row(lane.tallies + 32 * row, lane.high, lane.low, lane.count, lane.slant)


@device
def has_bin(lane, table):
    """Return whether a lane scores."""
    return lane.bin != 0


@lane_pass(layout.NO_TABLE, when=has_bin)
def score(lane, table):
    """Add weight, count and slant (weight/|mu|) to the row of the bin, for the few lanes that have one."""
    add_score(lane)


@lane_pass(layout.NO_TABLE)
def score_all(lane, table):
    """Add weight, count and slant where nearly every lane has a bin.

    Row 0 takes the rest and is never read.
    """
    add_score(lane)


@lane_pass(layout.MOMENTS, when=has_bin)
def score_moments(lane, table):
    """Add normal momentum, speed and squared speed of the lanes with a bin to its three moment rows.

    Matter of speed v has momentum v per unit mass, light of energy w has w/v; both relative to the scene's
    extreme speeds.
    """
    weight, v = lane.weight, lane.speed / table.fastest
    momentum = table.slowest / lane.speed if table.is_light != 0 else v
    row = lane.moments + 32 * (table.each * lane.bin + table.place)
    add_long(row, weight * abs(lane.mu) * momentum)
    add_long(row + 32, weight * v)
    add_long(row + 64, weight * v * v)


# ---- Filters by history: marks of visited objects (`via`) and numbers of reflections (`events`).


@lane_pass(layout.LAYERS)
def mark_visit(lane, table):
    """Set the visit bit of the object at this crossing, where a detector has it in `via`."""
    rows, layer = view(lane.arena + table.rows, table.count, layout.LAYER), table.layer
    mark = rows[lane.hit_sheet].mark
    lane.visited |= mark if is_covered(lane.covered, layer) else 0


@lane_pass(layout.LAYERS)
def require_visits(lane, table):
    """Drop the bin of lanes that have not visited all objects in the detector's `via`."""
    detectors = view(lane.arena + table.detectors, table.detector_count, layout.DETECTOR)
    if lane.bin != 0:
        via = detectors[lane.detector_index].via
        lane.bin = choose((lane.visited & via) == via, lane.bin, 0)


@lane_pass(layout.LAYERS)
def require_reflections(lane, table):
    """Drop the bin of lanes whose number of reflections lies outside the detector's `events`."""
    detectors = view(lane.arena + table.detectors, table.detector_count, layout.DETECTOR)
    if lane.bin != 0:
        m = detectors[lane.detector_index]
        lane.bin = choose((lane.reflections >= m.least) & (lane.reflections <= m.most), lane.bin, 0)
