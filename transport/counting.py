"""Geometry by counting: the solid angle of a shape is the share of all directions that meet it, times 4 pi."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from transport.detectors import Detector
from transport.emissions import Isotropic
from transport.materials import Black, Surface
from transport.results import Result
from transport.results.estimates import Estimate
from transport.scene import Scene
from transport.shapes import Box, FlatShape, Mesh, Point, Revolved, Shape, Sphere
from transport.shapes.base import ROUNDING
from transport.shapes.distances import least_distance
from transport.sheets import is_on_support, pieces
from transport.simulate import simulate
from transport.sources import Source
from transport.validation import SceneError, as_floats, shown
from transport.vectors import Vector

NAME = "shape"  # of the detector


def solid_angle(
    shape: Shape, position: Iterable[float], particles: int = 1_000_000, seed: int = 0
) -> Estimate:
    """Solid angle that a shape fills, seen from a position [m], by counting: an Estimate [sr].

    Particles leave the position isotropically, or only towards the shape and with the exact weight of that aim; those
    that reach it count, once each: from outside of a closed shape those that reach its outside, and from within it all,
    4 pi.  It is exact, without an error, where nothing is left to chance: of a sphere, from within a closed shape, in a
    flat one's plane.  Raises SceneError for what has no area or an infinite one, for a position on the shape, and for
    input that cannot be run.
    """
    result = simulate(solid_angle_scene(shape, position), particles=particles, seed=seed)
    return counted_solid_angle(result)


def solid_angle_scene(shape: Shape, position: Iterable[float], power: float = 1.0) -> Scene:
    """A point at the position that sends `power` [W] in all directions, and the shape.

    A detector on what a ray from there crosses once at most from one side, else a black surface, where it ends.
    """
    if not isinstance(shape, FlatShape | Revolved | Box | Mesh) or shape.is_infinite:
        must = "shape must be a Rectangle, Disk, Triangle, Sphere, Box, Cylinder, Cone, Paraboloid or Mesh"
        raise SceneError(f"solid_angle: {must}, got {shown(shape)}; give one that has an area")
    place = as_floats(position)
    if place is None or len(place) != 3:
        raise SceneError(f"solid_angle: position must be three finite numbers, got {shown(position)}")
    if any(_is_on(piece, place) for piece in pieces(shape)):
        must = f"position must not lie on the {type(shape).__name__}, which fills 2 pi or more from there"
        raise SceneError(f"solid_angle: {must}, got {shown(place)}; move it off the surface")
    if _is_crossed_once(shape):
        is_inside = shape.is_closed and least_distance(shape, place, filled=True) == 0
        source = Source(Point(position=place), Isotropic(power=power), aim=None if is_inside else shape)
        return Scene(source, detectors=Detector(shape, NAME, side="back" if is_inside else "front"))
    is_within = math.dist(place, shape.middle) <= shape.extent  # of the ball that an aim goes to
    source = Source(Point(position=place), Isotropic(power=power), aim=None if is_within else shape)
    return Scene(source, Surface(shape, Black(), name=NAME))


def counted_solid_angle(result: Result) -> Estimate:
    """Solid angle [sr] that the shape of a `solid_angle_scene` fills: what reached it, over the power, times 4 pi."""
    [source] = result.scene.sources
    shape = (result.scene.surfaces or result.scene.detectors)[0].shape
    if result.scene.surfaces:
        reached = result.ledger.absorbed_by[NAME]
        is_certain = shape.is_closed and least_distance(shape, source.shape.position, filled=True) == 0
    else:
        reading = result[NAME]
        reached = reading.flux_in if shape.is_closed else reading.flux_in + reading.flux_out
        is_edge_on = isinstance(shape, FlatShape) and is_on_support(source.shape.position, shape)
        is_certain = source.aim is None or isinstance(shape, Sphere) or is_edge_on
    share = reached / result.ledger["emitted"]
    is_exact = is_certain and np.ptp(share.values) <= 1e-12 * abs(share.value)
    angle = share * Estimate(np.full(len(result.run), 4 * math.pi), result.run, "sr", exact=True)
    return Estimate(angle.values, result.run, "sr", exact=True) if is_exact else angle


def _is_crossed_once(shape: Shape) -> bool:
    """Whether no ray from outside comes to the front, or to a flat shape, twice."""
    return isinstance(shape, FlatShape | Box) or (isinstance(shape, Sphere) and shape.is_closed)


def _is_on(piece: Shape, place: Vector) -> bool:
    """Whether a point lies on a piece, up to rounding."""
    size = piece.extent + sum(map(abs, (*piece.middle, *place)))
    return least_distance(piece, place) <= ROUNDING * size
