"""Rays into the edges and corners of closed boxes: nothing slips out between two walls.

Twelve boxes, turned and shifted at random so that no coordinate is round, each with sixty pencil beams that are aimed at
exact points of its edges and corners.  What breaks the naive ways is shown by planting them: walls without the bound on
their rounding leak where a ray misses both, points left on an edge leak at the next flight.
"""

import sys

import numpy as np
import pytest

import transport as tp
from transport import compile as compiling

simulating = sys.modules[tp.simulate.__module__]

BEAMS, HISTORIES = 60, 100


@pytest.fixture(autouse=True)
def compiled_anew():
    """Scenes are compiled once; a planted fault must not meet or leave a plan of before."""
    for step in ("before", "after"):
        compiling.compile_scene.cache_clear()
        simulating._program.cache_clear()
        if step == "before":
            yield


def boxes():
    random = np.random.default_rng(5)
    for trial in range(12):
        turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
        turn *= np.sign(np.linalg.det(turn))
        lengths, offset = random.uniform(0.3, 2, 3), random.normal(size=3) * (10 if trial % 2 else 0.3)
        yield tp.Scene(
            sources=[beam_into_edge(random, turn, lengths, offset, corner=i % 3 == 0) for i in range(BEAMS)],
            surfaces=[wall(axis, sign, turn, lengths, offset) for axis in range(3) for sign in (-1, 1)],
        )


def wall(axis, sign, turn, lengths, offset):
    along, up = [i for i in range(3) if i != axis]
    center, normal = offset + sign * turn[:, axis] * lengths[axis] / 2, sign * turn[:, axis]
    shape = tp.Rectangle(
        center=center, normal=normal, up=turn[:, up], width=lengths[along], height=lengths[up]
    )
    return tp.Surface(shape, tp.Diffuse(0.7))


def beam_into_edge(random, turn, lengths, offset, corner):
    start, target = random.uniform(-0.4, 0.4, 3) * lengths, random.uniform(-0.5, 0.5, 3) * lengths
    edge = random.permutation(3)[: 3 if corner else 2]
    target[edge] = np.sign(random.normal(size=len(edge))) * lengths[edge] / 2
    return tp.Source(tp.Point(position=offset + turn @ start), tp.Beam(turn @ (target - start), power=1.0))


def escaped() -> float:
    results = [tp.simulate(scene, particles=BEAMS * HISTORIES, seed=1) for scene in boxes()]
    assert all(result.ledger["lost"].value == 0 for result in results)
    return sum(float(result.ledger["escaped"].value) for result in results)


def test_nothing_escapes_through_an_edge_or_a_corner():
    assert escaped() == 0


def test_walls_without_a_bound_on_rounding_leak(monkeypatch):
    """Planted: a wall ends at its exact half width, as if a crossing's place were known exactly."""
    fill = compiling._member_row

    def exact_walls(member, space, code, sheet):
        row = fill(member, space, code, sheet)
        row["half_u"], row["half_v"] = (
            member.shape.width / 2 / space.size,
            member.shape.height / 2 / space.size,
        )
        return row

    monkeypatch.setattr(compiling, "_member_row", exact_walls)
    assert escaped() > 0


def test_points_left_on_an_edge_leak(monkeypatch):
    """Planted: a point within rounding of an edge stays there, perhaps beyond the neighbour's plane."""
    monkeypatch.setattr(compiling.Plan, "has_walls", property(lambda plan: False))
    assert escaped() > 0
