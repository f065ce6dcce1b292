"""Arrays in a notebook: bars, lines and maps of their values, and of their errors, as one expects them to lie."""

import base64
import math
import re
import time
import zlib

import numpy as np
import pytest

import transport as tp
from tests.html_pages import column, page
from tests.synthetic import EVEN_RUN, RUN, grid
from transport.io.html.charts import HEIGHT, bar_thumbnail, block_edges, block_means, scale_of
from transport.io.html.maps import VIRIDIS, png_url, shade
from transport.statistics.estimates import EstimateArray


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
    seen, top = page(array), np.max(array.value + 2 * array.error)
    heights = [float(a["height"]) for tag, a in zip(seen.tags, seen.attributes, strict=True) if tag == "rect"]
    assert heights == pytest.approx(np.array([1, 4, 2]) * HEIGHT / top, abs=0.06)
    whiskers = [a["d"] for a in seen.attributes if "d" in a and "V" in a["d"]]
    low, high = (float(y) for y in re.fullmatch(r"M[\d.]+ ([\d.]+)V([\d.]+)", whiskers[1]).groups())
    assert low - high == pytest.approx(4 * array.error[1] * HEIGHT / top, abs=0.11)


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
    means, sizes = block_means(numbers, (4,))
    assert sizes == (3,)
    np.testing.assert_array_equal(means, [1.0, 4.5, 7.0, 9.0])
    np.testing.assert_array_equal(block_edges(np.arange(11.0), 10, 3), [0, 3, 6, 9, 10])
    square, _ = block_means(np.arange(12.0).reshape(3, 4), (2, 2))
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
    [
        (("v", "u"), "top right"),
        (("theta", "phi"), "bottom left"),
        (("mu", "phi"), "top left"),
        (("x", "vx"), "top right"),
    ],
    ids=lambda value: str(value),
)
def test_maps_lie_as_one_expects(names, brightest):
    """Up and to the right; places go across.

    Of directions, seen from inside, the zenith is on top and azimuth grows to the left.
    """
    values = np.arange(1.0, 7.0).reshape(2, 3) * (1 + 0.01 * np.tile([-1.0, 1.0], 16)[:, None, None])
    edges = {names[0]: [0, 0.5, 1], names[1]: [0, 1, 2, 3]}
    seen = page(EstimateArray(values, EVEN_RUN, "W", names, edges))
    maps = [a["href"] for tag, a in zip(seen.tags, seen.attributes, strict=True) if tag == "image"]
    columns = 2 if names[0] == "x" else 3
    rows = _shades(maps[0]).reshape(-1, columns + 1)[:, 1:]
    place = np.unravel_index(np.argmax(rows), rows.shape)
    assert place == (0 if "top" in brightest else len(rows) - 1, columns - 1 if "right" in brightest else 0)
    assert len(maps) == 4 and "relative standard error [%]" in seen.text


def test_a_lamp_in_the_notebooks_map_is_on_the_side_on_which_a_camera_sees_it():
    """At (2, 2, 0), from the origin: right of +y.  The ends of the axis are labelled where they are."""
    (shades, _), words = _maps_of(_map_of_a_lamp().radiance)
    lamp, ahead = np.argwhere(shades == shades.max())[:, 1].mean(), shades.shape[1] * 3 / 4  # +y is at 90°
    assert lamp > ahead
    axis = "φ [°], seen from inside"
    assert words[words.index(axis) - 1 :][:3] == ["360", axis, "0"]


def _map_of_a_lamp():
    lamp = tp.Source(tp.Sphere(center=(2, 2, 0), radius=0.2), tp.Lambertian(radiance=3.0))
    around = tp.EnvironmentMap(name="map", position=(0, 0, 0), theta=9, phi=16)
    return tp.simulate(tp.Scene([lamp], (), [around]), 50_000, progress=False)["map"]


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
        r'y="([\d.]+)"[^/]*? height="([\d.]+)"', bar_thumbnail(np.array([1.0, 4.0]), np.arange(3.0))
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
            tp.statistics.estimates.Batches([5]),
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
    array = EstimateArray(values, tp.statistics.estimates.Batches([5, 5]), "W", names, edges)
    repr(array)
    start = time.process_time()
    html = array._repr_html_()
    assert len(html) < 60_000
    assert time.process_time() - start < 2.0  # a tenth of that in peace
