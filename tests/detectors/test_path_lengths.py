"""Mean path lengths by medium: geometry, 4V/S, the derivative by absorption, and other ways of tracking."""

from dataclasses import replace

import numpy as np
import pytest

import transport as tp
from tests.refusals import assert_refused

FOG, HAZE = tp.Medium(scattering=2.0), tp.Medium(scattering=0.5, phase=tp.HenyeyGreenstein(0.6))
VACUUM = tp.Vacuum()


def run(scene, particles=1e5, **settings):
    return tp.simulate(scene, particles=particles, seed=11, progress=False, **settings)


def body(shape, medium, name="body"):
    return tp.Surface(shape, tp.Transparent(), name, back=medium)


# ---- Isotropic light in a body: the mean chord.


def in_isotropic_light(shape, medium):
    """Return a scene of a body in isotropic light, with a detector inside its surface."""
    far = tp.Sphere(radius=5.0)
    lamp = tp.Source(far, tp.Lambertian(power=1.0), side="inside")
    surfaces = [tp.Surface(far, tp.Black(), "far"), body(shape, medium)]
    return tp.Scene(lamp, surfaces, tp.Detector("body", side="inside", path_lengths=medium))


BODIES = [tp.Sphere(radius=1.5), tp.Box(size=(1.0, 2.0, 0.3)), tp.Sphere(center=(1, 0, 0), radius=0.7)]


@pytest.mark.parametrize("medium", [FOG, HAZE], ids=["isotropic", "forward"])
@pytest.mark.parametrize("shape", BODIES, ids=["sphere", "box", "off centre"])
def test_the_mean_path_through_a_body_is_four_volumes_over_its_surface(shape, medium):
    """In isotropic light it does not depend on scattering (Blanco and Fournier 2003)."""
    path = run(in_isotropic_light(shape, medium), particles=4e5)["body"].mean_path_in
    assert path.dims == ("medium",)
    assert abs(path.z(4 * shape.volume / shape.area)[0]) < 3.5


def test_a_body_that_is_crossed_again_adds_to_the_path():
    """A white wall sends light through the body many times; its detector counts the path since birth."""
    room = tp.Sphere(radius=2.0)
    lamp = tp.Source(room, tp.Lambertian(power=1.0), side="inside")
    walls = [tp.Surface(room, tp.Diffuse(0.5), "room")]
    scene = tp.Scene(lamp, walls, tp.Detector("room", side="inside", path_lengths=[VACUUM]))
    # Arrival n has flown n chords, and weighs 0.5^(n - 1): mean chord times sum n 2^-n / sum 2^-n = 2.
    assert abs(run(scene)["room"].mean_path_in.z(2 * 4 / 3 * 2.0)[0]) < 3.5


# ---- A ray through layers: exact lengths.


def layers(*media, **options):
    """Return a scene of an oblique pencil through boxes of media of 0.5 m, with a detector behind them."""
    shapes = [tp.Box(center=(0, 0, 0.25 + k), size=(20, 20, 0.5)) for k in range(len(media))]
    boxes = [body(*each, name=f"box {k}") for k, each in enumerate(zip(shapes, media, strict=True))]
    lamp = tp.Source(tp.Point(position=(0.01, 0.02, -1.0)), tp.Beam(direction=(0.6, 0, 0.8), power=1.0))
    end = tp.Disk(center=(0, 0, len(media) + 1.0), normal=(0, 0, -1), radius=20.0)
    return tp.Scene(lamp, boxes, tp.Detector(end, "end", **options))


WEAK, STRONG = tp.Medium(absorption=0.3), tp.Medium(absorption=1.7)


def test_paths_of_a_pencil_through_layers_are_their_lengths():
    scene = layers(WEAK, STRONG, WEAK, path_lengths=[STRONG, WEAK, VACUUM])
    path = run(scene, particles=1e3)["end"].mean_path_in
    # From z = -1 to z = 4 at cosine 0.8; three layers of 0.5.
    assert path.value == pytest.approx(np.array([0.5, 1.0, 3.5]) / 0.8, rel=1e-13)


