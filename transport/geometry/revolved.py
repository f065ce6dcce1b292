"""Surfaces of revolution between two heights: cylinder, cone, paraboloid; base class of spheres too."""

import math
from dataclasses import dataclass

import numpy as np

from transport.geometry.shape import Rim, Shape
from transport.validation import (
    VectorField,
    coerce_direction,
    coerce_nonnegative,
    coerce_positive,
    coerce_vector,
    refuse,
    scene_object,
)
from transport.vectors import Frame, Vector, dot, local_frame

MIN_RADIUS_RATIO = 0.5  # cones with a smaller ratio of radii are described from the apex
MIN_ASPECT = 2.0**-40  # least ratio of radius and length: below it, rounding merges the two sides


@dataclass(frozen=True)
class Profile:
    """Conic section rotated about an axis: rho^2 = alpha + beta w + gamma w^2 for w in [low, high].

    w is the height [m] along the axis from `origin`, rho the distance [m] from the axis. `lift` is the height
    [m] of `origin` over the shape's `center`. gamma = -1: sphere; 0: cylinder, or paraboloid if beta is not
    0; above 0: cone.
    """

    alpha: float
    beta: float
    gamma: float
    low: float
    high: float
    origin: Vector
    lift: float = 0.0

    def radius_at(self, w: float) -> float:
        """rho [m] at a height [m] from `origin`; also for arrays."""
        if self.gamma < 0 and self.beta == 0:
            radius = math.sqrt(-self.alpha / self.gamma)
            return abs(-self.gamma * (radius - w) * (radius + w)) ** 0.5
        return abs(self.alpha + w * (self.beta + self.gamma * w)) ** 0.5

    def area_per_height(self, low: float, high: float) -> float:
        """Mean of rho sqrt(1 + (drho/dw)^2) between two heights [m]: area per azimuth and height.

        Also for arrays.

        The square of the integrand is linear in w (sphere, cylinder, paraboloid) or a perfect square (cone).
        The mean is computed from the end values without a difference, so that narrow bands and near-cylinders
        keep all digits.
        """
        lower, upper = self._area_density(low), self._area_density(high)
        if self.gamma * (1 + self.gamma) != 0:
            return (lower + upper) / 2
        return (lower * lower + lower * upper + upper * upper) / (lower + upper) / 1.5

    def area_per_radian(self, low: float, high: float) -> float:
        """Area per azimuth [m^2/rad] between two heights [m] from `origin`; also for arrays."""
        return (high - low) * self.area_per_height(low, high)

    def even_heights(self, share: np.ndarray) -> np.ndarray:
        """Heights [m] below which these shares of the area lie, without cancellation."""
        first, last = (float(self._area_density(w)) for w in (self.low, self.high))
        if self.gamma * (1 + self.gamma) != 0:  # the density is linear in the height: a cone
            density = np.sqrt(first * first + share * (last - first) * (last + first))
            risen = share * (first + last) / (first + density)
        else:  # its square is linear
            squares = first * first + first * last + last * last
            density = np.cbrt(first**3 + share * (last - first) * squares)
            whole = density * density + density * first + first * first
            risen = share * squares / whole * ((density + first) / (last + first))
        return self.low + risen * (self.high - self.low)

    def signed_distance(self, rho: float, w: float) -> float:
        """Signed distance [m] of a point from the infinite surface, positive outside.

        Exact for spheres and cylinders, else to first order near the surface.
        """
        slope, curve = self.beta / 2 + self.gamma * w, w * (self.beta + self.gamma * w)
        steepness2 = self.alpha + self.beta * self.beta / 4 + (1 + self.gamma) * curve
        scale = math.hypot(rho, slope) + math.sqrt(max(steepness2, 0.0))
        return (rho * rho - self.alpha - curve) / scale if scale > 0 else 0.0

    def is_on_branch(self, w: float, tolerance: float) -> bool:
        """Return whether a height [m] is on the cone itself and not on its mirror image beyond the apex."""
        if self.gamma <= 0:
            return True
        return (
            w * (self.low + self.high) >= -tolerance
            if self.alpha == 0
            else self.alpha + self.beta * w / 2 >= 0
        )

    def taper_sign(self) -> float:
        """For a cone described from its apex: 1 if it narrows along its axis, -1 if it widens; else 0."""
        if self.gamma <= 0 or self.alpha != 0:
            return 0.0
        return -math.copysign(1.0, self.beta + self.gamma * (self.low + self.high))

    def middle_height(self) -> float:
        """Height [m] of the centre of the smallest sphere that holds the surface."""
        even = ((self.low + self.high) * (1 + self.gamma) + self.beta) / 2  # equally far from both rims
        return min(max(even, self.low), self.high)

    def extent(self) -> float:
        """Radius [m] of the smallest sphere that holds the surface."""
        middle = self.middle_height()
        return max(math.hypot(w - middle, self.radius_at(w)) for w in (self.low, self.high))

    def reach(self, along: float, across: float) -> float:
        """Largest projection [m] of the surface, from `origin`, on a direction.

        along, across: cosine and sine of the direction to the axis.
        """
        heights = (self.low, self.high, min(max(self._stationary_height(along, across), self.low), self.high))
        return max(along * w + across * self.radius_at(w) for w in heights)

    def _area_density(self, w: float) -> float:
        """rho sqrt(1 + (drho/dw)^2) [m]."""
        slope = self.beta / 2 + self.gamma * w  # rho drho/dw
        if self.gamma < 0:
            return math.sqrt(self.alpha) + 0.0 * w
        return (self.radius_at(w) ** 2 + slope * slope) ** 0.5

    def _stationary_height(self, along: float, across: float) -> float:
        """Height [m] at which along w + across rho is stationary and largest; an end if there is none."""
        if self.gamma < 0:
            return math.sqrt(self.alpha) * along / math.hypot(along, across)
        if self.gamma == 0 and self.beta != 0 and along < 0:
            radius = -self.beta / 2 * across / along
            return (radius * radius - self.alpha) / self.beta if math.isfinite(radius) else math.inf
        return self.low


