"""Births towards a target: the flux that reaches it is that of unaimed births, and of closed forms; weights stay
within 1, and the ledger closes to the last integer.

Every judgement has a rate of false alarms of 1e-6, all together below 2e-4.  Of the comparisons with unaimed births
each would catch a bias of 6 % (half of them 2.3 %), of those with closed forms 3 % (half of them 0.3 %).
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.slow import quick
from transport.compile.compiler import compile_scene
from transport.compile.layout import ABSORBED, BORN, LOST
from transport.engine.bundle import LANES, empty_bundle
from transport.engine.driver import compile_program, run_batch
from transport.engine.program import build_program
from transport.results.detectors import BINS
from transport.statistics.estimates import Estimate
from transport.statistics.replicates import Batches
from transport.theory.emitters import point_flux_through_disk, sphere_solid_angle
from transport.theory.view_factors import coaxial_disks, opposed_rectangles, perpendicular_rectangles

Box, Disk, Point, Rectangle, Sphere = tp.Box, tp.Disk, tp.Point, tp.Rectangle, tp.Sphere
FALSE_ALARM = 1e-6
BATCHES = 24
AIMED, NEAR, FAR = 12_000, 40_000, 200_000  # histories of a batch
ONE = 1 << 63  # the weight 1 in units of the sums
ROUNDING = 1 << 13  # in the same units: four times the spacing of floats above 1
POWER = 2.0
LIGHT, GLOW = tp.Lambertian(power=POWER), tp.Isotropic(power=POWER)

SOURCES = {
    "disk": (Disk(radius=0.5), LIGHT),
    "rectangle": (Rectangle(width=1.0, height=0.6, normal=(0.2, -0.1, 1), up=(1, 1, 0)), LIGHT),
    "disk, back": (Disk(radius=0.5, normal=(0, 0, -1)), LIGHT, "back"),
    "sphere": (Sphere(radius=0.5), LIGHT),
    "box": (Box(size=(0.9, 0.6, 0.8)), LIGHT),
    "point": (Point(position=(0.1, 0.05, 0)), GLOW),
    "ball": (Sphere(radius=0.5), GLOW),
    "filled box": (Box(size=(0.9, 0.6, 0.8)), GLOW),
}
AIMS = {
    "disk near": Disk(center=(0.2, 0, 0.6), normal=(0.3, 0, -1), radius=0.7),
    "annulus near": Disk(center=(0, 0, 0.55), normal=(0, 0.1, 1), radius=0.8, inner_radius=0.3),
    "rectangle at the edge": Rectangle(center=(0.5, 0, 0.5), normal=(1, 0, 0), width=1.0, height=0.8),
    "sphere touching": Sphere(center=(0, 0, 1.0), radius=0.5),
    "box touching": Box(center=(0, 0, 0.9), size=1.0),
    "disk far": Disk(center=(3, 4, 16), normal=(-0.2, -0.1, 1), radius=4),
    "annulus far": Disk(center=(0, -6, 16), radius=5, inner_radius=3),
    "rectangle far": Rectangle(center=(-4, 2, 16), normal=(1, 0.5, -2), width=6, height=8),
    "sphere far": Sphere(center=(3, 4, 16), radius=4),
    "box far": Box(center=(-4, 2, 16), size=(6, 5, 8)),
}
ROUND = {"sphere": Sphere(radius=2), "box": Box(size=(2, 3, 4), center=(0.1, 0, 0))}


def emitter(name, aim=None):
    shape, emission, *side = SOURCES[name]
    return tp.Source(shape, emission, aim, *side)


def ready(sources, aim=None, surfaces=()):
    """A machine, with a meter on the target."""
    meters = [] if aim is None else [tp.Detector(aim, name="meter")]
    return compile_program(build_program(compile_scene(tp.Scene(sources, surfaces, meters))))


def total(rows) -> int:
    """The sum of rows of (high, low, ...) in units of 2^-63: exact."""
    return (sum(rows[:, 0].tolist()) << 31) + sum(rows[:, 1].tolist())


def run(machine, seed=1, histories=AIMED):
    """Raw sums of the batches; each one's ledger is checked."""
    sums = [run_batch(machine, seed, batch, histories) for batch in range(BATCHES)]
    targets = [e.target is not None for e in machine.program.plan.emitters]
    for one in sums:
        assert_ledger_closes(one, aimed=histories if all(targets) else None if any(targets) else 0)
    return sums