def test_each_detector_has_its_own_media_in_its_own_order():
    scene = layers(WEAK, STRONG, path_lengths=[STRONG])
    disk = tp.Disk(center=(0, 0, 0.75), normal=(0, 0, -1), radius=20.0)
    middle = tp.Detector(disk, "middle", path_lengths=[VACUUM, STRONG, WEAK])
    result = run(replace(scene, detectors=(*scene.detectors, middle)), particles=1e3)
    assert result["end"].mean_path_in.value == pytest.approx([0.5 / 0.8], rel=1e-13)
    assert result["middle"].mean_path_in.value == pytest.approx(np.array([1.25, 0.0, 0.5]) / 0.8, rel=1e-13)


def test_paths_by_direction_follow_the_slant_of_the_ray():
    lamp = tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=1.0))
    far = tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=40, height=40)
    directions = tp.Directions(mu=8)
    scene = tp.Scene(lamp, (), tp.Detector(far, "far", directions=directions, path_lengths=VACUUM))
    path = run(scene)["far"].mean_path_in
    assert path.dims == ("medium", "mu") and path.shape == (1, 8)
    # Light from a point has intensity uniform in mu: the mean of 1/mu over a bin.
    edges = np.linspace(0, 1, 9)
    exact = np.log(edges[2:] / edges[1:-1]) / np.diff(edges[1:])
    assert np.abs(path.z(np.array([[np.nan, *exact]]))[0, 1:]).max() < 4


# ---- Absorption: the mean path is the derivative of the logarithm of the flux.


def nested(core_absorption, shell_absorption):
    """Return a scattering sphere with an absorbing core in a beam, and a detector of all that leaves it."""
    core = tp.Medium(absorption=core_absorption, scattering=3.0, phase=tp.HenyeyGreenstein(0.5))
    shell = tp.Medium(absorption=shell_absorption, scattering=1.0)
    surfaces = [body(tp.Sphere(radius=1.0), shell, "shell"), body(tp.Sphere(radius=0.5), core, "core")]
    lamp = tp.Source(tp.Disk(center=(0, 0, -2), radius=0.8), tp.Beam(direction=(0, 0, 1), power=1.0))
    return tp.Scene(lamp, surfaces, tp.Detector("shell", side="inside", path_lengths=[core, shell]))


@pytest.mark.parametrize("medium", [0, 1], ids=["core", "shell"])
def test_the_mean_path_is_the_relative_loss_per_absorption_coefficient(medium):
    """Both runs have the same flights, for absorption only lessens weights: the difference has no noise."""
    step, fluxes = 1e-4, []
    tracking = tp.Tracking(absorption="weighted", roulette=1e-12)
    for sign in (-1, 1):
        absorption = [0.2, 0.1]
        absorption[medium] += sign * step
        fluxes.append(run(nested(*absorption), particles=2e4, tracking=tracking)["shell"].flux_in.value)
    path = run(nested(0.2, 0.1), particles=2e4, tracking=tracking)["shell"].mean_path_in[medium]
    slope = -np.log(fluxes[1] / fluxes[0]) / (2 * step)
    # The ratio's estimate is corrected for its bias of one in the number of batches; the slope is not.
    assert path.value == pytest.approx(slope, rel=1e-5)


WAYS = {
    "analog": tp.Tracking(absorption="analog"),
    "forced": tp.Tracking(forced=True),
    "splitting": tp.Tracking(splitting=tp.Splitting(start=(0, 0, -1), end=(0, 0, 1), gain=16)),
}


@pytest.mark.parametrize("way", WAYS)
def test_every_way_of_tracking_has_the_same_mean_paths(way):
    plain = run(nested(0.2, 0.1), particles=2e5)["shell"].mean_path_in
    other = run(nested(0.2, 0.1), particles=2e5, tracking=WAYS[way])["shell"].mean_path_in
    assert np.abs((plain - other).z(0.0)).max() < 3.5


def test_voxels_have_the_paths_of_the_medium_that_they_write_out():
    medium = tp.Medium(absorption=0.4, scattering=2.0)
    box = tp.Box(size=(1, 1, 1))
    voxels = np.full((3, 3, 3), 1.0)
    voxels[0, 0, 0] = 1.0 + 1e-12  # not collapsed to one number
    grid = tp.Grid(absorption=0.4 * voxels, scattering=2.0 * voxels, box=box)
    one, other = (run(in_isotropic_light(box, each), 2e5)["body"].mean_path_in for each in (medium, grid))
    assert abs((one - other).z(0.0)[0]) < 3.5


def test_paths_with_a_clock_end_with_it():
    scene = replace(layers(WEAK, path_lengths=[WEAK, VACUUM]), duration=10.0 / tp.speed_of_light)
    path = run(scene, particles=1e4)["end"].mean_path_in
    assert path.value == pytest.approx(np.array([0.5, 2.5]) / 0.8, rel=1e-12)


