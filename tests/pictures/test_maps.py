"""Maps by the numbers that they show: where a bin lies, its relative error, which row a cut takes, how far a scale reaches."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

import transport as tp
from tests.drawing import WARNINGS_FAIL, assert_drawn, points_of, reading, words
from tests.synthetic import EVEN_RUN, estimates
from transport.statistics.estimates import EstimateArray
from transport.viz.directions import direction_bins
from transport.viz.maps import (
    alongs,
    bins_of,
    draw_values,
    main_quantity,
    plot_map,
    plot_maps,
    unfold,
    value_norm,
)

pytestmark = pytest.mark.filterwarnings(*WARNINGS_FAIL)  # such as a layout that collapsed

TURN = np.linspace(0, 2 * math.pi, 13)
MU = np.linspace(0, 1, 9)
RIM = math.atan(0.5)
ERRORS = "relative standard error  [%]"


def simulated(sources, detectors, surfaces=(), particles=20_000, seed=1):
    return tp.simulate(tp.Scene(sources, surfaces, detectors), particles, seed=seed, progress=False)


@pytest.fixture(scope="module")
def result():
    """A lamp over a grey floor, with a disk and a tube beside it, all with bins of place."""
    lamp = tp.Disk(center=(0.3, 0, 1), normal=(0, 0, -1), radius=0.2)
    floor = tp.Surface(tp.Rectangle(width=2.0, height=1.0), tp.Diffuse(0.5), "floor")
    disk = tp.Disk(center=(0, 0, 0.5), radius=0.5)
    tube = tp.Cylinder(center=(0, 0, 0.5), radius=0.9, height=0.5)
    meters = [
        tp.Detector("floor", positions=tp.Positions(u=8, v=4)),
        tp.Detector("floor", "rows", positions=tp.Positions(u=8)),
        tp.Detector(disk, "round", positions=tp.Positions(u=3, v=8)),
        tp.Detector(tube, "tube", side="back", positions=tp.Positions(u=4, v=6)),
    ]
    return simulated(tp.Source(lamp, tp.Lambertian(power=10.0)), meters, floor)


def drawn(data, **how):
    """The axes of a map that is drawn alone, without a layout, which takes most of the time of a figure."""
    return plot_map(data, ax=Figure().subplots(), **how)


def mesh_of(axes):
    """The cells of a round map."""
    (mesh,) = [each for each in axes.collections if isinstance(each, QuadMesh)]
    return mesh


def brightest(mesh):
    """The middle of the corners of the cells of the largest value."""
    corners = mesh.get_coordinates()
    cells = np.ma.filled(mesh.get_array().reshape(len(corners) - 1, -1), -1.0)
    rows, columns = np.nonzero(cells == cells.max())
    return corners[rows.min() : rows.max() + 2, columns.min() : columns.max() + 2].mean(axis=(0, 1))


# By place


@pytest.mark.slow
def test_a_map_shows_the_values_their_relative_errors_and_a_cut(tmp_path, result):
    path, floor = tmp_path / "new" / "map.png", result["floor"].irradiance
    exact = np.arange(32.0).reshape(8, 4)
    page = plot_map(result["floor"], path, exact=exact, cut=-0.2, title="Light", note="small print")
    assert_drawn(page, path)
    values, errors, cut = page.axes
    np.testing.assert_array_equal(values.images[0].get_array(), floor.value.T)
    np.testing.assert_allclose(values.images[0].get_extent(), (-1, 1, -0.5, 0.5))
    percent, known = errors.images[0].get_array(), np.isfinite(floor.relative_error.T)
    np.testing.assert_allclose(percent[known], 100 * floor.relative_error.T[known])
    ((x, y, bars),) = points_of(cut)
    told = np.isfinite(floor.error[:, 1])
    np.testing.assert_allclose(x, (-0.875 + 0.25 * np.arange(8))[told])
    np.testing.assert_allclose(y, floor.value[told, 1])
    np.testing.assert_allclose(bars, 2 * floor.error[told, 1])
    np.testing.assert_array_equal(cut.patches[0].get_data().values, exact[:, 1])
    said = words(page)
    for part in ("u [m]", "v [m]", "small print", ERRORS, "Light", "at v = −0.125 m"):
        assert part in said, part
    assert r"irradiance  [$\mathrm{W\,m^{-2}}$]" in said


def test_a_map_and_its_cut_are_logarithmic_together(result):
    values, _, cut = plot_map(result["floor"], decades=2, cut=True).axes
    norm, (low, high) = values.images[0].norm, cut.get_ylim()
    assert cut.get_yscale() == "log"
    assert cut.get_ylabel().count("[") == 1  # the unit once
    assert low == norm.vmin and high >= norm.vmax == 100 * low


def test_a_disk_is_drawn_round_and_cut_from_rim_to_rim(result):
    page, round_one = plot_map(result["round"], cut=2), result["round"].irradiance
    mesh = mesh_of(page.axes[0])
    assert np.hypot(*mesh.get_coordinates().reshape(-1, 2).T).max() == pytest.approx(0.5)
    np.testing.assert_allclose(mesh.get_array().reshape(-1, 3)[::30], round_one.value.T)
    (ahead, value, _), (behind, opposite, _) = points_of(page.axes[2])
    assert (ahead > 0).all() and (behind < 0).all()
    np.testing.assert_allclose(value, round_one.value[:, 2])
    np.testing.assert_allclose(opposite, round_one.value[:, 6])


def test_a_disk_is_drawn_from_e_u_towards_e_v():
    values = np.ones((3, 8))
    values[1, 2] = 9.0
    array = estimates(values, ("u", "v"), ([0, 1, 2, 3], np.linspace(0, 2 * math.pi, 9)))
    mesh = mesh_of(drawn(reading(array, tp.Disk(radius=3.0)), quantity="glow"))
    x, y = brightest(mesh)
    assert math.atan2(y, x) == pytest.approx(math.radians(112.5), abs=0.02) and 1.4 < math.hypot(x, y) < 1.6


def spots(bright, shape=None, error=0.02):
    """4 by 5 bins of value 1 with this relative error, but for some: {(u, v): (value, relative error)}."""
    values, errors = np.ones((4, 5)), np.full((4, 5), error)
    for place, (value, relative) in bright.items():
        values[place], errors[place] = value, relative
    edges = (np.arange(5.0), np.arange(6.0) if shape is None else np.linspace(0, 2 * math.pi, 6))
    array = estimates(values, ("u", "v"), edges, relative=errors, counts=np.full((4, 5), 320))
    return reading(array, shape or tp.Rectangle(width=4, height=5))


@pytest.mark.parametrize(
    ("bright", "error", "row"),
    [
        pytest.param({(2, 4): (9.0, 0.02)}, 0.02, 4, id="above"),
        pytest.param({(2, 0): (9.0, 0.02)}, 0.02, 0, id="below"),
        pytest.param({(2, 4): (math.nan, 0.02), (1, 3): (2.0, 0.02)}, 0.02, 3, id="beside one that is not known"),
        pytest.param({(2, 0): (2.0, 0.02), (1, 3): (2.0, 0.02)}, 0.02, 3, id="of two the one nearer the middle"),
        pytest.param({}, 0.02, 2, id="nowhere"),
        pytest.param({(0, 1): (9.0, 0.02)} | {(u, 3): (2.0, 0.02) for u in range(4)}, 0.02, 1, id="a small spot"),
        pytest.param({(0, 4): (9.0, 0.95), (1, 1): (2.0, 0.02)}, 0.02, 1, id="beside a single large score"),
        pytest.param(
            {(0, 1): (9.0, 0.1)} | {(u, 3): (8.5, 0.1) for u in range(4)}, 0.02, 3, id="a structure in noise"
        ),
        pytest.param({(2, 4): (9.0, 0.0)}, 0.0, 4, id="without any known error"),
    ],
)  # fmt: skip
def test_a_cut_runs_through_the_brightest_spot_and_is_marked(bright, error, row):
    axes = drawn(spots(bright, error=error), quantity="irradiance", cut=True)
    np.testing.assert_allclose(axes.lines[0].get_ydata(), row + 0.5)


def test_a_cut_of_what_is_negative_runs_through_its_greatest_amount():
    """A net flux that all leaves is brightest where it is farthest from 0."""
    value = -np.array([[1.0, 1.0], [1.0, 9.0], [1.0, 1.0], [0.1, 0.1]])
    net = estimates(value, ("x", "y"), ([0, 1, 2, 3, 4], [0, 1, 2]))
    axes = drawn(net, cut=True)
    (place,) = set(np.ravel(axes.lines[0].get_ydata()))
    assert place == 1.5


@pytest.mark.parametrize(
    ("bright", "sector"),
    [({(2, 3): (9.0, 0.02)}, 3), ({}, 0), ({(0, 2): (9.0, 0.95), (3, 1): (2.0, 0.02)}, 1)],
)
def test_a_cut_of_a_disk_starts_in_the_brightest_sector(bright, sector):
    (x, y) = drawn(spots(bright, tp.Disk(radius=4.0)), quantity="E", cut=True).lines[0].get_data()
    assert math.degrees(math.atan2(y[-1], x[-1])) % 360 == pytest.approx(72 * sector + 36)


def test_a_tube_is_unrolled_with_its_azimuth_across_in_degrees(result):
    bins = bins_of(result["tube"], "irradiance")
    assert [bins.across.unit, bins.up.unit] == ["°", "m"]
    np.testing.assert_allclose(bins.across.edges, np.linspace(0, 360, 7))
    np.testing.assert_array_equal(bins.value, result["tube"].irradiance.value)


def test_bins_along_one_coordinate_are_a_curve(result):
    (axes,) = plot_map(result["rows"]).axes
    np.testing.assert_allclose(points_of(axes)[0][1], result["rows"].irradiance.value)


def square(values=((1.0, 1.0), (1.0, 1.0)), dims=("x", "y"), **options):
    """Two by two bins of width 1."""
    return estimates(values, dims, ([0, 1, 2], [0, 1, 2]), **options)


def cells(*shape, dims=("x", "y", "z")):
    """Cells whose values are their numbers."""
    values = 1.0 + np.arange(math.prod(shape)).reshape(shape)
    return estimates(values, dims, [np.linspace(0, 1, n + 1) for n in shape], relative=0.01)


@pytest.mark.parametrize(
    ("shape", "at", "taken"),
    [
        ((3, 4, 5), {}, np.s_[:, :, 2]),
        ((3, 4, 5), {"y": 1}, np.s_[:, 1, :]),
        ((3, 1, 5), {}, np.s_[:, 0, :]),
    ],
)
def test_of_cells_in_space_one_layer_is_drawn(shape, at, taken):
    array = cells(*shape)
    np.testing.assert_allclose(bins_of(array, at=at).value, array.value[taken].T)


@pytest.mark.parametrize(
    ("draw", "message"),
    [
        (lambda result: plot_map(result["floor"], quantity="flux_in"), "has no bins"),
        (lambda result: plot_map(result["floor"], exact=np.zeros(3)), r"bins \(8, 4\)"),
        (lambda result: plot_map(result["floor"], at={"z": 1}), r"no axes \['z'\]"),
        (lambda result: plot_map(result["floor"], at={"u": 1, "v": 1}), "leave an axis out"),
        (lambda result: plot_map(result["floor"], cut=0.7), "cut must be -0.5 to 0.5"),
        (lambda result: plot_map(cells(2, 3, 4, dims=("mu", "u", "v"))), r"write at=\{'mu': 0\}"),
        (lambda result: plot_maps({}), "at least one panel"),
        (lambda result: plot_map(square([[-3.0, 1.0]] * 2), decades=2), "no place for -3; leave decades out"),
        (lambda result: plot_map(seen(disk, phi=np.arange(3.0)), cut=3.0), "cut must be 0 to 2"),
        (lambda result: direction_bins(square(dims=("u", "v"))), "mu or theta"),
        (lambda result: direction_bins(estimates(np.ones(2), ("mu",), ([-1, 0, 1],))), "one hemisphere"),
    ],
)
def test_data_that_cannot_be_drawn_are_refused_with_the_cure(result, draw, message):
    with pytest.raises(ValueError, match=message):
        draw(result)


# Scales, instants, and figures of one's own


def test_a_scale_of_decades_begins_so_far_below_the_greatest_and_hatches_what_has_no_score():
    array = square([[0.0, 0.5], [1e3, 20.0]], relative=0.01)
    norm = value_norm(bins_of(array), 2.0)
    assert (norm.vmin, norm.vmax) == pytest.approx((10.0, 1e3), rel=1e-9)
    field = drawn(array, decades=2).images[0].get_array()
    np.testing.assert_allclose(np.ma.filled(field, -1), [[-1, 1e3], [norm.vmin, 20.0]])
    assert value_norm(bins_of(square(np.zeros((2, 2)))), 2.0).vmax == 1.0


def test_errors_are_drawn_over_two_decades_at_the_most():
    relative = np.array([[1e-6, 0.02], [0.5, 3.0]])
    norm = plot_map(square(relative=relative)).axes[1].images[0].norm
    assert isinstance(norm, LogNorm) and (norm.vmin, norm.vmax) == pytest.approx((1.0, 100.0))


def clouds(dims=("time", "x", "vx"), scale=1):
    """Counts over phase space at three instants, with a corner that nothing comes to."""
    shape = tuple({"time": 3, "x": 5, "vx": 4}[name] for name in dims)
    counts = scale * np.random.default_rng(5).poisson(4.0, size=(32, *shape))
    counts[..., 0] = 0
    coords = {name: np.linspace(-1, 1, n + 1) for name, n in zip(dims, shape, strict=True)}
    coords |= {"time": np.array([0.0, 1.0, 8.0])} if "time" in dims else {}
    return EstimateArray(counts, EVEN_RUN, "m^-2 s", dims, coords, counts=counts.sum(axis=0))


@pytest.mark.slow
@pytest.mark.parametrize("decades", [None, 2.0])
def test_instants_are_columns_of_maps_above_their_errors_on_one_scale(tmp_path, decades):
    density = clouds()
    page = plot_map(density, tmp_path / "a.png", decades=decades, label="density")
    assert_drawn(page, tmp_path / "a.png")
    upper, lower = np.array(page.axes[:6]).reshape(2, 3)
    assert len({axes.images[0].norm for axes in upper}) == 1
    for time in range(3):
        above, below = upper[time].images[0].get_array(), lower[time].images[0].get_array()
        np.testing.assert_array_equal(np.ma.filled(above, 0)[1:], density[time].value.T[1:])
        np.testing.assert_allclose(below[1:], 100 * density[time].relative_error.T[1:])
        assert np.ma.getmaskarray(below)[0].all()
        assert np.ma.getmaskarray(above)[0].all() == (decades is not None)
    said = words(page)
    assert {"t = 0 s", "t = 8 s", "no score", ERRORS, "x [m]"} <= set(said.splitlines())
    assert r"density  [$\mathrm{s\,m^{-2}}$]" in said and r"velocity vₓ [$\mathrm{m\,s^{-1}}$]" in said


def test_instants_beside_one_axis_stand_apart_by_their_names_and_alone_at_their_times():
    axes = plot_map(clouds(("time", "x"))).axes[0]
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["t = 0 s", "t = 1 s", "t = 8 s"]
    np.testing.assert_allclose(axes.get_xlim(), (-0.5, 2.5))  # 1 s and 8 s are neighbours
    assert "time" not in axes.get_xlabel()
    (line,) = plot_map(clouds(("time", "x")).sum("x")).axes
    assert list(points_of(line)[0][0]) == [0.0, 1.0, 8.0] and not line.patches


def test_media_are_named_and_no_numbers_on_a_line():
    paths = estimates([1.0, 2.0], ("medium",), ([0.0, 1.0],), "m")
    (axes,) = plot_map(paths).axes
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["medium 0", "medium 1"]


@pytest.mark.slow
def test_labels_of_a_narrow_map_do_not_overlap():
    array = cells(6, 60, dims=("r", "z"))
    array = estimates(
        array.value, ("r", "z"), (np.linspace(0, 0.1, 7), np.linspace(-0.2, 0.18, 61)), relative=0.02
    )
    page = plot_map(array, cut=True)
    page.draw_without_rendering()
    for axes in page.axes[:2]:
        low, high = axes.get_xlim()
        shown = [label for label in axes.get_xticklabels() if low <= label.get_position()[0] <= high]
        boxes = sorted((label.get_window_extent() for label in shown), key=lambda box: box.x0)
        assert len(boxes) >= 2
        assert all(left.x1 < right.x0 for left, right in zip(boxes, boxes[1:], strict=False))


def test_a_map_alone_hatches_doubtful_bins_and_writes_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    array, axes = square(), Figure().subplots()
    assert plot_map(array, ax=axes, bar=False) is axes
    assert not axes.child_axes and not axes.patches and not list(tmp_path.iterdir())
    bins = replace(bins_of(array), doubtful=np.array([[False, True], [False, False]]))
    draw_values(axes, bins, value_norm(bins), is_alone=True)
    (hatched,) = axes.patches
    assert hatched.get_hatch()
    np.testing.assert_array_equal(hatched.get_path().vertices[:, 0].mean(), 1.4)  # of 1, 2, 2, 1, 1


# By direction


def disk(theta, phi=0.0):
    """Radiance of a disk of half its distance's radius, seen from its axis."""
    return np.where(theta < RIM, 100.0, 0.0)


