"""Why a detector may have no score: the optical depth of the straight path to it, from geometry.

A run of n histories resolves a transmission well above 1/n, or, if weights decrease along the path, a weight
above FAINTEST of the birth weight.  Behind more optical depth a detector reads 0 whatever light there is, and
no score or error of the run shows it.  This module computes the optical depth, and the diffusing light, which
is at most about exp(-kappa z) with kappa^2 = 3 sigma_a (sigma_a + (1 - g) sigma_s) (Ishimaru 1978, equation
9-19).
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

FAINTEST = 2.0**-63  # of the largest birth weight: the unit of sums; smaller scores are counted by chance
DEEPEST = -math.log(FAINTEST)


@dataclass(frozen=True)
class Way:
    """Mean free paths along a straight path, and the decay exponent of diffusing light along it.

    absorbed, scattered: mean free paths to absorption and to scattering;  decay: the exponent.
    """

    absorbed: float
    scattered: float
    decay: float

    @property
    def depth(self) -> float:
        """Total number of mean free paths."""
        return self.absorbed + self.scattered

    def is_too_deep(self, plan: Plan, particles: int) -> bool:
        """Whether so many histories resolve next to no direct light, by chance or by too small weights."""
        chance = self.scattered if plan.tracking.absorption == "weighted" else self.depth
        return chance > math.log(particles) or self.depth > DEEPEST


def why_so_deep(plan: Plan, title: str, place: Shape | Vector, particles: int) -> str | None:
    """Message about a detector without a score if all straight paths to it cross thick media; None otherwise.

    title: name of the detector in the message;  place: its shape, or a point [m].
    """
    if plan.turned is not None or not has_media(plan.scene):
        return None
    ways = [(way_to(plan.scene, emitter, place), emitter) for emitter in plan.emitters]
    way, emitter = min(ways, key=lambda found: found[0].depth)
    is_hopeless = max(way.absorbed, way.decay) > DEEPEST
    if not (is_hopeless if plan.splits else way.is_too_deep(plan, particles)):
        return None
    where = (
        f"the straight path from {_titled(plan, emitter)} to it crosses {way.depth:.3g} mean free paths of"
        " media"
    )
    return f"no particle has reached {title}: {where}; {_cure(plan, emitter, way)}"


def _cure(plan: Plan, emitter: Emitter, way: Way) -> str:
    """What to do about light that is so faint, or that comes from so thin an outer layer."""
    if way.scattered == 0 and not emitter.source.emission.has_side and emitter.shape.is_closed:
        return (
            "only the outer mean free path of so dense a body is visible, and hardly any history is born"
            " there; let its surface emit instead, Lambertian(radiance=emission / absorption)"
        )
    if max(way.absorbed, way.decay) > DEEPEST:
        passes = (
            f"about exp(-{way.decay:.3g}) of the diffusing light"
            if way.scattered
            else f"exp(-{way.depth:.3g}) of it"
        )
        return (
            f"{passes} is transmitted, and no run resolves less than {FAINTEST:.0e} of a birth weight:"
            " place the detector at a smaller depth"
        )
    if way.scattered == 0:
        return f"exp(-{way.depth:.3g}) of it is transmitted: use tracking='weighted'"
    return (
        "use Tracking(splitting=Splitting(start=..., end=..., gain=...)) along this path, with a gain of"
        f" about 1 / transmission: {math.exp(way.decay):.0e} if light diffuses"
    )


def way_to(scene: Scene, emitter: Emitter, place: Shape | Vector) -> Way:
    """The straight path from the centre of an emitter to a detector: to its centre, or to its surface."""
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
    """Sum over the media along a straight line; a grid of voxels counts as its mean."""
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
    """Mean cosine of scattering; 1 if unknown, so that no path seems too deep."""
    match medium.phase:
        case HenyeyGreenstein(g=g):
            return g
        case Isotropic() | Rayleigh():
            return 0.0
    return 1.0


def _titled(plan: Plan, emitter: Emitter) -> str:
    numbers = [number for number, source in enumerate(plan.scene.sources) if source is emitter.source]
    return f"sources[{numbers[0]}]" if numbers else "an emitting medium"
