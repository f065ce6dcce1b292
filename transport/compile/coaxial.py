"""Where shapes about one axis meet: their profiles are curves in one half-plane, which cross in rings about the axis.

So lids of a cylinder, the two caps of a lens and a cone on a tube, which share an edge only, are told from what comes
inside of what: a tube that stands on a plate, a ball in a tube.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from transport.shapes import FlatShape, Plane, Profile, Revolved, Shape, Sphere
from transport.shapes.distances import in_plane_distances
from transport.shapes.supports import place_about_axis, rounding_of
from transport.vectors import Vector, dot

ROUNDINGS = 64  # of the coordinates that meeting shapes may be apart
# The sine of the angle at which two shapes cross, and for each whether it has that ring when it is widened (shrunk).
Ring = tuple[float, tuple[Callable[[float], bool], Callable[[float], bool]]]


@dataclass(frozen=True)
class Turned:
    """A profile on an axis that it shares: its own height is sign (w - shift)."""

    profile: Profile
    sign: float = 1.0
    shift: float = 0.0

    def height(self, w: float) -> float:
        """Height [m] on the shape's own axis."""
        return self.sign * (w - self.shift)

    def radius(self, w: float) -> float:
        """rho [m]."""
        return self.profile.radius_at(self.height(w))

    def ends(self) -> tuple[float, float]:
        """The lower and the upper end [m] on the shared axis."""
        low, high = sorted(self.shift + self.sign * w for w in (self.profile.low, self.profile.high))
        return low, high

    def slope(self, w: float) -> float:
        """rho drho/dw [m]."""
        return self.sign * (self.profile.beta / 2 + self.profile.gamma * self.height(w))

    def holds(self, w: float, slack: float) -> bool:
        """Whether the ring there is of the shape when it is widened (shrunk) by a length along its profile."""
        own, rho, profile = self.height(w), self.radius(w), self.profile
        rise = slack if slack > 0 else slack * rho / (math.hypot(rho, self.slope(w)) or math.inf)
        ends = (profile.low, profile.high)
        low, high = (abs(slack) if profile.radius_at(end) == 0 else rise for end in ends)  # a pole is no edge
        return profile.low - low <= own <= profile.high + high


def ring_contact(hit: Shape, other: Shape, is_inside: bool, tolerance: float) -> bool | None:
    """Whether two shapes about one axis come within the tolerance; is_inside: away from the edge of the one that is hit.

    None where they do not share an axis, or where none of them is a surface of revolution with an edge.
    """
    turned = [shape for shape in (hit, other) if isinstance(shape, Revolved) and not _is_ball(shape)]
    if not turned:
        return None
    base = turned[0]
    guest = other if base is hit else hit
    tolerance = max(tolerance, ROUNDINGS * rounding_of(hit, other))
    if isinstance(guest, FlatShape) and _is_square_to(base, guest, tolerance):
        found = _in_plane(base, guest, tolerance)
    elif isinstance(guest, Revolved) and _is_about(base, guest, tolerance):
        found = _in_common(base, guest, tolerance)
    else:
        return None
    for sine, holders in found:
        # Where profiles cross at a small angle rounding moves their ring, up to a limit where they are tangent.
        lost = min(tolerance / sine if sine > 0 else math.inf, tolerance * math.sqrt(2.0**52 / ROUNDINGS))
        inner = -tolerance - lost if is_inside else tolerance
        slacks = (inner, tolerance) if base is hit else (tolerance, inner)
        if all(holds(slack) for holds, slack in zip(holders, slacks, strict=True)):
            return True
    return False


def _is_ball(shape: Shape) -> bool:
    return isinstance(shape, Sphere) and shape.is_closed


def _is_square_to(shape: Revolved, flat: FlatShape, tolerance: float) -> bool:
    reach = shape.extent + (0.0 if isinstance(flat, Plane) else flat.extent)
    return _chord(shape.axis, flat.normal) * reach <= tolerance


