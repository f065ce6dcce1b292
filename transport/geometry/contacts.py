"""Find surfaces that cut or touch the interior of another: overhanging walls, a sphere on a floor.

A particle that lands there lies within rounding of both surfaces, and the sign of a rounding error must not
decide on which side of the other it is. The engine keeps it on the side it came from, in scenes with such
contacts only. Surfaces that share an edge only (the lids of a cylinder, the two faces of a lens, a cone on a
tube) are told from those that touch or cut the interior of another (a tube that stands on a plate, a sphere
in a tube).
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from transport.geometry.flat import Disk, FlatShape
from transport.geometry.neighbours import touching_boxes
from transport.geometry.relations import are_on_one_support, rounding_tolerance
from transport.geometry.revolved import Profile, Revolved
from transport.geometry.shape import ROUNDING, Shape
from transport.vectors import Vector, dot

GAP_IN_ROUNDINGS = 64  # allowed gap between touching shapes, in roundings of their coordinates
# Sine of the angle at which two shapes cross, and for each shape a test whether it has the ring when widened
# by a length.
Ring = tuple[float, tuple[Callable[[float], bool], Callable[[float], bool]]]


def contact_pairs(shapes: Sequence[Shape]) -> Iterator[tuple[int, int]]:
    """Yield pairs (hit, other) of shapes, by index, that come within rounding of one another.

    Yield nothing where surfaces share edges only: points near an edge are clamped to their own surface
    anyway.
    """
    pairs = list(_pairs(shapes))
    if any(is_inside for *_, is_inside in pairs):
        yield from (pair[:2] for pair in pairs)


def _pairs(shapes: Sequence[Shape]) -> Iterator[tuple[int, int, bool]]:
    """Yield pairs (hit, other) that touch, and whether the contact lies inside `hit`, away from its edge."""
    if not shapes:
        return
    low, high = (np.array([shape.bounds[side] for shape in shapes]) for side in (0, 1))
    places = np.array([(*shape.middle, *shape.middle) for shape in shapes])
    # Derive the tolerance from the largest finite coordinate.
    finite = np.where(np.isfinite([*low.T, *high.T]).T, np.hstack((low, high)), places)
    tolerance = 64 * ROUNDING * (np.abs(finite[:, :3]).max() + np.abs(finite[:, 3:]).max())
    # Compare shapes with overlapping bounding boxes only.
    for hit, near in enumerate(touching_boxes(low - tolerance, high)):
        for other in near.tolist():
            if touches(shapes[hit], shapes[other], tolerance, tolerance):
                is_inside = touches(shapes[hit], shapes[other], -tolerance, tolerance)
                yield hit, other, is_inside


def touches(hit: Shape, other: Shape, widened: float, tolerance: float) -> bool:
    """Return whether `hit` comes within the tolerance [m] of `other`.

    widened [m]: enlarges `hit` (negative: shrinks it).

    Exact for flat shapes, whole spheres and surfaces of revolution about one axis. Other pairs with a surface
    of revolution count as touching unless a plane separates them. A mesh touches nothing: it has no support.
    """
    if hit.triangles or other.triangles or are_on_one_support(hit, other):
        return False
    if hit.is_flat and other.is_flat:
        inside, beside = _common_line(hit, other, widened, tolerance)
        return inside[0] < inside[1] and max(inside[0], beside[0]) <= min(inside[1], beside[1])
    if hit.is_closed and other.is_closed:  # two whole spheres: other closed shapes have pieces
        apart = math.dist(hit.center, other.center)
        return abs(hit.radius - other.radius) - tolerance <= apart <= hit.radius + other.radius + tolerance
    about_one_axis = ring_contact(hit, other, widened < 0, tolerance)
    if about_one_axis is not None:
        return about_one_axis
    if hit.is_flat or other.is_flat:
        flat, turned = (hit, other) if hit.is_flat else (other, hit)
        return _reaches_plane(turned, flat, tolerance)
    return True


def _reaches_plane(shape: Revolved, flat: FlatShape, tolerance: float) -> bool:
    """Return whether a surface of revolution reaches the plane of a flat shape."""
    height = dot(_difference(shape.profile.origin, flat.center), flat.normal)
    along = dot(shape.axis, flat.normal)
    across = math.hypot(*(dot(axis, flat.normal) for axis in shape.frame[:2]))
    reach = shape.profile.reach
    return -reach(-along, across) - tolerance <= -height <= reach(along, across) + tolerance


def _common_line(
    hit: Shape, other: Shape, widened: float, tolerance: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the intervals of two planes' common line within `hit`, widened, and within `other`."""
    nothing = (math.inf, -math.inf)
    slope = dot(hit.normal, other.normal)
    across = tuple(m - slope * n for m, n in zip(other.normal, hit.normal, strict=True))
    steep = dot(across, across)
    span = sum(shape.extent for shape in (hit, other) if not shape.is_infinite)
    if steep <= max(ROUNDING, tolerance / span if span > 0 else 0.0) ** 2:
        return nothing, nothing
    step = dot(_difference(other.center, hit.center), other.normal) / steep
    point = tuple(c + step * a for c, a in zip(hit.center, across, strict=True))
    x, y = hit.normal, other.normal
    line = (x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0])
    line = tuple(value / math.sqrt(steep) for value in line)
    return _interval_in_shape(hit, point, line, widened), _interval_in_shape(other, point, line, tolerance)


