"""Meshes that are hard to hold shut: narrow, sharp, thin, with crowded vertices; and beams into their edges and vertices."""

import numpy as np

import transport as tp


def turned(mesh, seed=1, shift=0.3):
    """The mesh turned and shifted at random, so that no coordinate is round."""
    random = np.random.default_rng(seed)
    turn = random_turn(random)
    return tp.Mesh(vertices=mesh.vertices @ turn.T + shift * random.normal(size=3), faces=mesh.faces)


def random_turn(random):
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn))


def bipyramid(sides, height):
    """Two vertices that each join as many triangles as there are sides."""
    i, j = np.arange(sides), np.roll(np.arange(sides), -1)
    top, bottom = np.full(sides, sides), np.full(sides, sides + 1)
    ring = _ring(2 * np.pi * i / sides, 1.0, 0.0)
    faces = np.concatenate([np.stack([i, j, top], axis=1), np.stack([j, i, bottom], axis=1)])
    return tp.Mesh(vertices=np.concatenate([ring, [(0, 0, height), (0, 0, -height)]]), faces=faces)


def prism(angles, radii=1.0, height=1.0):
    """An upright prism over corners at these azimuths and radii, its floor and ceiling fans about their middles."""
    n = len(angles)
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    bottom, top = np.full(n, 2 * n), np.full(n, 2 * n + 1)
    sides = ((i, j, i + n), (j, j + n, i + n), (j, i, bottom), (i + n, j + n, top))
    floor = _ring(angles, radii, -height / 2)
    middles = [(0, 0, -height / 2), (0, 0, height / 2)]
    vertices = np.concatenate([floor, floor + (0, 0, height), middles])
    return tp.Mesh(vertices=vertices, faces=np.concatenate([np.stack(face, axis=1) for face in sides]))


def needles(aspect):
    """A prism of a hundred sides, half of which are crowded and as narrow as that."""
    return prism(np.concatenate([0.3 + np.arange(50) / aspect, np.linspace(0.5, 6.3, 50)]))


def star(points, inner):
    """A prism over a star: every other corner lies at the inner radius."""
    corners = np.arange(2 * points)
    return prism(np.pi * corners / points, np.where(corners % 2, inner, 1.0), 0.6)


def wedge(angle):
    """A prism over a triangle with a sharp corner, without middles."""
    corners = np.array([(0, 0), (1, 0), (np.cos(angle), np.sin(angle))])
    vertices = np.concatenate([np.insert(corners, 2, z, axis=1) for z in (0.0, 1.0)])
    faces = [(0, 2, 1), (3, 4, 5), (0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4), (2, 0, 3), (2, 3, 5)]
    return tp.Mesh(vertices=vertices, faces=faces)


def lattice(n):
    """A cube [0, n]^3 each face of which is n x n squares, cut along alternating diagonals: whole coordinates."""
    i, j = (index.ravel() for index in np.meshgrid(range(n), range(n), indexing="ij"))
    squares = np.stack(
        [np.stack([i + a, j + b], axis=1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1
    )
    odd = (i + j) % 2 == 1
    squares[odd] = np.roll(squares[odd], 1, axis=1)
    flat = np.concatenate([squares[:, (0, 1, 2)], squares[:, (0, 2, 3)]])
    sides = []
    for axis in range(3):
        for place in (0, n):
            side = np.full((*flat.shape[:2], 3), float(place))
            side[..., (axis + 1) % 3], side[..., (axis + 2) % 3] = flat[..., 0], flat[..., 1]
            sides.append(side if place else side[:, ::-1])
    corners = np.concatenate(sides).reshape(-1, 3)
    return tp.Mesh(vertices=corners, faces=np.arange(len(corners)).reshape(-1, 3)).merged()


def joined(*meshes):
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return tp.Mesh(vertices=np.concatenate([m.vertices for m in meshes]), faces=np.concatenate(faces))


def cracked(mesh):
    """The fault: every triangle with vertices of its own, an ulp or two beside those of its neighbours."""
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    noise = np.random.default_rng(1).integers(-2, 3, corners.shape) * 2.0**-52 * np.abs(corners).max()
    return tp.Mesh(vertices=corners + noise, faces=np.arange(len(corners)).reshape(-1, 3))


def targets(mesh, random, number):
    """Points of edges, a third of them vertices."""
    a, b, c = mesh.faces.T
    edges = np.concatenate([np.stack(ends, axis=1) for ends in ((a, b), (b, c), (c, a))])
    ends = mesh.vertices[edges[random.integers(len(edges), size=number)]]
    share = random.uniform(size=(number, 1))
    share[::3] = 0
    return (1 - share) * ends[:, 0] + share * ends[:, 1]


def beams_from_inside(mesh, number=60, seed=2):
    """Beams of 1 W from a point near the middle of a body that is seen whole from there."""
    random = np.random.default_rng(seed)
    middle = mesh.vertices.mean(axis=0)
    start = middle + 0.002 * (random.dirichlet(np.ones(len(mesh.vertices))) @ mesh.vertices - middle)
    return [beam(start, place) for place in targets(mesh, random, number)]


def beams_from_outside(mesh, number=60, seed=3):
    """Beams of 1 W from all round, most of them to edges that they see from aside or not at all."""
    random = np.random.default_rng(seed)
    ways = random.normal(size=(number, 3))
    starts = mesh.middle + 1.8 * mesh.extent * ways / np.linalg.norm(ways, axis=1)[:, None]
    return [beam(start, place) for start, place in zip(starts, targets(mesh, random, number), strict=True)]


def beam(start, target):
    return tp.Source(tp.Point(position=start), tp.Beam(np.subtract(target, start), power=1.0))


def _ring(angles, radii, height):
    return np.stack([radii * np.cos(angles), radii * np.sin(angles), 0 * angles + height], axis=1)
