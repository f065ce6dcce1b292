"""Rays meet rectangles and planes across an axis at the same place, to the last bit, as by the passes for any position."""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp
from tests.driven import Lanes
from transport.compile import layout
from transport.compile.compiler import compile_scene
from transport.engine.bundle import LANES
from transport.engine.registry import PASSES
from transport.engine.stages.flights import intersect_surfaces

LAMP = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def rectangle(axis, sign, turned):
    """Not a square, off the middle, its width along either of the other axes."""
    up = AXES["xyz"[("xyz".index(axis) + (1 if turned else 2)) % 3]]
    return tp.Rectangle(
        center=(0.1, -0.2, 0.3), normal=tuple(sign * n for n in AXES[axis]), up=up, width=1.1, height=0.7
    )


def met(name, row):
    """What rays from all around find, some of them along the plane or from it."""
    random = np.random.default_rng(4)
    lanes = Lanes(distance=np.inf, start=np.where(random.random(LANES) < 0.2, 0.25, 0.0))
    directions = random.normal(size=(LANES, 3))
    directions[:9] = np.eye(3)[np.arange(9) % 3]
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for column, name_of in enumerate("xyz"):
        lanes[name_of], lanes[f"u{name_of}"] = random.uniform(-0.3, 0.3, LANES), directions[:, column]
    sheet = (row["one"] if "one" in row.dtype.names else row)["sheet"]
    lanes["sheet"] = np.where(random.random(LANES) < 0.1, sheet, 0)
    lanes.run(PASSES[name], row)
    return {field: lanes[field] for field in ("distance", "hit", "covered")}


@pytest.mark.parametrize("turned", [False, True], ids=["upright", "lying"])
@pytest.mark.parametrize("sign", [1, -1], ids=["along", "against"])
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("kind", ["meet", "cover"])
def test_aligned_and_general_passes_agree(kind, axis, sign, turned):
    shape = rectangle(axis, sign, turned)
    parts = (
        {"surfaces": [tp.Surface(shape, tp.Black())]}
        if kind == "meet"
        else {"detectors": [tp.Detector(shape, "it")]}
    )
    ((name, row, _),) = compile_scene(tp.Scene(LAMP, **parts)).members
    assert name == f"{kind}_rectangle_{axis}"
    aligned, general = met(name, row), met(f"{kind}_rectangle", row)
    assert 20 < np.isfinite(aligned["distance"]).sum() < LANES
    for field, values in general.items():
        np.testing.assert_array_equal(aligned[field], values, field)


def test_a_tilted_rectangle_has_the_general_pass():
    tilted = tp.Rectangle(normal=(0, 1e-9, 1), width=1, height=1)
    ((name, _, _),) = compile_scene(tp.Scene(LAMP, [tp.Surface(tilted, tp.Black())])).members
    assert name == "meet_rectangle"


@pytest.mark.parametrize("sign", [1, -1], ids=["along", "against"])
@pytest.mark.parametrize("axis", AXES)
def test_aligned_and_general_passes_of_two_planes_agree(axis, sign):
    n = np.array(AXES[axis])
    planes = [
        tp.Plane(center=tuple(0.1 * n), normal=tuple(sign * n)),
        tp.Plane(center=tuple(-0.2 * n), normal=tuple(n)),
    ]
    plan = compile_scene(
        tp.Scene(LAMP, detectors=[tp.Detector(plane, f"at {k}") for k, plane in enumerate(planes)])
    )
    ((lane_pass, table),) = intersect_surfaces(plan)
    assert lane_pass.name == f"cover_planes_{axis}"
    aligned, general = met(lane_pass.name, table), met("cover_planes", table)
    assert 20 < np.isfinite(aligned["distance"]).sum() < LANES
    for field, values in general.items():
        np.testing.assert_array_equal(aligned[field], values, field)


@pytest.mark.parametrize("axis", AXES)
def test_two_planes_at_once_are_as_one_after_the_other(axis):
    """For rays from the planes too, rays that passed one, and rays with a hit before, on either sheet."""
    n = np.array(AXES[axis])
    looks = [
        tp.Detector(tp.Plane(center=tuple(at * n), normal=tuple(n)), name)
        for name, at in (("a", 0.125), ("b", -0.25))
    ]
    ((lane_pass, table),) = intersect_surfaces(compile_scene(tp.Scene(LAMP, detectors=looks)))
    rows = [table["one"], table["other"]]
    planes, sheets = np.array([(row[f"s{axis}"], row["sheet"]) for row in rows]).T
    choices, hits = [0, 0, 0, *sheets.astype(int)], np.array([row["hit"] for row in rows])
    replaced = shared = 0
    for seed in range(20):
        random = np.random.default_rng(seed)
        at, u = random.uniform(-0.5, 0.5, LANES), random.choice([-1.0, -0.5, 0.0, 0.5, 1.0], LANES)
        at[:64] = random.choice(planes, 64)
        places = random.choice(choices, LANES) | random.choice(choices, LANES) << layout.PASSED_SHIFT
        which, has_hit = random.integers(2, size=LANES), random.random(LANES) < 0.5
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (planes[which] - at) / u
        has_hit &= (t > 0) & (t < np.inf)
        fields = {
            "distance": np.where(has_hit, t, np.inf),
            "hit": np.where(has_hit, hits[which], 0),
            "covered": np.where(has_hit, 1 << 9, 0),
            "start": np.where(random.random(LANES) < 0.2, 0.125, 0.0),
            "sheet": places,
        }
        fields |= {"uz": 0, axis: at, f"u{axis}": u}
        together, apart = Lanes(**fields).run(lane_pass, table), Lanes(**fields)
        for row in rows:
            apart.run(PASSES["cover_plane"], row)
        for field in ("distance", "hit", "covered"):
            np.testing.assert_array_equal(together[field], apart[field], field)
        replaced += (has_hit & (apart["hit"] != fields["hit"])).sum()
        shared += (apart["covered"] > 1 << 9).sum()
    assert replaced > 100 and shared > 300