class Revolved(Shape):
    """Base class of surfaces of revolution: an axis, a profile, and normals away from the axis."""

    @property
    def support_breadth(self) -> float:
        """Extent [m], over which its coordinates define the support."""
        return self.extent

    @property
    def profile(self) -> Profile:
        """Conic section that is rotated about the axis."""
        raise NotImplementedError

    @property
    def frame(self) -> Frame:
        """Unit vectors (e_u, e_v, axis) of the shape's coordinates; azimuth runs from e_u to e_v.

        Returns
        -------
        tuple of three tuples of three floats
        """
        return local_frame(self.axis, None)

    @property
    def middle(self) -> Vector:
        """Centre of the smallest sphere that holds the surface [m]."""
        profile = self.profile
        return _point_along(profile.origin, self.axis, profile.middle_height())

    @property
    def extent(self) -> float:
        """Radius of the smallest sphere that holds the surface [m]."""
        return self.profile.extent()

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest axis-aligned box that holds the shape."""
        profile, (x, y, z) = self.profile, self.axis
        tilts = [(x, math.hypot(y, z)), (y, math.hypot(x, z)), (z, math.hypot(x, y))]
        places = list(zip(profile.origin, tilts, strict=True))
        lower = tuple(o - profile.reach(-along, across) for o, (along, across) in places)
        return lower, tuple(o + profile.reach(along, across) for o, (along, across) in places)

    @property
    def area(self) -> float:
        """Area of one side [m^2].

        Returns
        -------
        float
        """
        profile = self.profile
        return 2 * math.pi * profile.area_per_radian(profile.low, profile.high)

    @property
    def coordinate_scale(self) -> float:
        """Sum of the absolute coordinates of the profile's origin, and its reach from there [m]."""
        profile = self.profile
        reach = max(math.hypot(w, profile.radius_at(w)) for w in (profile.low, profile.high))
        return sum(map(abs, profile.origin)) + reach

    coordinate_names = ("height", "azimuth")  # of u and v

    def coordinates(self) -> dict[str, tuple[float, float, str]]:
        """Return the ranges of the height from the centre [m] and the azimuth [rad]."""
        half = self.height / 2
        return {"u": (-half, half, "m"), "v": (0.0, 2 * math.pi, "rad")}

    def strip_areas(self, u: np.ndarray) -> np.ndarray:
        """Return the areas of bands per azimuth [m^2/rad]."""
        profile, lower, upper = self.profile, u[:-1], u[1:]
        return (upper - lower) * profile.area_per_height(lower - profile.lift, upper - profile.lift)

    def cylindrical(self, point: Vector) -> tuple[float, float]:
        """Return the distance [m] of a point from the axis, and its height [m] from the profile's origin."""
        offset = tuple(p - o for p, o in zip(point, self.profile.origin, strict=True))
        e_u, e_v, axis = self.frame
        return math.hypot(dot(offset, e_u), dot(offset, e_v)), dot(offset, axis)

    def rims(self) -> list[Rim]:
        """Return the circles at both ends, unless they are poles."""
        profile, axis, found = self.profile, self.axis, []
        for height in () if self.is_closed else (profile.low, profile.high):
            radius = profile.radius_at(height)
            center = tuple(p + height * n for p, n in zip(profile.origin, axis, strict=True))
            found += [Rim(True, center, tuple(radius * x for x in axis))] if radius > 0 else []
        return found

    def distance(self, point: Vector, filled: bool = False) -> float:
        """Return the distance [m] of a point from the surface."""
        return self._distance_in_plane(*self.cylindrical(point))

    def _distance_in_plane(self, rho: float, w: float) -> float:
        """Distance [m] from a point at axial distance rho and height w; here the profile is straight."""
        profile = self.profile
        rims = [(profile.radius_at(rim), rim) for rim in (profile.low, profile.high)]
        length = math.dist(*rims)
        edge = tuple((q - p) / length for p, q in zip(*rims, strict=True))
        offset = rho - rims[0][0], w - rims[0][1]
        onward, across = edge[0] * offset[0] + edge[1] * offset[1], edge[1] * offset[0] - edge[0] * offset[1]
        return math.hypot(across, onward - min(max(onward, 0.0), length))

    def sample_area(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points even over the area, and the normals there; see `Shape`."""
        profile, (e_u, e_v, axis) = self.profile, np.array(self.frame)
        w = profile.even_heights(numbers[:, :1])
        turn = 2 * math.pi * numbers[:, 1:2]
        out, rho = np.cos(turn) * e_u + np.sin(turn) * e_v, profile.radius_at(w)
        slope = 0.5 * profile.beta + profile.gamma * w
        normals = (rho * out - slope * axis) / np.hypot(rho, slope)
        return np.array(profile.origin) + w * axis + rho * out, normals

    def _coerce_axis(self) -> None:
        """Check and store centre and axis."""
        coerce_vector(self, "center")
        coerce_direction(self, "axis")

    def _check_aspect(self, radius: float, height: float) -> None:
        """Raise for shapes so thin or flat that rounding cannot separate their two sides."""
        thin, wide = sorted((radius, height))
        if thin * thin == 0:
            refuse(self, f"squares of its lengths must not vanish, got {thin:.3g} m; change the unit")
        if thin < MIN_ASPECT * wide:
            cure = "make it thicker, or use a Disk for a flat shape"
            must = f"its radius and its length must not differ by more than 1 : {1 / MIN_ASPECT:.2g}"
            refuse(self, f"{must}, got {radius:.3g} m and {height:.3g} m; {cure}")


@scene_object(kw_only=True)
class Cylinder(Revolved):
    """Lateral surface of a circular cylinder, without end caps; normals point away from the axis.

    Parameters
    ----------
    center : three floats, default (0, 0, 0)
        Point on the axis at mid-height [m].
    axis : three floats, default (0, 0, 1)
        Direction of the axis, of any length; stored as a unit vector.
    radius : float
        Radius [m], positive.
    height : float
        Length along the axis [m], positive.

    Raises
    ------
    SceneError
        If a length is not positive, or radius and height differ by a factor above 1e12.

    Examples
    --------
    >>> import transport as tp
    >>> f"{tp.Cylinder(radius=1.0, height=2.0).area:.4f}"
    '12.5664'
    """

    center: VectorField = (0.0, 0.0, 0.0)
    axis: VectorField = (0.0, 0.0, 1.0)
    radius: float
    height: float

    def __post_init__(self) -> None:
        self._coerce_axis()
        coerce_positive(self, "radius", "height")
        self._check_aspect(self.radius, self.height)
        self._check_size("radius", "height")

    @property
    def profile(self) -> Profile:
        """Conic section rho^2 = radius^2."""
        half = self.height / 2
        return Profile(self.radius * self.radius, 0.0, 0.0, -half, half, self.center)

    @property
    def area(self) -> float:
        """Area of one side [m^2]."""
        return 2 * math.pi * self.radius * self.height

    @property
    def volume(self) -> float:
        """Volume between its ends [m^3]."""
        return math.pi * self.radius * self.radius * self.height

    @property
    def mean_chord(self) -> float:
        """Mean chord of the volume between its ends in isotropic light [m], with the ends in the area."""
        return 2 / (1 / self.radius + 1 / self.height)


@scene_object(kw_only=True)
class Cone(Revolved):
    """Lateral surface of a cone or frustum, without end caps; normals point away from the axis.

    Parameters
    ----------
    center : three floats, default (0, 0, 0)
        Point on the axis at mid-height [m].
    axis : three floats, default (0, 0, 1)
        Direction of the axis, of any length; stored as a unit vector.
    radius : float
        Radius at the lower end of the axis [m], zero or positive.
    top_radius : float, default 0
        Radius at the upper end of the axis [m], zero or positive; not both radii 0.
    height : float
        Length along the axis [m], positive.

    Raises
    ------
    SceneError
        If a length is out of range, or radius and height differ by a factor above 1e12.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Cone(radius=2.0, top_radius=1.0, height=2.0).slope
    -0.5
    """

    center: VectorField = (0.0, 0.0, 0.0)
    axis: VectorField = (0.0, 0.0, 1.0)
    radius: float
    top_radius: float = 0.0
    height: float

    def __post_init__(self) -> None:
        self._coerce_axis()
        coerce_nonnegative(self, "radius", "top_radius")
        coerce_positive(self, "height")
        if self.radius == self.top_radius == 0:
            refuse(
                self, "radius and top_radius must not both be 0, got 0.0 and 0.0; make one of them positive"
            )
        self._check_aspect(max(self.radius, self.top_radius), self.height)
        self._check_size("radius", "top_radius", "height")

    @property
    def slope(self) -> float:
        """Change of the radius with height."""
        return (self.top_radius - self.radius) / self.height

    @property
    def profile(self) -> Profile:
        """Conic section of the cone, from its centre, or from its apex if it is pointed.

        rho = mean radius + slope w from the centre; rho = ``|slope w|`` from the apex. Relative to the centre
        rho^2 would cancel near a narrow end; relative to the apex the heights of a nearly cylindrical cone
        would.
        """
        slope, radii = self.slope, (self.radius, self.top_radius)
        if min(radii) >= MIN_RADIUS_RATIO * max(radii):
            mean, half = (self.radius + self.top_radius) / 2, self.height / 2
            return Profile(mean * mean, 2 * mean * slope, slope * slope, -half, half, self.center)
        low, high = self.radius / slope + 0.0, self.top_radius / slope + 0.0
        lift = self.height / 2 - high if slope < 0 else -self.height / 2 - low
        return Profile(0.0, 0.0, slope * slope, low, high, _point_along(self.center, self.axis, lift), lift)

    @property
    def area(self) -> float:
        """Area of one side [m^2]."""
        slant = math.hypot(self.height, self.top_radius - self.radius)
        return math.pi * (self.radius + self.top_radius) * slant


@scene_object(kw_only=True)
class Paraboloid(Revolved):
    """Paraboloid of revolution that opens along `axis`: rho^2 = 4 focal_length w, between two radii.

    Normals point away from the axis, so that the focus lies on the back side.

    Parameters
    ----------
    center : three floats, default (0, 0, 0)
        Vertex [m].
    axis : three floats, default (0, 0, 1)
        Direction from the vertex to the focus, of any length; stored as a unit vector.
    focal_length : float
        Distance from vertex to focus [m], positive.
    radius : float
        Radius of the rim [m], positive.
    inner_radius : float, default 0
        Radius of a central hole [m], below `radius`.

    Raises
    ------
    SceneError
        If a length is out of range, or radius and depth differ by a factor above 1e12.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Paraboloid(focal_length=0.5, radius=1.0).focus
    (0.0, 0.0, 0.5)
    """

    center: VectorField = (0.0, 0.0, 0.0)
    axis: VectorField = (0.0, 0.0, 1.0)
    focal_length: float
    radius: float
    inner_radius: float = 0.0

    def __post_init__(self) -> None:
        self._coerce_axis()
        coerce_positive(self, "focal_length", "radius")
        coerce_nonnegative(self, "inner_radius")
        if self.inner_radius >= self.radius:
            refuse(self, f"inner_radius must be below radius {self.radius}, got {self.inner_radius}")
        self._check_aspect(self.radius, self.radius / self.focal_length * self.radius / 4)
        self._check_size("focal_length", "radius", "inner_radius")

    @property
    def focus(self) -> Vector:
        """Focus [m]."""
        return _point_along(self.center, self.axis, self.focal_length)

    @property
    def profile(self) -> Profile:
        """Conic section rho^2 = 4 f w."""
        slope = 4 * self.focal_length
        low, high = (radius / slope * radius for radius in (self.inner_radius, self.radius))
        return Profile(0.0, slope, 0.0, low, high, self.center)

    def coordinates(self) -> dict[str, tuple[float, float, str]]:
        """Return the ranges of the height from the vertex [m] and the azimuth [rad]."""
        return {"u": (self.profile.low, self.profile.high, "m"), "v": (0.0, 2 * math.pi, "rad")}

    def _distance_in_plane(self, rho: float, w: float) -> float:
        # Minimize the distance to (r, r^2/4f) over r: the roots of r^3 + (8 f^2 - 4 f w) r = 8 f^2 rho.
        size, f = self.radius, self.focal_length / self.radius
        rho, w = rho / size, w / size
        roots = np.roots([1.0, 0.0, 8 * f * f - 4 * f * w, -8 * f * f * rho]).real
        radii = [*np.clip(roots, self.inner_radius / size, 1.0).tolist(), self.inner_radius / size, 1.0]
        return size * min(math.hypot(rho - r, w - r * r / (4 * f)) for r in radii)


def _point_along(point: Vector, axis: Vector, length: float) -> Vector:
    """Point at a distance [m] from `point` along the axis."""
    return tuple(p + length * a + 0.0 for p, a in zip(point, axis, strict=True))
