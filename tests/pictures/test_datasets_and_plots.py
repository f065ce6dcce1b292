"""`to_dataset()` and `plot()` of every kind of tally: the numbers, the sizes of the bins, the axes of the picture."""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import matplotlib
import numpy as np
import pytest

import transport as tp
from tests.drawing import words
from tests.synthetic import estimates

matplotlib.use("Agg")
from matplotlib import pyplot

U = (-1.0, -0.8, 0.1, 1.0)  # bins of unlike sizes
FOG = tp.Medium(scattering=0.2, absorption=0.3)


@pytest.fixture(scope="module")
def forward():
    """A lamp over a floor in fog that absorbs, with a clock; a detector of each kind."""
    lamp = tp.Source(
        tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.2),
        tp.Lambertian(energy=2.0),
        pulse=tp.Instant(),
    )
    floor = tp.Surface(tp.Rectangle(normal=(0, 0, 1), width=2, height=2), tp.Diffuse(0.5), name="floor")
    disk = tp.Disk(center=(0, 0, 0.5), normal=(0, 0, 1), radius=0.3)
    box = tp.Box(center=(0, 0, 0.5), size=(1, 1, 1))
    detectors = [
        tp.Detector("floor", positions=tp.Positions(u=U, v=3), times=2),
        tp.Detector(disk, "up", directions=tp.Directions(theta=(0, 0.3, 0.7, np.pi / 2))),
        tp.Detector(disk, "all", positions=tp.Positions(u=2), directions=tp.Directions(mu=2, phi=3)),
        tp.Detector(disk, "plain"),
        tp.VolumeDetector(box, "box", cells=(3, 1, 2)),
        tp.VolumeDetector(tp.Sphere(center=(0, 0, 0.5), radius=0.4), "ball", cells=(0.1, 0.2, 0.4)),
        tp.PhaseSpace(name="cloud", time=(1e-9, 2e-9), x=(-1, -0.2, 0, 1)),
        tp.Snapshot(name="shot", time=1e-9, particles=50),
    ]
    scene = tp.Scene(lamp, floor, detectors, medium=FOG, duration=5e-9)
    return tp.simulate(scene, 20_000, seed=1, threads=2, progress=False)


@pytest.fixture(scope="module")
def backward():
    lamp = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.4), tp.Lambertian(radiance=2.0))
    floor = tp.Surface(tp.Rectangle(normal=(0, 0, 1), width=2, height=2), tp.Diffuse(0.5), name="floor")
    around = tp.EnvironmentMap(position=(0, 0.2, 0.5), name="around", theta=(0, 0.2, 1, np.pi), phi=4)
    view = tp.Camera(position=(0, -2, 1), look_at=(0, 0, 0), pixels=(6, 4), name="view")
    patch = tp.Detector("floor", "patch", positions=tp.Positions(u=U, v=2))
    scene = tp.Scene(lamp, floor, [around, view, patch])
    return tp.simulate(scene, 40_000, seed=1, threads=2, progress=False, estimator="backward")


@pytest.fixture(scope="module")
def steady():
    lamp = tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0))
    disk = tp.Surface(tp.Disk(radius=1), tp.Diffuse(0.5), name="disk")
    dot = tp.PointDetector(name="dot", position=(0.4, 0.1, 0.2))
    scene = tp.Scene(lamp, disk, [tp.Detector("disk", positions=tp.Positions(u=3, v=4)), dot])
    return tp.simulate(scene, 5_000, seed=1, threads=2, progress=False)


# Datasets


@pytest.mark.slow
@pytest.mark.parametrize("name", ["forward", "backward", "steady"])
def test_a_dataset_is_what_a_saved_run_holds_and_the_sizes_of_bins(name, request, tmp_path):
    xarray = pytest.importorskip("xarray")
    result, path = request.getfixturevalue(name), tmp_path / "run.nc"
    result.save(path)
    for detector in result.scene.detectors:
        data = result[detector.name].to_dataset()
        with xarray.open_dataset(path, engine="h5netcdf", group=detector.name) as saved:
            sizes = [name for name in data.coords if str(name).startswith("bin_")]
            xarray.testing.assert_identical(data.drop_vars(sizes), saved.load())


