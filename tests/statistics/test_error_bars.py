"""Error bars are right: over many seeds z follows Student's t of batches - 1, for estimates of every kind.

Spread, mean and 95 % coverage are judged; limits follow from the numbers of seeds and tests, so that all together fail
right code in three of a thousand choices of seeds.  An error bar that is 10 % wrong is rejected in 9 of 10.  All
estimators on all cost scenes: `python -m tests.bench.error_bars` (its results are in the guide on cost).

In media, in a small slab by chance, by weight, forced and split, and in rooms in which light is the same everywhere, fewer seeds reject
error bars that are wrong by a factor of 1.5.  Of bins, whose errors are pooled, intervals hold the truth as often as they claim,
where few scores carry the values and at edges: coverages are means over thousands of bins, whose bounds fail right code in fewer than one of
10^4 choices of seeds; without pooling they are missed by far.
"""

from __future__ import annotations

import math
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_z_spread
from tests.bench.error_bars import Way
from tests.bench.error_bars import scores as scores_of_way
from tests.bench.interval_coverage import radiance_of, room, row_of
from transport.compile.methods import Method
from transport.sims import diffuse_box, sun
from transport.statistics.batches import student_quantile
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.pooling import pooled_errors, window_sums
from transport.statistics.replicates import Batches
from transport.theory import effusion, emitters, ordinates

# ---- numbers, over 2000 seeds ----

SEEDS, PARTICLES, BATCHES = 2000, 10_000, 16
RADIANCE, RADIUS = 100.0, 0.5
IRRADIANCE = emitters.mean_disk_irradiance(RADIANCE, RADIUS, RADIUS, RADIUS)


def _disks():
    """A disk as large as its distance is wide, and what leaves the source in two bins."""
    meter = tp.Disk(center=(0, 0, RADIUS), normal=(0, 0, -1), radius=RADIUS)
    leaving = tp.Detector(tp.Disk(radius=RADIUS), name="source", directions=tp.Directions(mu=2))
    source = tp.Source(tp.Disk(radius=RADIUS), tp.Lambertian(radiance=RADIANCE))
    return tp.Scene(sources=source, detectors=[tp.Detector(meter, name="meter"), leaving])


def _gas():
    """A square metre in all the gas that can reach it while particles fly 5 cm."""
    patch, reach = tp.Rectangle(width=1, height=1), 0.05
    box = tp.Box(size=(1 + 2 * reach, 1 + 2 * reach, 2 * reach))
    source, detector = tp.Source(box, tp.Gas(1.0, 1.0)), tp.Detector(patch, name="patch")
    return tp.Scene(sources=source, detectors=detector, duration=reach)


def _floors_share(result):
    return result["floor"].flux_in / sum(result[name].flux_in for name in diffuse_box.WALLS)


RUNS = {  # scene; name -> (estimate in its result, exact value)
    "disks": (
        _disks(),
        {
            "irradiance": (lambda r: r["meter"].irradiance, IRRADIANCE),
            "radiance in a bin": (lambda r: r["source"].radiance_out[0], RADIANCE),
        },
    ),
    "sun": (sun.scene(), {"aimed flux": (lambda r: r["meter"].flux_in, sun.exact()[sun.POWER])}),
    "gas": (
        _gas(),
        {
            "flux of a gas": (lambda r: r["patch"].flux_in, effusion.one_way_flux_density(1.0, 1.0)),
            "net flux of a gas": (lambda r: r["patch"].net_flux_density, 0.0),
        },
    ),
    "box": (
        diffuse_box.scene(0.25, 0.75, "all walls"),
        {
            "irradiance of a wall": (lambda r: r["floor"].irradiance, 1.0),
            "ratio of fluxes": (_floors_share, 12 / 59),  # as the areas
        },
    ),
}
WAYS = (
    Way("cost_disks", 0, "flux", Method("aimed", "sobol")),
    Way("cost_disks", 0, "flux", Method("expected", "stratified")),
    Way("cost_enclosure", 0, "irradiance", Method("expected", "sobol")),
    Way("cost_enclosure", 0, "irradiance", Method("backward")),
)
QUANTITIES = [name for _, quantities in RUNS.values() for name in quantities]
GROUPS = {  # names of scores, and how many of them error bars that are wrong by a tenth fail in all but 1 of 270 choices of seeds
    "runs": (QUANTITIES, 4),
    "ways": (list(map(str, WAYS)), 2),
}


