"""Figures of any result: what is drawn are the numbers of the result, with its errors, to scale and with units."""

from __future__ import annotations

import math
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch

import transport as tp
from tests.synthetic import EVEN_RUN, noisy
from transport.statistics.estimates import EstimateArray
from transport.viz import cameras, irradiance, radiance
from transport.viz.convergence import convergence, course_of, strays
from transport.viz.phase_density import phase_density
from transport.viz.places import places_of
from transport.viz.power_flow import PITCH, WHOLE, ends_of, power_flow
from transport.viz.wording import as_it_stands

pytestmark = pytest.mark.filterwarnings("error")  # such as a layout that collapsed

PANELS = ("floor", "round", "tube")


@pytest.fixture(scope="module")
def result():
    """A lamp over a grey floor, with a disk and a tube beside it, all with bins of place."""
    lamp = tp.Disk(center=(0.3, 0, 1), normal=(0, 0, -1), radius=0.2)
    floor = tp.Rectangle(width=2.0, height=1.0)
    places = {
        "floor": tp.Positions(u=8, v=4),
        "round": tp.Positions(u=3, v=8),
        "tube": tp.Positions(u=4, v=6),
    }
    shapes = {
        "round": tp.Disk(center=(0, 0, 0.5), radius=0.5),
        "tube": tp.Cylinder(center=(0, 0, 0.5), radius=0.9, height=0.5),
    }
    meters = [tp.Detector(shapes.get(name, name), name, positions=bins) for name, bins in places.items()]
    meters[-1] = tp.Detector(shapes["tube"], "tube", side="back", positions=places["tube"])
    scene = tp.Scene(
        tp.Source(lamp, tp.Lambertian(power=10.0)),
        tp.Surface(floor, tp.Diffuse(0.5), "floor"),
        [*meters, tp.Detector("floor", "rows", positions=tp.Positions(u=8))],
    )
    return tp.simulate(scene, 20_000, seed=1, progress=False)


@pytest.fixture
def figures(monkeypatch):
    """The figures that were written; no label of theirs is cut off at an edge."""
    written, savefig = [], Figure.savefig

    def record(figure, *arguments, **options):
        written.append(figure)
        savefig(figure, *arguments, **options)
        box, (width, height) = figure.get_tightbbox(), figure.get_size_inches()
        assert min(box.x0, box.y0, width - box.x1, height - box.y1) > -0.01

    monkeypatch.setattr(Figure, "savefig", record)
    return written


def words(figure):
    """All that a figure says."""
    return "\n".join(text.get_text() for text in figure.findobj(matplotlib.text.Text))


def points_of(axes):
    """x, y and half bars of each series of points with bars that was drawn."""
    found = []
    for container in axes.containers:
        (line, _, (bars,)) = container.lines
        segments = np.array(bars.get_segments())
        found.append((*line.get_data(), (segments[:, 1, 1] - segments[:, 0, 1]) / 2))
    return found


# By place


def test_an_irradiance_map_and_its_cut_are_logarithmic_together(tmp_path, figures, result):
    irradiance.irradiance_map(result["floor"], tmp_path / "map.png", decades=2)
    values, cut = figures[0].axes[0], figures[0].axes[4]
    norm, (low, high) = values.images[0].norm, cut.get_ylim()
    assert cut.get_yscale() == "log"
    assert low == norm.vmin and high >= norm.vmax == 100 * low