@pytest.mark.parametrize(
    ("run", "name", "density", "size", "whole"),
    [
        ("forward", "floor", "irradiance", "bin_area", "flux_in"),
        ("forward", "floor", "flux_in", "bin_time", "energy_in"),
        ("forward", "up", "radiance", "bin_projected_solid_angle", "irradiance"),
        ("forward", "up", "flux_density", "bin_solid_angle", "irradiance"),
        ("forward", "ball", "absorbed_density", "bin_volume", "absorbed_power"),
        ("forward", "cloud", "density", "bin_extent", "number"),
        ("backward", "around", "radiance", "bin_solid_angle", "fluence_rate"),
        ("backward", "patch", "irradiance", "bin_area", "flux_in"),
    ],
)
def test_a_density_times_the_sizes_of_its_bins_is_its_integral(run, name, density, size, whole, request):
    data = request.getfixturevalue(run)[name].to_dataset()
    assert data[size].attrs["units"] and data[density].attrs["units"]
    kept = [dim for dim in data[density].dims if dim not in data[size].dims or dim in data[whole].dims]
    parts = data[density] * data[size]
    summed = parts.sum([dim for dim in data[density].dims if dim not in kept])
    np.testing.assert_allclose(summed, data[whole], rtol=1e-12)
    widths = data[size].values
    assert not np.allclose(widths, widths.flat[0]) or name == "floor"  # a plain sum would be wrong


def test_chosen_quantities_have_their_bins_alone(forward):
    data = forward["all"].to_dataset("irradiance", "radiance")
    assert [name for name in data if not name.endswith("_doubtful")] == [
        "irradiance", "irradiance_error", "radiance", "radiance_error",
    ]  # fmt: skip
    assert data.radiance.dims == ("u", "mu", "phi") and data.u.attrs["units"] == "m"
    only = forward["all"].to_dataset("irradiance")
    assert set(only.dims) == {"u", "v"} & set(only.dims) and "bin_area" in only.coords
    with pytest.raises(tp.SceneError, match="radiance needs directions"):
        forward["plain"].to_dataset("radiance")
    with pytest.raises(tp.SceneError, match="did you mean 'irradiance'"):
        forward["plain"].to_dataset("iradiance")


def test_a_dataset_leaves_no_quantities_in_a_tally_that_were_not_read(forward):
    tally = forward._read(forward.scene.detectors[0])
    read = tally.exitance
    tally.to_dataset()
    assert vars(tally)["exitance"] is read and "irradiance" not in vars(tally)


def test_available_quantities_are_those_that_can_be_read(forward, backward, steady):
    for result in (forward, backward, steady):
        for detector in result.scene.detectors:
            tally = result[detector.name]
            for name in tally.known:
                if name in tally.available:
                    getattr(tally, name)
                else:
                    with pytest.raises(tp.SceneError):
                        getattr(tally, name)
    assert "energy_in" in forward["plain"].available and "radiance" not in forward["plain"].available


def test_a_sample_has_no_quantity_to_convert(forward):
    with pytest.raises(tp.SceneError, match=r"Snapshot 'shot': no quantity 'weights'; it is a sample"):
        forward["shot"].to_dataset("weights")
    assert "weights" in forward["shot"].to_dataset()


# Pictures


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    pyplot.close("all")


def test_one_axis_is_drawn_as_steps_and_points_with_bars_of_two_errors(forward):
    axes = forward["up"].plot()
    radiance = forward["up"].radiance
    assert axes.get_xlabel() == "polar angle θ [°]" and axes.get_ylabel().startswith("radiance  [")
    (steps,) = axes.patches
    np.testing.assert_array_equal(steps.get_data().values, radiance.value)
    np.testing.assert_allclose(steps.get_data().edges, np.degrees(radiance.coords["theta"]))
    (bars,) = axes.containers
    segments = np.array(bars.lines[2][0].get_segments())
    known = np.isfinite(radiance.error)
    np.testing.assert_allclose(np.diff(segments[:, :, 1])[:, 0], 4 * radiance.error[known])


