"""f measured by direction, exchange of lamp and eye, sums of f over what arrives; and wrong laws that are rejected.

Each statistical judgement fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import dblquad

import transport as tp
from tests.agreement import agrees, assert_agrees, smallest_bias
from transport.sims import gonioreflectometer as sim
from transport.sims.gonioreflectometer import ALBEDO, EYE, HERE, LAMP, NARROW, RATIO, SAMPLES, THERE, law_of
from transport.theory import goniometry, microfacets

slow = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
SPECULAR = "f at 42° to 48°"
FINE = np.linspace(0, math.pi / 2, 61), np.linspace(0, 2 * math.pi, 37)
PROJECTED = np.outer(np.diff(np.sin(FINE[0]) ** 2) / 2, np.diff(FINE[1]))


def run(particles=200_000, **parameters):
    return tp.simulate(sim.scene(**parameters), particles=particles, seed=1, threads=1)


def rows(particles=200_000, **parameters):
    """(estimate, exact) by name."""
    measured, exact = sim.measure(run(particles, **parameters)), sim.exact(**parameters)
    assert measured.keys() == exact.keys()
    return {name: (measured[name], value) for name, value in exact.items()}


def uneven(mu_in, mu_out, phi):
    """A law that is not reciprocal: it is f = 1/π times the cosine of departure."""
    return mu_out / math.pi + 0.0 * (mu_in + phi)


# ---- theory ----


@pytest.mark.slow
def test_means_over_bins_are_those_of_adaptive_quadrature():
    """To 1e-6 is asked for; the sharpest lobe of the sim, at grazing."""
    angle, theta, phi = math.radians(75), np.radians([72, 78]), np.radians([165, 195])
    law = law_of(SAMPLES["gloss"])
    mean = goniometry.bin_means(law, angle, theta, phi)[0, 0]

    def power(p, t):
        return float(law(math.cos(angle), np.cos(t), p)) * math.sin(t) * math.cos(t)

    whole, _ = dblquad(power, *theta, *phi, epsrel=1e-10)
    projected = np.diff(np.sin(theta) ** 2)[0] / 2 * np.diff(phi)[0]
    assert mean == pytest.approx(whole / projected, rel=1e-9)


@pytest.mark.parametrize("sample", SAMPLES)
@pytest.mark.parametrize("degrees", [0, 45, 80])
def test_f_adds_up_to_the_albedo(sample, degrees):
    for side in sim.SIDES:
        if side == "front" or sample == "paper":
            means = goniometry.bin_means(law_of(SAMPLES[sample], side), math.radians(degrees), *FINE)
            assert (means * PROJECTED).sum() == pytest.approx(sim.albedo_of(SAMPLES[sample], side), rel=1e-12)


def test_a_cone_of_directions_has_its_projected_solid_angle_and_middle():
    for angle, azimuth, half in ((0.0, 0.0, 0.4), (0.7, 2.0, 0.3), (1.2, -1.0, math.pi / 2 - 1.2)):
        ways, weights = goniometry.cone(angle, azimuth, half)
        assert weights.sum() == pytest.approx(math.pi * math.sin(half) ** 2 * math.cos(angle), rel=1e-13)
        assert np.linalg.norm(ways, axis=1) == pytest.approx(1, rel=1e-14)
        axis = np.array(sim._way(angle, azimuth))
        assert (ways @ axis).min() > math.cos(half)
        middle = (weights / ways[:, 2]) @ ways
        assert middle == pytest.approx(axis * math.pi * math.sin(half) ** 2, rel=1e-12, abs=1e-13)
    with pytest.raises(ValueError, match="above the horizon"):
        goniometry.cone(1.3, 0.0, 0.3)


@pytest.mark.quick_cases("satin", "gloss")
@pytest.mark.parametrize("sample", ["satin", "gloss", "varnish"])
def test_means_between_cones_are_the_same_both_ways(sample):
    law = law_of(SAMPLES[sample])
    there, here = (goniometry.mean_between_cones(law, *ends, NARROW) for ends in ((LAMP, EYE), (EYE, LAMP)))
    assert there == pytest.approx(here, rel=1e-13)
    assert there != pytest.approx(float(law(math.cos(LAMP[0]), math.cos(EYE[0]), math.pi)), rel=1e-3)
    there, here = (
        goniometry.mean_between_cones(uneven, *ends, NARROW) for ends in ((LAMP, EYE), (EYE, LAMP))
    )
    means = [
        (weights @ ways[:, 2]) / weights.sum()
        for ways, weights in (goniometry.cone(*end, NARROW) for end in (EYE, LAMP))
    ]
    assert there / here == pytest.approx(means[0] / means[1], rel=1e-13)
    assert there / here == pytest.approx(0.64, abs=0.01)


def test_a_small_lamp_is_a_beam():
    law, half = law_of(SAMPLES["gloss"]), 1e-3
    bins = np.radians([40, 50]), np.radians([170, 190])
    lit = math.pi * math.sin(half) ** 2 * math.cos(0.8)
    small = goniometry.reflected_radiance(law, 0.8, half, *bins) / lit
    assert small == pytest.approx(goniometry.bin_means(law, 0.8, *bins), rel=1e-5)


@pytest.mark.slow
def test_quadrature_nodes_suffice_for_the_cases_of_the_sim(monkeypatch):
    cases = [
        {"sample": "gloss", "angle": math.radians(75)},
        *({"show": show, "sample": "gloss"} for show in ("swap", "lamp")),
    ]
    before = [sim.exact(**case) for case in cases]
    monkeypatch.setattr(goniometry, "NODES", 32)
    monkeypatch.setattr(goniometry, "SHARED", np.polynomial.legendre.leggauss(32))
    monkeypatch.setattr(goniometry, "AZIMUTHAL", np.polynomial.legendre.leggauss(64))
    for one, case in zip(before, cases, strict=True):
        assert list(one.values()) == pytest.approx(list(sim.exact(**case).values()), rel=1e-8)


# ---- measured ----


UNLISTED = [  # shows and angles that are not among the sim's own cases
    *({"sample": sample, "angle": angle} for sample in SAMPLES for angle in (0.0, math.radians(75))),
    *({"show": "swap", "sample": sample} for sample in ("matt", "satin")),
    *(
        {"show": show, "sample": sample}
        for show, sample in (("lamp", "satin"), ("lamp", "paper"), ("sky", "satin"))
    ),
]


@slow
@pytest.mark.parametrize("parameters", UNLISTED)
def test_every_sample_is_measured_under_every_light(parameters):
    for estimate, exact in rows(**parameters).values():
        assert_agrees(estimate, exact, FALSE_ALARM)


@slow
def test_all_bins_of_a_lobe_are_met():
    """Front bins in the plane of incidence, forward and back, of the roughest glossy sample."""
    reading = run(particles=2_000_000, sample="satin")["front"]
    expected = goniometry.bin_means(law_of(SAMPLES["satin"]), math.pi / 4, sim.THETA, sim.PHI - math.pi)
    f = reading.radiance_out / reading.irradiance
    assert_agrees(f, expected, FALSE_ALARM)
    assert not agrees(f, expected[:, ::-1])  # phi counted from the other side


@slow
def test_wrong_laws_are_rejected():
    """Other materials' laws, one reflection only, a cosine forgotten; a bias of 15 % in f would be seen."""
    found = {sample: rows(sample=sample)[SPECULAR][0] for sample in ("matt", "satin", "gloss", "varnish")}
    theta, phi = np.radians([42, 48]), sim.PHI[:2] - math.pi

    def mean(law):
        return goniometry.bin_means(law, math.pi / 4, theta, phi)[0, 0]

    for sample, estimate in found.items():
        assert smallest_bias(estimate, FALSE_ALARM) < 0.15
        assert agrees(estimate, mean(law_of(SAMPLES[sample])))
        for other in SAMPLES:
            if other != sample and (sample, other) != ("matt", "paper"):
                assert not agrees(estimate, mean(law_of(SAMPLES[other])))
    once = mean(lambda *d: 0.9 * microfacets.single_reflection(*d, 0.5))
    assert not agrees(found["satin"], once)
    unprojected = run(sample="gloss")["front"]
    assert not agrees(
        (unprojected.flux_density / unprojected.irradiance)[7, 0], mean(law_of(SAMPLES["gloss"]))
    )


