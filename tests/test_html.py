"""In a notebook objects say what their text says, in HTML that is well-formed whatever their names are."""

import ast
import base64
import math
import re
import sys
import time
import zlib
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import transport as tp
from tests import plain_scenes
from tests.browser import CHROMIUM, Browser
from tests.synthetic import EVEN_RUN, RUN, grid, noisy
from transport.html.bars import FILL, HEIGHT, thumbnail
from transport.html.elements import STYLE, framed
from transport.html.gathering import gathered, gathered_edges
from transport.html.rasters import VIRIDIS, png_url, shade
from transport.html.scales import scale_of
from transport.html.scenes import MOST_ROWS
from transport.html.typesetting import plain_typeset, typeset
from transport.pricing.slopes import Pace
from transport.pricing.ways import Point, Way
from transport.results.estimates import Estimate, EstimateArray

VOID = {"br", "img", "hr"}
HOSTILE = """<i>"meter"</i> & co <script>alert(1)</script> e-9 ^2 {} %s"""


class Page(HTMLParser):
    """The tags of a piece of HTML, checked to close in order, and the text between them."""

    def __init__(self, html):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.attributes, self.said, self.styles = [], [], [], "", []
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        names = [name for name, _ in attributes]
        assert len(set(names)) == len(names)
        self.tags.append(tag)
        self.attributes.append(dict(attributes))
        if tag not in VOID:
            self.open.append(tag)
        if tag == "sup":
            self.said += "^" if self.said[-1:].isalpha() else ""

    def handle_startendtag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes.append(dict(attributes))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        self.said += "\n" if tag in ("td", "th", "div", "summary") else ""

    def handle_data(self, data):
        if self.open[-1:] == ["style"]:
            self.styles.append(data)
        else:
            self.said += data.replace("−", "-")

    @property
    def text(self):
        """What it says in the notation of the project's text."""
        said = re.sub(r"\^(-?\d+/\d+)", r"^(\1)", self.said)
        return re.sub(r"\xa0×\xa010(-?)(\d+)", lambda hit: f"e{hit[1] or '+'}{int(hit[2]):02d}", said)


def page(thing):
    return Page(thing._repr_html_())


def number(value, error, unit="W"):
    signs = np.tile([-1.0, 1.0], 16)
    return Estimate(value + error * math.sqrt(31) * signs, EVEN_RUN, unit)


def column(values, name="x", edges=None, **options):
    """An array along one axis of which the batches all but agree."""
    values = np.asarray(values, dtype=float)
    signs = np.tile([-1.0, 1.0], 16)[:, None]
    edges = np.linspace(0, 1, len(values) + 1) if edges is None else edges
    return EstimateArray(
        values * (1 + 0.01 * math.sqrt(31) * signs), EVEN_RUN, "W m^-2", (name,), {name: edges}, **options
    )


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


# What it says


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
def test_an_estimate_says_what_its_text_says(estimate):
    assert str(estimate) in page(estimate).text


def test_numbers_are_set_as_in_print():
    assert (
        typeset("(-2.938 ± 0.009)e-09 W m^-2 sr^-1")
        == "(−2.938 ± 0.009)\xa0×\xa010<sup>−9</sup> W m<sup>−2</sup> sr<sup>−1</sup>"
    )
    assert typeset("5e+04 m^(1/2)") == "5\xa0×\xa010<sup>4</sup> m<sup>1/2</sup>"
    assert plain_typeset("-1e-12 m^-6 s^3") == "−1\xa0×\xa010⁻¹² m⁻⁶ s³"
    assert typeset("x-ray <a> at-3") == "x-ray &lt;a&gt; at-3"


def test_a_result_says_what_its_report_says(foggy):
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


def test_shares_of_what_was_emitted_are_bars_of_that_length(foggy):
    widths = [
        float(a["width"])
        for a in page(foggy.ledger).attributes
        if a.get("height") == "9" and "opacity" not in a
    ]
    assert foggy.ledger["absorbed"].value / foggy.ledger["emitted"].value == pytest.approx(
        widths[3] / 100, abs=1e-4
    )


def test_an_interrupted_run_says_so(foggy):
    half = tp.Result(foggy.plan, foggy.batches[:5], 1, None, False, ["a word of <warning>"])
    assert "INCOMPLETE" in page(half).text and "a word of <warning>" in page(half).text


