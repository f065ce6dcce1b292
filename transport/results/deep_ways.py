"""Why a detector may have counted nothing: the media on the straight way to it, told by geometry.

A run of n histories sees what passes with a chance well above 1/n, or, where weights fall along the way, what weighs more
than FAINTEST of its birth weight.  Beyond that a detector reads 0 whatever light there is, and nothing in the run tells: no
score, no error.  How many mean free paths lie before it does; and what diffuses through them is at most about exp(-kappa z),
kappa^2 = 3 sigma_a (sigma_a + (1 - g) sigma_s) (Ishimaru 1978, equation 9-19).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from transport.bodies.listing import has_media, media_at
from transport.emissions import Isotropic
from transport.media.phases import HenyeyGreenstein, Rayleigh
from transport.shapes.crossings import crossings

if TYPE_CHECKING:
    from transport.compile.plan import Emitter, Plan
    from transport.media import Grid, Medium
    from transport.scene import Scene
    from transport.shapes import Shape
    from transport.vectors import Vector

FAINTEST = 2.0**-63  # of the largest birth weight: the unit of sums, below which a score is counted by chance
DEEPEST = -math.log(FAINTEST)


@dataclass(frozen=True)
class Way:
    """Mean free paths to absorption and to scattering on a straight way, and by which exponent what diffuses along it has fallen."""

    absorbed: float
    scattered: float
    decay: float

    @property
    def depth(self) -> float:
        """Mean free paths in all."""
        return self.absorbed + self.scattered

    def is_too_deep(self, plan: Plan, particles: int) -> bool:
        """Whether so many histories see next to nothing of what comes straight, by chance or for being too light."""
        chance = self.scattered if plan.tracking.absorption == "weighted" else self.depth
        return chance > math.log(particles) or self.depth > DEEPEST


def why_so_deep(plan: Plan, title: str, place: Shape | Vector, particles: int) -> str | None:
    """What to know of a detector that counted nothing, where all straight ways to it lead through thick media.

    title: what the message calls it;  place: its shape, or a point [m].
    """
    if plan.turned is not None or not has_media(plan.scene):
        return None
    ways = [(way_to(plan.scene, emitter, place), emitter) for emitter in plan.emitters]
    way, emitter = min(ways, key=lambda found: found[0].depth)
    is_hopeless = max(way.absorbed, way.decay) > DEEPEST
    if not (is_hopeless if plan.splits else way.is_too_deep(plan, particles)):
        return None
    where = f"on the straight way from {_titled(plan, emitter)} to it are {way.depth:.3g} mean free paths of media"
    return f"nothing has come to {title}: {where}; {_cure(plan, emitter, way)}"


def _cure(plan: Plan, emitter: Emitter, way: Way) -> str:
    """What to do about light that is so faint, or comes from so thin a skin."""
    if way.scattered == 0 and not emitter.source.emission.has_side and emitter.shape.is_closed:
        return (
            "of what glows within so dense a body only a skin a mean free path thick is seen, in which hardly a history is"
            " born; let its surface emit instead, Lambertian(radiance=emission / absorption)"
        )
    if max(way.absorbed, way.decay) > DEEPEST:
        passes = (
            f"of what diffuses about exp(-{way.decay:.3g})"
            if way.scattered
            else f"exp(-{way.depth:.3g}) of it"
        )
        return f"{passes} passes, and no run tells less than {FAINTEST:.0e} of what a history is born with: look where it is less deep"
    if way.scattered == 0:
        return f"exp(-{way.depth:.3g}) of it passes: use tracking='weighted'"
    return (
        "use Tracking(splitting=Splitting(start=..., end=..., gain=...)) along it, with a gain of about 1 / transmission:"
        f" {math.exp(way.decay):.0e} if light diffuses"
    )


def way_to(scene: Scene, emitter: Emitter, place: Shape | Vector) -> Way:
    """The straight way from the middle of where light is born to a detector: to its middle, or to its surface."""
    start = np.array(emitter.shape.middle, float)
    is_point = isinstance(place, tuple)
    ahead = np.array(place if is_point else place.middle, float) - start
    distance = float(np.linalg.norm(ahead))
    direction = ahead / distance if distance > 0 else np.array([0.0, 0.0, 1.0])
    if not is_point:
        met = crossings(place, start, direction).distances
        distance = float(np.min(met[met > 0], initial=math.inf if (met > 0).any() else distance))
    return _through(scene, start, direction, distance)


def _through(scene: Scene, start: np.ndarray, direction: np.ndarray, distance: float) -> Way:
    """Sums over the media that a straight line leads through; voxels count as if they were mixed."""
    met = [crossings(surface.shape, start, direction).distances.ravel() for surface in scene.surfaces]
    ends = np.concatenate([[0.0], *met, [distance]])
    ends = np.unique(ends[(ends >= 0) & (ends <= distance)])
    lengths = np.diff(ends)
    way = np.zeros(3)
    for length, medium in zip(
        lengths, media_at(scene, start + np.outer(ends[:-1] + lengths / 2, direction)), strict=True
    ):
        absorbed, scattered = (float(np.mean(each)) for each in (medium.absorption, medium.scattering))
        decay = absorbed
        if scattered > 0:
            turned = scattered * (1 - _asymmetry(medium))
            decay = math.sqrt(3 * absorbed) * math.sqrt(absorbed + turned)
        way += length * np.array([absorbed, scattered, decay])
    return Way(*map(float, way))


def _asymmetry(medium: Medium | Grid) -> float:
    """The mean cosine of scattering; where it is not known as if all went forward, so that no way seems too deep."""
    match medium.phase:
        case HenyeyGreenstein(g=g):
            return g
        case Isotropic() | Rayleigh():
            return 0.0
    return 1.0


def _titled(plan: Plan, emitter: Emitter) -> str:
    numbers = [number for number, source in enumerate(plan.scene.sources) if source is emitter.source]
    return f"sources[{numbers[0]}]" if numbers else "what glows"
