"""simulate(sampling=...): nets in place of random numbers are unbiased, never worse, honest, and no pass is written twice."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from numba import config
from scipy.integrate import dblquad
from scipy.special import fdtrc

import transport as tp
from tests.agreement import assert_agrees, assert_z_spread
from tests.processes import elsewhere
from tests.refusals import assert_refused
from tests.same_batches import digest
from transport.compile.compiler import compile_scene
from transport.compile.methods import SAMPLINGS, Method
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program
from transport.engine.registry import PASSES
from transport.engine.stages.quasi_random import WORDS, quasi_random_twin
from transport.results.batches import batch_of
from transport.results.result import Result

NETS = [sampling for sampling in SAMPLINGS if sampling != "random"]
FALSE_ALARM = 1e-5
EXACT = (3 - math.sqrt(5)) / 2  # view factor of coaxial disks of radius 1 at distance 1
METER = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1)
FOG = tp.Medium(absorption=0.2, scattering=1.8, phase=tp.HenyeyGreenstein(0.75))


def disks(aim=None):
    lamp = tp.Source(tp.Disk(radius=1), tp.Lambertian(power=1.0), aim=aim)
    return tp.Scene(sources=[lamp], detectors=[tp.Detector(METER, name="meter")])


def lamps():
    """Three emitters of unlike powers: their histories are not powers of two."""
    sources = [
        tp.Source(tp.Disk(center=(x, 0, 0), radius=0.3), tp.Lambertian(power=power))
        for x, power in ((-1, 1.0), (0, 0.7), (1, 1.3))
    ]
    meter = tp.Disk(center=(0.3, 0, 1), normal=(0, 0, -1), radius=0.6)
    return tp.Scene(sources=sources, detectors=[tp.Detector(meter, name="meter")])


def box():
    """Closed and diffuse: all but the births are events on the way."""
    lamp = tp.Source(tp.Disk(center=(0, 0, -0.5), radius=0.2), tp.Lambertian(power=1.0))
    walls = tp.Surface(tp.Box(size=1.0), tp.Diffuse(0.7), name="walls")
    meter = tp.Rectangle(center=(0, 0, 0.5), normal=(0, 0, -1), width=0.5, height=0.5)
    return tp.Scene(sources=[lamp], surfaces=[walls], detectors=[tp.Detector(meter, name="meter")])


def slab():
    """A beam into fog."""
    lamp = tp.Source(tp.Point(position=(0, 0, -1)), tp.Beam(direction=(0, 0, 1), power=1.0))
    fog = tp.Surface(tp.Slab(center=(0, 0, 0.5), thickness=1.0), tp.Transparent(), inside=FOG)
    meter = tp.Detector(tp.Plane(center=(0, 0, 2)), name="meter", side="back")
    return tp.Scene(sources=[lamp], surfaces=[fog], detectors=[meter])


SCENES = {
    "disks": (disks(), None),
    "aimed": (disks(METER), None),
    "lamps": (lamps(), None),
    "box": (box(), None),
    "slab": (slab(), None),
    "slab with copies": (slab(), tp.Tracking(forced=True)),
}


@cache
def machine(name, sampling):
    scene, tracking = SCENES[name]
    return compile_program(build_program(compile_scene(scene, tracking, Method("analog", sampling))))


@cache
def fluxes(name, sampling, histories, batches, seed=7):
    """Flux into the meter [W] by each batch alone."""
    made = machine(name, sampling)
    plan = made.program.plan
    found = [batch_of(plan, run_batch(made, seed, number, histories)) for number in range(batches)]
    flux = Result(plan, found, seed, None, True, [])["meter"].flux_in
    (deviations,) = flux._replicates.deviations.values()
    return float(flux.value) + np.ravel(deviations)


@pytest.mark.slow
def test_the_error_of_direct_light_falls_faster_than_one_over_n():
    """True error of one net of 2^12 to 2^20 points, root mean square of 4; 1e-6 with a million."""
    sizes = 2 ** np.arange(12, 21, 2)
    errors = [np.sqrt(np.mean((fluxes("aimed", "sobol", int(n), 4) / EXACT - 1) ** 2)) for n in sizes]
    slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert slope <= -1.0
    assert errors[-1] < 2e-6
    random = [
        np.sqrt(np.mean((fluxes("aimed", "random", n, 32) / EXACT - 1) ** 2)) for n in (1 << 10, 1 << 16)
    ]
    assert (
        abs(math.log(random[1] / random[0]) / math.log(64) + 0.5) < 0.2
    )  # the same fit tells random numbers apart


# Least ratio of spreads; measured 1.8, 1.2 and 1.4 at 2^10 histories.
WORTH = {"disks": 1.5, "box": 1.1, "slab": 1.2}


@pytest.mark.quick_cases("disks-sobol", "slab-sobol")
@pytest.mark.parametrize(
    ("name", "sampling"),
    [*((name, "sobol") for name in SCENES), ("disks", "stratified"), ("aimed", "stratified")],
)
def test_no_net_errs_more_than_random_numbers(name, sampling):
    """Spread of 250 batches of 2^10 histories: at most 1.05 times that of random ones, by the F-test; means agree."""
    one, other = (fluxes(name, how, 1 << 10, 250) for how in (sampling, "random"))
    ratio = one.var(ddof=1) / other.var(ddof=1)
    assert fdtrc(249, 249, ratio / 1.05**2) >= FALSE_ALARM
    z = (one.mean() - other.mean()) / math.hypot(one.std(ddof=1), other.std(ddof=1)) * math.sqrt(250)
    assert abs(z) < 4.4  # 1 in 100 000
    if sampling == "sobol" and name in WORTH:
        assert other.std() > WORTH[name] * one.std()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "sampling"), [("disks", "sobol"), ("aimed", "stratified")])
def test_error_bars_of_few_nets_are_honest(name, sampling):
    """Eight batches at a time, through Student's t, against the exact value."""
    values = fluxes(name, sampling, 1 << 8, 8 * 400, seed=3).reshape(400, 8)
    t = (values.mean(axis=1) - EXACT) / (values.std(axis=1, ddof=1) / math.sqrt(8))
    assert_z_spread(t, 7, FALSE_ALARM)


