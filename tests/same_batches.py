"""Whether runs count the same to the last bit."""

import dataclasses
import hashlib

import numpy as np

import transport as tp

MATERIALS = tp.Diffuse(0.7), tp.Diffuse(0.2), tp.Mirror(0.9), tp.Black(), tp.Diffuse(0.5), tp.Mirror()


def assert_same(one, other):
    """Every number of every batch, with its type; and what is said of it."""
    assert len(one) == len(other)
    for batch, like in zip(one, other, strict=True):
        for field in dataclasses.fields(batch):
            value, again = getattr(batch, field.name), getattr(like, field.name)
            assert type(value) is type(again), field.name
            if isinstance(value, np.ndarray):
                assert (value.dtype, value.shape, value.tobytes()) == (
                    again.dtype,
                    again.shape,
                    again.tobytes(),
                )
            else:
                assert value == again, field.name


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


def digest(scene, particles=20_000, **options) -> str:
    """Of everything that a run counted, and of its samples."""
    result = tp.simulate(
        scene, **{"particles": particles, "seed": 7, "batches": 8, "progress": False} | options
    )
    sums = hashlib.sha256()
    for batch in result.batches:
        parts = (batch.weights, batch.counts, batch.slants, batch.absorbed, batch.moments)
        for part in (*parts, np.array(list(batch.ledger.values())), [batch.crossings, batch.collisions]):
            sums.update(np.ascontiguousarray(part).tobytes())
    for look in scene.detectors:
        if isinstance(look, tp.Snapshot):
            shot = result[look.name]
            for part in (shot.positions, shot.velocities, shot.weights, shot.histories):
                sums.update(np.ascontiguousarray(part).tobytes())
    return sums.hexdigest()
