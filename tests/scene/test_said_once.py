"""What is said once: indices by the media, names of media, coordinates by their own names, shapes through one another."""

from __future__ import annotations

import json
from dataclasses import replace

import jsonschema
import pytest

import transport as tp
from transport.io.json.codec import fields_to_json
from transport.io.json.differences import differences
from transport.io.json.schema import schema
from transport.viz.screen import has_screen

LAMP = tp.Source(tp.Point(position=(0, 0, 5)), tp.Isotropic(power=1.0))
GLASS = tp.Medium(index=1.5, absorption=0.1, name="glass")
WATER = tp.Medium(index=1.33, absorption=0.5, name="water")


def ball(radius, name, inside, material=tp.Dielectric()):  # noqa: B008
    return tp.Surface(tp.Sphere(radius=radius), material, name, inside=inside)


def test_a_dielectric_takes_its_indices_from_the_media_beside_it():
    surfaces = [
        ball(1.0, "outer", GLASS),
        ball(0.8, "inner", WATER),
        tp.Surface(tp.Plane(center=(0, 0, -2)), tp.Dielectric(), "sea", back=WATER),
    ]
    scene = tp.Scene(LAMP, surfaces)
    found = {each.name: each.material for each in scene.surfaces}
    assert found == {
        "outer": tp.Dielectric(1.5, 1.0), "inner": tp.Dielectric(1.33, 1.5), "sea": tp.Dielectric(1.33, 1.0),
    }  # fmt: skip
    assert tp.Scene.from_json(scene.to_json()) == scene
    said = [
        ball(1.0, "outer", GLASS, tp.Dielectric(1.5)),
        ball(0.8, "inner", WATER, tp.Dielectric(1.33, 1.5)),
    ]
    assert tp.Scene(LAMP, surfaces[:2]) == tp.Scene(LAMP, said)


@pytest.mark.parametrize(
    ("surfaces", "words"),
    [
        ([ball(1.0, "ball", None)], "Surface 'ball': Dielectric.. takes its indices .* got 1 on both sides; name its medium"),
        ([ball(1.0, "ball", tp.Medium(absorption=1.0))], "got 1 on both sides; give its medium an index, such as index=1.5"),
        ([ball(1.0, "ball", tp.Medium(absorption=1.0), tp.Dielectric(1.5))], "Medium.absorption=1.0. of index 1, .*; give that medium index=1.5"),
        ([ball(1.0, "ball", GLASS), tp.Surface(tp.Rectangle(width=4, height=4), tp.Dielectric(), "plate")],
         "Surface 'plate': Dielectric.. takes its indices .* on one side; write Dielectric"),
        ([ball(1.0, "ball", GLASS, tp.Mixture({tp.Dielectric(): 0.5, tp.Mirror(): 0.5}))],
         "Surface 'ball': a Mixture must not hold a Dielectric without indices"),
        ([ball(1.0, "ball", GLASS, tp.Dielectric(1.6))], "Surface 'ball': Dielectric.* contradicts the medium inside"),
    ],
)  # fmt: skip
def test_indices_that_nobody_knows_are_refused(surfaces, words):
    with pytest.raises(tp.SceneError, match=words):
        tp.Scene(LAMP, surfaces)


def test_the_energy_balance_names_media():
    surfaces = [
        ball(1.0, "outer", GLASS),
        ball(0.5, "inner", WATER),
        tp.Surface(tp.Sphere(center=(3, 0, 0), radius=0.5), tp.Dielectric(), "glass", inside=WATER),
        tp.Surface(tp.Sphere(center=(-3, 0, 0), radius=0.5), tp.Dielectric(1.2), "other", inside=tp.Medium(index=1.2, absorption=1)),
    ]  # fmt: skip
    result = tp.simulate(tp.Scene(LAMP, surfaces), particles=20_000, seed=1, progress=False)
    parts = result.ledger.absorbed_by
    assert {"water", "medium glass", "inside other"} <= set(parts) and "inside inner" not in parts
    assert sum(float(each.value) for each in parts.values()) == pytest.approx(
        float(result.ledger["absorbed"].value)
    )
    lines = str(result.ledger).splitlines()
    assert (
        len(
            {line.index("(") for line in lines if "(" in line and "exact" not in line and "score" not in line}
        )
        == 1
    )
    with pytest.raises(tp.SceneError, match="Medium: name must be text"):
        tp.Medium(name=3)


