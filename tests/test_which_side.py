"""Which side: a meter looks at one of its two, a box sends a beam from the faces that look along it."""

from __future__ import annotations

import math

import pytest

import transport as tp

UP = tp.Beam(direction=(0, 0, 1), power=2.0)


def readings(source, *detectors):
    """What 64 histories brought, by detector: (flux_in, flux_out) [W]."""
    result = tp.simulate(tp.Scene(source, (), detectors), particles=64, batches=2, progress=False)
    return {d.name: (result[d.name].flux_in.value, result[d.name].flux_out.value) for d in detectors}


@pytest.mark.parametrize("first", [1, -1])
def test_what_meets_the_side_looked_at_arrives_and_what_comes_from_behind_leaves(first):
    """Four meters on one sheet, whose normal is that of the first of them."""
    meters = [
        tp.Detector(
            tp.Disk(center=(0, 0, 1), normal=(0, 0, sign), radius=1.0 + k), f"{sign} {side}", side=side
        )
        for k, (sign, side) in enumerate((s, side) for s in (first, -first) for side in ("front", "back"))
    ]
    found = readings(tp.Source(tp.Point(), UP), *meters)
    arrives, leaves = (2.0, 0.0), (0.0, 2.0)
    assert found == {"1 front": leaves, "1 back": arrives, "-1 front": arrives, "-1 back": leaves}


@pytest.mark.parametrize("tilt", [0.0, 0.5])
def test_a_beam_leaves_a_box_by_the_faces_that_look_along_it_and_none_of_it_is_within(tilt):
    box = tp.Box(size=(1.0, 2.0, 3.0))
    beam = tp.Beam(direction=(math.sin(tilt), 0, math.cos(tilt)), power=2.0)
    middle = tp.Detector(tp.Disk(radius=0.4), "middle")
    found = readings(tp.Source(box, beam), tp.Detector(box, "box", side="outside"), middle)
    assert found == {"box": (0.0, 2.0), "middle": (0.0, 0.0)}
