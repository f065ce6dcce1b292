"""Instruments at a point that only backward histories reach: a pinhole camera, and a map of all directions."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from transport.bins import Directions, check_total
from transport.fields import BinsField, Converted, OptionalVector, VectorField
from transport.shapes import Point, Shape
from transport.sides import AnyDetector
from transport.validation import (
    as_float,
    in_degrees,
    is_count,
    refuse,
    scene_object,
    settle_direction,
    settle_name,
    settle_vector,
    shown,
    store,
)
from transport.vectors import Frame, Vector, are_parallel, local_frame, unit_vector

MOST_PIXELS = 1 << 14  # along one side


class Instrument(AnyDetector):
    """What both share: a name and a place; not made itself."""

    name: str
    position: VectorField

    @property
    def shape(self) -> Point:
        """Where its histories begin."""
        return Point(position=self.position)

    def check_clock(self, duration: float | None) -> None:
        """Refuse a clock: backward histories know no time of departure."""
        if duration is not None:
            refuse(self, f"sees steady scenes, got duration={duration!r}; leave duration out of the Scene")

    def _settle_place(self) -> None:
        settle_name(self)
        if self.name is None:
            refuse(self, "name must be given, got None; write name='view'")
        settle_vector(self, "position")


@scene_object(kw_only=True)
class Camera(Instrument):
    """A pinhole camera: the radiance that arrives at `position` [m], a mean over the solid angle of each pixel.

    It looks towards the point `look_at` [m], or along `direction`; `up` is upright in the image.  `field_of_view`:
    the angle [rad] in (0, pi) across the image's width.  `pixels`: (width, height), square ones on a plane across the
    line of sight.  Nothing of it is in the way of light.  Seen by histories that run backwards: transport.estimators.backward.
    """

    name: str
    position: VectorField
    look_at: OptionalVector = None
    direction: OptionalVector = None
    up: VectorField = (0.0, 0.0, 1.0)
    field_of_view: float = math.pi / 4
    pixels: Converted[Sequence[int], tuple[int, int]] = (160, 120)

    def __post_init__(self) -> None:
        self._settle_place()
        if (self.look_at is None) == (self.direction is None):
            got = "both" if self.look_at is not None else "none"
            refuse(self, f"one of look_at and direction must be given, got {got}; write look_at=(x, y, z)")
        if self.look_at is not None:
            settle_vector(self, "look_at")
            if self.look_at == self.position:
                refuse(self, f"look_at must not be its own position, got {shown(self.look_at)}; move one")
        else:
            settle_direction(self, "direction")
        settle_direction(self, "up")
        if are_parallel(self.forward, self.up):
            refuse(self, f"up must not lie along the line of sight, got {shown(self.up)}; write another up=")
        self._settle_image()

    @property
    def forward(self) -> Vector:
        """The line of sight, a unit vector."""
        if self.direction is not None:
            return self.direction
        return unit_vector(tuple(b - a for a, b in zip(self.position, self.look_at, strict=True)))

    @property
    def frame(self) -> Frame:
        """(to the left, up, the line of sight), unit vectors; right-handed, as all frames are."""
        return local_frame(self.forward, self.up)

    def edges(self) -> dict[str, np.ndarray]:
        """Edges of the pixels on the plane at distance 1, "v" upwards and "u" to the right [1]."""
        width, height = self.pixels
        half = math.tan(self.field_of_view / 2)
        tall = half * height / width
        return {"v": np.linspace(-tall, tall, height + 1), "u": np.linspace(-half, half, width + 1)}

    def may_see(self, shape: Shape) -> bool:
        """Whether a shape may be within the image, by a ball about the one and a cone about the other."""
        if shape.is_infinite:
            return True
        way = np.subtract(shape.middle, self.position)
        distance = float(np.linalg.norm(way))
        if distance <= shape.extent:
            return True
        half = math.atan(math.hypot(*(edges[-1] for edges in self.edges().values())))  # to the corners
        angle = math.acos(max(-1.0, min(1.0, float(np.dot(way, self.forward)) / distance)))
        return angle <= half + math.asin(shape.extent / distance)

    def solid_angles(self) -> np.ndarray:
        """Solid angle [sr] of each pixel, (v, u)."""
        v, u = np.meshgrid(*self.edges().values(), indexing="ij")
        corner = np.arctan(u * v / np.sqrt(1 + u * u + v * v))  # of the rectangle from the axis to there
        return np.diff(np.diff(corner, axis=0), axis=1)

    def _settle_image(self) -> None:
        angle = as_float(self.field_of_view)
        if angle is None or not 0 < angle < math.pi:
            refuse(
                self,
                f"field_of_view must be in (0, pi) rad, got {shown(self.field_of_view)}{in_degrees(angle)}",
            )
        pixels = tuple(self.pixels) if isinstance(self.pixels, tuple | list) else ()
        if len(pixels) != 2 or not all(is_count(n) and 1 <= n <= MOST_PIXELS for n in pixels):
            must = f"(width, height), whole numbers from 1 to {MOST_PIXELS}"
            refuse(self, f"pixels must be {must}, got {shown(self.pixels)}; write pixels=(160, 120)")
        store(self, field_of_view=angle, pixels=tuple(int(n) for n in pixels))
        check_total(self, dict(zip(("width", "height"), self.pixels, strict=True)))


@scene_object(kw_only=True)
class EnvironmentMap(Instrument):
    """The radiance that arrives at `position` [m] from all directions, a mean over each bin's solid angle.

    `theta` from +z and `phi` about it from +x, of the direction that light comes from: numbers of equal bins, or edges
    [rad].  Seen by histories that run backwards: transport.estimators.backward.
    """

    name: str
    position: VectorField
    theta: BinsField = 16
    phi: BinsField = 32

    def __post_init__(self) -> None:
        self._settle_place()
        directions = Directions(theta=self.theta, phi=self.phi, frame="world")
        store(self, theta=directions.theta, phi=directions.phi)

    def edges(self) -> dict[str, np.ndarray]:
        """Edges [rad] of "theta" and "phi"."""
        return Directions(theta=self.theta, phi=self.phi, frame="world").edges()

    def solid_angles(self) -> np.ndarray:
        """Solid angle [sr] of each bin, (theta, phi)."""
        edges = self.edges()
        return np.outer(-np.diff(np.cos(edges["theta"])), np.diff(edges["phi"]))
