"""Phase space measured: every particle alive is counted once at every instant, and samples and moments are theirs.

What is a law of every history is asked of integers: numbers of histories, or the limbs of exact sums.  All runs
have fixed seeds; statistical judgements fail right code in one of 10^6 seeds.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

import transport as tp
from tests.agreement import assert_agrees, assert_follows
from transport.compile import compile_scene
from transport.compile.layout import IN_FLIGHT
from transport.engine.driver import machine_of, run_batch
from transport.engine.program import program_of
from transport.results.estimates import Estimate
from transport.results.phase_readings import BOLTZMANN

FALSE_ALARM = 1e-6
DURATION = 4.0
TIMES = (0.0, 0.5, 1.25, 2.0, 3.3, 4.0)
HOT = tp.Maxwellian(sigma=1.5, mass=3.0)
WIND = tp.Maxwellian(sigma=0.7, mass=3.0, drift=(0.4, -0.3, 0.2))
ARRIVALS, DEPARTURES = 0, 1


def faces_with(*kinds):
    """The walls of a box of 2 m."""
    faces = tp.Box(size=2.0).faces()
    return [tp.Surface(face, kind, n) for (n, face), kind in zip(faces.items(), kinds, strict=True)]


def vessel(walls, looks):
    """Gases, a steady effusive source and a pulse; two of them on walls, all particles of one weight."""
    sources = [
        tp.Source(tp.Cloud(sigma=0.2), tp.Gas(number=3.0, speed=WIND)),
        tp.Source(tp.Box(size=(1.0, 0.5, 2.0)), tp.Gas(number=2.0, speed=0.8, mass=3.0)),
        tp.Source(tp.Sphere(radius=0.5), tp.Gas(number=1.0, speed=0.0, mass=3.0)),
        tp.Source("-z", tp.Effusive(number=4.0, speed=HOT), side="back"),
        tp.Source("+z", tp.Effusive(number=2.0, speed=0.5, mass=3.0), side="back", pulse=tp.BoxPulse(1.0, 2.0)),
    ]  # fmt: skip
    return tp.Scene(sources, walls, looks, duration=DURATION)


PICTURES = [
    tp.PhaseSpace(x=(-1.0, -0.3, 0.2, 0.9), vx=(-2.0, 0.0, 0.5, 3.0), time=TIMES, name="x vx"),
    tp.PhaseSpace(z=(-0.5, 0.0, 1.0), time=TIMES, name="z"),
    tp.PhaseSpace(speed=(0.0, 1e-3, 0.6, 1.0, 3.0), mu=(-1.0, -0.2, 0.9), time=TIMES, name="speed mu"),
    tp.PhaseSpace(
        vy=(-1.0, 0.0, 1.0), vz=(-9.0, 9.0), time=TIMES, name="part", within=tp.Box(size=(1, 2, 0.7)), moments=True
    ),
]  # fmt: skip
TALLIES = [
    tp.Detector(n, f"{n} in time", side="back", times=TIMES) for n in ("-x", "+x", "-y", "+y", "-z", "+z")
]
SPLITTING = tp.Mixture({tp.Black(): 0.5, tp.Diffuse(1.0, speed=HOT): 0.3, tp.Mirror(): 0.2})
KINDS = (tp.Mirror(), tp.Black(), SPLITTING, tp.Diffuse(1.0, speed=HOT), tp.Black(), tp.Black())


@lru_cache(maxsize=1)
def kept():
    """A vessel in which weights stay whole: what reaches a wall goes on, or ends."""
    return tp.simulate(vessel(faces_with(*KINDS), [*PICTURES, *TALLIES]), particles=120_000, seed=1)


def histories(result, value):
    """Numbers of histories from numbers of particles."""
    counts = np.asarray(value) * result.particles / result.ledger["emitted"].value
    np.testing.assert_allclose(counts, np.rint(counts), rtol=0, atol=1e-5)
    return np.rint(counts).astype(int)


def rows(result, name):
    """Histories of a picture, (times, 1 + bins), summed over batches."""
    first, bins = result.plan.bases[name], result[name].number[0].value.size
    found = [b.counts[first : first + len(TIMES) * (1 + bins)] for b in result.batches]
    return np.sum(found, axis=0).reshape(len(TIMES), 1 + bins)


def wall_histories(result, side):
    """Histories that arrived at or left each wall before each of the times, (walls, times)."""
    each = [result[look.name].sums.whole("counts", side).sum(axis=(0, 2)) for look in TALLIES]
    return np.array([np.concatenate([[0], np.cumsum(counts)]) for counts in each])


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
    raw = run_batch(machine_of(program_of(plan)), 1, 0, 20_000)
    flying = whole(raw.ledger[IN_FLIGHT])
    for picture in PICTURES:
        bins = math.prod(len(edges) - 1 for edges in picture.axes.values())
        last = plan.bases[picture.name] + (len(TIMES) - 1) * (1 + bins)
        assert sum(map(whole, raw.meters[last : last + 1 + bins])) == flying
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


# ---- snapshots ----


def streaming(looks, walls=(), speed=WIND):
    return tp.Scene(
        tp.Source(tp.Box(size=1.5), tp.Gas(number=6.0, speed=speed)), walls, looks, duration=DURATION
    )


PAIR = [tp.Snapshot(0.5, particles=20_000, name="before"), tp.Snapshot(2.75, particles=20_000, name="after")]


def matched(result):
    """Both snapshots in the order of their histories."""
    found = [result[shot.name] for shot in PAIR]
    orders = [np.lexsort((shot.histories, shot.batches)) for shot in found]
    first, second = (np.stack([s.batches, s.histories], 1)[o] for s, o in zip(found, orders, strict=True))
    np.testing.assert_array_equal(first, second)
    return [
        (shot.positions[order], shot.velocities[order]) for shot, order in zip(found, orders, strict=True)
    ]


def test_without_walls_every_particle_moves_by_v_t():
    (x, v), (later, w) = matched(tp.simulate(streaming(PAIR), particles=20_000, seed=1))
    assert len(x) == 20_000
    np.testing.assert_array_equal(v, w)
    np.testing.assert_allclose(later, x + 2.25 * v, rtol=0, atol=1e-13)
    assert np.abs(later - (x + 2.2 * v)).max() > 0.1


def test_between_mirrors_every_particle_moves_as_its_unfolded_image_does():
    walls = faces_with(*[tp.Mirror()] * 6)
    (x, v), (later, w) = matched(tp.simulate(streaming(PAIR, walls), particles=20_000, seed=1))
    unfolded = x + 2.25 * v
    turns = np.floor((unfolded + 1) / 2)
    sign = 1 - 2 * (turns % 2)
    np.testing.assert_allclose(later, sign * (unfolded - 2 * turns), rtol=0, atol=1e-12)
    np.testing.assert_allclose(w, sign * v, rtol=1e-12, atol=1e-12)
    assert (sign < 0).mean() > 0.2 and (np.abs(turns) > 1).any()


def test_samples_of_both_snapshots_are_of_the_same_histories():
    """One in five of them, chosen before anything was known of them."""
    few = [tp.Snapshot(s.time, particles=4000, name=s.name) for s in PAIR]
    (x, v), (later, _) = matched(tp.simulate(streaming(few), particles=20_000, seed=1))
    assert 3900 <= len(x) <= 4000
    np.testing.assert_allclose(later, x + 2.25 * v, rtol=0, atol=1e-13)


@pytest.mark.parametrize("particles", [20_011, 10_000_000])
def test_a_snapshot_of_more_particles_than_histories_has_all_of_them(particles):
    """Also where batches differ by one history."""
    shot = tp.Snapshot(1.0, particles=particles)
    result = tp.simulate(streaming(shot), particles=20_011, seed=1)
    found = result["snapshot"]
    assert len(found) == 20_011 == len(set(zip(found.batches, found.histories, strict=True)))
    np.testing.assert_allclose(found.weights, 6.0 / 20_011, rtol=1e-14)
    assert found.time == 1.0 and found.positions.shape == found.velocities.shape == (20_011, 3)


@pytest.mark.parametrize(
    "aim", [None, tp.Disk(center=(0.5, 0, 3.0), radius=0.2), tp.Sphere(center=(0, 0, 2), radius=0.5)]
)
def test_light_from_a_flash_is_on_a_sphere_whether_it_was_aimed_or_not(aim):
    """An aimed particle is kept at its target while it flies there from its source."""
    source = tp.Source(tp.Point(), tp.Isotropic(energy=1.0, speed=2.0), aim=aim, pulse=tp.Instant(0.25))
    looks = [tp.Snapshot(t, particles=2000, name=f"{k}") for k, t in enumerate((0.25, 0.5, 1.0, 3.0))]
    looks.append(tp.PhaseSpace(x=(-9, 9), time=(0.1, 0.5, 3.0), name="all"))
    around = tp.Sphere(radius=4.0)
    looks.append(tp.Detector(around, "around", side="inside", times=(0.0, 2.2499, 2.2501, 3.0)))
    result = tp.simulate(tp.Scene(source, [], looks, duration=3.0), particles=2000, seed=1)
    for k, t in enumerate((0.25, 0.5, 1.0, 3.0)):
        shot = result[f"{k}"]
        far = np.linalg.norm(shot.positions, axis=1)
        np.testing.assert_allclose(far, 2 * (t - 0.25), rtol=1e-13, atol=1e-15)
        np.testing.assert_allclose(np.linalg.norm(shot.velocities, axis=1), 2.0, rtol=1e-14)
    met = result["around"].sums.whole("counts", ARRIVALS).sum(axis=(0, 2))
    np.testing.assert_array_equal(met, [0, 2000, 0])
    emitted = 1.0 - result.ledger["unsampled"].value
    np.testing.assert_allclose(result["all"].alive.value, [0, emitted, emitted], rtol=1e-12)


@pytest.mark.parametrize("thinned", [False, True])
def test_samples_of_a_few_are_unbiased_over_seeds(thinned):
    """Weights, and weights times speed, of a sample against phase space of all; few are alive, of two kinds.

    Where another snapshot asks for more, this one is thinned out afterwards.
    """
    few = tp.Snapshot(2.0, particles=25, name="few")
    more = [tp.Snapshot(1.0, particles=400, name="more")] if thinned else []
    looks = [few, *more, tp.PhaseSpace(speed=(0, 9), time=2.0, moments=True, name="all")]
    fast, slow = (tp.Source(tp.Box(size=1.0), tp.Gas(number=n, speed=v)) for n, v in ((4.0, 2.0), (1.0, 0.3)))
    ball = tp.Surface(tp.Sphere(radius=1.5), tp.Diffuse(0.5))
    scene = tp.Scene([fast, slow], ball, looks, duration=DURATION)
    off = []
    for seed in range(300):
        result = tp.simulate(scene, particles=1000, seed=seed, batches=8, threads=1, progress=False)
        sample, all_ = result["few"], result["all"]
        assert len(sample) <= 25 + 8
        speeds = np.linalg.norm(sample.velocities, axis=1)
        exact = all_.alive.value, (all_.fluence_rate * 9.0).value[0]
        off.append([sample.weights.sum() - exact[0], sample.weights @ speeds - exact[1]])
    off = np.array(off)
    z = off.mean(axis=0) / (off.std(axis=0, ddof=1) / math.sqrt(len(off)))
    assert (np.abs(z) < -ndtri(FALSE_ALARM / 4)).all(), z
    biased = off.mean(axis=0) + 0.1 * np.array(exact)
    assert (np.abs(biased / (off.std(axis=0, ddof=1) / math.sqrt(len(off)))) > 5.1).any()


def test_snapshots_of_a_run_without_an_end_are_unbiased_too():
    """Batches are put together as the run goes on; each snapshot's sample still stands for all that are alive."""
    times = {"start": 0.0, "soon": 0.01, "end": 3.0}
    looks = [tp.Snapshot(time, particles=500, name=name) for name, time in times.items()]
    looks += [tp.PhaseSpace(x=(-9, 9), time=tuple(times.values()), name="all")]
    ball = tp.Surface(tp.Sphere(radius=1.5), tp.Black())
    scene = streaming(looks, ball)
    result = tp.simulate(scene, particles=300_000, error={"all.alive": 1e-9}, seed=1, progress=False)
    assert result.particles == 300_000 and len(result.run) < 256
    for name, alive in zip(times, result["all"].alive.value, strict=True):
        sample = result[name]
        assert 0 < len(sample) <= 500
        assert sample.weights.sum() == pytest.approx(alive, rel=max(0.06, 5 / math.sqrt(len(sample)))), name


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
    assert found.outside.value == pytest.approx(w[~masks.any(axis=0)].sum(), rel=1e-9)
    assert found.alive.value == pytest.approx(w.sum(), rel=1e-12)


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


