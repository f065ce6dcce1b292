"""Every plain scene saved, loaded, made of parts and gone on with: bit for bit the run that was not.

python -m tests.bench.saves [SCENE ...]
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import typer

import transport as tp
from tests.media_scenes import TRACKINGS
from tests.plain_scenes import METHODS, SCENES
from tests.same_batches import assert_same
from transport.compile.methods import ANALOG

PARTICLES, MORE = 803, 2000


def check(name: str, path: Path) -> None:
    """Raises AssertionError where something is not the same."""
    scene = SCENES[name]()
    how = {"estimator": METHODS.get(name, ANALOG).estimator, "seed": 9, "batches": 8}
    how |= {"tracking": TRACKINGS[name]} if name in TRACKINGS else {}
    whole = tp.simulate(scene, particles=PARTICLES, **how)
    whole.save(path)
    loaded = tp.load(path)
    assert_same(loaded.batches, whole.batches)
    assert loaded.report() == whole.report()
    parts = [tp.simulate(scene, particles=PARTICLES, part=(k, 3), **how) for k in (1, 2, 3)]
    assert_same(tp.merge(*parts).batches, whole.batches)
    from_file = tp.simulate(loaded.scene, particles=MORE, resume=path)
    assert_same(from_file.batches, tp.simulate(scene, particles=MORE, resume=whole).batches)


def main(names: list[str] = typer.Argument(None)) -> None:  # noqa: B008
    """Check the scenes, one file format after the other."""
    names = names or list(SCENES)
    with tempfile.TemporaryDirectory() as folder:
        for number, name in enumerate(names):
            check(name, Path(folder) / f"{number}{('.nc', '.npz')[number % 2]}")
    print(f"{len(names)} scenes the same")


if __name__ == "__main__":
    typer.run(main)
