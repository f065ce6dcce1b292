"""Lamps and beams that begin exactly on the boundary of a medium.

Each scene has an exact value; its ledger closes and nothing is lost.  Runs have seed 1; each judgement fails right code in
one of 10^5 seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.hard.media_at_limits import DARK, FALSE_ALARM, FORCED, absorbed, beam, body, run


def _absorbed_in_a_ball_from_its_surface():
    """Of isotropic light from a place on a ball of radius 1, absorption 1: half enters, with chords 2 mu."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    mu = (nodes + 1) / 2
    return 0.5 * ((weights / 2) @ -np.expm1(-2 * mu))


def _absorbed_in_a_slab_from_its_face(tau):
    from transport.theory import attenuation

    return 0.5 * (1 - float(attenuation.exponential_integral(2, tau)))


LAMP = tp.Isotropic(power=1.0)


def test_a_lamp_on_the_face_of_a_ball_lights_it_with_half_of_its_light():
    lamp = tp.Source(tp.Point(position=(0, 0, 1)), LAMP)
    result = run(tp.Scene(lamp, body(tp.Sphere(radius=1.0), DARK), ()))
    assert_agrees(result.ledger["absorbed"], _absorbed_in_a_ball_from_its_surface(), FALSE_ALARM)


@pytest.mark.parametrize("way", [1, -1])
def test_a_lamp_on_the_face_of_a_slab_lights_it_with_half_of_its_light(way):
    slab = tp.Slab(center=(0.3, 0, -0.25 * way), thickness=0.5)
    result = run(tp.Scene(tp.Source(tp.Point(), LAMP), body(slab, tp.Medium(absorption=2.0)), ()))
    assert_agrees(result.ledger["absorbed"], _absorbed_in_a_slab_from_its_face(1.0), FALSE_ALARM)


@pytest.mark.parametrize("tracking", [None, "analog", FORCED])
def test_a_lamp_in_the_interface_of_two_layers_is_a_lamp_in_one(tracking):
    lamp, mist = tp.Source(tp.Point(), LAMP), {"absorption": 0.3, "scattering": 2.0}
    two = [
        body(tp.Slab(center=(0, 0, z), thickness=1.0), tp.Medium(**mist, phase=tp.HenyeyGreenstein(g)))
        for z, g in ((0.5, 1e-12), (-0.5, 2e-12))
    ]
    one = [body(tp.Slab(thickness=2.0), tp.Medium(**mist))]
    apart, together = (run(tp.Scene(lamp, surfaces, ()), tracking).ledger for surfaces in (two, one))
    assert_agrees(apart["escaped"] - together["escaped"], 0.0, FALSE_ALARM)
    assert together["escaped"].relative_error < 0.01


@pytest.mark.parametrize(("corner", "octants"), [((0.5, 0, 0), 4), ((0.5, 0.5, 0), 2), ((0.5, 0.5, 0.5), 1)])
def test_a_lamp_on_a_face_an_edge_or_a_corner_of_a_box(corner, octants):
    """The light that enters is that of octants; it is compared with that of a place just within."""
    box = body(tp.Box(size=1.0), DARK)
    on, within = (
        run(tp.Scene(tp.Source(tp.Point(position=place), LAMP), box, ())).ledger
        for place in (corner, [x * (1 - 1e-9) for x in corner])
    )
    assert_agrees(on["absorbed"] - within["absorbed"], 0.0, FALSE_ALARM)
    assert on["absorbed"].value < octants / 8


@pytest.mark.parametrize(
    ("place", "way", "chord"),
    [
        ((0.5, 0, 0), (-1, 0, 0), 1.0),
        ((0.5, 0, 0), (1, 0, 0), 0.0),
        ((0.5, 0.5, 0), (-1, -1, 0), math.sqrt(2)),
        ((0.5, 0.5, 0.5), (-1, -1, -1), math.sqrt(3)),
    ],
)
def test_beams_from_a_face_an_edge_or_a_corner(place, way, chord):
    scene = tp.Scene(beam(place, np.array(way) / np.linalg.norm(way)), body(tp.Box(size=1.0), DARK), ())
    assert absorbed(scene) == pytest.approx(-math.expm1(-chord), rel=1e-12)
