"""Bodies of media: which there are, and which of them hold a place; against inequalities written out here."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.body_scenes import AFAR, LAMP, M, T, V, can, corner, filled, lens
from transport.scene.bodies import (
    bodies_on_sides,
    body_bits_at,
    has_media,
    media_at,
    points_below_surface,
    points_in_body,
    scene_bodies,
    scene_media,
)


def test_nested_boxes_that_share_faces():
    """The cubes of (0, 10), (0, 50) and (0, 100) m: the innermost counts, in whatever order they are written."""
    sizes = {10.0: M(1), 50.0: V, 100.0: M(3)}
    for order in ((10, 50, 100), (100, 50, 10), (50, 100, 10)):
        scene = tp.Scene(LAMP, [filled(corner(size), sizes[size]) for size in order])
        assert [body.medium for body in scene_bodies(scene)] == [M(1), V, M(3)]
        assert [scene.surfaces[body.surfaces[0]].shape.size[0] for body in scene_bodies(scene)] == [
            10,
            50,
            100,
        ]
        for x, medium, bits in ((5, M(1), 7), (20, V, 6), (70, M(3), 4), (101, V, 0), (-1, V, 0)):
            assert scene.medium_at((x, 5, 5)) == medium
            assert body_bits_at(scene, [(x, 5, 5)]).tolist() == [bits]
        assert set(scene_media(scene)) == {V, M(1), M(3)} and scene_media(scene)[0] == V
        shared = [(0.0, 5, 5)] * 2
        assert body_bits_at(scene, shared, [(1, 0, 0), (-1, 0, 0)]).tolist() == [7, 0]


def test_each_kind_of_body_holds_what_its_inequality_says():
    """20000 places about five bodies beside one another; the walls of meshes are told by their winding number."""
    up = np.array([1.0, 2.0, -0.5]) / math.sqrt(5.25)
    ball = tp.Mesh.sphere(center=(4, 0, 0), radius=1, triangles=320)
    surfaces = [
        filled(tp.Sphere(radius=1.2), M(1)),
        filled(tp.Box(center=(0, 4, 0), size=(1, 2, 3)), M(2)),
        filled(ball, M(3)),
        *can(M(4), center=(-4, 0, 0)),
        filled(tp.Plane(center=7 * up, normal=-up), M(5)),
        filled(tp.Slab(center=-7 * up, normal=up, thickness=2), M(6)),
    ]
    scene = tp.Scene(AFAR, surfaces)
    r = np.random.default_rng(3).uniform(-8, 8, (20_000, 3))
    x, y, z = r.T
    expected = {
        M(1): x * x + y * y + z * z < 1.44,
        M(2): (abs(x) < 0.5) & (abs(y - 4) < 1) & (abs(z) < 1.5),
        M(3): ((ball.vertices[ball.faces[:, 0]][None] - r[:, None]) * ball.normals).sum(axis=2).min(axis=1)
        > 0,
        M(4): ((x + 4) ** 2 + y * y < 1) & (abs(z) < 1),
        M(5): r @ up > 7,
        M(6): abs(r @ up + 7) < 1,
    }
    found = np.array(media_at(scene, r))
    for medium, is_there in expected.items():
        assert is_there.sum() > 10 and ((found == medium) == is_there).all(), medium
    assert (found == V).sum() == len(r) - sum(is_there.sum() for is_there in expected.values())


def test_a_body_of_open_surfaces_with_a_bubble_and_a_twin():
    """Two cans of one medium are two bodies; one holds a bubble, a third can, whose walls name vacuum."""
    glass = M(index=1.5)
    wall = tp.Dielectric(1.5)
    scene = tp.Scene(
        AFAR,
        [*can(glass, wall), *can(V, tp.Dielectric(1, 1.5), radius=0.4), *can(glass, wall, center=(5, 0, 0))],
    )
    bodies = scene_bodies(scene)
    assert [body.medium for body in bodies] == [V, glass, glass]
    assert [body.surfaces for body in bodies] == [(3, 4, 5), (0, 1, 2), (6, 7, 8)]
    places = [(0, 0, 0), (0.3, 0, -0.3), (0.5, 0, 0), (0, 0, -0.99), (0, 0, 1.01), (5, 0.9, 0.9), (5, 0, 1.1)]
    assert media_at(scene, places) == [V, V, glass, glass, V, glass, V]
    assert bodies_on_sides(scene)[0] == ((), (1,)) and bodies_on_sides(scene)[3] == ((), (0,))


def test_what_is_named_outside_and_surrounds_a_body_is_no_body():
    scene = tp.Scene(LAMP, can(M(1), outside=V))
    assert [body.medium for body in scene_bodies(scene)] == [M(1)]
    scene = tp.Scene(LAMP, can(M(1), outside=M(0.1, 2)), medium=M(0.1, 2))
    assert [body.medium for body in scene_bodies(scene)] == [M(1)] and scene.medium_at((0, 0, 9)) == M(0.1, 2)


def test_what_a_plane_has_in_front_is_no_body_where_it_surrounds_all():
    scene = tp.Scene(LAMP, tp.Surface(tp.Plane(), T, back=M(1), front=V))
    assert [body.medium for body in scene_bodies(scene)] == [M(1)] and bodies_on_sides(scene) == [((), (0,))]


@pytest.mark.parametrize("kind", ["mesh", "can", "lens", "shell"])
def test_places_under_the_skin_of_a_body_are_within_it(kind):
    """By how far each is looked at: those beside the skin, 1e-6 further out, are not."""
    surfaces = {
        "mesh": [filled(tp.Mesh.sphere(radius=1), M(1))],
        "can": can(M(1)),
        "lens": lens(M(1), T),
        "shell": can(M(1)) + [tp.Surface(surface.shape, T, outside=M(1)) for surface in can(V, radius=0.5)],
    }[kind]
    scene = tp.Scene(AFAR, surfaces)
    [body] = scene_bodies(scene)
    places = points_below_surface(scene, body)
    assert len(places) >= 60 and points_in_body(scene, body, places).all()
    middle = np.array([0, 0, 0.95 if kind == "lens" else 0])
    assert not points_in_body(scene, body, middle + (places - middle) * (1 + 1e-6))[: len(places) // 2].any()


def test_sides_of_surfaces_say_which_bodies_they_bound():
    scene = tp.Scene(LAMP, [tp.Surface(tp.Plane(), T, back=M(1), front=M(2)), filled(corner(1), V)])
    assert scene_bodies(scene)[0].medium == V  # it lies in front of the plane
    media = [body.medium for body in scene_bodies(scene)]
    front, back = bodies_on_sides(scene)[0]
    assert [media[k] for k in front] == [M(2)] and [media[k] for k in back] == [M(1)]
    assert bodies_on_sides(scene)[1] == ((), (0,))
    assert scene.medium_at((0, 0, 2)) == M(2) and scene.medium_at((0, 0, -2)) == M(1)


def test_crossing_each_surface_leads_from_the_bodies_behind_to_those_ahead():
    """Along 300 lines: bits that change by what bodies_on_sides says are those that hold the place, in every gap."""
    from transport.geometry.line_crossings import crossings

    shapes = [corner(100), corner(50), corner(10), tp.Sphere(center=(75, 75, 75), radius=20)]
    surfaces = [filled(shape, M(k + 1)) for k, shape in enumerate(shapes)]
    surfaces += [
        *can(M(9), center=(-20, 0, 0), radius=5),
        tp.Surface(tp.Plane(center=(0, 0, -30)), T, inside=M(10)),
    ]
    scene, rng = tp.Scene(LAMP, surfaces), np.random.default_rng(5)
    sides = [[sum(1 << k for k in side) for side in pair] for pair in bodies_on_sides(scene)]
    u = rng.normal(size=(300, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    o = rng.uniform(-40, 110, (300, 3))
    found = [crossings(surface.shape, o, u) for surface in surfaces]
    for line in range(len(o)):
        events = sorted(
            (distance, number, way)
            for number, f in enumerate(found)
            for distance, way in zip(f.distances[line], f.sides[line], strict=True)
            if distance > 0
        )
        bits = int(body_bits_at(scene, o[line])[0])
        ends = [distance for distance, _, _ in [*events, (1e4, 0, 0)]][1:]
        for (distance, number, way), end in zip(events, ends, strict=True):
            front, back = sides[number]
            bits = (bits & ~back) | front if way > 0 else (bits & ~front) | back
            if end - distance > 1e-9:
                place = o[line] + (distance + end) / 2 * u[line]
                assert bits == body_bits_at(scene, place)[0]


def test_whether_a_scene_has_media():
    assert not has_media(tp.Scene(LAMP))
    assert not has_media(tp.Scene(LAMP, filled(corner(1), V), medium=V))
    assert not has_media(tp.Scene(LAMP, filled(corner(1), M(phase=tp.Rayleigh()))))
    assert not has_media(tp.Scene(AFAR, tp.Surface(corner(1), tp.Dielectric(1.5))))
    for medium in (M(1), M(0, 1), M(index=1.0000001), M(emission=1)):
        material = tp.Dielectric(medium.index) if medium.index != 1 else T
        assert has_media(tp.Scene(AFAR, filled(corner(1), medium, material)))
    assert has_media(tp.Scene(LAMP, medium=M(1)))


def test_a_position_is_three_numbers():
    with pytest.raises(tp.SceneError, match="position must be three finite numbers"):
        tp.Scene(LAMP).medium_at((1, 2))