def assert_ledger_closes(raw, aimed):
    """What was born is what ended, in integers; without an aim that is the number of histories."""
    born, ended = raw.ledger[[BORN]], total(raw.ledger[BORN + 1 :])
    assert aimed is None or born[0, 2] == aimed
    assert ended == (raw.histories - int(born[0, 2])) * ONE + total(born)
    assert 0 <= ended <= raw.histories * (ONE + ROUNDING)
    assert not raw.ledger[LOST].any()


def met(machine, sums, way="both"):
    """Power [W] that crosses the meter towards its front ("in"), away from it ("out") or both ways."""
    plan = machine.program.plan
    row = plan.rows_of["meter"].base + 1
    rows = {"in": [row], "out": [row + plan.half], "both": [row, row + plan.half]}[way]
    values = [total(one.detectors[rows]) / ONE / one.histories * plan.unit for one in sums]
    return Estimate(np.array(values), Batches(np.full(len(sums), sums[0].histories)), "W")


def power_met(source, aim, seed=1, histories=AIMED, way="both"):
    machine = ready(source, aim)
    return met(machine, run(machine, seed, histories), way)


def once(shape):
    """How a ray from outside crosses a convex shape just once."""
    return "in" if shape.is_closed else "both"


def is_certain(estimate):
    """Whether all batches agree: then there is no error to judge by, nor needed."""
    return np.ptp(estimate.values) <= 1e-12 * estimate.value


def assert_is(estimate, exact, relative=1e-9):
    """Agreement within the errors, or to rounding where all histories are alike."""
    if is_certain(estimate):
        assert estimate.value == pytest.approx(exact, rel=relative, abs=0)
    else:
        assert_agrees(estimate, exact, FALSE_ALARM)


def assert_same(aimed, blind):
    """Agreement of two runs within the errors of both."""
    if is_certain(aimed):
        assert_agrees(blind, aimed.value, FALSE_ALARM)
    else:
        assert_agrees(aimed - blind, 0.0, FALSE_ALARM)


def assert_weights_are_within_one(source):
    # A grey surface has birth weights remembered for roulette.
    grey = tp.Surface(Disk(center=(0, 0, -30), radius=0.1), tp.Diffuse(0.5))
    machine, bundle, weights = ready(source, surfaces=[grey]), empty_bundle(), []
    for batch in range(8):
        run_batch(machine, 3, batch, LANES, bundle)
        weights.extend(bundle["birth"][0])
    assert min(weights) >= 0
    assert 0 < max(weights) <= 1 + ROUNDING / ONE


def unaimed(source, aim):
    histories = FAR if "far" in aim else NEAR
    return power_met(emitter(source), AIMS[aim], seed=2, histories=histories, way=once(AIMS[aim]))


PAIRS = {
    (source, aim): ()
    for source, aim in itertools.product(SOURCES, AIMS)
    if source == "disk" or aim == "disk near"
}
PAIRS = dict.fromkeys(list(itertools.product(SOURCES, AIMS))[::3], pytest.mark.slow) | PAIRS


@pytest.mark.parametrize(("source", "aim"), [pytest.param(*pair, marks=mark) for pair, mark in PAIRS.items()])
def test_as_much_reaches_the_target_as_without_aim(source, aim):
    shape = AIMS[aim]
    aimed = power_met(emitter(source, shape), shape, way=once(shape))
    assert_same(aimed, unaimed(source, aim))
    assert_weights_are_within_one(emitter(source, shape))


@pytest.mark.parametrize("aim", ROUND)
@pytest.mark.parametrize("source", quick(SOURCES, "disk", "point", "ball"))
def test_all_power_reaches_a_target_all_round(source, aim):
    shape = ROUND[aim]
    assert_is(power_met(emitter(source, shape), shape, way="out"), POWER)
    assert_weights_are_within_one(emitter(source, shape))


@pytest.mark.parametrize("source", ["disk", "rectangle"])
def test_nothing_reaches_a_target_behind_the_source(source):
    shape = SOURCES[source][0]
    aim = Disk(center=tuple(-3 * x for x in shape.normal), normal=shape.normal, radius=0.5)
    assert power_met(emitter(source, aim), aim, way="in").value == 0


def coaxial(radius, distance, inner_radius=0.0):
    return Disk(center=(0, 0, distance), normal=(0, 0, -1), radius=radius, inner_radius=inner_radius)


def ball(radius, distance):
    return Sphere(center=(0, 0, distance), radius=radius)


def opposite(distance):
    return Rectangle(center=(0, 0, distance), normal=(0, 0, -1), width=1.1, height=0.5)


