"""Phase space counts every particle that is alive once, at every instant.

What is a law of every history is asked of integers: numbers of histories, or the limbs of exact sums.  All runs
have fixed seeds; statistical judgements fail right code in one of 10^6 seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.phase_scenes import (
    ARRIVALS,
    DEPARTURES,
    HOT,
    PICTURES,
    TIMES,
    faces_with,
    histories,
    kept,
    rows,
    vessel,
    wall_histories,
)
from transport.compile.compiler import compile_scene
from transport.compile.layout import IN_FLIGHT
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program


@pytest.mark.parametrize("picture", [p.name for p in PICTURES])
def test_bins_and_outside_are_all_that_were_emitted_and_not_yet_absorbed(picture):
    """History by history: born at the start, plus all that left walls, less all that arrived at them."""
    result = kept()
    found, counted = result[picture], rows(result, picture)
    arrived, left = (wall_histories(result, side) for side in (ARRIVALS, DEPARTURES))
    gas = result.particles - born_at_walls(result)
    alive = gas - (arrived - left).sum(axis=0)
    np.testing.assert_array_equal(counted.sum(axis=1), alive)
    np.testing.assert_array_equal(histories(result, found.alive.value), alive)
    number = histories(result, found.number.value).reshape(len(TIMES), -1)
    np.testing.assert_array_equal(number, counted[:, 1:])
    np.testing.assert_array_equal(histories(result, found.outside.value), counted[:, 0])
    assert (counted[:, 0] > 0).all() and len(set(alive)) == len(TIMES)


def born_at_walls(result):
    """Histories of the last two sources: shares 4 and 2 of 12 to the last, as batches are dealt out systematically."""
    left = wall_histories(result, DEPARTURES)[4:, -1]  # black walls: what leaves them was born there
    share = left / result.particles
    np.testing.assert_allclose(share, [4 / 12, 2 / 12], atol=2e-3)
    return left.sum()


def test_what_is_alive_at_the_end_is_what_the_ledger_has_in_flight():
    result = kept()
    in_flight = histories(result, result.ledger["in_flight"].value)
    for picture in PICTURES:
        assert rows(result, picture.name)[-1].sum() == in_flight
        assert result[picture.name].alive[-1].value == result.ledger["in_flight"].value
    assert 0 < in_flight < result.particles


def test_weights_that_walls_and_roulette_have_changed_are_conserved_to_the_last_limb():
    """Numbers in the unit 2^-63 of the largest weight: phase space at the end against the ledger."""
    kinds = (
        tp.Diffuse(0.9),
        tp.Mirror(0.3),
        tp.Diffuse(0.2, speed=HOT),
        tp.Mirror(),
        tp.Diffuse(0.7),
        tp.Black(),
    )
    plan = compile_scene(vessel(faces_with(*kinds), PICTURES))
    raw = run_batch(compile_program(build_program(plan)), 1, 0, 20_000)
    flying = whole(raw.ledger[IN_FLIGHT])
    for picture in PICTURES:
        bins = math.prod(len(edges) - 1 for edges in picture.axes.values())
        last = plan.rows_of[picture.name].first + (len(TIMES) - 1) * (1 + bins)
        assert sum(map(whole, raw.detectors[last : last + 1 + bins])) == flying
    assert 0 < flying < 20_000 << 63 and flying % (1 << 31) != 0


def whole(row):
    return (int(row[0]) << 31) + int(row[1])


def test_particles_that_meet_a_wall_at_the_instant_itself_are_counted_once():
    """All of them do, at 1 s and 3 s: flights that held both of their ends would count twice, open ones never."""
    gas = tp.Source(tp.Point(), tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1)))
    look = tp.PhaseSpace(z=(-2, 2), vz=(-2, 0, 2), time=(0.0, 1.0, 2.0, 3.0))
    result = tp.simulate(
        tp.Scene(gas, faces_with(*[tp.Mirror()] * 6), look, duration=4.0), particles=1000, seed=1
    )
    found = result["phase_space"]
    assert (histories(result, found.alive.value) == 1000).all()
    upwards = histories(result, found.number.value)[:, 0, 1]
    np.testing.assert_array_equal(upwards, [1000, 0, 0, 1000])
