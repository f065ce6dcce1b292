"""The same seed gives the same bits: whatever the threads, the order of batches or the size of bundles."""

import hashlib

import numpy as np

import transport as tp
from transport.compile.compiler import compile_scene

MATERIALS = tp.Diffuse(0.7), tp.Diffuse(0.2), tp.Mirror(0.9), tp.Black(), tp.Diffuse(0.5), tp.Mirror()


def scene() -> tp.Scene:
    """A bit of everything: three materials, a ball, two sources of which one aims, bins of all kinds."""
    meter = tp.Disk(center=(0.2, 0.1, 0.3), radius=0.3)
    faces = tp.Box(size=2.0).faces()
    walls = [
        tp.Surface(faces[name], material, name=name) for name, material in zip(faces, MATERIALS, strict=True)
    ]
    walls.append(tp.Surface(tp.Sphere(center=(-0.4, 0, 0), radius=0.3), tp.Diffuse(0.8), name="ball"))
    lamp = tp.Source(tp.Point(position=(0.5, 0, 0)), tp.Isotropic(power=2.0), aim=meter)
    bins = {"directions": tp.Directions(mu=4, phi=3), "positions": tp.Positions(u=2)}
    return tp.Scene(
        sources=[tp.Source("+z", tp.Lambertian(radiance=3.0), side="back"), lamp],
        surfaces=walls,
        detectors=[
            tp.Detector(meter, name="meter", **bins),
            tp.Detector("-z", side="back", directions=tp.Directions(mu=[0, 0.1, 1])),
            tp.Detector("ball", positions=tp.Positions(u=4, v=2)),
        ],
    )


def digest(scene, **options) -> str:
    """Of everything that a run counted."""
    result = tp.simulate(scene, particles=20_000, seed=7, batches=8, **options)
    sums = hashlib.sha256()
    for batch in result.batches:
        for part in (
            batch.weights,
            batch.counts,
            batch.slants,
            batch.absorbed,
            np.array(list(batch.ledger.values())),
        ):
            sums.update(np.ascontiguousarray(part).tobytes())
    return sums.hexdigest()


def test_one_thread_and_more_threads_count_the_same():
    assert len({digest(scene(), threads=threads) for threads in (1, 2, 3)}) == 1


def test_running_twice_gives_the_same_and_another_seed_does_not():
    assert digest(scene()) == digest(scene())
    other = tp.simulate(scene(), particles=20_000, seed=8, batches=8)
    assert (
        other["meter"].flux_in.value
        != tp.simulate(scene(), particles=20_000, seed=7, batches=8)["meter"].flux_in.value
    )


def test_batches_are_pure_functions_of_their_number():
    from transport.engine.driver import compile_program, run_batch
    from transport.engine.program import build_program

    machine = compile_program(build_program(compile_scene(scene())))
    forwards = {number: run_batch(machine, 3, number, 1000) for number in range(4)}
    backwards = {number: run_batch(machine, 3, number, 1000) for number in reversed(range(4))}
    for number, raw in forwards.items():
        np.testing.assert_array_equal(raw.detectors, backwards[number].detectors)
        np.testing.assert_array_equal(raw.ledger, backwards[number].ledger)
    assert not np.array_equal(forwards[0].detectors, forwards[1].detectors)


def test_a_history_does_not_depend_on_the_histories_beside_it():
    """A batch of 300 histories begins with the 200 histories of a smaller batch of the same number (one source)."""
    from transport.engine.driver import compile_program, run_batch
    from transport.engine.program import build_program

    single = tp.Scene(sources=scene().sources[:1], surfaces=scene().surfaces, detectors=scene().detectors)
    machine = compile_program(build_program(compile_scene(single)))
    small, large = (run_batch(machine, 3, 0, n).detectors for n in (200, 300))
    assert (large[:, 2] >= small[:, 2]).all()