def box_above(gap):
    return Box(center=(0, 0, gap + 0.5), size=(1.2, 0.9, 1.0))


def disk_to_annulus(radius, outer, inner, distance):
    return coaxial_disks(radius, outer, distance) - coaxial_disks(radius, inner, distance)


def disk_to_ball(radius, ball_radius, distance):
    """By reciprocity, from Howell's C-136."""
    return 4 * (ball_radius / radius) ** 2 * point_flux_through_disk(1.0, radius, distance)


UNIT_DISK, NARROW = Disk(radius=1.0), Rectangle(width=0.8, height=0.6)
FLOOR = Rectangle(center=(0.4, 0, 0), width=0.8, height=0.6)
WALL = Rectangle(center=(0, 0, 0.5), normal=(1, 0, 0), width=1.0, height=0.6)
UNIT_BALL, SIDES = Sphere(radius=1.0), (0.8, 0.6)
CLOSED_FORMS = {  # source, targets, shares of the power that reach them
    "point to disk": [(Point(), coaxial(0.7, d), point_flux_through_disk(1.0, 0.7, d)) for d in (1e-3, 0.5, 40.0, 1e6, 1e12)],
    "point to sphere": [(Point(), ball(1.0, d), sphere_solid_angle(1.0, d) / (4 * math.pi)) for d in (1.001, 3.0, 1e6, 1e12)],
    "disk to disk": [(UNIT_DISK, coaxial(0.6, d), coaxial_disks(1.0, 0.6, d)) for d in (1e-2, 1.0, 50.0, 1e6)],
    "disk to tiny disk": [(UNIT_DISK, coaxial(r, d), coaxial_disks(1.0, r, d)) for r, d in ((1e-6, 1e6), (1e-9, 1e3), (1e-6, 0.5))],
    "disk to annulus": [(UNIT_DISK, coaxial(0.9, d, 0.5), disk_to_annulus(1.0, 0.9, 0.5, d)) for d in (1e-2, 1.0, 50.0)],
    "disk to sphere": [(UNIT_DISK, ball(0.5, d), disk_to_ball(1.0, 0.5, d)) for d in (0.5, 2.0, 1e3)],
    "rectangle to opposite one": [(NARROW, opposite(d), opposed_rectangles(SIDES, (1.1, 0.5), d)) for d in (0.05, 1.0, 40.0)],
    "rectangle to one at its edge": [(FLOOR, WALL, perpendicular_rectangles(0.8, 1.0, 0.6))],
    "rectangle to box above it": [(NARROW, box_above(d), opposed_rectangles(SIDES, (1.2, 0.9), d)) for d in (0.05, 1.0, 40.0)],
    "sphere to disk": [(UNIT_BALL, coaxial(2.0, d), point_flux_through_disk(1.0, 2.0, d)) for d in (1.0, 3.0, 1e3)],
    "inside of a sphere to sphere within": [(UNIT_BALL, ball(r, 0.0), r * r) for r in (0.999, 0.5, 1e-3)],
}  # fmt: skip


@pytest.mark.parametrize("law", CLOSED_FORMS)
def test_the_power_that_reaches_the_target_is_the_closed_form(law):
    """From touching to 1e12 sizes away."""
    for shape, aim, share in CLOSED_FORMS[law]:
        emission, side = GLOW if isinstance(shape, Point) else LIGHT, "back" if "inside" in law else "front"
        aimed = power_met(tp.Source(shape, emission, aim, side), aim, way="in")
        assert_is(aimed, share * POWER, relative=1e-8)


@pytest.mark.parametrize("radius", [1e-6, 1e-9, 1e-12])
def test_a_tiny_target_next_to_a_large_source_keeps_its_digits(radius):
    """Weights far below the largest one lose digits in the sums; so the largest must not be overestimated."""
    within = ball(radius, 0.0)
    inside = power_met(tp.Source(UNIT_BALL, LIGHT, within, "back"), within, way="in")
    assert_is(inside, radius**2 * POWER, relative=1e-6)
    close = power_met(tp.Source(UNIT_DISK, LIGHT, coaxial(radius, 0.5)), coaxial(radius, 0.5), way="in")
    assert_is(close, coaxial_disks(1.0, radius, 0.5) * POWER)


