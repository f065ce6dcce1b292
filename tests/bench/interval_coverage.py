"""How often the 95 % intervals of single pixels hold the truth: by scene, number of histories and claimed error.

    python -m tests.bench.interval_coverage [SCENE ...] [--seeds 50] [--histories 100 --histories 1000] [--reference 1e8]

One row per scene and number of histories per pixel.  `before` is the coverage of errors from a pixel's own batches,
`after` that of pooled errors, with the share of doubtful pixels, which are left out.  The four quarters of pixels by
claimed error follow, each with its coverage and mean z.  The truth is a run of other random numbers; its own error is
added to that of the pixel.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import typer

import transport as tp
from transport.sims import camera as notebook
from transport.statistics.batches import student_quantile
from transport.viz.showroom import EYES, showroom

SEEDS, HISTORIES, REFERENCE = 50, (100, 300, 1000, 5000), 1e8
SEED_OF_REFERENCE = 10_000_019


class Row(NamedTuple):
    """Coverage of the pixels of all seeds; the last two by quarter of the claimed error."""

    before: float
    after: float
    doubtful: float
    z: float
    coverages: np.ndarray
    means: np.ndarray


def room(ball: object = None, pixels: tuple[int, int] = (24, 18)) -> tp.Scene:
    """A room with a lamp, a camera and a ball of that material, or none."""
    surfaces = [tp.Surface(tp.Box(center=(0, 0, 1), size=2.0), tp.Diffuse(0.5), "room")]
    if ball is not None:
        surfaces.append(tp.Surface(tp.Sphere(center=(0, 0.3, 0.4), radius=0.3), ball, "ball"))
    lamp = tp.Source(tp.Disk(center=(0, 0, 1.9), normal=(0, 0, -1), radius=0.3), tp.Lambertian(radiance=1.0))
    ahead = {"position": (0, -0.9, 1), "look_at": (0, 0.3, 0.5), "field_of_view": 1.2}
    return tp.Scene([lamp], surfaces, [tp.Camera(name="view", pixels=pixels, **ahead)])


def gallery() -> tp.Scene:
    """The room of the gallery, with its map of all directions alone."""
    whole = showroom(EYES)
    return tp.Scene(
        whole.sources, whole.surfaces, [look for look in whole.detectors if look.name == "around"]
    )


SCENES = {
    "none": room,
    "mirror": lambda: room(tp.Mirror()),
    "glass": lambda: room(tp.Dielectric(1.5)),
    "glossy": lambda: room(tp.Glossy(0.3)),
    "gallery": gallery,
    "notebook": notebook.scene,
}


def radiance_of(scene: tp.Scene, particles: int, seed: int) -> tp.EstimateArray:
    """Radiance that the scene's camera or map finds in one run on one thread."""
    (look,) = scene.detectors
    options = {"estimator": "backward", "threads": 1, "progress": False}
    return tp.simulate(scene, particles, seed=seed, **options)[look.name].radiance


def row_of(found: list[tp.EstimateArray], truth: tp.EstimateArray) -> Row:
    """Coverage of these runs against the truth."""
    known = np.array([np.isfinite(each.error) for each in found]) & np.isfinite(truth.error)
    value = np.array([each.value for each in found])
    claimed = np.array([each.error for each in found])
    trusted = known & ~np.array([each.is_doubtful for each in found])
    z, reach = _z(value, claimed, truth), np.array([student_quantile(0.975, each.dof) for each in found])
    inside = np.abs(z) <= reach
    own = np.array([each._replicates.error for each in found])
    alone = np.array([student_quantile(0.975, each._replicates.dof) for each in found])
    before = np.abs(_z(value, own, truth)) <= alone
    quarter = np.digitize(claimed, np.quantile(claimed[trusted], [0.25, 0.5, 0.75]))
    quarters = [trusted & (quarter == k) for k in range(4)]
    return Row(
        before[known].mean(),
        inside[trusted].mean(),
        1 - trusted.sum() / known.sum(),
        z[trusted].mean(),
        np.array([inside[each].mean() for each in quarters]),
        np.array([z[each].mean() for each in quarters]),
    )


def _z(value: np.ndarray, error: np.ndarray, truth: tp.EstimateArray) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return (value - truth.value) / np.hypot(error, truth.error)


def rows(name: str, histories: tuple[int, ...], seeds: int, reference: float) -> Iterator[tuple[int, Row]]:
    """A row per number of histories per pixel."""
    scene = SCENES[name]()
    truth = radiance_of(scene, int(reference), SEED_OF_REFERENCE)
    for each in histories:
        particles = each * math.prod(truth.shape)
        yield each, row_of([radiance_of(scene, particles, seed) for seed in range(seeds)], truth)


def main(
    scenes: list[str] = typer.Argument(None),  # noqa: B008
    seeds: int = SEEDS,
    histories: list[int] = typer.Option(list(HISTORIES)),  # noqa: B008
    reference: float = REFERENCE,
) -> None:
    """Print the table."""
    print("scene     histories | before  after doubtful mean z | coverage by quarter     | mean z by quarter")
    for name in scenes or SCENES:
        for each, row in rows(name, tuple(histories), seeds, reference):
            quarters = " ".join(f"{coverage:.3f}" for coverage in row.coverages)
            means = " ".join(f"{z:+.2f}" for z in row.means)
            numbers = f"{row.before:6.3f} {row.after:6.3f} {row.doubtful:8.3f} {row.z:+6.2f}"
            print(f"{name:9s} {each:9d} | {numbers} | {quarters} | {means}", flush=True)


if __name__ == "__main__":
    typer.run(main)
