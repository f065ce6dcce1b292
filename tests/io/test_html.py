"""In a notebook objects have a table with what their text says, and a small picture; well-formed for any name."""

import base64
import importlib
import io
import math
import re
import sys
import time

import numpy as np
import pytest
from PIL import Image

import transport as tp
from tests import plain_scenes
from tests.browser import CHROMIUM, Browser
from tests.html_pages import Page, column, page
from tests.synthetic import EVEN_RUN, RUN, grid, noisy
from transport.analysis.work_precision import MethodCost, Point
from transport.io.html import estimates, pictures
from transport.io.html.elements import STYLE, framed, plain_typeset, typeset
from transport.io.html.scenes import MAX_ROWS
from transport.statistics.convergence import TimeModel
from transport.statistics.estimates import Batches, Estimate, EstimateArray

HOSTILE = """<i>"meter"</i> & co <script>alert(1)</script> e-9 ^2 {} %s"""


def number(value, error, unit="W"):
    signs = np.tile([-1.0, 1.0], 16)
    return Estimate(value + error * math.sqrt(31) * signs, EVEN_RUN, unit)


@pytest.fixture(scope="module")
def foggy():
    """A run with media, warnings, several detectors with bins, all of them of hostile names."""
    layer = tp.Slab(center=(0, 0, -4), thickness=8.0)
    fog = tp.Medium(absorption=0.8, scattering=0.2)
    scene = tp.Scene(
        sources=tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0)),
        surfaces=tp.Surface(layer, tp.Transparent(), HOSTILE, inside=fog),
        detectors=[
            tp.Detector(tp.Plane(), HOSTILE + "top", directions=tp.Directions(mu=4, phi=3)),
            tp.VolumeDetector(tp.Box(center=(0, 0, -4), size=(2, 2, 8)), HOSTILE + "core", cells=(2, 1, 9)),
        ],
    )
    return tp.simulate(scene, particles=2000, seed=1, threads=1, tracking=tp.Tracking(roulette=0.9))


@pytest.fixture
def drawn(monkeypatch):
    """What is drawn: (array, decades, label) of each picture; nothing is rendered."""
    found = []
    record = lambda array, ax, decades, label: found.append((array, decades, label))  # noqa: E731
    monkeypatch.setattr(pictures, "function_for", lambda kind, verb: record)
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda *_, **__: None)
    return found


# Text


@pytest.mark.parametrize(
    "estimate",
    [
        number(18.4391, 0.0007, "W m^-2"),
        number(-2.938e-9, 9e-12),
        number(6.02e23, 1e21, "m^-2 s^-1"),
        number(0.0, 0.3, "m^(1/2)"),
        noisy(5.0, 1.0, 3, unit="1"),
        Estimate(np.full(32, 2.0e-7), EVEN_RUN, "J", exact=True),
        Estimate(np.zeros(32), EVEN_RUN, "W"),
        Estimate(np.full(32, np.nan), EVEN_RUN, "W"),
        Estimate(np.r_[np.inf, np.zeros(31)], EVEN_RUN, "W"),
    ],
    ids=str,
)
def test_an_estimate_has_its_text(estimate):
    assert str(estimate) in page(estimate).text


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("(-2.938 ± 0.009)e-09 W m^-2", "(−2.938 ± 0.009)\xa0×\xa010<sup>−9</sup> W m<sup>−2</sup>"),
        ("5e+04 m^(1/2)", "5\xa0×\xa010<sup>4</sup> m<sup>1/2</sup>"),
        ("x-ray <a> at-3", "x-ray &lt;a&gt; at-3"),
    ],
)
def test_numbers_are_set_as_in_print(text, html):
    assert typeset(text) == html
    assert plain_typeset("-1e-12 m^-6 s^3") == "−1\xa0×\xa010⁻¹² m⁻⁶ s³"


@pytest.mark.slow
def test_a_result_has_what_its_report_has(foggy):
    seen = page(foggy)
    for name, estimate in foggy.ledger.items():
        assert (f"{name}\n{estimate}" in seen.text) == (f"{name:10s} {estimate}" in foggy.report())
    for detector in foggy.scene.detectors:
        for name, quantity in foggy[detector.name].quantities.items():
            told = str(quantity) if isinstance(quantity, Estimate) else repr(quantity)[15:-1]
            assert name in seen.text and told in seen.text
            assert told in page(foggy[detector.name]).text
    assert foggy.warnings and all(warning in seen.text for warning in foggy.warnings)
    assert seen.text.index("warning") < seen.text.index("emitted")
    assert "seed 1" in seen.text and "next digit" in seen.text
    assert str(foggy.ledger["absorbed"]) in page(foggy.ledger).text
    share = foggy.ledger["absorbed"].value / foggy.ledger["emitted"].value
    assert f"{foggy.ledger['absorbed']}\n{100 * share:.3g} %" in page(foggy.ledger).text
    half = tp.Result(foggy.plan, foggy.batches[:5], 1, None, False, ["a word of <warning>"])
    assert "INCOMPLETE" in page(half).text and "a word of <warning>" in page(half).text