@pytest.mark.parametrize(
    ("run", "name", "quantity", "labels", "is_transposed", "inverted"),
    [
        ("backward", "patch", "irradiance", ("u [m]", "v [m]"), True, (False, False)),
        ("backward", "view", "radiance", ("", ""), False, (False, False)),
        (
            "backward",
            "around",
            "radiance",
            ("azimuth φ [°], seen from inside", "polar angle θ [°]"),
            False,
            (True, True),
        ),
        ("forward", "box", "fluence_rate", ("x [m]", "z [m]"), True, (False, False)),
    ],
)
def test_a_map_has_its_bins_where_they_are(run, name, quantity, labels, is_transposed, inverted, request):
    tally = request.getfixturevalue(run)[name]
    axes = tally.plot(quantity)
    assert (axes.get_xlabel(), axes.get_ylabel()) == labels
    assert (axes.xaxis_inverted(), axes.yaxis_inverted()) == inverted
    array = getattr(tally, quantity)
    value = np.squeeze(array.value)
    value = value.T if is_transposed else value
    (drawn,) = [each for each in (*axes.images, *axes.collections) if each.get_array() is not None]
    np.testing.assert_array_equal(np.ma.filled(drawn.get_array(), np.nan).reshape(value.shape), value)
    beside = axes.figure.axes[1]
    assert len(axes.figure.axes) == 2 and beside.get_xlabel() == labels[0]
    assert beside.get_title() == "relative standard error  [%]"


def test_a_disk_is_drawn_round(steady):
    axes = steady["disk"].plot()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("along $e_u$ [m]", "along $e_v$ [m]")
    (mesh,) = axes.collections
    assert np.hypot(*mesh.get_coordinates().reshape(-1, 2).T).max() == pytest.approx(1.0)


def test_a_picture_is_drawn_where_it_is_asked_for(forward):
    _, axes = pyplot.subplots()
    radiance = forward["all"].radiance[0]
    radiance = radiance if len(radiance.dims) == 2 else radiance[0]
    assert radiance.plot(axes, label="L") is axes
    assert axes.child_axes[0].get_ylabel().startswith("L  [")  # its bar


def test_decades_set_a_logarithmic_scale(backward):
    axes = backward["around"].radiance.sum("phi").plot(decades=2)
    low, high = axes.get_ylim()
    assert axes.get_yscale() == "log" and 100 <= high / low < 1000


def test_what_cannot_be_drawn_is_refused(forward, steady):
    with pytest.raises(
        ValueError, match=r"3 axes of bins \(u, mu, phi\); index it, or average it as in [.]mean"
    ):
        forward["all"].plot("radiance")
    with pytest.raises(ValueError, match="flux_in of 'plain' has no bins"):
        forward["plain"].plot("flux_in")
    with pytest.raises(ValueError, match="'dot' has no quantity with bins"):
        steady["dot"].plot()


def test_without_matplotlib_the_command_that_installs_it_is_named(forward, monkeypatch):
    for name in [name for name in sys.modules if name.startswith("transport.viz")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(tp.SceneError, match=r"plot: matplotlib is not installed; pip install"):
        forward["up"].plot()
    with pytest.raises(tp.SceneError, match=r"plot: matplotlib is not installed; pip install"):
        forward["up"].radiance.plot()


@pytest.mark.parametrize("name", ["plan", "particles", "fluxin", 3, ["flux_in"]])
def test_what_is_no_quantity_is_refused_by_name(name):
    floor = tp.Surface(tp.Rectangle(center=(0, 0, -1), width=2, height=2), tp.Black(), "floor")
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    meter = tp.Detector("floor", positions=tp.Positions(u=2))
    reading = tp.simulate(tp.Scene(lamp, floor, meter), 100, seed=1, progress=False)["floor"]
    with pytest.raises(tp.SceneError, match="Detector 'floor': no quantity"):
        reading.to_dataset(name)
    with pytest.raises(tp.SceneError, match="Detector 'floor': no quantity"):
        reading.plot(name)
    for wrong in (0, -1, float("nan"), float("inf"), "a"):
        with pytest.raises(ValueError, match="plot: decades must be"):
            reading.plot("irradiance", decades=wrong)
    with pytest.raises(ValueError, match="plot: ax must be Axes"):
        reading.plot("irradiance", ax=3)


def test_a_misspelt_quantity_is_compared_with_those_that_the_scene_has():
    """`fluence` is nearer, but it needs a clock."""
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    scene = tp.Scene(lamp, (), tp.VolumeDetector(tp.Box(size=1.0), "box"))
    with pytest.raises(AttributeError, match="did you mean 'fluence_rate'"):
        _ = tp.simulate(scene, particles=100, progress=False)["box"].flence


# Plots in one line


def test_data_frames_have_a_row_per_bin(steady):
    pytest.importorskip("pandas")
    frame = steady["disk"].irradiance.to_dataframe()
    assert len(frame) == 12 and {"u", "v", "value", "error", "doubtful", "u_low"} <= set(frame.columns)
    whole = steady["disk"].to_dataframe("irradiance")
    np.testing.assert_allclose(sorted(whole.irradiance), sorted(frame.value))
    assert len(steady["dot"].to_dataframe()) == 1


def test_columns_of_a_frame_do_not_depend_on_the_noise(steady):
    """Few histories leave doubtful bins, many leave none."""
    few = tp.simulate(steady.scene, 100, seed=1, progress=False)
    columns = [list(run["disk"].to_dataframe("irradiance")) for run in (few, steady)]
    assert columns[0] == columns[1] and "irradiance_doubtful" in columns[0]


def test_a_plot_has_a_cut_and_another_unit(steady):
    ax = steady["disk"].plot("irradiance", cut=True, unit="lx", label="illuminance")
    words = [each.get_title() for each in ax.figure.axes] + [each.get_ylabel() for each in ax.figure.axes]
    assert any("illuminance" in each and "lx" in each for each in words)
    assert len([each for each in ax.figure.axes if each.get_label() != "<colorbar>"]) == 3
    line = steady["disk"].irradiance.mean("v").plot(unit="lx")
    assert "lx" in line.get_ylabel()
    pyplot.close("all")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"cut": True}, "drawn as a curve without cut"),
        ({"cut": "x"}, "the coordinate of a row, got 'x'"),
        ({"cut": None}, "the coordinate of a row, got None"),
        ({"cut": math.nan}, "the coordinate of a row, got nan"),
        ({"label": 3}, "label must be words, got 3"),
        ({"unit": ""}, "unit must be words, got ''"),
        ({"ax": "polar"}, "straight axes, got polar ones"),
    ],
)
def test_an_option_that_a_curve_cannot_use_is_refused(steady, options, said):
    line = steady["disk"].irradiance.mean("v")
    if "ax" in options:
        options = {"ax": pyplot.figure().add_subplot(projection=options["ax"])}
    with pytest.raises(ValueError, match=said):
        line.plot(**options)
    pyplot.close("all")