def test_an_irradiance_map_shows_the_values_their_relative_errors_and_a_cut(tmp_path, figures, result):
    path, floor = tmp_path / "map.png", result["floor"].irradiance
    exact = np.arange(32.0).reshape(8, 4)
    assert irradiance.irradiance_map(result["floor"], path, exact=exact, row=1, note="small print") == path
    values, errors, cut = (figures[0].axes[k] for k in (0, 1, 4))
    np.testing.assert_array_equal(values.images[0].get_array(), floor.value.T)
    np.testing.assert_allclose(values.images[0].get_extent(), (-1, 1, -0.5, 0.5))
    percent = errors.images[0].get_array()
    known = np.isfinite(floor.relative_error.T)
    np.testing.assert_allclose(percent[known], 100 * floor.relative_error.T[known])
    assert np.ma.getmaskarray(percent)[~known].all()
    ((x, y, bars),) = points_of(cut)
    told = np.isfinite(floor.error[:, 1])
    np.testing.assert_allclose(x, (-0.875 + 0.25 * np.arange(8))[told])
    np.testing.assert_allclose(y, floor.value[told, 1])
    np.testing.assert_allclose(bars, 2 * floor.error[told, 1])
    np.testing.assert_array_equal(cut.patches[0].get_data().values, exact[:, 1])
    assert {"u  [m]", "v  [m]", "small print", "relative standard error  [%]"} <= set(
        words(figures[0]).splitlines()
    )
    assert r"irradiance  [$\mathrm{W\,m^{-2}}$]" in words(figures[0])


def test_a_disk_is_drawn_round_and_cut_from_rim_to_rim(tmp_path, figures, result):
    irradiance.irradiance_map(result["round"], tmp_path / "map.png", row=2)
    (mesh,) = figures[0].axes[0].findobj(QuadMesh)
    corners = mesh.get_coordinates().reshape(-1, 2)
    assert np.hypot(*corners.T).max() == pytest.approx(0.5)
    np.testing.assert_allclose(mesh.get_array().reshape(3, -1)[:, ::30], result["round"].irradiance.value)
    (ahead, value, _), (behind, opposite, _) = points_of(figures[0].axes[4])
    assert (ahead > 0).all() and (behind < 0).all()
    np.testing.assert_allclose(value, result["round"].irradiance.value[:, 2])
    np.testing.assert_allclose(opposite, result["round"].irradiance.value[:, 6])


def spots(bright, shape=None, error=0.02):
    """A reading of 4 by 5 bins that are 1 ± 0.02, but for some: {(u, v): (value, relative error)}."""
    values, errors = np.ones((4, 5)), np.full((4, 5), error)
    for place, (value, relative) in bright.items():
        values[place], errors[place] = value, relative
    coords = {"u": np.arange(5.0), "v": np.arange(6.0) if shape is None else np.linspace(0, 2 * math.pi, 6)}
    signs = math.sqrt(31) * np.tile([-1.0, 1.0], 16)[:, None, None]
    estimate = EstimateArray(values * (1 + errors * signs), EVEN_RUN, "W m^-2", ("u", "v"), coords)
    return SimpleNamespace(name="meter", irradiance=estimate, shape=shape or tp.Rectangle(width=4, height=5))


SPOTS = {
    "above": ({(2, 4): (9.0, 0.02)}, 4),
    "below": ({(2, 0): (9.0, 0.02)}, 0),
    "beside one that is not known": ({(2, 4): (math.nan, 0.02), (1, 3): (2.0, 0.02)}, 3),
    "of two alike the one nearer the middle": ({(2, 0): (2.0, 0.02), (1, 3): (2.0, 0.02)}, 3),
    "nowhere": ({}, 2),
    "small beside a bright row": ({(0, 1): (9.0, 0.02)} | {(u, 3): (2.0, 0.02) for u in range(4)}, 1),
    "beside a single large score": ({(0, 4): (9.0, 0.95), (1, 1): (2.0, 0.02)}, 1),
}


@pytest.mark.parametrize(("bright", "row"), SPOTS.values(), ids=SPOTS)
def test_a_cut_runs_through_the_brightest_spot(tmp_path, figures, bright, row):
    irradiance.irradiance_map(spots(bright), tmp_path / "map.png")
    np.testing.assert_allclose(figures[0].axes[0].lines[0].get_ydata(), row + 0.5)


def test_a_cut_without_any_known_error_runs_through_the_greatest_value(tmp_path, figures):
    irradiance.irradiance_map(spots({(2, 4): (9.0, 0.0)}, error=0.0), tmp_path / "map.png")
    np.testing.assert_allclose(figures[0].axes[0].lines[0].get_ydata(), 4.5)