@pytest.mark.quick_cases("room", "furnace")
@pytest.mark.parametrize("make", plain_scenes.SCENES.values(), ids=list(plain_scenes.SCENES))
def test_a_scene_has_the_names_of_its_parts(make):
    scene = make()
    seen = page(scene).text
    named = (*scene.surfaces[:MAX_ROWS], *scene.detectors[:MAX_ROWS])
    assert seen.startswith("Scene") and all(part.name in seen for part in named if part.name)
    assert "None" not in seen and "299792458" not in seen


def test_a_scene_has_parameters_that_differ_from_the_defaults():
    lamp = tp.Source(tp.Disk(radius=0.25), tp.Lambertian(radiance=3.0))
    ball = tp.Surface(tp.Sphere(radius=0.5), tp.Dielectric(index_inside=1.5), "ball")
    skin = tp.Detector("ball", "skin", directions=tp.Directions(mu=(0, 0.5, 1)))
    seen = page(tp.Scene(lamp, ball, skin)).text
    parts = (
        "Disk(radius=0.25)",
        "Lambertian(radiance=3)",
        "Sphere(radius=0.5)",
        "Dielectric(index_inside=1.5)",
    )
    assert all(part in seen for part in (*parts, "skin", "Directions(mu=(0, 0.5, 1))"))
    assert "None" not in seen and "299792458" not in seen


def test_prices_have_the_words_of_their_text():
    tried = Point(1000, 2, 0.1, 0.1, math.nan, math.nan, math.nan)
    ways = tuple(
        MethodCost(name, (tried,), None, None, TimeModel(0.0, 1e-6), 0.25, math.nan)
        for name in ("analog", HOSTILE)
    )
    cost = tp.CostOfAccuracy(
        "meter.flux_in", "W", 2.5e-7, "exact", ways, (0.01, 1e-8), {"backward <i>": "no"}, "a <machine>", 1
    )
    seen, lines = page(cost), str(cost).splitlines()
    words = {word for line in lines if "particles in the largest" not in line for word in line.split()}
    assert {word for word in words if word not in seen.text} == set()
    assert seen.tags.count("tr") == 3 and not {"script", "i"} & set(seen.tags)


def test_an_array_has_its_range_and_some_of_its_bins():
    array, few = grid(1), column([1.0, 2.0, 3.0])
    seen = page(array)
    place = np.unravel_index(np.argmax(array.value), array.shape)
    assert repr(array)[15:-1] in seen.text and str(array[place]) in seen.text
    assert all(str(each) in page(few).text for each in few)


def test_phase_spaces_snapshots_and_tracks_have_their_numbers(foggy):
    light = tp.Source(tp.Point(), tp.Isotropic(energy=1.0), pulse=tp.Instant())
    looks = [
        tp.PhaseSpace(name=HOSTILE, time=1e-9, x=np.linspace(-1, 1, 5)),
        tp.Snapshot(name=HOSTILE + "s", time=1e-9, particles=100),
    ]
    scene = tp.Scene(light, tp.Surface(tp.Box(size=2.0), tp.Black()), looks, duration=2e-9)
    moving = tp.simulate(scene, particles=500, seed=1, threads=1)
    seen = page(moving[HOSTILE]).text
    assert "phase space" in seen and repr(moving[HOSTILE].number)[15:-1] in seen
    assert "100 particles at 1e-09 s" in page(moving[HOSTILE + "s"]).text
    assert "positions" in page(moving[HOSTILE + "s"]).text and "snapshot" in page(moving).text
    found = tp.tracks(foggy.scene, particles=50, seed=1)
    seen = page(found)
    assert repr(found).strip("<>").removeprefix("Tracks ") in seen.text
    assert f"flights\n{len(found)}" in seen.text and seen.tags.count("img") == 1


# Pictures


def test_a_picture_is_a_png_in_the_page_with_both_maps():
    """Left of the middle the values with their scale, right of it the errors: each has many colours."""
    (source,) = [a["src"] for a in page(grid(1)).attributes if "src" in a]
    picture = Image.open(io.BytesIO(base64.b64decode(source.removeprefix("data:image/png;base64,"))))
    pixels = np.asarray(picture.convert("RGB"))
    half = picture.width // 2
    for side in (pixels[:, :half], pixels[:, half:]):
        assert len(np.unique(side.reshape(-1, 3), axis=0)) > 50
    assert (picture.width, pixels[0, 0].tolist()) == (760, [255, 255, 255]) and 150 < picture.height < 320


