"""What a particle went through before: `via` and `events` count histories, so their laws are identities of integers.

A meter that nothing comes through alive, because it is black, shows what has never crossed it: the histories are the
same to the last bit until they meet it.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest

import transport as tp
from transport.results.detectors import BINS
from transport.results.tally import ARRIVALS, DEPARTURES, SIDES

PARTICLES = 30_000
FACES = tp.Box(size=2.0).faces()
PANE = tp.Disk(center=(0.2, 0.1, 0.3), normal=(0.3, -0.5, 1.0), radius=0.5)
WINDOW = tp.Rectangle(center=(-0.4, 0.2, -0.3), normal=(1, 0.4, 0), width=0.8, height=0.9)
BALL = tp.Sphere(center=(0.4, -0.5, -0.2), radius=0.35)
KINDS = {
    "-x": tp.Diffuse(0.9), "+x": tp.Mirror(), "-y": tp.Diffuse(1.0), "+y": tp.Mirror(0.8),
    "-z": tp.Mixture({tp.Diffuse(1.0): 0.5, tp.Mirror(): 0.5}), "+z": tp.Black(),
}  # fmt: skip
SOURCES = [
    tp.Source("-x", tp.Lambertian(power=1.0), side="back"),
    tp.Source(tp.Point(position=(0.6, 0.6, 0.6)), tp.Isotropic(power=1.0)),
]


def walls(**others):
    return [tp.Surface(FACES[n], others.get(n, kind), n) for n, kind in KINDS.items()]


def simulated(detectors, surfaces=None, sources=SOURCES, duration=None):
    scene = tp.Scene(sources, walls() if surfaces is None else surfaces, detectors, duration=duration)
    return tp.simulate(scene, particles=PARTICLES, seed=1, progress=False)


def counts(reading, side=ARRIVALS):
    """Histories by direction, (cosines,), or in all."""
    if reading.detector.directions is None:
        return reading.counts_of(f"weight {SIDES[side]}").sum()
    return reading.counts_of(f"weight {SIDES[side]}", BINS).sum(axis=0)


def back(wall, name=None, **options):
    """A detector on the inside of a wall."""
    return tp.Detector(wall, name, side="back", **options)


def both_sides(shape, name, **options):
    """Two meters on one shape, which together count every crossing."""
    return [tp.Detector(shape, f"{name} {side}", side=side, **options) for side in ("front", "back")]


def crossings(result, name):
    return sum(counts(result[f"{name} {side}"]) for side in ("front", "back"))


# ---- via ----


def looks():
    """On a wall by direction, through a window from both sides: all, and what came by the pane."""
    found = [*both_sides(PANE, "pane")]
    for name, via in (("all", None), ("via", "pane front")):
        found.append(back("-y", f"wall {name}", directions=tp.Directions(mu=4), via=via))
        found += both_sides(WINDOW, f"window {name}", via=via)
    return [*found, *both_sides(PANE, "again", via="pane front")]


@lru_cache(maxsize=2)
def open_and_shut():
    """The pane as a meter, and the same pane black."""
    shutter = tp.Surface(PANE, tp.Black(), "shutter")
    return simulated(looks()), simulated(looks(), [*walls(), shutter])


@pytest.mark.parametrize("side", [ARRIVALS, DEPARTURES])
def test_histories_by_a_pane_and_those_that_never_crossed_it_add_up(side):
    through, never = open_and_shut()
    every, via = (counts(through[name], side) for name in ("wall all", "wall via"))
    without = counts(never["wall all"], side)
    np.testing.assert_array_equal(via + without, every)
    assert (via > 20).all() and (without > 20).all()
    assert (counts(never["wall via"], side) == 0).all()


def test_a_window_counts_what_came_by_a_pane_from_both_of_its_sides():
    through, never = open_and_shut()
    for side in ("front", "back"):
        every, via = (counts(through[f"window {name} {side}"]) for name in ("all", "via"))
        without = counts(never[f"window all {side}"])
        assert via + without == every and via > 100 < without


def test_via_itself_counts_second_and_later_crossings():
    """Front and back alike: what crosses the pane for the first time is what meets it where it is black."""
    through, never = open_and_shut()
    first, all_ = crossings(never, "pane"), crossings(through, "pane")
    assert crossings(through, "again") == all_ - first > 100
    assert crossings(never, "again") == 0


def test_a_meter_on_a_wall_is_no_earlier_crossing_of_its_own():
    """The first arrival at a wall has not come by it, nor the departure that follows at once."""
    named = [back("-y"), back("-y", "later", via="-y")]
    surfaces = [tp.Surface(FACES[n], tp.Black() if n != "-y" else tp.Diffuse(1.0), n) for n in FACES]
    point = [tp.Source(tp.Point(position=(0.6, 0.6, 0.6)), tp.Isotropic(power=1.0))]
    result = simulated(named, surfaces, point)
    assert counts(result["-y"]) == counts(result["-y"], DEPARTURES) > 1000
    assert counts(result["later"]) == counts(result["later"], DEPARTURES) == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["-x", "ball"])
def test_via_a_surface_is_to_have_met_it_or_to_have_been_born_on_it(name):
    """Against the same wall black: what is born on it still leaves, and all else ends there."""
    ball = tp.Surface(BALL, tp.Diffuse(0.9), "ball")
    born = tp.Source(name, tp.Lambertian(power=1.0), side="front" if name == "ball" else "back")
    black = {"-x": tp.Black()} if name == "-x" else {}
    sources = {"born": [born], "else": SOURCES[1:], "both": [born, *SOURCES[1:]]}
    found = [back("-y", "all"), back("-y", "via", via=name)]
    results = {of: simulated(found, [*walls(), ball], some) for of, some in sources.items()}
    assert counts(results["born"]["all"]) == counts(results["born"]["via"]) > 1000
    end = tp.Surface(BALL, tp.Black(), "ball") if name == "ball" else ball
    never = simulated(found, [*walls(**black), end], sources["else"])
    total, via = (counts(results["else"][which]) for which in ("all", "via"))
    assert via == total - counts(never["all"]) > 100
    assert counts(never["via"]) == 0
    assert counts(results["both"]["via"]) < counts(results["both"]["all"])


def test_a_patch_of_light_on_a_floor_has_left_the_floor_where_it_lies():
    """A disk that shines, half on the named floor and half beside it."""
    lamp = tp.Source(tp.Disk(radius=0.5), tp.Lambertian(power=1.0))
    floor = tp.Rectangle(center=(1.0, 0, 0), width=2.0, height=2.0)
    roof = tp.Rectangle(center=(0, 0, 0.01), normal=(0, 0, -1), width=40.0, height=40.0)
    for material in (tp.Black(), tp.Transparent()):
        found = [tp.Detector(roof, "all"), tp.Detector(roof, "via", via="floor")]
        found += [tp.Detector(roof, "half", positions=tp.Positions(u=(-20, 0, 20)), via="floor")]
        result = simulated(found, [tp.Surface(floor, material, "floor")], [lamp])
        total, via = counts(result["all"]), counts(result["via"])
        assert total > 0.99 * PARTICLES
        assert abs(via - total / 2) < 5 * math.sqrt(PARTICLES) / 2
        by_place = result["half"].counts_of("weight in", BINS).sum(axis=0)
        assert by_place.max() > 0.98 * via


def test_via_several_is_to_have_come_by_all_of_them():
    """Inclusion and exclusion: both = one + other - either, and either = all - neither."""
    options = {"all": None, "one": "pane front", "other": "+x", "both": ("+x", "pane front")}
    names = [back("-y", name, via=via) for name, via in options.items()]
    found = [*both_sides(PANE, "pane"), *names]
    result = simulated(found)
    black = simulated(found, [*walls(**{"+x": tp.Black()}), tp.Surface(PANE, tp.Black(), "shutter")])
    every, one, other, both = (counts(result[name]) for name in options)
    either = every - counts(black["all"])
    assert both == one + other - either
    assert 100 < both < min(one, other) and max(one, other) < either < every


def test_via_a_pane_is_the_same_for_either_side_of_a_detector_and_for_a_transparent_surface():
    vias = ("pane front", "pane back", "film")
    found = [*both_sides(PANE, "pane"), *(back("-y", f"by {via}", via=via) for via in vias)]
    result = simulated(found, [*walls(), tp.Surface(PANE, tp.Transparent(), "film")])
    assert len({int(counts(result[f"by {via}"])) for via in vias}) == 1 and counts(result["by film"]) > 100


# ---- events ----


EVENTS = {str(n): n for n in range(4)}
EVENTS |= {"more": (4, math.inf), "1 to 3": (1, 3), "some": (1, math.inf), "all": None}


def events_at(place, name, **options):
    """Detectors for 0, 1, 2, 3 reflections, for more, for 1 to 3 and for any."""
    return [tp.Detector(place, f"{name} {n}", events=e, **options) for n, e in EVENTS.items()]


@lru_cache(maxsize=1)
def reflected():
    found = [d for n in FACES for d in events_at(n, n, side="back")]
    return simulated([*found, *events_at(PANE, "pane", directions=tp.Directions(mu=3))])


@pytest.mark.parametrize("side", [ARRIVALS, DEPARTURES])
@pytest.mark.parametrize("place", [*FACES, "pane"])
def test_all_numbers_of_reflections_together_are_all(place, side):
    result = reflected()
    found = {n: counts(result[f"{place} {n}"], side) for n in EVENTS}
    np.testing.assert_array_equal(found["0"] + found["some"], found["all"])
    np.testing.assert_array_equal(found["1"] + found["2"] + found["3"], found["1 to 3"])
    np.testing.assert_array_equal(found["0"] + found["1 to 3"] + found["more"], found["all"])
    if (place, side) != ("+z", DEPARTURES):
        assert (found["more"] > 20).all()


@pytest.mark.parametrize("place", ["-x", "+x", "-y", "+y", "-z"])
def test_departures_from_a_wall_have_reflected_once_more_than_arrivals(place):
    """Besides what is born on it, which has not."""
    result = reflected()
    for n in range(3):
        arrived = counts(result[f"{place} {n}"])
        assert counts(result[f"{place} {n + 1}"], DEPARTURES) == arrived > 100
        assert arrived != counts(result[f"{place} {n + 1}"])  # a count that is one off is rejected
    born = counts(result[f"{place} 0"], DEPARTURES)
    assert born == (PARTICLES // 2 if place == "-x" else 0) or abs(born - PARTICLES / 2) <= len(result.run)


def test_histories_without_reflection_are_those_among_black_walls():
    """Direct light, at every wall and through the pane."""
    black = [tp.Surface(FACES[n], tp.Black(), n) for n in FACES]
    dark = simulated([back(n) for n in FACES] + events_at(PANE, "pane"), black)
    result = reflected()
    assert all(counts(result[f"+z {n}"], DEPARTURES) == 0 for n in EVENTS)  # a black wall: nothing leaves
    for n in FACES:
        assert counts(result[f"{n} 0"]) == counts(dark[n]) > 1000
    assert counts(result["pane 0"]).sum() == counts(dark["pane all"]) == counts(dark["pane 0"])


def test_passing_a_transparent_share_of_a_mixture_is_no_reflection():
    """Two panes, half clear and half mirror: what comes straight through both has no event, what went to and fro two."""
    half = tp.Mixture({tp.Transparent(): 0.5, tp.Mirror(): 0.5})
    panes = [tp.Surface(tp.Disk(center=(0, 0, z), radius=1.0), half, f"pane {z}") for z in (1, 2)]
    beam = tp.Source(tp.Point(), tp.Beam(direction=(0, 0, 1), power=1.0))
    behind = tp.Disk(center=(0, 0, 3), radius=1.0)
    found = [tp.Detector(behind, str(n), side="back", events=n) for n in range(6)]
    result = simulated(found, panes, [beam])
    found = np.array([counts(result[str(n)]) for n in range(6)])
    assert (found[1::2] == 0).all() and (found[::2] > 50).all()
    shares = np.array([0.25, 0.0625, 0.015625])
    assert (np.abs(found[::2] - PARTICLES * shares) < 5 * np.sqrt(PARTICLES * shares)).all()


def test_via_and_events_go_with_bins_of_time():
    """Numbers in all bins of time together are those without; one filter does not disturb the other."""
    options = {"via": "pane front", "events": (1, 2)}
    found = [*both_sides(PANE, "pane"), back("-y", "timed", times=5, **options)]
    found += [back("-y", "untimed", **options)]
    found += [back("-y", f"just {n}", via="pane front", events=n) for n in (1, 2)]
    sources = [tp.Source("-x", tp.Lambertian(energy=1.0, speed=1.0), side="back")]
    result = simulated(found, sources=sources, duration=12.0)
    timed = result["timed"].counts_of("weight in").sum(axis=0)
    assert timed.sum() == counts(result["untimed"]) == counts(result["just 1"]) + counts(result["just 2"])
    assert (timed[1:] > 50).all()