def t_scores(run):
    """Name -> (value - exact) / error of each seed, and the degrees of freedom."""
    if isinstance(run, Way):
        return {str(run): scores_of_way(run, SEEDS)}
    scene, quantities = RUNS[run]
    scores = []
    for seed in range(SEEDS):
        result = tp.simulate(scene, PARTICLES, seed=seed, batches=BATCHES, threads=1, progress=False)
        estimates = [(estimate_in(result), exact) for estimate_in, exact in quantities.values()]
        scores.append([(estimate.value - exact) / estimate.error for estimate, exact in estimates])
    return {name: (z, BATCHES - 1) for name, z in zip(quantities, np.transpose(scores), strict=True)}


@pytest.fixture(scope="module")
def scores():
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        found = pool.map(t_scores, (*RUNS, *WAYS))
        return {name: each for scores in found for name, each in scores.items()}


@pytest.mark.slow
@pytest.mark.parametrize("group", GROUPS)
def test_scores_over_seeds_follow_students_t_and_wrong_error_bars_are_rejected(group, scores):
    """Wrong by 10 %, each with a probability of 90 %; and a bias of a fifth of the error always."""
    names, most = GROUPS[group]
    false_alarm, rejected = 1e-3 / len(names), {1.1: 0, 1 / 1.1: 0}
    for name in names:
        z, dof = scores[name]
        assert_z_spread(z, dof, false_alarm)
        with pytest.raises(AssertionError, match="mean"):
            assert_z_spread(z + 0.2, dof, false_alarm)
        for factor in rejected:
            try:
                assert_z_spread(factor * z, dof, false_alarm)
            except AssertionError:
                rejected[factor] += 1
    assert len(names) == {"runs": 7, "ways": 4}[group] and min(rejected.values()) >= most


# ---- media, over 200 seeds ----

TAU, ALBEDO, G = 1.0, 0.8, 0.5
EXACT = ordinates.slab(TAU, ALBEDO, ordinates.henyey_greenstein(G))


def slab():
    fog = tp.Medium((1 - ALBEDO) * TAU, ALBEDO * TAU, phase=tp.HenyeyGreenstein(G))
    body = tp.Slab(center=(0, 0, -0.5), thickness=1.0)
    beam = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
    faces = [tp.Detector(tp.Plane(), "top"), tp.Detector(tp.Plane(center=(0, 0, -1)), "bottom", side="back")]
    return tp.Scene(beam, tp.Surface(body, tp.Transparent(), inside=fog), faces)


def looked_into(medium, *bodies):
    """A room of grey walls with two cells of a box, two shells, and a point."""
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.6), "wall", inside=medium)
    lamp = tp.Source("wall", tp.Lambertian(exitance=0.4 * math.pi), side="back")
    looks = [
        tp.VolumeDetector(tp.Box(size=1.0), "voxels", (2, 1, 1)),
        tp.VolumeDetector(tp.Sphere(radius=0.8), "shells", (0.0, 0.6, 0.8)),
        tp.VolumeDetector(tp.Box(size=0.9), "hits", estimator="collision"),
        tp.PointDetector((0.3, 0.1, 0.2), "point"),
    ]
    return tp.Scene(lamp, [wall, *bodies], looks)


def furnace():
    """Wall and fog both shine by a radiance of 1: the fluence rate is 4 pi in every place."""
    return looked_into(tp.Medium(0.5, 2.0, phase=tp.HenyeyGreenstein(0.5), emission=0.5))


def cloud():
    """Voxels in a shining room: whatever only scatters leaves a radiance of 1 as it is."""
    box, voxels = tp.Box(size=1.1), np.random.default_rng(1).uniform(0.2, 4.0, (3, 2, 2))
    filling = tp.Grid(box=box, scattering=voxels, phase=tp.HenyeyGreenstein(0.5))
    return looked_into(tp.Vacuum(), tp.Surface(box, tp.Transparent(), inside=filling))


