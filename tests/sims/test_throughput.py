"""Throughput: its closed forms, its conservation through optics, sensors; and wrong optics that the counts reject.

Each statistical judgement fails right code in one of 10^5 seeds; the seed is 1.  A comment such as `B.etendue_discs`
names the entry of the project's reference collection that a number comes from.
"""

from __future__ import annotations

import dataclasses
import math
from functools import partial

import numpy as np
import pytest
from scipy.integrate import dblquad

import transport as tp
from tests.agreement import agrees, assert_agrees, smallest_bias
from transport.sims import throughput
from transport.sims.throughput import BEHIND, FOCAL, HOLE, KEPT, NEAR, READ, RIM, SENSOR, T_1, T_2
from transport.statistics.estimates import Estimate
from transport.statistics.replicates import Batches
from transport.theory import etendue, lenses, optical_paths
from transport.theory.optical_paths import from_to, to_plane

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
BEAMS = throughput.SHOWS[:-1]


def rows(scene=None, particles=1_000_000, **parameters):
    """(estimate, exact) by name, of the sim's scene or of a changed one."""
    scene = throughput.scene(**parameters) if scene is None else scene
    measured = throughput.measure(tp.simulate(scene, particles=particles, seed=1, threads=1))
    return {name: (measured[name], value) for name, value in throughput.exact(**parameters).items()}


# ---- theory ----


def test_throughput_of_a_cone_is_that_of_a_hemisphere_at_its_widest():
    assert etendue.cone_etendue(2.0) == pytest.approx(2 * math.pi, rel=1e-15)
    assert etendue.cone_etendue(2.0, math.pi / 6, 1.5) == pytest.approx(2.25 * math.pi / 2, rel=1e-14)


@pytest.mark.parametrize("slits", [(1.0, 1.0, 1.0), (0.01, 0.02, 1.0), (1e-7, 3.0, 2.0)])
def test_rays_of_a_plane_between_slits_are_counted_by_crossed_strings(slits):
    one, two, distance = slits
    exact, _ = dblquad(
        lambda x, y: distance**2 / math.hypot(distance, x - y) ** 3,
        -one,
        one,
        -two,
        two,
        epsabs=0,
        epsrel=1e-11,
    )
    assert etendue.meridional_etendue(*slits) == pytest.approx(exact, rel=1e-10)


def test_throughput_of_disks_is_the_square_of_that_of_their_slits():
    """pi²/4 (crossed - uncrossed)², 2 (crossed - uncrossed) being the slits'."""
    for case, exact in {(1, 1, 1): 3.7698534257005853, (0.01, 0.02, 1): 3.945868983699782e-07}.items():
        assert (math.pi * etendue.meridional_etendue(*case)) ** 2 / 16 == pytest.approx(exact, rel=1e-14)
        assert etendue.disks_throughput(*case) == pytest.approx(exact, rel=1e-14)  # B.etendue_discs


def area_at(rays, height, index=1.0):
    there = to_plane(rays, height)
    return etendue.outlined_area(there.points[:, 0], index * there.directions[:, 0])


def through_ball(rays):
    return lenses.trace(rays, lenses.ball(0.0, throughput.BALL), 1.5)


OPTICS = {
    "straight on": (lambda rays: rays, 0.05),
    "lens": (partial(optical_paths.bend, height=0.0, focal_length=FOCAL), 0.05),
    "diverging lens": (partial(optical_paths.bend, height=0.0, focal_length=-FOCAL), 0.05),
    "glass ball": (through_ball, 0.02),
    "spherical mirror": (partial(optical_paths.reflect_in_sphere, center=-0.15, radius=0.2), 0.05),
    "paraboloid": (partial(optical_paths.reflect_in_paraboloid, vertex=0.1, focal_length=-FOCAL), 0.05),
}


@pytest.mark.parametrize("name", OPTICS)
def test_optics_keep_the_area_in_phase_space(name):
    """The outermost rays of a beam in the plane of the axis enclose as much of x and p behind the optic as before."""
    optic, rim = OPTICS[name]
    exact = etendue.meridional_etendue(0.01, rim, 0.15)
    areas = []
    for points in (1500, 3000):
        rays = etendue.meridional_outline(0.01, -0.15, rim, 0.0, points)
        assert area_at(rays, -0.1) == pytest.approx(exact, rel=1e-5)
        areas.append(area_at(optic(rays), 0.25 if "mirror" not in name and name != "paraboloid" else -0.3))
    assert (4 * areas[1] - areas[0]) / 3 == pytest.approx(
        exact, rel=1e-9
    )  # polygons approach a curve as 1/n²


def test_within_glass_the_index_belongs_to_throughput():
    rays = etendue.meridional_outline(0.01, -0.15, 0.02, 0.0, 2000)
    inside = optical_paths.refract(rays, 0.0, throughput.BALL, 1.5)
    exact = etendue.meridional_etendue(0.01, 0.02, 0.15)
    assert area_at(inside, 0.0, 1.5) == pytest.approx(exact, rel=1e-6)
    assert area_at(inside, 0.0) == pytest.approx(exact / 1.5, rel=1e-6)