def lobe(theta, phi):
    """A smooth radiance that depends on both angles."""
    return 1 + np.exp(-8 * (1 - np.cos(theta) * 0.8 - 0.6 * np.sin(theta) * np.cos(phi)))


def seen(law, polar="mu", edges=MU, phi=TURN, seed=1):
    """What a detector with these bins would count of an exact radiance, with the noise of its counts."""
    coords, shape = {polar: edges, "phi": phi}, (32, len(edges) - 1, len(phi) - 1)
    bins = direction_bins(EstimateArray(np.zeros(shape), EVEN_RUN, "1", (polar, "phi"), coords))
    means = np.stack([bins.expected(law, column) for column in range(len(phi) - 1)], axis=1)
    means = means[::-1] if polar == "mu" else means
    counts = np.random.default_rng(seed).poisson(np.broadcast_to(means, shape))
    unit = "W m^-2 sr^-1"
    return EstimateArray(counts, EVEN_RUN, unit, (polar, "phi"), coords, counts=counts.sum(axis=0))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("polar", "edges", "law"),
    [
        pytest.param("mu", MU, lobe, id="lobe by mu"),
        pytest.param("theta", np.linspace(0, math.pi / 2, 10), disk, id="disk by theta"),
        pytest.param("theta", np.linspace(0, 1.2 * RIM, 7), disk, id="disk in a cone"),
    ],
)
def test_a_plan_of_directions_is_drawn_with_units(tmp_path, polar, edges, law):
    path, L = tmp_path / "map.png", seen(law, polar, edges)
    page = plot_map(
        L, path, label="radiance L", exact=law, cut=0.0, title="Law", note="384 particles, seed 1"
    )
    assert_drawn(page, path)
    said = words(page)
    for part in (
        r"\mathrm{W\,m^{-2}\,sr^{-1}}", ERRORS, "[°]", "Law", "384 particles, seed 1", "φ = 0° to 30°", "exact, bin mean",
    ):  # fmt: skip
        assert part in said, part
    assert ("no score" in said) == np.isnan(L.error).any()
    if edges[-1] > 1.5 or polar == "mu":
        assert {"30°", "60°", "θ = 90°", "seen from\nθ = 0"} <= {
            text.get_text() for text in page.axes[0].texts
        }


