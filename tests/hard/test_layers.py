"""Layers that touch, gaps of nothing between them, slabs far away, tiny or huge, are one slab.

Each scene has an exact value; its ledger closes and nothing is lost.  Runs have seed 1; each judgement fails right code in
one of 10^5 seeds.
"""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp
from tests.hard.media_at_limits import (
    FORCED,
    assert_is_van_de_hulst_s_slab,
    beam,
    body,
    faces,
    fog,
    returned_and_passed,
    run,
)


def layers(count, gap=0.0, are_alike=False, scale=1.0):
    """One slab as many; each differs from the next, or else they might be taken for one."""
    thickness = scale / count
    return [
        body(
            tp.Slab(center=(0, 0, -(k + 0.5) * thickness - k * gap), thickness=thickness),
            fog(2.0, 0.9, 0.75 if are_alike else 0.75 * (1 + 1e-12 * k), scale),
        )
        for k in range(count)
    ]


@pytest.mark.parametrize("tracking", ["weighted", "analog"])
@pytest.mark.parametrize("are_alike", [True, False])
@pytest.mark.parametrize("count", [1, 3, 20, 60])
def test_many_thin_slabs_are_one(count, are_alike, tracking):
    """Interfaces coincide; the path from one collision to the next leads through many."""
    scene = tp.Scene(beam((0, 0, 1), (0, 0, -1)), layers(count, are_alike=are_alike), faces())
    assert_is_van_de_hulst_s_slab(run(scene, tracking, 30_000))


@pytest.mark.parametrize(
    "tracking", [FORCED, tp.Tracking(splitting=tp.Splitting(end=(0, 0, -1), start=(0, 0, 0), gain=4))]
)
def test_many_thin_slabs_are_one_for_copies_too(tracking):
    scene = tp.Scene(beam((0, 0, 1), (0, 0, -1)), layers(5), faces())
    assert_is_van_de_hulst_s_slab(run(scene, tracking, 20_000))


@pytest.mark.parametrize("gap", [1e-3, 1e-9, 1e-12, 1e-14])
@pytest.mark.parametrize("tracking", [None, "analog", FORCED])
def test_a_gap_of_vacuum_between_layers_changes_nothing(gap, tracking):
    scene = tp.Scene(beam((0, 0, 1), (0, 0, -1)), layers(3, gap), faces())
    assert_is_van_de_hulst_s_slab(run(scene, tracking))


def test_a_layer_left_out_is_seen():
    scene = tp.Scene(beam((0, 0, 1), (0, 0, -1)), layers(20)[:-1], faces())
    with pytest.raises(AssertionError):
        assert_is_van_de_hulst_s_slab(run(scene))


@pytest.mark.parametrize("offset", [1e3, 1e6])
@pytest.mark.parametrize("tracking", [None, "analog", FORCED])
def test_a_slab_far_from_the_origin(offset, tracking):
    center = np.array([1.0, -0.7, 0.3]) * offset
    slab = tp.Slab(center=tuple(center - [0, 0, 0.5]), thickness=1.0)
    scene = tp.Scene(
        beam(center + [0, 0, 0.1], (0, 0, -1)), body(slab, fog(2.0, 0.9, 0.75)), faces(1.0, tuple(center))
    )
    assert_is_van_de_hulst_s_slab(run(scene, tracking))


@pytest.mark.parametrize("scale", [1e-12, 1e-6, 1e12])
def test_slabs_of_picometres_and_of_a_light_hour(scale):
    """The same digits as of a metre."""
    found = []
    for size in (1.0, scale):
        scene = tp.Scene(beam((0, 0, size), (0, 0, -1)), layers(3, scale=size), faces(size))
        found.append([estimate.value for estimate in returned_and_passed(run(scene, None, 5_000))])
    assert found[1] == pytest.approx(found[0], rel=1e-12)
