"""Runs that would never end are refused when the scene is made, or stopped soon, with what to do about it."""

from __future__ import annotations

import math
import time

import pytest

import transport as tp
from transport.compile.compiler import compile_scene
from transport.compile.limits_exceeded import OverrunError, full_bank_error, too_many_crossings_error
from transport.engine import driver
from transport.engine.passes.surfaces import MAX_EVENTS
from transport.scene.checks.trapping import LIFETIMES
from transport.scene.checks.trapping import MAX_EVENTS as GIVEN_UP

CLEAR, WATER = tp.Transparent(), tp.Medium(index=1.33)
WHITE, MIRROR, GREY, BLACK = tp.Diffuse(1.0), tp.Mirror(), tp.Diffuse(0.999), tp.Black()
LAMP = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
INNER = tp.Source(tp.Point(position=(0.1, 0, 0)), tp.Isotropic(power=1.0))
DOWN = tp.Source(tp.Point(position=(0, 0, 3)), tp.Beam((0, 0, -1), power=1.0))
PULSE = tp.Source(tp.Point(position=(0.1, 0, 0)), tp.Isotropic(energy=1.0), pulse=tp.Instant())
BALL = tp.Sphere(radius=0.5)
UP, DOWNWARDS = (0, 0, 1), (0, 0, -1)


def refused(words, call, *arguments, error=tp.SceneError, **named):
    with pytest.raises(error) as caught:
        call(*arguments, **named)
    message = str(caught.value)
    assert [word for word in words if word not in message] == [], message
    return caught.value


def simulate(scene, particles, **how):
    return tp.simulate(scene, particles, **{"threads": 1, "progress": False} | how)


# ---- splitting and crossings ----

FOGGY = tp.Scene(
    DOWN, tp.Surface(tp.Sphere(radius=1.0), CLEAR, inside=tp.Medium(absorption=0.3, scattering=2.7))
)


def split(gain, absorption="weighted"):
    return tp.Tracking(absorption=absorption, splitting=tp.Splitting(start=UP, end=DOWNWARDS, gain=gain))


@pytest.mark.slow
@pytest.mark.parametrize("absorption", ["weighted", "analog"])
def test_a_gain_far_too_high_stops_soon_and_is_named(absorption):
    """Each history would make 1e30 copies; 2e4 of each, in the mean, are a sign."""
    simulate(FOGGY, 100, tracking=absorption)
    begun = time.process_time()
    words = "Splitting: gain", "got 1e+30", "copies of 256 histories", "of each", "about 1 / transmission"
    error = refused(words, simulate, FOGGY, 20_000, tracking=split(1e30, absorption), error=OverrunError)
    assert isinstance(error, tp.SceneError) and isinstance(error, OverflowError)
    assert time.process_time() - begun < 30  # some seconds with compilation


def test_gains_that_are_merely_high_run():
    """tau 3, split by 1e4: some hundred copies of each history."""
    assert simulate(FOGGY, 500, tracking=split(1e4)).cost.collisions > 100 * 500


@pytest.mark.parametrize(
    ("tracking", "words"),
    [(split(7), ("gain", "got 7", "lower it")), (tp.Tracking(forced=True), ("forced", "leave it out"))],
)
def test_a_full_bank_names_what_filled_it(tracking, words):
    scene = tp.Scene(LAMP, medium=tp.Medium(absorption=1.0, scattering=1.0))
    message = str(full_bank_error(compile_scene(scene, tracking), 65536))
    assert all(word in message for word in (*words, "65536"))


GLASS, ROOM = tp.Surface(BALL, tp.Dielectric(1.5), "ball"), tp.Surface(tp.Box(size=4.0), GREY, "room")