def _is_about(shape: Revolved, other: Revolved, tolerance: float) -> bool:
    """Whether another shape of revolution has the axis of the first; a whole sphere has all through its center."""
    tilt = 0.0 if _is_ball(other) else _chord(shape.axis, other.axis) * (shape.extent + other.extent)
    return place_about_axis(shape, other.profile.origin)[0] + tilt <= tolerance


def _chord(a: Vector, b: Vector) -> float:
    """Between two unit vectors that are taken to point the same way."""
    sign = math.copysign(1.0, dot(a, b))
    return math.hypot(*(p - sign * q for p, q in zip(a, b, strict=True)))


def _in_plane(base: Revolved, flat: FlatShape, tolerance: float) -> Iterator[Ring]:
    """The ring in which a plane square to the axis cuts the shape, if any; a point where it touches the pole."""
    profile, w = base.profile, place_about_axis(base, flat.center)[1]
    if profile.low - tolerance <= w <= profile.high + tolerance:
        turned, at = Turned(profile), min(max(w, profile.low), profile.high)
        rho = profile.radius_at(at)
        foot = tuple(o + w * a for o, a in zip(profile.origin, base.axis, strict=True))
        sine = rho / math.hypot(rho, turned.slope(at)) if rho > 0 else 0.0
        yield sine, (lambda slack: turned.holds(at, slack), lambda slack: _has_ring(flat, foot, rho, slack))


def _has_ring(flat: FlatShape, foot: Vector, rho: float, slack: float) -> bool:
    """Whether a circle in the plane meets a flat shape that is widened (shrunk) by a length."""
    if isinstance(flat, Plane):
        return True
    nearest, farthest = in_plane_distances(flat, foot)
    return (nearest == 0 or nearest - slack <= rho) and rho <= farthest + slack


def _in_common(base: Revolved, guest: Revolved, tolerance: float) -> Iterator[Ring]:
    """The rings in which two endless profiles cross, and the one in which they are nearest if that is near enough."""
    sign = 1.0 if _is_ball(guest) else math.copysign(1.0, dot(base.axis, guest.axis))
    one = Turned(base.profile)
    other = Turned(guest.profile, sign, place_about_axis(base, guest.profile.origin)[1])
    for w in _heights_of_crossing(one, other, tolerance):
        rho, slopes = one.radius(w), (one.slope(w), other.slope(w))
        lengths = math.hypot(rho, slopes[0]) * math.hypot(rho, slopes[1])
        sine = rho * abs(slopes[0] - slopes[1]) / lengths if lengths > 0 else 0.0
        yield sine, tuple(_holder(turned, w) for turned in (one, other))


def _holder(turned: Turned, w: float) -> Callable[[float], bool]:
    return lambda slack: turned.holds(w, slack)


def _heights_of_crossing(one: Turned, other: Turned, tolerance: float) -> Iterator[float]:
    """Heights at which both profiles have the same radius: the roots of a quadratic, and where they only come close."""
    c, b, a = (p - q for p, q in zip(_coefficients(one), _coefficients(other), strict=True))
    discriminant = b * b - 4 * a * c
    if discriminant > 0:
        pivot = -(b + math.copysign(math.sqrt(discriminant), b)) / 2
        yield from (w for w in (pivot / a if a != 0 else math.inf, c / pivot) if math.isfinite(w))
    lows, highs = zip(one.ends(), other.ends(), strict=True)
    nearest = -b / (2 * a) if a != 0 else (max(lows) + min(highs)) / 2
    if abs(one.radius(nearest) - other.radius(nearest)) <= tolerance:
        yield nearest


def _coefficients(turned: Turned) -> tuple[float, float, float]:
    """Of rho^2 in powers of the common height."""
    profile, sign, shift = turned.profile, turned.sign, turned.shift
    linear = profile.beta * sign - 2 * profile.gamma * shift
    return profile.alpha - shift * (profile.beta * sign - profile.gamma * shift), linear, profile.gamma