@pytest.mark.quick_cases("not a number")
@pytest.mark.parametrize("gap", ["nothing scored", "one batch scored", "not a number", "exact", "no noise"])
def test_a_map_survives_bins_without_a_value_or_an_error(gap):
    values = np.random.default_rng(3).poisson(5.0, size=(32, 8, 12)).astype(float)
    if gap == "nothing scored":
        values[...] = 0
    elif gap == "one batch scored":
        values[1:, 3] = 0
    elif gap == "not a number":
        values[:, 2, 4], values[:, 7] = np.nan, np.nan
    elif gap == "no noise":
        values[...] = 2.0
    coords = {"mu": MU, "phi": TURN}
    L = EstimateArray(values, EVEN_RUN, "W m^-2 sr^-1", ("mu", "phi"), coords, exact=gap == "exact")
    assert_drawn(plot_map(L, exact=lobe, cut=True))


def test_a_plan_has_each_direction_in_its_place_and_both_halves_of_its_cut():
    """Brightest at theta 30 to 60, phi 120 to 180 degrees: up and to the left; the cut through it goes on at 300 degrees."""
    values = np.arange(1.0, 19.0).reshape(3, 6)
    values[1, 2], values[2, 4] = 1000.0, 0.0
    L = estimates(values, ("theta", "phi"), (np.linspace(0, math.pi / 2, 4), np.linspace(0, 2 * math.pi, 7)))
    exact = lambda theta, phi: np.where(phi < math.pi, 1000.0, 10.0)  # noqa: E731
    values_map, _, cut = plot_map(L, exact=exact, cut=math.radians(150), decades=2).axes
    mesh = mesh_of(values_map)
    x, y = brightest(mesh)
    assert math.degrees(math.atan2(y, x)) == pytest.approx(150, abs=1) and 40 < math.hypot(x, y) < 46
    assert (mesh.norm.vmin, mesh.norm.vmax) == pytest.approx((10.0, 1000.0))
    assert np.ma.getmaskarray(mesh.get_array()).any()  # nothing was counted there: hatched, not dark
    (here, value, bars), (there, opposite, _) = points_of(cut)
    assert (here > 0).all() and (there < 0).all()
    np.testing.assert_allclose(value, values[:, 2])
    np.testing.assert_allclose(bars, 2 * L.error[:, 2])
    np.testing.assert_allclose(opposite, values[:, 5])
    lines = {
        float(np.sign(line.get_xdata()[-1])): line.get_ydata()[-1]
        for line in cut.lines
        if len(line.get_xdata()) > 9
    }
    assert lines == {1.0: 1000.0, -1.0: 10.0}


