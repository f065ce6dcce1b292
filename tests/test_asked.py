"""What is said in vain or in the wrong place is not passed over: tracking without media, words, masks, rounding.

Nothing here is a matter of chance.
"""

from __future__ import annotations

import dataclasses
import inspect

import numpy as np
import pytest

import transport as tp
from transport.results.result import Ledger
from transport.validation import SIMULATE_PARAMETERS

LAMP = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
BOX = tp.Box(size=2)
SPLIT = tp.Splitting(start=(0, 0, 0), end=(0, 0, 1), gain=3)
IDLE = "tracking: without effect, because no medium here absorbs or scatters"


def filled(medium=None, *more) -> tp.Scene:
    return tp.Scene(LAMP, [tp.Surface(BOX, tp.Transparent(), inside=medium), *more])


def run(scene, tracking=None, particles=320):
    return tp.simulate(scene, particles, seed=1, threads=1, tracking=tracking, progress=False)


def told(scene, tracking=None) -> list[str]:
    """What the report says about tracking."""
    return [line for line in run(scene, tracking).report().splitlines() if line.startswith("tracking")]


def refusal(made) -> str:
    with pytest.raises(tp.SceneError) as refused:
        made()
    return str(refused.value)


# ---- tracking that has nothing to do ----


@pytest.mark.parametrize("medium", [None, tp.Vacuum(), tp.Medium(), tp.Medium(absorption=0.0, index=1.0)])
@pytest.mark.parametrize("tracking", ["analog", "weighted", tp.Tracking(splitting=SPLIT)])
def test_tracking_without_media_is_told_to_have_been_in_vain(medium, tracking):
    """Not refused: a sweep over coefficients from 0 on begins with it."""
    assert told(filled(medium), tracking) == [IDLE]
    assert told(filled(medium)) == []


def test_glass_that_absorbs_nothing_is_no_medium_to_track_in():
    lamp = tp.Source(tp.Point(position=(0, 0, 3)), tp.Isotropic(power=1.0))
    glass = tp.Scene(lamp, tp.Surface(BOX, tp.Dielectric(1.5), inside=tp.Medium(index=1.5)))
    assert told(glass) == [] and told(glass, "weighted") == [IDLE]


@pytest.mark.parametrize(
    ("tracking", "said"),
    [
        (None, "absorption by weight"),
        ("analog", "analog absorption"),
        (tp.Tracking(forced=True), "absorption by weight, no collisions to force"),
        (tp.Tracking(splitting=SPLIT), "absorption by weight, nothing to split: no collisions"),
        (tp.Tracking(absorption="analog", forced=True), "analog absorption, first collisions forced"),
        (tp.Tracking(absorption="analog", splitting=SPLIT), "analog absorption, split by importance, gain 3"),
    ],
)
def test_where_nothing_scatters_weights_leave_nothing_to_force_or_split(tracking, said):
    assert told(filled(tp.Medium(absorption=1.0)), tracking) == [f"tracking: {said}"]


def test_where_something_scatters_both_are_done():
    fog = filled(tp.Medium(scattering=1.0, absorption=1.0))
    assert told(fog, tp.Tracking(forced=True)) == ["tracking: absorption by weight, first collisions forced"]
    assert told(fog, tp.Tracking(splitting=SPLIT)) == [
        "tracking: absorption by weight, split by importance, gain 3"
    ]


# ---- words in the wrong place ----


@pytest.mark.parametrize("name", sorted(SIMULATE_PARAMETERS))
def test_what_is_simulates_is_not_the_scenes(name):
    said = refusal(lambda: tp.Scene(LAMP, **{name: "analog"}))
    assert said == f"Scene: unknown parameter {name}='analog'; write simulate(scene, {name}=...)"


def test_all_that_simulate_takes_is_known_as_its_own():
    assert set(inspect.signature(tp.simulate).parameters) - {"scene"} == SIMULATE_PARAMETERS


@pytest.mark.parametrize(
    ("word", "cure"),
    [
        ("analogue", "did you mean 'analog'?"),
        ("weight", "did you mean 'weighted'?"),
        ("forced", "write tracking=Tracking(forced=...)"),
        ("splitting", "write tracking=Tracking(splitting=...)"),
        ("russian", "leave it out for the default of the scene"),
        (3, "leave it out for the default of the scene"),
    ],
)
def test_a_word_near_a_tracking_is_told_which(word, cure):
    said = refusal(lambda: run(filled(), word))
    assert said == f"simulate: tracking must be 'analog', 'weighted' or a Tracking, got {word!r}; {cure}"


