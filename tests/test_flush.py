"""Faces of meshes that lie flush on other shapes are refused; what only touches along an edge, or leaves a gap, is not."""

import time

import pytest

import transport as tp

CUBE = tp.Mesh.box(size=1.0)
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
    "mesh": tp.Mesh.box(center=(0.3, 0.2, 1.0), size=1.0),
    "part of it": tp.Mesh(vertices=CUBE.vertices, faces=CUBE.faces[:2]),
}
CLEAR = {
    "gap": tp.Rectangle(center=(0, 0, -0.5 - 1e-9), width=3, height=3),
    "beside": tp.Rectangle(center=(1.5, 0, -0.5), width=1, height=1),
    "shares an edge": tp.Rectangle(center=(1.0, 0, -0.5), width=1, height=1),
    "disk beside": tp.Disk(center=(0, 0.8, 0.5), radius=0.2),
    "tilted": tp.Rectangle(center=(0, 0, -0.5), normal=(0.1, 0, 1), width=0.5, height=0.5),
    "ball": tp.Sphere(radius=0.5),
    "mesh that shares an edge": tp.Mesh.box(center=(1.0, 0, 1.0), size=1.0),
    "mesh inside": tp.Mesh.box(size=0.5),
    "itself": CUBE,
}


@pytest.mark.parametrize("other", FLUSH.values(), ids=FLUSH)
def test_a_face_on_another_shape_is_refused(other):
    mesh = tp.Surface(CUBE, tp.Diffuse(0.5), "cube")
    message = r"a face of .*cube.*, a Mesh, lies on .*; leave a gap such as .* m"
    with pytest.raises(tp.SceneError, match=message):
        tp.Scene(LAMP, [mesh], tp.Detector(other, "other"))
    with pytest.raises(tp.SceneError, match="lies on"):
        tp.Scene(LAMP, [mesh, tp.Surface(other, tp.Black())])
    if not other.is_infinite:
        with pytest.raises(tp.SceneError, match="lies on"):
            tp.Scene([LAMP, tp.Source(other, tp.Lambertian(power=1.0))], [mesh])


@pytest.mark.parametrize("other", CLEAR.values(), ids=CLEAR)
def test_what_is_clear_of_its_faces_is_not(other):
    mesh = tp.Surface(CUBE, tp.Transparent(), "cube")
    tp.Scene(LAMP, [mesh], [tp.Detector("cube"), tp.Detector(other, "other")])


def test_it_takes_little_time_for_many_facets():
    fine = tp.Mesh.sphere(radius=1.0, triangles=100_000)
    shifted = fine.moved((0.1, 0, 0))
    begun = time.perf_counter()
    tp.Scene(
        LAMP,
        [tp.Surface(fine, tp.Diffuse(0.5))],
        [tp.Detector(shifted, "shifted"), tp.Detector(tp.Plane(), "cut")],
    )
    assert time.perf_counter() - begun < 10
