"""Meshes: BVH traversal to the first facet along a ray, normals of facets, births on facets.

Acting meshes. A ray that begins on a facet lies within rounding of the adjacent facets, on either side of
them, and rounding may carry it past them. Which of them it hits is therefore decided by its direction and the
fold: at once those that it leaves through and that rise on its side of its own facet, else none. Two facets
that a ray crosses at one place, one inwards and one outwards, are ordered by their fold too. Rounding at the
joints of facets thus neither leaks through a closed mesh nor swaps inside and outside.

Transparent mesh detectors. All crossings of a ray are computed from one origin and taken in order of
distance, then of facet number: each once.
"""

import math

import numpy as np

from transport.compile import layout
from transport.compile.layout import ROUNDING
from transport.engine.bodies import lane_pass, own_memory
from transport.engine.bundle import view
from transport.engine.words import passed_sheet, standing_sheet
from transport.physics.device import EXACT, exact_device
from transport.physics.facets import facet_crossing, lies_beside_edge, plane_distance, within_facet
from transport.physics.streams import DEPTH, POSITION, random_words, uniform

NONE_AT_START = 1 << 62
STACK = 128  # nodes and facets that wait during a search
stack_memory = own_memory(STACK)
MAX_RECIPROCAL = 1e300  # reciprocal of a direction component that is 0: times 0 it gives 0
# [scene lengths] radius about a point of a mesh within which facets count as joined there
SLACK = 16.0 * ROUNDING
BOX_ROUNDING = 2.0**-48  # relative rounding of the crossings of a box


@exact_device
def reciprocal(u):
    """Return 1/u, finite for u = 0."""
    return 1.0 / u if abs(u) > 1.0 / MAX_RECIPROCAL else math.copysign(MAX_RECIPROCAL, u)


@exact_device
def box_entry(low_x, low_y, low_z, high_x, high_y, high_z, ox, oy, oz, ix, iy, iz, start, best):
    """Return the distance at which a ray enters a box (slab test); infinity for a miss.

    A box that the ray left before `start` or enters beyond `best` is a miss. ix, iy, iz: reciprocal
    direction.
    """
    p, q = (low_x - ox) * ix, (high_x - ox) * ix
    near, far = p if p < q else q, q if p < q else p
    p, q = (low_y - oy) * iy, (high_y - oy) * iy
    small, large = p if p < q else q, q if p < q else p
    near, far = small if small > near else near, large if large < far else far
    p, q = (low_z - oz) * iz, (high_z - oz) * iz
    small, large = p if p < q else q, q if p < q else p
    near, far = small if small > near else near, large if large < far else far
    far += BOX_ROUNDING * abs(far)
    return near if (near <= far) & (far >= start) & (near <= best) else math.inf


@exact_device
def joins_ahead(places, normals, a, b, c, f, own, side, ox, oy, oz):
    """Return whether a facet joins the ray's own facet at its origin and rises on the ray's side of it."""
    # The origin must lie within SLACK of the facet's plane and edges.
    nx, ny, nz = normals[3 * f], normals[3 * f + 1], normals[3 * f + 2]
    ax, ay, az = places[a] - ox, places[a + 1] - oy, places[a + 2] - oz
    if abs(ax * nx + ay * ny + az * nz) > SLACK:
        return False
    bx, by, bz = places[b] - ox, places[b + 1] - oy, places[b + 2] - oz
    cx, cy, cz = places[c] - ox, places[c + 1] - oy, places[c + 2] - oz
    beside = lies_beside_edge(ax, ay, az, bx, by, bz, nx, ny, nz, SLACK)
    beside |= lies_beside_edge(bx, by, bz, cx, cy, cz, nx, ny, nz, SLACK)
    beside |= lies_beside_edge(cx, cy, cz, ax, ay, az, nx, ny, nz, SLACK)
    # Height of the facet's middle over the plane of the own facet.
    rise = (ax + bx + cx) * normals[3 * own] + (ay + by + cy) * normals[3 * own + 1]
    rise += (az + bz + cz) * normals[3 * own + 2]
    return (not beside) & (side * rise > 0.0)


