"""A body of open surfaces must be closed by surfaces that name its medium, whatever else lies across a gap."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np
import pytest

import transport as tp
from tests.body_scenes import LAMP, M, T, V, can, filled
from tests.refusals import assert_refused
from transport.scene.bodies import media_at

FOG = M(1.0, 2.0)


class Part(NamedTuple):
    """A shape, and whether the body is in front of it."""

    shape: tp.geometry.shape.Shape
    is_front: bool = False


def frame(rng) -> np.ndarray:
    """Three unit vectors (rows) turned by chance."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q


def disk(rng, center, out, radius, inner=0.0) -> Part:
    """A disk across `out`, which leads out of the body; its normal is along that or against it."""
    sign = rng.choice([-1.0, 1.0])
    return Part(tp.Disk(center=center, normal=sign * out, radius=radius, inner_radius=inner), sign < 0)


def box(rng, size) -> list[Part]:
    axes, half = frame(rng), size * rng.uniform(0.3, 1, 3) / 2
    parts = []
    for k, out in ((k, sign * axes[k]) for k in range(3) for sign in (-1, 1)):
        sign, wide, high = rng.choice([-1.0, 1.0]), (k + 1) % 3, (k + 2) % 3
        sides = {"width": 2 * half[wide], "height": 2 * half[high], "up": axes[high]}
        parts.append(Part(tp.Rectangle(center=half[k] * out, normal=sign * out, **sides), sign < 0))
    return parts


def tin(rng, size) -> list[Part]:
    axis, radius, height = frame(rng)[0], size * rng.uniform(0.1, 0.5), size * rng.uniform(0.1, 1)
    lids = [disk(rng, s * height / 2 * axis, s * axis, radius) for s in (-1, 1)]
    return [Part(tp.Cylinder(axis=axis, radius=radius, height=height)), *lids]


def pipe(rng, size) -> list[Part]:
    axis, inner, outer, height = (
        frame(rng)[0],
        0.2 * size,
        size * rng.uniform(0.3, 0.5),
        size * rng.uniform(0.2, 1),
    )
    walls = [
        Part(tp.Cylinder(axis=axis, radius=radius, height=height), radius == inner)
        for radius in (inner, outer)
    ]
    return [*walls, *(disk(rng, s * height / 2 * axis, s * axis, outer, inner) for s in (-1, 1))]


def bucket(rng, size) -> list[Part]:
    axis, height, radii = frame(rng)[0], size * rng.uniform(0.2, 1), size * rng.uniform(0.1, 0.5, 2)
    wall = tp.Cone(axis=axis, radius=radii[0], top_radius=radii[1], height=height)
    lids = [disk(rng, s * height / 2 * axis, s * axis, r) for s, r in zip((-1, 1), radii, strict=True)]
    return [Part(wall), *lids]


def dish(rng, size) -> list[Part]:
    axis, radius, focal_length = frame(rng)[0], size * rng.uniform(0.2, 0.5), size * rng.uniform(0.1, 0.5)
    depth = radius * radius / (4 * focal_length)
    wall = tp.Paraboloid(center=-depth / 2 * axis, axis=axis, radius=radius, focal_length=focal_length)
    return [Part(wall), disk(rng, depth / 2 * axis, axis, radius)]


def cap(rng, size) -> list[Part]:
    axis, radius, mu = frame(rng)[0], size / 2, rng.uniform(-0.8, 0.8)
    flat = disk(rng, mu * radius * axis, -axis, radius * math.sqrt(1 - mu * mu))
    return [Part(tp.Sphere(radius=radius, axis=axis, mu_min=mu)), flat]


def lens(rng, size) -> list[Part]:
    axis, radius, mu = frame(rng)[0], size / 2, rng.uniform(0.2, 0.9)
    return [
        Part(tp.Sphere(center=-s * mu * radius * axis, radius=radius, axis=s * axis, mu_min=mu))
        for s in (-1, 1)
    ]


def shards(rng, size) -> list[Part]:
    """A ball of triangles in two meshes, of which one may be turned inside out."""
    ball = tp.Mesh.sphere(radius=size / 2, triangles=20)
    is_one = (ball.vertices[ball.faces].mean(axis=1) @ frame(rng)[0]) > size * rng.uniform(-0.2, 0.2)
    turned = rng.random() < 0.5
    one, other = (tp.Mesh(vertices=ball.vertices, faces=ball.faces[chosen]) for chosen in (is_one, ~is_one))
    return [Part(one.flipped() if turned else one, turned), Part(other)]


