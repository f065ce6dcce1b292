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
from numba import int64, uint64

from transport.compile import layout
from transport.compile.layout import ROUNDING
from transport.engine.bodies import lane_pass, own_memory
from transport.engine.bundle import view
from transport.engine.words import passed_sheet, standing_sheet
from transport.physics.bits import bits_of
from transport.physics.device import EXACT, exact_device
from transport.physics.facets import (
    crossing_weights,
    lies_beside_edge,
    passes_near,
    plane_distance,
    within_facet,
)
from transport.physics.streams import DEPTH, POSITION, random_words, uniform

NONE_AT_START = 1 << 62
STACK = 512  # nodes and leaves that wait during a search
stack_memory, child_memory, ray_memory = own_memory(STACK), own_memory(layout.CHILDREN), own_memory(6)
# a node as numbers of its boxes, of which these are the first per side, and as words
NODE_NUMBERS, NODE_WORDS = layout.NODE.itemsize // 4, layout.NODE.itemsize // 8
_, Y_LOW, Z_LOW, X_HIGH, Y_HIGH, Z_HIGH = (layout.CHILDREN * side for side in range(6))
MAX_RECIPROCAL = 1e300  # reciprocal of a direction component that is 0: times 0 it gives 0
# [scene lengths] radius about a point of a mesh within which facets count as joined there
SLACK = 16.0 * ROUNDING
BOX_ROUNDING = 2.0**-48  # relative rounding of the crossings of a box


@exact_device
def reciprocal(u):
    """Return 1/u, finite for u = 0."""
    return 1.0 / u if abs(u) > 1.0 / MAX_RECIPROCAL else math.copysign(MAX_RECIPROCAL, u)


@exact_device
def joins_ahead(places, faces, normals, f, own, side, ox, oy, oz):
    """Return whether a facet joins the ray's own facet at its origin and rises on the ray's side of it."""
    # The origin must lie within SLACK of the facet's edges, and of its box: a sharp corner ends there.
    a, b, c = 3 * faces[3 * f], 3 * faces[3 * f + 1], 3 * faces[3 * f + 2]
    nx, ny, nz = normals[3 * f], normals[3 * f + 1], normals[3 * f + 2]
    ax, ay, az = places[a] - ox, places[a + 1] - oy, places[a + 2] - oz
    bx, by, bz = places[b] - ox, places[b + 1] - oy, places[b + 2] - oz
    cx, cy, cz = places[c] - ox, places[c + 1] - oy, places[c + 2] - oz
    beside = lies_beside_edge(ax, ay, az, bx, by, bz, nx, ny, nz, SLACK)
    beside |= lies_beside_edge(bx, by, bz, cx, cy, cz, nx, ny, nz, SLACK)
    beside |= lies_beside_edge(cx, cy, cz, ax, ay, az, nx, ny, nz, SLACK)
    beside |= (min(ax, min(bx, cx)) > SLACK) | (max(ax, max(bx, cx)) < -SLACK)
    beside |= (min(ay, min(by, cy)) > SLACK) | (max(ay, max(by, cy)) < -SLACK)
    beside |= (min(az, min(bz, cz)) > SLACK) | (max(az, max(bz, cz)) < -SLACK)
    # Height of the facet's middle over the plane of the own facet.
    rise = (ax + bx + cx) * normals[3 * own] + (ay + by + cy) * normals[3 * own + 1]
    rise += (az + bz + cz) * normals[3 * own + 2]
    return (not beside) & (side * rise > 0.0)


@exact_device
def lies_behind(places, faces, normals, f, g):
    """Return whether facet f lies behind the plane of facet g.

    Where they share an edge, their fold is convex if so, and either lies behind the other. Where they share
    only a vertex, it is enough that one does.
    """
    a, b, c = 3 * faces[3 * f], 3 * faces[3 * f + 1], 3 * faces[3 * f + 2]
    at = 3 * faces[3 * g]
    nx, ny, nz = normals[3 * g], normals[3 * g + 1], normals[3 * g + 2]
    px = places[a] + places[b] + places[c] - 3.0 * places[at]
    py = places[a + 1] + places[b + 1] + places[c + 1] - 3.0 * places[at + 1]
    pz = places[a + 2] + places[b + 2] + places[c + 2] - 3.0 * places[at + 2]
    return px * nx + py * ny + pz * nz < 0.0


