"""Charts: a figure is written without a display, says its units, keeps labels inside, and survives gaps."""

import math
import os
import subprocess
import sys

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

from tests.synthetic import EVEN_RUN, noisy
from transport.statistics.estimates import Estimate, EstimateArray
from transport.viz import comparisons, cuts, profiles, radiance
from transport.viz.directions import direction_bins
from transport.viz.profiles import in_standard_errors
from transport.viz.style import unit_label

pytestmark = pytest.mark.filterwarnings("error")  # such as a layout that collapsed

TURN = np.linspace(0, 2 * math.pi, 13)
MU = np.linspace(0, 1, 9)
RIM = math.atan(0.5)
UNIT = r"\mathrm{W\,m^{-2}\,sr^{-1}}"


def disk(theta, phi=0.0):
    """Radiance of a disk of half its distance's radius, seen from its axis."""
    return np.where(theta < RIM, 100.0, 0.0)


def lobe(theta, phi):
    """A smooth radiance that depends on both angles."""
    return 1 + np.exp(-8 * (1 - np.cos(theta) * 0.8 - 0.6 * np.sin(theta) * np.cos(phi)))


def seen(law, polar="mu", edges=MU, phi=TURN, seed=1):
    """What a detector with these bins would count of an exact radiance, with the noise of its counts."""
    exact = EstimateArray(
        np.zeros((32, len(edges) - 1, len(phi) - 1)),
        EVEN_RUN,
        "1",
        (polar, "phi"),
        {polar: edges, "phi": phi},
    )
    bins = direction_bins(exact)
    means = np.stack([bins.expected(law, column) for column in range(len(phi) - 1)], axis=1)
    means = means[::-1] if polar == "mu" else means
    counts = np.random.default_rng(seed).poisson(np.broadcast_to(means, (32, *means.shape)))
    return EstimateArray(
        counts, EVEN_RUN, "W m^-2 sr^-1", exact.dims, exact.coords, counts=counts.sum(axis=0)
    )


@pytest.fixture
def figures(monkeypatch):
    """The figures that were written."""
    written, savefig = [], Figure.savefig

    def record(figure, *arguments, **options):
        written.append(figure)
        return savefig(figure, *arguments, **options)

    monkeypatch.setattr(Figure, "savefig", record)
    return written


def words(figure):
    """All that a figure says."""
    return "\n".join(text.get_text() for text in figure.findobj(matplotlib.text.Text))


def assert_drawn(path, figure):
    """The picture has more than one colour on white, and no label is cut off at its edge."""
    picture = imread(path)[..., :3]
    assert np.mean((picture < 0.9).any(axis=2)) > 0.01
    box, (width, height) = figure.get_tightbbox(), figure.get_size_inches()
    assert min(box.x0, box.y0) > -0.01
    assert box.x1 < width + 0.01
    assert box.y1 < height + 0.01


# Maps


@pytest.mark.parametrize(
    ("polar", "edges", "law"),
    [
        ("mu", MU, lobe),
        ("theta", np.linspace(0, math.pi / 2, 10), disk),
        ("theta", np.linspace(0, 1.2 * RIM, 7), disk),
    ],
    ids=["lobe by mu", "disk by theta", "disk in a cone"],
)
def test_a_radiance_map_is_drawn_with_units(tmp_path, figures, polar, edges, law):
    path = tmp_path / "new" / "map.png"
    L = seen(law, polar, edges)
    assert radiance.radiance_map(L, path, exact=law, title="Law", note="384 particles, seed 1") == path
    assert_drawn(path, figures[0])
    said = words(figures[0])
    for part in (
        UNIT,
        "relative standard error  [%]",
        "[deg]",
        "Law",
        "384 particles, seed 1",
        "φ = 0° to 30°",
    ):
        assert part in said
    assert ("no score" in said) == np.isnan(L.error).any()


def test_rings_are_labelled_at_30_60_and_90_degrees(tmp_path, figures):
    radiance.radiance_map(seen(lobe), tmp_path / "map.png")
    assert {"30°", "60°", "θ = 90°"} <= set(words(figures[0]).splitlines())


@pytest.mark.parametrize("gap", ["nothing scored", "one batch scored", "not a number", "exact", "no noise"])
def test_a_map_survives_bins_without_a_value_or_an_error(tmp_path, figures, gap):
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
    radiance.radiance_map(L, tmp_path / "map.png", exact=lobe)
    assert_drawn(tmp_path / "map.png", figures[0])


def test_a_map_without_azimuth_or_with_axes_exchanged_is_drawn(tmp_path, figures):
    L = seen(disk, phi=TURN[[0, -1]])[:, 0]
    radiance.radiance_map(L, tmp_path / "round.png", exact=disk)
    assert "all φ" in words(figures[0])
    turned = seen(lobe)
    turned = EstimateArray(
        turned.values.transpose(0, 2, 1), EVEN_RUN, turned.unit, ("phi", "mu"), {"phi": TURN, "mu": MU}
    )
    np.testing.assert_allclose(direction_bins(turned).value, direction_bins(seen(lobe)).value)


