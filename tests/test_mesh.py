"""A mesh: area, normals, volume and edges from its arrays, what is refused and what is warned of."""

import copy
import math
import pickle
import subprocess
import sys
import warnings

import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from transport.shapes import Box, Mesh, MeshWarning, Sphere, Triangle
from transport.shapes.mesh_topology import equal_rows
from transport.validation import SceneError

CUBE = Mesh.box(size=2.0)
BALL = Mesh.sphere(radius=2.0, center=(1, -2, 3), triangles=500)
TENT = Mesh(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], faces=[(0, 1, 3), (1, 2, 3), (2, 0, 3)])


def test_masked_vertices_are_refused():
    """What lies under a mask is a fill value, often 1e36: never a coordinate."""
    masked = np.ma.masked_greater(TENT.vertices, 0.5)
    with pytest.raises(
        SceneError, match=r"vertices must have all their values, got 3 masked; write \.filled\(0\)"
    ):
        Mesh(vertices=masked, faces=TENT.faces)


def mesh(vertices, faces):
    """A mesh of which nothing is warned."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return Mesh(vertices=vertices, faces=faces)


def exact_facet(vertices):
    """Unit normal and area of one triangle in 60 digits."""
    with mpmath.workdps(60):
        a, b, c = (mpmath.matrix([mpmath.mpf(float(x)) for x in vertex]) for vertex in vertices)
        u, v = b - a, c - a
        twice = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        length = mpmath.sqrt(sum(x * x for x in twice))
        return [float(x / length) for x in twice], float(length / 2)


# ---- what it answers ----


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
        "Mesh(2 triangles, 4 open edges, 1 turned edge)",
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


# ---- rounding ----


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


# ---- what is refused ----

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
ONE = [(0, 1, 2)]
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
        ["Mesh: vertices must be finite", "1 of 5, first vertex 4: [0.0, nan, 0.0]", "mend"],
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


# ---- what is warned of ----


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
    assert "closed and inverted, its normals point inwards (volume -8 m^3, 12 triangles)" in text
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
        faces = faces[equal_rows(np.sort(faces, axis=1))[0]]
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


# ---- welding ----


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
        MeshWarning, match=r"^Mesh: 2 triangles of 12 left out, with two vertices in one place"
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
    from transport.shapes import mesh_topology

    rows = np.array([(1, 2, 3), (3, 2, 1), (1, 2, 3), (0, 0, 0), (3, 2, 1)])
    expected = equal_rows(rows)
    mixers = mesh_topology.MIXERS
    try:
        mesh_topology.MIXERS = np.ones(3, dtype=np.uint64)
        collided = equal_rows(rows)
    finally:
        mesh_topology.MIXERS = mixers
    for first, label in (expected, collided):
        assert first.tolist() == [0, 1, 3] and label.tolist() == [0, 1, 0, 2, 1]


def test_neither_the_library_nor_a_mesh_asks_for_pyvista():
    code = "import sys, transport as tp; tp.Mesh.sphere(radius=1); print('pyvista' in sys.modules, 'numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]