# ---- Estimators, arguments, files.


def test_an_aimed_run_knows_the_straight_path():
    lamp = tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=1.0))
    disk = tp.Detector(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0), "end", path_lengths=VACUUM)
    scene = tp.Scene(lamp, (), disk)
    # Isotropic light within 45 degrees: mean of 1/mu over mu from 1/sqrt(2) to 1.
    exact = np.log(np.sqrt(2)) / (1 - np.sqrt(0.5))
    assert abs(run(scene, estimator="aimed")["end"].mean_path_in.z(exact)[0]) < 3.5


def test_eight_media_at_most_have_path_lengths():
    media = [tp.Medium(absorption=0.1 * k) for k in range(1, 10)]
    words = "8 media at most, of all detectors together, got 9"
    assert_refused(lambda: run(layers(*media, path_lengths=media)), words)


@pytest.mark.slow
def test_scenes_and_runs_with_path_lengths_are_stored(tmp_path):
    scene = layers(WEAK, STRONG, path_lengths=[STRONG, VACUUM], directions=tp.Directions(mu=3))
    assert tp.Scene.from_json(scene.to_json()) == scene
    result = run(scene, particles=1e3)
    result.save(tmp_path / "run.nc")
    again = tp.load(tmp_path / "run.nc")
    assert (again["end"].mean_path_in.value == result["end"].mean_path_in.value)[:, 2].all()


@pytest.mark.slow
def test_a_dataset_and_a_picture_have_the_axis_of_media():
    path = run(layers(WEAK, path_lengths=[WEAK, VACUUM]), particles=1e3)["end"]
    data = path.to_dataset("mean_path_in")
    assert data.mean_path_in.dims == ("medium",) and data.mean_path_in.attrs["units"] == "m"
    assert data.medium.values.tolist() == [0, 1]
    assert path.plot("mean_path_in") is not None


# ---- What few particles, faint light and long tails do to a mean.


def test_the_mean_path_of_very_faint_light_keeps_its_digits():
    """At an optical depth of 40 weights have four digits left in the sums of weights."""
    dense = tp.Medium(absorption=64.0)
    path = run(layers(dense, path_lengths=[dense, VACUUM]), particles=1e3)["end"].mean_path_in
    assert path.value == pytest.approx(np.array([0.5, 2.5]) / 0.8, rel=1e-10)


@pytest.mark.parametrize("radius", [1e-4, 6e-3, 1.6e-2], ids=["never met", "met once", "met eight times"])
def test_the_mean_path_in_a_body_that_hardly_any_ray_meets_is_doubtful(radius):
    ball = body(tp.Sphere(radius=radius), FOG, "ball")
    far = tp.Surface(tp.Sphere(radius=1.0), tp.Black(), "far")
    lamp = tp.Source("far", tp.Lambertian(power=1.0), side="inside")
    scene = tp.Scene(lamp, [ball, far], tp.Detector("far", side="inside", path_lengths=[FOG, VACUUM]))
    path = run(scene, particles=3e4)["far"].mean_path_in
    assert path.verdict.tolist() == ["doubtful", "sound"]


def test_a_mean_that_one_very_long_path_decides_is_doubtful():
    """The light of a point onto a plane without end: the mean of 1/mu does not exist."""
    lamp = tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0))
    scene = tp.Scene(lamp, (), tp.Detector(tp.Plane(), "plane", path_lengths=VACUUM))
    runs = (tp.simulate(scene, particles=1e4, seed=seed, progress=False) for seed in range(20))
    verdicts = [each["plane"].mean_path_in.verdict[0] for each in runs]
    assert verdicts.count("doubtful") > 10


def test_missing_particles_count_against_mean_paths_too():
    """In a scene of one speed, in which missing particles do not count against mean speeds."""
    fog = tp.Medium(absorption=1.0, scattering=2.0)
    box = body(tp.Box(size=6.0), fog, "box")
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    scene = tp.Scene(lamp, box, tp.Detector("box", side="inside", path_lengths=fog))
    reading = run(scene, particles=3e3, tracking=tp.Tracking(roulette=0.5))["box"]
    missing = {finding.name for finding in reading.flux_in.findings}
    assert missing and missing <= {finding.name for finding in reading.mean_path_in.findings}
