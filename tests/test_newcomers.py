"""The likeliest mistakes of a first day, and what is said of each: what is wrong, where, and the cure."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import transport as tp
from tests.processes import python
from transport.results.diagnostics.empty_detector import no_light_message

METER = tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.5)
LAMP = tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=100.0))


def run(lamp=LAMP, meter=METER, surfaces=(), side="front", particles=10_000):
    scene = tp.Scene(lamp, surfaces, tp.Detector(meter, "meter", side=side))
    return tp.simulate(scene, particles=particles, seed=1, threads=1, progress=False)


REFUSED = {
    "shapes by place": (lambda: tp.Disk((0, 0, 2), (0, 0, -1), 0.1), "Disk takes keywords only: write Disk(radius=...)"),
    "a name of another program": (lambda: tp.Sphere(diameter=2.0), "unknown parameter diameter=2.0; did you mean 'radius' (half of it)?"),
    "mu_a of tissue optics": (lambda: tp.Medium(mu_a=1.0), "unknown parameter mu_a=1.0; did you mean 'absorption'?"),
    "g of tissue optics": (lambda: tp.Medium(scattering=1, g=0.9), "did you mean 'phase' (phase=tp.HenyeyGreenstein(g))?"),
    "samples per pixel": (lambda: tp.simulate(tp.Scene(LAMP), spp=64), "simulate: unknown parameter spp=64; did you mean 'particles'?"),
    "nothing like it": (lambda: tp.Disk(radius=1, foo=2), "unknown parameter foo=2; choose from 'center', 'normal'"),
    "degrees for a cone": (lambda: tp.Directions.cone((0, 0, 1), 5), "angles are in radians: write 5 * tp.deg"),
    "degrees for edges": (lambda: run_with(theta=(0, 30, 90)), "angles are in radians: write 90 * tp.deg"),
    "degrees for a turn": (lambda: tp.Directions(phi=(0, 180, 360)), "angles are in radians: write 360 * tp.deg"),
    "degrees for a cosine": (lambda: run_with(mu=(0, 30, 90)), "mu is a cosine: for angles write theta="),
    "degrees for a camera": (
        lambda: tp.Camera(name="eye", position=(3, 0, 0), look_at=(0, 0, 0), field_of_view=40.0),
        "angles are in radians: write 40 * tp.deg",
    ),
    "no particles": (lambda: tp.simulate(tp.Scene(LAMP)), "no limit given; pass particles=1_000_000"),
    "particles to the scene": (lambda: tp.Scene(LAMP, particles=10), "write simulate(scene, particles=...)"),
    "a share above one": (lambda: tp.Diffuse(1.2), "albedo must be in [0, 1], got 1.2; a fraction, where 1 means all"),
    "a shape for a detector": (lambda: tp.Scene(LAMP, detectors=[METER]), "detectors must be a list of"),
    "rays without a detector": (
        lambda: tp.simulate(tp.Scene(LAMP), 10, estimator="expected"),
        "it has no detector to which rays could be sent; write detectors=[...]",
    ),
    "an array of another length": (lambda: tp.Disk(center=np.zeros(2), radius=1.0), "center must be three finite numbers"),
}  # fmt: skip


def run_with(**bins):
    return tp.Detector(METER, "meter", directions=tp.Directions(**bins))


@pytest.mark.parametrize("mistake", REFUSED)
def test_it_is_refused_with_the_cure(mistake):
    make, words = REFUSED[mistake]
    with pytest.raises(tp.SceneError) as refusal:
        made = make()
        tp.simulate(tp.Scene(LAMP, detectors=made), particles=10)
    assert words in str(refusal.value)


def test_what_is_no_mistake_is_taken():
    """Arrays for tuples, whole floats for counts, angles that are radians though above 1."""
    assert tp.Disk(center=np.array([0, 0, 2]), normal=np.array([0, 0, -1]), radius=np.float32(0.5)) == METER
    assert tp.simulate(tp.Scene(LAMP), particles=1e2, threads=1).particles == 100
    assert tp.Directions.cone((0, 0, 1), 1.5).half_angle == 1.5
    with pytest.raises(tp.SceneError) as refusal:
        tp.Directions.cone((0, 0, 1), -0.5)
    assert "tp.deg" not in str(refusal.value)


def test_errors_of_unknown_names_suggest_the_nearest(monkeypatch):
    result = run()
    with pytest.raises(tp.SceneError, match="no detector 'metre'; did you mean 'meter'"):
        result["metre"]
    with pytest.raises(AttributeError, match=r"read as result\['meter'\]"):
        result.meter  # noqa: B018
    with pytest.raises(AttributeError, match="no quantity 'iradiance'; did you mean 'irradiance'"):
        result["meter"].iradiance  # noqa: B018
    with pytest.raises(AttributeError, match="no attribute 'Lambertan'; did you mean 'Lambertian'"):
        tp.Lambertan  # noqa: B018
    for name, meant in (
        ("Lens", "ThinLens"),
        ("Cube", "Box"),
        ("Light", "Source"),
        ("Lambertan", "Lambertian"),
        ("millimeter", "mm"),
        ("nanometre", "nm"),
        ("micron", "um"),
        ("degrees", "deg"),
        ("inch", "cm"),
    ):
        with pytest.raises(AttributeError, match=f"no attribute '{name}'; did you mean '{meant}'"):
            getattr(tp, name)
    with pytest.raises(AttributeError, match=r"no attribute 'foo'; there are \d+ names, such as"):
        tp.foo  # noqa: B018
    with pytest.raises(AttributeError, match="no attribute 'metre'; numbers are in SI units: leave this"):
        tp.metre  # noqa: B018
    disc = tp.simulate(tp.Scene(LAMP, tp.Surface(METER, tp.Black(), "disc")), 10, progress=False).ledger
    with pytest.raises(tp.SceneError, match="absorbed_by has no entry 'desc'; did you mean 'disc'"):
        disc.absorbed_by["desc"]
    for name, meant in (
        ("radiosity", "exitance"),
        ("exposure", "fluence_rate"),
        ("illuminance", "irradiance"),
    ):
        with pytest.raises(AttributeError, match=f"no quantity '{name}'; did you mean '{meant}'"):
            getattr(result["meter"], name)
    with pytest.raises(AttributeError, match="no quantity 'xyz'; choose from 'flux_in'"):
        result["meter"].xyz  # noqa: B018
    monkeypatch.delattr(tp, "viz", raising=False)
    with pytest.raises(AttributeError, match="no attribute 'viz'; write import transport"):
        tp.viz  # noqa: B018
    with pytest.raises(AttributeError, match="no attribute 'scene'"):
        tp.Result.__new__(tp.Result).scene  # noqa: B018
    assert not hasattr(result, "_repr_png_") and not hasattr(tp, "__wrapped__")


def test_watts_and_radiance_are_not_added():
    meter = run()["meter"]
    with pytest.raises(tp.UnitError) as refusal:
        meter.flux_in + meter.irradiance
    assert str(refusal.value).endswith("[W] and [W m^-2]; the second lacks a factor of [m^2]")


def warnings_of(*arguments, **named):
    return [warning for warning in run(*arguments, **named).warnings if "counted nothing" in warning]


WALL = tp.Surface(tp.Box(size=1.5), tp.Diffuse(0.5), "wall")
ROOM = tp.Surface(tp.Box(center=(0, 0, 1), size=3.0), tp.Diffuse(0.5), "room")
BLACK = tp.Surface(tp.Sphere(radius=1.0), tp.Black(), "black")
SKY = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="inside")
EMPTY = {
    "a lamp that looks away": (
        {"lamp": tp.Source(tp.Disk(normal=(0, 0, -1), radius=0.5), tp.Lambertian(power=1.0))},
        "it lies behind every source",
    ),
    "a lamp in a wall": ({"surfaces": WALL}, "Surface 'wall' encloses every source"),
    "the outside of a wall round the lamp": (
        {"surfaces": BLACK, "meter": "black", "lamp": tp.Source(tp.Point(), tp.Isotropic(power=1.0))},
        "Surface 'black' encloses every source and lets no light through. Write side='inside', or move a source outside",
    ),
    "the inside of a wall under the sky": (
        {"surfaces": BLACK, "meter": "black", "side": "inside", "lamp": SKY},
        "Surface 'black' encloses it",
    ),
    "a meter in a wall": (
        {"surfaces": WALL, "meter": tp.Disk(radius=0.1), "lamp": tp.Source(METER, tp.Lambertian(power=1.0))},
        "Surface 'wall' encloses it",
    ),
    "a room that glows outwards": (
        {"surfaces": ROOM, "lamp": tp.Source("room", tp.Lambertian(power=1.0)), "meter": "room", "side": "inside"},
        "every source emits from the outside of Surface 'room'. Write side='inside' in the source",
    ),
}  # fmt: skip


@pytest.mark.parametrize("mistake", EMPTY)
def test_an_empty_detector_has_a_warning_with_the_reason(mistake):
    setting, words = EMPTY[mistake]
    (warning,) = warnings_of(**setting)
    assert words in warning and run(**setting)["meter"].is_blind


def test_a_shape_that_light_only_leaves_or_only_reaches_is_not_empty():
    ball, far = tp.Sphere(radius=1.0), tp.Sphere(radius=2.0)
    glowing = tp.Source(ball, tp.Lambertian(radiance=1.0))  # nothing comes back to it
    sky = tp.Source(far, tp.Lambertian(radiance=1.0), side="inside", aim=ball)
    black = tp.Surface(ball, tp.Black(), "wall")  # nothing leaves it
    for source, surfaces in ((glowing, ()), (sky, black)):
        meter = run(source, ball, surfaces)["meter"]
        assert sorted(flux.value > 0 for flux in (meter.flux_in, meter.flux_out)) == [False, True]
        assert not meter.is_blind and not warnings_of(source, ball, surfaces)


def test_a_detector_missed_by_chance_has_no_warning():
    """Nothing came by chance: none of the sure reasons holds."""
    far = tp.Disk(center=(1e5, 0, 2), normal=(-1, 0, 0), radius=1e-3)
    assert not warnings_of(meter=far) and run(meter=far)["meter"].is_blind
    assert not warnings_of(meter=far, surfaces=tp.Surface(tp.Box(size=1.5), tp.Transparent(), "pane"))
    away = tp.Source(tp.Disk(normal=(0, 0, -1), radius=0.5), tp.Lambertian(power=1.0))
    mirror = tp.Surface(tp.Disk(center=(0, 0, -1), radius=0.5), tp.Mirror(), "mirror")
    small = tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1e-6)
    assert not warnings_of(lamp=away, surfaces=mirror, meter=small)
    beside = tp.Disk(center=(0.3, 0, 0.6), normal=(0, 0, -1), radius=1e-6)  # with the lamp in the wall
    assert not warnings_of(surfaces=WALL, meter=beside) and run(meter=beside, surfaces=WALL)["meter"].is_blind
    inwards = tp.Source("room", tp.Lambertian(power=1.0), side="inside")
    assert (
        not warnings_of(lamp=inwards, surfaces=ROOM, meter=small)
        and run(inwards, small, ROOM)["meter"].is_blind
    )


def test_a_detector_that_faces_away_from_all_light_is_warned_of():
    """One that light crosses from behind, one that nothing has crossed yet, and an opaque one; by every estimator."""
    away = tp.Disk(center=(0, 0, 2), radius=0.5)
    faces = "its front faces away from every source, and nothing in front of it reflects or scatters light"
    note = (
        f"no light can arrive at detector 'meter': {faces}. Reverse its normal, write side='back', or read flux_out and"
        " exitance, which count light from its back"
    )
    floor = tp.Surface(tp.Rectangle(center=(0, 0, -1), width=9.0, height=9.0), tp.Diffuse(0.5), "floor")
    for surfaces in ((), floor):
        assert run(meter=away, surfaces=surfaces).warnings == [note]
        assert not run(surfaces=surfaces).warnings
    assert not run(meter=away, side="back").warnings
    assert run(meter=tp.Disk(center=(0, 0, 2), radius=1e-6)).warnings == [note]
    two = [tp.Detector(tp.Disk(center=(0, 0, z), radius=0.5), name) for z, name in ((1, "a"), (2, "b"))]
    (both,) = tp.simulate(
        tp.Scene(LAMP, (), two), particles=20_000, seed=1, threads=1, progress=False
    ).warnings
    assert "no light can arrive at detectors 'a' and 'b': they face away from every source" in both
    assert not run(meter=tp.Disk(radius=0.5)).warnings  # on the lamp: its exitance
    plate = tp.Surface(away, tp.Black(), "plate")
    proof = f"detector 'meter' counted nothing: {faces}. Reverse its normal, or write side='back'"
    for estimator in ("analog", "expected", "backward"):
        for surfaces, shape, words in (((), away, note), (plate, "plate", proof)):
            scene = tp.Scene(LAMP, surfaces, tp.Detector(shape, "meter"))
            result = tp.simulate(
                scene, particles=10_000, seed=1, threads=1, estimator=estimator, progress=False
            )
            assert result.warnings == [words] and str(result["meter"].flux_in) == "0 W (exact)"


def test_light_that_may_still_arrive_is_not_ruled_out():
    """An albedometer above dark asphalt: a few reflections of a thousand come, or none; none is no proof."""
    asphalt = tp.Surface(tp.Rectangle(width=20.0, height=20.0), tp.Diffuse(0.07), "asphalt")
    high = tp.Source(tp.Disk(center=(0, 0, 8), normal=(0, 0, -1), radius=0.2), tp.Lambertian(power=100.0))
    down = tp.Disk(center=(0, 0, 1.5), normal=(0, 0, -1), radius=0.05)
    result = run(high, down, asphalt)
    assert result["meter"].flux_in.reason == "no score"
    assert not any("no light can" in warning or "faces away" in warning for warning in result.warnings)


def test_light_that_may_be_sent_back_is_not_ruled_out():
    """A ceiling, a box of fog, fog all around, and a mirror that reaches past the plane: the detector was missed by chance."""
    away = tp.Disk(center=(0, 0, 2), radius=1e-6)
    fog = tp.Medium(absorption=0.1, scattering=0.1)
    for surfaces, medium in (
        (tp.Surface(tp.Disk(center=(0, 0, 3), radius=0.1), tp.Diffuse(0.5), "ceiling"), None),
        (tp.Surface(tp.Box(center=(0, 0, 3), size=0.1), tp.Transparent(), inside=fog), None),
        (tp.Surface(tp.Sphere(center=(2, 0, 1.95), radius=0.1), tp.Mirror(), "ball"), None),
        ((), fog),
    ):
        scene = tp.Scene(LAMP, surfaces, tp.Detector(away, "meter"), medium=medium)
        warnings = tp.simulate(scene, particles=400, seed=1, threads=1, progress=False).warnings
        assert not any("faces away" in warning for warning in warnings), surfaces
    behind = tp.Surface(tp.Sphere(center=(2, 0, 1.9), radius=0.1), tp.Mirror(), "ball")  # touches the plane
    assert "faces away" in run(meter=away, surfaces=behind).warnings[0]


LAMPS_IN_A_BOX = {
    "a point": tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=1.0)),
    "a disk on the ceiling": tp.Source(
        tp.Disk(center=(0.3, 0, 1), normal=(0, 0, -1), radius=0.1), tp.Lambertian(power=1.0)
    ),
    "the walls": tp.Source("box", tp.Lambertian(power=1.0), side="inside"),
}


ROOMS = {
    "box": [
        tp.Surface(tp.Box(size=2.0), tp.Diffuse(0.5), "box", inside=tp.Medium(absorption=0.5, scattering=0.5))
    ],
    "faces": [
        tp.Surface(face, tp.Diffuse(0.5), name, inside=tp.Medium(absorption=0.5, scattering=0.5))
        for name, face in tp.Box(size=2.0).faces().items()
    ],
}


@pytest.mark.quick_cases("a point-box", "a point-faces")
@pytest.mark.parametrize("room", ROOMS)
@pytest.mark.parametrize("lamp", LAMPS_IN_A_BOX)
def test_a_detector_outside_a_closed_opaque_box_has_a_warning_with_the_box_and_none_of_the_roulette(
    lamp, room
):
    """On the box, on its lid, round it, beside it, a volume and a point, with fog in the box: the cure is a side or a place."""
    wall = {"box": "box", "faces": "+z"}[room]
    source = LAMPS_IN_A_BOX[lamp]
    if lamp == "the walls":
        source = tp.Source(wall, tp.Lambertian(power=1.0), side="back")
    detectors = [
        tp.Detector(wall, "wall"),
        tp.Detector(tp.Disk(center=(0, 0, 1), radius=0.2), "lid"),
        tp.Detector(tp.Sphere(radius=3.0), "round"),
        tp.Detector(tp.Sphere(radius=3.0), "round, inwards", side="inside"),
        tp.Detector(tp.Disk(center=(0, 0, 3), normal=(0, 0, -1), radius=0.2), "beside"),
        tp.VolumeDetector(tp.Box(center=(0, 0, 3), size=0.5), "volume"),
    ]
    scene = tp.Scene(source, ROOMS[room], detectors)
    warnings = tp.simulate(scene, particles=2000, seed=1, threads=1, progress=False).warnings
    assert len(warnings) == len(detectors)
    for warning, detector in zip(warnings, detectors, strict=True):
        assert f"{detector.name!r} counted nothing: Surface " in warning
        assert "every source and lets no light through. " in warning
    assert f"Write side={'inside' if room == 'box' else 'back'!r}" in warnings[0]


def test_a_detector_between_two_opaque_balls_with_a_lamp_in_one_and_beyond_the_other():
    """Neither ball parts it from both lamps, both together do."""
    balls = [
        tp.Surface(tp.Sphere(radius=r), tp.Black(), name) for r, name in ((1.0, "inner"), (3.0, "outer"))
    ]
    lamps = [tp.Source(tp.Point(position=(x, 0, 0)), tp.Isotropic(power=1.0)) for x in (0.0, 5.0)]
    scene = tp.Scene(lamps, balls, tp.Detector(tp.Sphere(radius=2.0), "meter"))
    (warning,) = tp.simulate(scene, particles=400, seed=1, threads=1, progress=False).warnings
    assert (
        "'meter' counted nothing: Surface 'inner' and Surface 'outer' separate it from every source"
        in warning
    )


def test_a_lamp_that_fills_a_room_and_more_is_neither_in_nor_out():
    """A glowing ball about an opaque one, and a volume about a closed box: births, and light, are within as well."""
    glow = tp.Source(tp.Sphere(radius=10.0), tp.Isotropic(power=1.0))
    speck = tp.Detector(tp.Disk(radius=1e-3), "speck")
    scene = tp.Scene(glow, tp.Surface(tp.Sphere(radius=1.0), tp.Black(), "ball"), speck)
    warnings = tp.simulate(scene, particles=64, seed=1, threads=1, progress=False).warnings
    assert len(warnings) == 1 and "has no score in 64 particles: unknown, not 0." in warnings[0]
    box = tp.Surface(tp.Box(size=2.0), tp.Diffuse(0.5), "box")
    scene = tp.Scene(LAMPS_IN_A_BOX["a point"], box)
    assert no_light_message(scene, "volume", tp.Sphere(radius=9.0)) is None
    assert no_light_message(scene, "volume", tp.Sphere(center=(20, 0, 0), radius=9.0)) is not None


def test_a_lamp_on_a_closed_box_that_faces_outwards_does_not_count_as_inside():
    lamp = tp.Source(tp.Disk(center=(0, 0, 1), radius=0.1), tp.Lambertian(power=1.0))
    box = tp.Surface(tp.Box(size=2.0), tp.Diffuse(0.5), "box")
    speck = tp.Disk(center=(5, 0, 2), normal=(-1, 0, 0), radius=1e-6)
    assert not warnings_of(lamp=lamp, surfaces=box, meter=speck)
    inner = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.1)
    (warning,) = warnings_of(lamp=lamp, surfaces=box, meter=inner)
    assert "every source emits from the outside of Surface 'box'. Write side='back' in the source" in warning


# What Python reports of a script that imports itself.
SELF_IMPORT = "consider renaming" if sys.version_info >= (3, 13) else "circular import"


@pytest.mark.quick_cases("numpy-numpy.py shadows NumPy: rename it", f"transport-{SELF_IMPORT}")
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("numpy", "numpy.py shadows NumPy: rename it"),
        ("transport", SELF_IMPORT),
        ("random", None),
    ],
)
def test_a_file_with_the_name_of_a_package_is_reported(tmp_path, name, words):
    """A script that begins with `import transport`, beside or in a file of that name."""
    (tmp_path / f"{name}.py").write_text("x = 1\n")
    script = tmp_path / (f"{name}.py" if name == "transport" else "mine.py")
    script.write_text("import transport\nprint(transport.Disk(radius=1.0).radius)\n")
    done = python(script, folder=tmp_path, status=None)
    assert words in done.stderr if words else done.stdout.split() == ["1.0"]
