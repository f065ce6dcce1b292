"""Instruments of backward runs: cameras with several lenses, maps of all directions, and light fields."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from transport.geometry.flat import Disk, Rectangle
from transport.geometry.shape import Point, Shape
from transport.scene.bins import Directions, check_bin_count
from transport.scene.projections import (
    EQUAL_AREA,
    FISHEYE,
    PINHOLE,
    RADIUS_OF_ALL,
    image_radius,
    pixel_solid_angles,
    polar_angles,
    radial_places,
    radial_rays,
    radial_weights,
)
from transport.scene.resampling import overlaps, projected_solid_angles, view_weights, weighted
from transport.scene.sides import AnyDetector
from transport.validation import (
    Converted,
    OptionalBinsField,
    OptionalVectorField,
    VectorField,
    as_float,
    check_one_of,
    coerce_direction,
    coerce_name,
    coerce_positive,
    coerce_vector,
    degrees_hint,
    is_whole_number,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)
from transport.vectors import Frame, Vector, are_parallel, local_frame, unit_vector

if TYPE_CHECKING:
    from transport.statistics.estimates import EstimateArray

MAX_PIXELS_PER_SIDE = 1 << 14  # per side
ORTHOGRAPHIC, THIN_LENS = "orthographic", "thin lens"
LENSES = (PINHOLE, FISHEYE, EQUAL_AREA, ORTHOGRAPHIC, THIN_LENS)
WIDE_LENSES = (FISHEYE, EQUAL_AREA)
LATITUDE_LONGITUDE, CYLINDER, CUBE, BALL = "latitude-longitude", "cylinder", "cube", "mirrored ball"
GRIDS = (LATITUDE_LONGITUDE, CYLINDER)
PROJECTIONS = (*GRIDS, CUBE, FISHEYE, EQUAL_AREA, BALL)
FACES = ("+x", "-x", "+y", "-y", "+z", "-z")
X, Y, Z = np.eye(3)
# Right, up and axis of the images of a map. Seen from inside; a mirrored ball as it is seen from -y.
IMAGE_FRAMES = {FISHEYE: (-X, Y, Z), EQUAL_AREA: (-X, Y, Z), BALL: (X, Z, -Y)}
FACE_FRAMES = ((-Y, Z, X), (Y, Z, -X), (X, Z, Y), (-X, Z, -Y), (-X, Y, Z), (X, Y, -Z))
# What the lenses need beside pixels, and what they do not take.
LENS_PARAMETERS = {
    PINHOLE: ("field_of_view",),
    FISHEYE: ("field_of_view",),
    EQUAL_AREA: ("field_of_view",),
    ORTHOGRAPHIC: ("width",),
    THIN_LENS: ("field_of_view", "aperture", "focal_length", "focus"),
}


class CellMeasures(NamedTuple):
    """What the value of each cell of an instrument is a mean over: name, values, unit and axes."""

    name: str
    values: np.ndarray
    unit: str
    axes: tuple[str, ...]


class Instrument(AnyDetector):
    """Base class of Camera, EnvironmentMap and LightField: a name and a place; not instantiated directly."""

    name: str
    position: VectorField

    @property
    def shape(self) -> Shape:
        """Where backward histories start.

        Returns
        -------
        Point, Disk or Rectangle
        """
        return Point(position=self.position)

    @property
    def sees_from_point(self) -> bool:
        """Whether its cells are directions from a point.

        Returns
        -------
        bool
        """
        return isinstance(self.shape, Point)

    @property
    def projection_of_image(self) -> str | None:
        """The radial projection by which pixels are directions from a point; None if it is none.

        Returns
        -------
        str or None
        """
        return None

    def edges(self) -> dict[str, np.ndarray]:
        """Return the edges of the cells by axis."""
        raise NotImplementedError

    @property
    def axis_units(self) -> dict[str, str]:
        """Units of the axes u and v.

        Returns
        -------
        dict of str to str
        """
        return dict.fromkeys("uv", "1" if self.sees_from_point else "m")

    @property
    def stored_axes(self) -> tuple[str, ...]:
        """Names of the axes in the order in which cells are numbered, the fastest last.

        Returns
        -------
        tuple of str
        """
        return tuple(self.edges())

    def gains(self) -> np.ndarray | None:
        """Return one over the mean weight of the histories of each cell; None where all have 1."""
        return None

    def cell_measures(self) -> CellMeasures:
        """Return what the value of each cell is a mean over."""
        raise NotImplementedError

    def check_clock(self, duration: float | None) -> None:
        """Raise SceneError if the scene has a duration: backward histories have no time of emission."""
        if duration is not None:
            refuse(self, f"needs a steady scene, got duration={duration!r}; leave duration out of the Scene")

    def _coerce_position(self) -> None:
        coerce_name(self)
        if self.name is None:
            refuse(self, "name must be given, got None; write name='view'")
        coerce_vector(self, "position")

    def _coerce_counts(self, name: str, example: tuple[int, int]) -> None:
        """Convert a pair of numbers of cells; refuse others."""
        got = getattr(self, name)
        numbers = tuple(got) if isinstance(got, tuple | list) else ()
        if len(numbers) != 2 or not all(
            is_whole_number(n) and 1 <= n <= MAX_PIXELS_PER_SIDE for n in numbers
        ):
            must = f"(width, height), whole numbers from 1 to {MAX_PIXELS_PER_SIDE}"
            refuse(self, f"{name} must be {must}, got {short_repr(got)}; write {name}={example}")
        set_fields(self, **{name: tuple(int(n) for n in numbers)})


class Directed(Instrument):
    """Base class of instruments that look somewhere: a line of sight and what is upright."""

    look_at: OptionalVectorField
    direction: OptionalVectorField
    up: VectorField

    def _coerce_view(self) -> None:
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
            other = (0, 1, 0) if abs(self.up[2]) > 0.5 else (0, 0, 1)
            refuse(
                self, f"up must not lie along the line of sight, got {short_repr(self.up)}; write up={other}"
            )

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
        """Right-handed frame of the instrument.

        Returns
        -------
        tuple of 3 vectors
            Unit vectors to the left, upward and along the line of sight.
        """
        return local_frame(self.forward, self.up)


@scene_object(kw_only=True)
class Camera(Directed):
    """A camera: an image of the radiance that arrives at a point or at a lens.

    Each pixel is the mean radiance over its solid angle. The camera blocks no light. Its histories run
    backward from the camera to the sources. It sees no Point source itself, and no Beam, whose direct light
    has no radiance: it sees what they light. Give exactly one of `look_at` and `direction`; all parameters
    are keywords.

    Parameters
    ----------
    name : str
        Key of the camera in the result.
    position : vector
        Position [m] of the pinhole, or of the middle of the lens or of the orthographic image.
    look_at : vector, default None
        Point [m] at the centre of the image.
    direction : vector, default None
        Line of sight, of any length except 0; stored as a unit vector.
    up : vector, default (0, 0, 1)
        Direction that is upright in the image; not parallel to the line of sight.
    field_of_view : float, default pi/4, of a fisheye pi
        Angle [rad] across the width of the image, in (0, pi); of a fisheye in (0, 2 pi]. Not for
        "orthographic".
    pixels : (int, int), default (160, 120)
        Width and height in square pixels, each from 1 to 16384; at most 10 million in all.
    lens : str, default "pinhole"
        "pinhole": perspective, a direction at the angle theta from the line of sight lies at tan(theta).
        "fisheye": at theta, so that one picture may hold all directions. "equal-area fisheye": at
        2 sin(theta/2), so that equal areas are equal solid angles. "orthographic": parallel rays; nothing
        gets smaller with distance. "thin lens": as a pinhole, but through an aperture; what is not at the
        distance `focus` is blurred.
    width : float, default None
        Width [m] of what an orthographic camera sees; only for that lens.
    aperture : float, default None
        Diameter D [m] of a thin lens; only for that lens.
    focal_length : float, default None
        Focal length f [m] of a thin lens; only for that lens.
    focus : float, default None
        Distance [m] along the line of sight at which a thin lens is in focus, above `focal_length`; None is
        infinity. The film is at the distance v behind the lens, 1/v = 1/f - 1/focus.

    Raises
    ------
    SceneError
        If an argument is invalid or of no use to the lens, or if the scene has a duration.

    Notes
    -----
    A thin lens has `irradiance` on its film, too: of a uniform radiance L on the axis
    pi L (D/2)^2 / ((D/2)^2 + v^2), and off the axis, for small apertures, as cos^4. It has no aberrations,
    absorbs nothing and keeps radiance along rays. It maps tangents, so that pictures are in perspective; no
    lens of a large aperture can do that and keep the throughput of all rays: of the power that a small
    thing near the axis sends into the lens, the share 1/(1 + (D/2v)^2) is on the film, 97 % at f/2.8 and
    81 % at f/1. The material ThinLens obeys Abbe's sine condition instead.

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
    >>> photo = tp.Camera(
    ...     name="photo", position=(0, -3, 0), look_at=(0, 0, 0), lens="thin lens", aperture=0.05,
    ...     focal_length=0.05, focus=3.0,
    ... )
    >>> f"{photo.image_distance:.4f} m"
    '0.0508 m'
    """

    name: str
    position: VectorField
    look_at: OptionalVectorField = None
    direction: OptionalVectorField = None
    up: VectorField = (0.0, 0.0, 1.0)
    field_of_view: float | None = None
    pixels: Converted[Sequence[int], tuple[int, int]] = (160, 120)
    lens: str = PINHOLE
    width: float | None = None
    aperture: float | None = None
    focal_length: float | None = None
    focus: float | None = None

    def __post_init__(self) -> None:
        self._coerce_view()
        check_one_of(self, "lens", LENSES)
        self._coerce_lens()
        self._coerce_counts("pixels", (160, 120))
        check_bin_count(self, dict(zip(("width", "height"), self.pixels, strict=True)))

    def _coerce_lens(self) -> None:
        mine = LENS_PARAMETERS[self.lens]
        if self.field_of_view is None and "field_of_view" in mine:
            set_fields(self, field_of_view=math.pi if self.lens in WIDE_LENSES else math.pi / 4)
        for name in ("field_of_view", "width", "aperture", "focal_length", "focus"):
            got = getattr(self, name)
            if name not in mine and got is not None:
                refuse(
                    self, f"{name} is of no use with lens={self.lens!r}, got {short_repr(got)}; leave it out"
                )
            if name in mine and got is None and name != "focus":
                refuse(self, f"{name} must be given with lens={self.lens!r}, got None; write {name}=0.05")
        if "field_of_view" in mine:
            angle, is_wide = as_float(self.field_of_view), self.lens in WIDE_LENSES
            if angle is None or not (0 < angle <= 2 * math.pi if is_wide else 0 < angle < math.pi):
                within = "(0, 2 pi]" if is_wide else "(0, pi)"
                got = f"{short_repr(self.field_of_view)}{degrees_hint(angle)}"
                refuse(self, f"field_of_view must be in {within} rad, got {got}")
            set_fields(self, field_of_view=angle)
        coerce_positive(self, *(name for name in ("width", "aperture", "focal_length") if name in mine))
        if "aperture" in mine and self.aperture > 2 * self.focal_length:
            must = f"the diameter in metres, at most twice focal_length={self.focal_length:g} m (f/0.5)"
            cure = "for f/2.8 write focal_length / 2.8"
            refuse(self, f"aperture must be {must}, got {short_repr(self.aperture)}; {cure}")
        if self.focus is not None:
            focus = as_float(self.focus)
            if focus is None or not self.focal_length < focus:
                must = f"above focal_length={self.focal_length:g} m"
                refuse(self, f"focus must be {must}, got {short_repr(self.focus)}; write a distance")
            set_fields(self, focus=None if math.isinf(focus) else focus)

    @property
    def shape(self) -> Shape:
        """Where backward histories start, a point, a lens or the frame of an orthographic picture.

        Returns
        -------
        Point, Disk or Rectangle
        """
        frame = {"center": self.position, "normal": self.forward, "up": self.up}
        if self.lens == THIN_LENS:
            return Disk(radius=self.aperture / 2, **frame)
        if self.lens == ORTHOGRAPHIC:
            return Rectangle(width=self.width, height=self.width * self.pixels[1] / self.pixels[0], **frame)
        return Point(position=self.position)

    @property
    def projection_of_image(self) -> str | None:
        """The radial projection by which pixels are directions from a point; None if it is none.

        Returns
        -------
        str or None
        """
        return self.lens if self.lens in (PINHOLE, *WIDE_LENSES) else None

    @property
    def axis_units(self) -> dict[str, str]:
        """Units of the axes u and v.

        Returns
        -------
        dict of str to str
        """
        return dict.fromkeys("uv", "m" if self.lens == ORTHOGRAPHIC else "1")

    @property
    def image_distance(self) -> float:
        """Distance of the film behind a thin lens [m].

        Returns
        -------
        float

        Raises
        ------
        SceneError
            For other lenses.
        """
        if self.lens != THIN_LENS:
            refuse(self, f"image_distance needs lens='thin lens', got {self.lens!r}")
        return 1 / (1 / self.focal_length - self.nearness)

    @property
    def nearness(self) -> float:
        """One over the distance of focus [m^-1]; 0 for infinity.

        Returns
        -------
        float
        """
        return 0.0 if self.focus is None else 1 / self.focus

    def edges(self) -> dict[str, np.ndarray]:
        """Return the edges of the pixels.

        Returns
        -------
        dict of str to array
            "v" upward and "u" to the right: on the image plane at distance 1 [1] of a pinhole or a thin
            lens, by the projection of a fisheye [1], in metres of an orthographic camera.
        """
        width, height = self.pixels
        if self.lens == ORTHOGRAPHIC:
            half = self.width / 2
        else:
            half = image_radius(self.projection_of_image or PINHOLE, self.field_of_view / 2)
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
        if shape.is_infinite or self.projection_of_image is None:
            return True
        offset = np.subtract(shape.middle, self.position)
        distance = float(np.linalg.norm(offset))
        if distance <= shape.extent:
            return True
        corner = math.hypot(*(edges[-1] for edges in self.edges().values()))
        half = float(polar_angles(self.lens, np.array(corner)))
        angle = math.acos(max(-1.0, min(1.0, float(np.dot(offset, self.forward)) / distance)))
        return angle <= half + math.asin(shape.extent / distance)

    def may_see_hull(self, points: np.ndarray) -> bool:
        """Return whether the convex hull of points may be in the image, or part of it.

        It is not where one plane of the edges of a pinhole's image divides all points from the image.

        Parameters
        ----------
        points : array
            Points [m], shape (n, 3).

        Returns
        -------
        bool
        """
        if self.lens != PINHOLE:
            return True
        left, upward, forward = (np.subtract(points, self.position) @ np.array(axis) for axis in self.frame)
        half, tall = (edges[-1] for edges in reversed(self.edges().values()))
        outside = [forward <= 0]
        for across, most in ((left, half), (-left, half), (upward, tall), (-upward, tall)):
            outside.append(across > most * forward)
        return not any(each.all() for each in outside)

    def solid_angles(self) -> np.ndarray:
        """Return the solid angle of each pixel of a pinhole or a fisheye.

        Returns
        -------
        array
            Solid angles [sr], shape (height, width), axes (v, u); 0 beyond the rim of a fisheye.

        Raises
        ------
        SceneError
            For an orthographic camera and a thin lens, whose pixels are not directions from a point.
        """
        if self.projection_of_image is None:
            cure = "read its cell_measures()"
            refuse(self, f"pixels have no solid angle with lens={self.lens!r}; {cure}")
        return pixel_solid_angles(self.lens, *self.edges().values())

    def gains(self) -> np.ndarray | None:
        """Return one over the mean weight of the histories of each pixel.

        Returns
        -------
        array or None
            Area of the image per solid angle, 0 beyond a rim; of a thin lens one over the mean of cos^4 of
            the lines from pixel to lens; None for an orthographic camera.
        """
        if self.lens == THIN_LENS:
            return 1 / self._mean_lens_weights()
        return None if self.lens == ORTHOGRAPHIC else _gains(self)

    def _mean_lens_weights(self) -> np.ndarray:
        return _mean_lens_weights(*self.edges().values(), self.aperture / 2 / self.image_distance)

    def cell_measures(self) -> CellMeasures:
        """Return what each pixel is a mean over.

        Returns
        -------
        CellMeasures
            Solid angle [sr]; of an orthographic camera area [m^2]; of a thin lens projected solid angle [sr]
            of the lens from the film, by which irradiance is radiance times measure.
        """
        v, u = self.edges().values()
        if self.lens == THIN_LENS:
            whole = math.pi * (self.aperture / 2 / self.image_distance) ** 2
            return CellMeasures("projected solid angle", whole * self._mean_lens_weights(), "sr", ("v", "u"))
        if self.lens == ORTHOGRAPHIC:
            return CellMeasures("area", np.outer(np.diff(v), np.diff(u)), "m^2", ("v", "u"))
        return CellMeasures("solid angle", self.solid_angles(), "sr", ("v", "u"))

    def lens_points(self, nodes: int) -> list[tuple[float, float]]:
        """Return even points of the lens, as shares of its radius to the right and up; one of a point."""
        if self.lens != THIN_LENS:
            return [(0.0, 0.0)]
        places = (2 * np.arange(nodes) + 1) / nodes - 1
        return [(a, b) for a in places.tolist() for b in places.tolist() if a * a + b * b < 1]

    def rays(
        self, across: float, up: float, lens: tuple[float, float] = (0.0, 0.0)
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the rays that pass through the same place in each pixel.

        Parameters
        ----------
        across, up : float
            The place as shares of the pixel's width and height, 0.5 for its middle.
        lens : (float, float), default (0, 0)
            Place on a thin lens as shares of its radius, to the right and up.

        Returns
        -------
        tuple of 3 arrays
            Origins [m] and unit vectors away from the camera, shape (pixels, 3), and their weights in the
            mean of a pixel, (pixels,).
        """
        left, upward, forward = (np.array(axis) for axis in self.frame)
        (_, v), (_, u) = self.edges().items()
        v, u = np.meshgrid(v[:-1] + up * np.diff(v), u[:-1] + across * np.diff(u), indexing="ij")
        v, u = v.ravel(), u.ravel()
        place = np.array(self.position)
        if self.lens == ORTHOGRAPHIC:
            origins = place - np.outer(u, left) + np.outer(v, upward)
            return origins, np.broadcast_to(forward, origins.shape), np.ones(len(u))
        if self.lens == THIN_LENS:
            a, b = (share * self.aperture / 2 for share in lens)
            film = 1 + (u + a / self.image_distance) ** 2 + (v + b / self.image_distance) ** 2
            rays = forward - np.outer(u - a * self.nearness, left) + np.outer(v - b * self.nearness, upward)
            rays /= np.linalg.norm(rays, axis=1, keepdims=True)
            return np.broadcast_to(place - a * left + b * upward, rays.shape), rays, film**-2.0
        rays = radial_rays(self.lens, u, v) @ np.array((-left, upward, forward))
        return np.broadcast_to(place, rays.shape), rays, radial_weights(self.lens, u, v)