def test_a_map_stands_beside_that_of_its_relative_errors_in_percent(monkeypatch):
    percent, values = np.array([[3.0, 1.0, 2.0]] * 2), np.array([[1.0, 100.0, 1e4]] * 2)
    batches = values * (1 + percent / 100 * math.sqrt(31) * np.tile([-1.0, 1.0], 16)[:, None, None])
    saved = []
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda figure, *_, **__: saved.append(figure))
    page(EstimateArray(batches, EVEN_RUN, "W", ("v", "u"), {"v": [0, 1, 2], "u": [0, 1, 2, 3]}))
    shown = [
        np.ravel(each.get_array()) for axes in saved[0].axes[:2] for each in axes.images + axes.collections
    ]
    np.testing.assert_allclose(shown[0], values.ravel(), rtol=1e-9)
    np.testing.assert_allclose(shown[1], percent.ravel(), rtol=1e-9)


@pytest.mark.parametrize(
    ("values", "decades"),
    [
        ([1.0, 4.0], None),
        ([0.0, 1e-3, 30.0], 5),
        ([-1.0, 1e-9, 1.0], None),
        ([1e-30, 1e30], 15),
        ([1e-300, 1e300], None),
    ],
)
def test_a_scale_is_logarithmic_over_more_than_a_factor_of_a_thousand(drawn, values, decades):
    array = column(values)
    page(array)
    assert drawn == [(array, decades, "estimate")]


def test_of_many_axes_the_slice_through_the_largest_value_is_shown(drawn):
    values = np.random.default_rng(1).normal(5, 0.1, size=(32, 3, 4, 5, 6))
    values[:, 2, 1, 3, 3] += 100
    edges = {name: np.arange(n + 1.0) for name, n in zip(("x", "y", "mu", "phi"), (3, 4, 5, 6), strict=True)}
    array = EstimateArray(values, EVEN_RUN, "W", tuple(edges), edges)
    seen = page(array).text
    assert "x [m] is 2 … 3 and y [m] is 1 … 2" in seen and str(array[2, 1, 3, 3]) in seen
    np.testing.assert_array_equal(drawn[0][0].value, array.value[2, 1])


def test_a_reading_shows_the_quantity_that_its_detector_is_made_for(drawn, foggy):
    """Of bins of direction the radiance, not the flux density that comes first; of an infinite plane what there is."""
    meter = tp.Detector(
        tp.Disk(center=(0, 0, 1), radius=1.0), "meter", directions=tp.Directions(mu=4), side="back"
    )
    page(
        tp.simulate(tp.Scene(tp.Source(tp.Disk(radius=0.5), tp.Lambertian(power=1.0)), (), meter), 1000)[
            "meter"
        ]
    )
    page(foggy)
    assert [label for *_, label in drawn] == ["radiance", "intensity", "fluence rate"]


def test_of_more_detectors_a_result_has_the_tables_alone(drawn, foggy, monkeypatch):
    monkeypatch.setattr("transport.io.html.results.MAX_UNFOLDED_DETECTORS", 1)
    assert "fluence_rate" in page(foggy).text and drawn == []


def test_a_reading_of_very_many_bins_works_out_one_of_its_quantities(drawn, monkeypatch, foggy):
    result = tp.Result(foggy.plan, foggy.batches, 1, None, True, [])
    top = result[HOSTILE + "top"]
    monkeypatch.setattr(estimates, "MAX_NUMBERS", 100)
    assert "not computed for so many bins" in page(top).text
    assert "intensity" in vars(top) and "intensity_out" not in vars(top) and "radiance" not in vars(top)


