"""Phase space at an instant: binned (PhaseSpace), or recorded for a sample of particles (Snapshot).

A flight from `time` to `arrival` holds the instant if time <= instant < arrival: true for exactly one flight
of each history alive, so every particle is counted once.
"""

from transport.compile import layout
from transport.engine.bundle import add_to_row, view
from transport.engine.passes.detector_bins import find_cell
from transport.engine.registry import lane_pass
from transport.engine.tally import add_long, limbs
from transport.engine.words import surface_of
from transport.physics.device import device
from transport.physics.velocities import state_at

RECORD_BYTES = layout.RECORD.itemsize


@device
def coordinate(kind, x, y, z, vx, vy, vz, speed, mu):
    """Return one of the coordinates of a phase space by its number."""
    value = x
    value = y if kind == 2 else value
    value = z if kind == 3 else value
    value = vx if kind == 4 else value
    value = vy if kind == 5 else value
    value = vz if kind == 6 else value
    value = speed if kind == 7 else value
    return mu if kind == 8 else value


@lane_pass(layout.PHASE)
def count_phase_space(b, table, first, live):
    """Add each particle alive at the instant to its phase-space bin, or to the outside row.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `start`, `time`, `speed`, `arrival`.
    """
    n, instant = 0, table.time
    for k in range(first, live):  # no branch, so no misprediction
        b.listed[n] = k
        n += 1 if (b.time[k] <= instant) & (instant < b.arrival[k]) & (b.weight[k] != 0.0) else 0
    for j in range(n):
        k = b.listed[j]
        # Position and velocity at the instant; its bin by one or two coordinates.
        speed, ux, uy, uz = b.speed[k], b.ux[k], b.uy[k], b.uz[k]
        length = b.start[k] + (instant - b.time[k]) * speed
        x, y, z, vx, vy, vz = state_at(b.x[k], b.y[k], b.z[k], ux, uy, uz, length, speed)
        inside = (x >= table.low_x) & (x <= table.high_x) & (y >= table.low_y) & (y <= table.high_y)
        inside &= (z >= table.low_z) & (z <= table.high_z)
        a = coordinate(table.a_kind, x, y, z, vx, vy, vz, speed, uz)
        found = find_cell(a, table.a_cells, table.a_edges) if inside else -1
        row = 1 + found * table.a_stride if found >= 0 else 0
        if found >= 0 and table.b_kind != 0:
            other = coordinate(table.b_kind, x, y, z, vx, vy, vz, speed, uz)
            found = find_cell(other, table.b_cells, table.b_edges)
            row = row + found * table.b_stride if found >= 0 else 0
        high, low = limbs(b.weight[k])
        add_to_row(b.tallies + 32 * (table.first + row), high, low, 1, 0)
        # Velocity sums, relative to the table's mean velocity and fastest speed.
        if table.moments >= 0:
            inverse, weight = 1.0 / table.fastest, b.weight[k]
            vx, vy, vz = (vx - table.vx) * inverse, (vy - table.vy) * inverse, (vz - table.vz) * inverse
            speed *= inverse
            sums = b.moments + 32 * (table.moments + 7 * row)
            add_long(sums, weight * vx)
            add_long(sums + 32, weight * vy)
            add_long(sums + 64, weight * vz)
            add_long(sums + 96, weight * vx * vx)
            add_long(sums + 128, weight * vy * vy)
            add_long(sums + 160, weight * vz * vz)
            add_long(sums + 192, weight * speed)
    return live


@lane_pass(layout.SNAPSHOT)
def record_snapshot(b, table, first, live):
    """Record the state of one in `stride` histories alive at the instant.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `history`, `start`, `time`, `speed`, `arrival`; updates
    `record_count`.
    """
    n, instant = 0, table.time
    for k in range(first, live):
        b.listed[n] = k
        n += 1 if (b.time[k] <= instant) & (instant < b.arrival[k]) & (b.weight[k] != 0.0) else 0
    stride, phase = b.stride, b.record_phase
    for j in range(n):
        k = b.listed[j]
        if b.history[k] % stride == phase:
            row = view(b.records + RECORD_BYTES * b.record_count, 1, layout.RECORD)[0]
            speed, ux, uy, uz = b.speed[k], b.ux[k], b.uy[k], b.uz[k]
            length = b.start[k] + (instant - b.time[k]) * speed
            x, y, z, vx, vy, vz = state_at(b.x[k], b.y[k], b.z[k], ux, uy, uz, length, speed)
            row.x, row.y, row.z, row.vx, row.vy, row.vz = x, y, z, vx, vy, vz
            row.weight = b.weight[k]
            row.history, row.batch, row.snapshot = b.history[k], b.batch, table.number
            b.record_count += 1
    return live


# ---- Tracks for pictures: each flight is recorded by the engine that flies it.

SEGMENT_BYTES = layout.PATH_SEGMENT.itemsize


@lane_pass(layout.NO_TABLE)
def record_tracks(b, table, first, live):
    """Record each flight of this round, after volumes.set_flight_end; without room it is only counted.

    Fields: reads `x, y, z`, `ux, uy, uz`, `weight`, `history`, `start`, `distance`, `hit`, `flight_end`;
    updates `flight_count`.
    """
    for k in range(first, live):
        if b.weight[k] != 0.0 and b.flight_end[k] > b.start[k]:
            if b.flight_count < b.tracks_capacity:
                row = view(b.tracks + SEGMENT_BYTES * b.flight_count, 1, layout.PATH_SEGMENT)[0]
                row.x, row.y, row.z = b.x[k], b.y[k], b.z[k]
                row.ux, row.uy, row.uz = b.ux[k], b.uy[k], b.uz[k]
                row.start, row.reach, row.weight = b.start[k], b.flight_end[k], b.weight[k]
                row.history = b.history[k]
                is_end = b.flight_end[k] == b.distance[k]
                row.met = 1 if is_end and surface_of(b.hit[k]) != 0 else 0
            b.flight_count += 1
    return live
