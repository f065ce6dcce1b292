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


# ---- quantities that need a mass ----

PLATE = tp.Disk(center=(0, 0, 1), radius=1.0)


def plate_of(*emissions):
    sources = [tp.Source(tp.Disk(radius=1.0), emission) for emission in emissions]
    return run(sources, detectors=tp.Detector(PLATE, "plate", moments=True))["plate"]


@pytest.mark.parametrize(
    ("quantity", "emissions", "reason"),
    [
        pytest.param(
            "mean_energy_in", [tp.Lambertian(radiance=1.0)],
            "particles of one mass, got energies in watts; emit a Gas or Effusive$", id="energies",
        ),
        pytest.param(
            "pressure", [tp.Effusive(1e15, LIGHT), tp.Effusive(1e15, HEAVY)],
            "particles of one mass, got (?=.*6.6e-27 kg)(?=.*1.44e-25 kg).*; simulate each species in a scene of its own$",
            id="two masses",
        ),
        pytest.param(
            "mean_energy_out", [tp.Effusive(1e15, LIGHT), tp.Effusive(1e15, 300.0)],
            "got (none, 6.6e-27 kg|6.6e-27 kg, none);", id="one without a mass",
        ),
        pytest.param(
            "pressure", [tp.Effusive(1e15, 300.0)],
            "particles of known mass, got none; write mass=... in kg in the source's emission$", id="no mass",
        ),
    ],
)  # fmt: skip
def test_a_quantity_that_needs_one_mass_is_refused_with_the_masses_that_there_are(
    quantity, emissions, reason
):
    with pytest.raises(tp.SceneError, match=rf"^Detector 'plate': {quantity} needs .*{reason}"):
        getattr(plate_of(*emissions), quantity)


@pytest.mark.parametrize("sources", [1, 2])
def test_particles_of_one_mass_have_their_mean_energy(sources):
    """2 kT each, within a fifth."""
    plate = plate_of(*[tp.Effusive(1e15, HEAVY)] * sources)
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


@pytest.mark.parametrize(
    ("warned", "count", "lines"),
    [
        ({"beware": "b"}, 5, ["b: beware"]),
        ({"beware": "ab"}, 5, ["a; b: beware"]),
        ({"beware": "ace"}, 5, ["a; c; e: beware"]),
        ({"beware": "abce"}, 5, ["4 of 5 cases: beware"]),
        ({"beware": "abcde"}, 5, ["all cases: beware"]),
        ({"beware": "abc"}, 3, ["all cases: beware"]),
        ({"beware": "abcd"}, 8, ["4 of 8 cases: beware"]),
        ({"one": "ac", "two": "abdef"}, 6, ["a; c: one", "5 of 6 cases: two"]),
        ({"beware": "a"}, 1, ["beware"]),
        ({}, 2, []),
    ],
    ids=str,
)
def test_a_warning_names_its_cases_or_counts_them(warned, count, lines):
    outcomes = [
        SimpleNamespace(title=case, warnings=[text for text, cases in warned.items() if case in cases])
        for case in "abcdefgh"[:count]
    ]
    assert case_warnings(outcomes) == lines


def test_a_run_names_the_cases_of_its_warnings():
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


# ---- what an experiment reads, and what it intends ----


@pytest.mark.parametrize(
    ("read", "is_warned"),
    [
        (("flux_out",), False),
        (("exitance", "flux_out"), False),
        (("flux_in",), True),  # a reversed normal
        (("irradiance", "flux_out"), True),
        (("net_flux_density",), True),  # of both sides
        ((), True),  # nothing read of it: it may be for a picture
    ],
    ids=str,
)
def test_a_detector_of_which_only_departures_are_read_may_face_away(read, is_warned):
    def scene():
        away = tp.Disk(center=(0, 0, 1), radius=0.5)
        lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
        return tp.Scene(
            lamp, detectors=[tp.Detector(away, "plate"), tp.Detector(tp.Sphere(radius=5.0), "all", "inside")]
        )

    def measure(result):
        rows = {name: getattr(result["plate"], name) for name in read}
        return rows | {"all": result["all"].flux_in}

    [outcome] = run_experiment(experiment_of([{}], scene=scene, measure=measure), particles=20_000, seed=1)
    assert any("no light can arrive at detector 'plate'" in each for each in outcome.warnings) == is_warned
    assert any(
        "no light can arrive" in each for each in outcome.result.warnings
    )  # the run has it all the same


def aimed(**more):
    """A lamp that is aimed at the plate only, and a detector around both."""

    def scene():
        lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0), aim=PLATE)
        return tp.Scene(
            lamp, detectors=[tp.Detector(PLATE, "plate"), tp.Detector(tp.Sphere(radius=5.0), "all", "inside")]
        )

    both = {"measure": lambda result: {"on": result["plate"].flux_out, "all": result["all"].flux_in}}
    return experiment_of([{}], scene=scene, **both, **more)


def test_what_an_experiment_intends_is_a_note_with_its_reason():
    [plain] = run_experiment(aimed(), particles=20_000, seed=1)
    assert plain.warnings == ["detector 'all' sees an aimed source only in the directions of its aim"]
    assert plain.intentions == []
    [meant] = run_experiment(
        aimed(intended={"aim": "the plate alone is lit", "grazing": "unused"}), particles=20_000, seed=1
    )
    assert meant.warnings == []
    assert meant.intentions == ["the plate alone is lit (aim, as intended)"]
    assert set(plain.warnings) < set(meant.result.warnings)  # the run itself has them


def test_an_intended_diagnostic_that_there_is_not_is_refused():
    with pytest.raises(tp.SceneError, match=r"shining: intended has no diagnostic 'aims'.*'aim'"):
        run_experiment(aimed(intended={"aims": "misspelt"}), particles=1000)


# ---- the table of effects ----


def printed(names, costs):
    """The cells of the table, a list a row."""
    text = io.StringIO()
    Console(file=text, width=100, color_system=None).print(pass_table(names, costs))
    lines = [line.split("  ") for line in text.getvalue().splitlines() if "─" not in line]
    return [[cell.strip() for cell in line if cell.strip()] for line in lines if "".join(line).strip()][1:]


@pytest.mark.parametrize(
    ("names", "rows"),
    [
        (
            ["fly", *["meet_disk"] * 30, "move", "meet_disk", "move", "move"],
            ["1 fly ?", "2 meet_disk × 30 ?", "32 move ?", "33 meet_disk ?", "34 move × 2 ?"],
        ),
        (["fly", "fly", "stay", "land"], ["1 fly × 2 0.25", "3 stay not reached", "4 land ?"]),
    ],
    ids=["numbers", "costs"],
)
def test_runs_of_one_pass_are_one_row_with_the_cost_of_one(names, rows):
    costs = {"fly": PassCost(0.254, 1.0), "stay": PassCost(math.nan, 0.0)} if "stay" in names else {}
    assert [" ".join(row) for row in printed(names, costs)] == rows


@pytest.mark.parametrize("count", [2, 30])
def test_many_walls_are_one_row_of_a_scenes_effects(count):
    walls = [
        tp.Surface(tp.Rectangle(center=(0, 0, 1 + k), width=1.0, height=1.0), tp.Black())
        for k in range(count)
    ]
    rows = printed(effects_of(tp.Scene(LAMP, walls)).steps, {})
    assert f"meet_rectangle_z × {count}" in [name for _, name, _ in rows]
