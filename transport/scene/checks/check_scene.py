"""Checks of a whole scene, in a table: one acting surface per point, finite histories, fitting media."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.neighbours import touching_boxes
from transport.geometry.relations import are_on_one_support, overlap
from transport.geometry.shape import ROUNDING, Shape
from transport.scene.bodies import scene_media
from transport.scene.checks.coplanar_meshes import check_coplanar_meshes
from transport.scene.checks.enclosures import check_lossless_enclosures
from transport.scene.checks.overlapping_bodies import check_filling
from transport.scene.checks.points import check_point_detectors
from transport.scene.checks.refractive_indices import check_media
from transport.scene.checks.trapping import check_total_internal_reflection
from transport.scene.detectors import MAX_PATHS
from transport.scene.parts import surface_name
from transport.scene.sheets import SheetMember, scene_sheets
from transport.statistics.findings import Check
from transport.validation import SceneError, refuse, short_repr

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts


def check_scene(scene: SceneParts) -> None:
    """Raise SceneError if the parts of a scene do not fit together."""
    for check in SCENE_CHECKS:
        check.run(scene)


def check_supports(scene: SceneParts) -> None:
    """Refuse two acting surfaces at one point of a sheet."""
    for sheet in scene_sheets(scene):
        acting = [m for m in sheet.members if m.surface is not None]
        for one, other in _near_pairs(acting):
            if overlap(one.shape, other.shape):
                cure = "let them share an edge only, leave a gap of 1e-9 of their size, or leave one out"
                if all(member.surface.material.boundary for member in (one, other)):
                    cure = (
                        "define the common face once, as a Plane, Disk or Rectangle with"
                        " Dielectric(index behind, index in front), and make the bodies Transparent()"
                        " there; a gap would be a film of air"
                    )
                raise SceneError(
                    f"Scene: {surface_name(scene, other.surface)} and"
                    f" {surface_name(scene, one.surface)} overlap on one {_support_name(one.shape)};"
                    f" {cure}"
                )


def _near_pairs(members: list[SheetMember]) -> Iterator[tuple[SheetMember, SheetMember]]:
    """Yield each member with those before it whose bounding boxes it touches, within rounding."""
    if len(members) < 2:
        return
    low, high = np.array([member.shape.bounds for member in members]).transpose(1, 0, 2)
    gap = 64 * ROUNDING * max(member.shape.coordinate_scale for member in members)
    for k, near in enumerate(touching_boxes(low - gap, high)):
        yield from ((members[k], members[other]) for other in near[near < k].tolist())


def check_aims(scene: SceneParts) -> None:
    """Refuse a flat source that aims into its own plane, into which it does not emit."""
    for source in scene.sources:
        shape, aim = scene.shape_of(source), source.aim
        if aim is not None and aim.is_flat and shape.is_flat and are_on_one_support(shape, aim):
            refuse(
                source, f"aim must not lie in the source's own plane, got {short_repr(aim)}; aim elsewhere"
            )


def check_path_lengths(scene: SceneParts) -> None:
    """Refuse path lengths in media that the scene does not have, or in more than a lane has fields for."""
    known = scene_media(scene)
    for detector in scene.meters:
        for medium in detector.path_lengths or ():
            if medium not in known:
                must = "path_lengths must name media of the scene"
                cure = f"it has {', '.join(map(short_repr, known))}"
                refuse(detector, f"{must}, got {short_repr(medium)}; {cure}")
    if (many := len(scene.path_media)) > MAX_PATHS:
        must = f"path_lengths may name {MAX_PATHS} media at most, of all detectors together"
        raise SceneError(f"Scene: {must}, got {many}; use several scenes")


def _support_name(shape: Shape) -> str:
    """Kind of support in messages."""
    return "plane" if shape.is_flat else type(shape).__name__.lower()


# The checks of a scene, in their order.
SCENE_CHECKS = (
    Check(
        "scene: point detectors",
        "Point detectors beside mirrors, glass or gloss, on a surface, or with sources that send no ray to"
        " them.",
        run=check_point_detectors,
    ),
    Check("scene: surfaces", "Two acting surfaces at one point of a plane or quadric.", run=check_supports),
    Check(
        "scene: meshes",
        "Mesh faces that coincide with other shapes, so that rounding would decide which is hit first.",
        run=check_coplanar_meshes,
    ),
    Check(
        "scene: path lengths", "Path lengths in media that the scene does not have.", run=check_path_lengths
    ),
    Check("scene: aims", "A flat source that aims into its own plane.", run=check_aims),
    Check(
        "scene: enclosures",
        "Closed shapes, and open surfaces that join without a gap, in which light can neither be absorbed nor"
        " escape.",
        "Other endless histories, which the run stops.",
        check_lossless_enclosures,
    ),
    Check(
        "scene: total internal reflection",
        "Light trapped in clear spheres, boxes and slabs, or in an infinite medium that hardly absorbs.",
        "Light trapped in other shapes.",
        check_total_internal_reflection,
    ),
    Check(
        "scene: refractive indices",
        "Boundaries of dielectrics that contradict one another about the index between them.",
        "What is smaller than the spacing of some hundred lines through the surfaces, lies behind an opaque"
        " surface, or at the end of the scene.",
        check_media,
    ),
    Check(
        "scene: media",
        "Bodies of media that overlap, have gaps or reversed normals, or differ from the media that their"
        " surfaces name.",
        "Overlaps and gaps smaller than the spacing of the points and lines that probe them.",
        check_filling,
    ),
)
