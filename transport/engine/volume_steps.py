"""Steps of volume detectors and tracks in a flight.

Paths are scored before their absorption, collisions before their effects.
"""

from transport.compile import layout
from transport.engine import sensors, tracks, volume_cells, volumes
from transport.engine.registry import step


def ways(plan):
    """Yield the steps that score path lengths in volumes, before the clock and absorption act."""
    counting = [volume for volume in plan.volumes if not volume.counts_collisions]
    if not (counting or plan.ways_room):
        return
    yield step(volumes.reach_next_in_media if plan.has_media else volumes.reach_next)
    if plan.has_clock:
        yield _end_of_clock(plan)
    if plan.ways_room:
        yield step(tracks.write_ways)
    for volume in counting:
        yield step(volumes.clip_to_box if volume.is_box else volumes.clip_to_ball, volume.row)
        yield from _directions(volume)
        for row in volume.grids:
            yield step(volume_cells.walk_through_grid, row)
        if plan.turned is not None:
            by_cell = sensors.score_way_by_cell_in_media if volume.absorbs else sensors.score_way_by_cell
            yield step(by_cell, volume.row)
        elif volume.has_cells:
            yield step(volume_cells.walk_through_cells, volume.row)
        else:
            yield step(volumes.score_way_in_media if volume.absorbs else volumes.score_way, volume.row)


def _end_of_clock(plan):
    """Return the step that limits a flight to the end of the clock."""
    if plan.has_media:
        rows = {"rows": plan.media.ctypes.data, "count": len(plan.media)}
        law = layout.row(layout.MEDIA_CLOCK, slowness=plan.slowness, has_speeds=plan.has_speeds, **rows)
        return step(volumes.reach_until_end_in_media, law)
    if plan.has_speeds:
        return step(volumes.reach_until_end_by_speed)
    return step(volumes.reach_until_end, layout.row(layout.CLOCK, duration=1.0, slowness=plan.slowness))


def _directions(volume):
    """Yield the step that bins directions, where all bins are of equal width."""
    if volume.row["is_even"]:
        yield step(volume_cells.find_even_bins, volume.row)


def collided(plan):
    """Yield the steps that score collisions in volumes."""
    counting = [volume for volume in plan.volumes if volume.counts_collisions]
    if not counting:
        return
    yield step(volume_cells.know_collisions)
    for row in plan.grids:
        yield step(volume_cells.know_collisions_in_grid, row)
    for volume in counting:
        yield from _directions(volume)
        in_box, in_ball = volume_cells.score_collisions_in_box, volume_cells.score_collisions_in_ball
        yield step(in_box if volume.is_box else in_ball, volume.row)