def test_a_plan_without_azimuth_or_with_axes_exchanged_is_drawn():
    page = plot_map(seen(disk, phi=TURN[[0, -1]]), exact=disk, frame="plan", cut=True)
    assert "all azimuths" in words(page)
    turned = seen(lobe)
    coords = {"phi": TURN, "mu": MU}
    turned = EstimateArray(turned.values.transpose(0, 2, 1), EVEN_RUN, turned.unit, ("phi", "mu"), coords)
    np.testing.assert_allclose(direction_bins(turned).value, direction_bins(seen(lobe)).value)
    np.testing.assert_allclose(bins_of(turned).value, bins_of(seen(lobe)).value)


def test_a_bin_across_a_rim_holds_its_share_of_projected_solid_angle():
    bins = direction_bins(seen(disk))
    expected, squares = bins.expected(disk, 0), np.sin(bins.theta) ** 2
    share = np.clip((math.sin(RIM) ** 2 - squares[:-1]) / np.diff(squares), 0, 1)
    np.testing.assert_allclose(expected, 100 * share, atol=100 / 512)
    # Shares of angle, without the cosine, are another law that this would catch.
    wrong = np.clip((RIM - bins.theta[:-1]) / np.diff(bins.theta), 0, 1)
    assert np.abs(expected - 100 * wrong).max() > 1