def test_a_run_holds_few_equal_nets_and_reports_their_histories():
    result = tp.simulate(disks(METER), particles=100_000, sampling="sobol", seed=2)
    assert [batch.histories for batch in result.batches] == [1 << 14] * 8
    assert result.particles == 1 << 17
    assert_agrees(result["meter"].flux_in, EXACT)
    assert "sobol" in result.report()


@pytest.mark.parametrize("sampling", NETS)
def test_any_number_of_threads_counts_the_same(sampling):
    scene, _ = SCENES["box"]
    found = {digest(scene, threads=threads, sampling=sampling) for threads in (1, 3)}
    assert len(found) == 1 and found != {digest(scene)}


def counts_of(names, sampling="sobol", histories=64):
    """What scenes count, as lists, and which of their passes had to be compiled."""
    sums, compiled = {}, []
    for name in names:
        made = machine(name, sampling)
        raw = run_batch(made, 5, 1, histories)
        sums[name] = [raw.detectors.tolist(), raw.ledger.tolist()]
        passes = [] if config.DISABLE_JIT else made.program.passes
        compiled += [each.name for each in passes if not each.compiled.cache_hits]
    return sums, compiled


@pytest.mark.slow
def test_a_second_process_compiles_nothing():
    here, _ = counts_of(["aimed", "slab"])
    there, compiled = elsewhere("tests.engine.test_samplings.counts_of(['aimed', 'slab'])")
    assert there == here and compiled == []


@pytest.mark.slow
def test_plain_python_and_bundles_of_another_size_count_the_same():
    """To the rounding of fused multiplications."""
    names = ["aimed", "lamps", "box", "slab"]
    here, _ = counts_of(names, histories=160)
    code = f"tests.engine.test_samplings.counts_of({names}, histories=160)"
    there, _ = elsewhere(code, NUMBA_DISABLE_JIT="1", TRANSPORT_LANES="64")
    for name in names:
        for one, other in zip(here[name], there[name], strict=True):
            one, other = np.array(one), np.array(other)
            np.testing.assert_array_equal(one[:, 2], other[:, 2])
            weights, others = (w[:, 0] * 2.0**-32 + w[:, 1] * 2.0**-63 for w in (one, other))
            assert np.abs(weights - others).max() <= 1e-10
        assert np.array(here[name][0])[:, 2].sum() > 0


def callees(function, seen):
    """Every function of the library that a function can call, by its globals."""
    python = getattr(function, "py_func", function)
    for name in python.__code__.co_names:
        found = python.__globals__.get(name)
        inner = getattr(found, "py_func", found)
        is_ours = callable(found) and hasattr(inner, "__code__") and inner.__module__.startswith("transport.")
        if is_ours and found not in seen:
            seen.append(found)
            if inner.__module__ != "transport.physics.sobol":
                callees(found, seen)
    return seen