@slow
def test_a_law_that_is_not_reciprocal_is_rejected():
    """Intensity over irradiance, the cosine at the eye forgotten, differs by cosθ_o/cosθ_i = 0.63."""
    result = run(400_000, show="swap", sample="gloss")
    shares = [result[name].flux_density[0] / result[name].irradiance for name in ("i to o", "o to i")]
    assert not agrees(shares[0] / shares[1], 1.0)
    estimate = sim.measure(result)[RATIO]
    assert smallest_bias(estimate, FALSE_ALARM) < 0.15
    assert not agrees(estimate, math.cos(EYE[0]) / math.cos(LAMP[0]))


@slow
def test_via_separates_the_light_of_both_lamps():
    """Without `via` the eye would see the other lamp's light too."""
    result = run(show="swap", sample="satin")
    lit = {name: result[f"lamp {name}"].flux_out for name in "io"}
    for a, b in ("io", "oi"):
        reading = result[f"{a} to {b}"]
        assert reading.flux_in.value == pytest.approx(lit[a].value, rel=1e-9)
    assert not agrees(result["i to o"].flux_in / result["o to i"].flux_in, 1.0)


@slow
def test_wrong_sums_are_rejected():
    """A lamp taken for a beam from its middle, a sky without the light that is reflected twice between facets."""
    estimate, exact = rows(1_000_000, show="lamp", sample="gloss")["L_out at 42° to 48°"]
    lit = math.pi * sim.RADIANCE * math.sin(sim.WIDE) ** 2 * math.cos(math.pi / 4)
    theta, phi = np.radians([42, 48]), sim.PHI[:2] - math.pi
    as_beam = lit * goniometry.bin_means(law_of(SAMPLES["gloss"]), math.pi / 4, theta, phi)[0, 0]
    assert agrees(estimate, exact)
    assert not agrees(estimate, as_beam)
    estimate, exact = rows(400_000, show="sky", sample="satin")["L_out at 66° to 72°"]
    once = exact * microfacets.single_albedo(math.cos(math.radians(69)), 0.5)
    assert smallest_bias(estimate, FALSE_ALARM) < 0.05
    assert not agrees(estimate, once)


@slow
def test_reflected_and_transmitted_light_of_paper_differ():
    found = rows(sample="paper")
    behind, _ = found["f behind it at 42° to 48°"]
    assert not agrees(behind, 0.6 / math.pi)
    assert not agrees(found[ALBEDO][0], 0.9)


# ---- the sim ----


def test_exact_values_are_even():
    """What is exchanged has one exact value, and the irradiance of a lamp is that of its cone."""
    exact = sim.exact(show="swap", sample="gloss")
    assert exact[THERE] == pytest.approx(exact[HERE], rel=1e-13)
    assert sim.exact(show="lamp")["irradiance"] == pytest.approx(14.8808362, rel=1e-7)