@pytest.mark.parametrize(("azimuth", "row"), [(0.0, 0), (0.6, 1), (math.pi, 6), (-0.1, 11), (2 * math.pi, 0)])
def test_an_azimuth_finds_its_bin_across_the_full_turn(azimuth, row):
    bins = seen(lobe)
    marker = drawn(bins, cut=azimuth).lines
    ends = next(line for line in marker if line.get_linestyle() == "--" and len(line.get_xdata()) == 2)
    angle = math.degrees(math.atan2(ends.get_ydata()[1], ends.get_xdata()[1]))
    assert angle % 360 == pytest.approx(30 * row + 15)


# Instruments, and on which side a lamp is


def sight(dark=False):
    """An image of 6 by 8 pixels, to one of which nothing came."""
    counts = np.random.default_rng(8).poisson(9.0, size=(32, 6, 8)).astype(float)
    counts[:, 2, 3] = 0
    coords = {"v": np.linspace(-0.3, 0.3, 7), "u": np.linspace(-0.4, 0.4, 9)}
    return EstimateArray(
        counts * (not dark), EVEN_RUN, "W m^-2 sr^-1", ("v", "u"), coords, counts=counts.sum(axis=0)
    )


def test_a_picture_is_dark_where_nothing_came_from_and_stands_beside_its_errors():
    image = sight()
    left, right = (axes.images[0].get_array() for axes in plot_map(image, decades=2).axes)
    lit = image.value > 0
    np.testing.assert_allclose(left[lit], image.value[lit])
    assert not np.ma.getmaskarray(left).any() and left[~lit] == left.min()
    np.testing.assert_allclose(right[lit], 100 * image.relative_error[lit])
    assert np.ma.getmaskarray(right)[~lit].all()
    assert_drawn(plot_map(sight(dark=True), decades=2))


def test_a_map_of_all_directions_has_the_zenith_on_top_and_bins_as_wide_as_they_are():
    values = np.ones((2, 3))
    values[0, 1] = 5.0
    L = estimates(values, ("theta", "phi"), ([0.0, 0.5, math.pi], [0.0, 4.0, 5.0, 2 * math.pi]))
    axes = drawn(L, decades=2)
    (image,) = axes.images
    x, y = image._Ax, image._Ay  # edges of an image with unlike bins
    np.testing.assert_allclose((x[1:3].mean(), y[:2].mean()), np.degrees([4.5, 0.25]))
    np.testing.assert_allclose(axes.get_ylim(), (180, 0))
    assert axes.xaxis_inverted()


def test_a_lamp_is_on_the_same_side_of_a_map_as_of_the_cameras_picture():
    """At (2, 2, 0), seen from the origin along +y: to the right of the middle, and of the azimuth of +y."""
    lamp = tp.Source(tp.Sphere(center=(2, 2, 0), radius=0.4), tp.Lambertian(radiance=3.0))
    here = {"position": (0, 0, 0)}
    camera = tp.Camera(name="view", direction=(0, 1, 0), field_of_view=2.0, pixels=(24, 16), **here)
    around = tp.EnvironmentMap(name="around", theta=18, phi=32, **here)
    for instrument, ahead in ((camera, 0.0), (around, 90.0)):
        found = simulated([lamp], [instrument], particles=50_000, seed=2)[instrument.name]
        axes, bins = drawn(found, decades=2), bins_of(found)
        place = bins.across.middles[bins.value.max(axis=0) == bins.value.max()].mean()
        x, middle = axes.transData.transform([(place, 0), (ahead, 0)])[:, 0]
        assert x > middle + 1, f"{instrument.name}: {x:.0f} against {middle:.0f}"


def test_a_lamp_at_the_side_of_u_is_on_the_right_of_a_floors_plans_by_place_and_by_direction():
    """Both are seen from in front, so that they can stand side by side."""
    lamp = tp.Source(tp.Sphere(center=(1, 0, 1), radius=0.2), tp.Lambertian(radiance=3.0))
    meters = [
        tp.Detector(tp.Rectangle(width=2.0, height=2.0), "places", positions=tp.Positions(u=8, v=8)),
        tp.Detector(tp.Disk(radius=0.2), "directions", directions=tp.Directions(theta=9, phi=16)),
    ]
    found = simulated([lamp], meters, particles=50_000, seed=3)
    by_place = drawn(found["places"]).images[0].get_array().mean(axis=0)
    assert by_place.argmax() > 5
    mesh = mesh_of(drawn(found["directions"], quantity="radiance"))
    assert brightest(mesh)[0] > 20


