"""The small print: warnings, refusals and short forms that a reader meets now and then.

Nothing here is a matter of chance: each sentence is there where it is due, and only there.
"""

from __future__ import annotations

import io
import math
from types import ModuleType, SimpleNamespace

import pytest
from rich.console import Console

import transport as tp
from transport.analysis.effects import PassCost, effects_of
from transport.cli.effects import pass_table
from transport.cli.run import case_warnings
from transport.verification.experiment import run_experiment

LIGHT, HEAVY = (tp.Maxwellian(temperature=300.0, mass=mass) for mass in (6.6e-27, 1.44e-25))
SMALL, LARGE = tp.Sphere(radius=1.0), tp.Sphere(radius=2.0)
LAMP = tp.Source(tp.Point(), tp.Isotropic(power=1.0))


def run(sources, surfaces=(), detectors=(), **more):
    return tp.simulate(tp.Scene(sources, surfaces, detectors, **more), particles=1000, seed=1, progress=False)


# ---- a closed shape's outside that counted nothing ----


def blind(result):
    return [warning for warning in result.warnings if "counted nothing" in warning]


def test_the_outside_of_a_wall_round_the_light_is_warned_of():
    wall = tp.Surface(SMALL, tp.Black(), "wall")
    result = run(LAMP, wall, [tp.Detector("wall", "meter"), tp.Detector("wall", "other", side="inside")])
    why = "Surface 'wall' encloses every source and lets no light through"
    assert blind(result) == [
        f"detector 'meter' counted nothing: {why}. Write side='inside', or move a source outside"
    ]
    assert result["meter"].is_blind
    assert not result["other"].is_blind


def test_what_only_leaves_or_only_arrives_is_counted():
    glowing = tp.Source(SMALL, tp.Lambertian(radiance=1.0))  # nothing comes back to it
    sky = tp.Source(LARGE, tp.Lambertian(radiance=1.0), side="inside", aim=SMALL)
    black = tp.Surface(SMALL, tp.Black(), "wall")  # nothing leaves it
    for source, surfaces in ((glowing, ()), (sky, black)):
        result = run(source, surfaces, tp.Detector(SMALL, "meter"))
        fluxes = result["meter"].flux_in.value, result["meter"].flux_out.value
        assert sorted(flux > 0 for flux in fluxes) == [False, True]
        assert not result["meter"].is_blind
        assert blind(result) == []


def test_detectors_inside_a_black_wall_name_it():
    wall = tp.Surface(SMALL, tp.Black(), "wall")
    sky = tp.Source(LARGE, tp.Lambertian(radiance=1.0), side="inside")
    dark = [tp.Detector("wall", "within", side="inside"), tp.Detector(tp.Disk(radius=0.1), "disk")]
    result = run(sky, wall, dark)
    warnings = blind(result)
    assert len(warnings) == 2 and all("Surface 'wall' encloses it" in warning for warning in warnings)


# ---- quantities that need a mass ----

PLATE = tp.Disk(center=(0, 0, 1), radius=1.0)


def plate_of(*emissions):
    sources = [tp.Source(tp.Disk(radius=1.0), emission) for emission in emissions]
    return run(sources, detectors=tp.Detector(PLATE, "plate", moments=True))["plate"]


def test_energies_have_no_mass():
    with pytest.raises(tp.SceneError) as refused:
        _ = plate_of(tp.Lambertian(radiance=1.0)).mean_energy_in
    assert str(refused.value) == (
        "Detector 'plate': mean_energy_in needs particles of one mass, got energies in watts;"
        " emit a Gas or Effusive"
    )


def test_particles_of_two_masses_have_no_mean_energy():
    gases = [tp.Effusive(1e15, speed) for speed in (LIGHT, HEAVY)]
    with pytest.raises(tp.SceneError) as refused:
        _ = plate_of(*gases).pressure
    said = str(refused.value)
    assert said.startswith("Detector 'plate': pressure needs particles of one mass, got ")
    assert "6.6e-27 kg" in said
    assert "1.44e-25 kg" in said
    assert said.endswith("; simulate each species in a scene of its own")


def test_particles_of_no_mass_beside_others_are_said_to_have_none():
    gases = [tp.Effusive(1e15, LIGHT), tp.Effusive(1e15, 300.0)]
    with pytest.raises(tp.SceneError) as refused:
        _ = plate_of(*gases).mean_energy_out
    assert "got none, 6.6e-27 kg;" in str(refused.value) or "got 6.6e-27 kg, none;" in str(refused.value)


def test_particles_of_unknown_mass_are_told_how_to_get_one():
    with pytest.raises(tp.SceneError) as refused:
        _ = plate_of(tp.Effusive(1e15, 300.0)).pressure
    assert str(refused.value) == (
        "Detector 'plate': pressure needs particles of known mass, got none;"
        " write mass=... in kg in the source's emission"
    )


def test_particles_of_one_mass_have_their_mean_energy():
    """Whether they come from one source or from two: 2 kT each, within a fifth."""
    for gases in ([HEAVY], [HEAVY, HEAVY]):
        plate = plate_of(*(tp.Effusive(1e15, speed) for speed in gases))
        assert plate.mean_energy_out.value == pytest.approx(2 * 1.380649e-23 * 300, rel=0.2)


# ---- cases that settings make alike ----


