"""Media whose numbers are at their ends: depths from 1e-12 to 1e4, albedo next to 1, peaks straight on and straight back.

Each scene has an exact value; its ledger closes and nothing is lost.  Runs have seed 1; each judgement fails right code in
one of 10^5 seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.hard.media_at_limits import (
    FALSE_ALARM,
    FORCED,
    beam,
    body,
    faces,
    fog,
    returned_and_passed,
    run,
)
from transport.theory import ordinates


@pytest.mark.parametrize("tau", [1e-12, 1e-9, 1e-4])
@pytest.mark.parametrize("absorption", ["weighted", "analog"])
def test_next_to_nothing_scatters_once_where_that_is_forced(tau, absorption):
    """Half of tau scatters, half of that upwards; second collisions are of the order tau^2 log tau."""
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)), body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(tau, 0.5)), faces()
    )
    result = run(scene, tp.Tracking(absorption=absorption, forced=True))
    up, down = returned_and_passed(result)
    exact = ordinates.slab(tau, 0.5) if tau > 1e-6 else None
    upwards = exact.reflected if exact else 0.25 * tau
    assert_agrees(up, upwards, FALSE_ALARM)
    assert up.relative_error < 0.01
    assert_agrees(down, 1 - 3 * upwards, FALSE_ALARM * 10) if exact is None else assert_agrees(
        down, exact.transmitted, FALSE_ALARM
    )
    with pytest.raises(AssertionError):
        assert_agrees(up, 0.5 * tau, FALSE_ALARM)


@pytest.mark.parametrize("tau", [1e-12, 1e-9])
@pytest.mark.parametrize("tracking", ["weighted", "analog"])
def test_next_to_nothing_lets_all_through(tau, tracking):
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)), body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(tau, 0.5)), faces()
    )
    result = run(scene, tracking)
    assert result["below"].flux_in.value == pytest.approx(1.0, abs=tau)
    if tracking == "weighted":
        assert result.ledger["absorbed"].value == pytest.approx(tau / 2, rel=1e-3)


@pytest.mark.parametrize("tracking", ["weighted", "analog", FORCED])
@pytest.mark.parametrize(("albedo", "g"), [(0.5, 0.0), (0.9, 0.75), (0.99, -0.5)])
def test_ten_thousand_mean_free_paths_are_a_half_space(albedo, g, tracking):
    exact = ordinates.half_space(albedo, ordinates.henyey_greenstein(g))
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)),
        body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(1e4, albedo, g)),
        faces(),
    )
    result = run(scene, tracking, 20_000)
    assert_agrees(result["above"].flux_in, exact.reflected, FALSE_ALARM)
    assert result["below"].flux_in.value == 0


@pytest.mark.parametrize("tracking", ["weighted", "analog", FORCED])
def test_an_albedo_of_one_less_a_billionth(tracking):
    exact = ordinates.slab(2.0, 1.0)
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)),
        body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(2.0, 1 - 1e-9)),
        faces(),
    )
    result = run(scene, tracking)
    up, down = returned_and_passed(result)
    assert_agrees(up, exact.reflected, FALSE_ALARM)
    assert up.value + down.value == pytest.approx(1, abs=1e-7)
    if tracking == "weighted":  # absorbed: 1e-9 of the collisions
        collisions = result.cost.collisions / 50_000
        assert result.ledger["absorbed"].value == pytest.approx(1e-9 * collisions, rel=0.02)


@pytest.mark.parametrize("tracking", ["weighted", "analog", FORCED])
@pytest.mark.parametrize("g", [1e-15, -1e-15, 1e-300])
def test_next_to_no_asymmetry_is_none(g, tracking):
    """To the last digit what isotropic scattering in a loop of its own gives, or as near as errors tell."""
    exact = ordinates.slab(2.0, 0.9)
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)),
        body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(2.0, 0.9, g)),
        faces(),
    )
    for estimate, value in zip(
        returned_and_passed(run(scene, tracking)), (exact.reflected, exact.transmitted), strict=True
    ):
        assert_agrees(estimate, value, FALSE_ALARM)


def _small_angles(tau, albedo, g):
    """Of scattering through angles of g -> 1: straight on, so that only absorption counts.  Of g -> -1: the two-stream slab.

    With every scattering back along the same line, up and down: R, T of two streams with backward scattering.
    """
    if g > 0:
        return 0.0, math.exp(-(1 - albedo) * tau)
    rate = math.sqrt(1 - albedo**2)
    denominator = rate * math.cosh(rate * tau) + math.sinh(rate * tau)
    return albedo * math.sinh(rate * tau) / denominator, rate / denominator


@pytest.mark.parametrize("tracking", ["weighted", "analog", FORCED])
@pytest.mark.parametrize("g", [1 - 1e-9, -1 + 1e-9])
def test_peaks_straight_on_and_straight_back_are_lines(g, tracking):
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)),
        body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(2.0, 0.9, g)),
        faces(),
    )
    up, down = returned_and_passed(run(scene, tracking))
    exact = _small_angles(2.0, 0.9, g)
    assert abs(up.value - exact[0]) <= 4.42 * (up.error if exact[0] else 0) + 1e-4
    assert abs(down.value - exact[1]) <= 4.42 * (down.error if np.isfinite(down.error) else 0) + 1e-4


@pytest.mark.parametrize("g", [0.999, -0.999])
def test_narrow_peaks_keep_what_all_phases_keep(g):
    """R + T + A = 1 and, all ways of following them, the same R and T."""
    scene = tp.Scene(
        beam((0, 0, 1), (0, 0, -1)),
        body(tp.Slab(center=(0, 0, -0.5), thickness=1.0), fog(2.0, 0.9, g)),
        faces(),
    )
    weighted, analog, forced = (
        returned_and_passed(run(scene, t, 100_000)) for t in ("weighted", "analog", FORCED)
    )
    lines = _small_angles(2.0, 0.9, g)
    for part in (0, 1):
        for other in (analog, forced):
            assert_agrees(weighted[part] - other[part], 0.0, FALSE_ALARM)
        assert weighted[part].value == pytest.approx(lines[part], abs=0.02)


@pytest.mark.parametrize(
    "wall", [tp.Mirror(), tp.Dielectric(1.5, 1.5), tp.Diffuse(1.0)], ids=["mirror", "no change", "white"]
)
def test_a_box_of_conservative_fog_keeps_or_passes_all(wall):
    """Nothing is absorbed: against the clock all is in flight; without one all gets out of what lets light out."""
    mist = tp.Medium(scattering=3.0, phase=tp.HenyeyGreenstein(0.5), index=1.5)
    is_open = isinstance(wall, tp.Dielectric)
    surfaces = tp.Surface(tp.Box(size=1.0), wall, "box", inside=mist)
    around = tp.Medium(index=1.5) if is_open else None
    lamp = tp.Source(tp.Point(position=(0.1, 0.2, 0.3)), tp.Isotropic(power=1.0))
    ledger = run(tp.Scene(lamp, surfaces, (), medium=around, duration=1e-7), "analog", 2_000).ledger
    assert ledger["absorbed"].value == 0
    assert ledger["in_flight"].value == pytest.approx(1e-7, rel=1e-14)
    if is_open:
        ledger = run(tp.Scene(lamp, surfaces, (), medium=around), None, 2_000).ledger
        assert ledger["escaped"].value == pytest.approx(1, rel=1e-14)


@pytest.mark.parametrize("gap", [0.0, 1e-15, 1e-13, 1e-12, 1e-11])
def test_a_meter_a_thin_gap_beyond_the_outermost_face_sees_what_leaves(gap):
    """What is taken for gone at the last face must not have a meter before it, however near."""
    slab = body(tp.Slab(center=(0, 0, -1 - gap), thickness=2.0), tp.Medium(absorption=0.1, scattering=0.9))
    scene = tp.Scene(beam((0, 0, 1), (0, 0, -1)), slab, tp.Detector(tp.Plane(), "top"))
    result = run(scene, "analog")
    exact = ordinates.slab(2.0, 0.9, mu0=1.0).reflected
    assert_agrees(result["top"].flux_out, float(exact), FALSE_ALARM)
