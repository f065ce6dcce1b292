"""Contact of surfaces of revolution about one axis: profiles in a half-plane that cross in rings.

Distinguishes surfaces that share an edge only (the lids of a cylinder, the two faces of a lens, a cone on a
tube) from surfaces that touch or cut the interior of another (a tube that stands on a plate, a sphere in a
tube).
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from transport.geometry.distances import in_plane_distances
from transport.geometry.flat import FlatShape, Plane
from transport.geometry.revolved import Profile, Revolved
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.geometry.supports import cylindrical_coordinates, rounding_tolerance
from transport.vectors import Vector, dot

GAP_IN_ROUNDINGS = 64  # allowed gap between touching shapes, in roundings of their coordinates
# Sine of the angle at which two shapes cross, and for each shape a test whether it has the ring when widened
# by a length.
Ring = tuple[float, tuple[Callable[[float], bool], Callable[[float], bool]]]


@dataclass(frozen=True)
class AxisProfile:
    """A profile on a shared axis: the height on its own axis is sign (w - shift)."""

    profile: Profile
    sign: float = 1.0
    shift: float = 0.0

    def height(self, w: float) -> float:
        """Return the height [m] on the shape's own axis."""
        return self.sign * (w - self.shift)

    def radius(self, w: float) -> float:
        """Return the radius rho [m] at height w."""
        return self.profile.radius_at(self.height(w))

    def ends(self) -> tuple[float, float]:
        """Return the lower and the upper end [m] on the shared axis."""
        low, high = sorted(self.shift + self.sign * w for w in (self.profile.low, self.profile.high))
        return low, high

    def slope(self, w: float) -> float:
        """Return rho drho/dw [m] at height w."""
        return self.sign * (self.profile.beta / 2 + self.profile.gamma * self.height(w))

    def holds(self, w: float, slack: float) -> bool:
        """Return whether the shape, widened by `slack` (negative: shrunk), contains the ring at w."""
        own, rho, profile = self.height(w), self.radius(w), self.profile
        rise = slack if slack > 0 else slack * rho / (math.hypot(rho, self.slope(w)) or math.inf)
        ends = (profile.low, profile.high)
        # a pole is not an edge
        low, high = (abs(slack) if profile.radius_at(end) == 0 else rise for end in ends)
        return profile.low - low <= own <= profile.high + high


def ring_contact(hit: Shape, other: Shape, is_inside: bool, tolerance: float) -> bool | None:
    """Return whether two shapes about one axis come within the tolerance [m] of one another.

    is_inside: count only contacts away from the edge of `hit`. Return None where the shapes do not share an
    axis, or where neither is a surface of revolution with an edge.
    """
    turned = [shape for shape in (hit, other) if isinstance(shape, Revolved) and not _is_whole_sphere(shape)]
    if not turned:
        return None
    base = turned[0]
    guest = other if base is hit else hit
    tolerance = max(tolerance, GAP_IN_ROUNDINGS * rounding_tolerance(hit, other))
    # Find the rings in which the profiles cross.
    if isinstance(guest, FlatShape) and _is_perpendicular(base, guest, tolerance):
        found = _rings_in_plane(base, guest, tolerance)
    elif isinstance(guest, Revolved) and _is_coaxial(base, guest, tolerance):
        found = _common_rings(base, guest, tolerance)
    else:
        return None
    for sine, holders in found:
        # Rounding moves the ring of profiles that cross at a small angle; the shift is bounded where they are
        # tangent.
        lost = min(
            tolerance / sine if sine > 0 else math.inf, tolerance * math.sqrt(2.0**52 / GAP_IN_ROUNDINGS)
        )
        inner = -tolerance - lost if is_inside else tolerance
        slacks = (inner, tolerance) if base is hit else (tolerance, inner)
        if all(holds(slack) for holds, slack in zip(holders, slacks, strict=True)):
            return True
    return False


def _is_whole_sphere(shape: Shape) -> bool:
    return isinstance(shape, Sphere) and shape.is_closed


def _is_perpendicular(shape: Revolved, flat: FlatShape, tolerance: float) -> bool:
    """Return whether a flat shape is perpendicular to the axis, within the tolerance."""
    reach = shape.extent + (0.0 if isinstance(flat, Plane) else flat.extent)
    return _chord(shape.axis, flat.normal) * reach <= tolerance


