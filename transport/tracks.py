"""The ways of a few particles through a scene, for pictures: written down by the engine that simulates it, and no other."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from transport.estimators.methods import checked_method
from transport.runs.limits import checked_whole
from transport.scene import Scene
from transport.simulate import checked_tracking
from transport.tracking import Tracking
from transport.validation import SceneError, shown

EACH = 64  # ways of a history, for which there is room at first
MOST_WAYS = 1 << 24  # 1.4 GB


@dataclass(frozen=True, eq=False)
class Tracks:
    """Flights of particles, in the order in which each history made them.

    starts: (N, 3) where each begins [m];  directions: (N, 3) unit vectors;  lengths: (N,) [m], infinite where nothing is ahead;
    weights: (N,) at their beginning, in birth weights of the brightest source;  histories: (N,) which particle;
    meets: (N,) whether they end at a surface.  scene: the one that they are of.  A meter in the way parts a flight in two.
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
        from transport.html.flights import tracks_html

        return tracks_html(self)

    def ends(self, reach: float) -> np.ndarray:
        """Where each ends, (N, 3) [m]; what flies off is drawn so far [m]."""
        lengths = np.where(np.isfinite(self.lengths), self.lengths, reach)
        return self.starts + lengths[:, None] * self.directions

    @property
    def ages(self) -> np.ndarray:
        """The length of way that a history has behind it where each flight begins, (N,) [m]."""
        goes_on = self.histories[1:] == self.histories[:-1]
        before = np.zeros(len(self))
        before[1:] = np.where(goes_on, self.lengths[:-1], 0.0)
        step = 1  # sums over 2, 4, 8 flights of one history: a sum over all would lose the digits of the short ones
        while (same := self.histories[step:] == self.histories[:-step]).any():
            before[step:] += np.where(same, before[:-step], 0.0)
            step *= 2
        return before


def tracks(
    scene: Scene, particles: int = 300, seed: int = 0, tracking: Tracking | str | None = None
) -> Tracks:
    """The ways of that many histories: those of the first batch of a run with this seed and so many particles a batch.

    tracking: as for `simulate`.  Where a scene is estimated backwards (cameras), they lead from the camera.  Raises SceneError
    for what cannot be run, for a Splitting or forced collisions, whose copies share a history, and for more than 2^24 flights.
    """
    if not isinstance(scene, Scene):
        raise SceneError(
            f"tracks: scene must be a Scene, got {shown(scene)}; write Scene(sources=[...], ...)"
        )
    particles = checked_whole("particles", particles, 1, MOST_WAYS)
    seed, tracking = checked_whole("seed", seed, 0, 2**64 - 1), checked_tracking(scene, tracking)
    plan, raw = _raw_ways(scene, particles, seed, tracking)
    ways = raw.ways[np.argsort(raw.ways["history"], kind="stable")]
    size, origin = plan.space.size, np.array(plan.space.origin)
    here, directions = (
        np.stack([ways[c] for c in columns], axis=-1) for columns in ("xyz", ("ux", "uy", "uz"))
    )
    return Tracks(
        scene=scene,
        starts=(here + ways["start"][:, None] * directions) * size + origin,
        directions=directions,
        lengths=(ways["reach"] - ways["start"]) * size,
        weights=ways["weight"].copy(),
        histories=ways["history"].copy(),
        meets=ways["met"] != 0,
    )


def _raw_ways(scene: Scene, particles: int, seed: int, tracking: Tracking | None):
    """A plan that writes ways down, and what its one batch gave; run again where there was no room for all."""
    from transport.compile import compile_scene
    from transport.engine.driver import machine_of, run_batch
    from transport.engine.program import program_of

    plan = compile_scene(scene, tracking, checked_method(scene, None, "random"))
    if plan.splits or plan.forces:
        raise SceneError(
            "tracks: copies of one history share its number; take a tracking without splitting or forced"
        )
    room = EACH * particles
    while True:
        plan = replace(plan, ways_room=min(room, MOST_WAYS))
        raw = run_batch(machine_of(program_of(plan)), seed, 0, particles)
        if raw.walked <= plan.ways_room:
            return plan, raw
        if raw.walked > MOST_WAYS:
            raise SceneError(
                f"tracks: at most {MOST_WAYS} flights, got {raw.walked} of {particles} particles; take fewer of them"
            )
        room = raw.walked
