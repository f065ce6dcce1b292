"""Point detectors against exact fluence rates after scattering: in fog, beams, voxels and furnaces.

Each judgement fails right code in one of 10^6 seeds; the seeds are fixed.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import transport as tp
from tests.agreement import assert_agrees, smallest_bias
from tests.point_scenes import FOG, LAMP, M, V, filled, seen, straight
from transport.theory import point_source


@pytest.mark.parametrize("tracking", ["weighted", "analog"])
def test_a_point_source_in_fog_against_its_transform(tracking):
    distances = (0.1, 0.5, 1.0, 2.0, 5.0)
    places = [(0.6 * r, 0, 0.8 * r) for r in distances]
    *found, _ = seen(LAMP, places, particles=300_000, medium=FOG, tracking=tracking, seed=2)
    for estimate, r in zip(found, distances, strict=True):
        assert_agrees(estimate, 2 * point_source.fluence_rate(r, 1.0, 0.9), 1e-6)
    assert smallest_bias(found[0]) < 0.01 and smallest_bias(found[2]) < 0.06


def test_in_a_fog_that_seldom_scatters_it_is_not_the_source_alone():
    """What scattering adds stands out by tens of errors."""
    near, _ = seen(LAMP, [(1, 0, 0)], particles=300_000, medium=M(0.1, 0.05))
    assert_agrees(near, 2 * point_source.fluence_rate(1.0, 0.15, 1 / 3), 1e-6)
    assert near.value - straight(1, 0.15) > 30 * near.error


PHASES = {
    "isotropic": tp.Isotropic(),
    "forwards": tp.HenyeyGreenstein(0.7),
    "backwards": tp.HenyeyGreenstein(-0.4),
    "rayleigh": tp.Rayleigh(),
    "table": tp.Tabulated(mu=[-1, -0.2, 0.5, 1], density=[0.3, 0.1, 0.6, 2.0]),
    "mixture": tp.Mixture({tp.HenyeyGreenstein(0.8): 0.6, tp.Rayleigh(): 0.4}),
}


@pytest.mark.parametrize("name", PHASES)
def test_light_scattered_once_from_a_pencil_beam(name):
    """In a box so thin that light is scattered once at most: the integral along the beam of p(mu) / r^2."""
    sigma, phase = 1e-12, PHASES[name]
    pencil = tp.Source(tp.Point(position=(0, 0, -1)), tp.Beam((0, 0, 1), power=1.0))
    places = [(0.5, 0, 0.2), (0.3, 0.4, 2.0), (0, -0.6, -1.5)]
    *found, result = seen(
        pencil, places, [filled(tp.Box(size=2.0), M(scattering=sigma, phase=phase))], particles=200_000
    )
    for estimate, (x, y, z) in zip(found, places, strict=True):

        def density(t, d2=x * x + y * y, z=z):
            r = math.sqrt(d2 + (z - t) ** 2)
            return phase.density((z - t) / r) / r**2

        corners = [z] if -1 < z < 1 else None
        exact = sigma * quad(density, -1, 1, points=corners, epsabs=0, epsrel=1e-10, limit=500)[0]
        if estimate.relative_error < 1e-9:  # where all scores are alike
            assert estimate.value == pytest.approx(exact, rel=1e-9)
        else:
            assert_agrees(estimate, exact, 1e-6)
        assert smallest_bias(estimate) < 0.03
    assert not result.warnings


@pytest.mark.parametrize("name", PHASES)
def test_a_speck_in_a_beam_sends_to_each_side_what_its_phase_function_says(name):
    """All that is scattered is seen under one angle: each point knows p(mu) to a millionth."""
    phase, radius, sigma, r = PHASES[name], 1e-5, 1e-6, 2.0
    pencil = tp.Source(tp.Point(position=(0, 0, -1)), tp.Beam((0, 0, 1), power=2.0))
    cosines = np.array([-0.9, -0.35, 0.0, 0.2, 0.65, 0.999])  # between the table's kinks
    sines = np.sqrt((1 - cosines) * (1 + cosines))
    places = r * np.stack([0.6 * sines, 0.8 * sines, cosines], axis=1)
    speck = filled(tp.Sphere(radius=radius), M(scattering=sigma, phase=phase))
    *found, _ = seen(pencil, [tuple(place) for place in places], [speck])
    exact = 2.0 * sigma * 2 * radius * phase.density(cosines) / r**2
    assert [estimate.value for estimate in found] == pytest.approx(exact, rel=2e-6)


def test_it_agrees_with_a_small_volume_detector():
    ball = tp.Sphere(center=(0.4, 0.2, 0.3), radius=0.05)
    voxels = np.random.default_rng(3).uniform(0.2, 2.0, (3, 4, 5))
    grid = tp.Grid(box=tp.Box(size=2.0), absorption=0.3 * voxels, scattering=voxels, phase=tp.Rayleigh())
    lamp = tp.Source(tp.Point(position=(-0.5, 0, 0)), tp.Isotropic(power=1.0))
    volume = tp.VolumeDetector(ball, name="ball")
    for tracking in ("weighted", "analog"):
        medium = M(0.3, 1.5, phase=tp.HenyeyGreenstein(0.5))
        for filling in (medium, grid):
            body = filled(tp.Box(size=2.0), filling)
            point, result = seen(
                lamp, [ball.center], [body], particles=200_000, extra=[volume], tracking=tracking
            )
            assert_agrees(point - result["ball"].fluence_rate, 0.0, 1e-6)
            assert 3 * point.error < result["ball"].fluence_rate.error


@pytest.mark.parametrize("tracking", ["weighted", "analog"])
@pytest.mark.parametrize("g", [0.6, -0.4])
def test_about_a_lamp_in_a_ball_of_fog_points_read_what_thin_shells_do(g, tracking):
    """Within the fog by detours, beyond it by flights; a cosine of the wrong sign or a lost exp(-tau) shows."""
    ball = filled(tp.Sphere(radius=1.5), M(0.8, 1.2, tp.HenyeyGreenstein(g)))
    radii = (0.8, 2.0)
    shells = [
        tp.VolumeDetector(tp.Sphere(radius=1.01 * r), f"{k}", (0.99 * r, 1.01 * r))
        for k, r in enumerate(radii)
    ]
    places = [(0.6 * r, 0, 0.8 * r) for r in radii]
    *points, result = seen(LAMP, places, [ball], particles=200_000, extra=shells, tracking=tracking)
    for k, point in enumerate(points):
        shell = result[f"{k}"].fluence_rate[0]
        assert_agrees(point - shell, 0.0, 1e-6)
        assert max(smallest_bias(point), smallest_bias(shell)) < 0.08


def test_a_point_beyond_a_scattering_slab_sees_what_leaks_through():
    """A wide source: beyond the slab the point sees what a large flat box about it does."""
    slab = tp.Slab(center=(0, 0, -1), thickness=2.0)
    medium = M(0.2, 1.0, phase=tp.HenyeyGreenstein(0.5))
    lamp = tp.Source(tp.Disk(center=(0, 0, -2.5), radius=30.0), tp.Lambertian(radiance=1.0))
    meter = tp.VolumeDetector(tp.Box(center=(0, 0, 1), size=(6, 6, 0.2)), name="beyond")
    point, result = seen(lamp, [(0, 0, 1)], [filled(slab, medium)], particles=200_000, extra=[meter])
    assert_agrees(point - result["beyond"].fluence_rate, 0.0, 1e-6)
    assert point.error < 0.05 * point.value


def test_splitting_and_weights_leave_the_mean_as_it_is():
    splitting = tp.Splitting(start=(0, 0, 0), end=(0, 0, 3), gain=20)
    found = [
        seen(LAMP, [(0, 0, 3)], particles=50_000, medium=FOG, seed=4, tracking=tracking)[0]
        for tracking in (
            "analog",
            "weighted",
            tp.Tracking(roulette=0.9),
            tp.Tracking(forced=True),
            tp.Tracking(splitting=splitting),
        )
    ]
    for estimate in found:
        assert_agrees(estimate, 2 * point_source.fluence_rate(3.0, 1.0, 0.9), 1e-6)


def test_what_scatters_elsewhere_is_told_from_flights_the_rest_by_detours():
    """The fog in pieces: about the point one body, elsewhere others of the very same medium."""
    pieces = [
        filled(tp.Sphere(center=(1, 0, 0), radius=0.3), FOG),
        filled(tp.Box(center=(-1, 0, 0), size=1.0), FOG),
        filled(tp.Box(center=(1, 0, 0), size=1.0), FOG),
    ]
    for tracking in ("weighted", "analog"):
        inside, beside, _ = seen(
            LAMP, [(1, 0.1, 0), (0, 1, 0)], pieces, particles=100_000, medium=FOG, tracking=tracking
        )
        for estimate, r in ((inside, math.hypot(1, 0.1)), (beside, 1.0)):
            assert_agrees(estimate, 2 * point_source.fluence_rate(r, 1.0, 0.9), 1e-6)
            assert smallest_bias(estimate) < 0.06


@pytest.mark.parametrize("filling", ["glow", "forwards", "grid", "ball"])
def test_in_a_furnace_light_is_the_same_everywhere(filling):
    """Walls and media that all emit by the radiance 1 give phi = 4 pi, whatever they do."""
    phase = {"forwards": tp.HenyeyGreenstein(0.5), "ball": tp.Rayleigh()}.get(filling, tp.Isotropic())
    medium = M(0.5, 2.0, phase, emission=0.5) if filling != "forwards" else M(0.0, 3.0, phase)
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.6), "wall", inside=medium)
    surfaces, place = [wall], (0.3, 0.1, 0.2)
    if filling in ("grid", "ball"):
        surfaces = [tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.6), "wall", inside=V)]
        voxels = np.random.default_rng(5).uniform(0.5, 4.0, (3, 2, 4))
        inner = tp.Grid(box=tp.Box(size=0.9), scattering=voxels, phase=phase)
        surfaces.append(filled(inner.box, inner))
    if filling == "ball":
        surfaces.append(
            filled(tp.Sphere(center=(0.1, 0, 0), radius=0.3), M(0.0, 2.0, tp.HenyeyGreenstein(-0.5)))
        )
    lamp = tp.Source("wall", tp.Lambertian(exitance=0.4 * math.pi), side="back")
    inside, outer, _ = seen(lamp, [place, (0, 0.75, 0.1)], surfaces, particles=200_000, seed=11)
    for estimate in (inside, outer):
        assert_agrees(estimate, 4 * math.pi, 1e-6)
        assert smallest_bias(estimate) < 0.09
