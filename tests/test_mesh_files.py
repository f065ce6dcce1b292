"""Meshes from files: the same triangles from every kind of file, and every file that is not whole is refused."""

import math
import os
import struct
import subprocess
import sys
import types

import numpy as np
import pytest

from transport.geometry.mesh import Mesh, MeshWarning
from transport.validation import SceneError

pyvista = pytest.importorskip("pyvista")

BALL = Mesh.sphere(center=(1, 2, 3), radius=0.5, triangles=500)
SQUARE_OBJ = """
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
f 1/1 2/1 3/1 4/1
"""


def polydata(shape):
    return pyvista.PolyData(shape.vertices, np.insert(shape.faces, 0, 3, axis=1).ravel())


def write_stl(path, triangles, promised=None):
    """A binary STL file of triangles (m, 3, 3), by its definition."""
    with open(path, "wb") as stream:
        stream.write(b"by hand".ljust(80))
        stream.write(struct.pack("<I", len(triangles) if promised is None else promised))
        for corners in triangles:
            stream.write(struct.pack("<12fH", 0, 0, 0, *np.ravel(corners), 0))


def write_obj(path, shape):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in shape.vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (shape.faces + 1).tolist()]
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".vtp", ".STL"])
@pytest.mark.parametrize("binary", [True, False])
def test_a_closed_mesh_comes_back_closed(tmp_path, suffix, binary):
    path = tmp_path / f"ball{suffix}"
    polydata(BALL).save(tmp_path / f"saved{suffix.lower()}", binary=binary)
    (tmp_path / f"saved{suffix.lower()}").rename(path)
    shape = Mesh.from_file(path)
    assert shape.is_closed and shape.triangles == BALL.triangles
    assert len(shape.vertices) == len(BALL.vertices)
    single = suffix.lower() == ".stl" or not binary  # precision
    assert shape.volume == pytest.approx(BALL.volume, rel=1e-5 if single else 1e-6)
    assert shape.middle == pytest.approx((1, 2, 3), rel=1e-6)
    if suffix == ".vtp":
        assert shape == Mesh.from_pyvista(polydata(BALL))


def test_an_obj_file_keeps_all_digits(tmp_path):
    write_obj(tmp_path / "ball.obj", BALL)
    shape = Mesh.from_file(str(tmp_path / "ball.obj"))
    assert shape.is_closed and shape.triangles == BALL.triangles
    assert shape.volume == pytest.approx(BALL.volume, rel=1e-6)


def test_quads_are_cut_into_triangles(tmp_path):
    (tmp_path / "square.obj").write_text(SQUARE_OBJ)
    shape = Mesh.from_file(tmp_path / "square.obj")
    assert (shape.triangles, shape.area, shape.open_edges) == (2, 1.0, 4)
    box = Mesh.from_pyvista(pyvista.Box())
    assert (box.triangles, box.area, box.is_closed) == (12, pytest.approx(24), True)


def test_scale_is_metres_per_unit_of_the_file(tmp_path):
    polydata(BALL).save(tmp_path / "ball.ply")
    shape = Mesh.from_file(tmp_path / "ball.ply", scale=1e-3)
    assert shape.volume == pytest.approx(BALL.volume * 1e-9, rel=1e-5)
    assert shape == Mesh.from_file(tmp_path / "ball.ply").scaled(1e-3)


def test_tolerance_closes_a_mesh_whose_vertices_differ_by_rounding(tmp_path):
    random = np.random.default_rng(1)
    corners = BALL.vertices[BALL.faces]
    write_stl(tmp_path / "ball.stl", corners + random.uniform(-1e-5, 1e-5, corners.shape))
    assert not Mesh.from_file(tmp_path / "ball.stl").is_closed
    assert Mesh.from_file(tmp_path / "ball.stl", tolerance=1e-4).is_closed
    assert Mesh.from_file(tmp_path / "ball.stl", scale=1e-3, tolerance=1e-7).is_closed


def test_collapsed_triangles_are_left_out_with_their_number(tmp_path):
    """VTK would leave them out as well, but without a word."""
    corners = BALL.vertices[BALL.faces]
    corners = np.concatenate([corners, corners[:3, [0, 1, 1]]])
    write_stl(tmp_path / "ball.stl", corners)
    with pytest.warns(MeshWarning, match=f"3 triangles of {len(corners)} left out") as heard:
        shape = Mesh.from_file(tmp_path / "ball.stl")
    assert shape.is_closed and heard[0].filename == __file__


def test_lines_and_points_of_polydata_are_left_out():
    faces = np.insert(BALL.faces, 0, 3, axis=1).ravel()
    shape = Mesh.from_pyvista(pyvista.PolyData(BALL.vertices, faces, lines=[2, 0, 1], verts=[1, 5]))
    assert shape.triangles == BALL.triangles and shape.is_closed