@pytest.mark.parametrize(
    ("shape", "names"),
    [
        (tp.Rectangle(width=2, height=1), ("x", "y")),
        (tp.Disk(radius=1), ("radius", "azimuth")),
        (tp.Sphere(radius=1), ("polar_angle", "azimuth")),
        (tp.Cylinder(radius=1, height=2), ("height", "azimuth")),
    ],
)
def test_coordinates_have_names_of_their_own(shape, names):
    own, plain = tp.Positions(**dict(zip(names, (3, 2), strict=True))), tp.Positions(u=3, v=2)
    assert [e.tolist() for e in own.edges(shape).values()] == [
        e.tolist() for e in plain.edges(shape).values()
    ]
    assert (
        repr(own) == f"Positions({names[0]}=3, {names[1]}=2)"
        and eval(repr(own), {"Positions": tp.Positions}) == own
    )
    detector = tp.Detector(shape, "d", positions=own)
    scene = tp.Scene(LAMP, detectors=detector)
    assert tp.Scene.from_json(scene.to_json()) == scene
    wrong = {"x", "radius", "polar_angle", "height"} - {names[0]}
    for name in wrong:
        with pytest.raises(
            tp.SceneError, match=f"a {type(shape).__name__} has no {name}, got {name}=3; write {names[0]}="
        ):
            tp.Scene(LAMP, detectors=tp.Detector(shape, "d", positions=tp.Positions(**{name: 3})))


SPELLINGS = [("x", "y"), ("radius", "azimuth"), ("height", "azimuth"), ("polar_angle", "azimuth")]


@pytest.mark.parametrize("names", SPELLINGS, ids=map("-".join, SPELLINGS))
@pytest.mark.parametrize("bins", [(2, 3), ((0.0, 0.1, 0.2), 3), (2, None), (None, (0.1, 0.2))], ids=str)
def test_positions_are_equal_by_whatever_names(names, bins):
    own, plain = tp.Positions(**dict(zip(names, bins, strict=True))), tp.Positions(u=bins[0], v=bins[1])
    assert own == plain and hash(own) == hash(plain) and differences(own, plain) == []
    assert (own.u, own.v) == bins
    written = fields_to_json(own)
    assert written == fields_to_json(plain) and set(written) <= {"type", "u", "v"}
    assert own != tp.Positions(**dict(zip(names, (2, 4), strict=True)))


@pytest.mark.parametrize(
    ("changes", "called"),
    [
        ({}, "x=2, y=3"),
        ({"x": 5}, "x=5, y=3"),
        ({"u": 5}, "u=5, y=3"),
        ({"radius": 5, "v": (0, 1)}, "radius=5, v=(0.0, 1.0)"),
        ({"y": [0, 1]}, "x=2, y=(0.0, 1.0)"),
        ({"u": None}, "y=3"),
        ({"y": None}, "x=2"),
    ],
    ids=str,
)
@pytest.mark.parametrize("is_plain", [False, True])
def test_positions_are_replaced_by_any_name(changes, called, is_plain):
    before = tp.Positions(u=2, v=3) if is_plain else tp.Positions(x=2, y=3)
    after = replace(before, **changes)
    assert after == eval(f"tp.Positions({called})", {"tp": tp})
    assert is_plain or repr(after) == f"Positions({called})"


def test_two_names_of_a_replaced_coordinate_are_refused():
    for given in ({"u": 5, "x": 6}, {"x": 5, "radius": 6}):
        with pytest.raises(tp.SceneError, match="are one coordinate"):
            replace(tp.Positions(x=2, y=3), **given)


def test_a_file_with_both_names_of_a_coordinate_is_read():
    """As files were written before."""
    scene = tp.Scene(
        LAMP, detectors=tp.Detector(tp.Disk(radius=1), "d", positions=tp.Positions(radius=3, azimuth=2))
    )
    plain, old = '"u": 3, "v": 2', '"u": 3, "v": 2, "radius": 3, "azimuth": 2'
    text = scene.to_json()
    assert text.count(plain) == 1
    for names in (plain, old, '"radius": 3, "azimuth": 2'):
        data = text.replace(plain, names)
        assert tp.Scene.from_json(data) == scene
        jsonschema.validate(json.loads(data), schema())
    with pytest.raises(tp.SceneError, match="are one coordinate"):
        tp.Scene.from_json(text.replace(plain, '"u": 3, "radius": 4'))


def test_one_coordinate_under_two_names_is_refused():
    for given in ({"u": 3, "x": 4}, {"x": 3, "radius": 3}):
        with pytest.raises(tp.SceneError, match="are one coordinate"):
            tp.Positions(**given)


@pytest.mark.parametrize(
    ("shapes", "is_named"),
    [
        ((tp.Box(size=2.0), tp.Sphere(center=(1, 0, 0), radius=0.5)), True),
        ((tp.Box(size=2.0), tp.Box(center=(1, 0.3, 0.2), size=1.0)), True),
        ((tp.Box(size=2.0), tp.Sphere(radius=0.5)), False),
        ((tp.Box(size=2.0), tp.Box(center=(2, 0, 0), size=2.0)), False),
        ((tp.Box(size=2.0), tp.Box(center=(0, 0, -0.5), size=1.0)), False),
    ],
)
def test_shapes_that_stand_through_one_another_are_named(shapes, is_named):
    surfaces = [tp.Surface(shape, tp.Diffuse(0.5), f"s{k}") for k, shape in enumerate(shapes)]
    result = tp.simulate(tp.Scene(LAMP, surfaces), particles=100, seed=1, progress=False)
    assert (
        any("'s0' and Surface 's1' stand through one another" in each for each in result.warnings) == is_named
    )