BOTH, TUBE = tp.Positions(u=3, v=4), {"radius": 0.5, "height": 1.0}
METER, CELLS, WAYS, SPHERE = tp.Detector, tp.VolumeDetector, tp.Directions, tp.Directions.sphere
ROUND, ALONG = "azimuth v [°]", "height u along the axis [m]"
LABELS = {  # detector, and what its map calls its axes, in their order
    "rectangle": (METER(tp.Rectangle(width=2, height=1), "d", positions=BOTH), ["u [m]", "v [m]"]),
    "disk": (METER(tp.Disk(radius=1), "d", positions=BOTH), ["radius u [m]", ROUND]),
    "sphere": (METER(tp.Sphere(radius=1), "d", positions=BOTH), ["polar angle u [°]", ROUND]),
    "cylinder": (METER(tp.Cylinder(**TUBE), "d", positions=BOTH), [ALONG, ROUND]),
    "cone": (METER(tp.Cone(**TUBE), "d", positions=BOTH), [ALONG, ROUND]),
    "directions": (
        METER(tp.Disk(radius=1), "d", directions=WAYS(theta=3, phi=4)),
        ["polar angle θ [°]", "azimuth φ [°]"],
    ),
    "flights": (
        CELLS(tp.Sphere(radius=1), "d", directions=SPHERE(mu=3, phi=4)), ["cosine μ", "azimuth φ [°]"]
    ),
    "cells": (CELLS(tp.Box(size=1.0), "d", cells=(3, 4, 1)), ["x [m]", "y [m]", "z [m]"]),
    "rings": (CELLS(tp.Cylinder(**TUBE), "d", cells=(3, 4)), ["r [m]", "z [m]"]),
}  # fmt: skip


@pytest.mark.parametrize(("detector", "labels"), LABELS.values(), ids=LABELS)
def test_axes_are_called_by_what_they_are_on_their_shape(detector, labels):
    lamp = tp.Source(tp.Point(position=(0, 0, 3)), tp.Isotropic(power=1.0))
    found = simulated([lamp], [detector], particles=100)["d"]
    shape = found.shape if isinstance(detector, tp.Detector) else None
    array = found.named("radiance" if detector.directions is not None else main_quantity(found))
    assert [each.label for each in alongs(array, shape)] == labels


HEMISPHERE, ALL = (0.0, 0.7, 1.5), (0.0, 1.5, math.pi)  # polar angles [rad]
ABOVE, TURNS = (0.0, 0.5, 1.0), 8  # cosines, bins of azimuth
FLOOR, BALL = tp.Rectangle(width=2.0, height=2.0), tp.Sphere(radius=0.3)
IN_FRONT, FROM_Z, FROM_POLE = "seen from\nin front", "seen from\n+z", "seen from\nθ = 0"
INSIDE, NONE = ", seen from inside", ""


def of_side(shape=FLOOR, side="front", **bins):
    return METER(shape, "d", side, directions=WAYS(**bins))


def of_world(**bins):
    return METER(BALL, "d", directions=WAYS(frame="world", phi=TURNS, **bins))


def of_flights(**bins):
    return CELLS(BALL, "d", directions=SPHERE(phi=TURNS, **bins))


def of_places(**bins):
    return METER(FLOOR, "d", positions=tp.Positions(**bins))


def of_sky(theta):
    return tp.EnvironmentMap(name="d", position=(0, 0, 0.5), theta=theta, phi=TURNS)


MIXED = METER(FLOOR, "d", positions=tp.Positions(x=3), directions=WAYS(phi=TURNS))
DISK = METER(tp.Disk(radius=1), "d", positions=tp.Positions(radius=3, azimuth=4))
CAMERA = tp.Camera(
    name="d", position=(0, 0, 0.5), direction=(0, 1, 1), field_of_view=1.0, pixels=(4, 3)
)  # fmt: skip
SEEN_FROM = {  # detector, and frame of the map: where the map claims to be seen from
    "a side": (of_side(theta=HEMISPHERE, phi=TURNS), None, IN_FRONT),
    "a side by mu": (of_side(mu=3, phi=TURNS), None, IN_FRONT),
    "a back": (of_side(side="back", theta=3, phi=TURNS), None, IN_FRONT),
    "a curved side": (of_side(BALL, theta=3, phi=TURNS), None, IN_FRONT),
    "a side, without azimuth": (of_side(theta=3), "plan", NONE),
    "a side as a sky": (of_side(theta=3, phi=TURNS), "sky", INSIDE),
    "the world above": (of_world(theta=HEMISPHERE), None, FROM_Z),
    "the world above by mu": (of_world(mu=ABOVE), None, FROM_Z),
    "the world": (of_world(theta=ALL), None, INSIDE),
    "the world by mu": (of_world(mu=4), None, NONE),
    "the world, flat": (of_world(theta=ALL), "flat", NONE),
    "flights": (of_flights(mu=4), None, NONE),
    "flights as a sky": (of_flights(mu=4), "sky", INSIDE),
    "flights upwards": (of_flights(mu=ABOVE), None, FROM_POLE),
    "flights along x": (of_flights(mu=ABOVE, axis=(1, 0, 0)), None, FROM_POLE),
    "places": (of_places(x=3, y=4), None, NONE),
    "places as a sky": (of_places(x=3, y=4), "sky", NONE),
    "a disk": (DISK, None, NONE),
    "places and azimuths as a sky": (MIXED, "sky", NONE),
    "cells": (CELLS(tp.Box(size=1.0), "d", cells=(3, 4, 1)), None, NONE),
    "a map of all directions": (of_sky(4), None, INSIDE),
    "a map of all directions above": (of_sky(HEMISPHERE), "plan", FROM_POLE),
    "a camera": (CAMERA, None, NONE),
}


