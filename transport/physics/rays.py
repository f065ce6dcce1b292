"""Intersections of a ray with a plane, a sphere and a box, without cancellation."""

import math

from transport.physics.device import device


@device
def plane_crossing(rx, ry, rz, ux, uy, uz, nx, ny, nz):
    """Return the distance along u to the plane with normal n through the point at r from the ray's origin.

    Also returns the crossing relative to that point. A ray parallel to the plane gives infinity or NaN, which
    every comparison rejects.
    """
    t = (rx * nx + ry * ny + rz * nz) / (ux * nx + uy * ny + uz * nz)
    return t, t * ux - rx, t * uy - ry, t * uz - rz


@device
def sphere_crossing(ox, oy, oz, ux, uy, uz, radius, start, standing, own, closed, passed):
    """Return the distance along u to the next crossing of a sphere beyond `start`; infinity for none.

    o: origin of the ray from the centre. closed: a crossing at `start` counts too. standing: one crossing is
    known, at distance `own`; the other follows from the sum of both, without cancellation. passed: `start` is
    one of the crossings.

    The discriminant is computed from the perpendicular through the centre, and the small root from the large
    one (their product is o² − r²): stable for distant and for small spheres (Haines et al. 2019, Ray Tracing
    Gems ch. 7).
    """
    h = ox * ux + oy * uy + oz * uz
    qx, qy, qz = ox - h * ux, oy - h * uy, oz - h * uz
    d = radius * radius - (qx * qx + qy * qy + qz * qz)
    s = math.sqrt(d if d > 0.0 else 0.0)
    o = math.sqrt(ox * ox + oy * oy + oz * oz)
    c = (o - radius) * (o + radius)
    q = -h - s if h > 0.0 else -h + s
    other = c / q if q != 0.0 else 0.0
    near = q if h > 0.0 else other
    far = other if h > 0.0 else q
    t = near if (near > start) | (closed & (near == start)) else far
    t = (far if abs(near - start) <= abs(far - start) else math.inf) if passed else t
    t = (math.inf if passed else -2.0 * h - own) if standing else t
    met = (standing | (d > 0.0)) & ((t > start) | (closed & (t == start)))
    return t if met else math.inf


@device
def box_crossings(ox, oy, oz, ux, uy, uz, hx, hy, hz):
    """Return entry and exit of a ray through a box with half sides h: distance and |cosine| of each.

    o: origin of the ray from the centre. The ray misses the box if the entry lies beyond the exit. Slabs: Kay
    and Kajiya (1986).
    """
    sx, sy, sz = math.copysign(hx, ux), math.copysign(hy, uy), math.copysign(hz, uz)
    ix, iy, iz = 1.0 / ux, 1.0 / uy, 1.0 / uz
    near_x, near_y, near_z = (-sx - ox) * ix, (-sy - oy) * iy, (-sz - oz) * iz
    far_x, far_y, far_z = (sx - ox) * ix, (sy - oy) * iy, (sz - oz) * iz
    near, near_cosine = near_x, abs(ux)
    near_cosine = abs(uy) if near_y > near else near_cosine
    near = near_y if near_y > near else near
    near_cosine = abs(uz) if near_z > near else near_cosine
    near = near_z if near_z > near else near
    far, far_cosine = far_x, abs(ux)
    far_cosine = abs(uy) if far_y < far else far_cosine
    far = far_y if far_y < far else far
    far_cosine = abs(uz) if far_z < far else far_cosine
    far = far_z if far_z < far else far
    return near, near_cosine, far, far_cosine