@pytest.mark.parametrize(
    ("bright", "sector"),
    [({(2, 3): (9.0, 0.02)}, 3), ({}, 0), ({(0, 2): (9.0, 0.95), (3, 1): (2.0, 0.02)}, 1)],
)
def test_a_cut_of_a_disk_starts_in_the_brightest_sector(tmp_path, figures, bright, sector):
    irradiance.irradiance_map(spots(bright, tp.Disk(radius=4.0)), tmp_path / "map.png")
    (x, y) = figures[0].axes[0].lines[0].get_data()
    assert math.degrees(math.atan2(y[-1], x[-1])) % 360 == pytest.approx(72 * sector + 36)


def test_a_tube_is_unrolled_with_its_azimuth_across_in_degrees(result):
    places = places_of(result["tube"], "irradiance")
    assert [axis.unit for axis in places.axes] == ["deg", "m"]
    np.testing.assert_allclose(places.edges[0], np.linspace(0, 360, 7))
    np.testing.assert_array_equal(places.value, result["tube"].irradiance.value.T)


def test_bins_along_one_coordinate_are_a_cut_alone(tmp_path, figures, result):
    irradiance.irradiance_map(result["rows"], tmp_path / "cut.png")
    (axes,) = figures[0].axes
    np.testing.assert_allclose(points_of(axes)[0][1], result["rows"].irradiance.value)


def cells(*shape, dims=("x", "y", "z")):
    """A reading of cells whose values are their numbers."""
    values = np.broadcast_to(1.0 + np.arange(math.prod(shape)).reshape(shape), (32, *shape))
    values = values * (1 + 0.01 * np.arange(-15.5, 16).reshape(-1, *(1,) * len(shape)))
    coords = {name: np.linspace(0, 1, n + 1) for name, n in zip(dims, shape, strict=True)}
    return SimpleNamespace(name="core", glow=EstimateArray(values, EVEN_RUN, "W m^-2", dims, coords))


@pytest.mark.parametrize(
    ("shape", "at", "taken"),
    [
        ((3, 4, 5), {}, np.s_[:, :, 2]),
        ((3, 4, 5), {"y": 1}, np.s_[:, 1, :]),
        ((3, 1, 5), {}, np.s_[:, 0, :]),
        ((1, 1, 5), {}, np.s_[0, 0, :]),
    ],
)
def test_of_cells_in_space_one_layer_is_drawn(shape, at, taken):
    reading = cells(*shape)
    places = places_of(reading, "glow", at)
    np.testing.assert_array_equal(places.value, reading.glow.value[taken])
    np.testing.assert_array_equal(places.arranged(reading.glow.error), reading.glow.error[taken])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda path, result: irradiance.irradiance_map(result["floor"], path, quantity="flux_in"),
            "has no bins of place",
        ),
        (
            lambda path, result: irradiance.irradiance_map(result["floor"], path, exact=np.zeros(3)),
            r"bins \(8, 4\)",
        ),
        (
            lambda path, result: irradiance.irradiance_map(result["floor"], path, at={"z": 1}),
            r"no axes \['z'\]",
        ),
        (
            lambda path, result: irradiance.irradiance_map(
                cells(2, 3, dims=("time", "u")), path, quantity="glow"
            ),
            r"write at=\{'time': 0\}",
        ),
        (
            lambda path, result: convergence(result, "floor.irradiance", path),
            "take one of its bins",
        ),
        (
            lambda path, result: convergence(result, result.ledger["emitted"], path),
            "needs batches that differ",
        ),
        (lambda path, result: phase_density(phase(dims=("x",)), path), "two are needed"),
        (lambda path, result: phase_density(phase(scale=0), path), "nothing was in the bins"),
    ],
)
def test_what_cannot_be_drawn_is_refused_with_the_cure(tmp_path, result, make, message):
    with pytest.raises(ValueError, match=message):
        make(tmp_path / "x.png", result)


# In phase space


