"""Walks of rays through cells of equal size: each step is to the neighbour through the nearest face, and lengths add up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from transport.physics.cells import enter_cells, nearest_face, next_cell

COUNT, WIDTH = (4, 5, 6), (0.25, 0.5, 2.0)
SIZE = np.multiply(COUNT, WIDTH)


def parts(origin, direction, start, end):
    """Cells of a walk, and the distances at which it enters and leaves each."""
    per_length = tuple(1.0 / width for width in WIDTH)
    axes, cell, faces = enter_cells(origin, direction, start, per_length, WIDTH, COUNT)
    found, t = [], start
    while len(found) <= sum(COUNT):
        face = nearest_face(faces)
        found.append((tuple(map(int, np.unravel_index(cell[0], COUNT))), t, min(face, end)))
        if face >= end:
            return found
        t = face
        cell, faces = next_cell(axes, cell, faces)
    raise AssertionError("the walk does not end")


def rays(count=200):
    """Origins and directions of rays inside the cells, and how far these reach."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        origin, u = rng.uniform(0.0, SIZE), rng.normal(size=3)
        u /= np.linalg.norm(u)
        reach = np.min((np.where(u > 0, SIZE, 0.0) - origin) / u)
        yield tuple(origin.tolist()), tuple(u.tolist()), float(reach)


def test_each_part_of_a_ray_lies_in_its_cell_and_begins_where_the_last_one_ended():
    for origin, u, reach in rays():
        found = parts(origin, u, 0.0, reach)
        assert [before for _, before, _ in found[1:]] == [after for *_, after in found[:-1]]
        assert found[0][1] == 0.0 and found[-1][2] == reach
        for cell, before, after in found:
            middle = np.add(origin, np.multiply(0.5 * (before + after), u))
            assert after <= before + 1e-12 or tuple(np.floor(middle / WIDTH).astype(int)) == cell


@pytest.mark.parametrize("beyond", [1e-15, 1e-3, 10.0])
def test_a_ray_ends_in_the_last_cell_however_far_its_end_lies_beyond(beyond):
    """Rounding puts the end of a flight behind the last face, and this part of its length must not be lost."""
    for origin, u, reach in rays(50):
        found = parts(origin, u, 0.0, reach + beyond)
        assert found[-1][2] == reach + beyond
        steps = np.diff([cell for cell, *_ in found], axis=0)
        assert (np.abs(steps).sum(axis=1) == 1).all()  # each to a neighbour, so none beyond the last face


@pytest.mark.parametrize("u", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 1e-300, -1e-310)])
@pytest.mark.parametrize("origin", [(0.5, 1.0, 4.0), (0.0, 2.5, 0.0), (0.3, 0.7, 1.1)])
def test_a_ray_along_an_axis_stays_in_its_row_even_on_a_face(u, origin):
    axis = int(np.argmax(np.abs(u)))
    cells = np.array([cell for cell, *_ in parts(origin, u, 0.0, 100.0)])
    assert (np.delete(cells, axis, axis=1) == np.delete(cells[0], axis)).all()
    assert (np.diff(cells[:, axis]) == math.copysign(1, u[axis])).all()
    assert cells[-1, axis] == (COUNT[axis] - 1 if u[axis] > 0 else 0)