def test_a_lens_that_maps_tangents_makes_rays():
    rays = etendue.meridional_outline(0.01, -0.15, RIM, 0.0, 1000)
    behind = area_at(optical_paths.bend_tangents(rays, 0.0, FOCAL), 0.25)
    assert behind > 1.03 * etendue.meridional_etendue(0.01, RIM, 0.15)


def test_throughput_through_glass_is_the_same_from_either_end():
    """The same beam from aperture 2, whose window is where aperture 1 is; a small aperture and a wide one."""
    faces = lenses.ball(0.15, 0.06)
    for one, two in ((1e-4, 1e-3), (2e-3, 5e-3)):
        seen = [
            lenses.projected_solid_angle(faces, 1.0, a, b, 0.3) * a**2 for a, b in ((one, two), (two, one))
        ]
        assert seen[0] == pytest.approx(seen[1], rel=1e-13)


# ---- beams ----


@pytest.mark.parametrize("show", BEAMS)
def test_rays_count_alike_before_and_behind(show):
    found = rows(show=show)
    for name in (T_1, T_2):
        assert_agrees(*found[name], FALSE_ALARM)
        assert smallest_bias(found[name][0], FALSE_ALARM) < 0.05
    estimate, _ = found[KEPT]
    assert estimate.exact
    assert estimate.value == 0


@pytest.mark.parametrize("show", BEAMS)
def test_all_that_comes_from_aperture_1_reaches_aperture_2(show):
    """But at the flat mirror, where aperture 2 bounds the beam: the exact values rest on it."""
    right = throughput.scene(show=show)
    wider = [
        dataclasses.replace(
            detector, shape=dataclasses.replace(detector.shape, radius=1.5 * detector.shape.radius)
        )
        if detector.name.startswith("two")
        else detector
        for detector in right.detectors
    ]
    one = dataclasses.replace(right, sources=right.sources[:1])
    before, after = (
        tp.simulate(dataclasses.replace(one, detectors=detectors), particles=100_000, seed=1, threads=1)[
            "two"
        ]
        for detectors in (right.detectors, wider)
    )
    if show == "flat mirror":
        assert after.flux_in.value > 1.5 * before.flux_in.value
    else:
        assert after.flux_in.value == before.flux_in.value > 0


def test_an_optic_that_loses_rays_is_seen():
    """A mirror that swallows 2 %: counts differ from T, and what falls on it from what leaves it."""
    right = throughput.scene(show="spherical mirror")
    [mirror] = right.surfaces
    dull = dataclasses.replace(right, surfaces=[dataclasses.replace(mirror, material=tp.Mirror(0.98))])
    found = rows(dull, show="spherical mirror")
    assert not agrees(*found[T_1])
    assert not agrees(*found[T_2])
    assert found[KEPT][0].value > 0
    assert not found[KEPT][0].exact


def test_glass_counts_with_what_it_lets_through():
    found = rows(show="glass ball")
    [estimate, exact] = found[T_2]
    plain = etendue.disks_throughput(0.01, throughput.WINDOW, 1.4 * throughput.BALL)
    assert agrees(estimate, exact)
    assert not agrees(estimate, plain)  # as if Fresnel let all through
    assert not agrees(estimate, math.sqrt(exact * plain))  # as if one face did


def test_what_source_2_sends_back_by_aperture_1_is_taken_off():
    result = tp.simulate(throughput.scene(show="paraboloid"), particles=1_000_000, seed=1, threads=1)
    every = result["two"].flux_in / result["two again"].flux_in
    assert every.value > 1.5
    radiance, exact = result.scene.sources[0].emission.radiance, throughput.exact(show="paraboloid")[T_1]
    assert not agrees(result["two"].flux_in, radiance * exact)


# ---- the planted lens ----

RUN = Batches(np.full(32, 20_000))


def numpy_beams(lens):
    """T of the sim's lens, counted from either end by rays that are followed in numpy: (from 1 to 2, from 2 to 1)."""
    beam, random = throughput.beam_of("lens", 0.01, 1.5), np.random.default_rng(1)
    rim, number = tp.Disk(radius=RIM), RUN.sizes.sum()
    counted = []
    for start, end in ((beam.one, beam.two), (beam.two, beam.one)):
        one, two = (on_disk(disk, random, number) for disk in (start, rim))
        rays = from_to(one, two)
        squares = ((two - one) ** 2).sum(axis=-1)
        weights = rays.directions[:, 2] ** 2 / squares * start.area * rim.area
        ends = to_plane(lens(rays, 0.0, FOCAL), end.center[2]).points
        hits = np.hypot(ends[:, 0], ends[:, 1]) < end.radius
        means = np.where(hits, weights, 0.0).reshape(32, -1).mean(axis=1)
        counted.append(Estimate(means, RUN, "m^2 sr"))
    return counted