def test_a_temperature_with_the_mean_velocity_left_in_is_rejected():
    """Among all that is alive the wind's share is seen: variance and mean square differ by more than any error."""
    found = measured()["x"]
    squares = found.variance_vx.value + found.mean_vx.value**2
    assert (np.abs(found.variance_vx.value / squares - 1) > 1e-6).all()


def test_within_a_box_only_its_particles_are_counted_and_the_rest_is_outside():
    result = measured()
    shot, found = result["snapshot"], result["within"]
    low, high = HALF.bounds
    inside = ((shot.positions >= low) & (shot.positions <= high)).all(axis=1)
    in_bins = inside & (shot.positions[:, 1] >= -0.5) & (shot.positions[:, 1] <= 0.6)
    first = result.plan.bases["within"]
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


def run_alone(source, shot):
    """The whole sample of a source by itself."""
    return tp.simulate(tp.Scene(source, [], shot, duration=1.0), particles=200_000, seed=1)["snapshot"]


def test_small_snapshots_beside_a_large_one_are_unbiased_where_few_are_left():
    """Of 3200 particles 1.1 % are left at the second instant: most of its samples of 25 histories are then empty.

    Those that are not must stand for these, too: by the chance with which a history was chosen, not by how many there were.
    """
    gas = tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1))
    source = tp.Source(tp.Box(size=(1, 1, 0.01), center=(0, 0, -0.01)), gas)
    wall = tp.Surface(tp.Disk(center=(0, 0, 0.5), radius=5.0, inner_radius=0.06), tp.Black())
    looks = [tp.Snapshot(0.0, particles=25, name="all"), tp.Snapshot(0.9, particles=25, name="few")]
    looks += [tp.Snapshot(0.0, particles=3200, name="large"), tp.PhaseSpace(x=(-9, 9), time=0.9)]
    scene = tp.Scene(source, wall, looks, duration=1.0)
    off, alive, empty = [], [], 0
    for seed in range(100):
        result = tp.simulate(scene, particles=3200, seed=seed, batches=8, threads=1, progress=False)
        assert len(result["all"]) <= 25 and len(result["large"]) == 3200
        alive.append(result["phase_space"].alive.value)
        off.append([result["all"].weights.sum() - 1.0, result["few"].weights.sum() - alive[-1]])
        empty += len(result["few"]) == 0
    error = np.std(off, axis=0, ddof=1) / math.sqrt(len(off))
    assert np.mean(alive) == pytest.approx(math.pi * 0.06**2, rel=0.03) and empty > 50
    assert (np.abs(np.mean(off, axis=0)) < 5 * error).all()
