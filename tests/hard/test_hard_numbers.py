"""Numbers at the ends of what floating point holds: lengths, powers, speeds, random draws; the table of hard cases.

What does not fit is refused with the reason.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import warnings
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from numba import njit

import transport as tp
from tests.agreement import assert_agrees
from tests.bench.random_stream import ORDERS, chunks
from tests.plain_scenes import SCENES
from tests.slow import quick
from transport.physics.device import ARITHMETIC, EXACT
from transport.physics.streams import random_words
from transport.verification.hard.cases import FALSE_ALARM, cases_of

ROOT = Path(__file__).resolve().parents[2]


def run(sources, detectors=(), particles=10, seed=1, **scene):
    return tp.simulate(
        tp.Scene(sources, detectors=detectors, **scene), particles=particles, seed=seed, progress=False
    )


# ---- the hard cases of `transport verify --hard` ----

CASES = {f"{case.family}: {case.title}": case for case in cases_of()}


@pytest.mark.parametrize("title", CASES)
def test_a_hard_case_is_right_where_the_naive_way_is_not(title):
    case = CASES[title]
    seen = case.run()
    assert seen.holds(FALSE_ALARM / len(CASES)), f"{seen.value} for {seen.exact}, off by {seen.off}"
    assert seen.naive_fails, f"the naive way gives {seen.naive} for {seen.exact}"
    assert case.reason and case.naive


# ---- lengths, powers, speeds ----


def disks(length=1.0, radiance=1.0):
    """A lamp aimed at a detector."""
    pane = tp.Disk(center=(0, 0, 2 * length), normal=(0, 0, -1), radius=0.5 * length)
    return tp.Source(tp.Disk(radius=length), tp.Lambertian(radiance=radiance), aim=pane), tp.Detector(
        pane, "meter"
    )


@pytest.mark.parametrize(
    ("length", "radiance"), [(x, 1.0) for x in (1e-120, 1e-12, 1e12, 1e120)] + [(1.0, 1e-290), (1.0, 1e290)]
)
def test_irradiance_does_not_depend_on_the_units_of_length_and_power(length, radiance):
    one, other = (run(*disks(*units), 10_000)["meter"].irradiance.value for units in ((), (length, radiance)))
    np.testing.assert_allclose(one, other / radiance, rtol=1e-12)


FAR = tp.Disk(center=(0, 0, 1.0), normal=(0, 0, -1), radius=1e-130)
STRONG = tp.Source(tp.Point(), tp.Isotropic(power=1.5e308))
FAST = tp.Source(tp.Point(), tp.Isotropic(power=1.0, speed=1e300))
BEYOND = {
    "too large": (lambda: run(*disks(1e145)), "size must be between"),
    "an aim too small": (
        lambda: run(tp.Source(tp.Disk(radius=0.1), tp.Lambertian(radiance=1.0), aim=FAR)),
        "aim must subtend more than",
    ),
    "too bright": (lambda: run([STRONG, STRONG]), "power of all sources together"),
    "too faint": (lambda: run(*disks(1.0, 5e-324)), "power of all sources together"),
    "too fast": (lambda: run(FAST, duration=1e100), "speed must cross"),
}


@pytest.mark.parametrize(("make", "words"), BEYOND.values(), ids=BEYOND)
def test_numbers_beyond_the_range_are_refused(make, words):
    with pytest.raises(tp.SceneError, match=words):
        make()


def test_an_aim_whose_weights_have_a_heavy_tail_is_warned_of():
    """A kilometre of ceiling over a millimetre: the births that matter are never drawn, and the error looks small."""
    pane = tp.Disk(center=(0, 0, -0.01), normal=(0, 0, 1), radius=1e-3)
    ceiling = tp.Rectangle(normal=(0, 0, -1), width=1000.0, height=1000.0)
    lamp = tp.Source(ceiling, tp.Lambertian(radiance=1.0), aim=pane)
    result = run(lamp, tp.Detector(pane, "meter"), 50_000, seed=0)
    assert any("doubtful" in warning for warning in result.warnings)
    assert not run(*disks(), 50_000, seed=0).warnings


@pytest.mark.parametrize("height", quick([0.5, 0.5 - 1e-15, 0.5 + 1e-15, 0.2], 0.5))
def test_a_box_aimed_at_from_the_plane_of_its_face(height):
    """Directions within the face's plane are of measure zero: drawn, but never counted."""
    box, point = tp.Box(size=1.0), tp.Point(position=(2, 0, height))
    aimed, free = (
        run(tp.Source(point, tp.Isotropic(power=1.0), aim=aim), tp.Detector(box, "box"), n)["box"].flux_in
        for aim, n in ((box, 200_000), (None, 2_000_000))
    )
    assert abs(aimed.value - free.value) < 4.5 * np.hypot(aimed.error, free.error)


