"""Meshes: area, normals, volume, edges and what they hold; rounding; welding; files; faces that lie on other shapes."""

import copy
import math
import pickle
import struct
import sys
import time
import types
import warnings

import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

import transport as tp
from tests.refusals import assert_refused
from transport.geometry import mesh_topology
from transport.geometry.mesh_topology import unique_rows

Mesh, MeshWarning = tp.Mesh, tp.MeshWarning
CUBE = Mesh.box(size=2.0)
BALL = Mesh.sphere(radius=2.0, center=(1, -2, 3), triangles=500)
TENT = Mesh(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], faces=[(0, 1, 3), (1, 2, 3), (2, 0, 3)])
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def mesh(vertices, faces):
    """A mesh of which nothing is warned."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return Mesh(vertices=vertices, faces=faces)


# ---- areas, volumes, insides ----


def test_a_box_of_triangles_is_the_box():
    shape, box = (make(center=(1, 2, 3), size=(1, 2, 4)) for make in (Mesh.box, tp.Box))
    assert (shape.triangles, shape.area, shape.volume) == (12, box.area, pytest.approx(box.volume, rel=1e-15))
    assert (shape.bounds, shape.middle) == (box.bounds, box.middle)
    assert shape.extent == pytest.approx(box.extent, rel=1e-15)
    assert shape.is_closed and shape.open_edges == 0
    centroids = shape.vertices[shape.faces].mean(axis=1)
    assert ((centroids - shape.middle) * shape.normals > 0).any(axis=1).all()  # outwards
    assert {tuple(normal) for normal in shape.normals} == {face.normal for face in box.faces().values()}


@pytest.mark.parametrize(("wanted", "got"), [(1, 20), (20, 20), (21, 80), (80, 80), (81, 180), (5120, 5120)])
def test_a_sphere_has_at_least_so_many_triangles_with_all_vertices_on_it(wanted, got):
    ball = tp.Sphere(center=(1, -2, 3), radius=0.7)
    shape = Mesh.sphere(center=ball.center, radius=ball.radius, triangles=wanted)
    assert shape.triangles == got and shape.is_closed
    assert len(shape.vertices) == got / 2 + 2  # Euler: n - 3m/2 + m = 2
    distances = np.linalg.norm(shape.vertices - ball.center, axis=1)
    assert distances == pytest.approx(ball.radius, rel=2e-15)
    assert shape.extent == pytest.approx(ball.radius, rel=1e-2 if got > 20 else 0.2)
    assert 0.5 < shape.area / ball.area < 1 and 0.5 < shape.volume / ball.volume < 1
    assert shape.areas.max() / shape.areas.min() < 2


def test_a_mesh_of_a_sphere_nears_the_sphere_with_the_square_of_its_edges():
    lacks = [1 - Mesh.sphere(radius=1, triangles=20 * f * f).volume / (4 * math.pi / 3) for f in (10, 20, 40)]
    assert np.divide(lacks[:-1], lacks[1:]) == pytest.approx(4, rel=0.02)


def test_an_open_mesh_has_an_area_and_no_volume():
    assert TENT.open_edges == 3 and not TENT.is_closed
    assert TENT.area == pytest.approx(1 + math.sqrt(3) / 2, rel=1e-15)
    assert_refused(
        lambda: TENT.volume, "Mesh: a volume needs a closed mesh, got Mesh(3 triangles, 3 open edges)"
    )
    assert_refused(lambda: TENT.holds((0, 0, 0.1)), "an inside needs a closed mesh")


def test_the_repr_of_a_mesh_is_short():
    with pytest.warns(MeshWarning):
        shape = Mesh(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], faces=[(0, 1, 2), (1, 2, 3)])
    assert [repr(m) for m in (CUBE, CUBE.flipped(), TENT, shape)] == [
        "Mesh(12 triangles, closed)",
        "Mesh(12 triangles, inverted)",
        "Mesh(3 triangles, 3 open edges)",
        "Mesh(2 triangles, 4 open edges, 1 misoriented edge)",
    ]


def test_arrays_are_copied_plain_and_read_only():
    vertices = TENT.vertices.astype(np.float32)[::-1]
    shape = Mesh(vertices=vertices, faces=np.asfortranarray(TENT.faces[:, ::-1].astype(np.uint8)))
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
    assert CUBE != tp.Box(size=2) and len({again, CUBE, zero, TENT}) == 3
    for same in (pickle.loads(pickle.dumps(CUBE)), copy.deepcopy(CUBE)):
        assert same == CUBE and not same.vertices.flags.writeable
    vertices = [(9, 9, 9), *TENT.vertices[:2], (7, 7, 7), *TENT.vertices[2:], (-9, 0, 0)]
    assert mesh(vertices, np.array([1, 2, 4, 5])[TENT.faces]) == TENT  # vertices of no triangle are left out


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
    faces = np.concatenate([CUBE.faces, inner.faces + 8])
    shell = mesh(np.concatenate([CUBE.vertices, inner.vertices]), faces)
    assert shell.is_closed and shell.volume == pytest.approx(7)
    assert shell.holds((0.7, 0, 0)) and not shell.holds((0.1, 0, 0)) and not shell.holds((2, 0, 0))


# ---- slivers, thin plates and lengths of any scale ----


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
def test_slivers_keep_all_their_digits_which_a_vector_product_in_doubles_loses(offset, scale):
    vertices, faces = slivers(offset)
    shape = mesh(vertices * scale, faces)
    normals, areas = map(np.array, zip(*(exact_facet(vertices[face]) for face in faces), strict=True))
    assert shape.areas / scale**2 == pytest.approx(areas, rel=1e-15, abs=0)
    assert np.abs(shape.normals - normals).max() < 5e-16
    assert shape.area == pytest.approx(math.fsum(shape.areas), rel=1e-16)
    a, b, c = vertices[faces].transpose(1, 0, 2)
    plain = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    assert np.abs(plain / areas - 1).max() > (1e-3 if offset == 0 else 1e-6)


def test_a_mesh_has_the_normals_and_areas_of_its_triangles():
    for face, normal, area in zip(BALL.faces, BALL.normals, BALL.areas, strict=True):
        single = tp.Triangle(vertices=BALL.vertices[face].tolist())
        assert normal == pytest.approx(np.array(single.normal), abs=4e-16)
        assert area == pytest.approx(single.area, rel=1e-15)


def is_made(make):
    try:
        return bool(make())
    except tp.SceneError:
        return False


def test_a_triangle_and_a_mesh_agree_on_vertices_on_a_line():
    """Heights about the rounding of the coordinates: both take the same side."""
    random, refused = np.random.default_rng(2), 0
    for height in 2.0 ** np.arange(-56, -46, 0.25):
        a, way = random.uniform(-1, 1, 3), random.normal(size=3)
        corners = [a.tolist(), (a + way).tolist(), (a + 0.4 * way + height * np.array([1, -1, 0])).tolist()]
        one = is_made(lambda corners=corners: tp.Triangle(vertices=corners))
        assert one == is_made(lambda corners=corners: Mesh(vertices=corners, faces=[(0, 1, 2)]))
        refused += not one
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


# ---- edges ----


def turned(k):
    """The faces of the cube, one of which faces the other way."""
    faces = CUBE.faces.copy()
    faces[k] = faces[k][::-1]
    return faces


SECOND = np.where(
    CUBE.faces == 0, 6, np.where(CUBE.faces == 1, 7, CUBE.faces + 6)
)  # its 0, 1: the first's 6, 7
TWO_BOXES = np.concatenate([CUBE.vertices, (CUBE.vertices + (2, 2, 0))[2:]])
TILTED = np.array(SQUARE) @ np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
WARNED = {
    "three on one edge": (
        [*SQUARE, (0.3, 0, 1)], [(0, 1, 2), (1, 0, 4), (0, 1, 3)], {"crowded": 1},
        ("1 edge is shared by more than two triangles (non-manifold)", "the first by triangles 0, 1 and 2", "split"),
    ),
    "two boxes along one edge": (TWO_BOXES, np.concatenate([CUBE.faces, SECOND]), {"open": 0, "turned": 0}, ("1 edge is shared",)),
    "inverted": (CUBE.vertices, CUBE.faces[:, ::-1], {}, ("closed, but its normals point inwards (volume -8 m^3, 12 triangles)", "mesh.flipped()")),
    "two layers": (TILTED, [(0, 1, 2), (0, 2, 3), (1, 0, 3), (1, 3, 2)], {}, ("enclose nothing",)),
    **{
        f"triangle {k} turned": (CUBE.vertices, turned(k), {"turned": 3}, ("3 pairs of neighbours have opposite orientations, the first is triangles",))
        for k in range(12)
    },
}  # fmt: skip


@pytest.mark.parametrize("case", WARNED)
def test_edges_that_do_not_close_a_mesh_are_warned_of_with_their_number(case):
    vertices, faces, edges, words = WARNED[case]
    with pytest.warns(MeshWarning) as heard:
        shape = Mesh(vertices=vertices, faces=faces)
    (warning,) = heard
    assert warning.filename == __file__  # at the caller's line
    assert [word for word in words if word not in str(warning.message)] == []
    assert not shape.is_closed and {name: getattr(shape.edges, name) for name in edges} == edges
    assert "turned" not in case or int(case.split()[1]) in shape.edges.turned_example
    assert case != "inverted" or shape.flipped().is_closed


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


def soup(shape, noise=0.0):
    """Every triangle with vertices of its own, as in an STL file."""
    vertices = shape.vertices[shape.faces].reshape(-1, 3) + noise
    return Mesh(vertices=vertices, faces=np.arange(3 * shape.triangles).reshape(-1, 3))


@pytest.mark.parametrize("shape", [CUBE, BALL, TENT], ids=["box", "ball", "tent"])
def test_welding_joins_vertices_in_one_place(shape):
    loose = soup(shape)
    assert loose.open_edges == 3 * shape.triangles and not loose.is_closed
    welded = loose.merged()
    assert welded.is_closed == shape.is_closed and welded.open_edges == shape.open_edges
    assert len(welded.vertices) == len(shape.vertices) and (welded.areas == shape.areas).all()


def test_welding_within_a_tolerance():
    shaken = soup(BALL, np.random.default_rng(6).uniform(-1e-7, 1e-7, (3 * BALL.triangles, 3)))
    assert not shaken.merged().is_closed and not shaken.merged(1e-9).is_closed
    welded = shaken.merged(4e-7)
    assert welded.is_closed and welded.triangles == BALL.triangles
    assert {tuple(v) for v in welded.vertices} <= {tuple(v) for v in shaken.vertices}  # no new places


def test_triangles_that_collapse_are_left_out_with_their_number():
    assert Mesh.box(size=(1, 1, 1)).moved((5, 0, 0)).triangles == 12
    shape = Mesh(vertices=[*SQUARE, (1, 1, 1e-9)], faces=[(0, 1, 2), (0, 2, 3), (1, 4, 2), (2, 4, 3)])
    vertices = np.concatenate([CUBE.vertices + (9, 9, 9), shape.vertices])
    many = Mesh(vertices=vertices, faces=np.concatenate([CUBE.faces[:8], shape.faces + 8]))
    words = r"^Mesh: 2 triangles of 12 left out: two of their vertices coincide"
    with pytest.warns(MeshWarning, match=words):
        assert many.merged(1e-8).triangles == 10


@pytest.mark.parametrize("multipliers", [None, np.ones(3, dtype=np.uint64)], ids=["usual", "colliding"])
def test_rows_whose_keys_collide_are_distinguished(multipliers, monkeypatch):
    """Two different rows with one key: the slow way is taken."""
    if multipliers is not None:
        monkeypatch.setattr(mesh_topology, "HASH_MULTIPLIERS", multipliers)
    first, label = unique_rows(np.array([(1, 2, 3), (3, 2, 1), (1, 2, 3), (0, 0, 0), (3, 2, 1)]))
    assert first.tolist() == [0, 1, 3] and label.tolist() == [0, 1, 0, 2, 1]


# ---- files ----

FILED = Mesh.sphere(center=(1, 2, 3), radius=0.5, triangles=500)
SQUARE_OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1 4/1\n"


@pytest.fixture
def pyvista():
    return pytest.importorskip("pyvista")


@pytest.fixture
def polydata(pyvista):
    """Another one for each test."""
    return pyvista.PolyData(FILED.vertices, np.insert(FILED.faces, 0, 3, axis=1).ravel())


def write_stl(path, triangles):
    """A binary STL file of triangles (m, 3, 3), by its definition."""
    records = (struct.pack("<12fH", 0, 0, 0, *np.ravel(corners), 0) for corners in triangles)
    path.write_bytes(b"by hand".ljust(80) + struct.pack("<I", len(triangles)) + b"".join(records))
    return path


def write_obj(path):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in FILED.vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (FILED.faces + 1).tolist()]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".vtp", ".STL"])
@pytest.mark.parametrize("binary", [True, False])
def test_a_closed_mesh_comes_back_closed(tmp_path, polydata, suffix, binary):
    path, saved = tmp_path / f"ball{suffix}", tmp_path / f"saved{suffix.lower()}"
    polydata.save(saved, binary=binary)
    shape = Mesh.from_file(saved.rename(path))
    assert shape.is_closed and shape.triangles == FILED.triangles
    assert len(shape.vertices) == len(FILED.vertices)
    single = suffix.lower() == ".stl" or not binary  # precision
    assert shape.volume == pytest.approx(FILED.volume, rel=1e-5 if single else 1e-6)
    assert shape.middle == pytest.approx((1, 2, 3), rel=1e-6)
    if suffix == ".vtp":
        assert shape == Mesh.from_pyvista(polydata)


def test_obj_files_keep_all_digits_and_quads_are_cut_into_triangles(tmp_path, pyvista):
    shape = Mesh.from_file(str(write_obj(tmp_path / "ball.obj")))
    assert shape.is_closed and shape.triangles == FILED.triangles
    assert shape.volume == pytest.approx(FILED.volume, rel=1e-6)
    (tmp_path / "square.obj").write_text(SQUARE_OBJ)
    square, box = Mesh.from_file(tmp_path / "square.obj"), Mesh.from_pyvista(pyvista.Box())
    assert (square.triangles, square.area, square.open_edges) == (2, 1.0, 4)
    assert (box.triangles, box.area, box.is_closed) == (12, pytest.approx(24), True)


def test_scale_is_metres_per_unit_of_the_file(tmp_path, polydata):
    polydata.save(tmp_path / "ball.ply")
    shape = Mesh.from_file(tmp_path / "ball.ply", scale=1e-3)
    assert shape.volume == pytest.approx(FILED.volume * 1e-9, rel=1e-5)
    assert shape == Mesh.from_file(tmp_path / "ball.ply").scaled(1e-3)


def test_tolerance_closes_a_mesh_whose_vertices_differ_by_rounding(tmp_path, pyvista):
    corners = FILED.vertices[FILED.faces]
    noise = np.random.default_rng(1).uniform(-1e-5, 1e-5, corners.shape)
    path = write_stl(tmp_path / "ball.stl", corners + noise)
    assert not Mesh.from_file(path).is_closed
    assert Mesh.from_file(path, tolerance=1e-4).is_closed
    assert Mesh.from_file(path, scale=1e-3, tolerance=1e-7).is_closed


def test_collapsed_triangles_of_a_file_are_left_out_with_their_number(tmp_path, pyvista):
    """VTK would leave them out as well, but without a word."""
    corners = FILED.vertices[FILED.faces]
    corners = np.concatenate([corners, corners[:3, [0, 1, 1]]])
    path = write_stl(tmp_path / "ball.stl", corners)
    with pytest.warns(MeshWarning, match=f"3 triangles of {len(corners)} left out") as heard:
        shape = Mesh.from_file(path)
    assert shape.is_closed and heard[0].filename == __file__


def test_lines_and_points_of_polydata_are_left_out(pyvista, polydata):
    shape = pyvista.PolyData(FILED.vertices, polydata.faces, lines=[2, 0, 1], verts=[1, 5])
    assert Mesh.from_pyvista(shape).triangles == FILED.triangles and Mesh.from_pyvista(shape).is_closed


def test_whatever_looks_like_polydata_is_understood():
    """No PyVista is needed for it."""
    duck = types.SimpleNamespace(points=[(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces=[3, 0, 1, 2])
    duck.triangulate = lambda: duck
    assert Mesh.from_pyvista(duck).area == 0.5


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".vtp"])
@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("share", [0.001, 0.3, 0.9, 0.99])
def test_a_file_that_was_cut_off_is_refused(tmp_path, polydata, suffix, binary, share):
    """Of such VTK makes garbage, or ends the process."""
    whole, part = tmp_path / f"whole{suffix}", tmp_path / f"part{suffix}"
    polydata.save(whole, binary=binary)
    part.write_bytes(whole.read_bytes()[: math.ceil(share * whole.stat().st_size)])
    words = f"Mesh.from_file: ... 'part{suffix}' cannot be read as {suffix} ... save it again"
    assert_refused(lambda: Mesh.from_file(part), words)


WRONG_FILES = {
    "empty.stl": (b"", "an empty file, 0 bytes"),
    "text.stl": (b"hello there", "a truncated STL file, or none"),
    "solid.stl": (b"solid of rock", "text that does not end with 'endsolid'"),
    "hollow.stl": (b"solid a\nendsolid a\n", "save it again"),
    "zeros.stl": (b"\0" * 84, "no triangles"),
    "promises.stl": (b"\0" * 80 + b"\xff\xff\xff\xff", "truncated"),
    "text.ply": (b"ply nonsense", "no PLY header"),
    "odd.ply": (b"ply\nformat ascii 1.0\nelement vertex many\nend_header\n", "an invalid header"),
    "odd2.ply": (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty word x\nend_header\n", "an invalid header"),
    "text.vtp": (b"<xml", "save it again"),
    "text.obj": (b"# nothing\n", "no triangles"),
    "points.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangles"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG_FILES)
def test_a_file_without_triangles_is_refused(tmp_path, pyvista, name):
    content, words = WRONG_FILES[name]
    (tmp_path / name).write_bytes(content)
    assert_refused(lambda: Mesh.from_file(tmp_path / name), ["Mesh.from_file: ", repr(name), words])


def test_wrong_paths_scales_and_tolerances_are_refused(tmp_path, polydata):
    (tmp_path / "folder.stl").mkdir()
    polydata.save(tmp_path / "ball.ply")
    for path, words in {
        tmp_path / "a" / "ball.stl": f"no such file ... ball.stl ... look in {str(tmp_path)!r}",
        tmp_path / "folder.stl": "got a folder",
        "part.step": ".stl, .ply, .obj, .vtp ... 'part.step'",
        "part": "'part'",
        7: "path must be a text or a Path, got 7",
    }.items():
        assert_refused(lambda path=path: Mesh.from_file(path), f"Mesh.from_file: ... {words}")
    for name, value in [("scale", 0), ("scale", math.nan), ("tolerance", -1), ("tolerance", "1")]:
        assert_refused(lambda how={name: value}: Mesh.from_file(tmp_path / "ball.ply", **how), name)


def test_nan_in_a_file_is_refused(tmp_path, polydata):
    corners = FILED.vertices[FILED.faces]
    corners[7, 1, 2] = np.nan
    path = write_stl(tmp_path / "ball.stl", corners)
    assert_refused(lambda: Mesh.from_file(path), "finite")
    (tmp_path / "square.obj").write_text(SQUARE_OBJ.replace("v 1 0 0", "v nan 0 0"))
    assert_refused(lambda: Mesh.from_file(tmp_path / "square.obj"), "")
    polydata.points[3, 1] = np.inf
    assert_refused(
        lambda: Mesh.from_pyvista(polydata), "vertices must be finite, got NaN or infinity in 1 of"
    )


def test_without_pyvista_the_cure_is_named(tmp_path, monkeypatch):
    path = write_obj(tmp_path / "ball.obj")
    monkeypatch.setitem(sys.modules, "pyvista", None)
    assert_refused(lambda: Mesh.from_file(path), "'ball.obj' needs pyvista ... pip install '.[viz]'")


def test_a_polydata_without_polygons_and_anything_else_is_refused(pyvista):
    for other in (None, [(0, 0, 0)], types.SimpleNamespace(points=[])):
        words = "polydata must be a pyvista.PolyData, got ... ; write ... extract_surface"
        assert_refused(lambda other=other: Mesh.from_pyvista(other), words)
    points = pyvista.PolyData([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    assert_refused(lambda: Mesh.from_pyvista(points), "polydata must hold polygons, got none")


# ---- faces that lie on other shapes ----

UNIT = Mesh.box(size=1.0)
LAMP = tp.Source(tp.Point(position=(0, 0, 3)), tp.Isotropic(power=1.0))
FLUSH = {
    "floor": tp.Rectangle(center=(0, 0, -0.5), width=3, height=3),
    "corner of a floor": tp.Rectangle(center=(0.9, 0.9, -0.5), width=1, height=1),
    "turned floor": tp.Rectangle(center=(0, 0, -0.5), up=(1, 2, 0), width=0.1, height=0.1),
    "disk": tp.Disk(center=(0, 0.6, 0.5), radius=0.2),
    "plane": tp.Plane(center=(3, 0, 0.5)),
    "slab": tp.Slab(center=(0, 0, -1.5), thickness=2.0),
    "box": tp.Box(center=(0, 0, -1), size=1.0),
    "triangle": tp.Triangle(vertices=((0, 0, 0.5), (2, 0, 0.5), (0, 2, 0.5))),
    "mesh": Mesh.box(center=(0.3, 0.2, 1.0), size=1.0),
    "part of it": Mesh(vertices=UNIT.vertices, faces=UNIT.faces[:2]),
}
APART = {
    "gap": tp.Rectangle(center=(0, 0, -0.5 - 1e-9), width=3, height=3),
    "beside": tp.Rectangle(center=(1.5, 0, -0.5), width=1, height=1),
    "shares an edge": tp.Rectangle(center=(1.0, 0, -0.5), width=1, height=1),
    "disk beside": tp.Disk(center=(0, 0.8, 0.5), radius=0.2),
    "tilted": tp.Rectangle(center=(0, 0, -0.5), normal=(0.1, 0, 1), width=0.5, height=0.5),
    "ball": tp.Sphere(radius=0.5),
    "mesh that shares an edge": Mesh.box(center=(1.0, 0, 1.0), size=1.0),
    "mesh inside": Mesh.box(size=0.5),
    "itself": UNIT,
}


@pytest.mark.parametrize("other", FLUSH.values(), ids=FLUSH)
def test_a_face_on_another_shape_is_refused(other):
    cube = tp.Surface(UNIT, tp.Diffuse(0.5), "cube")
    words = "a face of ... cube ... , a Mesh, lies on ... ; leave a gap such as ... m"
    assert_refused(lambda: tp.Scene(LAMP, [cube], tp.Detector(other, "other")), words)
    assert_refused(lambda: tp.Scene(LAMP, [cube, tp.Surface(other, tp.Black())]), "lies on")
    if not other.is_infinite:
        lamps = [LAMP, tp.Source(other, tp.Lambertian(power=1.0))]
        assert_refused(lambda: tp.Scene(lamps, [cube]), "lies on")


@pytest.mark.parametrize("other", APART.values(), ids=APART)
def test_a_shape_that_touches_an_edge_or_leaves_a_gap_is_accepted(other):
    cube = tp.Surface(UNIT, tp.Transparent(), "cube")
    tp.Scene(LAMP, [cube], [tp.Detector("cube"), tp.Detector(other, "other")])


@pytest.mark.slow
def test_faces_of_many_facets_are_compared_in_little_time():
    fine, begun = Mesh.sphere(radius=1.0, triangles=100_000), time.process_time()
    looks = [tp.Detector(fine.moved((0.1, 0, 0)), "shifted"), tp.Detector(tp.Plane(), "cut")]
    tp.Scene(LAMP, [tp.Surface(fine, tp.Diffuse(0.5))], looks)
    assert time.process_time() - begun < 10
