"""Meshes to ask, and one of which nothing is warned."""

import warnings

from transport.geometry.mesh import Mesh

CUBE = Mesh.box(size=2.0)
BALL = Mesh.sphere(radius=2.0, center=(1, -2, 3), triangles=500)
TENT = Mesh(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], faces=[(0, 1, 3), (1, 2, 3), (2, 0, 3)])
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def mesh(vertices, faces):
    """A mesh of which nothing is warned."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return Mesh(vertices=vertices, faces=faces)