@pytest.mark.parametrize(
    ("scene", "started", "word"),
    [
        (tp.Scene(DOWN, GLASS), 300, "nothing in the scene absorbs"),
        (tp.Scene(LAMP, [ROOM, GLASS]), 300, "absorb more"),
        (tp.Scene(DOWN, GLASS), 1_000_000, "pass more batches"),
    ],
)
def test_a_batch_of_too_many_crossings_names_the_cause(scene, started, word):
    error = too_many_crossings_error(compile_scene(scene, None), 2**30, started)
    assert word in str(error) and f"{2**30 / started:.2g} for each" in str(error)
    assert isinstance(error, tp.SceneError) and isinstance(error, OverflowError)


# ---- light that can neither be absorbed nor escape ----

LID = tp.Disk(center=(0, 0, -1), radius=0.2)


def planes(*normals, material=WHITE):
    """Planes that face away from the origin, each a unit away from it or more."""
    return [tp.Surface(tp.Plane(center=n, normal=n), material) for n in normals]


def walls(*shapes, material=WHITE):
    return [tp.Surface(shape, material) for shape in shapes]


def ball(height, material):
    return tp.Surface(tp.Sphere(center=(5, 0, height), radius=0.5), material)


def lamp(shape, side="front"):
    return tp.Source(shape, tp.Lambertian(power=1.0), side=side)


def beam(direction):
    return tp.Source(tp.Point(), tp.Beam(direction, power=1.0))


