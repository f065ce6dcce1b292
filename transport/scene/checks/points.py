"""Refuse scenes that point detectors cannot see into."""

from __future__ import annotations

import math

from transport.geometry.shape import ROUNDING, Point
from transport.scene.materials import Surface
from transport.scene.parts import SceneParts, surface_name
from transport.scene.points import PointDetector
from transport.scene.sources import Source
from transport.validation import refuse, short_repr
from transport.vectors import Vector, dot

ON_SURFACE_TOLERANCE = 64 * ROUNDING  # distance relative to the coordinates at which a point is on a surface


def check_point_detectors(scene: SceneParts) -> None:
    """Check that the point detectors of a scene can be estimated.

    Raises
    ------
    SceneError
        If a surface, a source or a position is not allowed.
    """
    for detector in scene.points:
        for surface in scene.surfaces:
            _check_surface(scene, detector, surface)
        for source in scene.sources:
            _check_source(scene, detector, source)


def _check_surface(scene: SceneParts, detector: PointDetector, surface: Surface) -> None:
    if not surface.material.acts:
        return
    title = surface_name(scene, surface)
    for part in surface.material.elements:
        # no block to a ray, or of unknown radiance
        if part.is_specular or part.shares.glossy > 0 or not part.acts:
            must = "needs surfaces that are Black, Diffuse or Transparent throughout"
            cure = "use a small VolumeDetector instead"
            refuse(detector, f"{must}, got {part!r} of {title}; {cure}")
    if _lies_on(detector, surface.shape):
        cure = f"use Detector({surface.name or 'its name'!r}), or move the point off it"
        refuse(detector, f"position must not lie on {title}, got {short_repr(detector.position)}; {cure}")


def _check_source(scene: SceneParts, detector: PointDetector, source: Source) -> None:
    emission, shape = source.emission, scene.shape_of(source)
    if emission.measured_in != "watts":
        got = type(emission).__name__
        refuse(detector, f"needs Isotropic, Lambertian or Beam emission, got {got}; use a VolumeDetector")
    if source.aim is not None:
        cure = "leave out aim: every emission already sends a ray to the point"
        refuse(detector, f"needs sources without an aim, got aim={short_repr(source.aim)}; {cure}")
    is_point = isinstance(shape, Point)
    if emission.law == "isotropic" and is_point and detector.position == shape.position:
        refuse(
            detector,
            f"position must differ from that of a point source, got {short_repr(detector.position)}; move it",
        )
    if emission.law == "beam" and is_point and _lies_on_ray(detector, shape.position, emission.direction):
        cure = "move it off, or use a small VolumeDetector"
        refuse(
            detector,
            "position must not lie on a pencil beam, where the fluence rate is infinite,"
            f" got {short_repr(detector.position)}; {cure}",
        )
    if emission.law == "lambertian" and _lies_on(detector, shape):
        cure = "move the point off it"
        refuse(detector, f"position must not lie on a source, got {short_repr(detector.position)}; {cure}")


def _lies_on_ray(detector: PointDetector, origin: Vector, direction: Vector) -> bool:
    offset = [p - q for p, q in zip(detector.position, origin, strict=True)]
    ahead = dot(offset, direction)
    across = math.hypot(*(w - ahead * u for w, u in zip(offset, direction, strict=True)))
    return ahead >= 0 and across <= ON_SURFACE_TOLERANCE * sum(map(abs, (*origin, *detector.position)))


def _lies_on(detector: PointDetector, shape) -> bool:
    size = shape.coordinate_scale + sum(map(abs, detector.position))
    return shape.distance(detector.position) <= ON_SURFACE_TOLERANCE * size
