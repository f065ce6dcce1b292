"""Phase space at an instant: binned (PhaseSpace), or recorded for a sample of particles (Snapshot).

A flight from `time` to `arrival` holds the instant if time <= instant < arrival: true for exactly one flight
of each history alive, so every particle is counted once.
"""

from transport.compile import layout
from transport.engine.bodies import lane_pass
from transport.engine.bundle import add_to_row, view
from transport.engine.passes.detector_bins import find_cell
from transport.engine.tally import add_long, limbs
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


@device
def is_alive_at(lane, table):
    """Return whether the flight holds the instant."""
    return (lane.time <= table.time) & (table.time < lane.arrival) & (lane.weight != 0.0)


@lane_pass(layout.PHASE, when=is_alive_at)
def count_phase_space(lane, table):
    """Add each particle alive at the instant to its phase-space bin, or to the outside row."""
    # Position and velocity at the instant; its bin by one or two coordinates.
    speed, ux, uy, uz = lane.speed, lane.ux, lane.uy, lane.uz
    length = lane.start + (table.time - lane.time) * speed
    x, y, z, vx, vy, vz = state_at(lane.x, lane.y, lane.z, ux, uy, uz, length, speed)
    inside = (x >= table.low_x) & (x <= table.high_x) & (y >= table.low_y) & (y <= table.high_y)
    inside &= (z >= table.low_z) & (z <= table.high_z)
    a = coordinate(table.a_kind, x, y, z, vx, vy, vz, speed, uz)
    found = find_cell(a, table.a_cells, lane.arena + table.a_edges) if inside else -1
    row = 1 + found * table.a_stride if found >= 0 else 0
    if found >= 0 and table.b_kind != 0:
        other = coordinate(table.b_kind, x, y, z, vx, vy, vz, speed, uz)
        found = find_cell(other, table.b_cells, lane.arena + table.b_edges)
        row = row + found * table.b_stride if found >= 0 else 0
    high, low = limbs(lane.weight)
    add_to_row(lane.tallies + 32 * (table.first + row), high, low, 1, 0)
    # Velocity sums, relative to the table's mean velocity and fastest speed.
    if table.moments >= 0:
        inverse, weight = 1.0 / table.fastest, lane.weight
        vx, vy, vz = (vx - table.vx) * inverse, (vy - table.vy) * inverse, (vz - table.vz) * inverse
        speed *= inverse
        sums = lane.moments + 32 * (table.moments + 7 * row)
        add_long(sums, weight * vx)
        add_long(sums + 32, weight * vy)
        add_long(sums + 64, weight * vz)
        add_long(sums + 96, weight * vx * vx)
        add_long(sums + 128, weight * vy * vy)
        add_long(sums + 160, weight * vz * vz)
        add_long(sums + 192, weight * speed)


@device
def is_alive_at(lane, table):
    """Return whether the flight holds the instant."""
    return (lane.time <= table.time) & (table.time < lane.arrival) & (lane.weight != 0.0)


@lane_pass(layout.SNAPSHOT, when=is_alive_at)
def record_snapshot(lane, table):
    """Record the state of one in `stride` histories alive at the instant."""
    if lane.history % lane.stride != lane.record_phase:
        return
    row = view(lane.records + RECORD_BYTES * lane.record_count, 1, layout.RECORD)[0]
    speed, ux, uy, uz = lane.speed, lane.ux, lane.uy, lane.uz
    length = lane.start + (table.time - lane.time) * speed
    x, y, z, vx, vy, vz = state_at(lane.x, lane.y, lane.z, ux, uy, uz, length, speed)
    row.x, row.y, row.z, row.vx, row.vy, row.vz = x, y, z, vx, vy, vz
    row.weight = lane.weight
    row.history, row.batch, row.snapshot = lane.history, lane.batch, table.number
    lane.record_count += 1


# ---- Tracks for pictures: each flight is recorded by the engine that flies it.

SEGMENT_BYTES = layout.PATH_SEGMENT.itemsize


@lane_pass(layout.NO_TABLE)
def record_tracks(lane, table):
    """Record each flight of this round, after volumes.set_flight_end; without room it is only counted."""
    if lane.weight != 0.0 and lane.flight_end > lane.start:
        if lane.flight_count < lane.tracks_capacity:
            row = view(lane.tracks + SEGMENT_BYTES * lane.flight_count, 1, layout.PATH_SEGMENT)[0]
            row.x, row.y, row.z = lane.x, lane.y, lane.z
            row.ux, row.uy, row.uz = lane.ux, lane.uy, lane.uz
            row.start, row.reach, row.weight = lane.start, lane.flight_end, lane.weight
            row.history = lane.history
            is_end = lane.flight_end == lane.distance
            row.met = 1 if is_end and lane.surface != 0 else 0
        lane.flight_count += 1