def _is_coaxial(shape: Revolved, other: Revolved, tolerance: float) -> bool:
    """Return whether two shapes share an axis; a sphere shares all through its center."""
    tilt = 0.0 if _is_whole_sphere(other) else _chord(shape.axis, other.axis) * (shape.extent + other.extent)
    return cylindrical_coordinates(shape, other.profile.origin)[0] + tilt <= tolerance


def _chord(a: Vector, b: Vector) -> float:
    """Return the chord between two unit vectors, up to sign."""
    sign = math.copysign(1.0, dot(a, b))
    return math.hypot(*(p - sign * q for p, q in zip(a, b, strict=True)))


def _rings_in_plane(base: Revolved, flat: FlatShape, tolerance: float) -> Iterator[Ring]:
    """Yield the ring that a perpendicular plane cuts from the shape; a point at a pole."""
    profile, w = base.profile, cylindrical_coordinates(base, flat.center)[1]
    if profile.low - tolerance <= w <= profile.high + tolerance:
        turned, at = AxisProfile(profile), min(max(w, profile.low), profile.high)
        rho = profile.radius_at(at)
        foot = tuple(o + w * a for o, a in zip(profile.origin, base.axis, strict=True))
        sine = rho / math.hypot(rho, turned.slope(at)) if rho > 0 else 0.0
        yield sine, (lambda slack: turned.holds(at, slack), lambda slack: _has_ring(flat, foot, rho, slack))


def _has_ring(flat: FlatShape, foot: Vector, rho: float, slack: float) -> bool:
    """Return whether a circle in the plane meets a flat shape widened by a length (negative: shrunk)."""
    if isinstance(flat, Plane):
        return True
    nearest, farthest = in_plane_distances(flat, foot)
    return (nearest == 0 or nearest - slack <= rho) and rho <= farthest + slack


def _common_rings(base: Revolved, guest: Revolved, tolerance: float) -> Iterator[Ring]:
    """Yield the rings in which two unbounded profiles cross, or come within the tolerance."""
    sign = 1.0 if _is_whole_sphere(guest) else math.copysign(1.0, dot(base.axis, guest.axis))
    one = AxisProfile(base.profile)
    other = AxisProfile(guest.profile, sign, cylindrical_coordinates(base, guest.profile.origin)[1])
    for w in _crossing_heights(one, other, tolerance):
        rho, slopes = one.radius(w), (one.slope(w), other.slope(w))
        lengths = math.hypot(rho, slopes[0]) * math.hypot(rho, slopes[1])
        sine = rho * abs(slopes[0] - slopes[1]) / lengths if lengths > 0 else 0.0
        yield sine, tuple(_ring_test(turned, w) for turned in (one, other))


def _ring_test(turned: AxisProfile, w: float) -> Callable[[float], bool]:
    return lambda slack: turned.holds(w, slack)


def _crossing_heights(one: AxisProfile, other: AxisProfile, tolerance: float) -> Iterator[float]:
    """Yield heights of equal radius: roots of a quadratic, and the height of closest approach."""
    c, b, a = (p - q for p, q in zip(_coefficients(one), _coefficients(other), strict=True))
    discriminant = b * b - 4 * a * c
    if discriminant > 0:
        pivot = -(b + math.copysign(math.sqrt(discriminant), b)) / 2
        yield from (w for w in (pivot / a if a != 0 else math.inf, c / pivot) if math.isfinite(w))
    lows, highs = zip(one.ends(), other.ends(), strict=True)
    nearest = -b / (2 * a) if a != 0 else (max(lows) + min(highs)) / 2
    if abs(one.radius(nearest) - other.radius(nearest)) <= tolerance:
        yield nearest


def _coefficients(turned: AxisProfile) -> tuple[float, float, float]:
    """Return the coefficients of rho^2 in powers of the common height."""
    profile, sign, shift = turned.profile, turned.sign, turned.shift
    linear = profile.beta * sign - 2 * profile.gamma * shift
    return profile.alpha - shift * (profile.beta * sign - profile.gamma * shift), linear, profile.gamma
