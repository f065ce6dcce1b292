"""Scenes whose random numbers are the least and the largest that there are, half of the time.

    python -m tests.hard.extreme_draws [--histories 100000] [SCENE ...]

runs them compiled; with NUMBA_DISABLE_JIT=1 as plain Python, where every lane is looked at after every pass.  Of all words
that come in pairs a quarter are 0, a quarter 2^32 - 1: uniforms of 0 and of 1 - 2^-52.  The passes are twins of the engine's
own, which call other words by the same names, as those of quasi-random sampling are (engine/stages/quasi_random.py).
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np
from numba import config, uint64

from tests import media_scenes
from tests.plain_scenes import METHODS, SCENES
from transport.compile.compiler import compile_scene
from transport.compile.methods import ANALOG
from transport.engine import cache, driver
from transport.engine.program import Program, build_program, change_steps
from transport.engine.stages import quasi_random
from transport.physics.device import device
from transport.physics.streams import event_words, philox_rounds, random_words
from transport.results.batches import Batch, batch_of
from transport.scene.materials import Mirror
from transport.scene.scene import Scene

NAME, SEED = "extreme", 20240607
ONES = uint64(0xFFFFFFFF)
CHECKED = ("x", "y", "z", "ux", "uy", "uz", "weight")


@device
def extreme_pair(one, other, choice):
    """Both 0, both ones, or what they are, by the last two bits of the choice."""
    low, high = (choice & uint64(3)) == uint64(0), (choice & uint64(3)) == uint64(1)
    one = uint64(0) if low else ONES if high else one
    return one, uint64(0) if low else ONES if high else other


@device
def extreme_words(history, batch, event, purpose, seed_low, seed_high):
    """A block in which each pair of words is extreme with a chance of a half."""
    w0, w1, w2, w3 = random_words(history, batch, event, purpose, seed_low, seed_high)
    c, d, _, _ = philox_rounds(w0, w1, w2, w3, uint64(SEED), uint64(purpose), 7)
    w0, w1 = extreme_pair(w0, w1, c)
    w2, w3 = extreme_pair(w2, w3, d)
    return w0, w1, w2, w3


@device
def extreme_event_words(history, batch, event, purpose, seed_low, seed_high):
    """The same for what may be a copy."""
    w0, w1, w2, w3 = event_words(history, batch, event, purpose, seed_low, seed_high)
    c, d, _, _ = philox_rounds(w0, w1, w2, w3, uint64(SEED), uint64(purpose) & ONES, 7)
    w0, w1 = extreme_pair(w0, w1, c)
    w2, w3 = extreme_pair(w2, w3, d)
    return w0, w1, w2, w3


def scene_of(name: str) -> Scene:
    """A scene whose mirrors lose a tenth: in a dish that loses nothing what leaves it at 1e-8 rad is reflected 1e8 times."""
    scene = SCENES[name]()
    dull = [replace(s, material=Mirror(0.9)) if s.material == Mirror() else s for s in scene.surfaces]
    return replace(scene, surfaces=dull)


def extreme_program(name: str) -> Program:
    """The program of a scene, with draws as above."""
    quasi_random.WORDS[NAME] = quasi_random.twins_of_words(extreme_words, extreme_event_words)
    asked = media_scenes.TRACKINGS.get(name), METHODS.get(name, ANALOG)
    program = build_program(compile_scene(scene_of(name), *asked))
    change_steps(program, lambda steps: quasi_random.quasi_random_steps(steps, NAME))
    return program


def run(name: str, histories: int, batch: int = 0) -> Batch:
    """A batch of that scene.

    Raises LedgerError where weight appears or vanishes; FloatingPointError in plain Python, for a particle that is nowhere.
    """
    program = extreme_program(name)
    if config.DISABLE_JIT:
        driver.call_pass = _looked_at({p.name for p, _ in program.steps})
    with np.errstate(all="ignore"):  # whole numbers that wrap, and what a select throws away
        raw = driver.run_batch(driver.compile_program(program), 1, batch, histories)
    return batch_of(program.plan, raw)


def _looked_at(steps: set[str]):
    """What calls a pass in plain Python, and then looks at every particle that lives; not at shadow rays."""
    particles = []

    def call_pass(entry, bundle, table, first, live):
        particles.append(bundle) if not particles else None  # births come first
        live = entry(bundle, table, first, live)
        if bundle is particles[0] and entry.__name__ in steps:
            _look(entry.__name__, bundle, live)
        return live

    return call_pass


def _look(name: str, bundle, live: int) -> None:
    lives = bundle.weight[:live] != 0
    for field in CHECKED:
        values = getattr(bundle, field)[:live][lives]
        if not np.isfinite(values).all():
            raise FloatingPointError(f"{name} made a {field} of {values[~np.isfinite(values)][:3]}")
    squares = sum(getattr(bundle, field)[:live][lives] ** 2 for field in ("ux", "uy", "uz"))
    if (np.abs(squares - 1) > 1e-9).any():
        raise FloatingPointError(
            f"{name} made directions of squared length {squares[np.abs(squares - 1) > 1e-9][:3]}"
        )


def told(batch: Batch) -> dict[str, object]:
    """What a batch came to, for tests in another process."""
    sums = chain(batch.weights, batch.slants, batch.moments, batch.ledger.values(), [batch.born])
    return {
        "lost": batch.lost,
        "astray": batch.astray,
        "unseen": batch.unseen,
        "crossings": batch.crossings,
        "collisions": batch.collisions,
        "is_finite": bool(np.isfinite(list(sums)).all()),
    }


def main() -> None:
    """Print a line a scene."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", default=list(SCENES))
    parser.add_argument("--histories", type=int, default=100_000)
    asked = parser.parse_args()
    cache.KERNELS = Path(tempfile.mkdtemp())  # what is compiled here is for here alone
    cache.kernel_folder.cache_clear()
    for name in asked.scenes:
        try:
            print(
                f"{name:24s}",
                *(f"{k} {v}" for k, v in told(run(name, asked.histories)).items()),
                flush=True,
            )
        except (ArithmeticError, AssertionError) as error:
            print(f"{name:24s} {type(error).__name__}: {error}", flush=True)


if __name__ == "__main__":
    main()