@pytest.mark.parametrize(("detector", "frame", "claim"), SEEN_FROM.values(), ids=SEEN_FROM)
def test_a_map_claims_to_be_seen_from_where_it_is_or_from_nowhere(detector, frame, claim):
    lamp = tp.Source(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1.0), tp.Lambertian(radiance=1.0))
    found = simulated([lamp], [detector], particles=500)["d"]
    has_directions = getattr(detector, "directions", None) is not None
    axes = drawn(found, frame=frame, **({"quantity": "radiance"} if has_directions else {}))
    said = [axes.get_xlabel(), axes.get_ylabel(), *(text.get_text() for text in axes.texts)]
    claims = [
        each[each.index(word) :] for each in said for word in (", seen from", "seen from\n") if word in each
    ]
    assert claims == ([claim] if claim else [])
    assert axes.xaxis_inverted() == (claim == ", seen from inside")


def test_an_array_by_direction_claims_no_frame():
    """It does not know whether its directions are those of a side or of the world."""
    bins = tp.Directions(theta=HEMISPHERE, phi=TURNS, frame="world")
    lamp = tp.Source(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=1.0), tp.Lambertian(radiance=1.0))
    array = simulated([lamp], [tp.Detector(BALL, "d", directions=bins)], particles=500)["d"].radiance
    assert "seen from\nθ = 0" in [text.get_text() for text in drawn(array).texts]


def test_a_lamp_above_a_ball_lights_the_top_of_its_map():
    """The ball is seen from outside: the pole is on top and azimuth grows to the right."""
    lamp = tp.Source(tp.Disk(center=(0, 0, 3), normal=(0, 0, -1), radius=0.5), tp.Lambertian(power=1.0))
    ball = tp.Detector(tp.Sphere(radius=1.0), "ball", positions=tp.Positions(u=6, v=8))
    axes = drawn(simulated([lamp], [ball], particles=50_000, seed=4)["ball"], quantity="irradiance")
    pole, floor = axes.transData.transform([(0, 0), (0, 180)])[:, 1]
    assert pole > floor
    assert axes.get_xlim()[0] < axes.get_xlim()[1]


def test_a_cut_shows_doubtful_bins_hollow():
    values, edges = np.random.default_rng(4).normal(10.0, 1.0, (32, 20, 20)), np.linspace(0, 1, 21)
    values[7, 5, 6] += 1000  # one batch is far above all others
    array = EstimateArray(values, EVEN_RUN, "W", ("x", "y"), {"x": edges, "y": edges})
    doubtful = np.flatnonzero(array.is_doubtful[:, 6])
    assert 5 in doubtful and len(doubtful) < 10
    cut = plot_map(array, cut=edges[6] + 0.01).axes[2]
    (hollow,) = [line for line in cut.lines if line.get_label() == "error unknown or doubtful"]
    np.testing.assert_allclose(hollow.get_xdata(), edges[doubtful] + 0.025)


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"unit": "W"}, "the same unit, W m\\^-2, got W in 'b'"),
        ({"edges": (np.linspace(0, 1e-3, 5), np.linspace(0, 1e-3, 4))}, "the same axes"),
    ],
    ids=["unit", "axes"],
)
def test_maps_of_unlike_units_or_axes_are_refused(other, said):
    edges = np.linspace(0, 1, 5), np.linspace(0, 1, 4)
    one = estimates(np.ones((4, 3)), ("x", "y"), edges, unit="W m^-2")
    another = estimates(
        np.ones((4, 3)), ("x", "y"), other.get("edges", edges), unit=other.get("unit", "W m^-2")
    )
    with pytest.raises(ValueError, match=said):
        plot_maps({"a": one, "b": another})


def test_close_instants_have_their_own_maps():
    times = np.array([10.0001, 10.0002, 10.0003])
    array = estimates(
        np.ones((3, 4, 4)), ("time", "x", "y"), (times, np.linspace(0, 1, 5), np.linspace(0, 1, 5))
    )
    page = plot_map(array)
    assert [axes.get_title() for axes in page.axes[:3]] == ["t = 10.0001 s", "t = 10.0002 s", "t = 10.0003 s"]


def test_what_belongs_to_a_new_figure_is_refused_in_given_axes(result):
    axes = Figure().subplots()
    with pytest.raises(ValueError, match="path, title and note are of a new figure"):
        plot_map(result["floor"], "floor.png", ax=axes)
    with pytest.raises(ValueError, match="ax must be one to three Axes"):
        plot_map(result["floor"], ax=Figure().subplots(2, 2))
    with pytest.raises(
        ValueError,
        match="frame must be one of flat, disk, plan, sky, image, round image, cylinder, cube, got 'round'",
    ):
        plot_map(result["floor"], frame="round")
    with pytest.raises(ValueError, match="a Tally or EstimateArray is drawn, got Result"):
        plot_map(result)


@pytest.mark.parametrize(("shape", "is_inverted"), [
    (tp.Sphere(radius=1.0), True), (tp.Cylinder(radius=1.0, height=2.0), False),
    (tp.Rectangle(width=1.0, height=1.0), False),
])  # fmt: skip
def test_a_map_of_a_ball_has_its_pole_on_top(shape, is_inverted):
    """Polar angles grow downwards; heights and lengths upwards."""
    lamp = tp.Source(tp.Point(position=(0, 0, 3)), tp.Isotropic(power=1.0))
    meter = tp.Detector(shape, "meter", positions=tp.Positions(u=3, v=4))
    result = tp.simulate(tp.Scene(lamp, detectors=meter), 1000, seed=1, progress=False)
    axes = plot_map(result["meter"]).axes[0]
    assert axes.yaxis_inverted() == is_inverted


# All directions in other projections


PICTURED = {  # the height of the picture over its width
    "latitude-longitude": 0.5, "cylinder": 1 / math.pi, "cube": 0.75, "fisheye": 1.0, "equal-area fisheye": 1.0,
    "mirrored ball": 1.0,
}  # fmt: skip


