"""The same seed gives the same bits in media, whatever the threads and the order of batches.

Weighted, analog, forced and split histories, voxels, volume and point detectors, with and without a clock:
every integer that a batch counts is compared, in scenes that between them call for every pass of media.
"""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

import transport as tp
from tests import media_scenes
from transport.compile.compiler import compile_scene
from transport.engine.bundle import empty_bundle
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program

SPLIT = tp.Tracking(splitting=media_scenes.STATION)
WAYS = {  # scene, and how it is followed
    "weighted": ("layers", None),
    "analog": ("layers", "analog"),
    "forced": ("layers", tp.Tracking(forced=True)),
    "split": ("layers", SPLIT),
    "forced by chance": ("thin", tp.Tracking(absorption="analog", forced=True)),
    "split voxels": ("deep", SPLIT),
    "split by chance": ("hall", tp.Tracking(absorption="analog", splitting=media_scenes.STATION)),
    "voxels, volumes": ("cloud", None),
    "voxels, volumes by chance": ("cloud", "analog"),
    "absorbing voxels": ("smoke", None),
    "points": ("seen", None),
    "points by chance": ("seen", "analog"),
    "rings": ("rod", None),
    "rings by chance": ("rod", "analog"),
    "clock": ("pile", "analog"),
    "path lengths": ("shells", tp.Tracking(forced=True)),
}
HISTORIES, BATCHES = 300, 4


def program_for(way):
    name, tracking = WAYS[way]
    tracking = tp.Tracking(absorption=tracking) if isinstance(tracking, str) else tracking
    return build_program(compile_scene(media_scenes.MEDIA[name](), tracking))


def counted(raw) -> list[np.ndarray]:
    """All that a batch counted, nobody's row left out."""
    return [raw.detectors[1:], raw.ledger, raw.moments, np.array([raw.crossings, raw.collisions])]


def assert_same(one, other) -> None:
    for each, like in zip(one, other, strict=True):
        np.testing.assert_array_equal(each, like)


def differ(one, other) -> bool:
    return any(not np.array_equal(each, like) for each, like in zip(one, other, strict=True))


@pytest.mark.parametrize("way", WAYS)
def test_batches_in_media_are_pure_functions_of_their_number(way):
    """Forwards each in a bundle of its own, then backwards in one that still holds what the last one left."""
    machine = compile_program(program_for(way))
    alone = [counted(run_batch(machine, 5, number, HISTORIES)) for number in range(BATCHES)]
    bundle = empty_bundle()
    for number in reversed(range(BATCHES)):
        assert_same(counted(run_batch(machine, 5, number, HISTORIES, bundle=bundle)), alone[number])
    assert all(differ(alone[0], other) for other in alone[1:])
    assert differ(alone[0], counted(run_batch(machine, 6, 0, HISTORIES)))


@pytest.mark.parametrize("way", WAYS)
def test_threads_in_media_count_the_same(way):
    name, tracking = WAYS[way]
    options = {"particles": BATCHES * 4 * HISTORIES, "batches": 4 * BATCHES, "seed": 5, "tracking": tracking}
    one, other = (
        tp.simulate(media_scenes.MEDIA[name](), threads=threads, progress=False, **options)
        for threads in (1, 3)
    )
    for batch, like in zip(one.batches, other.batches, strict=True):
        for part in ("weights", "counts", "slants", "absorbed", "moments"):
            np.testing.assert_array_equal(getattr(batch, part), getattr(like, part))
        assert batch.ledger == like.ledger
        assert (batch.crossings, batch.collisions) == (like.crossings, like.collisions)


def digest(way) -> str:
    """Of all that two batches counted."""
    machine, sums = compile_program(program_for(way)), hashlib.sha256()
    for number in range(2):
        for part in counted(run_batch(machine, 5, number, HISTORIES)):
            sums.update(np.ascontiguousarray(part).tobytes())
    return sums.hexdigest()


def test_the_ways_between_them_use_every_pass_of_media():
    """Of all scenes for media; so nothing that they do is left out here."""
    used = {each.name for way in WAYS for each in program_for(way).passes}
    for name in set(media_scenes.MEDIA) - {"flash_in_the_dark", "draught", "still"}:
        plan = compile_scene(media_scenes.MEDIA[name](), media_scenes.TRACKINGS.get(name))
        assert {each.name for each in build_program(plan).passes} <= used