FURNACE = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="inside")
TILTED = tp.Disk(radius=0.5, normal=(1, 0, 2))
BINS = [{"mu": (0, 0.25, 0.5, 1)}, {"theta": 4}, {"mu": 4}, {"mu": (-1, -0.3, 0.2, 1), "frame": "world"}]


@pytest.mark.parametrize("bins", BINS)
@pytest.mark.parametrize("phi", quick([(0, 1), (1, 2, 4), 3], (1, 2, 4)))
def test_radiance_in_a_furnace_is_the_same_in_any_bins(bins, phi):
    """Partial edges on both axes of direction: light outside of one must not come back by the other."""
    detector = tp.Detector(TILTED, "meter", directions=tp.Directions(phi=phi, **bins))
    radiance = run(FURNACE, detector, 400_000)["meter"].radiance
    for value in radiance.value.flat:
        assert np.isnan(value) or value > 0
    seen = np.isfinite(radiance.error) & (radiance.value > 0)
    assert (np.abs(radiance.value[seen] - 1) < 5 * radiance.error[seen]).all()


@pytest.mark.parametrize("frame", ["local", "world"])
def test_a_sector_across_azimuth_zero_is_its_two_halves(frame):
    """The same crossings, whether the sector is cut at 0 or begins below it."""
    edges = {"whole": (-0.7, 0.5), "below": (2 * np.pi - 0.7, 2 * np.pi), "above": (0, 0.5)}
    sectors = {name: tp.Directions(phi=phi, frame=frame) for name, phi in edges.items()}
    result = run(FURNACE, [tp.Detector(TILTED, n, directions=d) for n, d in sectors.items()], 100_000)
    counts = {name: result[name].counts.value.sum() for name in edges}
    assert counts["whole"] == counts["below"] + counts["above"] > 100


def test_a_detector_on_a_source_measures_its_whole_power_wherever_the_origin_lies():
    """A source of a picometre beside smaller shapes a metre away: nothing is lost at its rim by rounding."""
    disk, crumb = tp.Disk(radius=1e-12, center=(0.3, 0.2, 0.1)), tp.Disk(radius=1e-13, center=(-1, 0, 0))
    detectors = [tp.Detector(disk, "own"), tp.Detector(crumb, "crumb")]
    result = run(tp.Source(disk, tp.Lambertian(power=1.0)), detectors, 1_000_000, seed=0)
    np.testing.assert_allclose(result["own"].flux_out.value, 1.0, rtol=1e-14)


def test_fluence_of_a_steady_grazing_beam_is_not_rounded_away():
    """Every crossing has the same cosine and a weight far below the largest: rounding must not lean one way."""
    tilt = np.radians(89.9)
    normal = (np.sin(tilt), 0, np.cos(tilt))
    pane = tp.Disk(center=(0, 0, 1), normal=normal, radius=1e-9)
    lamp = tp.Source(tp.Disk(radius=1e-9, normal=normal), tp.Lambertian(radiance=1.0), aim=pane)
    reading = run(lamp, tp.Detector(pane, "m"), 100_000, seed=0)["m"]
    assert_agrees(reading.fluence_rate, reading.exitance.value / np.cos(tilt), 1e-5)