@exact_device
def are_at_one_place(t, other, slope, other_slope):
    """Return whether a ray crosses two facets, at these distances and cosines, at one place."""
    return abs(t - other) * min(abs(slope), abs(other_slope)) <= SLACK


@exact_device
def lowest_bit(word):
    """Return the number of the lowest bit that is set in a word."""
    return (bits_of(float(word & -word)) >> 52) - 1023


@exact_device
def push_children(boxes, children, node, stack, entries, top, x, y, z, ix, iy, iz, start, best):
    """Push the children of a node whose boxes a ray meets, the nearest one last; return the stack's new top.

    x, y, z: origin of the ray from the mesh's middle. ix, iy, iz: reciprocal direction. A box that the ray
    left before `start` or enters beyond `best` is a miss.
    """
    entered, at, hits = view(child_memory(), layout.CHILDREN, np.float64), NODE_NUMBERS * node, 0
    # The sides by which the ray enters, and those by which it leaves.
    x_in, y_in, z_in = 0 if ix > 0.0 else X_HIGH, Y_LOW if iy > 0.0 else Y_HIGH, Z_LOW if iz > 0.0 else Z_HIGH
    x_out, y_out, z_out = X_HIGH - x_in, Y_LOW + Y_HIGH - y_in, Z_LOW + Z_HIGH - z_in
    x_in, y_in, z_in = uint64(at + x_in), uint64(at + y_in), uint64(at + z_in)
    x_out, y_out, z_out = uint64(at + x_out), uint64(at + y_out), uint64(at + z_out)
    for j in range(uint64(layout.CHILDREN)):
        near, far = (boxes[x_in + j] - x) * ix, (boxes[x_out + j] - x) * ix
        p, q = (boxes[y_in + j] - y) * iy, (boxes[y_out + j] - y) * iy
        near, far = p if p > near else near, q if q < far else far
        p, q = (boxes[z_in + j] - z) * iz, (boxes[z_out + j] - z) * iz
        near, far = p if p > near else near, q if q < far else far
        far += BOX_ROUNDING * abs(far)
        entered[j] = near
        hits |= (1 << j) if (near <= far) & (far >= start) & (near <= best) else 0
    bottom = top
    while hits != 0:
        j = lowest_bit(hits)
        hits &= hits - 1
        place = top
        while place > bottom and entries[place - 1] < entered[j]:
            stack[place], entries[place] = stack[place - 1], entries[place - 1]
            place -= 1
        stack[place], entries[place] = children[NODE_WORDS * node + 3 * layout.CHILDREN + j], entered[j]
        top += 1
    return top