def test_a_cut_that_a_map_has_no_place_for_is_refused(steady):
    for cut in (np.int64(1), np.float32(1.0)):  # numbers of NumPy are numbers
        steady["disk"].plot("irradiance", cut=cut)
    with pytest.raises(ValueError, match="ax has no room for a cut"):
        steady["disk"].plot("irradiance", cut=True, ax=pyplot.figure().gca())
    with pytest.raises(ValueError, match=r"azimuth of -2π to 2π .*write math.radians.90. for degrees"):
        steady["disk"].plot("irradiance", cut=90)
    pyplot.close("all")


@pytest.mark.parametrize("unit", ["%", "#", r"a_b{c}\d"])
def test_a_unit_is_written_as_it_stands(steady, unit, tmp_path):
    steady["disk"].plot("irradiance", unit=unit, path=tmp_path / "unit.png")
    pyplot.close("all")


def test_a_logarithmic_scale_says_what_it_leaves_out():
    """Bins below it are counted, negative ones refused; where all are 0 the scale is linear."""
    x = [0.0, 1.0, 2.0, 3.0]
    axes = estimates([0.01, 0.0, 3.0], ("x",), (x,)).plot(decades=2)
    assert "not drawn: 2 of 3 bins, below the scale" in words(axes.figure)
    assert estimates([0.0, 0.0, 0.0], ("x",), (x,)).plot(decades=2).get_yscale() == "linear"
    with pytest.raises(ValueError, match="no place for -1; leave decades out"):
        estimates([-1.0, 2.0, 3.0], ("x",), (x,)).plot(decades=2)
    assert estimates([1e-300, 2e-300, 3e-300], ("x",), (x,)).plot(decades=2).get_yscale() == "log"
    pyplot.close("all")


def test_a_run_is_plotted_as_a_whole(forward, backward, steady):
    panels = forward.plot()
    titles = [each.get_title() for each in panels]
    assert titles[:-1] == ["up", "box", "ball", "cloud", "shot"]
    assert titles[-1].startswith("energy balance of 2 J")
    assert backward.plot()[-1].get_title() == "histories, traced backwards"
    assert "not drawn: floor and all (more than two axes of bins)" in panels[0].figure.get_supxlabel()
    bars = [each.get_width() for each in panels[-1].patches]
    assert sum(bars) == pytest.approx(2.0, rel=1e-9)
    assert next(each.get_title() for each in steady.plot()) == "disk"
    pyplot.close("all")