def test_an_aim_behind_its_source_in_fog_is_reported_without_nan():
    """Found by a random scene: nothing is born, and the share of survivors that may be missing was 0/0."""
    box = tp.Box(center=(0, 0, 3), size=1.0)
    cells = np.array([[[1.0, 2.0]]])
    grid = tp.Grid(box=box, absorption=cells, scattering=cells)
    fog = tp.Surface(box, tp.Transparent(), "fog", inside=grid)
    aim = tp.Sphere(center=(0, 0, -2), radius=0.1)
    lamp = tp.Source(tp.Disk(radius=0.3), tp.Lambertian(power=1.0), aim=aim)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        report = run(lamp, tp.Detector("fog"), 500, surfaces=fog).report()
    assert "nothing is emitted towards the aim" in report
    assert "nan" not in report


# ---- draws of 0 and of 1 - 2^-52 in every sampler: no NaN, no infinity, no endless loop, and the energy balance closes ----

EXTREME = """
import json, sys
from tests.hard import extreme_draws as extreme
print(json.dumps({name: extreme.told(extreme.run(name, 5)) for name in sys.argv[1:]}))
"""
PLANTED = """
import math
from transport.engine.passes import emission as births
def sample_isotropic(u, turn):
    mu = 2.0 * u - 1.0
    s = math.sqrt(1.0 - mu * mu)
    x, y, _ = real(u, turn)
    return s * x / (s + 0.0 if s > 0 else math.nan), y, mu
real, births.sample_isotropic = births.sample_isotropic, sample_isotropic
"""


def plainly(code, *scenes):
    """Run code in a new interpreter without compilation."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-c", code, *scenes]
    return subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False, timeout=300
    )


@pytest.mark.slow
def test_extreme_draws_in_every_scene_lead_to_an_end():
    """That each ended and its energy balance closed to the last bit shows in its being here.

    In media a collision may come within the last digit of a wall, on its other side: such histories are lost, and counted.
    """
    done = plainly(EXTREME, *SCENES)
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout.splitlines()[-1])
    assert found.keys() == SCENES.keys()
    for name, sums in found.items():
        assert sums["is_finite"] and sums["astray"] == 0, name
        assert sums["lost"] == 0 or 0 < sums["lost"] <= sums["collisions"], name
    assert sum(sums["crossings"] for sums in found.values()) > 100


@pytest.mark.slow
def test_a_sampler_that_divides_by_a_sine_of_zero_is_caught():
    """Planted: a direction whose sine is divided by; only the two poles break it, which are never drawn by chance."""
    assert "FloatingPointError" in plainly(PLANTED + EXTREME, "beams", "vessel", "glow").stderr


def count_finite(values):
    count = 0
    for x in values:
        count += 1 if np.isfinite(x) else 0
    return count


@pytest.mark.parametrize("arithmetic", [ARITHMETIC, EXACT])
def test_guards_see_nan_and_infinity(arithmetic):
    """A whole fastmath takes nan and inf for finite, and with it every guard; the engine's arithmetic does not."""
    values = np.array([np.nan, np.inf, -np.inf, 1.0])
    assert njit(**arithmetic)(count_finite)(values) == 1
    assert njit(fastmath=True)(count_finite)(values) == 4  # the planted fault


# ---- the stream that a battery of tests reads is made of the words that the engine draws, none of them twice ----


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "second"),
    [
        ("lives", (0, 0, 0, 1, 7)),
        ("histories", (1, 0, 0, 0, 7)),
        ("batches", (0, 1, 0, 0, 7)),
        ("seeds", (0, 0, 0, 0, 8)),
    ],
)
def test_the_next_block_follows_the_order(order, second):
    """The first two blocks are the engine's of (history, batch, event, purpose; seed)."""
    words = next(chunks(order, 7, 2))
    for found, (*counter, seed) in zip(words.tolist(), [(0, 0, 0, 0, 7), second], strict=True):
        assert found == list(random_words(*map(np.uint64, (*counter, seed, 0))))


@pytest.mark.parametrize("order", ORDERS)
def test_no_block_comes_twice_and_chunks_continue_where_the_last_ended(order):
    parts = np.concatenate(list(islice(chunks(order, 1, 5000), 8)))
    assert (parts == next(chunks(order, 1, 40_000))).all()
    assert len(np.unique(parts, axis=0)) == 40_000
