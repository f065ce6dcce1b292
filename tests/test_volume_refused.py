"""What a volume detector refuses: shapes, cells, directions and quantities that make no sense."""

from __future__ import annotations

import pytest

import transport as tp
from tests.volume_scenes import (
    ALL_ROUND,
    BALL,
    BOX,
    FOG,
    body,
    lit,
    run,
    sphere,
)
from transport.compile.compiler import compile_scene


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ({"shape": tp.Slab(thickness=1.0)}, "from face to face"),
        ({"shape": tp.Disk(radius=1.0)}, "Box, a Sphere or a Cylinder"),
        ({"shape": tp.Sphere(radius=1.0, mu_min=0.0)}, "whole Sphere"),
        ({"name": None}, "name must be given"),
        ({"cells": (2, 2)}, "three whole numbers"),
        ({"cells": (2, 0, 2)}, "from 1 to"),
        ({"cells": (2.5, 1, 1)}, "whole numbers"),
        ({"cells": 3}, "three whole numbers"),
        ({"cells": "many"}, "must be"),
        ({"cells": (-1, 2, 3)}, "must be"),
        ({"cells": (500, 500, 500)}, "10000000"),
        ({"shape": BALL, "cells": (0.1, 0.9)}, "radii"),
        ({"shape": BALL, "cells": (0.3, 0.2)}, "radii"),
        ({"shape": BALL, "cells": (0.5,)}, "number of shells"),
        ({"shape": BALL, "cells": (0,)}, "number of shells"),
        ({"directions": tp.Directions(mu=4)}, "Directions.sphere"),
        ({"directions": 8}, "Directions.sphere"),
        ({"estimator": "chord"}, "'track' or 'collision'"),
    ],
)
def test_a_volume_that_cannot_be_looked_at_is_refused(values, word):
    with pytest.raises(tp.SceneError, match=word):
        tp.VolumeDetector(**{"shape": BOX, "name": "box"} | values)


def test_all_directions_are_refused_where_they_make_no_sense():
    for values, word in (
        ({"mu": (-1.5, 1)}, "within"),
        ({"phi": (0, 7)}, "one turn"),
        ({"axis": (0, 0, 0)}, "axis"),
    ):
        with pytest.raises(tp.SceneError, match=word):
            sphere(**values)
    with pytest.raises(tp.SceneError, match="Directions"):
        tp.Detector(BOX, "meter", directions=sphere())


@pytest.mark.parametrize(
    ("surfaces", "tracking", "word"),
    [
        ([], None, "Vacuum"),
        ([body(BALL, tp.Medium(absorption=1.0))], "weighted", "scatter"),
        ([body(tp.Sphere(radius=0.5), FOG)], "analog", "Vacuum"),
    ],
)
def test_collisions_are_refused_where_there_are_none(surfaces, tracking, word):
    scene = tp.Scene(ALL_ROUND, surfaces, tp.VolumeDetector(BALL, "ball", estimator="collision"))
    with pytest.raises(tp.SceneError, match=word):
        run(scene, 1000, tracking=tracking)


LAMP = tp.Source(tp.Point(position=(-0.95, 0.0, 0.0)), tp.Isotropic(power=1.0))
UNIT_BALL, SPECK = tp.Sphere(radius=1.0), (0.0321, -0.0123, 0.0712)
LOW, HIGH = (tp.Plane(center=(0, 0, z), normal=(0, 0, 1)) for z in (0.0999, 0.1))
VACUUM, CLEAR = tp.Vacuum(), tp.Transparent()


@pytest.mark.parametrize(
    "surfaces",
    {
        "a speck": [body(tp.Sphere(radius=1e-3, center=SPECK), VACUUM)],
        "a small mesh": [body(tp.Mesh.box(size=1e-3, center=SPECK), VACUUM)],
        "a cap": [body(tp.Sphere(radius=3.0, center=(3.999, 0, 0)), VACUUM)],
        "a shell": [body(tp.Sphere(radius=0.9), VACUUM), body(tp.Sphere(radius=0.8999), FOG, "inner")],
        "a layer": [
            tp.Surface(HIGH, CLEAR, front=FOG, back=VACUUM),
            tp.Surface(LOW, CLEAR, front=VACUUM, back=FOG),
        ],
    }.items(),
    ids=lambda case: case[0],
)
@pytest.mark.parametrize("shape", [UNIT_BALL, tp.Box(size=2.0), tp.Cylinder(radius=1.0, height=2.0)])
def test_collisions_are_refused_with_a_vacuum_of_any_size_in_the_volume(surfaces, shape):
    detector = tp.VolumeDetector(shape, "volume", estimator="collision")
    scene = tp.Scene(LAMP, surfaces[1], detector, medium=FOG)
    with pytest.raises(tp.SceneError, match=r"all media in it must scatter .* got Vacuum"):
        compile_scene(scene)


def test_collisions_are_allowed_beside_a_vacuum():
    detector = tp.VolumeDetector(UNIT_BALL, "volume", estimator="collision")
    beside = body(tp.Sphere(radius=3.0, center=(4.001, 0, 0)), VACUUM)
    assert compile_scene(tp.Scene(LAMP, beside, detector, medium=FOG)).volumes
    assert compile_scene(tp.Scene(LAMP, body(UNIT_BALL, FOG), detector)).volumes
    layers = [tp.Surface(HIGH, CLEAR, front=FOG, back=VACUUM), tp.Surface(LOW, CLEAR, front=VACUUM, back=FOG)]
    high = tp.Sphere(radius=0.2, center=(0, 0, 0.301))
    above = tp.VolumeDetector(high, "volume", estimator="collision")
    assert compile_scene(tp.Scene(LAMP, layers, above)).volumes


def test_quantities_that_a_volume_was_not_set_up_for_are_refused():
    reading = lit()["box"]
    for quantity, word in (
        ("absorbed_power", "medium that absorbs"),
        ("radiance", "sphere"),
        ("fluence", "duration"),
        ("absorbed_energy", "duration"),
    ):
        with pytest.raises(tp.SceneError, match=word):
            getattr(reading, quantity)
    with pytest.raises(AttributeError, match="did you mean 'fluence_rate'"):
        _ = reading.fluence_rates
    with pytest.raises(tp.SceneError, match="must name a surface"):
        tp.Scene(ALL_ROUND, [], tp.VolumeDetector("fog"))
    with pytest.raises(tp.SceneError, match="unique"):
        tp.Scene(ALL_ROUND, [], [tp.VolumeDetector(BOX, "box"), tp.Detector(BOX, "box")])
    for target in ("box.flux_in", "box.fluence", "box"):
        with pytest.raises(tp.SceneError):
            tp.simulate(tp.Scene(ALL_ROUND, [], tp.VolumeDetector(BOX, "box")), error={target: 0.1})