def test_an_aimed_particle_meets_what_stands_in_its_way():
    """A black disk half way casts a shadow of twice its radius; outside of it all arrives."""
    aim, shade = coaxial(2.0, 3.0), tp.Surface(coaxial(0.4, 1.5), tp.Black(), "shade")
    lit = point_flux_through_disk(POWER, 2.0, 3.0) - point_flux_through_disk(POWER, 0.8, 3.0)
    for source in (tp.Source(Point(), GLOW, aim), tp.Source(Point(), GLOW)):
        machine = ready(source, aim, [shade])
        assert_is(met(machine, run(machine), "in"), lit)


@pytest.mark.parametrize("shape", [Sphere(radius=1.0), Box(size=1.0)], ids=["sphere", "box"])
@pytest.mark.parametrize("distance", [3.0, 1e3, 1e6, 1e9])
def test_nothing_that_leaves_a_convex_body_meets_it_again(shape, distance):
    """A black body that shines takes nothing of its own light, however far away the target is."""
    aim = coaxial(1.0, distance)
    machine = ready(tp.Source("body", LIGHT, aim), aim, [tp.Surface(shape, tp.Black(), "body")])
    assert not any(one.ledger[ABSORBED + 1].any() for one in run(machine))


def test_sources_with_and_without_aim_add_up():
    """Histories are dealt by largest weights, each emitter keeps its own power, and one ledger closes for all."""
    aim = AIMS["sphere far"]
    room = [tp.Surface(Sphere(radius=50), tp.Diffuse(0.5), "room")]
    sources = [emitter("disk", aim), emitter("ball"), tp.Source(Point(), tp.Isotropic(power=0.5), aim)]
    machines = [ready(source, aim, room) for source in sources]
    alone = [met(machine, run(machine, seed=5 + k)) for k, machine in enumerate(machines)]
    machine = ready(sources, aim, room)
    sums = run(machine, seed=4, histories=3 * AIMED)
    assert all(0 < one.ledger[BORN, 2] < one.histories for one in sums)
    assert_same(met(machine, sums), alone[0] + alone[1] + alone[2])


@pytest.mark.quick_cases("disk near")
@pytest.mark.parametrize("aim", ["disk near", "annulus far", "sphere far", "box far", "box touching"])
def test_a_wrong_weight_is_caught(aim):
    """Planted: a target taken for 15 % too small, and Lambert's cosine left out."""
    shape = AIMS[aim]
    blind = unaimed("disk", aim)
    for wrong in ({"area": 0.85, "half_u": 0.92}, {"lambertian": 0.0}):
        scene = tp.Scene([emitter("disk", shape)], detectors=[tp.Detector(shape, name="meter")])
        plan = compile_scene.__wrapped__(scene)
        target = plan.emitters[0].target[0][1]  # one row for all its passes
        for name, factor in wrong.items():
            target[name] *= factor
        if "lambertian" in wrong:
            target["isotropic"] = 0.5 / math.pi
        machine = compile_program(build_program(plan))
        with pytest.raises(AssertionError, match="z = "):
            assert_same(met(machine, run(machine), once(shape)), blind)


PLANES = {"up": (0, 0, 1), "east": (1, 0, 0), "north": (0, 1, 0), "sloped": (1, -2, 3)}


@pytest.mark.parametrize("shape", [Disk, Rectangle])
@pytest.mark.parametrize("name", PLANES)
def test_an_aim_changes_where_particles_fly_but_not_where_they_are_born(shape, name):
    """Detectors on the source and on a patch of its plane count the same births with and without aim."""
    normal = np.array(PLANES[name]) / np.linalg.norm(PLANES[name])
    size = {"radius": 0.5} if shape is Disk else {"width": 1.0, "height": 0.6}
    place, aim = (0.3, -0.2, 0.7), Sphere(center=tuple(50 * normal), radius=0.1)
    lamp = shape(center=place, normal=tuple(normal), **size)
    e_u = shape(normal=tuple(normal), **size).frame[0]
    patch = Disk(center=tuple(place + 0.2 * np.array(e_u)), normal=tuple(normal), radius=0.15)
    looks = [tp.Detector(lamp, "lamp", positions=tp.Positions(u=3, v=4)), tp.Detector(patch, "patch")]
    aimed, free = (
        tp.simulate(tp.Scene(tp.Source(lamp, LIGHT, target), detectors=looks), 3000, seed=1, progress=False)
        for target in (aim, None)
    )
    for look in looks:
        for by in ((), BINS):  # with those outside all bins, and in each bin
            born, exact = (run[look.name].counts_of("weight out", by).sum(axis=0) for run in (aimed, free))
            np.testing.assert_array_equal(born, exact)
        assert born.sum() > 100
    assert aimed["patch"].flux_out.value < 1e-3 * free["patch"].flux_out.value
