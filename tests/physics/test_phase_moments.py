"""Births in volumes, and moments in phase space: those of the particles themselves."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from scipy.special import ndtr

import transport as tp
from tests.agreement import assert_agrees, assert_follows
from tests.phase_scenes import FALSE_ALARM, HOT, faces_with, histories, run_alone, streaming, vessel
from transport.statistics.estimates import Estimate
from transport.units import BOLTZMANN

# ---- births ----


def test_positions_of_a_gas_are_uniform_in_its_box():
    """Chi-square over cells of the box, at the start."""
    edges = tuple(np.linspace(-0.75, 0.75, 9))
    look = tp.PhaseSpace(x=edges, z=edges, time=0.0)
    result = tp.simulate(streaming(look), particles=200_000, seed=1)
    counts = histories(result, result["phase_space"].number.value)
    assert counts.sum() == 200_000
    assert_follows(counts, np.full(64, 1 / 64), FALSE_ALARM)


def test_positions_of_a_gas_are_uniform_in_its_ball():
    """The cube of the radius, the cosine and the azimuth are uniform and independent."""
    gas = tp.Source(tp.Sphere(center=(1, 2, 3), radius=2.0), tp.Gas(number=1.0, speed=1.0))
    shot = tp.Snapshot(0.0, particles=200_000)
    x, y, z = (run_alone(gas, shot).positions - (1, 2, 3)).T
    r = np.sqrt(x**2 + y**2 + z**2)
    assert r.max() <= 2 * (1 + 1e-12)
    counts, _ = np.histogramdd(
        [(r / 2) ** 3, z / r, np.arctan2(y, x)], [8] * 3, [(0, 1), (-1, 1), (-np.pi, np.pi)]
    )
    assert_follows(counts, np.full(512, 1 / 512), FALSE_ALARM)
    wrong = np.diff(np.linspace(0, 1, 9) ** 0.95)
    with pytest.raises(AssertionError):
        assert_follows(counts.sum(axis=(1, 2)), wrong, FALSE_ALARM)


def test_positions_of_a_cloud_are_normal_each_with_its_own_width():
    gas = tp.Source(tp.Cloud(center=(1, 2, 3), sigma=(0.5, 1.0, 2.0)), tp.Gas(number=1.0, speed=1.0))
    shot = tp.Snapshot(0.0, particles=200_000)
    places = (run_alone(gas, shot).positions - (1, 2, 3)) / (0.5, 1.0, 2.0)
    edges = np.concatenate([[-9], np.linspace(-2, 2, 9), [9]])
    shares = np.diff(ndtr(edges))
    counts, _ = np.histogramdd(places, [edges] * 3)
    assert counts.sum() == 200_000
    assert_follows(counts, np.einsum("i,j,k->ijk", shares, shares, shares), FALSE_ALARM)
    with pytest.raises(AssertionError):
        assert_follows(counts.sum(axis=(0, 1)), np.diff(ndtr(edges / 1.02)), FALSE_ALARM)


# ---- moments ----

X_EDGES, V_EDGES = (-1.0, -0.4, 0.1, 1.0), (-3.0, 0.0, 0.4, 3.0)
HALF = tp.Box(center=(0.1, 0.0, -0.2), size=(1.5, 1.2, 1.0))
LOOKS = {
    "x": tp.PhaseSpace(x=X_EDGES, time=2.0, moments=True, name="x"),
    "x vz": tp.PhaseSpace(x=X_EDGES, vz=V_EDGES, time=2.0, moments=True, name="x vz"),
    "within": tp.PhaseSpace(y=(-0.5, 0.2, 0.6), time=2.0, moments=True, name="within", within=HALF),
}


@lru_cache(maxsize=1)
def measured():
    """The vessel with a snapshot of all that are alive, weights between 0 and 1."""
    kinds = (
        tp.Diffuse(0.9),
        tp.Mirror(0.3),
        tp.Diffuse(0.6, speed=HOT),
        tp.Mirror(),
        tp.Diffuse(0.7),
        tp.Black(),
    )
    looks = [*LOOKS.values(), tp.Snapshot(2.0, particles=200_000)]
    return tp.simulate(vessel(faces_with(*kinds), looks), particles=100_000, seed=1)


def picked(shot, name):
    """Which particles of the snapshot are in each bin, (bins, particles), and the bins' measure."""
    look = LOOKS[name]
    columns = dict(zip("xyz", shot.positions.T, strict=True))
    columns |= dict(zip(("vx", "vy", "vz"), shot.velocities.T, strict=True))
    masks, widths = np.ones((1, len(shot)), bool), np.ones(1)
    for axis, edges in look.axes.items():
        inside = [(columns[axis] >= a) & (columns[axis] < b) for a, b in zip(edges, edges[1:], strict=False)]
        masks = (masks[:, None] & np.array(inside)[None]).reshape(-1, len(shot))
        widths = np.outer(widths, np.diff(edges)).ravel()
    if look.within is not None:
        low, high = look.within.bounds
        masks &= ((shot.positions >= low) & (shot.positions <= high)).all(axis=1)
        widths = widths * 1.5 * 1.0
    return masks, widths


