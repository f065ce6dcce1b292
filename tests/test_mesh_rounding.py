"""Slivers, thin plates and lengths of any scale: a mesh keeps the digits that its arrays have."""

import math

import mpmath
import numpy as np
import pytest

from tests.mesh_scenes import BALL, CUBE, mesh
from transport.geometry.flat import Triangle
from transport.geometry.mesh import Mesh
from transport.validation import SceneError


def exact_facet(vertices):
    """Unit normal and area of one triangle in 60 digits."""
    with mpmath.workdps(60):
        a, b, c = (mpmath.matrix([mpmath.mpf(float(x)) for x in vertex]) for vertex in vertices)
        u, v = b - a, c - a
        twice = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        length = mpmath.sqrt(sum(x * x for x in twice))
        return [float(x / length) for x in twice], float(length / 2)


def slivers(offset):
    """Triangles with an edge of length 1 and heights down to the rounding of the coordinates."""
    random = np.random.default_rng(1)
    corners, ways = random.uniform(-1, 1, (200, 3)) + offset, random.normal(size=(200, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    aside = np.cross(ways, random.normal(size=(200, 3)))
    size = 1 + math.hypot(*np.broadcast_to(offset, 3))
    heights = size * 10 ** random.uniform(-14.5, -1, (200, 1))
    tops = corners + random.uniform(0, 1, (200, 1)) * ways + heights * aside
    return np.stack([corners, corners + ways, tops], axis=1).reshape(-1, 3), np.arange(600).reshape(-1, 3)


@pytest.mark.parametrize("offset", [0, (1e3, -7, 1e-9)])
@pytest.mark.parametrize("scale", [1.0, 2.0**-300, 2.0**300])
def test_slivers_keep_all_their_digits(offset, scale):
    vertices, faces = slivers(offset)
    shape = mesh(vertices * scale, faces)
    exact = [exact_facet(vertices[face]) for face in faces]
    assert shape.areas / scale**2 == pytest.approx(np.array([area for _, area in exact]), rel=1e-15, abs=0)
    assert np.abs(shape.normals - [normal for normal, _ in exact]).max() < 5e-16
    assert shape.area == pytest.approx(math.fsum(shape.areas), rel=1e-16)


def test_a_vector_product_in_floating_point_loses_the_digits_that_slivers_keep():
    """Planted: the usual formula."""
    vertices, faces = slivers(0)
    a, b, c = vertices[faces].transpose(1, 0, 2)
    exact = np.array([exact_facet(vertices[face])[1] for face in faces])
    plain = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    assert np.abs(plain / exact - 1).max() > 1e-3


def test_a_mesh_has_the_normals_and_areas_of_its_triangles():
    for face, normal, area in zip(BALL.faces, BALL.normals, BALL.areas, strict=True):
        single = Triangle(vertices=BALL.vertices[face].tolist())
        assert normal == pytest.approx(np.array(single.normal), abs=4e-16)
        assert area == pytest.approx(single.area, rel=1e-15)


def test_what_is_on_a_line_for_a_triangle_is_for_a_mesh():
    """Heights about the rounding of the coordinates: both take the same side."""
    random, refused = np.random.default_rng(2), 0
    for height in 2.0 ** np.arange(-56, -46, 0.25):
        a, way = random.uniform(-1, 1, 3), random.normal(size=3)
        vertices = [a.tolist(), (a + way).tolist(), (a + 0.4 * way + height * np.array([1, -1, 0])).tolist()]
        outcomes = []
        for make in (lambda v: Triangle(vertices=v), lambda v: Mesh(vertices=v, faces=[(0, 1, 2)])):
            try:
                make(vertices)
                outcomes.append(True)
            except SceneError:
                outcomes.append(False)
        assert outcomes[0] == outcomes[1]
        refused += not outcomes[0]
    assert 5 < refused < 35


@pytest.mark.parametrize("thickness", [1e-3, 1e-9, 1e-12, 1e-14])
def test_a_thin_plate_is_closed(thickness):
    plate = mesh(Mesh.box(size=(1, 2, thickness)).vertices, CUBE.faces)
    assert plate.is_closed and plate.volume == pytest.approx(2 * thickness, rel=1e-14, abs=0)
    turned = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turned *= np.linalg.det(turned)
    if thickness >= 1e-12:
        plate = mesh(plate.vertices @ turned, CUBE.faces)
        assert plate.is_closed and plate.volume == pytest.approx(2 * thickness, rel=0, abs=1e-15)


@pytest.mark.parametrize("factor", [1e-100, 1e-9, 1e9, 1e100])
def test_all_lengths_scale(factor):
    shape = BALL.scaled(factor)
    assert shape.is_closed
    assert shape.area == pytest.approx(BALL.area * factor**2, rel=1e-13, abs=0)
    assert shape.volume == pytest.approx(BALL.volume * factor**3, rel=1e-12, abs=0)
    assert shape.normals == pytest.approx(BALL.normals, abs=1e-13)