def on_disk(disk, random, number):
    r, phi = disk.radius * np.sqrt(random.random(number)), 2 * math.pi * random.random(number)
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.full(number, disk.center[2])], axis=-1)


def test_the_ideal_lens_is_accepted_in_numpy_too():
    exact = throughput.exact(show="lens")[T_1]
    for estimate in numpy_beams(optical_paths.bend):
        assert_agrees(estimate, exact, FALSE_ALARM)


def test_a_lens_that_maps_tangents_is_rejected():
    """The planted fault: as many rays leave aperture 1, but behind the lens they take up more of phase space."""
    exact = throughput.exact(show="lens")[T_1]
    there, back = numpy_beams(optical_paths.bend_tangents)
    assert agrees(there, exact)  # in the coordinates of aperture 1 nothing has happened yet
    assert not agrees(back, exact)
    assert back.value > exact


# ---- sensors ----


@pytest.mark.parametrize("distance", [0.05, 0.5, 50.0])
def test_a_sensor_reads_radiance_times_throughput(distance):
    for name, (estimate, exact) in rows(show="sensor", distance=distance).items():
        assert_agrees(estimate, exact, FALSE_ALARM)
        assert smallest_bias(estimate, FALSE_ALARM) < 0.1, name


def test_a_response_that_falls_with_the_walls_distance_is_rejected():
    near, far = (rows(show="sensor", distance=distance) for distance in (0.5, 1.0))
    for name, (estimate, _) in far.items():
        assert not agrees(estimate, near[name][0].value / 4)


def test_a_wall_that_does_not_fill_the_sensors_view_is_seen():
    right = throughput.scene(show="sensor", distance=5.0)
    [source] = right.sources
    small = dataclasses.replace(
        source, shape=dataclasses.replace(source.shape, radius=0.3 * source.shape.radius)
    )
    found = rows(dataclasses.replace(right, sources=small), show="sensor", distance=5.0)
    first, last = (found[READ.format(place)] for place in (BEHIND[0], BEHIND[-1]))
    assert not agrees(*first)
    assert agrees(*last)  # which sees a small part of it alone


# ---- tp.etendue ----


def test_etendue_between_disks_is_the_closed_form():
    one, two = tp.Disk(radius=HOLE), tp.Disk(center=(0, 0, 0.1), normal=(0, 0, -1), radius=SENSOR)
    estimate = tp.etendue(one, two, particles=1_000_000, seed=1)
    assert_agrees(estimate, throughput.sensor_throughput(0.1), FALSE_ALARM)
    assert str(estimate.unit) == "m^2 sr"


def test_a_wall_and_a_sensor_share_what_goes_through_the_hole():
    """By a plate as blocker: as many rays as hole and sensor share, for the wall fills the view."""
    scene = throughput.scene(show="sensor", distance=0.5)
    wall, plate, sensor = scene.sources[0].shape, scene.surfaces[0].shape, scene.detectors[0].shape
    estimate = tp.etendue(sensor, wall, blockers=[plate], particles=2_000_000, seed=1)
    assert_agrees(estimate, throughput.sensor_throughput(BEHIND[0]), FALSE_ALARM)


# ---- the sim ----


def test_the_beam_of_a_lens_is_seen_in_phase_space():
    """L within the outline of traced rays and 0 beyond, at all four places; a mirrored map is rejected."""
    from transport.verification.experiment import Outcome

    scene = throughput.scene(show="lens")
    outcome = Outcome({"show": "lens"}, tp.simulate(scene, particles=2_000_000, seed=1, threads=1), ())
    for plane in throughput.PLANES:
        x, p, shares, [(_, outline, area), *_] = throughput._portrait(outcome, plane)
        assert area == pytest.approx(etendue.meridional_etendue(0.01, RIM, NEAR), rel=1e-4)
        right, mirrored = (overlap(x, p, outline, share) for share in (shares, shares[::-1]))
        assert right > 0.97
        assert mirrored < (0.97 if plane == "at aperture 1" else 0.8)


def overlap(x_edges, p_edges, outline, share):
    """Part of the radiance, summed over bins, that lies in bins whose middle is within the outline or next to it."""
    from matplotlib.path import Path

    x, p = ((edges[1:] + edges[:-1]) / 2 for edges in (x_edges, p_edges))
    scale = np.array([np.diff(x_edges)[0], np.diff(p_edges)[0]])
    places = np.stack(np.meshgrid(x, p, indexing="ij"), axis=-1).reshape(-1, 2) / scale
    inside = np.zeros(len(places), dtype=bool)
    for shift in ((0, 0), (0.5, 0.5), (-0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)):
        inside |= Path(outline / scale).contains_points(places + shift)
    return share.reshape(-1)[inside].sum() / share.sum()