@pytest.mark.parametrize("name", LOOKS)
def test_numbers_densities_and_flux_are_those_of_the_particles_themselves(name):
    result = measured()
    shot, found = result["snapshot"], result[name]
    masks, widths = picked(shot, name)
    w, speed = shot.weights, np.linalg.norm(shot.velocities, axis=1)
    sums = {
        "number": masks @ w,
        "density": masks @ w / widths,
        "fluence_rate": masks @ (w * speed) / widths,
    }
    for quantity, exact in sums.items():
        np.testing.assert_allclose(getattr(found, quantity).value.ravel(), exact, rtol=1e-9)
    assert found.outside.value == pytest.approx(w[~masks.any(axis=0)].sum(), rel=1e-9, abs=0)
    assert found.alive.value == pytest.approx(w.sum(), rel=1e-12, abs=0)


@pytest.mark.parametrize("name", LOOKS)
def test_moments_are_those_of_the_particles_themselves(name):
    """Bin by bin from the snapshot, each batch by itself, so that a ratio's bias is taken off alike; and plainly."""
    result = measured()
    shot, found = result["snapshot"], result[name]
    masks, widths = picked(shot, name)
    for mask, width, place in zip(masks, widths, np.ndindex(found.number.shape), strict=True):
        own = OfParticles(result, shot, mask)
        variance = [own.mean(shot.velocities[:, k] ** 2) - own.mean(shot.velocities[:, k]) * own.mean(
            shot.velocities[:, k]) for k in range(3)]  # fmt: skip
        spread = variance[0] + variance[1] + variance[2]
        speeds = np.linalg.norm(shot.velocities, axis=1)
        exact = {f"mean_v{a}": own.mean(shot.velocities[:, k]).value for k, a in enumerate("xyz")}
        exact |= {f"variance_v{a}": v.value for a, v in zip("xyz", variance, strict=True)}
        exact["mean_speed"] = own.mean(speeds).value
        exact["temperature"] = spread.value * 3.0 / (3 * BOLTZMANN)
        exact["pressure"] = (own.sum(1.0) * spread).value * 3.0 / 3 / width
        for quantity, value in exact.items():
            scale = np.abs(shot.velocities).max() ** (1 if quantity.startswith("mean") else 2) * (
                3.0 / (3 * BOLTZMANN) if quantity == "temperature" else 1.0
            )
            measured_ = getattr(found, quantity)[place].value
            assert measured_ == pytest.approx(value, rel=1e-9, abs=1e-12 * scale), quantity
        w, v = shot.weights[mask], shot.velocities[mask]
        plain = np.average(v, axis=0, weights=w)
        variances = np.average((v - plain) ** 2, axis=0, weights=w)
        assert found.temperature[place].value == pytest.approx(
            variances.sum() / BOLTZMANN, rel=30 / mask.sum()
        )
        assert found.mean_vx[place].value == pytest.approx(plain[0], abs=30 / mask.sum())


class OfParticles:
    """Sums over the particles of a bin as estimates: what each batch gave a history."""

    def __init__(self, result, shot, mask):
        self.run, self.shot, self.mask = result.run, shot, mask

    def sum(self, values):
        weights = self.shot.weights * values * self.mask
        batches = np.bincount(self.shot.batches, weights, minlength=len(self.run))
        return Estimate(batches * self.run.sizes.sum() / self.run.sizes, self.run, "1")

    def mean(self, values):
        return self.sum(values) / self.sum(1.0)


def test_within_a_box_only_its_particles_are_counted_and_the_rest_is_outside():
    result = measured()
    shot, found = result["snapshot"], result["within"]
    low, high = HALF.bounds
    inside = ((shot.positions >= low) & (shot.positions <= high)).all(axis=1)
    in_bins = inside & (shot.positions[:, 1] >= -0.5) & (shot.positions[:, 1] <= 0.6)
    first = result.plan.rows_of["within"].first
    counted = np.sum([b.counts[first : first + 3] for b in result.batches], axis=0)
    assert counted[1:].sum() == in_bins.sum() and counted[0] == (~in_bins).sum()
    assert str(found.density.unit) == "m^-3" and str(found.pressure.unit) == "Pa"


def test_a_bin_that_the_box_cuts_has_the_density_of_what_is_left_of_it():
    """A uniform gas, looked at within a box over half of one bin and a quarter of another; beyond is nothing to tell."""
    gas = tp.Source(tp.Box(size=2.0), tp.Gas(density=3.0, speed=1.0))
    look = tp.PhaseSpace(
        x=(-1.0, 0.0, 0.8, 1.0), time=0.0, within=tp.Box(center=(-0.15, 0.2, 0), size=(0.7, 1, 1.5))
    )
    density = tp.simulate(tp.Scene(gas, [], look, duration=1.0), particles=200_000, seed=1)[
        "phase_space"
    ].density
    assert_agrees(density[:2], 3.0, FALSE_ALARM)
    assert np.isnan(density.value[2])
    with pytest.raises(AssertionError):
        assert_agrees(density[:2], 3.0 * np.array([0.5, 0.25]), FALSE_ALARM)
