"""Checks of a whole scene: one acting surface per point, feasible aims, finite histories, fitting media."""

from __future__ import annotations

from typing import TYPE_CHECKING

from transport.geometry.relations import are_on_one_support, overlap
from transport.geometry.shape import Shape
from transport.scene.checks.coplanar_meshes import check_coplanar_meshes
from transport.scene.checks.enclosures import check_lossless_enclosures
from transport.scene.checks.overlapping_bodies import check_filling
from transport.scene.checks.points import check_point_detectors
from transport.scene.checks.refractive_indices import check_media
from transport.scene.checks.trapping import check_total_internal_reflection
from transport.scene.materials import Surface, display_name
from transport.scene.sheets import scene_sheets
from transport.validation import SceneError, refuse, short_repr

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts


def check_scene(scene: SceneParts) -> None:
    """Raise SceneError if the parts of a scene do not fit together."""
    check_point_detectors(scene)
    check_supports(scene)
    check_coplanar_meshes(scene)
    check_aims(scene)
    check_lossless_enclosures(scene)
    check_total_internal_reflection(scene)
    check_media(scene)
    check_filling(scene)


def check_supports(scene: SceneParts) -> None:
    """Refuse two acting surfaces at one point of a sheet."""
    for sheet in scene_sheets(scene):
        acting = [m for m in sheet.members if m.surface is not None]
        for i, one in enumerate(acting):
            for other in acting[:i]:
                if overlap(one.shape, other.shape):
                    cure = "let them share an edge only, leave a gap of 1e-9 of their size, or leave one out"
                    if all(member.surface.material.boundary for member in (one, other)):
                        cure = (
                            "define the common face once, as a Plane, Disk or Rectangle with"
                            " Dielectric(index behind, index in front), and make the bodies Transparent()"
                            " there; a gap would be a film of air"
                        )
                    raise SceneError(
                        f"Scene: {_surface_name(scene, other.surface)} and"
                        f" {_surface_name(scene, one.surface)} overlap on one {_support_name(one.shape)};"
                        f" {cure}"
                    )


def check_aims(scene: SceneParts) -> None:
    """Refuse a flat source that aims into its own plane, into which it does not emit."""
    for source in scene.sources:
        shape, aim = scene.shape_of(source), source.aim
        if aim is not None and aim.is_flat and shape.is_flat and are_on_one_support(shape, aim):
            refuse(
                source, f"aim must not lie in the source's own plane, got {short_repr(aim)}; aim elsewhere"
            )


def _support_name(shape: Shape) -> str:
    """Kind of support in messages."""
    return "plane" if shape.is_flat else type(shape).__name__.lower()


def _surface_name(scene: SceneParts, surface: Surface) -> str:
    """Name of a surface in messages."""
    return display_name(surface, scene.surfaces.index(surface))
