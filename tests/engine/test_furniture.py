"""Boxes that stand on a floor, against a wall, on and in one another: on each side of a shared plane one surface acts.

The same without contact, a millionth of their size apart, must give the same; and where every surface sends on what it does not absorb,
radiance is the same everywhere.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from tests.tracking_scenes import assert_closed
from transport.compile.compiler import compile_scene

ROOM = tp.Box(center=(0, 0, 1.25), size=(4, 5, 2.5))
CUPBOARD = tp.Box(center=(0.3, -0.4, 0.5), size=(1.0, 0.8, 1.0))
LAMP = tp.Source(tp.Disk(center=(1, 1, 2.2), normal=(0, 0, -1), radius=0.2), tp.Lambertian(power=10.0))
METER = tp.Detector(tp.Disk(center=(1.2, 0.8, 0.4), radius=0.2), "meter")
ALBEDO = 0.5


def surface(shape, name, albedo=ALBEDO):
    return tp.Surface(shape, tp.Diffuse(albedo), name)


def run(scene, particles=200_000, **how):
    return tp.simulate(scene, particles, seed=1, progress=False, **how)


def raised(box, by):
    x, y, z = box.center
    return tp.Box(center=(x, y, z + by), size=box.size)


FLOORS = {
    "room": ROOM,
    "rectangle": tp.Rectangle(width=4, height=5),
    "disk": tp.Disk(radius=3),
    "holed": tp.Rectangle(width=4, height=5, hole=tp.Disk(center=(1.5, 2, 0), radius=0.3)),
    "polygon": tp.Polygon(vertices=[(-2, -3, 0), (3, -3, 0), (3, 3, 0), (0, 2, 0), (-2, 3, 0)]),
    "plane": tp.Plane(normal=(0, 0, 1)),
    "overhung": tp.Rectangle(center=(0, -0.4, 0), width=0.6, height=2),
    "turned": tp.Rectangle(width=4, height=5, normal=(0, 0, -1)),
}


def meters(names):
    """Detectors of both sides of these surfaces."""
    return [tp.Detector(name, f"{name}, {side}", side=side) for name in names for side in ("front", "back")]


@pytest.mark.parametrize("floor", FLOORS)
def test_a_box_stands_on_a_floor_as_if_a_gap_were_beneath_it(floor):
    """Light within the box, too, and from below: all sides of both."""
    places = {"above": (1.4, 1.2, 1.5), "within": (0.3, -0.4, 0.3), "below": (0.3, -0.4, -1)}
    sources = [tp.Source(tp.Point(position=place), tp.Isotropic(power=1.0)) for place in places.values()]
    names = ("box",) if floor == "plane" else ("box", "floor")
    found = []
    for gap in (0.0, 1e-6):
        surfaces = [surface(FLOORS[floor], "floor"), surface(raised(CUPBOARD, gap), "box", 0.3)]
        found.append(run(tp.Scene(sources, surfaces, [METER, *meters(names)])))
        assert_closed(found[-1])
        assert found[-1].ledger["lost"].value == 0
    for name in ("meter", *(each.name for each in meters(names))):
        shared, apart = (result[name].flux_in for result in found)
        assert apart.value > 0 or shared.value == 0
        if apart.value > 0:
            assert_agrees(shared / apart, 1.0)


def test_within_a_box_on_a_floor_the_box_acts_and_beneath_it_the_floor():
    """A black box on a white floor, with a lamp inside, or one below: nothing is reflected, or nine tenths.

    Rounding puts the bottom of the box below the floor.
    """
    height = 0.7
    box = tp.Box(center=(0.3, -0.4, height + 0.35), size=(1.0, 0.8, 0.7))
    assert box.bounds[0][2] < height
    floor = tp.Rectangle(center=(0, 0, height), width=4, height=5)
    surfaces = [surface(floor, "floor", 0.9), surface(box, "box", 0.0)]
    for place, met, missed, share in (
        ((0.3, -0.4, 0.9), "box, back", "floor, front", 0.0),
        ((0.3, -0.4, 0.699), "floor, back", "box, front", 0.9),
    ):
        lamp = tp.Source(tp.Point(position=place), tp.Isotropic(power=1.0))
        result = run(tp.Scene(lamp, surfaces, meters(("floor", "box"))), 10_000)
        assert result[missed].flux_in.value == 0
        assert float(result[met].flux_in.value) > 0.45
        assert float(result[met].flux_out.value) == pytest.approx(
            share * float(result[met].flux_in.value), rel=1e-9
        )


STANDING = {
    "on the floor": [CUPBOARD],
    "in a corner": [tp.Box(center=(-1.5, -2.0, 0.75), size=(1, 1, 1.5))],
    "from floor to ceiling": [tp.Box(center=(1.5, 0, 1.25), size=(1, 1, 2.5))],
    "on one another": [CUPBOARD, tp.Box(center=(0.5, -0.4, 1.2), size=(0.4, 1.2, 0.4))],
    "side by side": [CUPBOARD, tp.Box(center=(1.3, -0.4, 0.5), size=(1.0, 0.5, 0.7)), tp.Box(center=(0.3, 0.5, 0.3), size=(1, 1, 0.6))],
    "all": [
        CUPBOARD, tp.Box(center=(0.5, -0.4, 1.2), size=(0.4, 1.2, 0.4)), tp.Box(center=(1.3, -0.4, 0.5), size=(1.0, 0.5, 0.7)),
        tp.Box(center=(-1.5, -2.0, 0.75), size=(1, 1, 1.5)), tp.Box(center=(1.75, 2, 1.25), size=(0.5, 1, 2.5)),
    ],
}  # fmt: skip
CAMERA = tp.Camera(
    name="view", position=(-1.4, 1.9, 2.2), look_at=(0.5, -0.5, 0.5), field_of_view=1.2, pixels=(6, 4)
)
MAP = tp.EnvironmentMap(name="map", position=(-0.9, 1.1, 0.7), theta=4, phi=6)


def furnished(boxes, instruments):
    """A room whose surfaces all send on what they do not absorb: radiance is 1 in each direction, wherever light comes."""
    surfaces = [surface(ROOM, "room"), *(surface(box, f"box {k}") for k, box in enumerate(boxes))]
    sources = [
        tp.Source(
            each.name, tp.Lambertian(radiance=1 - ALBEDO), side="back" if each.name == "room" else "front"
        )
        for each in surfaces
    ]
    return tp.Scene(sources, surfaces, instruments)


@pytest.mark.parametrize("boxes", STANDING.values(), ids=STANDING)
def test_radiance_is_the_same_everywhere_in_a_furnished_room(boxes):
    result = run(furnished(boxes, [CAMERA, MAP]), 100_000)
    for name in ("view", "map"):
        assert_agrees(result[name].radiance, 1.0)
    whole = result["view"].radiance.sum("u").sum("v") / 24
    assert_agrees(whole, 1.0)
    assert_rejected(whole, 0.97)
    forward = furnished(boxes, [METER, tp.Detector("room", "walls", side="back")])
    for estimator in ("analog", "expected"):
        result = run(forward, estimator=estimator)
        assert_agrees(result["meter"].irradiance, math.pi)
        assert_closed(result)
        assert result.ledger["lost"].value == result.ledger["escaped"].value == 0
    # What comes to the walls, but for what a box covers.
    exposed = ROOM.area - sum(touching_area(box, ROOM) for box in boxes)
    assert_agrees(result["walls"].flux_in, math.pi * exposed)


def touching_area(box, room):
    """Area of the faces of a box that lie on those of a room."""
    faces = zip(box.faces().values(), room.faces().values(), strict=True)
    return sum(
        one.area
        for one, other in faces
        if math.isclose(*(float(np.dot(each.center, each.normal)) for each in (one, other)), abs_tol=1e-12)
    )


@pytest.mark.parametrize("estimator", ["analog", "expected", "backward"])
def test_the_covered_part_of_a_floor_receives_nothing(estimator):
    """Though the box is lit within. Planted: births beneath it that go on; "backward" then counts what is within."""
    positions = tp.Positions(u=8, v=10)
    floor = tp.Surface(FLOORS["rectangle"], tp.Diffuse(0.0), "floor")
    box = tp.Box(center=(0.5, 0.0, 0.5), size=(1.0, 1.0, 1.0))
    within = tp.Source(tp.Sphere(center=(0.5, 0, 0.5), radius=0.1), tp.Lambertian(power=10.0))
    scene = tp.Scene(
        [LAMP, within], [floor, surface(box, "box")], tp.Detector("floor", "on floor", positions=positions)
    )
    irradiance = run(scene, estimator=estimator)["on floor"].irradiance
    covered = irradiance.value[4:6, 4:6]
    assert (covered == 0).all() and (irradiance.value > 0).sum() > 60


def test_what_a_covered_surface_emits_is_absorbed_by_what_covers_it():
    box = tp.Box(center=(0.0, 0.0, 0.5), size=(1.0, 1.0, 1.0))
    floor = tp.Surface(tp.Rectangle(width=2, height=2), tp.Black(), "floor")
    source = tp.Source("floor", tp.Lambertian(power=4.0), aim=tp.Sphere(center=(0, 0, 3), radius=0.5))
    for aim in (None, source.aim):
        scene = tp.Scene(
            tp.Source("floor", source.emission, aim=aim), [floor, surface(box, "box", 0.0)], meters(("box",))
        )
        result = run(scene)
        assert_closed(result)
        if aim is None:
            assert_agrees(result.ledger["absorbed"] - result["box, front"].flux_in, 1.0)
        assert result["box, back"].flux_in.value == 0


def test_a_birth_departs_from_the_surface_that_acts_where_it_is_born():
    """A cupboard that glows within does not light the floor beneath it; of a lamp that lies half in it, half does.

    Planted: births that count at all surfaces of a shared plane.
    """
    box = tp.Surface(tp.Box(center=(0.0, 0.0, 0.5), size=(1.0, 1.0, 1.0)), tp.Black(), "box")
    floor = tp.Surface(FLOORS["rectangle"], tp.Black(), "floor")
    glow = tp.Source("box", tp.Lambertian(power=6.0), side="back")
    half = tp.Source(tp.Rectangle(center=(0.5, 0, 0), width=0.4, height=0.4), tp.Lambertian(power=1.0))
    within = tp.Source(tp.Disk(radius=0.4), tp.Lambertian(power=1.0))
    for source, from_floor, from_box in ((glow, 0.0, 6.0), (half, 0.5, 0.5), (within, 0.0, 1.0)):
        result = run(tp.Scene(source, [floor, box], meters(("floor", "box"))))
        for name, power in (("floor, front", from_floor), ("box, back", from_box)):
            if power in (0.0, 1.0, 6.0):
                assert result[name].flux_out.value == pytest.approx(power, rel=1e-9)
            else:
                assert_agrees(result[name].flux_out, power)
        assert result["floor, back"].flux_out.value == result["box, front"].flux_out.value == 0


# ---- refused ----


@pytest.mark.parametrize(
    ("surfaces", "detectors", "words"),
    [
        ([surface(ROOM, "room"), surface(tp.Rectangle(width=1, height=1), "carpet")], METER, "inside a Box its own face acts"),
        ([surface(CUPBOARD, "one"), surface(tp.Box(center=(0.5, -0.4, 0.7), size=(1, 0.8, 1.4)), "other")], METER,
         "' stand through one another, with faces on one plane; move one"),
        ([surface(CUPBOARD, "one"), surface(CUPBOARD, "other")], METER, "' stand through one another, with faces on one plane; move one"),
        ([surface(CUPBOARD, "one"), surface(raised(CUPBOARD, 1e-16), "other")], METER, "' stand through one another, with faces on one plane; move one"),
        ([surface(CUPBOARD, "one"), surface(tp.Box(center=CUPBOARD.center, size=(1.0, 0.8, 1 - 2**-53)), "other")], METER,
         "' stand through one another, with faces on one plane; move one"),
        ([surface(FLOORS["rectangle"], "floor"), tp.Surface(CUPBOARD, tp.Dielectric(1.5), "glass")], METER,
         "is a film of air between them meant"),
        ([surface(FLOORS["rectangle"], "floor"), surface(tp.Rectangle(width=1, height=1), "carpet")], METER,
         "a whole Box may stand on another surface"),
        ([surface(FLOORS["rectangle"], "floor"), surface(CUPBOARD, "box")],
         tp.Detector(tp.Disk(center=(0.3, -0.4, 0), radius=0.2), "between"), "must not lie between Surface 'box' and Surface 'floor'"),
    ],
)  # fmt: skip
def test_what_is_not_furniture_is_refused(surfaces, detectors, words):
    with pytest.raises(tp.SceneError, match=words):
        tp.Scene(LAMP, surfaces, detectors)


def test_a_detector_beyond_the_rim_of_a_round_floor_is_not_between():
    """It lies on the free part of the bottom of a box, in the square about the disk."""
    floor = surface(tp.Disk(radius=3), "floor")
    box = surface(tp.Box(center=(2.6, 2.6, 0.5), size=1), "box")
    below = tp.Source(tp.Point(position=(2.7, 2.7, -1)), tp.Isotropic(power=1.0))
    meter = tp.Detector(tp.Disk(center=(2.7, 2.7, 0), radius=0.1), "free", "back")
    result = run(tp.Scene(below, [floor, box], meter))
    assert_agrees(result["free"].flux_in, (1 - 1 / math.hypot(1, 0.1)) / 2)


def test_passes_of_shared_planes_are_in_no_other_scene():
    apart = [surface(ROOM, "room"), surface(raised(CUPBOARD, 1e-6), "box")]
    together = [surface(ROOM, "room"), surface(CUPBOARD, "box")]
    names = [
        {name for name, *_ in compile_scene(tp.Scene(LAMP, surfaces, METER)).members}
        for surfaces in (apart, together)
    ]
    assert not any(name.endswith("_on_side") for name in names[0])
    assert "meet_rectangle_on_side" in names[1]
