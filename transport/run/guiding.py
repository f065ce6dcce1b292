"""Learn the guides of a plan's births by short runs, each guided by those before (compile/guides.py).

The short runs have numbers of their own and take no part in the result. What is learnt is a pure function of
the plan and the seed of the run, so that a run is repeated, continued and divided bit for bit.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import fields, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.compiler import compile_scene
from transport.compile.guides import BOLD, LEAST, MAX_SHARE, UNIFORM, Guide, learn_guide
from transport.compile.plan import Plan
from transport.geometry.flat import Disk, Rectangle
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.run.settings import checked_threads
from transport.scene.detectors import Detector
from transport.validation import SceneError

if TYPE_CHECKING:
    from transport.engine.driver import CompiledProgram
    from transport.engine.program import Program

# of histories that scored: the numbers that they were born from, (n, 4), and their squares, (n,)
Scores = tuple[np.ndarray, np.ndarray]

# of a run's seed: what is learnt must not depend on the run's own numbers
GUIDE_SEED_MASK = 0x6A09E667F3BCC908
# sums of histories that a round keeps in memory: with many detectors it has fewer histories
MAX_SUMS = 1 << 24
BATCHES = 8  # in which the histories of a round are run
# shares of the histories for the scene as it is, in rounds, and for each size of enlarged targets before
ROUNDS, ENLARGED_SHARE = (1 / 16, 1 / 16, 1 / 8, 1 / 4, 1 / 2), 1 / 16
# Targets are enlarged at first, to FIRST_REACH of the distance from which they are seen, then SHRINKAGE times
# smaller each time.
FIRST_REACH, SHRINKAGE, MAX_ENLARGED = 1.0, 4.0, 12
# Where there are more, enlarged ones would cover each other, or compiling the scene anew would take long.
MAX_TARGETS, MAX_SURFACES = 8, 200


def guided_program(plan: Plan, seed: int) -> Program:
    """Return the program of a plan whose births follow a guide learnt with this seed of a run."""
    from transport.engine.program import build_program

    return build_program(plan.apart(), learn_guides(plan, seed))


def learn_guides(plan: Plan, seed: int) -> list[Guide]:
    """Return a guide for each emitter of the plan.

    A target that few births could meet is enlarged at first: what leads to the small one leads to the large.
    """
    guides = [replace(UNIFORM, least=BOLD)] * len(plan.emitters)
    batches = itertools.count(step=BATCHES)
    for enlarged in _enlarged_plans(plan):
        found = _learn_round(enlarged, guides, seed, next(batches), ENLARGED_SHARE)
        guides = [learn_guide(*scores, guide) for scores, guide in zip(found, guides, strict=True)]
    plan, learnt = plan.apart(), [[] for _ in guides]
    for share in ROUNDS:
        found = _learn_round(plan, guides, seed, next(batches), share)
        learnt = [[*rounds, scores] for rounds, scores in zip(learnt, found, strict=True)]
        pooled = [tuple(map(np.concatenate, zip(*rounds, strict=True))) for rounds in learnt]
        guides = [learn_guide(*scores, guide) for scores, guide in zip(pooled, guides, strict=True)]
    return [replace(guide, least=LEAST) for guide in guides]


def _learn_round(plan: Plan, guides: list[Guide], seed: int, first: int, share: float) -> list[Scores]:
    """Run a share of the histories from batch `first` on; return what was found of each emitter."""
    from transport.engine.driver import compile_program
    from transport.engine.program import build_program

    sums = _sums_per_history(plan)
    compiled = compile_program(build_program(plan, guides, sums))
    histories = min(share * plan.method.guide, MAX_SUMS / int(sums["count"]))
    size = max(1, round(histories / BATCHES))
    run = partial(_run_part, compiled, seed ^ GUIDE_SEED_MASK, size)
    with ThreadPoolExecutor(checked_threads(None)) as pool:
        parts = list(pool.map(run, range(first, first + BATCHES)))
    return _by_emitter(plan, *map(np.concatenate, zip(*parts, strict=True)))


def _enlarged_plans(plan: Plan) -> Iterator[Plan]:
    """Yield plans with ever smaller targets, each larger than they are; none where all are large.

    Forward flights score even where the run sends rays: these do not depend on where a birth flies.
    """
    is_backward = plan.adjoint is not None
    method = plan.method if is_backward else replace(plan.method, estimator="analog")
    scene = plan.adjoint.scene if is_backward else plan.scene
    what = "sources" if is_backward else "detectors"
    targets = getattr(scene, what)
    if len(targets) > MAX_TARGETS or len(scene.surfaces) > MAX_SURFACES:
        return
    seen_from = [emitter.shape for emitter in plan.emitters]
    reaches = [_reach(target.shape, seen_from) for target in targets]
    largest = max(reaches, default=1.0)
    for step in range(MAX_ENLARGED):
        now = largest / SHRINKAGE**step
        if now <= SHRINKAGE / 2:
            return
        factors = [min(now, reach) for reach in reaches]
        enlarged = [
            replace(target, shape=_scaled(target.shape, factor)) if factor > 1 else target
            for target, factor in zip(targets, factors, strict=True)
        ]
        with suppress(SceneError):  # a larger target may touch or cut another shape
            other = compile_scene(replace(scene, **{what: enlarged}), plan.tracking, method)
            if len(other.emitters) == len(plan.emitters) and len(other.layers) <= 1 + len(plan.layers):
                yield other.apart()


def _reach(shape: Shape | str, seen_from: list[Shape]) -> float:
    """Return the factor by which a target may be enlarged: 1 for shapes that are not scaled."""
    if not isinstance(shape, Disk | Rectangle | Sphere) or shape.is_infinite or shape.hole is not None:
        return 1.0
    distance = min(place.distance(shape.middle) for place in seen_from)
    return max(1.0, FIRST_REACH * distance / shape.extent)


def _scaled(shape: Disk | Rectangle | Sphere, factor: float) -> Shape:
    """Return a shape enlarged about its middle."""
    sizes = {"width", "height", "radius", "inner_radius"} & {each.name for each in fields(shape)}
    return replace(shape, **{name: factor * getattr(shape, name) for name in sizes})


def _run_part(compiled: CompiledProgram, seed: int, histories: int, batch: int) -> tuple[np.ndarray, ...]:
    """Return what each history of a batch was born from, and what it brought."""
    from transport.engine.driver import run_batch

    raw = run_batch(compiled, seed, batch, histories)
    return raw.births, raw.brought


def _by_emitter(plan: Plan, births: np.ndarray, brought: np.ndarray) -> list[Scores]:
    """Return for each emitter the numbers that its scoring histories were born from, and their squares.

    A square is that of what a history brought to all detectors, over its birth weight. In forward runs each
    detector counts relative to its mean: its arrivals, or where there are none its departures. Where rare
    flights would pass for outliers among many small scores of rays, flights alone count.
    """
    many = max(1, len(plan.scene.meters))
    by_kind = brought.reshape(len(brought), -1, 2, many)  # flights, and rays if any are sent
    by_kind = np.where(by_kind[:, :, 0].any(axis=(0, 1)), by_kind[:, :, 0], by_kind[:, :, 1])
    if plan.adjoint is not None:
        is_met = [isinstance(lamp.detector, Detector) for lamp in plan.adjoint.sources]  # not in a volume
        gains = np.array([part.gains[is_met] for part in plan.adjoint.parts])
        by_kind = (by_kind * gains[births["origin"], None]).sum(axis=2, keepdims=True)
    means = by_kind.sum(axis=1).mean(axis=0)
    by_kind = (by_kind / np.where(means > 0, means, 1.0)).sum(axis=2)
    of_all, of_flights = (each**2 / births["worth"] for each in (by_kind.sum(axis=1), by_kind[:, 0]))
    squares = of_flights if of_flights.max() > MAX_SHARE * of_all.sum() else of_all
    scored = squares > 0
    births, squares = births[scored], squares[scored]
    numbers = np.stack([births[name] for name in ("u0", "u1", "u2", "u3")], axis=-1)
    return [
        (numbers[births["origin"] == k], squares[births["origin"] == k]) for k in range(len(plan.emitters))
    ]


def _sums_per_history(plan: Plan) -> np.ndarray:
    """Return the table of a history's sums: arrivals by detector, then departures; then those of rays.

    Scores of shadow rays are scaled like those of particles.
    """
    rows = plan.rows + 3 * plan.half
    factors, numbers = np.zeros(rows), np.zeros(rows, np.int64)
    scales = {each.detector.name: each.scale for each in plan.expectations}
    for number, detector in enumerate(plan.scene.meters):
        first = plan.rows_of[detector.name].base
        for block in range(4 if detector.name in scales else 2):
            row = first + block * plan.half
            factors[row] = 1.0 if block < 2 else 1.0 / scales[detector.name]
            numbers[row] = number + block * len(plan.scene.meters)
    place = plan.arena.place
    count = max(1, len(plan.scene.meters)) * (4 if scales else 2)
    return layout.row(
        layout.HISTORY_SUMS, factors=place(factors), numbers=place(numbers), rows=rows, count=count
    )