KINDS = [box, tin, pipe, bucket, dish, cap, lens, shards]
BODIES = [(kind, seed) for kind in KINDS for seed in range(1 if kind is shards else 3)]
MATERIALS = [T, tp.Diffuse(0.5), tp.Black(), tp.Mirror(0.5, 0.25)]


def surfaces(parts: list[Part], medium, bare: int | None = None, material=T) -> list[tp.Surface]:
    """The surfaces of a body, of which one may name no medium."""
    made = []
    for k, (shape, is_front) in enumerate(parts):
        named = {} if k == bare else {"front" if is_front else "back": medium}
        made.append(tp.Surface(shape, material if k == bare else T, f"part {k}", **named))
    return made


def neighbours(rng, size) -> list[tp.Surface]:
    """A ball within every body, what lies far about it, and bodies beside it that touch one another."""
    beside = tp.Box(center=(0, 0, 2 * size), size=size)
    return [
        filled(tp.Sphere(radius=0.01 * size), M(3.0)),
        filled(tp.Box(size=9 * size), M(0.1)),
        filled(beside, M(4.0)),
        filled(tp.Box(center=(size, 0, 2 * size), size=size), M(5.0)),
        *(tp.Surface(face, T, back=M(6.0)) for face in tp.Box(center=(-size, 0, 2 * size), size=size).faces().values()),
        *can(M(6.0), center=(0, 0, -2 * size), radius=size / 4),
        tp.Surface(tp.Rectangle(center=(0, 0, 3 * size), width=size, height=size), T, "bare beside"),
    ]  # fmt: skip


@pytest.mark.parametrize(("kind", "seed"), BODIES, ids=lambda value: getattr(value, "__name__", value))
def test_whole_bodies_are_accepted_and_each_part_without_its_medium_is_named(kind, seed):
    """Each of a body's parts in turn without media, its normal either way; alone, and among nested and touching bodies."""
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    size = 10.0 ** rng.integers(-6, 7)
    parts = kind(rng, size)
    lamp = tp.Source(tp.Point(position=(0, 0, 6 * size)), tp.Isotropic(power=1))
    for others in ([], neighbours(rng, size)):
        order = rng.permutation(len(parts) + len(others))
        tp.Scene(lamp, [[*surfaces(parts, FOG), *others][k] for k in order])
        for bare, (_, is_front) in enumerate(parts):
            open_body = [*surfaces(parts, FOG, bare, MATERIALS[rng.integers(len(MATERIALS))]), *others]
            with pytest.raises(tp.SceneError) as caught:
                tp.Scene(lamp, [open_body[k] for k in order])
            side = "front" if is_front else "back"
            assert f"give Surface 'part {bare}' {side}={FOG!r}" in str(caught.value)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_the_place_that_a_refusal_names_is_on_the_surface_that_it_names(kind):
    rng = np.random.default_rng(KINDS.index(kind))
    parts = kind(rng, 1.0)
    for bare, (shape, _) in enumerate(parts):
        with pytest.raises(tp.SceneError) as caught:
            tp.Scene(LAMP, surfaces(parts, FOG, bare))
        place = [float(x) for x in re.search(r"at \((.*?)\)", str(caught.value))[1].split(", ")]
        assert shape.distance(tuple(place)) < 1e-5


def test_a_hemisphere_on_a_disk_that_names_nothing():
    dome = tp.Surface(tp.Sphere(radius=1, mu_min=0), T, "cap", inside=FOG)
    for z, side in ((1, "front"), (-1, "back")):
        floor = tp.Disk(normal=(0, 0, z), radius=1)
        with pytest.raises(
            tp.SceneError, match=rf"bounded by Surface 'cap'.*got None; give Surface 'd' {side}=Medium"
        ):
            tp.Scene(LAMP, [dome, tp.Surface(floor, T, "d")])
        tp.Scene(LAMP, [dome, tp.Surface(floor, T, "d", **{side: FOG})])