def _gains(view: Camera | EnvironmentMap) -> np.ndarray:
    """Area of the image per solid angle of each pixel; 0 beyond the rim."""
    v, u = (view.edges()[name] for name in ("v", "u"))
    angles = view.solid_angles()
    area = float((v[1] - v[0]) * (u[1] - u[0]))
    return np.divide(area, angles, out=np.zeros_like(angles), where=angles > 0)


def _mean_lens_weights(v: np.ndarray, u: np.ndarray, radius: float) -> np.ndarray:
    """Mean of cos^4 over pixels and lens, (rows, columns): from film at distance 1 to a disk of this radius.

    From one point of the film at r: (1 - (1 + r^2 - R^2)/S)/(2 R^2) with
    S^2 = (1 + r^2 - R^2)^2 + 4 R^2 (the irradiance by a disk off its axis), whose mean over a pixel is
    computed by Gauss's quadrature to about 14 digits.
    """
    # In angles, in which the widest pixel is below pi.
    (right, of_right), (up, of_up) = (_nodes_in_angle(edges) for edges in (u, v))
    total = np.zeros((len(v) - 1, len(u) - 1))
    for y, weight_y in zip(up, of_up, strict=True):
        for x, weight_x in zip(right, of_right, strict=True):
            less = 1 + y[:, None] ** 2 + x**2 - radius**2
            root = np.sqrt(less * less + 4 * radius**2)
            near = (root - less) / (2 * radius**2 * root) if less.min() < 0 else 0.0
            mean = np.where(less < 0, near, 2 / (root * (root + np.abs(less))))
            total += weight_x * weight_y[:, None] * mean
    return total