def test_without_matplotlib_the_table_names_the_extra(monkeypatch, foggy):
    for name in [name for name in sys.modules if name.startswith(("matplotlib", "transport.viz"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    seen = page(grid(1))
    assert "no picture: matplotlib is not installed; pip install '.[plot]'" in seen.text
    assert repr(grid(1))[15:-1] in seen.text and "img" not in seen.tags
    assert "pip install" in page(tp.tracks(foggy.scene, particles=5)).text


@pytest.mark.quick_cases("empty", "single")
@pytest.mark.parametrize(
    "array",
    [
        grid(1)[:0],
        grid(1)[:1, :1],
        grid(1, exact=True),
        grid(1) * np.nan,
        EstimateArray(np.zeros((len(RUN), 4)), RUN, "W", ("x",), {"x": np.arange(5.0)}),
        column([1.0, 2.0], "time", np.array([0.0, 1e-9])),
        column([1e-300, 1e300]),
        column([-1.0, np.inf, 3.0]),
        column(np.ones(9), "speed", np.r_[np.arange(9.0), np.inf]),
        EstimateArray(np.ones((1, 3, 1)), Batches([5]), "1", ("x", "y"), {"x": [0, 1, 2, 3], "y": [0, 1]}),
    ],
    ids=["empty", "single", "exact", "nan", "zero", "instants", "far apart", "infinite", "endless bin", "one batch"],
)  # fmt: skip
def test_odd_arrays_have_a_page(array):
    assert "EstimateArray" in page(array).text


@pytest.mark.slow
@pytest.mark.parametrize("shape", [(1_000_000,), (1000, 1000), (100, 100, 100)], ids=str)
def test_a_million_bins_take_little_time_and_make_no_long_page(shape, drawn):
    names = ("x", "y", "z")[: len(shape)]
    values = np.random.default_rng(1).normal(5, 1, size=(2, *shape))
    edges = {name: np.linspace(0, 1, n + 1) for name, n in zip(names, shape, strict=True)}
    array = EstimateArray(values, Batches([5, 5]), "W", names, edges)
    repr(array)
    start = time.process_time()
    html = array._repr_html_()
    assert len(html) < 60_000 and time.process_time() - start < 2.0  # a tenth of that on a quiet machine
    assert len(drawn) == (len(shape) == 3)  # a slice of 1e4 bins, and no picture of 1e6


# Any page


@pytest.mark.slow
def test_no_name_breaks_the_page(foggy):
    for thing in (foggy, foggy.scene, foggy.ledger, *(foggy[name] for name in foggy)):
        seen = page(thing)
        assert not {"script", "i"} & set(seen.tags)
        assert all(not name.startswith("on") for attributes in seen.attributes for name in attributes)
        assert all(a["src"].startswith("data:image/png;base64,") for a in seen.attributes if "src" in a)
        if thing is not foggy.ledger:
            assert HOSTILE in seen.said


def test_the_colour_of_warnings_is_seen_on_light_and_dark():
    """Contrast of 3 for graphics (WCAG 2.2, 1.4.11), on white and on Jupyter's dark grey."""
    (colour,) = set(re.findall(r"#[0-9a-f]{6}", STYLE))
    shine = _shine(colour)
    assert (1.05 / (shine + 0.05)) > 2.8 and (shine + 0.05) / (_shine("#111111") + 0.05) > 3


def _shine(colour):
    channels = np.array(list(bytes.fromhex(colour[1:]))) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def test_html_is_imported_without_matplotlib():
    for name in ("estimates", "pictures", "results", "scenes"):
        code = vars(importlib.import_module(f"transport.io.html.{name}"))
        assert not any(getattr(each, "__name__", "").startswith("matplotlib") for each in code.values())


def test_the_parser_sees_what_is_broken():
    Page(framed("<b>well</b>"))
    for broken in ("<b>open", "<td><b></td></b>", '<i a="1" a="2"></i>'):
        with pytest.raises((AssertionError, IndexError)):
            Page(broken)


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
def test_a_browser_draws_it_in_both_themes_and_asks_nothing_of_the_network(tmp_path, foggy):
    parts = "".join(each._repr_html_() for each in (foggy, grid(1), column([1.0, 2.0])))
    with Browser(tmp_path / "profile") as browser:
        for ground, ink in (("#ffffff", "#000000"), ("#111111", "#ffffff")):
            path, style = tmp_path / f"{ground[1:]}.html", f"background:{ground};color:{ink}"
            path.write_text(f"<meta charset=utf-8><body style='{style}'>{parts}", encoding="utf-8")
            browser.open(path, "document.readyState == 'complete'")
            assert browser.value("document.querySelectorAll('div.tp script, parsererror').length") == 0
            picture = browser.picture().astype(int)
            back = np.array(list(bytes.fromhex(ground[1:])))
            assert 0.02 < np.mean(np.abs(picture - back).max(axis=2) > 100) < 0.5
        assert browser.complaints == []
        assert all(address.startswith(("file:", "data:", "about:")) for address in browser.requests)


def test_positions_on_a_sphere_are_in_degrees_and_on_a_rectangle_in_metres():
    ball, plate = tp.Sphere(radius=1.0), tp.Rectangle(center=(0, 0, 2), width=2, height=1)
    lamp = tp.Source(tp.Disk(center=(0, 0, 3), normal=(0, 0, -1), radius=1), tp.Lambertian(power=1.0))
    meters = [
        tp.Detector(ball, "ball", positions=tp.Positions(polar_angle=3, azimuth=2)),
        tp.Detector(plate, "plate", positions=tp.Positions(x=4)),
    ]
    result = tp.simulate(tp.Scene(lamp, detectors=meters), 1000, seed=1, progress=False)
    page = result["ball"].irradiance._repr_html_()
    assert "u [°]" in page and "60 … 120" in page and "180 … 360" in page
    page = result["plate"].irradiance._repr_html_()
    assert "u [m]" in page and "−1 … −0.5" in page
