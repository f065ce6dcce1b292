"""Ray-triangle intersection for meshes: exactly one crossing at edges and vertices that triangles share.

Woop, Benthin and Wald (2013), "Watertight ray/triangle intersection": vertices are sheared into the ray's
frame, in which the signs of three edge functions decide. A vertex gives the same numbers for all its
triangles, and a rounded difference of two rounded products never has the wrong sign: it is 0 where it is
undecided. There the products are computed exactly, and a ray through the edge itself is displaced by an
infinitesimal (e, e^2) that is the same for all triangles. No fused operations here: they would make the two
sides of an edge differ.
"""

import math

from transport.physics.device import exact_device

SPLITTER = 134217729.0  # 2^27 + 1


@exact_device
def product_error(a, b, product):
    """Return a b minus its rounded product, exactly (Veltkamp 1968, Dekker 1971)."""
    p, q = SPLITTER * a, SPLITTER * b
    a_high, b_high = p - (p - a), q - (q - b)
    a_low, b_low = a - a_high, b - b_high
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


@exact_device
def edge_function(px, py, qx, qy):
    """Return px qy - py qx with the right sign; 0 only for coincident points."""
    left, right = px * qy, py * qx
    value = left - right
    # Undecided: compare the rounding errors, then displace the ray by (e, e^2).
    if value == 0.0:
        value = product_error(px, qy, left) - product_error(py, qx, right)
        if value == 0.0:
            value = qy - py
            if value == 0.0:
                value = px - qx
            value = math.copysign(1e-300, value) if value != 0.0 else 0.0
    return value


@exact_device
def passes_near(ax, ay, az, bx, by, bz, cx, cy, cz, shear_x, shear_y, foot_x, foot_y, margin):
    """Return whether a ray passes through a triangle, or by less than rounding beside it.

    ax ... cz: the vertices, with z along the largest component of the ray's direction. (foot_x, foot_y):
    point of the ray at z = 0, which moves by shear_x, shear_y per z. margin: bound of the rounding of the
    edge functions.
    """
    ax, ay = (ax - shear_x * az) - foot_x, (ay - shear_y * az) - foot_y
    bx, by = (bx - shear_x * bz) - foot_x, (by - shear_y * bz) - foot_y
    cx, cy = (cx - shear_x * cz) - foot_x, (cy - shear_y * cz) - foot_y
    u, v, w = cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax
    return (min(u, min(v, w)) >= -margin) | (max(u, max(v, w)) <= margin)


@exact_device
def crossing_weights(ax, ay, bx, by, cx, cy):
    """Return the weights of a triangle's vertices where a ray crosses it, of one sign; all 0 for a miss.

    ax ... cy: the sheared vertices, across the ray from its origin. The sum of the weights is twice the
    sheared triangle's signed area.
    """
    u = edge_function(cx, cy, bx, by)
    v = edge_function(ax, ay, cx, cy)
    w = edge_function(bx, by, ax, ay)
    is_in = ((u > 0.0) & (v > 0.0) & (w > 0.0)) | ((u < 0.0) & (v < 0.0) & (w < 0.0))
    return (u, v, w) if is_in else (0.0, 0.0, 0.0)


@exact_device
def plane_distance(u, v, w, az, bz, cz, height, cosine):
    """Return the distance to the plane of a facet that a ray crosses, within the range of its vertices.

    u, v, w: weights of the vertices, whose mean distance counts if the ray lies in the plane; for slivers it
    is off the plane, since their narrowness magnifies rounding. az, bz, cz: the vertices' distances along the
    ray. height: of the facet's plane over the ray's origin, along its normal.
    """
    nearest, farthest = min(az, min(bz, cz)), max(az, max(bz, cz))
    t = height / cosine if cosine != 0.0 else (u * az + v * bz + w * cz) / (u + v + w)
    return min(max(t, nearest), farthest)


@exact_device
def lies_beside_edge(ax, ay, az, bx, by, bz, nx, ny, nz, reach):
    """Return whether the origin is farther than `reach` outside edge a b of a facet with normal n."""
    ex, ey, ez = bx - ax, by - ay, bz - az
    inward = ax * (ny * ez - nz * ey) + ay * (nz * ex - nx * ez) + az * (nx * ey - ny * ex)
    return inward > reach * math.sqrt(ex * ex + ey * ey + ez * ez)


@exact_device
def within_facet(x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz, nx, ny, nz):
    """Return a point of a facet's plane, clamped to the facet.

    Only the rounding of a grazing ray puts it beside.
    """
    ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
    px, py, pz = x - ax, y - ay, z - az
    # Barycentric weights of the second and third vertex.
    twice = nx * (uy * vz - uz * vy) + ny * (uz * vx - ux * vz) + nz * (ux * vy - uy * vx)
    p = (nx * (py * vz - pz * vy) + ny * (pz * vx - px * vz) + nz * (px * vy - py * vx)) / twice
    q = (nx * (uy * pz - uz * py) + ny * (uz * px - ux * pz) + nz * (ux * py - uy * px)) / twice
    is_in = (p >= 0.0) & (q >= 0.0) & (p + q <= 1.0)
    p, q = max(p, 0.0), max(q, 0.0)
    share = 1.0 / max(p + q, 1.0)
    p, q = p * share, q * share
    x, y, z = (x, y, z) if is_in else (ax + p * ux + q * vx, ay + p * uy + q * vy, az + p * uz + q * vz)
    return x, y, z