PANEL = {"width": 1.0, "height": 0.4}
ROOM, TUBE = tp.Box(size=2.0), tp.Cylinder(radius=1.0, height=2.0)
SCREEN = tp.Rectangle(normal=(1, 0, 0), width=0.3, height=0.3)
BALL_OF_FACETS = tp.Mesh.sphere(radius=0.5, triangles=180)


@pytest.mark.parametrize(
    ("lamp", "wall", "is_named"),
    [
        (tp.Rectangle(center=(0.9, 0, 0.5), **PANEL), ROOM, True),
        (tp.Rectangle(center=(0.5, 0, 0.5), **PANEL), ROOM, False),  # touches the wall with its edge
        (tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), **PANEL), ROOM, False),  # on the ceiling
        (tp.Rectangle(center=(0, 0, -1), width=3, height=3), ROOM, False),  # the walls stand on it
        (tp.Rectangle(width=1, height=1), SCREEN, True),  # the screen stands within the lamp
        (tp.Rectangle(width=1, height=1, hole=tp.Rectangle(width=0.4, height=0.4)), SCREEN, False),
        (tp.Disk(radius=0.5), tp.Plane(center=(0.1, 0, 0), normal=(1, 0, 1)), True),
        (tp.Disk(center=(0, 0, -1), radius=1.0), TUBE, False),  # closes the tube
        (tp.Disk(center=(0, 0, -1), radius=1.5), TUBE, False),
        (tp.Disk(radius=1.5), TUBE, True),
        (tp.Sphere(center=(1, 0, 0), radius=0.1), ROOM, True),
        (tp.Sphere(center=(0.9, 0, 0), radius=0.1), ROOM, False),  # touches the wall
        (tp.Sphere(center=(1, 0, 0), radius=0.1), tp.Sphere(radius=1.0), True),
        (tp.Sphere(radius=1.0), ROOM, False),
        (tp.Box(center=(0, 0, 0.9), size=(0.2, 0.2, 0.2)), ROOM, False),  # hangs on the ceiling
        (tp.Box(center=(0, 0, 1), size=(0.2, 0.2, 0.2)), ROOM, True),
        (tp.Mesh.sphere(center=(0.91, 0, 0), radius=0.1), ROOM, True),  # 1 % of it is behind the wall
        (tp.Mesh.sphere(center=(0.9, 0, 0), radius=0.1), ROOM, False),
        (BALL_OF_FACETS, BALL_OF_FACETS.moved((0.03, 0.05, 0.1)), True),
        (BALL_OF_FACETS, BALL_OF_FACETS, False),  # lies on the wall
        (BALL_OF_FACETS, tp.Sphere(radius=0.5), False),  # touches the wall with its vertices
        (BALL_OF_FACETS, tp.Rectangle(center=(0, 0, 0.47), width=1, height=1), True),
    ],
)
def test_a_lamp_through_an_opaque_wall_is_named(lamp, wall, is_named):
    source = tp.Source(lamp, tp.Lambertian(power=40.0))
    walls = [tp.Surface(wall, tp.Diffuse(0.5), "wall")]
    result = tp.simulate(tp.Scene(source, walls), particles=100, seed=1, progress=False)
    words = "sources[0] passes through the opaque Surface 'wall': a part of its power is emitted behind"
    assert any(words in each for each in result.warnings) == is_named


@pytest.mark.parametrize(
    ("lamp", "material"),
    [
        (tp.Source(tp.Rectangle(center=(0.9, 0, 0), **PANEL), tp.Lambertian(power=1.0)), tp.Transparent()),
        (tp.Source("wall", tp.Lambertian(power=1.0), side="inside"), tp.Diffuse(0.5)),
        (tp.Source(tp.Box(center=(1, 0, 0), size=0.5), tp.Isotropic(power=1.0)), tp.Diffuse(0.5)),
    ],
    ids=["clear wall", "the wall itself", "volume"],
)
def test_a_source_that_may_stand_in_a_wall_is_not_named(lamp, material):
    meter = tp.Detector(tp.Disk(center=(1, 0, 0), radius=0.5), "meter")
    scene = tp.Scene(lamp, [tp.Surface(ROOM, material, "wall")], meter)
    result = tp.simulate(scene, particles=100, seed=1, progress=False)
    assert not any("passes through" in each for each in result.warnings)


def test_a_scene_is_written_as_a_page_and_a_picture(tmp_path):
    pytest.importorskip("pyvista")
    scene = tp.Scene(LAMP, tp.Surface(tp.Box(size=2.0), tp.Diffuse(0.5), "box"))
    assert scene.view(tmp_path / "scene.html").stat().st_size > 10_000
    if has_screen():
        assert scene.view(tmp_path / "scene.png").stat().st_size > 5_000
