"""Cameras at a point: a pinhole camera and a map of all directions, both estimated backward."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from transport.geometry.shape import Point, Shape
from transport.scene.bins import Directions, check_bin_count
from transport.scene.sides import AnyDetector
from transport.validation import (
    BinsField,
    Converted,
    OptionalVectorField,
    VectorField,
    as_float,
    coerce_direction,
    coerce_name,
    coerce_vector,
    degrees_hint,
    is_whole_number,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)
from transport.vectors import Frame, Vector, are_parallel, local_frame, unit_vector

MAX_PIXELS_PER_SIDE = 1 << 14  # per side


class PointInstrument(AnyDetector):
    """Base class of Camera and EnvironmentMap: a name and a position; not instantiated directly."""

    name: str
    position: VectorField

    @property
    def shape(self) -> Point:
        """The point where backward histories start.

        Returns
        -------
        Point
        """
        return Point(position=self.position)

    def check_clock(self, duration: float | None) -> None:
        """Raise SceneError if the scene has a duration: backward histories have no time of emission."""
        if duration is not None:
            refuse(self, f"needs a steady scene, got duration={duration!r}; leave duration out of the Scene")

    def _coerce_position(self) -> None:
        coerce_name(self)
        if self.name is None:
            refuse(self, "name must be given, got None; write name='view'")
        coerce_vector(self, "position")


@scene_object(kw_only=True)
class Camera(PointInstrument):
    """A pinhole camera: an image of the radiance that arrives at a point.

    Each pixel is the mean radiance over its solid angle. The camera blocks no light. Its histories run
    backward from the camera to the sources. It sees no Point source itself, and no Beam, whose direct light
    has no radiance: it sees what they light. Give exactly one of `look_at` and `direction`; all parameters
    are keywords.

    Parameters
    ----------
    name : str
        Key of the camera in the result.
    position : vector
        Position of the pinhole [m].
    look_at : vector, default None
        Point [m] at the centre of the image.
    direction : vector, default None
        Line of sight, of any length except 0; stored as a unit vector.
    up : vector, default (0, 0, 1)
        Direction that is upright in the image; not parallel to the line of sight.
    field_of_view : float, default pi/4
        Angle [rad] across the width of the image, in (0, pi).
    pixels : (int, int), default (160, 120)
        Width and height in square pixels, each from 1 to 16384; at most 10 million in all.

    Raises
    ------
    SceneError
        If an argument is invalid, or if the scene has a duration.

    Examples
    --------
    >>> import math
    >>> import transport as tp
    >>> camera = tp.Camera(
    ...     name="view", position=(0, -3, 0), look_at=(0, 0, 0), field_of_view=math.pi / 2, pixels=(4, 2)
    ... )
    >>> camera.forward
    (0.0, 1.0, 0.0)
    >>> camera.solid_angles().shape
    (2, 4)
    """

    name: str
    position: VectorField
    look_at: OptionalVectorField = None
    direction: OptionalVectorField = None
    up: VectorField = (0.0, 0.0, 1.0)
    field_of_view: float = math.pi / 4
    pixels: Converted[Sequence[int], tuple[int, int]] = (160, 120)

    def __post_init__(self) -> None:
        self._coerce_position()
        if (self.look_at is None) == (self.direction is None):
            got = "both" if self.look_at is not None else "none"
            refuse(self, f"one of look_at and direction must be given, got {got}; write look_at=(x, y, z)")
        if self.look_at is not None:
            coerce_vector(self, "look_at")
            if self.look_at == self.position:
                refuse(self, f"look_at must differ from position, got {short_repr(self.look_at)}; move one")
        else:
            coerce_direction(self, "direction")
        coerce_direction(self, "up")
        if are_parallel(self.forward, self.up):
            refuse(
                self, f"up must not lie along the line of sight, got {short_repr(self.up)}; write another up="
            )
        self._coerce_image()

    @property
    def forward(self) -> Vector:
        """Line of sight.

        Returns
        -------
        vector
            Unit vector.
        """
        if self.direction is not None:
            return self.direction
        return unit_vector(tuple(b - a for a, b in zip(self.position, self.look_at, strict=True)))

    @property
    def frame(self) -> Frame:
        """Right-handed frame of the camera.

        Returns
        -------
        tuple of 3 vectors
            Unit vectors to the left, upward and along the line of sight.
        """
        return local_frame(self.forward, self.up)

    def edges(self) -> dict[str, np.ndarray]:
        """Return the edges of the pixels on the image plane at distance 1.

        Returns
        -------
        dict of str to array
            "v" upward and "u" to the right [1].
        """
        width, height = self.pixels
        half = math.tan(self.field_of_view / 2)
        tall = half * height / width
        return {"v": np.linspace(-tall, tall, height + 1), "u": np.linspace(-half, half, width + 1)}

    def may_see(self, shape: Shape) -> bool:
        """Return whether a shape may be in the image.

        The test uses a bounding sphere of the shape and a bounding cone of the image, so it may be true for a
        shape outside the image, but is never false for one in it.

        Returns
        -------
        bool
        """
        if shape.is_infinite:
            return True
        offset = np.subtract(shape.middle, self.position)
        distance = float(np.linalg.norm(offset))
        if distance <= shape.extent:
            return True
        half = math.atan(math.hypot(*(edges[-1] for edges in self.edges().values())))  # to the corners
        angle = math.acos(max(-1.0, min(1.0, float(np.dot(offset, self.forward)) / distance)))
        return angle <= half + math.asin(shape.extent / distance)

    def may_see_hull(self, points: np.ndarray) -> bool:
        """Return whether the convex hull of points may be in the image, or part of it.

        It is not where one plane of the image's edges divides all points from the image.

        Parameters
        ----------
        points : array
            Points [m], shape (n, 3).

        Returns
        -------
        bool
        """
        left, upward, forward = (np.subtract(points, self.position) @ np.array(axis) for axis in self.frame)
        half, tall = (edges[-1] for edges in reversed(self.edges().values()))
        outside = [forward <= 0]
        for across, most in ((left, half), (-left, half), (upward, tall), (-upward, tall)):
            outside.append(across > most * forward)
        return not any(each.all() for each in outside)

    def solid_angles(self) -> np.ndarray:
        """Return the solid angle of each pixel.

        Returns
        -------
        array
            Solid angles [sr], shape (height, width), axes (v, u).
        """
        v, u = np.meshgrid(*self.edges().values(), indexing="ij")
        # Solid angle of the rectangle from the axis to each corner (u, v).
        corner = np.arctan(u * v / np.sqrt(1 + u * u + v * v))
        return np.diff(np.diff(corner, axis=0), axis=1)

    def _coerce_image(self) -> None:
        angle = as_float(self.field_of_view)
        if angle is None or not 0 < angle < math.pi:
            refuse(
                self,
                "field_of_view must be in (0, pi) rad, got"
                f" {short_repr(self.field_of_view)}{degrees_hint(angle)}",
            )
        pixels = tuple(self.pixels) if isinstance(self.pixels, tuple | list) else ()
        if len(pixels) != 2 or not all(is_whole_number(n) and 1 <= n <= MAX_PIXELS_PER_SIDE for n in pixels):
            must = f"(width, height), whole numbers from 1 to {MAX_PIXELS_PER_SIDE}"
            refuse(self, f"pixels must be {must}, got {short_repr(self.pixels)}; write pixels=(160, 120)")
        set_fields(self, field_of_view=angle, pixels=tuple(int(n) for n in pixels))
        check_bin_count(self, dict(zip(("width", "height"), self.pixels, strict=True)))


@scene_object(kw_only=True)
class EnvironmentMap(PointInstrument):
    """A map of the radiance that arrives at a point from all directions.

    Each bin is the mean radiance over its solid angle. The map blocks no light. Its histories run backward
    from the point to the sources. It sees no Point source itself, and no Beam, whose direct light has no
    radiance: it sees what they light, and has no fluence rate then. All parameters are keywords.

    Parameters
    ----------
    name : str
        Key of the map in the result.
    position : vector
        Position [m].
    theta : int or sequence of float, default 16
        Polar angle from +z of the direction that light comes from: number of equal bins, or edges [rad]
        within [0, pi].
    phi : int or sequence of float, default 32
        Azimuth about +z from +x of the direction that light comes from: number of equal bins, or edges
        [rad].

    Raises
    ------
    SceneError
        If an argument is invalid, or if the scene has a duration.

    Examples
    --------
    >>> import transport as tp
    >>> sky = tp.EnvironmentMap(name="sky", position=(0, 0, 1), theta=2, phi=4)
    >>> sky.solid_angles().round(4)  # [sr]
    array([[1.5708, 1.5708, 1.5708, 1.5708],
           [1.5708, 1.5708, 1.5708, 1.5708]])
    """

    name: str
    position: VectorField
    theta: BinsField = 16
    phi: BinsField = 32

    def __post_init__(self) -> None:
        self._coerce_position()
        directions = Directions(theta=self.theta, phi=self.phi, frame="world")
        set_fields(self, theta=directions.theta, phi=directions.phi)

    def edges(self) -> dict[str, np.ndarray]:
        """Return the edges of the bins.

        Returns
        -------
        dict of str to array
            "theta" and "phi" [rad].
        """
        return Directions(theta=self.theta, phi=self.phi, frame="world").edges()

    def solid_angles(self) -> np.ndarray:
        """Return the solid angle of each bin.

        Returns
        -------
        array
            Solid angles [sr], shape (theta bins, phi bins).
        """
        edges = self.edges()
        return np.outer(-np.diff(np.cos(edges["theta"])), np.diff(edges["phi"]))