def of_slab(result):
    """Reflected, transmitted, absorbed: three scores."""
    lost = 1 - EXACT.reflected - EXACT.transmitted
    found = (result["top"].flux_out, result["bottom"].flux_out, result.ledger["absorbed"])
    return [e.z(x) for e, x in zip(found, (EXACT.reflected, EXACT.transmitted, lost), strict=True)]


def of_room(result):
    """Two voxels, two shells, collisions in a box, a point: six scores."""
    return [z for look in result for z in np.ravel(result[look].fluence_rate.z(4 * math.pi))]


SPLITTING = tp.Splitting(start=(0, 0, 0), end=(0, 0, -1), gain=8.0)
IN_MEDIA = {
    "analog": (slab(), tp.Tracking(absorption="analog"), of_slab),
    "weighted": (slab(), tp.Tracking(), of_slab),
    "forced": (slab(), tp.Tracking(forced=True), of_slab),
    "split": (slab(), tp.Tracking(splitting=SPLITTING), of_slab),
    "furnace": (furnace(), None, of_room),
    "cloud": (cloud(), None, of_room),
}
FALSE_ALARM = 1e-3 / (4 * 3 + 2 * 6)


@pytest.mark.slow
@pytest.mark.parametrize("name", IN_MEDIA)
def test_scores_in_media_over_seeds_are_normal(name):
    scene, tracking, score = IN_MEDIA[name]
    options = {"batches": BATCHES, "threads": 1, "progress": False, "tracking": tracking}
    for each in np.transpose([score(tp.simulate(scene, 1000, seed=seed, **options)) for seed in range(200)]):
        assert_z_spread(each, math.inf, FALSE_ALARM)
        for wrong in (1.5 * each, each / 1.5):
            with pytest.raises(AssertionError, match="spread"):
                assert_z_spread(wrong, math.inf, FALSE_ALARM)


def test_voxels_are_walked_by_numbers_of_their_own_in_every_batch():
    """Among thick voxels most tentative collisions in thin ones are not real: the spread stays binomial.

    Over 256 batches the variance is known to 9 %; five times that fails right code in one of 10^5 seeds.
    """
    voxels = np.full((16, 16, 64), 0.5)
    voxels[::2, ::2, ::2] = 5.0
    grid = tp.Grid(box=tp.Box(size=1.0), absorption=voxels)
    beam = tp.Source(tp.Point(position=(1.5 / 16, 1.5 / 16, -1)), tp.Beam((0, 0, 1), power=1.0))
    scene = tp.Scene(beam, tp.Surface(grid.box, tp.Transparent(), inside=grid))
    options = {"tracking": "analog", "threads": 1, "progress": False}
    result = tp.simulate(scene, particles=100 * 256, batches=256, seed=1, **options)
    passed = np.array([batch.ledger["escaped"] for batch in result.batches])
    share = math.exp(-0.5)
    assert abs(passed.var(ddof=1) / (100 * share * (1 - share)) - 1) < 5 * math.sqrt(2 / 255)


# ---- bins, whose errors are pooled ----

MANY = 32  # batches
RUN = Batches(np.full(MANY, 100))


def heavy(seed, expected):
    """Sums of scores of 1, of which three in a hundred are 50 instead, by batch; and their true mean and error."""
    rng, expected = np.random.default_rng(seed), np.asarray(expected, dtype=float)
    small, large = (rng.poisson(share * expected / MANY, (MANY, *expected.shape)) for share in (0.97, 0.03))
    error = np.sqrt((0.97 + 0.03 * 2500) * expected) / MANY
    return small + 50.0 * large, (0.97 + 1.5) * expected / MANY, error


def like(seed, expected):
    """The same of scores that are all alike; sums and error."""
    expected = np.asarray(expected, dtype=float)
    sums = np.random.default_rng(seed).poisson(expected / MANY, (MANY, *expected.shape)).astype(float)
    return sums, np.sqrt(expected) / MANY


def picture(values, dims=("v", "u")):
    edges = {name: np.arange(n + 1.0) for name, n in zip(dims, values.shape[1:], strict=True)}
    return EstimateArray(values, RUN, "W", dims, edges)