def _nodes_in_angle(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points of each interval of tangents, and their shares in its mean, (points, intervals)."""
    angles = np.arctan(edges)
    half = np.diff(angles) / 2
    nodes, weights = np.polynomial.legendre.leggauss(3 + math.ceil(16 / math.asinh(1 / half.max())))
    places = np.tan((angles[1:] + angles[:-1]) / 2 + half * nodes[:, None])
    return places, weights[:, None] * half * (1 + places * places) / np.diff(edges)


@scene_object(kw_only=True)
class EnvironmentMap(Instrument):
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
        Polar angle from +z of the direction that light comes from: number of bins, or edges [rad] within
        [0, pi]. Bins are equal in theta, and in its cosine with "cylinder". Not for other projections.
    phi : int or sequence of float, default 32
        Azimuth about +z from +x of the direction that light comes from: number of equal bins, or edges
        [rad]. Not for other projections than these two.
    projection : str, default "latitude-longitude"
        "latitude-longitude": bins of theta and phi. "cylinder": the same with rows of equal height on a
        cylinder about +z, and so of equal solid angles. "cube": six square images with a field of view of
        90°. "fisheye": +z in the middle, +y up, a direction at the distance of its polar angle.
        "equal-area fisheye": the same at 2 sin(theta/2), pixels of equal solid angles. "mirrored ball": the
        ball as it is seen from afar along +y, +z up.
    pixels : int, default 64, of a cube 32
        Pixels along a side of the image, or of each face of the cube; not for bins of theta and phi.

    Raises
    ------
    SceneError
        If an argument is invalid or of no use to the projection, or if the scene has a duration.

    Notes
    -----
    All projections hold the same light: the fluence rate is the sum of radiance times `solid_angles`, and
    the irradiance on a plane that of radiance times `projected_solid_angles`. `resampled` turns radiances of
    one projection into those of another. Pixels of a fisheye or of a ball beyond its rim have solid angle 0,
    and radiance 0.

    Examples
    --------
    >>> import transport as tp
    >>> sky = tp.EnvironmentMap(name="sky", position=(0, 0, 1), theta=2, phi=4)
    >>> sky.solid_angles().round(4)  # [sr]
    array([[1.5708, 1.5708, 1.5708, 1.5708],
           [1.5708, 1.5708, 1.5708, 1.5708]])
    >>> cube = tp.EnvironmentMap(name="cube", position=(0, 0, 1), projection="cube", pixels=8)
    >>> cube.solid_angles().shape, f"{cube.solid_angles().sum():.4f} sr"
    ((6, 8, 8), '12.5664 sr')
    """

    name: str
    position: VectorField
    theta: OptionalBinsField = None
    phi: OptionalBinsField = None
    projection: str = LATITUDE_LONGITUDE
    pixels: int | None = None

    def __post_init__(self) -> None:
        self._coerce_position()
        check_one_of(self, "projection", PROJECTIONS)
        given = {name: getattr(self, name) for name in ("theta", "phi", "pixels")}
        useless = ("pixels",) if self.projection in GRIDS else ("theta", "phi")
        for name in useless:
            if given[name] is not None:
                cure = f"leave it out, or write {'theta=, phi=' if name == 'pixels' else 'pixels='}"
                got = short_repr(given[name])
                refuse(self, f"{name} is of no use with projection={self.projection!r}, got {got}; {cure}")
        if self.projection in GRIDS:
            bins = {
                "theta": 16 if self.theta is None else self.theta,
                "phi": 32 if self.phi is None else self.phi,
            }
            directions = Directions(**bins, frame="world")
            set_fields(self, theta=directions.theta, phi=directions.phi)
            return
        number = given["pixels"] if given["pixels"] is not None else 32 if self.projection == CUBE else 64
        if not (is_whole_number(number) and 1 <= number <= MAX_PIXELS_PER_SIDE):
            must = f"a whole number from 1 to {MAX_PIXELS_PER_SIDE}"
            refuse(self, f"pixels must be {must}, got {short_repr(number)}; write pixels=64")
        set_fields(self, pixels=int(number))
        check_bin_count(self, {name: len(edges) - 1 for name, edges in self.edges().items()})

    @property
    def projection_of_image(self) -> str | None:
        """The radial projection by which pixels are directions; None for bins of theta and phi.

        Returns
        -------
        str or None
        """
        if self.projection in GRIDS:
            return None
        return {CUBE: PINHOLE, BALL: EQUAL_AREA}.get(self.projection, self.projection)

    def edges(self) -> dict[str, np.ndarray]:
        """Return the edges of the bins.

        Returns
        -------
        dict of str to array
            "theta" and "phi" [rad]; or "v" upward and "u" to the right [1], for a cube after "face", the
            numbers of +x, -x, +y, -y, +z and -z.
        """
        if self.projection in GRIDS:
            edges = Directions(theta=self.theta, phi=self.phi, frame="world").edges()
            if self.projection == CYLINDER and isinstance(self.theta, int):
                edges["theta"] = np.arccos(np.linspace(1.0, -1.0, self.theta + 1))
            return edges
        half = RADIUS_OF_ALL.get(self.projection_of_image, 1.0)
        sides = {name: np.linspace(-half, half, self.pixels + 1) for name in ("v", "u")}
        return {"face": np.arange(len(FACES) + 1) - 0.5, **sides} if self.projection == CUBE else sides

    @property
    def stored_axes(self) -> tuple[str, ...]:
        """Names of the axes in the order in which cells are numbered, the fastest last.

        Returns
        -------
        tuple of str
        """
        return ("phi", "theta") if self.projection in GRIDS else tuple(self.edges())

    def solid_angles(self) -> np.ndarray:
        """Return the solid angle of each bin.

        Returns
        -------
        array
            Solid angles [sr], shape (theta bins, phi bins), (6, pixels, pixels) or (pixels, pixels); 0
            beyond the rim of an image.
        """
        edges = self.edges()
        if self.projection in GRIDS:
            return np.outer(-np.diff(np.cos(edges["theta"])), np.diff(edges["phi"]))
        angles = pixel_solid_angles(self.projection_of_image, edges["v"], edges["u"])
        return np.tile(angles, (len(FACES), 1, 1)) if self.projection == CUBE else angles

    def gains(self) -> np.ndarray | None:
        """Return one over the mean weight of the histories of each pixel; None for bins.

        Returns
        -------
        array or None
            Area of the image per solid angle, 0 beyond a rim.
        """
        return None if self.projection in GRIDS else _gains(self)

    def cell_measures(self) -> CellMeasures:
        """Return the solid angles over which radiance is a mean.

        Returns
        -------
        CellMeasures
        """
        return CellMeasures("solid angle", self.solid_angles(), "sr", tuple(self.edges()))

    def projected_solid_angles(self, normal: Sequence[float]) -> np.ndarray:
        """Return the solid angle of each bin times the cosine to a normal, 0 behind the plane.

        Parameters
        ----------
        normal : vector
            Normal of the plane, of any length except 0.

        Returns
        -------
        array
            Integral of max(cos, 0) over each bin [sr], in the shape of `solid_angles`; of all directions
            the sum is pi.

        Notes
        -----
        The irradiance on the plane is the sum of radiance times this, as far as radiance does not vary within
        bins: the error falls with the square of their size, and is not in the error bar.

        Examples
        --------
        >>> import transport as tp
        >>> sky = tp.EnvironmentMap(name="sky", position=(0, 0, 1), projection="cube", pixels=4)
        >>> f"{sky.projected_solid_angles((1, 1, 1)).sum():.4f} sr"
        '3.1416 sr'
        """
        lengths = [as_float(each) for each in normal] if isinstance(normal, Sequence | np.ndarray) else []
        if len(lengths) != 3 or None in lengths or not 0 < math.hypot(*lengths) < math.inf:
            refuse(self, f"normal must be three numbers, not all 0, got {short_repr(normal)}")
        return projected_solid_angles(self, unit_vector(tuple(lengths)))

    def resampled(
        self, radiance: EstimateArray | np.ndarray, other: EnvironmentMap
    ) -> EstimateArray | np.ndarray:
        """Return radiances of this map in the bins of another projection.

        Parameters
        ----------
        radiance : EstimateArray or array
            Values in the shape of `solid_angles`.
        other : EnvironmentMap
            Map with the bins to convert to; its position does not matter.

        Returns
        -------
        EstimateArray or array
            Mean over each bin, as if the values were constant over the bins of this map, and 0 outside of it.
            The fluence rate stays the same to rounding, and so does a uniform radiance, if both maps cover
            all directions. Into a map of all directions the fluence rate stays; from one, uniform radiance.

        Examples
        --------
        >>> import numpy as np
        >>> import transport as tp
        >>> sky = tp.EnvironmentMap(name="sky", position=(0, 0, 1), theta=8, phi=16)
        >>> ball = tp.EnvironmentMap(name="ball", position=(0, 0, 1), projection="mirrored ball", pixels=16)
        >>> radiance = np.linspace(0.0, 1.0, 8 * 16).reshape(8, 16)
        >>> converted = sky.resampled(radiance, ball)
        >>> f"{(radiance * sky.solid_angles()).sum():.6f}, {(converted * ball.solid_angles()).sum():.6f}"
        '6.283185, 6.283185'
        """
        if not isinstance(other, EnvironmentMap):
            cure = "write tp.EnvironmentMap(name='other', position=..., projection='cube')"
            refuse(self, f"other must be an EnvironmentMap, got {short_repr(other)}; {cure}")
        for each in (self, other):
            if not math.isclose(each.solid_angles().sum(), 4 * math.pi, rel_tol=1e-9):
                must = "must cover all directions to be resampled"
                refuse(each, f"{must}, got {each.solid_angles().sum():.4g} sr of 12.57; leave edges out")
        angles = other.solid_angles().ravel()
        scale = np.divide(1.0, angles, out=np.zeros_like(angles), where=angles > 0)
        return weighted(overlaps(self, other) * scale[:, None], radiance, self.solid_angles().shape, other)

    def rays(
        self, across: float, up: float, cells: np.ndarray | slice = slice(None)
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the directions at the same place in each bin, and their weights.

        Parameters
        ----------
        across, up : float
            The place as shares of the bin: of azimuth and of 1 - cos(theta), or of a pixel's sides.
        cells : array of int, optional
            Indices of the bins in a flattened array; all by default.

        Returns
        -------
        tuple of 2 arrays
            Unit vectors that light comes from, (bins, 3), and solid angles per area of the image, (bins,).
        """
        edges = self.edges()
        if self.projection in GRIDS:
            mu, phi = np.cos(edges["theta"]), edges["phi"]
            mu, phi = np.meshgrid(mu[:-1] + up * np.diff(mu), phi[:-1] + across * np.diff(phi), indexing="ij")
            mu, phi = mu.ravel()[cells], phi.ravel()[cells]
            sine = np.sqrt((1 - mu) * (1 + mu))
            return np.stack([sine * np.cos(phi), sine * np.sin(phi), mu], axis=-1), np.ones(len(mu))
        v, u = (edges[name][:-1] + share * np.diff(edges[name]) for name, share in (("v", up), ("u", across)))
        v, u = (each.ravel() for each in np.meshgrid(v, u, indexing="ij"))
        frames = FACE_FRAMES if self.projection == CUBE else (IMAGE_FRAMES[self.projection],)
        chosen = np.arange(len(frames) * len(u))[cells]
        face, pixel = np.divmod(chosen, len(u))
        seen = radial_rays(self.projection_of_image, u[pixel], v[pixel])
        rays = np.einsum("ni,nij->nj", seen, np.array(frames)[face])
        return rays, radial_weights(self.projection_of_image, u[pixel], v[pixel])

    @property
    def image_axis(self) -> Vector:
        """The direction in the middle of the image; of bins and of a cube +z.

        Returns
        -------
        vector
        """
        return tuple(map(float, IMAGE_FRAMES.get(self.projection, (X, Y, Z))[2]))

    def cells_of(self, rays: np.ndarray) -> np.ndarray:
        """Return the indices, in a flattened array, of the bins that directions fall into; -1 for none.

        Parameters
        ----------
        rays : array
            Unit vectors that light comes from, (n, 3).

        Returns
        -------
        array of int
        """
        edges = self.edges()
        if self.projection in GRIDS:
            phi = np.arctan2(rays[:, 1], rays[:, 0])
            phi = np.mod(phi - edges["phi"][0], 2 * math.pi) + edges["phi"][0]
            theta = np.arctan2(np.hypot(rays[:, 0], rays[:, 1]), rays[:, 2])
            return _cells_of([(theta, edges["theta"]), (phi, edges["phi"])])
        frames = np.array(FACE_FRAMES if self.projection == CUBE else (IMAGE_FRAMES[self.projection],))
        along = rays @ frames[:, 2].T
        face = np.argmax(along, axis=1)
        u, v = radial_places(self.projection_of_image, np.einsum("nij,nj->ni", frames[face], rays))
        places = []
        for value, name in ((v, "v"), (u, "u")):  # rounding must not move a direction out of the image
            half = edges[name][-1]
            near = np.abs(value) < half * (1 + 1e-12)
            places.append((np.where(near, np.clip(value, -half, half), value), edges[name]))
        numbers = [(face, edges["face"])] if self.projection == CUBE else []
        return _cells_of([*numbers, *places])


def _cells_of(places: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Indices in a flattened array of coordinates between edges, by axis; -1 outside."""
    cells, is_inside = np.zeros(len(places[0][0]), np.int64), np.ones(len(places[0][0]), bool)
    for value, edges in places:
        bins = len(edges) - 1
        number = np.searchsorted(edges, value, side="right") - 1
        number[value == edges[-1]] = bins - 1
        is_inside &= (number >= 0) & (number < bins)
        cells = cells * bins + np.clip(number, 0, bins - 1)
    return np.where(is_inside, cells, -1)


def _mean_cos4_of_wide(u: np.ndarray, v: np.ndarray, s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Mean of cos^4 over pairs of points of wide cells of two planes at the distance 1, (u, v, s, t).

    From the closed form of the view factor of parallel rectangles (Ehlert and Smith 1993), which cancels in
    narrow cells.
    """
    corners = (
        (0, 1, 1.0),
        (0, 0, -1.0),
        (1, 1, -1.0),
        (1, 0, 1.0),
    )  # of a near and a far interval, and signs
    total = np.zeros([len(each) - 1 for each in (u, v, s, t)])
    for i, j, sign_x in corners:
        x = (s[j : len(s) - 1 + j] - u[i : len(u) - 1 + i, None])[:, None, :, None]
        for k, m, sign_y in corners:
            y = (t[m : len(t) - 1 + m] - v[k : len(v) - 1 + k, None])[None, :, None, :]
            root_x, root_y = np.sqrt(1 + x * x), np.sqrt(1 + y * y)
            term = y * root_x * np.arctan(y / root_x) + x * root_y * np.arctan(x / root_y)
            total += sign_x * sign_y * (term - np.log(1 + x * x + y * y) / 2) / 2
    widths = (float(each[1] - each[0]) for each in (u, v, s, t))
    return total / math.prod(widths)


@scene_object(kw_only=True)
class LightField(Directed):
    """A light field on two parallel planes: the radiance of the rays through pairs of cells, L(u, v, s, t).

    Rays arrive through the far plane (s, t) at the near plane (u, v), on which the light field is an array of
    cameras, or the lens of a camera that may be focused afterwards. It blocks no light. Its histories run
    backward from the near plane to the sources. It sees no Point source itself, and no Beam. Give exactly one
    of `look_at` and `direction`; all parameters are keywords.

    Parameters
    ----------
    name : str
        Key of the light field in the result.
    position : vector
        Middle [m] of the near plane.
    look_at : vector, default None
        Point [m] on the normal of both planes through their middles.
    direction : vector, default None
        The normal, from the near to the far plane, of any length except 0; stored as a unit vector.
    up : vector, default (0, 0, 1)
        Direction of the axes v and t; u and s point to the right as seen from the near plane.
    distance : float
        Distance [m] between the planes.
    size : (float, float)
        Width and height [m] of the near plane.
    far_size : (float, float)
        Width and height [m] of the far plane.
    views : (int, int), default (4, 4)
        Numbers of cells of the near plane along u and v.
    pixels : (int, int), default (40, 30)
        Numbers of cells of the far plane along s and t; at most 10 million cells in all.

    Raises
    ------
    SceneError
        If an argument is invalid, or if the scene has a duration.

    Notes
    -----
    Each value is the mean radiance over the throughput of a cell, the integral of
    cos(theta_1) cos(theta_2)/r^2 over both areas [m^2 sr]. Whatever lies on the far plane is sharp in every
    view; what lies elsewhere moves from view to view. A spherical light field is a Detector on a Sphere with
    bins of position and direction. (Levoy and Hanrahan 1996; Gortler et al. 1996.)

    Examples
    --------
    >>> import transport as tp
    >>> field = tp.LightField(
    ...     name="field", position=(0, -3, 0), look_at=(0, 0, 0), distance=3.0, size=(0.2, 0.2),
    ...     far_size=(2.0, 1.5), views=(2, 2), pixels=(8, 6),
    ... )
    >>> field.cell_measures().values.shape
    (2, 2, 8, 6)
    """

    name: str
    position: VectorField
    look_at: OptionalVectorField = None
    direction: OptionalVectorField = None
    up: VectorField = (0.0, 0.0, 1.0)
    distance: float
    size: Converted[Sequence[float], tuple[float, float]]
    far_size: Converted[Sequence[float], tuple[float, float]]
    views: Converted[Sequence[int], tuple[int, int]] = (4, 4)
    pixels: Converted[Sequence[int], tuple[int, int]] = (40, 30)

    def __post_init__(self) -> None:
        self._coerce_view()
        coerce_positive(self, "distance")
        for name in ("size", "far_size"):
            got = getattr(self, name)
            lengths = [as_float(each) for each in got] if isinstance(got, tuple | list) else []
            if len(lengths) != 2 or not all(each is not None and 0 < each < math.inf for each in lengths):
                must = "(width, height) in metres, both positive"
                refuse(self, f"{name} must be {must}, got {short_repr(got)}; write {name}=(0.2, 0.2)")
            set_fields(self, **{name: tuple(lengths)})
        self._coerce_counts("views", (4, 4))
        self._coerce_counts("pixels", (40, 30))
        check_bin_count(self, dict(zip("uvst", (*self.views, *self.pixels), strict=True)))

    @property
    def shape(self) -> Rectangle:
        """The near plane, where backward histories start.

        Returns
        -------
        Rectangle
        """
        width, height = self.size
        return Rectangle(center=self.position, normal=self.forward, up=self.up, width=width, height=height)

    def edges(self) -> dict[str, np.ndarray]:
        """Return the edges of the cells.

        Returns
        -------
        dict of str to array
            "u" to the right and "v" upward on the near plane, "s" and "t" on the far plane [m], from the
            middles.
        """
        lengths, numbers = (*self.size, *self.far_size), (*self.views, *self.pixels)
        return {
            name: np.linspace(-length / 2, length / 2, number + 1)
            for name, length, number in zip("uvst", lengths, numbers, strict=True)
        }

    @property
    def stored_axes(self) -> tuple[str, ...]:
        """Names of the axes in the order in which cells are numbered, the fastest last.

        Returns
        -------
        tuple of str
        """
        return "u", "v", "t", "s"

    def gains(self) -> np.ndarray:
        """Return one over the mean of cos^4 of the rays of each cell, (u, v, s, t).

        Returns
        -------
        array
        """
        return 1 / self._mean_cos4()

    def cell_measures(self) -> CellMeasures:
        """Return the throughput of each cell, over which radiance is a mean.

        Returns
        -------
        CellMeasures
            [m^2 sr], axes (u, v, s, t).
        """
        u, v, s, t = (float(edges[1] - edges[0]) for edges in self.edges().values())
        return CellMeasures(
            "throughput", u * v * s * t / self.distance**2 * self._mean_cos4(), "m^2 sr", tuple("uvst")
        )

    def cells_of(self, origins: np.ndarray, rays: np.ndarray) -> np.ndarray:
        """Return the indices, in a flattened array (u, v, s, t), of the cells of rays; -1 for none.

        Parameters
        ----------
        origins, rays : array
            Points [m] and directions of the rays, away from the eye, (n, 3).

        Returns
        -------
        array of int
        """
        left, upward, forward = (np.array(axis) for axis in self.frame)
        depth, along = (origins - self.position) @ forward, rays @ forward
        along = np.where(along > 0, along, np.nan)
        places = []
        for edges, far in (("uv", 0.0), ("st", self.distance)):
            meets = origins - self.position + ((far - depth) / along)[:, None] * rays
            places += [(-(meets @ left), edges[0]), (meets @ upward, edges[1])]
        found = self.edges()
        return _cells_of([(np.nan_to_num(value, nan=np.inf), found[name]) for value, name in places])

    def view(self, radiance: EstimateArray | np.ndarray, camera: Camera) -> EstimateArray | np.ndarray:
        """Return the picture that a camera takes of the light field: no history is needed any more.

        Parameters
        ----------
        radiance : EstimateArray or array
            Values (u, v, s, t), such as `result["field"].radiance`.
        camera : Camera
            Any lens. With "thin lens" the picture is focused after the fact.

        Returns
        -------
        EstimateArray or array
            Radiance of each pixel, axes (v, u); nan where a ray of the pixel misses the light field.

        Raises
        ------
        SceneError
            If rays of all pixels miss it.

        Notes
        -----
        A pixel is the mean over even rays of the values of the cells that they pass through: details below
        the size of the cells are lost, which is not in the error bar.
        """
        if not isinstance(camera, Camera):
            refuse(self, f"camera must be a Camera, got {short_repr(camera)}")
        numbers = tuple(len(edges) - 1 for edges in self.edges().values())
        weights = view_weights(self, camera)
        if np.isnan(weights @ np.ones(weights.shape[1])).all():
            must = "see the far plane through the near plane, with all of its lens"
            cure = "move it, look along the light field, or take a smaller aperture"
            refuse(
                self, f"camera must {must}, but each pixel of {camera.name!r} has rays that miss them; {cure}"
            )
        return weighted(weights, radiance, numbers, camera)

    def _mean_cos4(self) -> np.ndarray:
        """Mean of cos^4 over pairs of points of each cell, by Gauss's quadrature to about 10 digits."""
        edges = {name: each / self.distance for name, each in self.edges().items()}
        widest = max(float(each[1] - each[0]) for each in edges.values())
        if widest > 1:
            return _mean_cos4_of_wide(**edges)
        nodes, weights = np.polynomial.legendre.leggauss(2 + math.ceil(6 / math.asinh(1 / widest)))
        squares = []  # of the differences along u and s, and along v and t, at all pairs of nodes
        for near, far in (("u", "s"), ("v", "t")):
            here, there = (
                (edges[name][1:] + edges[name][:-1])[:, None] / 2 + np.diff(edges[name])[:, None] / 2 * nodes
                for name in (near, far)
            )
            squares.append(
                [
                    (p * q / 4, (there[:, j] - here[:, i, None]) ** 2)
                    for i, p in enumerate(weights)
                    for j, q in enumerate(weights)
                ]
            )
        total = np.zeros([len(edges[name]) - 1 for name in "uvst"])
        for weight_x, x in squares[0]:
            for weight_y, y in squares[1]:
                total += weight_x * weight_y / (1 + x[:, None, :, None] + y[None, :, None, :]) ** 2
        return total