def test_a_map_refuses_other_axes_directions_and_azimuths(tmp_path):
    grid = EstimateArray(np.ones((32, 2, 2)), EVEN_RUN, "1", ("u", "v"), {"u": [0, 1, 2], "v": [0, 1, 2]})
    with pytest.raises(ValueError, match="mu or theta"):
        radiance.radiance_map(grid, tmp_path / "map.png")
    world = EstimateArray(np.ones((32, 2)), EVEN_RUN, "1", ("mu",), {"mu": [-1, 0, 1]})
    with pytest.raises(ValueError, match="one hemisphere"):
        radiance.radiance_map(world, tmp_path / "map.png")
    with pytest.raises(ValueError, match="azimuth must be 0 to 1"):
        radiance.radiance_map(seen(disk, phi=np.array([0.0, 1.0])), tmp_path / "map.png", azimuth=2.0)
    assert not list(tmp_path.iterdir())


# What a bin should hold


def test_a_bin_across_a_rim_holds_its_share_of_projected_solid_angle():
    bins = direction_bins(seen(disk))
    expected = bins.expected(disk, 0)
    squares = np.sin(bins.theta) ** 2
    share = np.clip((math.sin(RIM) ** 2 - squares[:-1]) / np.diff(squares), 0, 1)
    np.testing.assert_allclose(expected, 100 * share, atol=100 / 512)
    # Shares of angle, without the cosine, are another law that this would catch.
    wrong = np.clip((RIM - bins.theta[:-1]) / np.diff(bins.theta), 0, 1)
    assert np.abs(expected - 100 * wrong).max() > 1


def test_an_azimuth_finds_its_bin_across_the_full_turn():
    bins = direction_bins(seen(lobe))
    assert [bins.column(phi) for phi in (0.0, 0.6, math.pi, -0.1, 2 * math.pi)] == [0, 1, 6, 11, 0]
    assert direction_bins(seen(disk, phi=np.array([0.0, 1.0]))).column(2.0) is None


# Profiles


def irradiance(distance):
    return math.pi * 100 / (1 + distance**2)


def test_a_profile_over_six_decades_is_drawn_with_units_and_residuals(tmp_path, figures):
    distance = np.logspace(-3, 3, 13)
    estimates = [noisy(irradiance(d), irradiance(d) / 10, k, unit="W m^-2") for k, d in enumerate(distance)]
    profiles.profile(
        distance,
        estimates,
        tmp_path / "profile.png",
        exact=irradiance,
        guides={"inverse square": lambda d: 100 * math.pi / d**2},
        xlabel="distance d  [m]",
        ylabel="irradiance E",
        log_x=True,
        log_y=True,
    )
    assert_drawn(tmp_path / "profile.png", figures[0])
    said = words(figures[0])
    for part in (
        r"irradiance E  [$\mathrm{W\,m^{-2}}$]",
        "distance d  [m]",
        "[std. errors]",
        "inverse square",
    ):
        assert part in said
    main = figures[0].axes[0]
    assert main.get_xscale() == main.get_yscale() == "log"
    assert main.get_ylim()[1] < 1e4  # the guide, 3e8 at its end, does not stretch the scale


@pytest.mark.parametrize("truth", ["exact", "expected", "neither"])
def test_a_profile_over_bins_survives_empty_ones(tmp_path, figures, truth):
    values = np.random.default_rng(5).poisson(100 * (MU[1:] + MU[:-1]), size=(32, 8)).astype(float)
    values[:, 0], values[:, 3] = 0.0, np.nan
    crossings = EstimateArray(values, EVEN_RUN, "m^-2 s^-1", ("mu",), {"mu": MU})
    known = {"exact": {"exact": lambda mu: 200 * mu}, "expected": {"expected": 100 * (MU[1:] + MU[:-1])}}
    profiles.profile(MU, crossings, tmp_path / "gas.png", xlabel="μ", **known.get(truth, {}))
    assert_drawn(tmp_path / "gas.png", figures[0])
    assert len(figures[0].axes) == (1 if truth == "neither" else 2)


def test_residuals_are_in_standard_errors_and_a_wrong_exact_number_is_far_off():
    residual = in_standard_errors(
        np.array([3.0, 2.0, 2.0, 1.0]), np.array([0.5, 0, 0, np.nan]), np.array([2.0, 2, 3, 1])
    )
    np.testing.assert_array_equal(residual, [2.0, 0.0, -np.inf, np.nan])


def test_a_residual_beyond_the_panel_is_an_arrow_at_its_edge(tmp_path, figures):
    estimates = [noisy(1.0, 0.1, k) for k in range(4)]
    profiles.profile(
        [1, 2, 3, 4], estimates, tmp_path / "far.png", exact=lambda x: np.where(x == 3, 2.0, 1.0)
    )
    arrows = [
        line for line in figures[0].axes[1].lines if line.get_marker() in ("^", "v") and len(line.get_xdata())
    ]
    assert [list(line.get_xdata()) for line in arrows] == [[3.0]]


