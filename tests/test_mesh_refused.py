"""What a mesh refuses, with what is wrong and the cure."""

import math

import numpy as np
import pytest

from tests.mesh_scenes import CUBE, ONE, SQUARE, TENT
from transport.geometry.mesh import Mesh
from transport.validation import SceneError

REFUSALS = {
    "positional": (lambda: Mesh(SQUARE, ONE), ["Mesh takes keywords only", "vertices=..., faces=..."]),
    "no faces given": (lambda: Mesh(vertices=SQUARE), ["Mesh: faces missing"]),
    "vertices flat": (
        lambda: Mesh(vertices=[0, 1, 2], faces=ONE),
        ["vertices must be an array (n, 3)", "[0, 1, 2]"],
    ),
    "vertices in a plane": (lambda: Mesh(vertices=np.zeros((4, 2)), faces=ONE), ["vertices", "shape (4, 2)"]),
    "vertices text": (lambda: Mesh(vertices="cube.stl", faces=ONE), ["vertices", "'cube.stl'"]),
    "vertices complex": (
        lambda: Mesh(vertices=np.zeros((4, 3), complex), faces=ONE),
        ["vertices", "complex128"],
    ),
    "vertices bool": (lambda: Mesh(vertices=np.ones((4, 3), bool), faces=ONE), ["vertices", "bool"]),
    "NaN": (
        lambda: Mesh(vertices=[*SQUARE, (0, math.nan, 0)], faces=ONE),
        ["Mesh: vertices must be finite", "1 of 5, first vertex 4: [0.0, nan, 0.0]", "correct"],
    ),
    "infinity": (
        lambda: Mesh(vertices=[*SQUARE[:3], (0, 0, math.inf)], faces=ONE),
        ["1 of 4, first vertex 3", "inf"],
    ),
    "too far apart": (
        lambda: Mesh(vertices=np.array(SQUARE) * 1e308, faces=ONE),
        ["farther apart", "change the unit"],
    ),
    "too small": (lambda: Mesh(vertices=np.array(SQUARE) * 1e-165, faces=ONE), ["areas", "change the unit"]),
    "no triangle": (
        lambda: Mesh(vertices=SQUARE, faces=[]),
        ["faces must hold at least one triangle", "got none of 4"],
    ),
    "no triangle, array": (
        lambda: Mesh(vertices=SQUARE, faces=np.zeros((0, 3), int)),
        ["at least one triangle"],
    ),
    "quads": (
        lambda: Mesh(vertices=SQUARE, faces=[(0, 1, 2, 3)]),
        ["array (m, 3)", "(0, 1, 2, 3)", "triangulate"],
    ),
    "mixed": (
        lambda: Mesh(vertices=SQUARE, faces=[(0, 1, 2), (0, 1, 2, 3)]),
        ["array (m, 3)", "triangulate"],
    ),
    "fractions": (
        lambda: Mesh(vertices=SQUARE, faces=[(0, 1, 2), (0, 1.5, 2)]),
        ["faces must be whole numbers", "1 triangles, first triangle 1: [0.0, 1.5, 2.0]", "cast"],
    ),
    "not a number": (
        lambda: Mesh(vertices=SQUARE, faces=[(0, math.nan, 2)]),
        ["faces must be whole numbers", "nan"],
    ),
    "bool": (lambda: Mesh(vertices=SQUARE, faces=np.ones((1, 3), bool)), ["faces must be an array", "bool"]),
    "negative": (lambda: Mesh(vertices=SQUARE, faces=[(0, 1, -1)]), ["0 to 3 with 4 vertices", "[0, 1, -1]"]),
    "out of range": (
        lambda: Mesh(vertices=SQUARE, faces=[(0, 1, 2), (0, 1, 7), (8, 1, 2)]),
        ["0 to 3 with 4 vertices", "2 of 3 triangles", "triangle 1: [0, 1, 7], triangle 2: [8, 1, 2]"],
    ),
    "from 1": (
        lambda: Mesh(vertices=SQUARE, faces=[(1, 2, 3), (1, 3, 4)]),
        ["triangle 1: [1, 3, 4]", "subtract 1"],
    ),
    "huge": (
        lambda: Mesh(vertices=SQUARE, faces=np.array([(0, 1, 2**63)], np.uint64)),
        ["0 to 3 with 4 vertices"],
    ),
    "a vertex twice": (
        lambda: Mesh(vertices=SQUARE, faces=[(0, 1, 2), (3, 1, 3)]),
        ["three different vertices", "1 of 2, first triangle 1: [3, 1, 3]", "leave"],
    ),
    "a triangle twice": (
        lambda: Mesh(vertices=SQUARE, faces=[(0, 1, 2), (0, 2, 3), (2, 0, 1)]),
        [
            "same three vertices twice",
            "1 that repeat",
            "triangles 0 and 2: [2, 0, 1]",
            "leave the copies out",
        ],
    ),
    "a triangle and its back": (
        lambda: Mesh(vertices=SQUARE, faces=[(0, 1, 2), (2, 1, 0)]),
        ["triangles 0 and 1"],
    ),
    "no area": (
        lambda: Mesh(vertices=[*SQUARE, (0.5, 0.5, 0)], faces=[(0, 1, 2), (0, 2, 4)]),
        ["triangles must have an area", "1 of 2, first triangle 1: [[0.0, 0.0, 0.0]", "move or merge"],
    ),
    "no area up to rounding": (
        lambda: Mesh(vertices=[(0.1, 0.2, 0.3), (0.2, 0.4, 0.6), (0.7, 1.4, 2.1)], faces=ONE),
        ["triangles must have an area"],
    ),
    "thinner than rounding": (lambda: Mesh.box(size=(1, 1, 1e-30)), ["must have an area", "8 of 12"]),
    "two vertices in one place": (
        lambda: Mesh(vertices=[*SQUARE, (1, 0, 0)], faces=[(0, 1, 4)]),
        ["have an area"],
    ),
    "moved by a number": (lambda: CUBE.moved(1), ["by must be three finite lengths", "got 1"]),
    "moved beyond rounding": (lambda: CUBE.moved((1e17, 0, 0)), ["triangles must have an area"]),
    "scaled by nothing": (lambda: CUBE.scaled(0), ["by must be a number, positive and finite, got 0"]),
    "mirrored": (lambda: CUBE.scaled(-1), ["by must be a number, positive", "-1"]),
    "tolerance": (lambda: CUBE.merged(-1e-3), ["tolerance must be a length in metres", "-0.001"]),
    "sphere of none": (
        lambda: Mesh.sphere(radius=1, triangles=0),
        ["Mesh.sphere: triangles must be a whole number from 1 to 20000000, got 0"],
    ),
    "sphere of a fraction": (lambda: Mesh.sphere(radius=1, triangles=1000.5), ["triangles", "1000.5"]),
    "sphere without radius": (lambda: Mesh.sphere(radius=-1), ["radius must be positive", "-1"]),
    "box without size": (lambda: Mesh.box(size=(1, 0, 1)), ["size", "(1, 0, 1)"]),
    "point": (lambda: CUBE.holds((1, 2)), ["point must be three finite numbers", "(1, 2)"]),
}


@pytest.mark.parametrize("make, parts", REFUSALS.values(), ids=REFUSALS)
def test_refused_with_what_is_wrong_and_the_cure(make, parts):
    with pytest.raises(SceneError) as refused:
        make()
    for part in parts:
        assert part in str(refused.value), str(refused.value)
    assert len(str(refused.value)) < 400


def test_masked_vertices_are_refused():
    """What lies under a mask is a fill value, often 1e36: never a coordinate."""
    masked = np.ma.masked_greater(TENT.vertices, 0.5)
    with pytest.raises(
        SceneError, match=r"vertices must have all their values, got 3 masked; write \.filled\(0\)"
    ):
        Mesh(vertices=masked, faces=TENT.faces)