def test_a_scene_says_what_is_in_it():
    lamp = tp.Source(tp.Disk(radius=0.25), tp.Lambertian(radiance=3.0))
    ball = tp.Surface(tp.Sphere(radius=0.5), tp.Dielectric(index_inside=1.5), "ball")
    seen = page(
        tp.Scene(lamp, ball, tp.Detector("ball", "skin", directions=tp.Directions(mu=(0, 0.5, 1))))
    ).text
    for part in (
        "Disk(radius=0.25)",
        "Lambertian(radiance=3)",
        "Sphere(radius=0.5)",
        "Dielectric(index_inside=1.5)",
        "skin",
        "Directions(mu=(0, 0.5, 1))",
    ):
        assert part in seen
    assert "None" not in seen and "299792458" not in seen


@pytest.mark.parametrize("make", plain_scenes.SCENES.values(), ids=list(plain_scenes.SCENES))
def test_scenes_of_every_kind_are_told(make):
    scene = make()
    seen = page(scene).text
    assert seen.startswith("Scene")
    named = (*scene.surfaces[:MOST_ROWS], *scene.detectors[:MOST_ROWS])
    assert all(part.name in seen for part in named if part.name)
    assert "None" not in seen and "299792458" not in seen


def test_prices_say_what_their_text_says():
    tried = Point(1000, 2, 0.1, 0.1, math.nan, math.nan, math.nan)
    ways = tuple(
        Way(name, (tried,), None, None, Pace(0.0, 1e-6), 0.25, math.nan) for name in ("analog", HOSTILE)
    )
    cost = tp.CostOfAccuracy(
        "meter.flux_in", "W", 2.5e-7, "exact", ways, (0.01, 1e-8), {"backward <i>": "no"}, "a <machine>", 1
    )
    seen = page(cost).text
    words = {
        word
        for line in str(cost).splitlines()
        if "particles of the largest" not in line
        for word in line.split()
    }
    assert {word for word in words if word not in seen} == set()
    assert page(cost).tags.count("tr") == 3 and not {"script", "i"} & set(page(cost).tags)


# Arrays


def test_an_array_tells_its_range_and_some_of_its_bins():
    array = grid(1)
    seen = page(array)
    assert repr(array)[15:-1] in seen.text
    place = np.unravel_index(np.argmax(array.value), array.shape)
    assert str(array[place]) in seen.text
    few = column([1.0, 2.0, 3.0])
    assert all(str(each) in page(few).text for each in few)


def test_bars_are_as_high_as_the_values_and_whiskers_two_errors_long():
    array = column([1.0, 4.0, 2.0])
    seen = page(array)
    heights = [float(a["height"]) for tag, a in zip(seen.tags, seen.attributes, strict=True) if tag == "rect"]
    assert heights == pytest.approx(np.array([1, 4, 2]) * HEIGHT / (4 * 1.02), abs=0.06)
    whiskers = [a["d"] for a in seen.attributes if "d" in a and "V" in a["d"]]
    low, high = (float(y) for y in re.fullmatch(r"M[\d.]+ ([\d.]+)V([\d.]+)", whiskers[1]).groups())
    assert low - high == pytest.approx(4 * array.error[1] * HEIGHT / 4.08, abs=0.11)


def test_bars_of_unknown_errors_are_pale_and_without_whiskers():
    values = np.ones((32, 3))
    values[:, 0] += np.tile([-0.1, 0.1], 16)
    seen = page(EstimateArray(values, EVEN_RUN, "W", ("x",), {"x": [0, 1, 2, 3]}))
    assert [a.get("opacity") for t, a in zip(seen.tags, seen.attributes, strict=True) if t == "rect"] == [
        None,
        ".4",
        ".4",
    ]
    assert sum("V" in a.get("d", "") for a in seen.attributes) == 1


def test_scales_hold_zero_or_whole_decades():
    plain = scale_of(np.array([2.0, -1.0]), np.array([2.0, -1.0]))
    assert (plain.place(-1.0), plain.place(2.0), plain.is_log) == (0.0, 1.0, False)
    decades = scale_of(np.array([2e-9, 30.0]), np.array([2e-9, 30.0]))
    assert (decades.low, decades.high, decades.is_log) == pytest.approx((1e-9, 100.0, True))
    assert decades.place(1e-9) == 0 and decades.place(1e-4) == pytest.approx(5 / 11)
    nothing = scale_of(np.full(2, np.nan), np.full(2, np.nan))
    assert nothing.place(0.0) == 0.0