def experiment_of(cases, **more):
    """A point or a disk that shines at a meter; a point has no radius."""
    module = ModuleType("shining")

    def scene(kind="point", radius=0.5, power=1.0):
        shape = tp.Point() if kind == "point" else tp.Disk(radius=radius)
        emission = tp.Isotropic(power=power) if kind == "point" else tp.Lambertian(power=power)
        return tp.Scene(tp.Source(shape, emission), detectors=tp.Detector(PLATE, "plate"))

    module.scene, module.cases, module.particles = scene, lambda: cases, 1000
    module.measure = lambda result: {"flux": result["plate"].flux_in}
    vars(module).update(more)
    return module


def test_cases_of_equal_scenes_are_run_once():
    points = [{"kind": "point", "radius": radius} for radius in (0.1, 0.2, 0.3)]
    disks = [{"kind": "disk", "radius": radius} for radius in (0.1, 0.2)]
    cases = [points[0], disks[0], points[1], disks[1], points[2], disks[0]]
    outcomes = run_experiment(experiment_of(cases), seed=1)
    assert [outcome.parameters for outcome in outcomes] == [points[0], *disks]


def test_a_setting_that_tells_scenes_apart_keeps_all_cases():
    cases = [{"power": power, "radius": 0.1} for power in (1.0, 2.0)]
    assert len(run_experiment(experiment_of(cases), seed=1)) == 2
    assert len(run_experiment(experiment_of(cases), {"power": 3.0}, seed=1)) == 1
    kept = run_experiment(experiment_of(cases), {"kind": "disk"}, seed=1)
    assert [outcome.parameters["power"] for outcome in kept] == [1.0, 2.0]


# ---- whose warning it is ----


def told(*warnings):
    """Outcomes of cases a, b, c ... with these warnings each."""
    return [SimpleNamespace(title="abcdefgh"[k], warnings=list(each)) for k, each in enumerate(warnings)]


@pytest.mark.parametrize(
    ("warned", "cases", "whose"),
    [
        ("b", 5, "b"), ("ab", 5, "a; b"), ("ace", 5, "a; c; e"), ("abce", 5, "4 of 5 cases"),
        ("abcde", 5, "all cases"), ("abc", 3, "all cases"), ("abcd", 8, "4 of 8 cases"),
    ],
)  # fmt: skip
def test_a_warning_names_its_cases_or_counts_them(warned, cases, whose):
    outcomes = told(*(["beware"] if case in warned else [] for case in "abcdefgh"[:cases]))
    assert case_warnings(outcomes) == [f"{whose}: beware"]


def test_each_warning_has_cases_of_its_own():
    said = case_warnings(told(["one", "two"], ["two"], ["one"], ["two"], ["two"], ["two"]))
    assert said == ["a; c: one", "5 of 6 cases: two"]


def test_a_single_case_need_not_be_named():
    assert case_warnings(told(["beware"])) == ["beware"]
    assert case_warnings(told([], [])) == []


def test_a_run_tells_whose_warnings_they_are():
    """Four of five cases meter a wall from the side that is dark."""

    def scene(side="outside", radius=1.0):
        wall = tp.Surface(tp.Sphere(radius=radius), tp.Black(), "wall")
        return tp.Scene(LAMP, wall, tp.Detector("wall", "meter", side))

    dark = [{"radius": radius} for radius in (1.0, 2.0, 3.0, 4.0)]
    cases = [{"side": "inside"}, *dark]
    outcomes = run_experiment(
        experiment_of(cases, scene=scene, measure=lambda result: {"flux": result["meter"].flux_in}), seed=1
    )
    [warning] = case_warnings(outcomes)
    assert warning.startswith("4 of 5 cases: detector 'meter' counted nothing: Surface 'wall' encloses every")


# ---- the table of effects ----


def printed(names, costs):
    """The cells of the table, a list a row."""
    text = io.StringIO()
    Console(file=text, width=100, color_system=None).print(pass_table(names, costs))
    lines = [line.split("  ") for line in text.getvalue().splitlines() if "─" not in line]
    return [[cell.strip() for cell in line if cell.strip()] for line in lines if "".join(line).strip()][1:]


def test_runs_of_one_pass_are_one_row():
    names = ["fly", *["meet_disk"] * 30, "move", "meet_disk", "move", "move"]
    rows = printed(names, {})
    assert [row[:2] for row in rows] == [
        ["1", "fly"],
        ["2", "meet_disk × 30"],
        ["32", "move"],
        ["33", "meet_disk"],
        ["34", "move × 2"],
    ]


def test_the_cost_of_a_run_is_that_of_one_pass():
    rows = printed(
        ["fly", "fly", "move", "land"], {"fly": PassCost(0.254, 1.0), "move": PassCost(math.nan, 0.0)}
    )
    assert rows == [["1", "fly × 2", "0.25"], ["3", "move", "not reached"], ["4", "land", "?"]]


@pytest.mark.parametrize("count", [2, 30])
def test_many_walls_are_one_row_of_a_scenes_effects(count):
    walls = [
        tp.Surface(tp.Rectangle(center=(0, 0, 1 + k), width=1.0, height=1.0), tp.Black())
        for k in range(count)
    ]
    rows = printed(effects_of(tp.Scene(LAMP, walls)).steps, {})
    assert f"meet_rectangle × {count}" in [name for _, name, _ in rows]