@pytest.fixture(scope="module")
def all_directions():
    """A white sphere with a black lid above, in all projections, and cameras with other lenses."""
    top = tp.Surface(tp.Sphere(radius=1.0, mu_min=0.5), tp.Black(), "top")
    rest = tp.Surface(tp.Sphere(radius=1.0, mu_max=0.5), tp.Black(), "rest")
    lamps = [
        tp.Source(name, tp.Lambertian(radiance=radiance), side="back")
        for name, radiance in (("top", 1.0), ("rest", 5.0))
    ]
    place = {"position": (0, 0, 0)}
    sensors = [
        tp.EnvironmentMap(name=projection, projection=projection, **place, **size)
        for projection in PICTURED
        for size in [
            {"theta": 8, "phi": 16} if projection in ("latitude-longitude", "cylinder") else {"pixels": 8}
        ]
    ]
    lenses = {
        "whole": {"lens": "fisheye", "field_of_view": 2 * math.pi}, "half": {"lens": "fisheye"},
        "equal": {"lens": "equal-area fisheye", "field_of_view": 2 * math.pi},
        "parallel": {"lens": "orthographic", "width": 0.5}, "pinhole": {},
    }  # fmt: skip
    sensors += [
        tp.Camera(name=name, direction=(0, 1, 0), pixels=(8, 8), **place, **lens)
        for name, lens in lenses.items()
    ]
    scene = tp.Scene(lamps, [top, rest], sensors)
    return tp.simulate(scene, 200_000, seed=1, estimator="backward", progress=False)


@pytest.mark.parametrize("name", [*PICTURED, "whole", "half", "equal", "parallel", "pinhole"])
def test_each_projection_and_lens_is_drawn_by_itself(all_directions, name):
    """Pixels beyond a rim are blank, in the map of errors too, and nothing is called a tangent."""
    reading = all_directions[name]
    bins = bins_of(reading)
    page = plot_map(reading)
    assert not re.search(r"\btan", words(page))
    assert bins.stretch == pytest.approx(PICTURED.get(name, 1.0), rel=0.01)
    assert bins.is_to_scale
    drawn_cells = np.isfinite(bins.value).sum()
    angles = None if name == "parallel" else reading.detector.solid_angles()
    assert drawn_cells == (64 if angles is None else np.count_nonzero(angles))
    has_rim = name in ("fisheye", "equal-area fisheye", "mirrored ball", "whole", "equal")
    assert (bins.frame == "round image") == has_rim
    field = page.axes[0].images[-1] if page.axes[0].images else page.axes[0].collections[-1]
    assert (field.get_clip_path() is not None and drawn_cells < 64) == has_rim
    for label in (page.axes[0].get_xlabel(), page.axes[0].get_ylabel()):
        assert ("θ" in label or "φ" in label) == (name in ("latitude-longitude", "cylinder")), label


def test_a_cylinder_has_rows_of_equal_height(all_directions):
    bins = bins_of(all_directions["cylinder"])
    np.testing.assert_allclose(np.diff(bins.up.edges), -0.25, rtol=1e-12)
    axes = drawn(all_directions["cylinder"], cut=math.radians(89))
    assert axes.get_ylim() == (-1, 1)
    assert axes.lines[0].get_ydata()[0] == pytest.approx(0.125)
    with pytest.raises(ValueError, match=r"cut must be 0 to 3\.142, got 4"):
        drawn(all_directions["cylinder"], cut=4.0)


def test_faces_of_an_unfolded_cube_meet():
    """The directions of neighbouring pixels differ by a pixel, within faces and across all edges that touch.

    Planted: a face turned, and two faces exchanged.
    """
    pixels = 16
    cube = tp.EnvironmentMap(name="cube", position=(0, 0, 0), projection="cube", pixels=pixels)
    rays = cube.rays(0.5, 0.5)[0].reshape(6, pixels, pixels, 3)

    def widest_step(faces):
        laid = np.stack([unfold(faces[..., k], np.nan) for k in range(3)], axis=-1)
        steps = [np.linalg.norm(np.diff(laid, axis=axis), axis=-1) for axis in (0, 1)]
        return max(np.nanmax(each) for each in steps)

    assert widest_step(rays) < 2.5 / pixels
    turned, exchanged = rays.copy(), rays[[1, 0, 2, 3, 4, 5]]
    turned[4] = turned[4, ::-1, ::-1]
    for wrong in (turned, exchanged):
        assert widest_step(wrong) > 1
    cross = unfold(rays[..., 2], np.nan)
    assert cross.shape == (3 * pixels, 4 * pixels)
    assert np.nanargmax(cross) // (4 * pixels) > 2 * pixels  # +z is above


def test_a_cube_is_unfolded_and_its_faces_are_drawn_alone(all_directions):
    cube = all_directions["cube"]
    named = {text.get_text() for text in drawn(cube).texts}
    assert named >= {"+x", "−x", "+y", "−y", "+z", "−z"}
    assert bins_of(cube.radiance).frame == "cube"
    assert bins_of(cube, at={"face": 2}).frame == "image"
    with pytest.raises(ValueError, match="an unfolded cube has no cut; choose a face"):
        drawn(cube, cut=True)
    with pytest.raises(ValueError, match="frame='cube' needs the axes face, v and u"):
        drawn(all_directions["fisheye"], frame="cube")
    with pytest.raises(ValueError, match="frame='cylinder' needs the axes theta and phi"):
        drawn(all_directions["fisheye"], frame="cylinder")


def test_an_array_of_an_image_is_round_if_it_is_asked(all_directions):
    array = all_directions["fisheye"].radiance
    assert np.isfinite(bins_of(array).value).all()
    assert np.array_equal(
        np.isnan(bins_of(array, frame="round image").value),
        all_directions["fisheye"].detector.solid_angles() == 0,
    )
