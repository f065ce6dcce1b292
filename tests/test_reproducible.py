"""The same seed gives the same bits: whatever the threads, the order of batches or the size of bundles; plain Python counts the same.

Weighted, analog, forced and split histories, voxels, volume and point detectors, with and without a clock: every integer that a
batch counts is compared, in scenes that between them call for every pass.  Compiled code contracts a product and a sum into one
operation and plain Python (NUMBA_DISABLE_JIT=1) does not: there counts are equal and weights agree to rounding.
"""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

import numpy as np
import pytest

import transport as tp
from tests import media_scenes
from tests.plain_scenes import METHODS, SCENES
from tests.processes import elsewhere
from tests.same_batches import digest, scene
from tests.slow import quick
from transport import engine
from transport.compile.compiler import compile_scene
from transport.compile.methods import ANALOG
from transport.engine.bodies import Pass
from transport.engine.bundle import empty_bundle
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program

SPLIT = tp.Tracking(splitting=media_scenes.STATION)
WAYS = {  # scene, and how it is followed
    "weighted": ("layers", None),
    "split": ("layers", SPLIT),
    "points": ("seen", None),
    "analog": ("layers", tp.Tracking(absorption="analog")),
    "forced": ("layers", tp.Tracking(forced=True)),
    "forced by chance": ("thin", tp.Tracking(absorption="analog", forced=True)),
    "split voxels": ("deep", SPLIT),
    "split by chance": ("hall", tp.Tracking(absorption="analog", splitting=media_scenes.STATION)),
    "voxels, volumes": ("cloud", None),
    "voxels, volumes by chance": ("cloud", tp.Tracking(absorption="analog")),
    "absorbing voxels": ("smoke", None),
    "points by chance": ("seen", tp.Tracking(absorption="analog")),
    "rings": ("rod", None),
    "rings by chance": ("rod", tp.Tracking(absorption="analog")),
    "clock": ("pile", tp.Tracking(absorption="analog")),
    "path lengths": ("shells", tp.Tracking(forced=True)),
}
HISTORIES, BATCHES = 300, 4


def program_for(name, tracking=None, method=ANALOG):
    return build_program(compile_scene(SCENES[name](), tracking, method))


def counted(raw) -> list[np.ndarray]:
    """All that a batch counted, nobody's row left out."""
    return [raw.detectors[1:], raw.ledger, raw.moments, np.array([raw.crossings, raw.collisions])]


def are_equal(one, other) -> bool:
    return all(np.array_equal(each, like) for each, like in zip(one, other, strict=True))


# ---- batches and threads ----


def test_one_thread_and_more_threads_count_the_same_and_another_seed_does_not():
    found = [digest(scene(), threads=threads) for threads in (1, 2, 3, 3)]
    assert len(set(found)) == 1 and digest(scene(), seed=8) not in found


@pytest.mark.parametrize("way", quick(WAYS, "weighted", "split"))
def test_threads_in_media_count_the_same(way):
    name, tracking = WAYS[way]
    options = {"particles": 4 * BATCHES * HISTORIES, "batches": 4 * BATCHES, "tracking": tracking}
    assert digest(SCENES[name](), threads=1, **options) == digest(SCENES[name](), threads=3, **options)


@pytest.mark.parametrize("way", quick(WAYS, "weighted", "split"))
def test_batches_are_pure_functions_of_seed_and_number(way):
    """Forwards each in a bundle of its own, then backwards in one that still holds what the last one left."""
    machine = compile_program(program_for(*WAYS[way]))
    alone = [counted(run_batch(machine, 5, number, HISTORIES)) for number in range(BATCHES)]
    bundle = empty_bundle()
    for number in reversed(range(BATCHES)):
        assert are_equal(counted(run_batch(machine, 5, number, HISTORIES, bundle=bundle)), alone[number])
    assert not any(are_equal(alone[0], other) for other in alone[1:])
    assert not are_equal(alone[0], counted(run_batch(machine, 6, 0, HISTORIES)))


def test_a_history_does_not_depend_on_the_histories_beside_it():
    """A batch of 300 histories begins with the 200 histories of a smaller batch of the same number (one source)."""
    single = tp.Scene(sources=scene().sources[:1], surfaces=scene().surfaces, detectors=scene().detectors)
    machine = compile_program(build_program(compile_scene(single)))
    small, large = (run_batch(machine, 3, 0, n).detectors for n in (200, 300))
    assert (large[:, 2] >= small[:, 2]).all()


# ---- plain Python, and bundles of another size ----