def test_blocks_of_bins_are_their_means():
    numbers = np.arange(10.0)
    numbers[3] = np.nan
    means, sizes = gathered(numbers, (4,))
    assert sizes == (3,)
    np.testing.assert_array_equal(means, [1.0, 4.5, 7.0, 9.0])
    np.testing.assert_array_equal(gathered_edges(np.arange(11.0), 10, 3), [0, 3, 6, 9, 10])
    square, _ = gathered(np.arange(12.0).reshape(3, 4), (2, 2))
    np.testing.assert_array_equal(square, [[2.5, 4.5], [8.5, 10.5]])


def test_a_raster_is_a_png_of_its_numbers():
    """Read back by another program; what is not known is transparent."""
    image = pytest.importorskip("matplotlib.image")
    import io

    url = png_url(shade(np.array([[0.0, 1.0], [np.nan, 0.5]]), 0.0, 1.0), VIRIDIS)
    pixels = image.imread(io.BytesIO(base64.b64decode(url.partition(",")[2])))
    assert pixels.shape == (2, 2, 4)
    for (row, col), colour in {(0, 0): VIRIDIS[0], (0, 1): VIRIDIS[-1]}.items():
        np.testing.assert_allclose(255 * pixels[row, col, :3], list(bytes.fromhex(colour)), atol=0.6)
    np.testing.assert_array_equal(pixels[..., 3], [[1, 1], [0, 1]])
    np.testing.assert_allclose(pixels[1, 1, :3], [0.129, 0.569, 0.551], atol=0.02)  # viridis at 0.5


def _shades(url):
    data = base64.b64decode(url.partition(",")[2])
    at = data.index(b"IDAT")
    return np.frombuffer(zlib.decompress(data[at + 4 : at + 4 + int.from_bytes(data[at - 4 : at])]), np.uint8)


@pytest.mark.parametrize(
    ("names", "brightest"),
    [(("v", "u"), "top right"), (("theta", "phi"), "bottom right"), (("x", "vx"), "top right")],
    ids=lambda value: str(value),
)
def test_maps_lie_as_one_expects(names, brightest):
    """Up and to the right, but for the polar angle, whose zenith is on top; places go across."""
    values = np.arange(1.0, 7.0).reshape(2, 3) * (1 + 0.01 * np.tile([-1.0, 1.0], 16)[:, None, None])
    edges = {names[0]: [0, 1, 2], names[1]: [0, 1, 2, 3]}
    seen = page(EstimateArray(values, EVEN_RUN, "W", names, edges))
    maps = [a["href"] for tag, a in zip(seen.tags, seen.attributes, strict=True) if tag == "image"]
    columns = 2 if names[0] == "x" else 3
    rows = _shades(maps[0]).reshape(-1, columns + 1)[:, 1:]
    place = np.unravel_index(np.argmax(rows), rows.shape)
    assert place == (0 if "top" in brightest else len(rows) - 1, columns - 1)
    assert len(maps) == 4 and "relative standard error [%]" in seen.text


def _maps_of(array):
    """The shades of the maps of values and of errors, rows from the top; and what the picture says, word by word."""
    html = array._repr_html_()
    urls = re.findall(r'href="(data:[^"]*)"', html)[::2]  # between them those of the bars
    columns = [int.from_bytes(base64.b64decode(url.partition(",")[2])[16:20]) for url in urls]
    shades = [_shades(url).reshape(-1, n + 1)[:, 1:] for url, n in zip(urls, columns, strict=True)]
    return shades, re.findall(r">([^<>]+)</text>", html)


def test_maps_have_the_shades_of_their_values_and_of_their_errors():
    """Values over decades, so their shades are logarithms; errors of 1, 2 and 3 percent, of which the least is not dark."""
    values, percent = np.array([[1.0, 100.0, 1e4]] * 2), np.array([[3.0, 1.0, 2.0]] * 2)
    batches = values * (1 + percent / 100 * math.sqrt(31) * np.tile([-1.0, 1.0], 16)[:, None, None])
    array = EstimateArray(batches, EVEN_RUN, "W", ("v", "u"), {"v": [0, 1, 2], "u": [0, 1, 2, 3]})
    (shades, errors), words = _maps_of(array)
    np.testing.assert_allclose(shades, [[0, 127, 254]] * 2, atol=1)
    np.testing.assert_allclose(errors, [[254, 254 / 3, 254 * 2 / 3]] * 2, atol=1)
    assert "value [W], log" in words and words[-2:] == ["0", "3"]