@pytest.mark.parametrize("expected", [30, 100])
def test_intervals_hold_where_rare_scores_carry_the_error(expected):
    rng, held = np.random.default_rng(expected), {"pooled": [], "own": []}
    for _ in range(20):
        values, truth, _ = heavy(rng, np.full((20, 25), expected))
        array = picture(values)
        trusted, off = np.isfinite(array.error) & ~array.is_doubtful, np.abs(array.value - truth)
        held["pooled"].append((off <= student_quantile(0.975, array.dof) * array.error)[trusted])
        own = student_quantile(0.975, MANY - 1) * array._replicates.error
        held["own"].append((off <= own)[trusted])
    pooled, own = (np.concatenate(each).mean() for each in held.values())
    assert 0.93 < pooled < 0.97 and own < 0.925


def test_errors_do_not_follow_the_luck_of_the_value():
    values, mean, _ = heavy(1, np.full((40, 40), 30))
    array = picture(values)
    own = array._replicates.error
    assert abs(np.corrcoef(array.value.ravel(), array.error.ravel())[0, 1]) < 0.3
    assert np.corrcoef(array.value.ravel(), own.ravel())[0, 1] > 0.8
    assert np.mean((array.value - mean)[own < np.median(own)]) < -0.4 * np.std(array.value)
    few = array.error < np.median(array.error)
    assert abs(np.mean((array.value - mean)[few])) < 0.2 * np.std(array.value)


def test_edges_leave_errors_as_they_are():
    """A hundred times as many scores on one side: ten times the error, from one bin to the next."""
    expected = np.full((30, 30), 100.0)
    expected[:, 15:] = 10000
    values, error = like(2, expected)
    ratio = picture(values).error / error
    assert (ratio > 0.75).all() and (ratio < 1.33).all()
    assert np.std(ratio) < 0.08  # from 32 batches alone it is 1 / sqrt(62) = 0.127


def test_a_spot_among_sparse_bins_is_trusted_and_they_are_not():
    expected, spot = np.full((30, 30), 1.0), np.s_[10:12, 10:12]
    expected[spot] = 10000
    values, error = like(3, expected)
    array = picture(values)
    assert not array.is_doubtful[spot].any() and np.count_nonzero(~array.is_doubtful) == 4
    assert np.all(np.abs(np.log(array.error[spot] / error[spot])) < np.log(1.5))
    np.testing.assert_array_equal(np.isnan(array.error), array.value == 0)


@pytest.mark.slow
def test_few_bins_judge_themselves():
    """Of two bins, one with nine times the variance, each has about its own error."""
    drawn = (like(seed, np.array([200.0, 1800.0])) for seed in range(200))
    ratios = [picture(values, ("u",)).error / error for values, error in drawn]
    assert np.allclose(np.sqrt(np.mean(np.square(ratios), axis=0)), 1, atol=0.04)


def test_a_batch_that_alone_moves_the_mean_makes_its_bin_doubtful():
    values = np.random.default_rng(4).normal(10.0, 1.0, (MANY, 20, 20))
    values[7, 5, 6] += 1000
    array = picture(values)
    assert array.is_doubtful.sum() < 30  # and some of its neighbours, which may get one as well
    assert array[5, 6].is_doubtful is True and array[15, 15].is_doubtful is False


def test_errors_are_free_of_scale_and_of_where_a_circle_begins():
    values, _, _ = heavy(5, np.full((12, 16), 40))
    deviations, more = values - values.mean(axis=0), (np.ones(MANY), np.ones((12, 16), dtype=bool), (0, 1))
    first = pooled_errors(deviations, *more, (1,))
    for power in (-900, 900):
        scaled = pooled_errors(np.ldexp(deviations, power), *more, (1,))
        np.testing.assert_array_equal(scaled.error, np.ldexp(first.error, power))
        np.testing.assert_array_equal(scaled.dof, first.dof)
    for unit in (1e-6, 0.3, 1.4, 1e6):
        np.testing.assert_allclose(
            pooled_errors(unit * deviations, *more, (1,)).error, unit * first.error, rtol=1e-10
        )
    turned = pooled_errors(np.roll(deviations, 5, axis=2), *more, (1,))
    np.testing.assert_allclose(turned.error, np.roll(first.error, 5, axis=1), rtol=1e-12)
    open_ended = pooled_errors(deviations, *more)
    assert np.abs(open_ended.error / first.error - 1)[:, [0, -1]].max() > 1e-3


