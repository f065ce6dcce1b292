"""Vectors as tuples of three floats: products, unit vectors and local frames; independent of scale."""

import math

Vector = tuple[float, float, float]
Frame = tuple[Vector, Vector, Vector]

# Sine of the angle below which two directions count as parallel. It exceeds the rounding of single precision
# (6e-8), so that rounding never decides how a frame is rotated about its normal.
PARALLEL_SINE = 1e-6


def local_frame(normal: Vector, up: Vector | None) -> Frame:
    """Return the right-handed frame (e_u, e_v, n) of a unit normal.

    e_v is the component of `up` in the plane; the default `up` is +y, or +z for a normal along y. e_u is
    computed first, as up x n, which does not cancel.
    """
    if up is None:
        up = (0.0, 0.0, 1.0) if are_parallel(normal, (0.0, 1.0, 0.0)) else (0.0, 1.0, 0.0)
    e_v = unit_vector(_cross(normal, unit_vector(_cross(up, normal))))
    return unit_vector(_cross(e_v, normal)), e_v, normal


def are_parallel(a: Vector, b: Vector) -> bool:
    """Return whether two unit vectors are parallel or opposite, to within 1e-6 rad."""
    return math.hypot(*_cross(a, b)) <= PARALLEL_SINE


def unit_vector(vector: Vector) -> Vector:
    """Return the unit vector along a vector of any scale; a unit vector is returned unchanged."""
    if abs(math.hypot(*vector) - 1) <= 4e-16:
        return vector
    largest = max(map(abs, vector))
    scaled = [component / largest for component in vector]
    length = math.hypot(*scaled)
    return tuple(component / length + 0.0 for component in scaled)


def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return math.fsum(p * q for p, q in zip(a, b, strict=True))


def _cross(a: Vector, b: Vector) -> Vector:
    (ax, ay, az), (bx, by, bz) = a, b
    return ay * bz - az * by + 0.0, az * bx - ax * bz + 0.0, ax * by - ay * bx + 0.0