def test_a_snapshot_is_drawn_in_phase_space(forward):
    ax = forward["shot"].plot()
    ((points,),) = [each.get_lines() for each in [ax]]
    assert len(points.get_xdata()) == len(forward["shot"])
    assert "s^{-1}" in ax.get_ylabel()
    pyplot.close("all")


def section(shape, material=tp.Black(), plane="xz", **how):  # noqa: B008
    lamp = tp.Source(tp.Point(position=(0, 0, 1.5)), tp.Isotropic(power=1.0))
    scene = tp.Scene(lamp, [tp.Surface(shape, material, "shape")], tp.Detector(tp.Disk(radius=0.2), "meter"))
    ax = scene.plot(plane, **how)
    texts = [each.get_text() for each in ax.get_legend().get_texts()]
    places = [each.get_xydata() for each in ax.get_lines() if each.get_color() == "#1a1a1a"]
    pyplot.close("all")
    return texts, (places[0] if places else np.zeros((0, 2)))


@pytest.mark.parametrize(
    ("shape", "distance"),
    [
        (tp.Sphere(radius=1.0), lambda x, y: np.hypot(x, y) - 1),
        (tp.Box(size=2.0), lambda x, y: np.maximum(abs(x), abs(y)) - 1),
        (tp.Cylinder(radius=1.0, height=2.0), lambda x, y: abs(x) - 1),
        (tp.Mesh.sphere(radius=1.0), lambda x, y: np.hypot(x, y) - 1),
        (tp.Rectangle(width=2, height=2), lambda x, y: y),
    ],
    ids=["sphere", "box", "cylinder", "mesh", "flat"],
)
def test_a_section_lies_on_the_shape(shape, distance):
    texts, places = section(shape)
    assert len(places) > 300
    assert np.abs(distance(*places.T)).max() < (0.1 if isinstance(shape, tp.Mesh) else 1e-9)
    assert "Black(): shape" in texts and any("meter" in each for each in texts)


def test_what_a_section_does_not_meet_is_named():
    texts, places = section(tp.Sphere(center=(0, 3, 0), radius=0.5), at=0.0)
    assert "not in this plane: shape" in " ".join(texts) and len(places) == 0


ROOM = tp.Surface(tp.Box(center=(0, 0, 1.5), size=(6, 4, 3)), tp.Diffuse(0.7), "room")
CEILING_LAMP = tp.Source(tp.Disk(center=(0, 0, 2.9), normal=(0, 0, -1), radius=0.2), tp.Lambertian(power=1.0))


def test_a_small_detector_and_a_thin_film_are_drawn_in_the_room_about_them():
    """A diode below a thousandth of the room neither shrinks the picture to itself nor is lost in the raster."""
    film = tp.Surface(tp.Box(center=(-1, 0, 1), size=(0.5, 0.5, 1e-6)), tp.Black(), "film")
    diode = tp.Detector(tp.Disk(center=(0.5, 0, 1.0), radius=1e-3), "diode")
    ax = tp.Scene(CEILING_LAMP, [ROOM, film], diode).plot("xz")
    assert np.ptp(ax.get_xlim()) > 6
    texts = " ".join(legend_of(ax))
    assert "Black(): film" in texts and "Detector diode" in texts and "not in" not in texts
    pyplot.close("all")


@pytest.mark.parametrize("at", [0.0, 0.7, 3.0])
def test_what_lies_in_the_plane_of_a_section_is_drawn(at):
    """The area of a table at 0.7 m; at 0 and 3 m the edges of the room's floor and ceiling."""
    desk = tp.Rectangle(center=(1, 0, 0.7), normal=(0, 0, 1), width=1.2, height=0.8)
    ax = tp.Scene(CEILING_LAMP, [ROOM, tp.Surface(desk, tp.Black(), "table")]).plot("xy", at=at)
    ((right, up),) = [
        each.get_data() for each in ax.get_lines() if each.get_color() == "#1a1a1a" and each.get_zorder() == 3
    ]
    assert np.abs(np.maximum(np.abs(right) / 3, np.abs(up) / 2) - 1).max() < 1e-9
    areas = [each.get_path().get_extents().bounds for each in ax.patches]
    assert areas == ([pytest.approx((0.4, -0.4, 1.2, 0.8))] if at == 0.7 else [])
    assert ("not in this plane: table" in " ".join(legend_of(ax))) == (at != 0.7)
    pyplot.close("all")


