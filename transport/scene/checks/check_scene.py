"""Checks of a whole scene, in a table: one acting surface per point, finite histories, fitting media."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.relations import are_on_one_support, is_within, overlap
from transport.geometry.shape import ROUNDING, Shape
from transport.geometry.solid import Box
from transport.scene.bodies import scene_media
from transport.scene.checks.coplanar_meshes import check_coplanar_meshes
from transport.scene.checks.enclosures import check_lossless_enclosures
from transport.scene.checks.overlapping_bodies import check_filling
from transport.scene.checks.points import check_point_detectors
from transport.scene.checks.refractive_indices import check_media
from transport.scene.checks.trapping import check_total_internal_reflection
from transport.scene.detectors import MAX_PATHS
from transport.scene.parts import surface_name
from transport.scene.sheets import Sheet, SheetMember, is_closed_face, scene_sheets, shared_planes
from transport.statistics.findings import Check
from transport.validation import SceneError, refuse, short_repr
from transport.vectors import dot

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts


def check_scene(scene: SceneParts) -> None:
    """Raise SceneError if the parts of a scene do not fit together."""
    for check in SCENE_CHECKS:
        check.run(scene)


def check_supports(scene: SceneParts) -> None:
    """Refuse two acting surfaces at one place of a sheet, but for opaque ones of which a Box is one."""
    for sheet in scene_sheets(scene):
        for one, other in shared_planes(sheet):
            if (fault := _fault_of_shared_plane(scene, one, other)) is not None:
                names = f"{surface_name(scene, other.surface)} and {surface_name(scene, one.surface)}"
                raise SceneError(f"Scene: {names} {fault}")
            _check_between(scene, sheet, one, other)


def _check_between(scene: SceneParts, sheet: Sheet, one: SheetMember, other: SheetMember) -> None:
    """Refuse a detector of its own shape between two surfaces that share part of a plane."""
    for member in sheet.members:
        free = [detector for detector in member.detectors if not isinstance(detector.shape, str)]
        if free and all(
            _holds_bounds(each.shape, member.shape) and overlap(each.shape, member.shape)
            for each in (one, other)
        ):
            names = " and ".join(surface_name(scene, each.surface) for each in (one, other))
            refuse(
                free[0],
                f"shape must not lie between {names}, where nothing comes, got {short_repr(free[0].shape)};"
                " move it, or raise it by 1e-9 of its size",
            )


def _fault_of_shared_plane(scene: SceneParts, one: SheetMember, other: SheetMember) -> str | None:
    """Return the fault of two surfaces that share part of a plane; None where one acts on each side."""
    overlap_there = f"overlap on one {_support_name(one.shape)};"
    materials = [member.surface.material for member in (one, other)]
    if all(material.boundary for material in materials):
        return (
            f"{overlap_there} define the common face once, as a Plane, Disk or Rectangle with"
            " Dielectric(index behind, index in front), and make the bodies Transparent()"
            " there; a gap would be a film of air"
        )
    apart = "let them share an edge only, leave a gap of 1e-9 of their size, or leave one out"
    if any(material.is_transmissive for material in materials):
        return (
            f"{overlap_there} is a film of air between them meant, leave a gap of 1e-9 of their size;"
            " is it contact, build the clear body of open surfaces without this face"
        )
    closed = [member for member in (one, other) if is_closed_face(member)]
    if not closed:
        return f"{overlap_there} {apart}; a whole Box may stand on another surface"
    if len(closed) == 2:
        if dot(one.shape.normal, other.shape.normal) < 0:
            return None
        small, large = sorted((one.whole, other.whole), key=lambda box: box.extent)
        if is_within(small, large) and not is_within(large, small):  # nor the same within rounding
            return None
        return "stand through one another, with faces on one plane; move one, or make them one shape"
    (face,), (flat,) = closed, [member for member in (one, other) if member is not closed[0]]
    if flat.shape.is_infinite or not _holds_bounds(face.shape, flat.shape):
        return None
    if _holds_anything(scene, face.whole):
        return (
            f"{overlap_there} inside a Box its own face acts, which hides the other surface:"
            " raise that by 1e-9 of its size"
        )
    return None


def _holds_bounds(face: Shape, shape: Shape) -> bool:
    """Return whether a face of a box holds the bounding box of a shape on its plane."""
    (low, high), (first, last) = np.array(face.bounds), np.array(shape.bounds)
    gap = 64 * ROUNDING * max(face.coordinate_scale, shape.coordinate_scale)
    return bool((first >= low - gap).all() and (last <= high + gap).all())


def _holds_anything(scene: SceneParts, box: Box) -> bool:
    """Return whether a source, a detector or a whole surface lies in a box, and not on its faces alone."""
    shapes = [*(each.shape for each in scene.surfaces), *map(scene.shape_of, (*scene.sources, *scene.meters))]
    places = [shape.middle for shape in shapes if not shape.is_infinite and shape != box]
    places += [each.position for each in (*scene.points, *scene.instruments)]
    (low, high), gap = np.array(box.bounds), 64 * ROUNDING * box.coordinate_scale
    return any((low + gap < place).all() and (place < high - gap).all() for place in np.array(places))


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
    Check(
        "scene: surfaces",
        "Two acting surfaces at one point of a plane or quadric, other than a Box on an opaque surface.",
        run=check_supports,
    ),
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
