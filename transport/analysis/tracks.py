"""Paths of a few particles through a scene, for pictures, recorded by the engine itself."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from transport.compile.methods import coerce_method
from transport.io.html.elements import escaped, framed, heading, side_by_side, table, typeset
from transport.io.html.pictures import image
from transport.run.settings import checked_integer, coerce_tracking
from transport.scene.scene import Scene
from transport.scene.tracking import Tracking
from transport.validation import SceneError, checked_keywords, short_repr

FLIGHTS_PER_PARTICLE = 64  # flights per particle for which memory is allocated at first
MAX_FLIGHTS = 1 << 24  # most flights: 1.4 GB


@dataclass(frozen=True, eq=False)
class Tracks:
    """Straight flights of particles, grouped by particle in the order in which they were made.

    A detector on the path splits a flight in two.

    Parameters
    ----------
    scene : Scene
        Scene of the flights.
    starts : array (N, 3)
        Start of each flight [m].
    directions : array (N, 3)
        Unit vectors.
    lengths : array (N,)
        Lengths [m], infinite where nothing is ahead.
    weights : array (N,)
        Weights at the start, relative to the birth weight of the brightest source.
    histories : array (N,)
        Number of the particle.
    meets : array (N,) of bool
        Whether the flight ends at a surface.

    Examples
    --------
    >>> import transport as tp
    >>> shape = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0)
    >>> disk = tp.Surface(shape, tp.Black(), name="disk")
    >>> source = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    >>> scene = tp.Scene(sources=[source], surfaces=[disk], detectors=[tp.Detector("disk", "meter")])
    >>> paths = tp.tracks(scene, particles=3)
    >>> paths.meets
    array([ True, False, False])
    >>> paths.ends(reach=2.0).shape
    (3, 3)
    """

    scene: Scene
    starts: np.ndarray
    directions: np.ndarray
    lengths: np.ndarray
    weights: np.ndarray
    histories: np.ndarray
    meets: np.ndarray

    def __len__(self) -> int:
        return len(self.lengths)

    def __repr__(self) -> str:
        return f"<Tracks of {len(np.unique(self.histories))} particles in {len(self)} flights>"

    def _repr_html_(self) -> str:
        """Interactive drawing for notebooks."""
        return tracks_html(self)

    def ends(self, reach: float) -> np.ndarray:
        """Return the end of each flight.

        Parameters
        ----------
        reach : float
            Length [m] that stands for infinite flights.

        Returns
        -------
        array (N, 3)
            Ends [m].
        """
        lengths = np.where(np.isfinite(self.lengths), self.lengths, reach)
        return self.starts + lengths[:, None] * self.directions

    @property
    def ages(self) -> np.ndarray:
        """Path length of the particle before each flight, (N,) [m]."""
        goes_on = self.histories[1:] == self.histories[:-1]
        before = np.zeros(len(self))
        before[1:] = np.where(goes_on, self.lengths[:-1], 0.0)
        # Sum over 2, 4, 8 ... flights: one cumulative sum over all would lose the digits of short flights.
        step = 1
        while (same := self.histories[step:] == self.histories[:-step]).any():
            before[step:] += np.where(same, before[:-step], 0.0)
            step *= 2
        return before


@checked_keywords
def tracks(
    scene: Scene, particles: int = 300, seed: int = 0, tracking: Tracking | str | None = None
) -> Tracks:
    """Record the paths of a few particles: those of the first batch of a run with this seed and batch size.

    Parameters
    ----------
    scene : Scene
        Scene to trace.
    particles : int, default 300
        Number of particles.
    seed : int, default 0
        Seed.
    tracking : Tracking or str, optional
        As for `simulate`.

    Returns
    -------
    Tracks
        Flights of all particles. For scenes with cameras, which are estimated backward, paths start at the
        camera.

    Raises
    ------
    SceneError
        If the scene cannot be run, for splitting or forced collisions (whose copies share a particle number),
        and for more than 2^24 flights.

    Examples
    --------
    >>> import transport as tp
    >>> shape = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0)
    >>> disk = tp.Surface(shape, tp.Black(), name="disk")
    >>> source = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    >>> scene = tp.Scene(sources=[source], surfaces=[disk], detectors=[tp.Detector("disk", "meter")])
    >>> tp.tracks(scene, particles=3)
    <Tracks of 3 particles in 3 flights>
    """
    if not isinstance(scene, Scene):
        raise SceneError(
            f"tracks: scene must be a Scene, got {short_repr(scene)}; write Scene(sources=[...], ...)"
        )
    particles = checked_integer("particles", particles, 1, MAX_FLIGHTS)
    seed, tracking = checked_integer("seed", seed, 0, 2**64 - 1), coerce_tracking(scene, tracking)
    plan, raw = _record_flights(scene, particles, seed, tracking)
    # Sort by particle (stable: flights stay in order), and convert to metres in scene coordinates.
    flights = raw.tracks[np.argsort(raw.tracks["history"], kind="stable")]
    size, origin = plan.space.size, np.array(plan.space.origin)
    here, directions = (
        np.stack([flights[c] for c in columns], axis=-1) for columns in ("xyz", ("ux", "uy", "uz"))
    )
    return Tracks(
        scene=scene,
        starts=(here + flights["start"][:, None] * directions) * size + origin,
        directions=directions,
        lengths=(flights["reach"] - flights["start"]) * size,
        weights=flights["weight"].copy(),
        histories=flights["history"].copy(),
        meets=flights["met"] != 0,
    )


def _record_flights(scene: Scene, particles: int, seed: int, tracking: Tracking | None):
    """A plan that records flights, and the sums of its one batch; repeated if the memory was too small."""
    from transport.compile.compiler import compile_scene
    from transport.engine.driver import compile_program, run_batch
    from transport.engine.program import build_program

    plan = compile_scene(scene, tracking, coerce_method(scene, None, "random"))
    if plan.splits or plan.forces_collisions:
        raise SceneError(
            "tracks: copies of one particle share its number; use a tracking without splitting or forced"
        )
    # Run the batch; if the flights do not fit, repeat it with the memory that they need.
    room = FLIGHTS_PER_PARTICLE * particles
    while True:
        plan = replace(plan, max_path_segments=min(room, MAX_FLIGHTS))
        raw = run_batch(compile_program(build_program(plan)), seed, 0, particles)
        if raw.flight_count <= plan.max_path_segments:
            return plan, raw
        if raw.flight_count > MAX_FLIGHTS:
            raise SceneError(
                f"tracks: at most {MAX_FLIGHTS} flights, got {raw.flight_count} of {particles} particles;"
                " trace fewer particles"
            )
        room = raw.flight_count


# ---- Tracks in a notebook.
#
# Numbers of flights, and the paths of some particles as lines projected along one axis.

MAX_DRAWN_FLIGHTS = 400  # in the picture
SIZE = 2.6, 2.6  # inches
COLOUR = "#3b8ec2"
MIN_RELATIVE_EXTENT = 0.02  # of the largest extent, below which an axis is not shown
CLIPPED_SHARE = 0.01  # share of the points at either end that may lie outside the picture


def tracks_html(tracks: Tracks) -> str:
    """Numbers of flights, and a picture of the first ones."""
    if not len(tracks):
        return framed(heading("Tracks", "of no particle"))
    particles = len(np.unique(tracks.histories))
    flies_off = int(np.count_nonzero(~np.isfinite(tracks.lengths)))
    flights = tracks.lengths[np.isfinite(tracks.lengths)]
    rows = [
        ["particles", f">{particles}"],
        ["flights", f">{len(tracks)}"],
        ["end at a surface", f">{int(np.count_nonzero(tracks.meets))}"],
        ["leave the scene", f">{flies_off}"],
        *([["median length", f">{typeset(f'{np.median(flights):.3g} m')}"]] if flights.size else []),
    ]
    return framed(
        heading("Tracks", escaped(repr(tracks).strip("<>").removeprefix("Tracks "))),
        side_by_side(_flight_picture(tracks), table(rows)),
    )


def _flight_picture(tracks: Tracks) -> str:
    """The first flights, projected along one axis; the paler, the smaller the weight."""
    count = min(len(tracks), MAX_DRAWN_FLIGHTS)
    starts, weights = tracks.starts[:count], tracks.weights[:count]
    finite = np.isfinite(tracks.lengths[:count])
    within = np.concatenate([starts, tracks.ends(0.0)[:count][finite]])
    low, high = np.quantile(within, [CLIPPED_SHARE, 1 - CLIPPED_SHARE], axis=0)
    span = float((high - low).max()) or 1.0
    ends = tracks.ends(0.25 * span)[:count]
    plane = list(_picture_axes(high - low))
    middle, reach = 0.5 * (low + high)[plane], 0.625 * span
    opacities = 0.15 + 0.5 * np.clip(weights / max(weights.max(), 1e-300), 0, 1)

    def draw(figure) -> None:
        from matplotlib.collections import LineCollection

        axes = figure.subplots()
        lines = np.stack([starts[:, plane], ends[:, plane]], axis=1)
        axes.add_collection(LineCollection(lines, colors=COLOUR, alpha=opacities, linewidths=0.8))
        axes.set(xlim=middle[0] + reach * np.array([-1, 1]), ylim=middle[1] + reach * np.array([-1, 1]))
        axes.set(xlabel=f"{'xyz'[plane[0]]} [m]", ylabel=f"{'xyz'[plane[1]]} [m]", aspect="equal")

    return image(draw, SIZE, f"the first {count} flights, paler for smaller weight")


def _picture_axes(extents: np.ndarray) -> tuple[int, int]:
    """The two axes across and up: z is up, unless flights hardly extend along it."""
    if extents[2] < MIN_RELATIVE_EXTENT * extents.max():
        return 0, 1
    return (0 if extents[0] >= extents[1] else 1), 2
