"""A mesh: area, normals, volume and edges from its arrays; what moves, turns and scales it."""

import copy
import math
import pickle
import subprocess
import sys
import warnings

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from tests.mesh_scenes import CUBE, TENT, mesh
from transport.geometry.mesh import Mesh, MeshWarning
from transport.geometry.solid import Box, Sphere
from transport.validation import SceneError


def test_a_box_of_triangles_is_the_box():
    shape = Mesh.box(center=(1, 2, 3), size=(1, 2, 4))
    box = Box(center=(1, 2, 3), size=(1, 2, 4))
    assert (shape.triangles, shape.area, shape.volume) == (12, box.area, pytest.approx(box.volume, rel=1e-15))
    assert (shape.bounds, shape.middle) == (box.bounds, box.middle)
    assert shape.extent == pytest.approx(box.extent, rel=1e-15)
    assert shape.is_closed and shape.open_edges == 0
    centroids = shape.vertices[shape.faces].mean(axis=1)
    assert ((centroids - shape.middle) * shape.normals > 0).any(axis=1).all()  # outwards
    assert {tuple(normal) for normal in shape.normals} == {face.normal for face in box.faces().values()}


@pytest.mark.parametrize(("wanted", "got"), [(1, 20), (20, 20), (21, 80), (80, 80), (81, 180), (5120, 5120)])
def test_a_sphere_has_at_least_so_many_triangles_with_all_vertices_on_it(wanted, got):
    ball = Sphere(center=(1, -2, 3), radius=0.7)
    shape = Mesh.sphere(center=ball.center, radius=ball.radius, triangles=wanted)
    assert shape.triangles == got and shape.is_closed
    assert len(shape.vertices) == got / 2 + 2  # Euler: n - 3m/2 + m = 2
    distances = np.linalg.norm(shape.vertices - ball.center, axis=1)
    assert distances == pytest.approx(ball.radius, rel=2e-15)
    assert shape.extent == pytest.approx(ball.radius, rel=1e-2 if got > 20 else 0.2)
    assert 0.5 < shape.area / ball.area < 1 and 0.5 < shape.volume / ball.volume < 1
    assert shape.areas.max() / shape.areas.min() < 2


def test_a_mesh_of_a_sphere_nears_the_sphere_with_the_square_of_its_edges():
    wants = [1 - Mesh.sphere(radius=1, triangles=20 * f * f).volume / (4 * math.pi / 3) for f in (10, 20, 40)]
    assert wants[0] / wants[1] == pytest.approx(4, rel=0.02) and wants[1] / wants[2] == pytest.approx(
        4, rel=0.02
    )


def test_an_open_mesh_has_an_area_and_no_volume():
    assert TENT.open_edges == 3 and not TENT.is_closed
    assert TENT.area == pytest.approx(1 + math.sqrt(3) / 2, rel=1e-15)
    with pytest.raises(
        SceneError, match=r"Mesh: a volume needs a closed mesh, got Mesh\(3 triangles, 3 open edges\)"
    ):
        _ = TENT.volume
    with pytest.raises(SceneError, match="an inside needs a closed mesh"):
        TENT.holds((0, 0, 0.1))


def test_a_mesh_says_briefly_what_it_is():
    turned = [(0, 1, 2), (1, 2, 3)]
    with pytest.warns(MeshWarning):
        shape = Mesh(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], faces=turned)
    assert [repr(m) for m in (CUBE, CUBE.flipped(), TENT, shape)] == [
        "Mesh(12 triangles, closed)",
        "Mesh(12 triangles, inverted)",
        "Mesh(3 triangles, 3 open edges)",
        "Mesh(2 triangles, 4 open edges, 1 misoriented edge)",
    ]


def test_arrays_are_copied_plain_and_read_only():
    vertices, faces = (
        TENT.vertices.astype(np.float32)[::-1],
        np.asfortranarray(TENT.faces[:, ::-1].astype(np.uint8)),
    )
    shape = Mesh(vertices=vertices, faces=faces)
    before = shape.vertices.copy()
    vertices[:] = 0
    assert (shape.vertices == before).all()
    for array, kind in [(shape.vertices, np.float64), (shape.faces, np.int64), (shape.normals, np.float64)]:
        assert array.dtype == kind and array.flags.c_contiguous and array.shape[1] == 3
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1
    with pytest.raises(AttributeError):
        shape.vertices = before


def test_meshes_are_equal_where_their_arrays_are():
    again = Mesh.box(size=2)
    assert again == CUBE and hash(again) == hash(CUBE) and again is not CUBE
    moved = CUBE.vertices.copy()
    moved[0, 0] = np.nextafter(moved[0, 0], 0)
    assert Mesh(vertices=moved, faces=CUBE.faces) != CUBE
    assert Mesh(vertices=CUBE.vertices, faces=CUBE.faces[::-1]) != CUBE
    zero = Mesh(vertices=TENT.vertices * [1, 1, -1], faces=TENT.faces)  # with -0.0
    assert zero == Mesh(vertices=TENT.vertices * [1, 1, -1] + 0.0, faces=TENT.faces) != TENT
    assert CUBE != Box(size=2) and len({again, CUBE, zero, TENT}) == 3
    for same in (pickle.loads(pickle.dumps(CUBE)), copy.deepcopy(CUBE)):
        assert same == CUBE and not same.vertices.flags.writeable


def test_vertices_that_no_triangle_names_are_left_out():
    vertices = [(9, 9, 9), *TENT.vertices[:2], (7, 7, 7), *TENT.vertices[2:], (-9, 0, 0)]
    faces = np.array([1, 2, 4, 5])[TENT.faces]
    assert mesh(vertices, faces) == TENT


def test_moved_scaled_and_flipped_meshes():
    assert CUBE.moved((1, 2, 3)) == Mesh.box(center=(1, 2, 3), size=2)
    assert CUBE.scaled(1e-3) == Mesh(vertices=CUBE.vertices * 1e-3, faces=CUBE.faces)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # who flips a mesh need not be told that it is
        inside_out = CUBE.flipped()
    assert inside_out.volume == -CUBE.volume and not inside_out.is_closed
    assert (inside_out.normals == -CUBE.normals).all()
    assert inside_out.flipped() == CUBE


@given(st.lists(st.floats(-3, 3), min_size=3, max_size=3))
@example([0.0, 1.0, 0.5])
@example([1.0, -1.0, 0.25])
@example([1.0, 1.0, 1.0])
def test_a_closed_mesh_holds_the_points_inside_it(place):
    """None of its surface; within rounding of it, but not on it, either would do."""
    assume(not 0 < abs(max(map(abs, place)) - 1) < 1e-12)
    assert CUBE.holds(place) == CUBE.flipped().holds(place) == (max(map(abs, place)) < 1)


def test_a_shell_does_not_hold_its_cavity():
    inner = Mesh.box(size=1).flipped()
    shell = mesh(
        np.concatenate([CUBE.vertices, inner.vertices]), np.concatenate([CUBE.faces, inner.faces + 8])
    )
    assert shell.is_closed and shell.volume == pytest.approx(7)
    assert shell.holds((0.7, 0, 0)) and not shell.holds((0.1, 0, 0)) and not shell.holds((2, 0, 0))


def test_neither_the_library_nor_a_mesh_asks_for_pyvista():
    code = "import sys, transport as tp; tp.Mesh.sphere(radius=1); print('pyvista' in sys.modules, 'numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]