@exact_device
def folds_back(places, normals, a, b, c, at, f):
    """Return whether a facet lies behind the plane of facet f: a convex fold where the two join.

    at: offset of the first vertex of f.
    """
    nx, ny, nz = normals[3 * f], normals[3 * f + 1], normals[3 * f + 2]
    px = places[a] + places[b] + places[c] - 3.0 * places[at]
    py = places[a + 1] + places[b + 1] + places[c + 1] - 3.0 * places[at + 1]
    pz = places[a + 2] + places[b + 2] + places[c + 2] - 3.0 * places[at + 2]
    return px * nx + py * ny + pz * nz < 0.0


@exact_device
def next_facet(
    mesh, nodes, places, faces, normals, stack, entries, ox, oy, oz, ux, uy, uz,
    own, side, acts, start, last, furthest,
):  # fmt: skip
    """Return the next facet that a ray crosses after (start, last), and its distance (BVH traversal).

    The facet is -1 if none is nearer than `furthest`. The nearer child is visited first, with a stack in
    `stack` and `entries`. own: facet that the ray began on (-1: none). side: +1 if it has just left the front
    of that facet, -1 its back, else 0. last: of facets crossed at `start`, those of higher numbers are still
    to come.
    """
    # Frame of the watertight test: the largest component of the direction becomes the z axis.
    along_x, along_y, along_z = abs(ux), abs(uy), abs(uz)
    kz = 0 if (along_x >= along_y) & (along_x >= along_z) else (1 if along_y >= along_z else 2)
    kx = 1 if kz == 0 else (2 if kz == 1 else 0)
    ky = 2 if kz == 0 else (0 if kz == 1 else 1)
    uk = ux if kz == 0 else (uy if kz == 1 else uz)
    if uk < 0.0:
        kx, ky = ky, kx  # preserves the winding
    u_x = ux if kx == 0 else (uy if kx == 1 else uz)
    u_y = ux if ky == 0 else (uy if ky == 1 else uz)
    o_x = ox if kx == 0 else (oy if kx == 1 else oz)
    o_y = ox if ky == 0 else (oy if ky == 1 else oz)
    o_z = ox if kz == 0 else (oy if kz == 1 else oz)
    sz = 1.0 / uk
    cx, cy, cz = ox - mesh.cx, oy - mesh.cy, oz - mesh.cz
    ix, iy, iz = reciprocal(ux), reciprocal(uy), reciprocal(uz)
    best, found, slope, top, here = furthest, -1, 0.0, 0, 0
    while here >= 0:
        n = nodes[here]
        # Enter the boxes of both children; push the farther one first.
        left = box_entry(
            n.low_x0, n.low_y0, n.low_z0, n.high_x0, n.high_y0, n.high_z0, cx, cy, cz, ix, iy, iz, start, best
        )
        right = box_entry(
            n.low_x1, n.low_y1, n.low_z1, n.high_x1, n.high_y1, n.high_z1, cx, cy, cz, ix, iy, iz, start, best
        )
        here = -1
        for turn in range(2):  # so that the nearer child is on top of the stack
            is_right = (left <= right) == (turn == 0)
            entry = right if is_right else left
            if entry < math.inf:
                stack[top] = (n.first1 << 3 | n.count1) if is_right else (n.first0 << 3 | n.count0)
                entries[top] = entry
                top += 1
        # Pop until an inner node is found; test the facets of leaves.
        while (here < 0) & (top > 0):
            top -= 1
            if entries[top] > best:
                continue
            first, count, begins_here = stack[top] >> 3, stack[top] & 7, entries[top] <= start
            if count == 0:
                here = first
            for f in range(first, first + count):
                a, b, c = 3 * faces[3 * f], 3 * faces[3 * f + 1], 3 * faces[3 * f + 2]
                az, bz = sz * (places[a + kz] - o_z), sz * (places[b + kz] - o_z)
                cz_ = sz * (places[c + kz] - o_z)
                t, area = facet_crossing(
                    (places[a + kx] - o_x) - u_x * az, (places[a + ky] - o_y) - u_y * az, az,
                    (places[b + kx] - o_x) - u_x * bz, (places[b + ky] - o_y) - u_y * bz, bz,
                    (places[c + kx] - o_x) - u_x * cz_, (places[c + ky] - o_y) - u_y * cz_, cz_,
                )  # fmt: skip
                if f == own:
                    continue
                cosine = ux * normals[3 * f] + uy * normals[3 * f + 1] + uz * normals[3 * f + 2]
                # At the origin, a joined facet that the ray leaves through is crossed at once.
                heads_out = cosine * side < 0.0
                joins = heads_out and begins_here
                if joins and joins_ahead(places, normals, a, b, c, f, own, side, ox, oy, oz):
                    best, found, slope = start, f, cosine
                    continue
                if area == 0.0:
                    continue
                height = (places[a] - ox) * normals[3 * f] + (places[a + 1] - oy) * normals[3 * f + 1]
                height += (places[a + 2] - oz) * normals[3 * f + 2]
                t = plane_distance(t, az, bz, cz_, height, cosine)
                is_next = (t > start) | ((t == start) & (f > last))
                if (side != 0.0) & (abs(height) <= SLACK):  # the ray begins on its plane
                    is_next, t = heads_out, (t if t > start else start)
                if is_next:
                    # The nearer crossing wins; at one place, the fold of the two facets decides.
                    comes_first = (t < best) | ((t == best) & (found >= 0) & (f < found))
                    if acts & (found >= 0):
                        same_place = abs(t - best) * min(abs(cosine), abs(slope)) <= SLACK
                        if same_place & (cosine * slope < 0.0):
                            is_convex = folds_back(places, normals, a, b, c, 3 * faces[3 * found], found)
                            comes_first = (cosine < 0.0) == is_convex
                    if comes_first:
                        best, found, slope = min(t, best), f, cosine
    return found, best