FACES = list(tp.Box(center=(0.1, 0.2, 0.3), size=(0.7, 1.3, 1.9)).faces().values())
CYLINDER = tp.Cylinder(radius=1.0, height=2.0)
LIDS = [tp.Disk(center=(0, 0, z), radius=1.0) for z in (-1, 1)]
ENDLESS = {
    "two mirrors": (INNER, planes(UP, DOWNWARDS, material=MIRROR)),
    "a beam between mirrors": (beam((1, 0, 0.1)), planes(UP, DOWNWARDS, material=MIRROR)),
    "two mirrors that face one another": (
        INNER, [tp.Surface(tp.Plane(center=(0, 0, z), normal=(0, 0, -z)), MIRROR) for z in (1, -1)]),
    "three planes round an axis": (INNER, planes((1, 0, 0), (-1, 1, 0), (-1, -1, 0))),
    "four planes": (INNER, planes((1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1))),
    "a white ball between planes": (INNER, [*planes(UP, DOWNWARDS), ball(0, WHITE)]),
    "a black ball beyond planes": (INNER, [*planes(UP, DOWNWARDS), ball(3, tp.Black())]),
    "planes that are black outside": (
        INNER, planes(UP, DOWNWARDS, material=tp.TwoSided(front=tp.Black(), back=WHITE))),
    "a lamp on a plane": (lamp(LID), planes(UP, DOWNWARDS)),
    "a ball of a lamp between planes": (lamp(tp.Sphere(radius=0.3)), planes(UP, DOWNWARDS)),
    "a lamp on the ceiling of a box": (
        lamp(tp.Disk(center=UP, normal=DOWNWARDS, radius=0.2)), walls(tp.Box(size=2.0))),
    "the faces of a box": (INNER, walls(*FACES, material=MIRROR)),
    "a cylinder with its lids": (INNER, walls(CYLINDER, *LIDS)),
    "two halves of a sphere": (INNER, walls(tp.Sphere(radius=1.0, mu_max=0), tp.Sphere(radius=1.0, mu_min=0))),
    "the faces of a box that are black outside": (
        INNER, walls(*FACES, material=tp.TwoSided(front=tp.Black(), back=WHITE))),
    "fog that glows in white walls": ((), [tp.Surface(tp.Box(size=2.0), WHITE, inside=tp.Medium(emission=1.0))]),
    "a dome on its floor": (
        INNER, walls(tp.Sphere(radius=1.0, mu_min=-0.6), tp.Disk(center=(0, 0, -0.6), radius=0.8))),
}  # fmt: skip
ENDING = {
    "a beam along the planes": (beam((1, 0, 0)), planes(UP, DOWNWARDS, material=MIRROR)),
    "a beam by a mirror along the planes": (beam((0, 0, 1)), [
        *planes(UP, DOWNWARDS, material=MIRROR), tp.Surface(tp.Disk(center=(0, 0, 0.5), normal=(1, 0, 1), radius=0.1), MIRROR)]),
    "a beam along the axis of a prism": (beam((0, 0, 1)), planes((1, 0, 0), (-1, 1, 0), (-1, -1, 0))),
    "a beam along the faces of a slab": (beam((1, 0, 0)), walls(tp.Slab(thickness=2.0), material=MIRROR)),
    "two tubes and a collar at one rim": (INNER, walls(
        tp.Cylinder(center=(0, 0, 2.5), radius=1.0, height=5.0), tp.Cylinder(center=(0, 0, -2.5), radius=1.0, height=5.0),
        tp.Cone(center=(0, 0, 0.25), radius=1.0, top_radius=1.5, height=0.5))),
    "a bead close above a wide lamp": (
        lamp(tp.Disk(radius=1.0)), walls(tp.Sphere(center=(0, 0, 1.2e-6), radius=1e-6))),
    "a plane close above a wide lamp": (
        lamp(tp.Disk(radius=1.0)), [tp.Surface(tp.Plane(center=(0, 0, 1e-7)), tp.Black()), *planes(UP)]),
    "the upper half of a ball as a lamp": (lamp(tp.Sphere(radius=1.0, mu_min=0)), walls(tp.Sphere(radius=1.0))),
    "a ball turned about as a lamp": (
        lamp(tp.Sphere(radius=1.0, axis=(1, 0, 0))), walls(tp.Sphere(radius=1.0))),
    "a wedge": (INNER, planes(UP, (0, 0.1, -1))),
    "three planes of a corner": (INNER, planes((1, 0, 0), (0, 1, 0), (0, 0, 1))),
    "a lamp beyond both planes": (DOWN, planes(UP, DOWNWARDS)),
    "a lamp on a plane that faces out": (lamp(LID, "back"), planes(UP, DOWNWARDS)),
    "a black ball between planes": (INNER, [*planes(UP, DOWNWARDS), ball(0, tp.Black())]),
    "planes that are black inside": (
        INNER, planes(UP, DOWNWARDS, material=tp.TwoSided(front=WHITE, back=tp.Black()))),
    "planes that absorb a little": (INNER, planes(UP, DOWNWARDS, material=GREY)),
    "fog between planes": (INNER, [
        tp.Surface(tp.Plane(center=UP), WHITE, back=tp.Medium(absorption=0.1)),
        tp.Surface(tp.Plane(center=DOWNWARDS), WHITE, front=tp.Medium(absorption=0.1), back=tp.Vacuum()),
    ]),
    "five faces of a box": (INNER, walls(*FACES[:5])),
    "a face that absorbs": (INNER, [*walls(*FACES[:5]), tp.Surface(FACES[5], GREY)]),
    "a lid that is too small": (INNER, walls(CYLINDER, LIDS[0], tp.Disk(center=UP, radius=0.999))),
    "a lamp outside of the faces": (DOWN, walls(*FACES)),
}  # fmt: skip


@pytest.mark.parametrize("name", ENDLESS)
def test_light_that_can_never_end_is_refused_as_the_scene_is_made(name):
    words = "nothing absorbs", "surfaces[0]", "nothing escapes", "albedo or reflectance below 1", "duration"
    begun = time.process_time()
    refused(words, tp.Scene, *ENDLESS[name])
    assert time.process_time() - begun < 1


@pytest.mark.parametrize("name", ENDING)
def test_light_that_ends_is_not_refused(name):
    tp.Scene(*ENDING[name])


def test_a_clock_ends_all():
    tp.Scene(PULSE, planes(UP, DOWNWARDS, material=MIRROR), duration=1e-8)


