"""How triangles join: what a mesh warns of, and welding of vertices in one place."""

import warnings

import numpy as np
import pytest

from tests.mesh_scenes import BALL, CUBE, SQUARE, TENT, mesh
from transport.geometry.mesh import Mesh, MeshWarning
from transport.geometry.mesh_topology import unique_rows


def warned(vertices, faces):
    with pytest.warns(MeshWarning) as heard:
        shape = Mesh(vertices=vertices, faces=faces)
    assert all(w.filename == __file__ for w in heard)  # at the caller's line
    return shape, [str(w.message) for w in heard]


def test_edges_of_three_triangles_are_warned_of_with_their_number():
    shape, (text,) = warned([*SQUARE, (0.3, 0, 1)], [(0, 1, 2), (1, 0, 4), (0, 1, 3)])
    assert "1 edge is shared by more than two triangles (non-manifold)" in text
    assert "the first by triangles 0, 1 and 2" in text and "split" in text
    assert not shape.is_closed and shape.edges.crowded == 1


def test_two_boxes_along_one_edge_are_not_closed():
    faces = CUBE.faces
    second = np.where(
        faces == 0, 6, np.where(faces == 1, 7, faces + 6)
    )  # its 0 and 1 are the first's 6 and 7
    vertices = np.concatenate([CUBE.vertices, (CUBE.vertices + (2, 2, 0))[2:]])
    shape, (text,) = warned(vertices, np.concatenate([faces, second]))
    assert "1 edge is shared" in text and not shape.is_closed
    assert shape.edges.open == shape.edges.turned == 0


@pytest.mark.parametrize("turned", range(12))
def test_a_triangle_that_faces_the_other_way_is_warned_of_with_the_number_of_its_edges(turned):
    faces = CUBE.faces.copy()
    faces[turned] = faces[turned][::-1]
    shape, (text,) = warned(CUBE.vertices, faces)
    assert "3 pairs of neighbours have opposite orientations, the first is triangles" in text
    assert turned in shape.edges.turned_example and not shape.is_closed and shape.edges.turned == 3


def test_an_inverted_mesh_is_warned_of_with_its_volume():
    shape, (text,) = warned(CUBE.vertices, CUBE.faces[:, ::-1])
    assert "closed, but its normals point inwards (volume -8 m^3, 12 triangles)" in text
    assert "mesh.flipped()" in text and not shape.is_closed and shape.flipped().is_closed


def test_two_layers_that_enclose_nothing_are_warned_of():
    vertices = np.array([*SQUARE]) @ np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    shape, (text,) = warned(vertices, [(0, 1, 2), (0, 2, 3), (1, 0, 3), (1, 3, 2)])
    assert "enclose nothing" in text and not shape.is_closed


def test_open_meshes_and_closed_ones_are_not_warned_of():
    for shape in (TENT, CUBE, BALL):
        assert mesh(shape.vertices, shape.faces) == shape


def test_edges_are_counted_as_by_hand():
    """Random triangles among few vertices: the census against a dictionary of edges."""
    random = np.random.default_rng(5)
    for vertices in (5, 7, 12, 40):
        faces = np.array([random.permutation(vertices)[:3] for _ in range(60)])
        faces = faces[unique_rows(np.sort(faces, axis=1))[0]]
        runs = {}
        for t, face in enumerate(faces.tolist()):
            for a, b in zip(face, face[1:] + face[:1], strict=True):
                runs.setdefault(frozenset((a, b)), []).append((a < b, t))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MeshWarning)
            edges = Mesh(vertices=random.normal(size=(vertices, 3)), faces=faces).edges
        sharers = [len(run) for run in runs.values()]
        turned = [run for run in runs.values() if len(run) == 2 and run[0][0] == run[1][0]]
        assert edges[:3] == (sharers.count(1), sum(n > 2 for n in sharers), len(turned))
        assert not turned or edges.turned_example in [tuple(t for _, t in run) for run in turned]


def soup(shape):
    """Every triangle with vertices of its own, as in an STL file."""
    return Mesh(
        vertices=shape.vertices[shape.faces].reshape(-1, 3),
        faces=np.arange(3 * shape.triangles).reshape(-1, 3),
    )


@pytest.mark.parametrize("shape", [CUBE, BALL, TENT], ids=["box", "ball", "tent"])
def test_welding_joins_vertices_in_one_place(shape):
    loose = soup(shape)
    assert loose.open_edges == 3 * shape.triangles and not loose.is_closed
    welded = loose.merged()
    assert welded.is_closed == shape.is_closed and welded.open_edges == shape.open_edges
    assert len(welded.vertices) == len(shape.vertices) and (welded.areas == shape.areas).all()


def test_welding_within_a_tolerance():
    loose = soup(BALL)
    noise = np.random.default_rng(6).uniform(-1e-7, 1e-7, loose.vertices.shape)
    shaken = Mesh(vertices=loose.vertices + noise, faces=loose.faces)
    assert not shaken.merged().is_closed and not shaken.merged(1e-9).is_closed
    welded = shaken.merged(4e-7)
    assert welded.is_closed and welded.triangles == BALL.triangles
    assert {tuple(v) for v in welded.vertices} <= {tuple(v) for v in shaken.vertices}  # no new places


def test_triangles_that_collapse_are_left_out_with_their_number():
    with pytest.warns(
        MeshWarning, match=r"^Mesh: 2 triangles of 12 left out: two of their vertices coincide"
    ):
        assert Mesh.box(size=(1, 1, 1)).moved((5, 0, 0)).triangles == 12
        shape = Mesh(vertices=[*SQUARE, (1, 1, 1e-9)], faces=[(0, 1, 2), (0, 2, 3), (1, 4, 2), (2, 4, 3)])
        many = Mesh(
            vertices=np.concatenate([CUBE.vertices + (9, 9, 9), shape.vertices]),
            faces=np.concatenate([CUBE.faces[:8], shape.faces + 8]),
        )
        assert many.merged(1e-8).triangles == 10


def test_rows_whose_keys_collide_are_told_apart():
    """Two different rows with one key: the slow way is taken."""
    from transport.geometry import mesh_topology

    rows = np.array([(1, 2, 3), (3, 2, 1), (1, 2, 3), (0, 0, 0), (3, 2, 1)])
    expected = unique_rows(rows)
    mixers = mesh_topology.HASH_MULTIPLIERS
    try:
        mesh_topology.HASH_MULTIPLIERS = np.ones(3, dtype=np.uint64)
        collided = unique_rows(rows)
    finally:
        mesh_topology.HASH_MULTIPLIERS = mixers
    for first, label in (expected, collided):
        assert first.tolist() == [0, 1, 3] and label.tolist() == [0, 1, 0, 2, 1]