def phase(dims=("time", "x", "vx"), scale=1):
    """A reading of counts over phase space, with a corner that nothing comes to."""
    shape = tuple({"time": 3, "x": 5, "vx": 4}[name] for name in dims)
    counts = scale * np.random.default_rng(5).poisson(4.0, size=(32, *shape))
    counts[..., 0] = 0
    coords = {name: np.linspace(-1, 1, n + 1) for name, n in zip(dims, shape, strict=True)}
    coords |= {"time": np.arange(3.0)} if "time" in dims else {}
    density = EstimateArray(counts, EVEN_RUN, "m^-2 s", dims, coords, counts=counts.sum(axis=0))
    return SimpleNamespace(name="gas", density=density, detector=SimpleNamespace(times=(0.0, 1.0, 2.0)))


@pytest.mark.parametrize("decades", [None, 2.0])
def test_phase_density_stands_above_its_relative_error_at_each_time(tmp_path, figures, decades):
    reading, path = phase(), tmp_path / "phase.png"
    assert phase_density(reading, path, times=(0, 2), decades=decades) == path
    axes = figures[0].axes
    for column, time in enumerate((0, 2)):
        density = reading.density[time]
        above, below = axes[column].images[0].get_array(), axes[2 + column].images[0].get_array()
        np.testing.assert_array_equal(np.ma.filled(above, 0)[1:], density.value.T[1:])
        np.testing.assert_allclose(below[1:], 100 * density.relative_error.T[1:])
        assert np.ma.getmaskarray(below)[0].all() and np.ma.getmaskarray(above)[0].all() == (
            decades is not None
        )
    said = words(figures[0])
    assert {"t = 0 s", "t = 2 s", "no score", "relative standard error  [%]"} <= set(said.splitlines())
    assert r"position x  [$\mathrm{m}$]" in said and r"density  [$\mathrm{s\,m^{-2}}$]" in said


# While it runs


def test_the_course_of_a_run_ends_at_its_result(result):
    estimate = result["floor"].flux_in
    course = course_of(estimate)
    assert course.value[-1] == pytest.approx(estimate.value, rel=1e-13)
    assert course.error[-1] == pytest.approx(estimate.error, rel=1e-13)
    assert course.particles[-1] == result.particles
    assert course.value[0] == pytest.approx(estimate.values[0])


def test_the_band_covers_the_truth_as_often_as_it_says():
    """95.4 % of 500 runs, at 3, 8 and 32 batches, to five standard deviations; ± 2 bare errors of 3 batches cover 82 %."""
    courses = [course_of(noisy(5.0, 2.0, seed)) for seed in range(500)]
    for k in (3, 8, 32):
        covered = np.mean([abs(c.value[k - 1] - 5.0) <= c.reach[k - 1] for c in courses])
        assert covered == pytest.approx(0.9545, abs=0.047)
    bare = np.mean([abs(c.value[2] - 5.0) <= 2 * c.error[2] for c in courses])
    assert bare < 0.9


def test_standard_errors_of_few_batches_fall_within_the_grey_band():
    batches = np.random.default_rng(2).normal(size=(4000, 5))
    errors = batches.std(axis=1, ddof=1)
    low, high = strays(np.array([5, 32]))
    assert np.mean((errors > low[0]) & (errors < high[0])) == pytest.approx(0.9545, abs=0.017)
    assert low[0] < low[1] < 1 < high[1] < high[0]


def test_convergence_is_drawn_with_guide_seconds_and_exact_value(tmp_path, figures, result):
    path = tmp_path / "course.png"
    assert convergence(result, "floor.flux_in", path, exact=8.0, title="Settles") == path
    upper, lower = figures[0].axes[:2]
    course = course_of(result["floor"].flux_in)
    np.testing.assert_allclose(upper.lines[0].get_ydata(), course.value)
    assert upper.lines[1].get_ydata()[0] == 8.0
    n, guide = lower.lines[0].get_data()
    np.testing.assert_allclose(guide * np.sqrt(n), 100 * course.error[-1] / course.value[-1] * np.sqrt(n[-1]))
    assert "seconds, at the run's mean rate" in words(figures[0]) or result.cost is None
    assert r"floor, flux in  [$\mathrm{W}$]" in words(figures[0])


# Where it went


