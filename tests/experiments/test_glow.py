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


def run(scene, particles=150_000):
    result = tp.simulate(scene, particles=particles, seed=1, threads=2)
    assert result.ledger["lost"].value == 0
    return result


@pytest.fixture(scope="module")
def furnace():
    return run(SCENE, 500_000)


@pytest.fixture(scope="module")
def alone():
    """A ball and a slab of the depth 1 in the dark."""
    return {show: run(glow.scene(show), 1_000_000) for show in ("ball", "slab")}


def assert_rows(rows, exact):
    assert rows.keys() == exact.keys()
    for name, value in exact.items():
        if name == ESCAPED:
            assert rows[name].value == 0
        else:
            assert_agrees(rows[name], value, FALSE_ALARM)


# ---- between walls ----


@pytest.mark.parametrize("albedo", [0.0, 0.9])
def test_whatever_the_albedo_of_the_walls_is(albedo):
    assert_rows(glow.measure(run(glow.scene(albedo=albedo))), glow.exact(albedo=albedo))


def test_no_meter_is_off_by_itself(furnace):
    for name, level in glow.levels(SCENE).items():
        off = glow.deviations(furnace, {name: level})
        assert_agrees(off.mean(), 1.0, FALSE_ALARM)
        assert off.chi_square().z(1.0) < 6, name
    assert_agrees(glow.deviations(furnace, glow.levels(SCENE)).chi_square(), 1.0, FALSE_ALARM)


def test_chi_square_sees_levels_that_are_wrong(furnace):
    """Planted: L for n² L in glass, a room without glass, 1.1 L for L in a fog."""
    wrong = {"glass inside": 1.0, "in room": np.ones(1), "in thick": 1.1}
    for name, level in wrong.items():
        assert_rejected(glow.deviations(furnace, {name: np.asarray(level)}).chi_square(), 1.0)


def test_light_comes_from_everywhere_to_everywhere(furnace):
    """Fluence rate 4π n² L, irradiance π n² L, net flux 0, beyond the escape cone as well."""
    for name in glow.BODIES:
        bright = 2.25 if name == "glass" else 1.0
        assert_agrees(furnace[f"in {name}"].fluence_rate, 4 * math.pi * bright, FALSE_ALARM)
        for side, level in (("inside", bright), ("outside", 1.0)):
            assert_agrees(furnace[f"{name} {side}"].irradiance, math.pi * level, FALSE_ALARM)
            assert_agrees(furnace[f"{name} {side}"].net_flux_density, 0.0, FALSE_ALARM)
    beyond = slice(4)  # up to μ = 0.67; the escape cone begins at 0.745
    assert_agrees(furnace["glass inside"].radiance.mean("phi")[beyond], 2.25, FALSE_ALARM)


# ---- out of balance ----


def rows_with(media=None, walls=None):
    """Rows of a furnace whose media or walls' radiance are others, by surface."""
    surfaces = []
    for s in SCENE.surfaces:
        inside = dataclasses.replace(s.inside, **(media or {}).get(s.name, {}))
        surfaces.append(tp.Surface(s.shape, s.material, s.name, inside=inside))
    sources = (
        SCENE.sources if walls is None else tp.Source("room", tp.Lambertian(radiance=walls), side="inside")
    )
    return glow.measure(run(tp.Scene(sources, surfaces, SCENE.detectors), 200_000))


WRONG = {  # furnaces out of balance, and the rows that show it
    "glass without its n squared": (
        {"media": {"glass": {"emission": 3.0}}},
        ["L/n²L₀, within glass", "absorbed / emitted, glass"],
    ),
    "a fog colder by a tenth of its emission": (
        {"media": {"thick": {"emission": 18.0}}},
        ["L/n²L₀, within fog", "absorbed / emitted, thick"],
    ),
    "walls hotter by a tenth": ({"walls": 0.66}, ["L/n²L₀, the walls", "absorbed / emitted, thick"]),
    "air that absorbs and does not glow": (
        {"media": {"room": {"absorption": 0.05}}},
        ["L/n²L₀, the whole room"],
    ),
}


@pytest.mark.parametrize(("change", "names"), WRONG.values(), ids=WRONG)
def test_a_furnace_out_of_balance_is_rejected(change, names):
    rows = rows_with(**change)
    for name in names:
        assert_rejected(rows[name], 1.0)


def test_scattering_and_its_phase_do_not_matter():
    """The same rows, of other scattering everywhere."""
    other = {"scattering": 30.0, "phase": tp.HenyeyGreenstein(-0.8)}
    assert_rows(rows_with(dict.fromkeys(("thin", "thick", "ball"), other)), glow.exact())


# ---- in the dark ----


@pytest.mark.parametrize(
    "parameters",
    [{"show": show, "depth": depth} for show in ("ball", "slab") for depth in (1e-6, 0.1, 1.0, 30.0)]
    + [{"show": "ball", "depth": 2.0, "radiance": 1e-9}],
)
def test_rows_in_the_dark_are_met(parameters):
    assert_rows(glow.measure(run(glow.scene(**parameters))), glow.exact(**parameters))


@pytest.mark.parametrize("show", ["ball", "slab"])
def test_all_bins_of_a_face_are_met_and_other_laws_rejected(alone, show):
    """Planted: a black body's radiance, a thin fog's, the other body's."""
    leaving = glow.leaving_share(alone[show])
    assert_agrees(leaving, glow.expected_leaving(show, 1.0), FALSE_ALARM)
    middles = (np.arange(glow.BINS) + 0.5) / glow.BINS
    other = "slab" if show == "ball" else "ball"
    for wrong in (1.0, 2 * middles, 1 / middles, glow.expected_leaving(other, 1.0)):
        assert_rejected(leaving, wrong)


def test_all_shells_are_met_and_an_even_ball_is_rejected(alone):
    result = alone["ball"]
    shares = theory.ball_shell_shares(1.0, np.linspace(0, 1, glow.SHELLS + 1))
    found = result["shells"].fluence_rate / (4 * math.pi)
    assert_agrees(found, shares, FALSE_ALARM)
    assert_rejected(found, 1 - theory.ball_escape(1.0))
    assert_rejected(glow.measure(result)[SHARE], float(theory.slab_escape(1.0)))