@exact_device
def next_facet(
    arena, mesh, places, faces, normals, ox, oy, oz, ux, uy, uz, own, side, acts, start, last, furthest
):  # fmt: skip
    """Return the next facet that a ray crosses after (start, last), and its distance (BVH traversal).

    The facet is -1 if none is nearer than `furthest`. own: facet that the ray began on (-1: none). side: +1
    if it has just left the front of that facet, -1 its back, else 0. last: of facets crossed at `start`,
    those of higher numbers are still to come. The order in which facets are tested does not matter.
    """
    boxes = view(arena + mesh.nodes, NODE_NUMBERS * mesh.node_count, np.float32)
    children = view(arena + mesh.nodes, NODE_WORDS * mesh.node_count, np.int64)
    leaves = view(arena + mesh.leaves, layout.FACET_TERMS * mesh.facet_count + layout.VECTOR, np.float64)
    stack, entries = view(stack_memory(), STACK, np.int64), view(stack_memory(), STACK, np.float64)
    # Frame of the watertight test: the largest component of the direction becomes the z axis. Components are
    # fetched from memory: which one is unforeseeable, and a branch would be mispredicted.
    ray = view(ray_memory(), 6, np.float64)
    ray[0], ray[1], ray[2], ray[3], ray[4], ray[5] = ux, uy, uz, ox, oy, oz
    along_x, along_y, along_z = abs(ux), abs(uy), abs(uz)
    is_z, is_y = int64((along_z > along_x) & (along_z > along_y)), int64(along_y > along_x)
    kz = 2 * is_z + (is_y & ~is_z)
    kx, ky = (kz + 1) % 3, (kz + 2) % 3
    uk = ray[uint64(kz)]
    kx, ky = ky if uk < 0.0 else kx, kx if uk < 0.0 else ky  # preserves the winding
    u_x, u_y = ray[uint64(kx)], ray[uint64(ky)]
    o_x, o_y, o_z = ray[uint64(kx + 3)], ray[uint64(ky + 3)], ray[uint64(kz + 3)]
    per_z = 1.0 / uk
    shear_x, shear_y = u_x * per_z, u_y * per_z
    foot_x, foot_y = o_x - shear_x * o_z, o_y - shear_y * o_z
    ix, iy, iz = reciprocal(ux), reciprocal(uy), reciprocal(uz)
    # The nearest facet against whose normal the ray moves, the nearest along whose normal it moves, and how
    # many of either kind it crosses at that place.
    t_in, facet_in, cosine_in, count_in = furthest, -1, 0.0, 0
    t_out, facet_out, cosine_out, count_out = furthest, -1, 0.0, 0
    best = furthest
    stack[0] = mesh.facet_count if mesh.facet_count <= layout.MAX_LEAF_FACETS else 0
    entries[0], top = -math.inf, 1
    while top > 0:
        top -= 1
        if entries[top] > best:
            continue
        first, count = stack[top] >> layout.LEAF_BITS, stack[top] & ((1 << layout.LEAF_BITS) - 1)
        if count == 0:
            top = push_children(
                boxes, children, first, stack, entries, top,
                ox - mesh.cx, oy - mesh.cy, oz - mesh.cz, ix, iy, iz, start, best,
            )  # fmt: skip
            continue
        # List the facets of the leaf that the ray may cross, without a branch. Offsets of their terms: a to c
        # are the vertices in the ray's frame, p the first one as it is, n the normal.
        at, hits = layout.FACET_TERMS * first, 0
        ax, ay, az = uint64(at + kx * count), uint64(at + ky * count), uint64(at + kz * count)
        bx, by, bz = ax + uint64(3 * count), ay + uint64(3 * count), az + uint64(3 * count)
        cx, cy, cz = ax + uint64(6 * count), ay + uint64(6 * count), az + uint64(6 * count)
        px, py, pz = uint64(at), uint64(at + count), uint64(at + 2 * count)
        nx, ny, nz = uint64(at + 9 * count), uint64(at + 10 * count), uint64(at + 11 * count)
        for j in range(uint64((count + layout.VECTOR - 1) & -layout.VECTOR)):
            may_cross = passes_near(
                leaves[ax + j], leaves[ay + j], leaves[az + j],
                leaves[bx + j], leaves[by + j], leaves[bz + j],
                leaves[cx + j], leaves[cy + j], leaves[cz + j], shear_x, shear_y, foot_x, foot_y, mesh.margin,
            )  # fmt: skip
            hits |= (1 << j) if may_cross else 0
        hits &= (1 << count) - 1
        if (own >= first) & (own < first + count):
            hits &= ~(1 << (own - first))
        # Test these exactly.
        while hits != 0:
            j = uint64(lowest_bit(hits))
            hits &= hits - 1
            f = first + int64(j)
            n_x, n_y, n_z = leaves[nx + j], leaves[ny + j], leaves[nz + j]
            cosine = ux * n_x + uy * n_y + uz * n_z
            height = (leaves[px + j] - ox) * n_x + (leaves[py + j] - oy) * n_y
            height += (leaves[pz + j] - oz) * n_z
            heads_out, begins_on_plane = cosine * side < 0.0, (side != 0.0) & (abs(height) <= SLACK)
            # At the origin, a joined facet that the ray leaves through is crossed at once.
            t, is_next = start, heads_out & begins_on_plane & (start == 0.0)
            if is_next:
                is_next = joins_ahead(places, faces, normals, f, own, side, ox, oy, oz)
            if not is_next:
                a_z, b_z = per_z * (leaves[az + j] - o_z), per_z * (leaves[bz + j] - o_z)
                c_z = per_z * (leaves[cz + j] - o_z)
                u, v, w = crossing_weights(
                    (leaves[ax + j] - o_x) - u_x * a_z, (leaves[ay + j] - o_y) - u_y * a_z,
                    (leaves[bx + j] - o_x) - u_x * b_z, (leaves[by + j] - o_y) - u_y * b_z,
                    (leaves[cx + j] - o_x) - u_x * c_z, (leaves[cy + j] - o_y) - u_y * c_z,
                )  # fmt: skip
                if u != 0.0:
                    t = plane_distance(u, v, w, a_z, b_z, c_z, height, cosine)
                    is_next = (t > start) | ((t == start) & (f > last))
                    if begins_on_plane:  # unless it lies behind the origin
                        is_next, t = (
                            heads_out & (max(a_z, max(b_z, c_z)) >= start - 2.0 * SLACK),
                            max(t, start),
                        )
            if is_next & (cosine < 0.0):
                is_joint = are_at_one_place(t, t_in, cosine, cosine_in)
                count_in = count_in + 1 if is_joint else 1 if t < t_in else count_in
                if (t < t_in) | ((t == t_in) & (f < facet_in)):
                    t_in, facet_in, cosine_in = t, f, cosine
            elif is_next:
                is_joint = are_at_one_place(t, t_out, cosine, cosine_out)
                count_out = count_out + 1 if is_joint else 1 if t < t_out else count_out
                if (t < t_out) | ((t == t_out) & (f < facet_out)):
                    t_out, facet_out, cosine_out = t, f, cosine
            best = min(t_in, t_out)
    # The nearer crossing comes first. At one place ways in and out alternate: the more frequent one comes
    # first, and if there are as many of both, the fold of the two facets decides.
    is_in = (t_in < t_out) | ((t_in == t_out) & (facet_in < facet_out))
    is_joint = acts & (facet_in >= 0) & (facet_out >= 0) & (best > start)
    if is_joint & are_at_one_place(t_in, t_out, cosine_in, cosine_out):
        is_convex = lies_behind(places, faces, normals, facet_in, facet_out)
        is_convex |= lies_behind(places, faces, normals, facet_out, facet_in)
        is_in = count_in > count_out if count_in != count_out else is_convex
    return (facet_in if is_in else facet_out), (t_in if is_in else t_out)


@lane_pass(layout.MESH, EXACT)
def meet_mesh(lane, table):
    """Intersect rays with an acting mesh; keep the facet if it is the nearest surface ahead."""
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
            lane.arena, table, places, faces, normals, x, y, z, ux, uy, uz,
            own, side, True, start, NONE_AT_START, lane.distance,
        )  # fmt: skip
        if (found >= 0) & (t < lane.distance):
            lane.distance, lane.hit, lane.covered, lane.facet = t, table.hit, table.covers, found


@lane_pass(layout.MESH, EXACT)
def cover_mesh(lane, table):
    """Intersect rays with a transparent mesh detector; keep the facet if its sheet is the nearest ahead.

    On the sheet of the nearest hit, adds its bit to the hit.
    """
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
            lane.arena, table, places, faces, normals, lane.x, lane.y, lane.z,
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