def slabs(material=MIRROR):
    """Two slabs, between which no check looks."""
    return [
        tp.Surface(tp.Slab(center=(0, 0, z), thickness=1.0), material, name)
        for z, name in ((2, "upper"), (-2, "lower"))
    ]


@pytest.mark.slow
def test_a_run_in_which_no_history_ends_stops_and_names_the_surfaces():
    begun = time.process_time()
    words = "not end", "millions of crossings", "none was absorbed or has escaped", "the scene a duration"
    scene = tp.Scene(INNER, slabs())
    message = str(refused(words, simulate, scene, 3, batches=2, error=OverrunError))
    assert "Surface 'upper'" in message or "Surface 'lower'" in message
    assert time.process_time() - begun < 60


def test_a_shut_in_run_of_collisions_stops_as_well(little_patience):
    """Milk between the slabs: next to no crossings."""
    scene = tp.Scene(INNER, slabs(), medium=tp.Medium(scattering=1e4))
    with pytest.raises(OverrunError, match=r"2 particles do not end: .* collisions none was absorbed"):
        simulate(scene, 4, batches=2)


@pytest.fixture
def little_patience(monkeypatch):
    """Two hundred crossings of each of 64 lanes, instead of a million of 256."""
    assert (driver.PATIENCE, driver.PATIENCE_IN_MEDIA) == (256 * 10**6, 1 << 30)
    for name in ("PATIENCE", "PATIENCE_IN_MEDIA"):
        monkeypatch.setattr(driver, name, 64 * 200)


def test_patience_is_measured_in_crossings(little_patience):
    begun = time.process_time()
    words = (
        "64 particles do not end",
        "'upper'",
        "'lower'",
        "none was absorbed or has escaped",
        "the scene a duration",
    )
    refused(words, simulate, tp.Scene(INNER, slabs()), 128, batches=2, error=OverrunError)
    assert time.process_time() - begun < 5  # until each is given up would take 1e9 crossings


def test_a_clock_or_weight_that_is_lost_ends_a_run_however_long_it_takes(little_patience):
    """A thousand crossings until the clock stops; some ten thousand until fog has taken nearly all by and by."""
    box = tp.Surface(tp.Box(size=2.0), MIRROR, "box")
    result = simulate(tp.Scene(PULSE, box, duration=1000 * 1.4 / 299792458.0), 128, batches=2)
    assert result.ledger["in_flight"].value == 1.0 and result.cost.crossings > 128 * 500
    faint = tp.Surface(tp.Box(size=2.0), MIRROR, "box", inside=tp.Medium(absorption=1e-4))
    result = simulate(tp.Scene(INNER, faint), 128, batches=2, tracking="weighted")
    assert result.ledger["absorbed"].value == pytest.approx(1.0, abs=0.05)
    assert result.cost.crossings > 128 * 5000


@pytest.mark.slow
def test_a_few_that_do_not_end_among_many_that_do_are_lost_and_counted():
    """Not refused: the ended histories are right, and the ledger counts the lost ones."""
    outside = tp.Source(tp.Point(position=(0, 0, 9)), tp.Isotropic(power=1.0))
    scene = tp.Scene([INNER, outside], slabs(tp.TwoSided(front=MIRROR, back=BLACK)))
    result = simulate(scene, 8, batches=2)
    assert result.ledger["lost"].value == 1.0 and "histories were lost" in result.warnings[0]


@pytest.mark.slow
def test_a_white_cavity_with_a_hole_of_a_millionth_still_runs():
    """A million reflections per history in the mean: 1/share of the wall (Poincare's theorem)."""
    cavity = tp.Surface(tp.Sphere(radius=1.0, mu_max=1 - 2e-6), WHITE, "cavity")
    result = tp.simulate(tp.Scene(INNER, cavity), 64, batches=2, seed=1, progress=False)
    assert result.ledger["escaped"].value == 1.0 and result.ledger["lost"].value == 0
    assert result.cost.crossings == pytest.approx(1e6 * 64, rel=4.5 / math.sqrt(64))