def test_weights_with_a_clock_are_refused_in_the_words_that_were_said():
    fog = tp.Medium(absorption=1.0)
    clocked = tp.Scene(LAMP, tp.Surface(BOX, tp.Transparent(), inside=fog), duration=1e-8)
    for tracking, said in (
        ("weighted", "got 'weighted'; leave it out"),
        (tp.Tracking(), "write Tracking(absorption='analog', ...)"),
    ):
        assert refusal(lambda tracking=tracking: run(clocked, tracking)).endswith(said)


# ---- masked values ----

GAPS = np.ma.masked_greater(np.array([1.0, 2.0, 9.97e36]), 1e30)
CURE = "write .filled(0), or another number"


@pytest.mark.parametrize("name", ["absorption", "scattering"])
def test_voxels_without_a_value_are_refused(name):
    said = refusal(lambda: tp.Grid(box=BOX, **{name: GAPS[None, None]}))
    assert said == f"Grid: {name} must have all its values, got 1 of 3 values masked; {CURE}"


@pytest.mark.parametrize(
    "made",
    [
        lambda: tp.Tabulated(mu=[-1, 0, 1], density=GAPS),
        lambda: tp.Tabulated(mu=np.ma.masked_equal([-1.0, 0.0, 1.0], 0), density=[1, 2, 3]),
        lambda: tp.Detector(tp.Disk(radius=1), "lid", times=GAPS),
        lambda: tp.Point(position=GAPS),
        lambda: tp.Medium(absorption=GAPS[2:]),
    ],
    ids=["density", "mu", "edges", "place", "number"],
)
def test_masked_values_are_refused_with_their_cure_wherever_they_come(made):
    said = refusal(made)
    assert "masked" in said and CURE in said and "9.97e+36" not in said


def test_a_masked_array_without_gaps_is_an_array():
    whole = np.ma.masked_greater(np.array([[[1.0, 2.0]]]), 1e30)
    assert tp.Grid(box=BOX, absorption=whole) == tp.Grid(box=BOX, absorption=whole.data)
    assert tp.Grid(box=BOX, absorption=GAPS[None, None].filled(0)).absorption.max() == 2.0


# ---- rounding is no roulette ----

THIN = filled(tp.Medium(absorption=0.01, scattering=0.01))
FORCED = {how: tp.Tracking(absorption=how, forced=True) for how in ("analog", "weighted")}


@pytest.mark.parametrize("how", FORCED)
def test_copies_that_share_a_weight_to_rounding_play_no_roulette(how):
    result = run(THIN, FORCED[how], 2000)
    assert any(batch.ledger["roulette"] for batch in result.batches)  # 5e-17 of a history's weight
    assert result.ledger["roulette"].value == 0
    assert ("roulette" in str(result.ledger)) == (how == "weighted")  # which might have killed
    entries = dict(result.ledger)
    assert entries.pop("emitted").value == pytest.approx(
        sum(part.value for part in entries.values()), rel=1e-14
    )


@pytest.mark.parametrize("how", FORCED)
@pytest.mark.parametrize("gain", [1e-14, -1e-14, 1e-3])
def test_what_is_more_than_rounding_is_in_the_ledger(how, gain):
    """An engine that gains a little in one batch of 32 does not hide it."""
    result = run(THIN, FORCED[how], 2000)
    first = result.batches[0]
    result.batches[0] = dataclasses.replace(first, ledger=first.ledger | {"roulette": gain * first.born})
    roulette = Ledger(result)["roulette"]
    assert roulette.value == pytest.approx(gain / 32, rel=0.1) and not roulette.exact
    assert "roulette" in str(Ledger(result))


def test_roulette_at_walls_stays_in_the_ledger():
    walls = tp.Surface(tp.Box(size=4), tp.Diffuse(0.5))
    result = run(filled(tp.Medium(absorption=0.01, scattering=0.01), walls), FORCED["analog"], 2000)
    assert result.ledger["roulette"].error > 1e-4