def test_what_is_far_larger_than_a_section_is_said_not_to_be_drawn():
    earth = tp.Surface(tp.Sphere(center=(0, 0, -6.4e6), radius=6.4e6), tp.Diffuse(0.3), "earth")
    meter = tp.Detector(tp.Disk(center=(0, 0, 1.0), radius=0.2), "meter")
    lamp = tp.Source(tp.Point(position=(0, 0, 1.5)), tp.Isotropic(power=1.0))
    ax = tp.Scene(lamp, [earth], meter).plot("xz")
    assert np.ptp(ax.get_ylim()) < 10
    assert "in this plane, but not drawn: earth" in " ".join(legend_of(ax))
    pyplot.close("all")


def test_a_detector_and_a_source_in_the_plane_of_a_surface_are_seen_on_it():
    floor = tp.Surface(tp.Rectangle(width=4, height=3), tp.Diffuse(0.7), "floor")
    meter = tp.Detector(tp.Disk(center=(-1, 0, 0), radius=0.5), "meter")
    ax = tp.Scene(tp.Source("floor", tp.Lambertian(power=1.0)), floor, meter).plot("xy", at=0)
    surface, source, detector = sorted(ax.patches, key=lambda each: each.get_zorder())
    assert surface.get_facecolor()[3] == 1 and surface.get_hatch() is None
    assert {source.get_hatch(), detector.get_hatch()} == {"\\\\", "//"}
    assert source.get_facecolor()[3] == detector.get_facecolor()[3] == 0
    pyplot.close("all")


def test_a_section_through_tilted_planes_is_as_broad_as_high():
    """Nothing but their centres says how much of them is to be seen."""
    planes = [
        tp.Surface(tp.Plane(), tp.Diffuse(0.5), "flat"),
        tp.Surface(tp.Plane(center=(0, 0, -2), normal=(0.3, 0, 1)), tp.Diffuse(0.5), "tilted"),
    ]
    beam = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
    ax = tp.Scene(beam, planes).plot("xz")
    assert 0.5 < np.ptp(ax.get_xlim()) / np.ptp(ax.get_ylim()) < 2
    assert "flat and tilted" in " ".join(legend_of(ax))
    pyplot.close("all")


def test_most_of_a_cloud_is_drawn_where_the_plane_cuts_it():
    cloud = tp.Source(tp.Cloud(sigma=1.0), tp.Gas(number=1e6, speed=100.0))
    walls = tp.Surface(tp.Box(size=10.0), tp.Diffuse(0.5), "walls")
    scene = tp.Scene(cloud, walls, tp.Snapshot(1e-3, particles=10), duration=1e-2)
    (drawn,) = scene.plot("xy", at=1.0).patches
    np.testing.assert_allclose(drawn.get_path().get_extents().bounds[2:], 2 * math.sqrt(3), rtol=1e-3)
    at_rim = scene.plot("xy", at=2.5)
    assert "not in this plane: sources[0]" in " ".join(legend_of(at_rim)) and not at_rim.patches
    sheet = tp.Source(tp.Cloud(sigma=(1.0, 1.0, 0.0)), tp.Gas(number=1e6, speed=100.0))
    assert len(replace(scene, sources=sheet).plot("xy", at=0.0).patches) == 1
    pyplot.close("all")


def test_media_of_a_section_are_filled():
    glass = tp.Medium(index=1.5, absorption=1.0)
    ball = tp.Surface(tp.Sphere(radius=0.5), tp.Dielectric(1.5), "ball", inside=glass)
    lamp = tp.Source(tp.Point(position=(0, 0, 1.5)), tp.Isotropic(power=1.0))
    ax = tp.Scene(lamp, [ball]).plot("xy")
    (image,) = ax.get_images()
    share = np.mean(np.asarray(image.get_array()) == 1)
    width, height = np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())
    assert share * width * height == pytest.approx(np.pi / 4, rel=0.02)
    assert any(each.get_text().startswith("Medium(absorption=1") for each in ax.get_legend().get_texts())
    pyplot.close("all")


def legend_of(ax):
    return [each.get_text() for each in ax.get_legend().get_texts()]