def test_a_profile_refuses_what_does_not_fit(tmp_path):
    path, pair = tmp_path / "profile.png", [noisy(1, 0.1, 1), noisy(2, 0.1, 2)]
    with pytest.raises(ValueError, match="2 places or 3 edges"):
        profiles.profile([1.0], pair, path)
    with pytest.raises(ValueError, match="one unit"):
        profiles.profile([1, 2], [pair[0], noisy(2, 0.1, 2, unit="m")], path)
    with pytest.raises(ValueError, match="one axis"):
        profiles.profile([1, 2], seen(lobe), path)
    with pytest.raises(ValueError, match="expected must have shape"):
        profiles.profile([1, 2], pair, path, expected=[1.0])


# Cuts at several places, and tables


def test_radiance_at_several_distances_is_drawn_with_units(tmp_path, figures):
    theta, curves, laws = np.linspace(0, math.pi / 2, 19), {}, {}
    for k, distance in enumerate((0.5, 1.0, 2.0, 4.0)):
        laws[f"d = {distance} m"] = lambda t, d=distance: np.where(t < math.atan(1 / d), 100.0, 0.0)
        law = laws[f"d = {distance} m"]
        L = seen(lambda t, p, law=law: law(t), "theta", theta, TURN[[0, -1]], seed=k)
        curves[f"d = {distance} m"] = L if k else L[:, 0]
    cuts.radiance_cuts(curves, tmp_path / "cuts.png", exact=laws, title="Invariance")
    assert_drawn(tmp_path / "cuts.png", figures[0])
    said = words(figures[0])
    assert all(part in said for part in (UNIT, "[deg]", *curves))
    cuts.radiance_cuts(curves, tmp_path / "log.png", exact=laws, log_x=True)
    assert_drawn(tmp_path / "log.png", figures[1])
    left, right = figures[1].axes[0].get_xlim()
    points = np.concatenate([bars.lines[0].get_xdata() for bars in figures[1].axes[0].containers])
    assert left < points.min() < points.max() < right
    with pytest.raises(ValueError, match="one bin of phi"):
        cuts.radiance_cuts({"map": seen(lobe)}, tmp_path / "no.png")
    with pytest.raises(ValueError, match="no curves"):
        cuts.radiance_cuts({}, tmp_path / "no.png")
    with pytest.raises(ValueError, match="the curves are"):
        cuts.radiance_cuts(curves, tmp_path / "no.png", exact={"d = 3 m": disk})


def test_a_comparison_shows_every_kind_of_row(tmp_path, figures):
    table = {
        "irradiance": (noisy(18.4, 0.2, 1, unit="W m^-2"), 18.439),
        "wrong by far": (noisy(20.0, 0.2, 2, unit="W m^-2"), 18.439),
        "net flux density": (noisy(0.0, 0.2, 3, unit="m^-2 s^-1"), 0.0),
        "emitted": (Estimate(np.full(32, 2.0), EVEN_RUN, "W", exact=True), 2.0),
        "exactly wrong": (Estimate(np.full(32, 2.0), EVEN_RUN, "W", exact=True), 3.0),
        "empty": (Estimate(np.zeros(32), EVEN_RUN, "W"), 1.0),
        "ratio": (noisy(-0.5, 0.01, 4, unit="1"), -0.5),
    }
    comparisons.comparison(table, tmp_path / "table.png", title="All", note="seed 1")
    assert_drawn(tmp_path / "table.png", figures[0])
    said = words(figures[0])
    for part in (
        *table,
        "[%]",
        "z  [standard errors]",
        r"\mathrm{W\,m^{-2}}",
        "no score",
        "exact 18.439",
        "(exact)",
    ):
        assert part in said
    with pytest.raises(ValueError, match="must have a row"):
        comparisons.comparison({}, tmp_path / "no.png")


def test_a_comparison_of_precise_numbers_counts_in_ppm(tmp_path, figures):
    comparisons.comparison({"one": (noisy(1.0, 1e-5, 1), 1.0)}, tmp_path / "ppm.png")
    assert "[ppm]" in words(figures[0])


# Manners


def test_units_are_written_in_mathtext():
    assert unit_label("W m^-2 sr^-1") == f"${UNIT}$"
    assert unit_label("m^(1/2)") == r"$\mathrm{m^{1/2}}$"
    assert unit_label("1") == ""


def test_drawing_leaves_the_settings_of_matplotlib_alone(tmp_path):
    before = dict(matplotlib.rcParams)
    comparisons.comparison({"one": (noisy(1.0, 0.1, 1), 1.0)}, tmp_path / "one.png")
    assert dict(matplotlib.rcParams) == before


def test_drawing_needs_no_pyplot_and_the_library_no_charts():
    code = """
import sys, transport
assert not {"matplotlib", "transport.viz"} & set(sys.modules)
from transport import viz
assert not {"matplotlib.pyplot", "pyvista", "numba"} & set(sys.modules)
"""
    without_display = {
        name: value for name, value in os.environ.items() if name not in ("DISPLAY", "MPLBACKEND")
    }
    subprocess.run([sys.executable, "-c", code], check=True, env=without_display)
