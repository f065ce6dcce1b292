"""Optical depth of the straight path to a detector, from geometry: a reason for a detector without scores.

A run of n histories resolves a transmission well above 1/n, or, if weights decrease along the path, a weight
above SMALLEST_WEIGHT of the birth weight.  Behind more optical depth a detector reads 0 whatever light there
is, and no score or error of the run shows it.  This module computes the optical depth, and the diffusing
light, which is at most about exp(-kappa z) with kappa^2 = 3 sigma_a (sigma_a + (1 - g) sigma_s) (Ishimaru
1978, equation 9-19).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.line_crossings import crossings
from transport.geometry.shape import Point, Shape
from transport.results.diagnostics.proofs import source_title
from transport.scene.bodies import has_media, media_at
from transport.statistics.chunked import ChunkedArray, replicates_of
from transport.statistics.findings import Finding, doubtful, unseen_scores
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.compile.plan import Emitter, Plan
    from transport.results.batches import Batch
    from transport.results.tally import Tally
    from transport.scene.scene import Scene
    from transport.statistics.estimates import Estimate


SMALLEST_WEIGHT = 2.0**-63  # of the largest birth weight: the unit of sums; smaller ones count by chance
MAX_OPTICAL_DEPTH = -math.log(SMALLEST_WEIGHT)


@dataclass(frozen=True)
class StraightPath:
    """Mean free paths along a straight path, and the decay exponent of diffusing light along it.

    start, end: of the path [m];  absorbed, scattered: mean free paths to absorption and to scattering;
    turned: the share 1 - g of those to scattering;  decay: the exponent.
    """

    start: Vector
    end: Vector
    absorbed: float
    scattered: float
    turned: float
    decay: float

    @property
    def depth(self) -> float:
        """Total number of mean free paths."""
        return self.absorbed + self.scattered

    def is_too_deep(self, plan: Plan, particles: int) -> bool:
        """Return whether so many histories resolve next to no direct light, by chance or small weights."""
        chance = self.scattered if plan.tracking.absorption == "weighted" else self.depth
        return chance > math.log(particles) or self.depth > MAX_OPTICAL_DEPTH


def optical_depth_message(tally: Tally) -> str | None:
    """Message about a detector without a score whose straight paths all cross thick media; else None."""
    plan = tally.plan
    if plan.adjoint is not None or not has_media(plan.scene):
        return None
    paths = [(straight_path_to(plan.scene, emitter, tally.shape), emitter) for emitter in plan.emitters]
    path, emitter = min(paths, key=lambda found: found[0].depth)
    is_hopeless = max(path.absorbed, path.decay) > MAX_OPTICAL_DEPTH
    if not (is_hopeless if plan.splits else path.is_too_deep(plan, tally.particles)):
        return None
    source, cure = source_title(plan.scene, emitter.source), _depth_cure(plan, emitter, path)
    return (
        f"no particle has reached {tally.title}: the straight path from {source} to it crosses"
        f" {path.depth:.3g} mean free paths of media; {cure}"
    )


def _depth_cure(plan: Plan, emitter: Emitter, path: StraightPath) -> str:
    """Cure for light that is so faint, or that comes from so thin an outer layer."""
    if path.scattered == 0 and not emitter.source.emission.has_side and emitter.shape.is_closed:
        return (
            "only the outer mean free path of so dense a body is visible, and hardly any history is born"
            " there; let its surface emit instead, Lambertian(radiance=emission / absorption)"
        )
    if max(path.absorbed, path.decay) > MAX_OPTICAL_DEPTH:
        passes = f"exp(-{path.depth:.3g}) of it"
        if path.scattered:
            passes = f"about exp(-{path.decay:.3g}) of the diffusing light"
        return (
            f"{passes} is transmitted, and no run resolves less than {SMALLEST_WEIGHT:.0e} of a birth weight:"
            " place the detector at a smaller depth"
        )
    if path.scattered == 0:
        return f"exp(-{path.depth:.3g}) of it is transmitted: use tracking='weighted'"
    # 1 / transmission of a slab: by absorption, and without any (diffusion theory).
    gain = max(math.exp(path.decay), 1 + 0.75 * path.turned)
    start, end = (", ".join(f"{x:.10g}" for x in place) for place in (path.start, path.end))
    return (
        f"use tracking=Tracking(splitting=Splitting(start=({start}), end=({end}), gain={gain:.0e})), whose"
        " gain is 1 / transmission of light that diffuses"
    )


def straight_path_to(scene: Scene, emitter: Emitter, place: Shape) -> StraightPath:
    """The straight path from the centre of an emitter to a detector: to its centre, or to its surface."""
    start = np.array(emitter.shape.middle, float)
    ahead = np.array(place.middle, float) - start
    distance = float(np.linalg.norm(ahead))
    direction = ahead / distance if distance > 0 else np.array([0.0, 0.0, 1.0])
    if not isinstance(place, Point):
        met = crossings(place, start, direction).distances
        distance = float(np.min(met[met > 0], initial=math.inf if (met > 0).any() else distance))
    return _path_through_media(scene, start, direction, distance)


def _path_through_media(
    scene: Scene, start: np.ndarray, direction: np.ndarray, distance: float
) -> StraightPath:
    """Sum over the media along a straight line; a grid of voxels counts as its mean."""
    met = [crossings(surface.shape, start, direction).distances.ravel() for surface in scene.surfaces]
    ends = np.concatenate([[0.0], *met, [distance]])
    ends = np.unique(ends[(ends >= 0) & (ends <= distance)])
    lengths, path = np.diff(ends), np.zeros(4)
    media = media_at(scene, start + np.outer(ends[:-1] + lengths / 2, direction))
    for length, medium in zip(lengths, media, strict=True):
        absorbed, scattered = (float(np.mean(each)) for each in (medium.absorption, medium.scattering))
        turned, decay = 0.0, absorbed
        if scattered > 0:
            turned = scattered * (1 - medium.phase.g)
            decay = math.sqrt(3 * absorbed) * math.sqrt(absorbed + turned)
        path += length * np.array([absorbed, scattered, turned, decay])
    end = start + distance * direction
    return StraightPath(tuple(start.tolist()), tuple(end.tolist()), *path.tolist())


# ---- Diagnostic "roulette survivors": whether survivors may be missing from a number and its error.
#
# Roulette ends light histories and makes a few of them heavier.  If all arrivals at a detector are far
# lighter, a run may end before the first survivor arrives: its mean is then too low, and its error measures
# the spread of the light ones alone.  Such a run can be recognised: a single survivor would add more than the
# error allows.

MIN_RELATIVE_NOISE = 1e-6  # relative error below which scores have not passed a medium by chance


def survivor_findings(
    tally: Tally, total: Estimate, score: str, by: tuple[str, ...] | None, most: float = 1.0
) -> Iterator[Finding]:
    """Survivors of roulette of which none may have come.

    total: mean score of histories;  by: groups of axes of the bins, None without bins;  most: score in one of
    them of a history of the largest birth weight.  The bound, in the unit of `total`, covers survivors that
    did not come, or all weight for which roulette was played if that is less.  Nothing if no medium played
    roulette.
    """
    plan, batches = tally.plan, tally.batches
    plays_roulette = plan.has_roulette_in_flight or plan.splits
    if not plays_roulette or total.error <= MIN_RELATIVE_NOISE * total.value:
        return
    histories = tally.particles
    born = sum(batch.born for batch in batches) / histories
    if born == 0:  # an aim behind its source: nothing can be missing
        return
    # Bound the weight of missing survivors.
    heaviest = born * _max_relative_weight(plan, tally.shape.middle)
    is_by_share = plan.splits or plan.absorbs_weighted
    played = math.inf if is_by_share else _roulette_weight(batches, histories, heaviest)
    bound = min(unseen_scores(0) * heaviest / histories, played) * most
    if bound > 0:
        # Suggest a threshold at which one survivor adds less than the error.
        error = total.error if total.error > 0 else math.inf
        bins = None if by is None else tally.sums(score, by)
        if bins is not None and not isinstance(bins, ChunkedArray):
            means = bins / total.run.sizes.reshape(-1, *(1,) * (bins.ndim - 1))
            errors = replicates_of(means, total.run, False, None).error
            error = float(np.min(errors, where=errors > 0, initial=error))
        roulette = (error / most if math.isfinite(error) else heaviest / histories) / born
        yield _survivor_finding(plan, roulette, bound)


def _max_relative_weight(plan: Plan, place: Vector) -> float:
    """The largest possible weight of a history near a place, relative to its birth weight.

    Importance falls from there to the births; in voxels that absorb, nothing reduces the weight of an
    uncollided flight.
    """
    if plan.splits:
        rise_at = plan.tracking.splitting.rise_at
        births = max(rise_at(emitter.shape.middle) for emitter in plan.emitters)
        return min(1.0, math.exp(births - rise_at(place)))
    return 1.0 if plan.absorbs_weighted else plan.tracking.survivors_weight


def _roulette_weight(batches: list[Batch], histories: int, heaviest: float) -> float:
    """Approximate weight for which roulette was played, per history.

    Roulette kills w with chance 1 - w/h and gains h - w with chance w/h, where h is the heaviest weight.
    Until one has survived, the sum of the killed weight measures it; later the variance of the balance does,
    h times the sum of w.
    """
    balance = np.array([batch.ledger["roulette"] for batch in batches])
    return max(abs(balance.sum()), (balance**2).sum() / heaviest) / histories


def _survivor_finding(plan: Plan, roulette: float, bound: float) -> Finding:
    """The finding about missing light and its cure; roulette: a threshold that would suffice."""
    if plan.splits:
        what = "rare heavy histories that the Splitting thins out not sampled"
        gain = f"{plan.tracking.splitting.gain:g}"
        cure = f"let the Splitting rise towards it, and raise its gain, got {gain}, to about 1 / transmission"
    elif plan.absorbs_weighted:
        what = "uncollided particles through voxels not sampled"
        cure = "use more particles, or a Splitting"
    else:
        share, threshold = f"{plan.tracking.roulette:g}", math.floor(math.log10(roulette))
        what = f"rare survivors of Russian roulette, at {share} of the birth weight, not sampled"
        cure = f"pass tracking=Tracking(roulette=1e{threshold:03d}), or use a Splitting"
    return doubtful("roulette survivors", what, bound, cure)
