"""Glow: fog in equilibrium with its walls, and alone in the dark; what is out of balance shows.

Each statistical judgement fails right code in one of 10^5 seeds; the seed is 1.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from transport.sims import glow
from transport.sims.glow import ESCAPED, SHARE
from transport.theory import glow as theory

pytestmark = pytest.mark.slow  # runs of millions of particles

FALSE_ALARM = 1e-5
SCENE = glow.scene()


def run(scene, particles=300_000):
    return tp.simulate(scene, particles=particles, seed=1, threads=2)


@pytest.fixture(scope="module")
def furnace():
    return run(SCENE, 1_000_000)


def assert_rows(result, exact):
    rows = glow.measure(result)
    assert rows.keys() == exact.keys()
    for name, value in exact.items():
        if name == ESCAPED:
            assert rows[name].value == 0
        else:
            assert_agrees(rows[name], value, FALSE_ALARM)
    assert result.ledger["lost"].value == 0


# ---- between walls ----


def test_radiance_is_the_same_everywhere(furnace):
    assert_rows(furnace, glow.exact())


@pytest.mark.parametrize("change", [{"albedo": 0.0}, {"albedo": 0.9}, {"index": 1.2, "radiance": 7.0}])
def test_whatever_the_walls_and_the_glass_are(change):
    assert_rows(run(glow.scene(**change)), glow.exact(**change))


def test_no_meter_is_off_by_itself(furnace):
    for name, level in glow.levels(SCENE).items():
        assert_agrees(glow.mean_level(furnace, (name,)), 1.0, FALSE_ALARM)
        assert glow.chi_square(furnace, {name: level}).z(1.0) < 6, name
    assert_agrees(glow.chi_square(furnace, glow.levels(SCENE)), 1.0, FALSE_ALARM)


def test_chi_square_sees_levels_that_are_wrong(furnace):
    """Planted: L for n² L in glass, a room without glass, 1.1 L for L in a fog."""
    wrong = {"glass inside": 1.0, "in room": np.ones(1), "in thick": 1.1}
    for name, level in wrong.items():
        assert_rejected(glow.chi_square(furnace, {name: np.asarray(level)}), 1.0)


def test_light_comes_from_everywhere_to_everywhere(furnace):
    """Fluence rate 4π n² L, irradiance π n² L, net flux 0, beyond the escape cone as well."""
    for name in glow.BODIES:
        bright = 2.25 if name == "glass" else 1.0
        assert_agrees(furnace[f"in {name}"].fluence_rate, 4 * math.pi * bright, FALSE_ALARM)
        for side, level in (("inside", bright), ("outside", 1.0)):
            assert_agrees(furnace[f"{name} {side}"].irradiance, math.pi * level, FALSE_ALARM)
            assert_agrees(furnace[f"{name} {side}"].net_flux_density, 0.0, FALSE_ALARM)
    grazing = furnace["glass inside"].radiance.mean("phi")[
        :4
    ]  # up to μ = 0.67; the escape cone begins at 0.745
    assert_agrees(grazing, 2.25, FALSE_ALARM)


# ---- out of balance ----


def rows_with(media=None, walls=None, materials=None):
    """Rows of a furnace whose media, walls' radiance or materials are others, by surface."""
    surfaces = []
    for surface in SCENE.surfaces:
        name = surface.name
        inside = dataclasses.replace(surface.inside, **(media or {}).get(name, {}))
        material = (materials or {}).get(name, surface.material)
        surfaces.append(tp.Surface(surface.shape, material, name, inside=inside))
    sources = (
        SCENE.sources if walls is None else tp.Source("room", tp.Lambertian(radiance=walls), side="inside")
    )
    return glow.measure(run(tp.Scene(sources, surfaces, SCENE.detectors), 500_000))


def test_glass_without_its_index_squared_is_rejected():
    rows = rows_with({"glass": {"emission": 3.0}})
    assert_rejected(rows["L/n²L₀, within glass"], 1.0)
    assert_rejected(rows["absorbed / emitted, glass"], 1.0)


def test_a_fog_colder_by_a_tenth_of_its_emission_is_rejected():
    rows = rows_with({"thick": {"emission": 18.0}})
    assert_rejected(rows["L/n²L₀, within fog"], 1.0)
    assert_rejected(rows["absorbed / emitted, thick"], 1.0)


def test_walls_hotter_by_a_tenth_are_rejected():
    rows = rows_with(walls=0.66)
    assert_rejected(rows["L/n²L₀, the walls"], 1.0)
    assert_rejected(rows["absorbed / emitted, thick"], 1.0)


def test_air_that_absorbs_and_does_not_glow_is_rejected():
    assert_rejected(rows_with({"room": {"absorption": 0.05}})["L/n²L₀, the whole room"], 1.0)


def test_scattering_and_its_phase_do_not_matter():
    """The same rows, of other scattering everywhere."""
    media = {
        name: {"scattering": 30.0, "phase": tp.HenyeyGreenstein(-0.8)} for name in ("thin", "thick", "ball")
    }
    rows = rows_with(media)
    for name, value in glow.exact().items():
        if name != ESCAPED:
            assert_agrees(rows[name], value, FALSE_ALARM)


# ---- in the dark ----


@pytest.mark.parametrize(
    "parameters",
    [{"show": show, "depth": depth} for show in ("ball", "slab") for depth in (1e-6, 0.1, 1.0, 30.0)]
    + [{"show": "ball", "depth": 2.0, "radiance": 1e-9}],
)
def test_rows_in_the_dark_are_met(parameters):
    result, exact = run(glow.scene(**parameters)), glow.exact(**parameters)
    rows = glow.measure(result)
    assert rows.keys() == exact.keys()
    for name, value in exact.items():
        assert_agrees(rows[name], value, FALSE_ALARM)


@pytest.mark.parametrize("show", ["ball", "slab"])
def test_all_bins_of_a_face_are_met_and_other_laws_rejected(show):
    """Planted: a black body's radiance, a thin fog's, the other body's."""
    leaving = glow.leaving_share(run(glow.scene(show), 1_000_000))
    assert_agrees(leaving, glow.expected_leaving(show, 1.0), FALSE_ALARM)
    middles = (np.arange(glow.BINS) + 0.5) / glow.BINS
    other = "slab" if show == "ball" else "ball"
    for wrong in (1.0, 2 * middles, 1 / middles, glow.expected_leaving(other, 1.0)):
        assert_rejected(leaving, wrong)


def test_all_shells_are_met_and_an_even_ball_is_rejected():
    result = run(glow.scene("ball"), 1_000_000)
    shares = theory.ball_shell_shares(1.0, np.linspace(0, 1, glow.SHELLS + 1))
    found = result["shells"].fluence_rate / (4 * math.pi)
    assert_agrees(found, shares, FALSE_ALARM)
    assert_rejected(found, 1 - theory.ball_escape(1.0))
    assert_rejected(glow.measure(result)[SHARE], float(theory.slab_escape(1.0)))