def test_unlike_bins_of_a_map_are_as_wide_as_they_are():
    values = np.array([[1.0, 2.0], [3.0, 4.0]]) * (1 + 0.01 * np.tile([-1.0, 1.0], 16)[:, None, None])
    array = EstimateArray(values, EVEN_RUN, "W", ("v", "u"), {"v": [0, 1, 2], "u": [0.0, 0.9, 1.0]})
    (shades, _), _ = _maps_of(array)
    assert shades.shape == (2, 190)
    assert [len(np.unique(row[:171])) for row in shades] == [1, 1]
    np.testing.assert_allclose(shades[:, [170, 171]] / 254 * 4, [[3, 4], [1, 2]], atol=0.02)


def test_bars_of_a_line_s_height_stand_on_zero():
    drawn = re.findall(
        r'y="([\d.]+)"[^/]*? height="([\d.]+)"', thumbnail(np.array([1.0, 4.0]), np.arange(3.0))
    )
    np.testing.assert_allclose(np.array(drawn, dtype=float), [[15, 5], [0, 20]])


def test_of_many_axes_the_cut_through_the_largest_value_is_told():
    values = np.random.default_rng(1).normal(5, 0.1, size=(32, 3, 4, 5, 6))
    values[:, 2, 1, 3, 3] += 100
    edges = {name: np.arange(n + 1.0) for name, n in zip(("x", "y", "mu", "phi"), (3, 4, 5, 6), strict=True)}
    array = EstimateArray(values, EVEN_RUN, "W", tuple(edges), edges)
    seen = page(array).text
    assert "x [m] is 2 … 3 and y [m] is 1 … 2" in seen
    assert str(array[2, 1, 3, 3]) in seen


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
        EstimateArray(
            np.ones((1, 3, 1)),
            tp.results.estimates.Batches([5]),
            "1",
            ("x", "y"),
            {"x": [0, 1, 2, 3], "y": [0, 1]},
        ),
    ],
    ids=[
        "empty",
        "single",
        "exact",
        "nan",
        "zero",
        "instants",
        "far apart",
        "infinite",
        "endless bin",
        "one batch",
    ],
)
def test_odd_arrays_are_told(array):
    seen = page(array)
    assert "EstimateArray" in seen.text
    numbers = " ".join(f"{a.get(n, '')}" for a in seen.attributes for n in ("x", "y", "d", "width", "height"))
    assert not re.search("nan|inf", numbers)


@pytest.mark.parametrize("shape", [(1_000_000,), (1000, 1000), (100, 100, 100)], ids=str)
def test_a_million_cells_cost_little_and_make_no_long_page(shape):
    names = ("x", "y", "z")[: len(shape)]
    values = np.random.default_rng(1).normal(5, 1, size=(2, *shape))
    edges = {name: np.linspace(0, 1, n + 1) for name, n in zip(names, shape, strict=True)}
    array = EstimateArray(values, tp.results.estimates.Batches([5, 5]), "W", names, edges)
    repr(array)
    start = time.process_time()
    html = array._repr_html_()
    assert len(html) < 60_000
    assert time.process_time() - start < 2.0  # a tenth of that in peace


def test_a_reading_of_very_many_bins_works_out_one_of_its_quantities(monkeypatch, foggy):
    from transport.html import readings

    result = tp.Result(foggy.plan, foggy.batches, 1, None, True, [])
    top = result[HOSTILE + "top"]
    monkeypatch.setattr(readings, "HEAVY", 100)
    assert "not worked out unasked" in page(top).text
    assert "intensity" in vars(top) and "intensity_out" not in vars(top)


# Other objects