def sums_of(names):
    """What these scenes count, as lists."""
    found = {}
    for name in names:
        asked = media_scenes.TRACKINGS.get(name), METHODS.get(name, ANALOG)
        raw = run_batch(compile_program(program_for(name, *asked)), seed=12345678901, batch=1, histories=200)
        found[name] = {
            "meters": raw.detectors[1:].tolist(),  # without nobody's row
            "ledger": raw.ledger.tolist(),
            "moments": raw.moments.tolist(),
            "records": [list(map(float, record)) for record in raw.records.tolist()],
            "crossings": raw.crossings,
            "collisions": raw.collisions,
        }
    return found


@cache
def plain_sums():
    """The same in a new interpreter without compilation, whose bundles have 64 lanes."""
    return elsewhere(
        f"tests.test_reproducible.sums_of({list(SCENES)})", NUMBA_DISABLE_JIT="1", TRANSPORT_LANES="64"
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_plain_python_in_bundles_of_64_lanes_counts_what_compiled_code_counts(name):
    interpreted, compiled = plain_sums()[name], sums_of([name])[name]
    assert interpreted["crossings"] == compiled["crossings"] > 10
    assert interpreted["collisions"] == compiled["collisions"]
    for table in ("meters", "ledger"):
        one, other = (np.array(sums[table]) for sums in (interpreted, compiled))
        assert (one[:, 2] == other[:, 2]).all()
        weights, others = (w[:, 0] * 2.0**-32 + w[:, 1] * 2.0**-63 for w in (one, other))
        assert np.abs(weights - others).max() <= 2e-10
        assert (
            np.abs(one[:, 3] - other[:, 3]).max() <= 2 * other[:, 2].max()
        )  # slants, each rounded to its unit
    one, other = (np.array(sums["moments"]).reshape(-1, 4) for sums in (interpreted, compiled))
    assert (
        np.abs((one - other) @ np.array([2.0**-32, 2.0**-63, 2.0**-94, 2.0**-125])).max(initial=0.0) <= 2e-10
    )
    one, other = (np.array(sorted(sums["records"])) for sums in (interpreted, compiled))
    assert one == pytest.approx(other, rel=1e-9, abs=1e-12)
    assert np.array(compiled["meters"])[:, 2].sum() > 10


def digests() -> dict[str, str]:
    """Where a copy lies in the bank, and when it is taken up, is nothing to it."""
    ways = {way: WAYS[way] for way in ("split",)}
    found = {way: digest(SCENES[name](), 4000, tracking=tracking) for way, (name, tracking) in ways.items()}
    return found | {"a bit of everything": digest(scene())}


@pytest.mark.slow
def test_compiled_bundles_of_64_lanes_count_the_same_bits():
    assert elsewhere("tests.test_reproducible.digests()", TRANSPORT_LANES="64") == digests()


# ---- the scenes above use every pass ----


def passes_of(program):
    """Names of its passes, and of those that take the place of one of them in a rare case."""
    rare = {each.unless[1].name for each in program.passes if each.unless is not None}
    return rare | {each.name for each in program.passes}


@pytest.mark.slow
def test_every_pass_is_compared_with_plain_python():
    """A new pass must be called for by one of these scenes."""
    folder = f"{engine.__path__[0]}/passes"
    modules = [
        importlib.import_module(f"{engine.__name__}.passes.{m.name}") for m in pkgutil.iter_modules([folder])
    ]
    passes = {p.name for module in modules for p in vars(module).values() if isinstance(p, Pass)}
    asked = {name: (media_scenes.TRACKINGS.get(name), METHODS.get(name, ANALOG)) for name in SCENES}
    used = set().union(*(passes_of(program_for(name, *how)) for name, how in asked.items()))
    # of pictures: see detectors/test_tracks.py; of guided births: run/test_guided_births.py; of images in
    # mirrors: detectors/test_mirror_images.py
    of_images = {"record_pdf_across_mirrors", "redirect_next_event_rays"}
    of_guides = {"draw_guided_birth", "record_birth", "add_to_history"}
    assert passes - used == {"record_tracks"} | of_guides | of_images


@pytest.mark.slow
def test_the_ways_between_them_use_every_pass_of_media():
    used = set().union(*(passes_of(program_for(*how)) for how in WAYS.values()))
    for name in set(media_scenes.MEDIA) - {"flash_in_the_dark", "draught", "still"}:
        assert passes_of(program_for(name, media_scenes.TRACKINGS.get(name))) <= used