@pytest.mark.parametrize("sampling", NETS)
def test_every_pass_that_draws_has_a_twin_in_which_nothing_draws_at_random(sampling):
    """By what its code calls, however deep; what draws nothing is its own twin, and keeps its machine code."""
    drawing = 0
    for lane_pass in PASSES.values():
        twin, words = quasi_random_twin(lane_pass, sampling), set(WORDS[sampling])
        if words & set(callees(lane_pass.function, [])):
            drawing += 1
            found = {*callees(twin.function, []), *callees(twin.before, [])}
            assert not words & found and found & set(WORDS[sampling].values())
            assert twin.name == f"{lane_pass.name} by {sampling}" and twin.fields == lane_pass.fields
        else:
            assert twin is lane_pass
    assert drawing >= 40


def test_random_programs_hold_nothing_of_it():
    assert not [each.name for each in machine("slab", "random").program.passes if " by " in each.name]
    assert any(each.name == "draw_flight by sobol" for each in machine("slab", "sobol").program.passes)


def test_an_unknown_sampling_is_refused_with_those_there_are():
    assert_refused(
        lambda: tp.simulate(disks(), particles=10, sampling="sobl"), ["sampling", "'sobl'", "sobol"]
    )


@pytest.mark.parametrize("sampling", NETS)
def test_each_source_has_its_exact_share_of_even_points(sampling):
    """Dealt by chance a source has one history more or less, by which all eight batches of a run may be wrong alike."""
    powers = {"above": 3.0, "below": 7.3}
    sources = [
        tp.Source(tp.Disk(radius=0.5), tp.Lambertian(power=power), side=side)
        for power, side in zip(powers.values(), ("front", "back"), strict=True)
    ]
    planes = [
        tp.Detector(tp.Plane(center=(0, 0, z), normal=(0, 0, -z)), name)
        for z, name in ((1, "above"), (-1, "below"))
    ]
    for particles in (1024, 1 << 16):
        result = tp.simulate(tp.Scene(sources, detectors=planes), particles, seed=3, sampling=sampling)
        for name, power in powers.items():
            flux = result[name].flux_in
            assert flux.value == pytest.approx(power, rel=1e-12)
            assert flux.interval()[0] <= power <= flux.interval()[1] and not flux.is_doubtful
        assert result.ledger["escaped"].value == pytest.approx(10.3, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("sampling", NETS)
def test_one_score_more_is_within_the_interval_where_all_batches_have_as_many(sampling):
    """Half of a lamp is hidden from a point: rays from 0.288 of it come, so many that all batches may have the same number.

    Their spread is then that of the rays' smooth weights, without which the interval missed by up to 300 standard errors.
    """
    edge = -0.04246
    lamp = tp.Source(
        tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=0.2, height=0.2), tp.Lambertian(power=3.0)
    )
    wall = tp.Rectangle(center=(edge / 2 + 0.5, 0, 0.5), width=1, height=1)
    scene = tp.Scene(
        lamp, tp.Surface(wall, tp.Diffuse(0.0)), detectors=tp.PointDetector(name="eye", position=(0, 0, 0))
    )
    density = 3.0 / (math.pi * 0.2**2)
    exact, _ = dblquad(lambda y, x: density * (1 + x * x + y * y) ** -1.5, -0.1, edge, -0.1, 0.1)
    found = [
        tp.simulate(scene, 1 << 13, seed=seed, sampling=sampling, progress=False)["eye"].fluence_rate
        for seed in range(40)
    ]
    blind = [estimate for estimate in found if estimate.verdict == "bounded"]
    assert blind and all("the same few scores" in str(estimate) for estimate in blind)
    assert max(abs(estimate.z(exact)) for estimate in blind) > 5  # else this scene shows nothing
    covered = sum(low <= exact <= high for low, high in (estimate.interval() for estimate in found))
    assert covered >= 35  # fewer with a chance of 1e-2 at 95 % each


def test_batches_together_have_as_many_histories_of_each_source_as_they_should():
    """Two beams of unlike power; dealt by chance 32 batches together had 2 too many or too few, and in one run of 70 all batches as many."""
    at, powers = tp.Point(position=(0, 0, 0)), (1.0, 0.00010007)
    beams = [tp.Source(at, tp.Beam((0, 0, z), power=p)) for z, p in zip((1, -1), powers, strict=True)]
    faint = tp.Detector(tp.Disk(center=(0, 0, -1), normal=(0, 0, 1), radius=0.5), name="faint")
    for seed in range(20):
        result = tp.simulate(
            tp.Scene(beams, detectors=faint), 1_000_000, seed=seed, threads=1, progress=False
        )
        flux = result["faint"].flux_in
        assert abs(flux.value - powers[1]) < 1.6e-6  # 1.6 histories of 100
        assert 1e-6 < flux.error < 3e-6 and flux.interval()[0] <= powers[1] <= flux.interval()[1]