def test_tracks_are_counted_and_drawn(foggy):
    found = tp.tracks(foggy.scene, particles=50, seed=1)
    seen = page(found)
    assert repr(found).strip("<>").removeprefix("Tracks ") in seen.text
    assert f"flights\n{len(found)}" in seen.text
    lines = " ".join(a["d"] for a in seen.attributes if "d" in a)
    ends = [tuple(map(float, line)) for line in re.findall(r"M(\S+) (\S+)L(\S+) (\S+?)(?=M|\s|$)", lines)]
    assert len(ends) == min(len(found), 400)
    across = float(re.search(r"z up, ([\d.]+) m across", seen.text)[1])
    lengths = np.where(np.isfinite(found.lengths), found.lengths, 0.2 * across)
    rises = np.sort(lengths * found.directions[:, 2]) * 200 / across
    np.testing.assert_allclose(np.sort([y0 - y1 for _, y0, _, y1 in ends]), rises, rtol=0.01, atol=0.3)


def test_phase_spaces_and_snapshots_are_told():
    box = tp.Box(size=2.0)
    light = tp.Source(tp.Point(), tp.Isotropic(energy=1.0), pulse=tp.Instant())
    looks = [
        tp.PhaseSpace(name=HOSTILE, time=1e-9, x=np.linspace(-1, 1, 5)),
        tp.Snapshot(name=HOSTILE + "s", time=1e-9, particles=100),
    ]
    moving = tp.simulate(
        tp.Scene(light, tp.Surface(box, tp.Black()), looks, duration=2e-9), particles=500, seed=1, threads=1
    )
    seen = page(moving[HOSTILE]).text
    assert "phase space" in seen and repr(moving[HOSTILE].number)[15:-1] in seen
    assert "100 particles at 1e-09 s" in page(moving[HOSTILE + "s"]).text
    assert "positions" in page(moving[HOSTILE + "s"]).text and "snapshot" in page(moving).text


# Manners


def test_no_name_breaks_the_page(foggy):
    for thing in (foggy, foggy.scene, foggy.ledger, *(foggy[name] for name in foggy)):
        seen = page(thing)
        assert not {"script", "i"} & set(seen.tags)
        assert all(not name.startswith("on") for attributes in seen.attributes for name in attributes)
        if thing is not foggy.ledger:
            assert HOSTILE in seen.said


def test_colours_are_the_pages_own_or_seen_on_light_and_dark():
    """Contrast of 3 for graphics (WCAG 2.2, 1.4.11), on white and on Jupyter's dark grey."""
    used = set(re.findall(r"#[0-9a-f]{6}", STYLE)) | {FILL}
    assert len(used) == 2
    for colour in used:
        shine = _shine(colour)
        assert (1.05 / (shine + 0.05)) > 2.8 and (shine + 0.05) / (_shine("#111111") + 0.05) > 3


def _shine(colour):
    channels = np.array(list(bytes.fromhex(colour[1:]))) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def test_html_needs_nothing_but_numpy():
    folder = Path(tp.__file__).parent / "html"
    known = {*sys.stdlib_module_names, "numpy", "transport"}
    for path in sorted(folder.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = (
                [a.name for a in node.names]
                if isinstance(node, ast.Import)
                else [node.module]
                if isinstance(node, ast.ImportFrom)
                else []
            )
            assert {name.partition(".")[0] for name in names} <= known, path.name


def test_the_parser_sees_what_is_broken():
    Page(framed("<b>well</b>"))
    for broken in ("<b>open", "<td><b></td></b>", '<i a="1" a="2"></i>'):
        with pytest.raises((AssertionError, IndexError)):
            Page(broken)


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
def test_a_browser_draws_it_in_both_themes(tmp_path, foggy):
    parts = "".join(each._repr_html_() for each in (foggy, grid(1), column([1.0, 2.0])))
    with Browser(tmp_path / "profile") as browser:
        for ground, ink in (("#ffffff", "#000000"), ("#111111", "#ffffff")):
            path = tmp_path / f"{ground[1:]}.html"
            path.write_text(
                f"<meta charset=utf-8><body style='background:{ground};color:{ink}'>{parts}", encoding="utf-8"
            )
            browser.open(path, "document.readyState == 'complete'")
            assert browser.value("document.querySelectorAll('div.tp script, parsererror').length") == 0
            picture = browser.picture().astype(int)
            back = np.array(list(bytes.fromhex(ground[1:])))
            assert 0.02 < np.mean(np.abs(picture - back).max(axis=2) > 100) < 0.5
        assert browser.complaints == []
        assert all(address.startswith(("file:", "data:", "about:")) for address in browser.requests)