def test_whatever_looks_like_polydata_is_understood():
    """No PyVista is needed for it."""
    duck = types.SimpleNamespace(points=[(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces=[3, 0, 1, 2])
    duck.triangulate = lambda: duck
    assert Mesh.from_pyvista(duck).area == 0.5


# ---- what is refused ----


def refused(path, *parts, **how):
    with pytest.raises(SceneError) as error:
        Mesh.from_file(path, **how)
    for part in ("Mesh.from_file: ", *parts):
        assert part in str(error.value), str(error.value)


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".vtp"])
@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("share", [0.001, 0.3, 0.9, 0.99])
def test_a_file_that_was_cut_off_is_refused(tmp_path, suffix, binary, share):
    """Of such VTK makes garbage, or ends the process."""
    whole, part = tmp_path / f"whole{suffix}", tmp_path / f"part{suffix}"
    polydata(BALL).save(whole, binary=binary)
    part.write_bytes(whole.read_bytes()[: math.ceil(share * whole.stat().st_size)])
    refused(part, f"'part{suffix}' cannot be read as {suffix}", "save it again")


@pytest.mark.skipif(os.name != "posix", reason="looks at how a process ends")
def test_without_the_look_at_lengths_a_short_file_ends_the_process_or_is_garbage(tmp_path):
    """Planted: no look before reading."""
    polydata(BALL).save(tmp_path / "ball.ply", binary=True)
    whole = (tmp_path / "ball.ply").read_bytes()
    (tmp_path / "short.ply").write_bytes(whole[: len(whole) // 2])
    code = (
        "from transport.geometry import mesh_build as mesh_files; from transport.geometry.mesh import Mesh; mesh_files.why_not_whole = lambda file: None\n"
        f"print(Mesh.from_file({str(tmp_path / 'short.ply')!r}))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode != 0 or "Mesh(" in done.stdout


@pytest.mark.parametrize(
    ("name", "content", "part"),
    [
        ("empty.stl", b"", "an empty file, 0 bytes"),
        ("text.stl", b"hello there", "a truncated STL file, or none"),
        ("solid.stl", b"solid of rock", "text that does not end with 'endsolid'"),
        ("hollow.stl", b"solid a\nendsolid a\n", "save it again"),
        ("zeros.stl", b"\0" * 84, "no triangles"),
        ("promises.stl", b"\0" * 80 + b"\xff\xff\xff\xff", "truncated"),
        ("text.ply", b"ply nonsense", "no PLY header"),
        ("odd.ply", b"ply\nformat ascii 1.0\nelement vertex many\nend_header\n", "an invalid header"),
        (
            "odd2.ply",
            b"ply\nformat ascii 1.0\nelement vertex 1\nproperty word x\nend_header\n",
            "an invalid header",
        ),
        ("text.vtp", b"<xml", "save it again"),
        ("text.obj", b"# nothing\n", "no triangles"),
        ("points.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangles"),
    ],
)
def test_a_file_without_triangles_is_refused(tmp_path, name, content, part):
    (tmp_path / name).write_bytes(content)
    refused(tmp_path / name, repr(name), part)


def test_a_file_that_is_not_there_is_refused_with_where_to_look(tmp_path):
    refused(tmp_path / "a" / "ball.stl", "no such file", "ball.stl", f"look in {str(tmp_path)!r}")
    (tmp_path / "folder.stl").mkdir()
    refused(tmp_path / "folder.stl", "got a folder")


def test_an_unknown_kind_of_file_is_refused_with_those_that_are_known(tmp_path):
    refused("part.step", ".stl, .ply, .obj, .vtp", "'part.step'")
    refused("part", "'part'")
    refused(7, "path must be a text or a Path, got 7")


@pytest.mark.parametrize("how", [{"scale": 0}, {"scale": math.nan}, {"tolerance": -1}, {"tolerance": "1"}])
def test_wrong_scales_and_tolerances_are_refused(tmp_path, how):
    polydata(BALL).save(tmp_path / "ball.ply")
    with pytest.raises(SceneError, match=next(iter(how))):
        Mesh.from_file(tmp_path / "ball.ply", **how)


def test_nan_in_a_file_is_refused(tmp_path):
    corners = BALL.vertices[BALL.faces]
    corners[7, 1, 2] = np.nan
    write_stl(tmp_path / "ball.stl", corners)
    with pytest.raises(SceneError, match="finite"):
        Mesh.from_file(tmp_path / "ball.stl")
    (tmp_path / "square.obj").write_text(SQUARE_OBJ.replace("v 1 0 0", "v nan 0 0"))
    with pytest.raises(SceneError):
        Mesh.from_file(tmp_path / "square.obj")
    bad = polydata(BALL)
    bad.points[3, 1] = np.inf
    with pytest.raises(SceneError, match="vertices must be finite, got NaN or infinity in 1 of"):
        Mesh.from_pyvista(bad)


def test_without_pyvista_the_cure_is_named(tmp_path, monkeypatch):
    write_obj(tmp_path / "ball.obj", BALL)
    monkeypatch.setitem(sys.modules, "pyvista", None)
    refused(tmp_path / "ball.obj", "'ball.obj' needs pyvista", "pip install '.[viz]'")


@pytest.mark.parametrize("given", [None, [(0, 0, 0)], types.SimpleNamespace(points=[])])
def test_what_is_no_polydata_is_refused(given):
    with pytest.raises(
        SceneError, match=r"polydata must be a pyvista.PolyData, got \w+; write .*extract_surface"
    ):
        Mesh.from_pyvista(given)


def test_polydata_without_polygons_is_refused():
    with pytest.raises(SceneError, match="polydata must hold polygons, got none"):
        Mesh.from_pyvista(pyvista.PolyData([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)]))