@lane_pass(layout.MESH, EXACT)
def meet_mesh(lane, table):
    """Intersect rays with an acting mesh; keep the facet if it is the nearest surface ahead."""
    stack, entries = view(stack_memory(), STACK, np.int64), view(stack_memory(), STACK, np.float64)
    nodes = view(lane.arena + table.nodes, table.node_count, layout.NODE)
    places = view(lane.arena + table.vertices, 3 * table.vertex_count, np.float64)
    faces = view(lane.arena + table.faces, 3 * table.facet_count, np.int32)
    normals = view(lane.arena + table.normals, 3 * table.facet_count, np.float64)
    sheet = table.sheet
    if lane.weight != 0.0:
        x, y, z, ux, uy, uz, start = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz, lane.start
        own, side = -1, 0.0
        if standing_sheet(lane.sheet) == sheet:
            own = lane.own_facet
            at = 3 * own
            if passed_sheet(lane.sheet) == 0:  # still at its origin
                side = math.copysign(1.0, ux * normals[at] + uy * normals[at + 1] + uz * normals[at + 2])
        found, t = next_facet(
            table, nodes, places, faces, normals, stack, entries, x, y, z, ux, uy, uz,
            own, side, True, start, NONE_AT_START, lane.distance,
        )  # fmt: skip
        if (found >= 0) & (t < lane.distance):
            lane.distance, lane.hit, lane.covered, lane.facet = t, table.hit, table.covers, found


