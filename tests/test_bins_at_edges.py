"""What lies exactly on an edge of bins is counted once: in the upper bin, on the last edge in the last one."""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp


def beamed(**bins):
    """Counts of a pencil beam of 64 particles along the normal of a meter, through its middle."""
    meter = tp.Rectangle(center=(0, 0, 1), width=2.0, height=2.0, normal=(0, 0, -1))
    source = tp.Source(tp.Point(position=(0, 0, 0)), tp.Beam(direction=(0, 0, 1), power=1.0))
    detectors = [tp.Detector(meter, "meter", **bins), tp.Detector(meter, "next", **bins)]
    result = tp.simulate(tp.Scene(source, (), detectors), particles=64, batches=2, progress=False)
    np.testing.assert_array_equal(result["next"].counts.value, result["meter"].counts.value)
    assert result["meter"].flux_in.value == 1.0
    return result["meter"].counts.value


@pytest.mark.parametrize(
    ("directions", "last"),
    [
        ({"mu": 4}, -1),
        ({"mu": (0, 0.3, 1)}, -1),
        ({"theta": 4}, 0),
        ({"mu": 2, "phi": 3}, -1),
        ({"mu": 4, "frame": "world"}, 0),
    ],
)
def test_a_ray_straight_along_the_normal_is_in_the_outermost_bin_of_cosine(directions, last):
    """It comes from (0, 0, -1), so that the world's first bin of cosine holds it."""
    counts = beamed(directions=tp.Directions(**directions))
    assert counts[last].sum() == counts.sum() == 64


@pytest.mark.parametrize("bins", [{"mu": (0, 0.25, 1)}, {"theta": 4}, {"mu": 8}])
def test_a_ray_along_any_normal_is_in_the_bin_of_cosine_1(bins):
    """The cosine of a ray and a normal that are equal may round to more than 1."""
    normals = np.random.default_rng(1).normal(size=(24, 3))
    for normal in normals / np.linalg.norm(normals, axis=1)[:, None]:
        source = tp.Source(tp.Point(position=normal), tp.Beam(direction=-normal, power=1.0))
        meter = tp.Detector(tp.Disk(normal=normal, radius=1.0), "meter", directions=tp.Directions(**bins))
        result = tp.simulate(tp.Scene(source, (), meter), particles=8, batches=2, progress=False)
        assert result["meter"].counts.value.sum() == 8


def test_a_ray_on_the_edge_between_two_bins_of_place_is_in_the_upper_one():
    counts = beamed(positions=tp.Positions(u=2, v=4))
    assert counts[1, 2] == counts.sum() == 64


def test_azimuths_on_a_disk_run_from_its_own_e_u_to_e_v():
    """Beams at 0.1 and 0.3 of a turn from +x towards +y, on a disk whose normal is +z."""
    for turn, cell in ((0.1, 0), (0.3, 1), (0.6, 2), (0.8, 3)):
        place = (0.5 * np.cos(2 * np.pi * turn), 0.5 * np.sin(2 * np.pi * turn), 2.0)
        source = tp.Source(tp.Point(position=place), tp.Beam(direction=(0, 0, -1), power=1.0))
        meter = tp.Detector(tp.Disk(radius=1.0), "meter", positions=tp.Positions(v=4))
        counts = tp.simulate(tp.Scene(source, (), meter), particles=8, batches=2, progress=False)[
            "meter"
        ].counts
        assert counts.value.ravel()[cell] == 8