def crowd(result):
    """A ledger with eight absorbers, the least of them 1e-9 of what was emitted, and nothing else."""
    emitted, shares = result.ledger["emitted"], [0.9, 0.09, 9e-3, 9e-4, 9e-5, 9e-6, 9e-7, 1e-7]
    many = {f"wall {k}": emitted * share for k, share in enumerate(shares)}
    others = {name: result.ledger["lost"] for name in result.ledger if name not in ("emitted", "absorbed")}
    return SimpleNamespace(plan=result.plan, ledger=_Ledger(others | {"emitted": emitted}, many))


@pytest.mark.parametrize("kind", ["of a run", "many and small"])
def test_the_flow_is_to_scale_and_adds_up_to_what_was_emitted(tmp_path, figures, result, kind):
    path, shown = tmp_path / "flow.png", result if kind == "of a run" else crowd(result)
    assert power_flow(shown, path) == path
    (axes,) = figures[0].axes
    ends = ends_of(shown)
    bands = [patch for patch in axes.patches if isinstance(patch, PathPatch)]
    widths = [vertices[3, 1] - vertices[4, 1] for vertices in (band.get_path().vertices for band in bands)]
    np.testing.assert_allclose(widths, [WHOLE * end.amount.value / 10.0 for end in ends], atol=1e-12)
    assert sum(widths) == pytest.approx(WHOLE, rel=1e-6)
    said = words(figures[0])
    for end in ends:
        assert end.words in said and f"{100 * end.amount.value / 10.0:.3g} %" in said
    middles = sorted(band.get_path().vertices[3:5, 1].mean() for band in bands)
    assert min(np.diff(middles)) >= PITCH


def test_every_end_is_told_and_the_least_of_many_together(result):
    assert {end.words for end in ends_of(result)} == {"absorbed by floor", "escaped"}
    ends = {end.words: end.amount.value / 10.0 for end in ends_of(crowd(result), most=5)}
    assert next(iter(ends)) == "absorbed by wall 0" and len(ends) == 5
    assert ends["absorbed by 4 others"] == pytest.approx(9e-5 + 9e-6 + 9e-7 + 1e-7)


class _Ledger(dict):
    def __init__(self, entries, absorbed_by):
        super().__init__(entries)
        self.absorbed_by = absorbed_by


# Instruments


def sight(dark=False):
    """A reading of an image of 6 by 8 pixels, one of which nothing came to."""
    counts = np.random.default_rng(8).poisson(9.0, size=(32, 6, 8)).astype(float)
    counts[:, 2, 3] = 0
    coords = {"v": np.linspace(-0.3, 0.3, 7), "u": np.linspace(-0.4, 0.4, 9)}
    radiance = EstimateArray(
        counts * (not dark), EVEN_RUN, "W m^-2 sr^-1", ("v", "u"), coords, counts=counts.sum(axis=0)
    )
    image, errors = (lambda: radiance.value[::-1]), (lambda: radiance.error[::-1])
    return SimpleNamespace(name="view", radiance=radiance, image=image, errors=errors)


def test_a_picture_stands_beside_its_relative_errors_in_percent(tmp_path, figures):
    reading = sight()
    cameras.seen(reading, tmp_path / "seen.png")
    left, right = (figures[0].axes[k].images[0].get_array() for k in (0, 1))
    lit = reading.image() > 0
    np.testing.assert_allclose(left[lit], reading.image()[lit])
    np.testing.assert_allclose(right[lit], 100 * (reading.errors() / np.where(lit, reading.image(), 1))[lit])
    assert np.ma.getmaskarray(right)[~lit].all()
    assert {"hatched: no error known", "relative standard error  [%]"} <= set(words(figures[0]).splitlines())
    with pytest.raises(ValueError, match="saw no light at all"):
        cameras.seen(sight(dark=True), tmp_path / "dark.png")