@lane_pass(layout.MESH, EXACT)
def cover_mesh(lane, table):
    """Intersect rays with a transparent mesh detector; keep the facet if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
    stack, entries = view(stack_memory(), STACK, np.int64), view(stack_memory(), STACK, np.float64)
    nodes = view(lane.arena + table.nodes, table.node_count, layout.NODE)
    places = view(lane.arena + table.vertices, 3 * table.vertex_count, np.float64)
    faces = view(lane.arena + table.faces, 3 * table.facet_count, np.int32)
    normals = view(lane.arena + table.normals, 3 * table.facet_count, np.float64)
    sheet = table.sheet
    if lane.hit_sheet == sheet:  # the same mesh
        lane.covered |= table.covers
    elif lane.weight != 0.0:
        # Which facets at the current distance have been crossed already.
        passed = passed_sheet(lane.sheet)
        own = lane.own_facet if standing_sheet(lane.sheet) == sheet else -1
        last = NONE_AT_START
        if (passed != 0) & (passed <= sheet):
            last = lane.passed_facet if passed == sheet else -1
        start = lane.start
        found, t = next_facet(
            table, nodes, places, faces, normals, stack, entries, lane.x, lane.y, lane.z,
            lane.ux, lane.uy, lane.uz, own, 0.0, False, start, last, lane.distance,
        )  # fmt: skip
        if (found >= 0) & (t < lane.distance):
            lane.distance, lane.hit, lane.covered, lane.facet = t, table.hit, table.covers, found


@lane_pass(layout.ROWS)
def land_on_facet(lane, table):
    """On a mesh: set the facet's normal and move the point onto the facet.

    The facet of an acting mesh becomes the lane's `own_facet`, that of a transparent detector its
    `passed_facet`.
    """
    sheets = view(lane.arena + table.rows, table.count, layout.MESHED_SHEET)
    row = sheets[lane.sheet]
    if (row.facet_count != 0) & (lane.weight != 0.0):
        places = view(lane.arena + row.vertices, 3 * row.vertex_count, np.float64)
        faces = view(lane.arena + row.faces, 3 * row.facet_count, np.int32)
        normals, at = view(lane.arena + row.normals, 3 * row.facet_count, np.float64), 3 * lane.facet
        nx, ny, nz = normals[at], normals[at + 1], normals[at + 2]
        i, j, m = 3 * faces[at], 3 * faces[at + 1], 3 * faces[at + 2]
        lane.x, lane.y, lane.z = within_facet(
            lane.x, lane.y, lane.z, places[i], places[i + 1], places[i + 2], places[j], places[j + 1],
            places[j + 2], places[m], places[m + 1], places[m + 2], nx, ny, nz,
        )  # fmt: skip
        lane.nx, lane.ny, lane.nz = nx, ny, nz
        acts = lane.surface != 0
        if acts:
            lane.own_facet = lane.facet
        else:
            lane.passed_facet = lane.facet


@lane_pass(layout.FACET_AREAS)
def born_on_mesh(lane, table):
    """Sample a point uniformly on a mesh: a facet by its area, then a point uniform on it."""
    places = view(lane.arena + table.vertices, 3 * table.vertex_count, np.float64)
    faces = view(lane.arena + table.faces, 3 * table.facet_count, np.int32)
    normals = view(lane.arena + table.normals, 3 * table.facet_count, np.float64)
    shares = view(lane.arena + table.shares, table.facet_count, np.float64)
    side, count = table.side, table.facet_count
    seed_low, seed_high, batch = lane.seed_low, lane.seed_high, lane.batch
    w0, w1, w2, w3 = random_words(lane.history, batch, 0, POSITION, seed_low, seed_high)
    d0, d1, _, _ = random_words(lane.history, batch, 0, DEPTH, seed_low, seed_high)
    # Binary search in the cumulative areas.
    u, found, width = uniform(d0, d1), 0, count
    while width > 1:
        half = width >> 1
        found += half if u >= shares[found + half - 1] else 0
        width -= half
    s, t = math.sqrt(uniform(w0, w1)), uniform(w2, w3)
    p, q, r = 1.0 - s, s * (1.0 - t), s * t
    i, j, m = 3 * faces[3 * found], 3 * faces[3 * found + 1], 3 * faces[3 * found + 2]
    lane.x = p * places[i] + q * places[j] + r * places[m]
    lane.y = p * places[i + 1] + q * places[j + 1] + r * places[m + 1]
    lane.z = p * places[i + 2] + q * places[j + 2] + r * places[m + 2]
    lane.nx, lane.ny = side * normals[3 * found], side * normals[3 * found + 1]
    lane.nz = side * normals[3 * found + 2]
    lane.own_facet, lane.facet = found, found