def test_the_legend_of_a_section_keeps_materials_apart_and_names_media():
    """Materials that differ after many letters have a line and a colour each; numbers are written whole."""
    mixtures = [
        tp.Mixture({tp.Diffuse(0.5): 0.5, tp.Mirror(0.25): 0.25, tp.Glossy(0.3, a): 0.25}) for a in (0.1, 0.9)
    ]
    plates = [
        tp.Surface(tp.Rectangle(center=(0, 0, k), width=1, height=1), mixture, f"plate {k}")
        for k, mixture in enumerate(mixtures)
    ]
    ball = tp.Sphere(center=(0, 0, 3), radius=0.5)
    lamp = tp.Source(tp.Point(position=(0, 0, 1.5)), tp.Isotropic(power=1.0))
    for name in ("dermis", None):
        tissue = tp.Medium(absorption=50.0, scattering=15000.0, name=name)
        ax = tp.Scene(lamp, [*plates, tp.Surface(ball, tp.Transparent(), "ball", inside=tissue)]).plot("xz")
        texts = legend_of(ax)
        assert sum("Mixture" in text for text in texts) == 2
        assert ("dermis" if name else "Medium(absorption=50, scattering=15000)") in texts
        pyplot.close("all")


@pytest.mark.parametrize(("side", "sign"), [("front", 1), ("back", -1)])
def test_arrows_of_a_section_show_where_sources_emit_and_detectors_count(side, sign):
    """The source looks down; the detector up, or down with its back."""
    lamp = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.2), tp.Lambertian(power=1.0))
    meter = tp.Detector(tp.Disk(center=(0.5, 0, 0), radius=0.2), "meter", side=side)
    ax = tp.Scene(lamp, detectors=meter).plot("xz")
    rises = [each.xy[1] - each.xyann[1] for each in ax.texts if each.arrow_patch is not None]
    assert [np.sign(rise) for rise in rises] == [-1, sign]
    ax = tp.Scene(lamp, detectors=meter).plot("xy", at=0)
    assert [each for each in ax.texts if each.arrow_patch is not None] == []
    pyplot.close("all")


def test_a_plane_that_is_none_and_axes_that_are_none_are_refused():
    scene = tp.Scene(tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0)))
    with pytest.raises(tp.SceneError, match='plane must be "xy", "xz" or "yz", got \'zx\''):
        scene.plot("zx")
    with pytest.raises(tp.SceneError, match="write ax=pyplot"):
        scene.plot(ax=3)
    for at in (math.nan, math.inf, "a"):
        with pytest.raises(tp.SceneError, match="at must be a finite number"):
            scene.plot(at=at)
    with pytest.raises(tp.SceneError, match=r"must end in \.png or \.html"):
        scene.view("scene.jpg")
    with pytest.raises(tp.SceneError, match=r"plot: path must end in \.png, \.pdf or \.svg, got 'x\.jpgg'"):
        scene.plot(path="x.jpgg")


def test_without_matplotlib_a_sentence_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "transport.viz.sections", raising=False)
    scene = tp.Scene(tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0)))
    with pytest.raises(tp.SceneError, match=r"plot: matplotlib is not installed; .*\[plot\]"):
        scene.plot()


def test_files_are_plotted_by_the_command(steady, tmp_path, monkeypatch):
    from typer.testing import CliRunner

    from transport.cli.commands import app

    monkeypatch.chdir(tmp_path)
    steady.save("run.npz")
    (tmp_path / "scene.json").write_text(steady.scene.to_json())
    for options, made in (
        (["run.npz"], "out/run.png"),
        (["run.npz", "--detector", "disk", "--cut", "--out", "disk.png"], "disk.png"),
        (["scene.json", "--plane", "xy", "--at", "0.01"], "out/scene.png"),
    ):
        answer = CliRunner().invoke(app, ["plot", *options])
        assert answer.exit_code == 0, answer.output
        assert (tmp_path / made).stat().st_size > 10_000 and made in answer.output
    answer = CliRunner().invoke(app, ["plot", "run.npz", "--detector", "dsik"])
    assert answer.exit_code == 2 and "did you mean 'disk'" in answer.output
    for options, said in (
        (["run.npz", "--cut"], "add --detector NAME"),
        (["run.npz", "--decades", "0.5"], "add --detector NAME"),
        (["run.npz", "--plane", "xy"], "run.npz is a run; give a scene, .json"),
        (["scene.json", "--detector", "disk"], "scene.json is a scene; give a saved run"),
    ):
        answer = CliRunner().invoke(app, ["plot", *options])
        assert answer.exit_code == 2 and f"{options[1]} has no use here" in answer.output
        assert said in answer.output