def _interval_in_shape(shape: Shape, point: Vector, line: Vector, slack: float) -> tuple[float, float]:
    """Return the interval of a coplanar line within a shape widened by the slack, holes ignored."""
    offset = _difference(point, shape.center)
    if isinstance(shape, Disk):
        middle = -dot(offset, line)
        apart2 = dot(offset, offset) - middle * middle
        half2 = max(shape.radius + slack, 0.0) ** 2 - apart2
        half = math.sqrt(half2) if half2 > 0 else -math.inf
        return middle - half, middle + half
    enter, leave = -math.inf, math.inf
    for across, reach in shape.edges():
        place, pace, half = dot(offset, across), dot(line, across), reach + slack
        if abs(pace) * shape.extent <= abs(slack):
            if place > half:
                return math.inf, -math.inf
            continue
        end = (half - place) / pace
        enter, leave = (enter, min(leave, end)) if pace > 0 else (max(enter, end), leave)
    return enter, leave


def _difference(a: Vector, b: Vector) -> Vector:
    return tuple(p - q for p, q in zip(a, b, strict=True))


# ---- Surfaces of revolution about one axis: profiles in a half-plane that cross in rings.


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
    turned = [shape for shape in (hit, other) if isinstance(shape, Revolved) and not shape.is_closed]
    if not turned:
        return None
    base = turned[0]
    guest = other if base is hit else hit
    tolerance = max(tolerance, GAP_IN_ROUNDINGS * rounding_tolerance(hit, other))
    # Find the rings in which the profiles cross.
    if guest.is_flat and _is_perpendicular(base, guest, tolerance):
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


def _is_perpendicular(shape: Revolved, flat: FlatShape, tolerance: float) -> bool:
    """Return whether a flat shape is perpendicular to the axis, within the tolerance."""
    reach = shape.extent + (0.0 if flat.is_infinite else flat.extent)
    return _chord(shape.axis, flat.normal) * reach <= tolerance


def _is_coaxial(shape: Revolved, other: Revolved, tolerance: float) -> bool:
    """Return whether two shapes share an axis; a sphere shares all through its center."""
    tilt = 0.0 if other.is_closed else _chord(shape.axis, other.axis) * (shape.extent + other.extent)
    return shape.cylindrical(other.profile.origin)[0] + tilt <= tolerance


def _chord(a: Vector, b: Vector) -> float:
    """Return the chord between two unit vectors, up to sign."""
    sign = math.copysign(1.0, dot(a, b))
    return math.hypot(*(p - sign * q for p, q in zip(a, b, strict=True)))


def _rings_in_plane(base: Revolved, flat: FlatShape, tolerance: float) -> Iterator[Ring]:
    """Yield the ring that a perpendicular plane cuts from the shape; a point at a pole."""
    profile, w = base.profile, base.cylindrical(flat.center)[1]
    if profile.low - tolerance <= w <= profile.high + tolerance:
        turned, at = AxisProfile(profile), min(max(w, profile.low), profile.high)
        rho = profile.radius_at(at)
        foot = tuple(o + w * a for o, a in zip(profile.origin, base.axis, strict=True))
        sine = rho / math.hypot(rho, turned.slope(at)) if rho > 0 else 0.0
        yield sine, (lambda slack: turned.holds(at, slack), lambda slack: _has_ring(flat, foot, rho, slack))


def _has_ring(flat: FlatShape, foot: Vector, rho: float, slack: float) -> bool:
    """Return whether a circle in the plane meets a flat shape widened by a length (negative: shrunk)."""
    if flat.is_infinite:
        return True
    nearest, farthest = flat.in_plane_distances(foot)
    return (nearest == 0 or nearest - slack <= rho) and rho <= farthest + slack


def _common_rings(base: Revolved, guest: Revolved, tolerance: float) -> Iterator[Ring]:
    """Yield the rings in which two unbounded profiles cross, or come within the tolerance."""
    sign = 1.0 if guest.is_closed else math.copysign(1.0, dot(base.axis, guest.axis))
    one = AxisProfile(base.profile)
    other = AxisProfile(guest.profile, sign, base.cylindrical(guest.profile.origin)[1])
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
