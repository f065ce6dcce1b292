"""Solid angles by Monte Carlo: the share of all directions that hit a shape, times 4 pi."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from transport.geometry.relations import is_on_support
from transport.geometry.shape import ROUNDING, Point, Shape
from transport.geometry.solid import Sphere
from transport.results.result import Result
from transport.scene.detectors import Detector
from transport.scene.emissions import Isotropic
from transport.scene.materials import Black, Surface
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.simulate import simulate
from transport.statistics.estimates import Estimate
from transport.validation import SceneError, as_floats, checked_keywords, short_repr
from transport.vectors import Vector

SHAPE_NAME = "shape"  # name of the detector


@checked_keywords
def solid_angle(
    shape: Shape, position: Iterable[float], particles: int = 1_000_000, seed: int = 0
) -> Estimate:
    """Estimate the solid angle that a shape subtends at a position.

    Particles leave the position isotropically, or only towards the shape with the exact weight, and each that
    reaches the shape scores once. From outside a closed shape its outside counts; from inside the solid angle
    is 4 pi. The result is exact, without an error, if nothing is left to chance: for a sphere, inside a
    closed shape, and in the plane of a flat shape.

    Parameters
    ----------
    shape : Shape
        Rectangle, Disk, Triangle, Polygon, Sphere, Box, Cylinder, Cone, Paraboloid or Mesh.
    position : three floats
        Position [m], not on the shape.
    particles : int, default 1_000_000
        Number of particles.
    seed : int, default 0
        Seed.

    Returns
    -------
    Estimate
        Solid angle [sr].

    Raises
    ------
    SceneError
        If the shape has no finite area, the position lies on it, or a parameter cannot be run.

    Examples
    --------
    >>> import transport as tp
    >>> tp.solid_angle(tp.Disk(radius=1.0), (0, 0, 1), particles=10_000)  # doctest: +SKIP
    <Estimate (1.844 ± 0.006) sr, 32 batches>
    """
    result = simulate(solid_angle_scene(shape, position), particles=particles, seed=seed)
    return solid_angle_from_run(result)


def solid_angle_scene(shape: Shape, position: Iterable[float], power: float = 1.0) -> Scene:
    """Scene of an isotropic point source of `power` [W] at the position and the shape.

    The shape is a detector if a ray from the position crosses one side at most once, else a black surface
    that ends rays.
    """
    if not isinstance(shape, Shape) or not shape.has_area or shape.is_infinite:
        kinds = "Rectangle, Disk, Triangle, Polygon, Sphere, Box, Cylinder, Cone, Paraboloid or Mesh"
        raise SceneError(
            f"solid_angle: shape must be a {kinds}, got {short_repr(shape)}; give one that has an area"
        )
    place = as_floats(position)
    if place is None or len(place) != 3:
        raise SceneError(f"solid_angle: position must be three finite numbers, got {short_repr(position)}")
    if any(_is_on(piece, place) for piece in shape.pieces()):
        must = f"position must not lie on the {type(shape).__name__}, which fills 2 pi or more from there"
        raise SceneError(f"solid_angle: {must}, got {short_repr(place)}; move it off the surface")
    # Use a detector if each ray scores at most once, with an aimed source from outside.
    if _is_crossed_once(shape):
        is_inside = shape.is_closed and shape.distance(place, filled=True) == 0
        source = Source(Point(position=place), Isotropic(power=power), aim=None if is_inside else shape)
        return Scene(source, detectors=Detector(shape, SHAPE_NAME, side="back" if is_inside else "front"))
    # Otherwise let a black surface end each ray at its first hit.
    is_within = math.dist(place, shape.middle) <= shape.extent  # bounding sphere of an aim
    source = Source(Point(position=place), Isotropic(power=power), aim=None if is_within else shape)
    return Scene(source, Surface(shape, Black(), name=SHAPE_NAME))


def solid_angle_from_run(result: Result) -> Estimate:
    """Solid angle [sr] from a run of a `solid_angle_scene`: share of the power on the shape, times 4 pi."""
    [source] = result.scene.sources
    shape = (result.scene.surfaces or result.scene.detectors)[0].shape
    if result.scene.surfaces:
        reached = result.ledger.absorbed_by[SHAPE_NAME]
        is_certain = shape.is_closed and shape.distance(source.shape.position, filled=True) == 0
    else:
        reading = result[SHAPE_NAME]
        reached = reading.flux_in if shape.is_closed else reading.flux_in + reading.flux_out
        is_edge_on = shape.is_flat and is_on_support(source.shape.position, shape)
        is_certain = source.aim is None or isinstance(shape, Sphere) or is_edge_on
    share = reached / result.ledger["emitted"]
    is_exact = is_certain and np.ptp(share.values) <= 1e-12 * abs(share.value)
    angle = share * Estimate(np.full(len(result.run), 4 * math.pi), result.run, "sr", exact=True)
    return Estimate(angle.values, result.run, "sr", exact=True) if is_exact else angle


def _is_crossed_once(shape: Shape) -> bool:
    """Return whether a ray from outside crosses the front (or a flat shape) at most once."""
    return shape.is_flat or shape.is_convex


def _is_on(piece: Shape, place: Vector) -> bool:
    """Return whether a point lies on a piece, within rounding."""
    size = piece.extent + sum(map(abs, (*piece.middle, *place)))
    return piece.distance(place) <= ROUNDING * size
