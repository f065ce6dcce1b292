"""Where particles are at the instants of a movie: by the clock, or as far along their tracks as they have flown.

With a clock they are samples of the same histories at each instant, by the engine's own snapshots.  A steady scene has no
clock: all particles of `tp.tracks` start together, and time is path length / c.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import transport as tp
from transport.units import speed_of_light
from transport.viz.facets import Bounds
from transport.viz.track_lines import clipped

if TYPE_CHECKING:
    from transport.results.phase_space import SnapshotReading

FRAMES = 60
SAMPLE = 3000  # particles of a frame
TAIL = 2.5  # frames, of the way behind a particle that is told
# diagonals of the box that particles fly at most: farther, they would jump from frame to frame
FARTHEST = 2.0
FAR = 1.5  # diagonals of the box: where all particles fly farther before they are in it, that way is left out
MOST_GONE = 0.95  # share of the particles that are gone at the end


class Instant(NamedTuple):
    """The particles' places (n, 3) [m], directions (n, 3) and weights (n,), and the ways behind them.

    seconds: since the start;  tails: (k, 2, 3) [m], from old to new, with the directions and weights of their flights.
    """

    seconds: float
    places: np.ndarray
    directions: np.ndarray
    weights: np.ndarray
    tails: np.ndarray = np.empty((0, 2, 3))
    tail_directions: np.ndarray = np.empty((0, 3))
    tail_weights: np.ndarray = np.empty(0)


def filmed(scene: tp.Scene, frames: int = FRAMES, particles: int = SAMPLE) -> tp.Scene:
    """The scene with a snapshot of so many particles at each of `frames` equal steps of its clock.

    Raises SceneError for a scene without a duration.
    """
    if scene.duration is None:
        raise tp.SceneError("filmed: needs a scene with a duration; a steady one is filmed along its tracks")
    times = np.linspace(0, scene.duration, frames)
    looks = [tp.Snapshot(float(time), particles, name=f"frame {k}") for k, time in enumerate(times)]
    return replace(scene, detectors=(*scene.detectors, *looks))


def snapped(shot: SnapshotReading) -> Instant:
    """A snapshot's particles; those at rest have no direction."""
    speeds = np.linalg.norm(shot.velocities, axis=1, keepdims=True)
    return Instant(
        shot.time, shot.positions, shot.velocities / np.where(speeds > 0, speeds, 1.0), shot.weights
    )


def flights(tracks: tp.Tracks, bounds: Bounds, count: int = FRAMES) -> tuple[list[Instant], bool]:
    """Instants until most of the particles are absorbed or out of the box; and whether they count from its edge.

    bounds: two corners of the box [m].
    """
    size = float(np.linalg.norm(bounds[1] - bounds[0]))
    first, last = clipped(tracks, bounds)
    entries = (tracks.ages + first)[first < last]
    is_far = bool(len(entries)) and entries.min() > FAR * size
    seen = from_entry(tracks, bounds) if is_far else tracks
    farthest = min(_farthest(seen, bounds), FARTHEST * size)
    ways = np.linspace(0, farthest, count)
    return [within(along(seen, float(way), TAIL * farthest / count), bounds) for way in ways], is_far


def along(tracks: tp.Tracks, way: float, tail: float) -> Instant:
    """Where the particles are that have flown so far [m], with what they have flown last [m] behind them."""
    first = tracks.ages
    last = first + tracks.lengths
    here = (first <= way) & (way < last)
    behind = (first < way) & (last > way - tail)
    ends = [np.maximum(first, way - tail)[behind], np.minimum(last, way)[behind]]
    starts, directions = tracks.starts[behind], tracks.directions[behind]
    tails = [starts + (end - first[behind])[:, None] * directions for end in ends]
    return Instant(
        seconds=way / speed_of_light,
        places=tracks.starts[here] + (way - first[here])[:, None] * tracks.directions[here],
        directions=tracks.directions[here],
        weights=tracks.weights[here],
        tails=np.stack(tails, axis=1),
        tail_directions=directions,
        tail_weights=tracks.weights[behind],
    )


def from_entry(tracks: tp.Tracks, bounds: Bounds) -> tp.Tracks:
    """The tracks from where each particle comes into the box; without those that never do.

    bounds: two corners of the box [m].  For sources so far that their light would never be in the picture at one time.
    """
    first, last = clipped(tracks, bounds)
    is_in = first < last
    _, numbers = np.unique(tracks.histories, return_inverse=True)
    entering = np.full(numbers.max(initial=0) + 1, len(tracks))
    np.minimum.at(entering, numbers[is_in], np.flatnonzero(is_in))
    rows = np.arange(len(tracks))
    cut = np.where(rows == entering[numbers], first, 0.0)
    kept = rows >= entering[numbers]
    starts, lengths = tracks.starts + cut[:, None] * tracks.directions, tracks.lengths - cut
    told = {name: getattr(tracks, name)[kept] for name in ("directions", "weights", "histories", "meets")}
    return replace(tracks, starts=starts[kept], lengths=lengths[kept], **told)


def within(instant: Instant, bounds: Bounds) -> Instant:
    """What of it is in the box: nothing farther off is drawn, or counted."""
    low, high = bounds
    here = ((low <= instant.places) & (instant.places <= high)).all(axis=1)
    near = ((low <= instant.tails) & (instant.tails <= high)).all(axis=(1, 2))
    return Instant(
        instant.seconds,
        *(values[here] for values in (instant.places, instant.directions, instant.weights)),
        *(values[near] for values in (instant.tails, instant.tail_directions, instant.tail_weights)),
    )


def _farthest(tracks: tp.Tracks, bounds: Bounds) -> float:
    """How far the particles fly until most of them are gone, absorbed or out of the box [m]."""
    first, last = clipped(tracks, bounds)
    is_in = first < last
    _, numbers = np.unique(tracks.histories[is_in], return_inverse=True)
    flown = np.zeros(numbers.max(initial=0) + 1)
    np.maximum.at(flown, numbers, (tracks.ages + last)[is_in])
    return float(np.quantile(flown, MOST_GONE))