# ---- light that is guided for ever ----


def guided(body, glass=WATER, source=DOWN, host=None, duration=None):
    """A ball in a slab of glass."""
    slab = tp.Surface(host or tp.Slab(thickness=2.0), tp.Dielectric(1.33), "slab", inside=glass)
    return tp.Scene(source, [slab, tp.Surface(BALL, CLEAR, "inner", inside=body)], duration=duration)


FOGS = [tp.Medium(scattering=2.0, index=1.33), tp.Medium(absorption=0.5, scattering=2.0, index=1.33)]
ABSORBER = tp.Medium(absorption=0.5, index=1.33)
TOTAL = "total internal reflection", "'inner'", "'slab'", "48.75 degrees", "replace the slab by a finite Box"
ASIDE = tp.Source(tp.Point(position=(2.0, 0, 0)), tp.Isotropic(power=1.0))
TILTED = tp.Slab(normal=(0.1, 0.2, 1.0), thickness=2.0)


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"body": FOGS[0]}, TOTAL),
        ({"body": FOGS[1]}, TOTAL),
        ({"body": FOGS[0], "host": TILTED}, TOTAL),
        ({"body": FOGS[1], "host": TILTED}, TOTAL),
        ({"body": ABSORBER, "source": ASIDE}, ["sources[0] in Surface 'slab'"]),
    ],
)
def test_a_scatterer_or_a_lamp_in_a_clear_slab_is_refused(how, words):
    """Beyond the critical angle light goes on between the faces, past the ball, for ever; so in a slab that is tilted."""
    refused(words, guided, **how)


def test_slabs_that_end_absorb_or_hold_nothing_that_scatters_are_made():
    guided(FOGS[1], host=tp.Box(size=2.0))
    guided(FOGS[0], glass=tp.Medium(absorption=1e-3, index=1.33))
    guided(ABSORBER)  # nothing turns the beam
    pulse = tp.Source(DOWN.shape, tp.Beam((0, 0, -1), energy=1.0), pulse=tp.Instant())
    guided(FOGS[0], duration=1e-8, source=pulse)
    for height, normal in ((1.5, UP), (4, (0.1, 0, 1))):  # a ball on its face, and above it
        body = tp.Surface(tp.Sphere(center=(0, 0, height), radius=0.5), tp.Diffuse(0.5))
        tp.Scene(DOWN, [tp.Surface(tp.Slab(normal=normal, thickness=2.0), tp.Dielectric(1.33)), body])


# ---- media that hardly absorb ----


def test_an_endless_medium_that_gives_histories_up_is_refused():
    """Else all but one history in ten million end."""
    words = "infinite medium", "1e+09 times", "1.7e+07", "put it into a Box", "duration"
    refused(words, tp.Scene, LAMP, medium=tp.Medium(scattering=1.0, absorption=1e-9))
    assert GIVEN_UP == MAX_EVENTS and math.exp(-LIFETIMES) < 2e-7
    edge = LIFETIMES / MAX_EVENTS
    for absorption in (1e-6, edge * (1 + 1e-9)):
        tp.Scene(LAMP, medium=tp.Medium(scattering=1.0, absorption=absorption))
    thin = tp.Medium(scattering=1.0, absorption=edge * (1 - 1e-9))
    refused(["infinite medium"], tp.Scene, LAMP, medium=thin)


def test_a_medium_that_has_an_end_a_clock_or_an_absorber_is_made():
    milk = tp.Medium(scattering=1.0, absorption=1e-9)
    tp.Scene(LAMP, tp.Surface(tp.Box(size=2.0), BLACK), medium=milk)
    tp.Scene(LAMP, tp.Surface(tp.Box(size=2.0), CLEAR, inside=milk))
    tp.Scene(LAMP, tp.Surface(tp.Plane(center=UP), CLEAR, front=tp.Vacuum()), medium=milk)
    tp.Scene(PULSE, medium=milk, duration=1e-8)
