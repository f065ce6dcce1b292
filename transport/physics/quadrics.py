"""Surfaces of revolution of second order: rho^2 = alpha + beta w + gamma w^2, w along the axis, rho from it.

Cylinder, cone, paraboloid and sphere differ only in the three coefficients. Rays are followed from their
point nearest to the origin of w, where all terms are of the surface's size, so distant rays keep their
digits.
"""

import math

from transport.physics.device import device

# Relative rounding of the discriminant: a ray that misses by less is tangent, or passes a cone's apex.
GRAZING = 2.0**-50


@device
def quadric_form(px, py, pz, ax, ay, az, alpha, beta, gamma):
    """Return rho^2 - alpha - beta w - gamma w^2 at p (negative inside), half its gradient, and w."""
    w = px * ax + py * ay + pz * az
    qx, qy, qz = px - w * ax, py - w * ay, pz - w * az
    slope = 0.5 * beta + gamma * w
    value = qx * qx + qy * qy + qz * qz - (alpha + w * (beta + gamma * w))
    return value, qx - slope * ax, qy - slope * ay, qz - slope * az, w


@device
def quadric_crossings(ox, oy, oz, ux, uy, uz, ax, ay, az, alpha, beta, gamma, standing, own, touching):
    """Return (near, far, w, pace, steep) for a ray from o along u: distances of both crossings, and heights.

    near, far: NaN or infinity where there is no crossing. w, pace: height at distance 0 and its change per
    distance. steep: the ray is steeper than the cone. standing: one crossing is known, at distance `own`; the
    other follows from the sum of both, without cancellation. touching: a tangent ray (within rounding) hits
    the surface; otherwise it stays on its side, but a ray steeper than a cone passes through its apex, where
    both distances coincide.
    """
    # Coefficients of a t^2 + 2 b t + c = 0, with t from the ray's point nearest to the origin of w.
    w, pace = ox * ax + oy * ay + oz * az, ux * ax + uy * ay + uz * az
    qx, qy, qz = ux - pace * ax, uy - pace * ay, uz - pace * az
    a = qx * qx + qy * qy + qz * qz - gamma * pace * pace
    h = ox * ux + oy * uy + oz * uz
    px, py, pz = ox - h * ux, oy - h * uy, oz - h * uz  # the ray's point nearest to the origin of w
    v = px * ax + py * ay + pz * az
    rx, ry, rz = px - v * ax, py - v * ay, pz - v * az
    b = rx * qx + ry * qy + rz * qz - (0.5 * beta + gamma * v) * pace
    c = rx * rx + ry * ry + rz * rz - (alpha + v * (beta + gamma * v))
    # b² - a c by Lagrange's identity: for a flat cone both terms are far larger than their difference.
    kx, ky, kz = pace * rx - v * qx, pace * ry - v * qy, pace * rz - v * qz
    m = ax * (ry * qz - rz * qy) + ay * (rz * qx - rx * qz) + az * (rx * qy - ry * qx)
    bent, tilted = gamma * (kx * kx + ky * ky + kz * kz), beta * (qx * kx + qy * ky + qz * kz)
    half_beta = 0.5 * beta * pace
    d = bent - m * m - tilted + half_beta * half_beta + alpha * a
    rounding = GRAZING * (abs(bent) + m * m + abs(tilted) + half_beta * half_beta + abs(alpha * a))
    # Stable roots: the larger one first, the other from the product of both.
    steep, touches = a < 0.0, abs(d) <= rounding
    s = math.sqrt(d if d > 0.0 else 0.0) if (d > 0.0) | touches else math.nan
    s = math.nan if touches & (not touching) else s
    # A ray steeper than the cone always hits it or its mirror image.
    s = (0.0 if touches | (d < 0.0) else s) if steep else s
    q = -b - s if b > 0.0 else -b + s
    first = q / a - h
    second = first if s == 0.0 else c / q - h
    # The other crossing of a ray that begins on the surface.
    ex, ey, ez = ox - w * ax, oy - w * ay, oz - w * az
    half = ex * qx + ey * qy + ez * qz - (0.5 * beta + gamma * w) * pace
    other = -2.0 * half / a - own
    near = first if first < second else second
    far = second if first < second else first
    near = second if first != first else near  # the other one is at infinity
    return other if standing else near, math.nan if standing else far, w, pace, steep


@device
def on_one_nappe(at_near, at_far, slack, pace, is_below, standing):
    """Return the heights over the apex of both crossings of a ray steeper than a cone.

    NaN on the mirror image.

    Within rounding of the apex the ray's direction decides which crossing is on the cone, and its height is
    0.
    """
    at_near = 0.0 if abs(at_near) <= slack else at_near
    at_far = 0.0 if abs(at_far) <= slack else at_far
    is_near = (pace > 0.0) == is_below
    return at_near if is_near & (not standing) else math.nan, math.nan if is_near else at_far


@device
def next_crossing(near, far, is_near_in, is_far_in, start, closed, passed):
    """Return the first of two crossings within the surface's bounds beyond `start`; infinity for none.

    closed: a crossing at `start` counts too. passed: the crossing at `start` has been taken; it is the one
    closest to it.
    """
    is_near_ahead = is_near_in & ((near > start) | (closed & (near == start)))
    is_far_ahead = is_far_in & ((far > start) | (closed & (far == start)))
    was_near = abs(near - start) <= abs(far - start)
    is_near_ahead &= not passed
    is_far_ahead &= (not passed) | was_near
    t = far if is_far_ahead else math.inf
    return near if is_near_ahead else t