@pytest.mark.parametrize(
    "across", [tp.Plane(), tp.Plane(normal=(0, 0, -1)), tp.Box(center=(0, 0, -2), size=4)]
)
@pytest.mark.parametrize("inside", [None, FOG])
def test_a_dome_on_a_plane_or_a_box_wants_a_floor_of_its_own(across, inside):
    """Also where the plane has the same medium below it: the fog of a dome that is left through it would go along."""
    dome = tp.Surface(tp.Sphere(radius=1, mu_min=0), T, "dome", inside=FOG)
    if inside is not None and isinstance(across, tp.Plane) and across.normal[2] < 0:
        across = tp.Plane()
    ground = tp.Surface(across, T, "ground", inside=inside)
    with pytest.raises(
        tp.SceneError,
        match=r"'dome': back must .*'ground' does not bound the body there; put a Transparent.. Disk",
    ):
        tp.Scene(LAMP, [dome, ground])
    floor = tp.Surface(tp.Disk(normal=(0, 0, -1), radius=1), T, inside=FOG)
    scene = tp.Scene(LAMP, [dome, ground, floor])
    assert media_at(scene, [(0, 0, 0.5), (0, 0, -0.5), (2, 0, 0.5)]) == [FOG, inside or V, V]


REFUSED = {
    "can without a lid": (can(FOG)[:2], ["surfaces[", "back must bound a closed body", "to nothing", "close the gaps"]),
    "can with a turned lid": (
        [*can(FOG)[:2], filled(tp.Disk(center=(0, 0, -1), radius=1), FOG)],
        ["surfaces[2]: back", "reverse its normal, or write front instead of back"],
    ),
    "can with a lid that is too small": (
        [*can(FOG)[:2], filled(tp.Disk(center=(0, 0, -1), normal=(0, 0, -1), radius=0.9), FOG)], ["back must bound", "close the gaps"]
    ),
    "can with a lid that is too large": (
        [*can(FOG)[:2], filled(tp.Disk(center=(0, 0, -1), normal=(0, 0, -1), radius=1.1), FOG)], ["back must bound", "close the gaps"]
    ),
    "can with a lid of another medium": (
        [*can(FOG)[:2], filled(tp.Disk(center=(0, 0, -1), normal=(0, 0, -1), radius=1), M(7.0), name="lid")], ["Medium(absorption=7.0)"]
    ),
    "fog round a can that nothing else has": (can(None, outside=FOG), ["front must bound a closed body"]),
    "a sheet with a medium": (filled(tp.Rectangle(width=1, height=1), FOG), ["back must bound a closed body", "close the gaps"]),
    "a ball of triangles that is turned inside out": (filled(tp.Mesh.sphere(radius=1).flipped(), FOG), ["reverse its normal"]),
    "two cans on one another": ([*can(FOG), *can(FOG, center=(0, 0, 2))], ["surfaces[1] and surfaces[5] must not lie back to back", "leave both out"]),
    "a small can on a large one": ([*can(FOG), *can(FOG, center=(0, 0, 1.5), radius=0.5)], ["back to back", "a hole"]),
    "two cans that overlap": ([*can(FOG), *can(FOG, center=(0, 0, 1))], ["overlap or are nested, make them one"]),
    "a can in a can": ([*can(FOG), *can(FOG, radius=0.5)], ["overlap or are nested, make them one"]),
    "a flask whose walls say what is inside only": (
        [*can(FOG, radius=4), *can(V, radius=3), *can(FOG, radius=2), *can(V, radius=1)], ["surfaces[6]: front must be Vacuum()", "give surfaces[6] front=Vacuum()"]
    ),
}  # fmt: skip


@pytest.mark.parametrize(("parts", "words"), REFUSED.values(), ids=REFUSED)
def test_what_does_not_close_a_body_is_refused(parts, words):
    assert_refused(lambda: tp.Scene(LAMP, parts), words)


def test_what_a_back_to_back_refusal_asks_for_is_one_body():
    low, high = can(FOG), can(FOG, center=(0, 0, 2))
    scene = tp.Scene(LAMP, [low[0], low[2], high[0], high[1]])
    assert media_at(scene, [(0, 0, 0.99), (0, 0, 1.01), (0, 0, 3.1)]) == [FOG, FOG, V]


def test_a_flask_whose_walls_name_both_of_their_sides():
    """Glass, a gap, glass and what is in it: each medium's surfaces take turns along any line."""
    sides = [(4, FOG, None), (3, V, FOG), (2, FOG, V), (1, V, FOG)]
    flask = [
        surface
        for radius, inside, outside in sides
        for surface in can(inside, radius=radius, outside=outside)
    ]
    scene = tp.Scene(tp.Source(tp.Point(position=(0, 0, 9)), tp.Isotropic(power=1)), flask)
    assert media_at(scene, [(0, 0, z) for z in (0.5, 1.5, 2.5, 3.5, 4.5)]) == [V, FOG, V, FOG, V]