def test_a_lamp_is_on_the_same_side_of_a_map_as_of_the_cameras_picture(tmp_path, figures):
    """At (2, 2, 0), seen from the origin along +y: to the right of the middle, and of the azimuth of +y."""
    lamp = tp.Source(tp.Sphere(center=(2, 2, 0), radius=0.4), tp.Lambertian(radiance=3.0))
    here = {"position": (0, 0, 0)}
    camera = tp.Camera(name="view", direction=(0, 1, 0), field_of_view=2.0, pixels=(24, 16), **here)
    around = tp.EnvironmentMap(name="around", theta=18, phi=32, **here)
    for instrument, ahead in ((camera, 11.5), (around, 90.0)):
        result = tp.simulate(tp.Scene([lamp], (), [instrument]), 50_000, seed=2, progress=False)
        cameras.seen(result[instrument.name], tmp_path / f"{instrument.name}.png")
        axes = figures[-1].axes[0]
        if instrument is camera:
            (drawn,) = axes.images
            place = np.argwhere(drawn.get_array() == drawn.get_array().max())[:, 1].mean()
        else:
            (drawn,) = axes.findobj(QuadMesh)
            lit = drawn.get_array() == drawn.get_array().max()
            corners = drawn.get_coordinates()
            place = ((corners[:-1, :-1] + corners[1:, 1:]) / 2)[lit.reshape(18, 32)][:, 0].mean()
        x, middle = axes.transData.transform([(place, 0), (ahead, 0)])[:, 0]
        assert x > middle + 1, f"{instrument.name}: {x:.0f} against {middle:.0f}"


def test_a_lamp_at_the_side_of_u_is_on_the_right_of_a_floors_plans_by_place_and_by_direction(
    tmp_path, figures
):
    """Both are seen from in front, so that they can stand side by side."""
    lamp = tp.Source(tp.Sphere(center=(1, 0, 1), radius=0.2), tp.Lambertian(radiance=3.0))
    floor = tp.Rectangle(width=2.0, height=2.0)
    meters = [
        tp.Detector(floor, "places", positions=tp.Positions(u=8, v=8)),
        tp.Detector(tp.Disk(radius=0.2), "directions", directions=tp.Directions(theta=9, phi=16)),
    ]
    result = tp.simulate(tp.Scene([lamp], (), meters), 50_000, seed=3, progress=False)
    irradiance.irradiance_map(result["places"], tmp_path / "places.png")
    radiance.radiance_map(result["directions"].radiance, tmp_path / "directions.png")
    by_place = figures[0].axes[0].images[0].get_array().mean(axis=0)
    assert by_place.argmax() > 5
    (mesh,) = figures[1].axes[0].findobj(QuadMesh)
    corners = mesh.get_coordinates()
    middles = (corners[:-1, :-1, 0] + corners[1:, 1:, 0]) / 2
    assert middles[np.unravel_index(np.argmax(mesh.get_array()), mesh.get_array().shape)] > 20
    assert "seen from\nin front" in words(figures[1])


def test_a_lamp_above_a_ball_lights_the_top_of_its_map(tmp_path, figures):
    """The ball is seen from outside: the pole is on top and azimuth grows to the right."""
    lamp = tp.Source(tp.Disk(center=(0, 0, 3), normal=(0, 0, -1), radius=0.5), tp.Lambertian(power=1.0))
    ball = tp.Detector(tp.Sphere(radius=1.0), "ball", positions=tp.Positions(u=6, v=8))
    result = tp.simulate(tp.Scene([lamp], (), [ball]), 50_000, seed=4, progress=False)
    irradiance.irradiance_map(result["ball"], tmp_path / "ball.png")
    axes = figures[0].axes[0]
    pole, floor = axes.transData.transform([(0, 0), (0, 180)])[:, 1]
    assert pole > floor
    assert axes.get_xlim()[0] < axes.get_xlim()[1]


def test_names_with_dollar_signs_are_no_formulas(tmp_path, figures, result):
    emitted, name = result.ledger["emitted"], r"a $\bad{$ b"
    crowded = crowd(result)
    crowded.ledger.absorbed_by = {name: emitted}
    power_flow(crowded, tmp_path / "flow.png")
    assert rf"absorbed by {as_it_stands(name)}" in words(figures[0])
