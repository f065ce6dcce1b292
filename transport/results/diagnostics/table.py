"""The table of checks of a scene and diagnostics of a run (`transport checks`): what each can detect."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.neighbours import touching_boxes
from transport.geometry.piercing import passes_through
from transport.geometry.relations import is_within, solids_overlap
from transport.geometry.solid import Box, Sphere
from transport.results.diagnostics.proofs import source_title
from transport.scene.checks.check_scene import SCENE_CHECKS
from transport.scene.parts import join_surface_names, surface_name
from transport.statistics.batches import MIN_SCORES_FOR_ERROR as FEW
from transport.statistics.findings import Check

if TYPE_CHECKING:
    from transport.results.record import Record


def lost_particles(result: Record) -> Iterator[str]:
    """Yield messages about lost particles and contradictory media, and about aims without births."""
    batches, emitters = result.batches, result.plan.emitters
    if lost := sum(batch.lost for batch in batches):
        yield (
            f"{lost} histories were lost, and their weight is in the ledger as `lost`: a history in a finite"
            " body of a medium had no surface ahead (the surfaces leave a gap, or a ray ran along an edge),"
            " or had more than 2^24 events"
        )
    if unseen := sum(batch.unseen for batch in batches):
        yield (
            f"{unseen} times a particle left a body of a medium without having entered it: its surfaces"
            " leave a gap, or rays ran along an edge"
        )
    if astray := sum(batch.astray for batch in batches):
        yield (
            f"{astray} times light reached a Dielectric from a medium of another index than the surface"
            " separates: close its gaps, or give adjacent media the same index"
        )
    is_aimed = result.plan.adjoint is None and any(emitter.target is not None for emitter in emitters)
    if is_aimed and sum(batch.born for batch in batches) == 0:
        yield "nothing is emitted towards the aim: it lies behind its source"


def faint_sources(result: Record) -> Iterator[str]:
    """Yield a warning for each source with fewer than FEW expected histories.

    Births are drawn in proportion to power.
    """
    plan, particles = result.plan, result.particles
    if plan.adjoint is not None:
        return
    total = math.fsum(emitter.bound for emitter in plan.emitters)
    for source in plan.scene.sources:
        share = math.fsum(emitter.bound for emitter in plan.emitters if emitter.source is source) / total
        if share < 0.5 and particles * share < FEW:
            yield (
                f"{source_title(plan.scene, source)} has {share:.2g} of the total power and so about"
                f" {particles * share:.2g} of {particles} histories: light that only it provides is not"
                " resolved; simulate it in a separate scene and add the results"
            )


def partial_aims(result: Record) -> Iterator[str]:
    """Yield the detectors for which an aim does not cover every path."""
    scene = result.scene
    aims = [source.aim for source in scene.sources if source.aim is not None and result.plan.adjoint is None]
    for detector in (*scene.meters, *scene.volumes) if aims else ():
        via = [other for other in scene.meters if other.name in (getattr(detector, "via", None) or ())]
        covered = [scene.shape_of(other) for other in (detector, *via)]
        if any(aim not in covered for aim in aims):
            yield f"{result[detector.name].title} sees an aimed source only in the directions of its aim"


def crossing_shapes(result: Record) -> Iterator[str]:
    """Yield a warning about whole boxes and spheres that stand through one another."""
    scene = result.scene
    closed = [
        (number, surface.shape)
        for number, surface in enumerate(scene.surfaces)
        if isinstance(surface.shape, (Box, Sphere)) and surface.shape.is_closed
    ]
    if len(closed) < 2:
        return
    low, high = np.array([shape.bounds for _, shape in closed]).transpose(1, 0, 2)
    found = [
        (closed[k][0], closed[other][0])
        for k, near in enumerate(touching_boxes(low, high))
        for other in near[near < k].tolist()
        if _stand_through(closed[k][1], closed[other][1])
    ]
    if found:
        more = f" (and {len(found) - 1} more such pairs)" if len(found) > 1 else ""
        names = join_surface_names(scene, sorted(found[0]))
        yield f"{names} stand through one another{more}: move one, or leave it if that is meant"


def crossing_sources(result: Record) -> Iterator[str]:
    """Yield a warning about sources that pass through an opaque surface."""
    scene = result.scene
    walls = [surface for surface in scene.surfaces if not surface.material.is_transmissive]
    if not walls:
        return
    low, high = np.array([surface.shape.bounds for surface in walls]).transpose(1, 0, 2)
    found = []
    for source in scene.sources:
        if isinstance(source.shape, str) or not source.emission.has_side:
            continue
        first, last = source.shape.bounds
        near = np.flatnonzero(((low <= last) & (first <= high)).all(axis=1)).tolist()
        if (
            wall := next((walls[k] for k in near if passes_through(source.shape, walls[k].shape)), None)
        ) is not None:
            found.append(
                f"{source_title(scene, source)} passes through the opaque {surface_name(scene, wall)}"
            )
    if found:
        more = f" (and {len(found) - 1} more such sources)" if len(found) > 1 else ""
        yield (
            f"{found[0]}{more}: a part of its power is emitted behind that surface. Move the source or make"
            " it smaller, or leave it if that is meant"
        )


def _stand_through(one: Box | Sphere, other: Box | Sphere) -> bool:
    return solids_overlap(one, other) and not (is_within(one, other) or is_within(other, one))


DIAGNOSTICS = (
    Check(
        "crossing shapes",
        "Whole boxes and spheres that stand through one another.",
        "Other shapes.",
        crossing_shapes,
    ),
    Check(
        "crossing sources",
        "Sources of a surface's shape that pass through an opaque surface.",
        "Sources that are infinite or meshes of very many facets, and a wall so small that it lies between"
        " the lines drawn on the source.",
        crossing_sources,
    ),
    Check(
        "path class",
        f"Light that an estimator finds only by chance and that has fewer than {FEW} scores: via mirrors,"
        " glass or lenses, in the middle of the narrow lobe of gloss, from beams, from very near, or from a"
        " lamp that backward histories rarely reach. Its bound is Poisson's 95 % limit times the largest"
        " score, or the result of a probe, whichever is less; a class that geometry proves to be empty is"
        " left out.",
        "Which surface the light comes from, if there are several; and a class with many, but unequal"
        " scores.",
    ),
    Check(
        "all light",
        f"A detector that light reaches only by chance, and that has fewer than {FEW} scores, or a sum below"
        f" {FEW} times the most that one history can score.",
        "Where the light would come from; light from very few histories with thousands of scores each,"
        " beside light from many histories, as between two mirrors of reflectance 0.9999; and a gap in a"
        " scattering medium, for which scores of all weights count alike.",
    ),
    Check(
        "strong rays",
        f"Rays from walls and lamps so near to a detector that each scores much, if fewer than {FEW} were"
        " counted.",
        "Which wall or lamp they would come from.",
    ),
    Check(
        "near emitter",
        "A point detector so near to a diffuse wall, an emitter or a scattering medium that hardly any"
        " history reaches the nearest spot, from where half of the light comes; and a small lamp nearby"
        " with hardly any births.",
        "Mirrors; a scene cannot have them beside point detectors.",
    ),
    Check(
        "unvisited surface",
        "A diffuse or glossy surface close to a detector with next-event estimation, if hardly any history"
        " reached it.",
        "A small bright spot on a large surface that histories reach elsewhere.",
    ),
    Check(
        "forward peak",
        "Scattering so sharply forward that one collision pointing at the detector would exceed the error.",
        "Peaks of tabulated phase functions narrower than their table.",
    ),
    Check(
        "roulette survivors",
        "Heavy survivors of Russian roulette, or uncollided histories through voxels, of which none may"
        " have come.",
        "Weight that was never followed, such as the directions that an aim leaves out.",
    ),
    Check(
        "few carriers",
        "An error that a few scores carry, though there may be many: from the variance of the variance, and"
        f" from a spread of the batches like that of fewer than {FEW} scores, as where one history scores"
        " hundreds of times.",
        "Scores that are still missing.",
    ),
    Check(
        "tail",
        "Larger scores that the law of the largest predicts, if none has come.",
        "A second kind of score, larger than the law predicts.",
    ),
    Check(
        "batches",
        "A trend from batch to batch, or one batch far above all others, which chance produces once in 1e6"
        " runs.",
        "Contributions that all batches miss.",
    ),
    Check(
        "unknown error",
        "A number without a score, or from batches that gave all the same; with sobol and stratified also"
        " an error smaller than one score is worth, as even points may give every batch one too many.",
        "Why there is no score.",
    ),
    Check(
        "bins",
        "Bins, cells and pixels whose error is unknown although the total is sound.",
        "Structure finer than a bin.",
    ),
    Check(
        "enclosed detector",
        "A detector that provably no light can reach: it is enclosed by opaque walls, behind every source,"
        " or facing away.",
        "Light that only chance missed; curved walls that separate two places without enclosing either.",
    ),
    Check(
        "optical depth",
        "A detector behind so many mean free paths that no run of this length resolves the transmitted"
        " light.",
        "Paths around a thick medium.",
    ),
    Check(
        "faint source",
        "A source with so small a share of the power that hardly any history is born on it.",
        f"A faint source whose light matters in few bins, if it has {FEW} histories or more.",
        faint_sources,
    ),
    Check(
        "grazing",
        "A fluence rate from crossings so close to grazing that it depends on the cut at |mu| = 0.001.",
        "Asymmetric light on which batches disagree; a few grazing crossings among steep ones that are"
        " still missing, each of which scores up to 1000 times as much.",
    ),
    Check(
        "aim",
        "A detector that sees an aimed source only in the directions of its aim.",
        "How much light the aim leaves out.",
        partial_aims,
    ),
    Check(
        "lost particles",
        "Particles lost at gaps and edges, or in media that contradict their surfaces.",
        "A gap that lets light escape from a scene without a medium.",
        lost_particles,
    ),
    Check("thin batches", "Batches with fewer histories than a sensor has bins."),
    Check("run", "What the run itself reports: an error that was not reached, or a file not written."),
)
CHECKS = (*SCENE_CHECKS, *DIAGNOSTICS)
