"""The clock: time of birth, time of arrival, end of the clock. Only in scenes with a duration.

Times are in durations. A flight lasts from `time` to `arrival`, and the next begins at that very number, so
an instant belongs to exactly one flight of each history and each particle is scored once per instant.
"""

from transport.compile.layout import CLOCK, IN_FLIGHT, MEDIA, MEDIA_CLOCK, MOMENT, NO_TABLE
from transport.engine.addresses import view
from transport.engine.ledger import enter
from transport.engine.passes import lane_pass
from transport.engine.sums import limbs
from transport.physics.streams import CLOCK as CLOCK_DRAW
from transport.physics.streams import random_words, uniform
from transport.physics.velocities import sample_normal_pair


@lane_pass(MOMENT)
def start_at(b, table, first, live):
    """Set one time of birth for all.

    Fields: writes `time`.
    """
    start = table.start
    for k in range(first, live):
        b.time[k] = start
    return live


@lane_pass(MOMENT)
def start_within(b, table, first, live):
    """Sample a time of birth uniformly in an interval: a steady source, or a pulse of constant power.

    Fields: reads `history`; writes `time`.
    """
    start, width = table.start, table.width
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, _, _ = random_words(b.history[k], batch, 0, CLOCK_DRAW, seed_low, seed_high)
        b.time[k] = start + uniform(w0, w1) * width
    return live


@lane_pass(MOMENT)
def start_within_and_draw(b, table, first, live):
    """The same, and keep in u0 the uniform for a speed from the same random block.

    Fields: reads `history`; writes `time`, `u0`.
    """
    start, width = table.start, table.width
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, CLOCK_DRAW, seed_low, seed_high)
        b.time[k], b.u0[k] = start + uniform(w0, w1) * width, uniform(w2, w3)
    return live


@lane_pass(MOMENT)
def start_about(b, table, first, live):
    """Sample a time of birth from a Gaussian pulse; width: its standard deviation.

    Fields: reads `history`; writes `time`.
    """
    start, width = table.start, table.width
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    for k in range(first, live):
        w0, w1, w2, w3 = random_words(b.history[k], batch, 0, CLOCK_DRAW, seed_low, seed_high)
        deviation, _ = sample_normal_pair(uniform(w0, w1), uniform(w2, w3))
        b.time[k] = start + width * deviation
    return live


@lane_pass(CLOCK)
def time_arrival(b, table, first, live):
    """Set the time at the end of the flight, for one common speed; infinite without a surface ahead.

    Fields: reads `start`, `distance`, `time`; writes `arrival`.
    """
    slowness = table.slowness
    for k in range(first, live):
        b.arrival[k] = b.time[k] + (b.distance[k] - b.start[k]) * slowness
    return live


@lane_pass(NO_TABLE)
def time_arrival_by_speed(b, table, first, live):
    """The same with the particle's own speed; infinite at rest.

    Fields: reads `start`, `distance`, `time`, `speed`; writes `arrival`.
    """
    for k in range(first, live):
        b.arrival[k] = b.time[k] + (b.distance[k] - b.start[k]) / b.speed[k]
    return live


@lane_pass(MEDIA_CLOCK)
def time_arrival_in_media(b, table, first, live):
    """The same in media, where light slows down by the refractive index; lanes that wait keep their time.

    Fields: reads `start`, `distance`, `time`, `speed`, `medium`, `flies`; writes `arrival`.
    """
    rows, slowness, has_speeds = view(table.rows, table.count, MEDIA), table.slowness, table.has_speeds != 0
    for k in range(first, live):
        pace = rows[b.medium[k]].index * slowness
        pace = 1.0 / b.speed[k] if has_speeds else pace
        way = b.distance[k] - b.start[k]
        b.arrival[k] = b.time[k] + (way * pace if b.flies[k] != 0 else 0.0)
    return live


@lane_pass(CLOCK)
def stop_clock(b, table, first, live):
    """End particles whose flight outlasts the clock, as in flight; advance the time of the others.

    Fields: reads `arrival`; updates `weight`, `hit`; writes `time`.
    """
    high, low, duration = 0, 0, table.duration
    for k in range(first, live):
        arrival = b.arrival[k]
        late = arrival > duration
        w_high, w_low = limbs(b.weight[k] if late else 0.0)
        high += w_high
        low += w_low
        b.time[k] = arrival
        b.hit[k] = 0 if late else b.hit[k]
        b.weight[k] = 0.0 if late else b.weight[k]
    enter(b, IN_FLIGHT, high, low)
    return live