def test_window_sums_are_those_of_a_loop():
    terms = np.random.default_rng(6).uniform(size=(3, 7, 5))
    for reach in (1, 2, 3, 9):
        found = window_sums(terms, reach, (1, 2), (2,))
        around = min(reach, 2)  # of five bins on a circle two lie on each side
        for i, j in np.ndindex(7, 5):
            columns = [(j + step) % 5 for step in range(-around, around + 1)]
            expected = terms[:, max(0, i - reach) : i + reach + 1][:, :, columns].sum(axis=(1, 2))
            np.testing.assert_allclose(found[:, i, j], expected, rtol=1e-13)


def test_bins_of_few_scores_keep_at_least_their_own_error():
    array = picture(np.random.default_rng(1).poisson(0.02, (MANY, 20, 20)).astype(float))
    scored = array.value > 0
    assert (array.error[scored] >= (1 - 1e-12) * array._replicates.error[scored]).all()


def test_elements_slices_and_multiples_keep_their_errors_and_sums_theirs():
    values, _, _ = heavy(7, np.full((8, 9), 60))
    array, factors = picture(values), np.arange(1.0, 10.0)
    assert not np.allclose(array.error, array._replicates.error, rtol=0.05)
    element, part = array[3, 4], array[2:5, 1:7]
    assert (element.error, element.dof) == (array.error[3, 4], array.dof[3, 4])
    assert element.interval() == tuple(ends[3, 4] for ends in array.interval())
    assert element.z(0.0) == array.z(0.0)[3, 4]
    np.testing.assert_array_equal(part.error, array.error[2:5, 1:7])
    assert part[1, 3].error == pickle.loads(pickle.dumps(element)).error == element.error
    assert (2 * element).error == pytest.approx(2 * element.error, rel=1e-12)
    assert (element**2).relative_error == pytest.approx(2 * element.relative_error, rel=0.1)
    np.testing.assert_allclose((array * factors).error, array.error * factors, rtol=1e-12)
    total = Estimate(values.sum(axis=(1, 2)), RUN, "W")
    assert array.sum().error == pytest.approx(total.error, rel=1e-12)
    np.testing.assert_array_equal(array.to_xarray()["doubtful"], array.is_doubtful)
    times = picture(heavy(8, np.full(30, 60))[0], ("time",))  # no places: they are not pooled
    np.testing.assert_array_equal(times.error, times._replicates.error)


@pytest.mark.slow
def test_pixels_hold_the_truth_in_a_room_with_a_glossy_ball():
    """300 histories per pixel; from a pixel's own batches 88 % of the intervals hold it."""
    scene = room(tp.Glossy(0.1), pixels=(16, 12))
    truth = radiance_of(scene, 5_000_000, 10_000)
    row = row_of([radiance_of(scene, 300 * 192, seed) for seed in range(20)], truth)
    assert row.before < 0.9
    assert 0.925 < row.after < 0.975
    assert row.doubtful < 0.25  # the pixels of the ball
    assert np.all((row.coverages > 0.90) & (row.coverages < 0.99))


@pytest.mark.slow
def test_pixels_hold_the_truth_in_a_room_with_a_mirror_ball():
    """3000 histories per pixel: with those from the lamp, already a pixel's own batches hold it.

    Planted: no histories from lamps; then 88 % do.
    """
    scene = room(tp.Mirror(), pixels=(16, 12))
    truth = radiance_of(scene, 20_000_000, 10_000)
    row = row_of([radiance_of(scene, 3000 * 192, seed) for seed in range(10)], truth)
    assert row.before > 0.92
    assert 0.94 < row.after < 0.98
    assert row.doubtful < 0.25  # the pixels of the ball, which few histories may have left out a glint of
    assert np.all((row.coverages > 0.92) & (row.coverages < 0.995))
