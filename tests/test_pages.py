"""Pages of HTML: what VTK would draw is what they hold, and a browser without a network draws them."""

from __future__ import annotations

import base64
import json
import math
import re
import time
import zlib

import numpy as np
import pytest

import transport as tp
from tests.browser import CHROMIUM, Browser
from transport.viz.page import as_html, page, scene_page
from transport.viz.screen import has_screen

pv = pytest.importorskip("pyvista")
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
needs_screen = pytest.mark.skipif(not has_screen(), reason="no OpenGL here")
BACKGROUND = np.array([0x0D, 0x10, 0x17])


@pytest.fixture
def plotter():
    """A red square at z = 0, lit by nothing; above it one blue line, and a colour bar of three decades."""
    made = pv.Plotter(off_screen=True)
    made.set_background("#0d1017")
    square = pv.Plane(i_size=2, j_size=2, i_resolution=1, j_resolution=1)
    made.add_mesh(square, color="#ff0000", lighting=False)
    line = pv.Line(pointa=(-1, 0, 1), pointb=(1, 0, 1), resolution=4)
    line.cell_data["E"] = [1.0]
    bar = {"title": r"$E\;[\mathrm{W\,m^{-2}}]$"}
    made.add_mesh(line, scalars="E", clim=(1e-3, 1), log_scale=True, cmap="Blues", scalar_bar_args=bar)
    made.camera_position = [(0, 0, 8), (0, 0, 0), (0, 1, 0)]
    yield made
    made.close()


def read(path):
    """What a page holds: its description, and each part's corners (n, 3) and colours (n, 4)."""
    text = path.read_text(encoding="utf-8")
    told = json.loads(re.search(r"const scene = (\{.*\});", text)[1])
    held = zlib.decompress(base64.b64decode(re.search(r'const bytes = "(.*)"', text)[1]))
    corners = [np.frombuffer(held, "<f4", 3 * p["count"], p["places"]).reshape(-1, 3) for p in told["parts"]]
    colours = [np.frombuffer(held, "u1", 4 * p["count"], p["tints"]).reshape(-1, 4) for p in told["parts"]]
    return told, corners, colours


def area(corners):
    edges = corners.reshape(-1, 3, 3)
    return np.linalg.norm(np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0]), axis=1).sum() / 2


def length(corners):
    return np.linalg.norm(np.diff(corners.reshape(-1, 2, 3), axis=1), axis=-1).sum()


def test_a_page_holds_the_area_the_length_and_the_colours_of_what_is_drawn(plotter, tmp_path):
    told, corners, colours = read(page(plotter, tmp_path / "page.html", "A page"))
    assert [part["kind"] for part in told["parts"]] == ["triangles", "lines"]
    size = np.sqrt(1 + 1 + 0.25)  # from the middle of all to a corner of the square
    np.testing.assert_allclose([area(corners[0]) * size**2, length(corners[1]) * size], [4, 2], rtol=1e-6)
    assert set(map(tuple, colours[0])) == {(255, 0, 0, 255)}
    assert set(map(tuple, colours[1])) == {(8, 48, 107, 255)}  # the end of the colour map, at 1
    [bar] = told["bars"]
    assert bar["title"] == "E\u2009[W\u2009m<sup>−2</sup>]"
    assert [label for _, label in bar["labels"]] == ["10⁻³", "0.01", "0.1", "1"]
    np.testing.assert_allclose([place for place, _ in bar["labels"]], [0, 1 / 3, 2 / 3, 1], atol=1e-12)


@pytest.mark.parametrize("style, kind, measure, whole", [
    ("surface", "triangles", area, 6.0), ("wireframe", "lines", length, 12.0), ("points", "points", len, 8),
])  # fmt: skip
def test_a_box_is_its_faces_its_edges_or_its_corners(style, kind, measure, whole, tmp_path):
    plotter = pv.Plotter(off_screen=True)
    plotter.add_mesh(pv.Cube(), style=style)
    told, corners, _ = read(page(plotter, tmp_path / "page.html", "A box"))
    plotter.close()
    [part] = told["parts"]
    scale = {"triangles": 0.75, "lines": np.sqrt(0.75), "points": 1}[kind]
    assert part["kind"] == kind
    assert measure(corners[0]) * scale == pytest.approx(whole, rel=1e-6)


def test_each_cell_and_each_point_keeps_its_own_colour(tmp_path):
    """Black where x < 0 and white where x > 0: told by cells, and by points of another mesh."""
    plotter = pv.Plotter(off_screen=True)
    for at, level in (("cell_data", 0), ("point_data", 1)):
        grid = pv.Plane(i_resolution=4, j_resolution=3, center=(0, 0, level))
        places = grid.cell_centers().points if at == "cell_data" else grid.points
        getattr(grid, at)["side"] = np.sign(places[:, 0])
        plotter.add_mesh(grid, scalars="side", cmap="gray", clim=(-1, 1), lighting=False)
    _, corners, colours = read(page(plotter, tmp_path / "page.html", "Two halves"))
    plotter.close()
    centres = corners[0].reshape(-1, 3, 3).mean(axis=1)
    np.testing.assert_array_equal(colours[0][::3, 0], np.where(centres[:, 0] > 0, 255, 0))
    off = np.abs(corners[1][:, 0]) > 1e-6
    np.testing.assert_array_equal(colours[1][off, 0], np.where(corners[1][off, 0] > 0, 255, 0))


def test_a_scene_as_large_as_the_way_to_the_sun_keeps_its_small_parts(tmp_path):
    """Single precision is spent on what is drawn, not on where it is: a square of 1 m, 150 million km away."""
    plotter = pv.Plotter(off_screen=True)
    square = pv.Plane(center=(0, 0, 0), i_resolution=1, j_resolution=1)
    square.points = square.points.astype(float) + [1.5e11, 0, 0]
    plotter.add_mesh(square)
    _, corners, _ = read(page(plotter, tmp_path / "page.html", "Far"))
    plotter.close()
    assert area(corners[0]) * 0.5 == pytest.approx(1.0, rel=1e-4)


def test_titles_are_text_and_not_markup(plotter, tmp_path):
    path = page(plotter, tmp_path / "page.html", "<b>a & b</b>", note="</script>")
    text = path.read_text(encoding="utf-8")
    assert "<title>&lt;b&gt;a &amp; b&lt;/b&gt;</title>" in text
    assert text.count("</script>") == 1
    assert as_html(r"$\mathrm{m^{-2}\,sr^{-1}}$ & more") == "m<sup>−2</sup>\u2009sr<sup>−1</sup> &amp; more"


@pytest.fixture
def cloud():
    """A grid that is empty for x < 0 and white fog for x > 0, seen along -z."""
    grid = pv.ImageData(dimensions=(20, 10, 10), spacing=(0.1, 0.1, 0.1), origin=(-0.95, -0.45, -0.45))
    grid.point_data["extinction"] = (grid.points[:, 0] > 0).astype(float)
    made = pv.Plotter(off_screen=True)
    made.set_background("#0d1017")
    made.add_volume(
        grid,
        cmap=["#ffffff", "#ffffff"],
        opacity=[0.0, 0.5],
        opacity_unit_distance=0.2,
        show_scalar_bar=False,
    )
    made.camera_position = [(0, 0, 5), (0, 0, 0), (0, 1, 0)]
    yield made
    made.close()


def test_a_volume_is_its_grid_and_the_depth_and_colour_of_each_value(cloud, tmp_path):
    path = page(cloud, tmp_path / "cloud.html", "A cloud")
    told, corners, _ = read(path)
    [part] = told["parts"]
    held = zlib.decompress(base64.b64decode(re.search(r'const bytes = "(.*)"', path.read_text())[1]))
    cells = np.frombuffer(held, "u1", 2000, part["cells"]).reshape(10, 10, 20)
    table = np.frombuffer(held, "u1", 1024, part["table"]).reshape(256, 4)
    assert (cells[:, :, :10] == 0).all() and (cells[:, :, 10:] == 255).all()
    diagonal = np.linalg.norm(np.ptp(corners[0], axis=0))
    depth = part["deepest"] * (table[[0, 255], 3] / 255.0) ** 2
    length = np.linalg.norm([1.9, 0.9, 0.9])
    np.testing.assert_allclose(depth, [0, np.log(2) * length / 0.2], rtol=0.02)
    assert diagonal == pytest.approx(2.0)  # in halves of it
    assert tuple(table[255, :3]) == (255, 255, 255)


@pytest.mark.slow
@needs_browser
def test_a_browser_draws_the_page_turns_it_and_asks_nothing_of_the_network(plotter, cloud, tmp_path):
    path = page(plotter, tmp_path / "page.html", "A red square")
    with Browser(tmp_path / "profile") as browser:
        browser.open(path, "window.drawn > 0")
        before = browser.picture()
        reds = (before == [255, 0, 0]).all(axis=2)
        across, down = reds.any(axis=0).sum(), reds.any(axis=1).sum()
        assert across > 100
        assert down == pytest.approx(across, rel=0.03)  # a square, seen along its normal
        middle = (before.shape[1] / 2, before.shape[0] / 2)
        browser.drag(middle, (middle[0], middle[1] - 0.2 * before.shape[0]))
        browser.value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        after = (browser.picture() == [255, 0, 0]).all(axis=2).any(axis=1).sum()
        assert after < 0.9 * down  # foreshortened
        fog = page(cloud, tmp_path / "cloud.html", "A cloud")
        browser.open(fog, "window.drawn > 0")
        row = browser.picture()[before.shape[0] // 2].max(axis=1)
        empty, full = row[len(row) // 2 - 60], row[len(row) // 2 + 60]
        through = 0.5 ** (0.9 / 0.2)  # of light from behind, along z
        assert empty < 0x20
        assert full == pytest.approx(255 * (1 - through) + through * BACKGROUND[2], abs=6)
        assert browser.complaints == []
        assert browser.requests == [path.as_uri(), fog.as_uri()]


@pytest.mark.slow
@needs_browser
@needs_screen
def test_a_scene_with_its_result_and_tracks_is_drawn_by_a_browser(tmp_path):
    floor = tp.Surface(tp.Rectangle(width=2, height=2), tp.Diffuse(0.5), name="floor")
    lamp = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.2), tp.Lambertian(power=1.0))
    meter = tp.Detector("floor", positions=tp.Positions(u=8, v=8))
    scene = tp.Scene(lamp, surfaces=floor, detectors=meter)
    result = tp.simulate(scene, 20_000, seed=1, threads=1)
    path = scene_page(scene, tmp_path / "scene.html", result, tp.tracks(scene, 50, seed=1), "A floor")
    with Browser(tmp_path / "profile") as browser:
        browser.open(path, "window.drawn > 0")
        drawn = (np.abs(browser.picture().astype(int) - BACKGROUND) > 8).any(axis=2)
        assert drawn.mean() > 0.03
        assert "W" in browser.value("document.getElementById('bars').textContent")
        assert browser.complaints == []
        assert browser.requests == [path.as_uri()]


# Boxes [pixels] of all texts and bars that are seen.
BOXES = """
[...document.querySelectorAll("h1, header p, footer, .bar b, .bar div, .bar span, #labels span")]
  .filter((each) => getComputedStyle(each).visibility === "visible")
  .map((each) => {
    const { left, right, top, bottom } = each.getBoundingClientRect();
    return { words: each.tagName + " " + each.textContent, size: parseFloat(getComputedStyle(each).fontSize),
             left, right, top, bottom };
  })
"""
SIZES = [(1280, 900), (390, 844)]


@pytest.fixture(scope="module")
def crowded():
    """A lit floor with twelve detectors of long names over it, its result, and tracks that leave the picture."""
    turns = 2 * np.pi * np.arange(12) / 12
    places = [(1.2 * np.cos(turn), 1.2 * np.sin(turn), 0.3 + 0.05 * k) for k, turn in enumerate(turns)]
    names = [f"illuminance at workplace number {k + 1}" for k in range(12)]
    shapes = [tp.Rectangle(center=place, width=0.25, height=0.25) for place in places]
    looks = [tp.Detector(shape, name) for shape, name in zip(shapes, names, strict=True)]
    floor = tp.Surface(tp.Rectangle(width=4, height=4), tp.Diffuse(0.5), "floor")
    lamp = tp.Source(tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.2), tp.Lambertian(power=1.0))
    cells = tp.VolumeDetector(tp.Box(center=(0, 0, 1), size=(1, 1, 1)), "volume", cells=(4, 4, 4))
    scene = tp.Scene(lamp, floor, [*looks, cells])
    return scene, tp.simulate(scene, 100_000, seed=1, threads=1), tp.tracks(scene, 50, seed=1)


def shown_at(browser, size, path):
    """Open a page in a window of that size: one narrower than 500 is a phone's."""
    is_phone = size[0] < 500
    look = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": is_phone}
    browser.ask("Emulation.setDeviceMetricsOverride", **look)
    browser.ask("Emulation.setTouchEmulationEnabled", enabled=is_phone, maxTouchPoints=2)
    browser.open(path, "window.drawn > 0")


def drawn_again(browser):
    browser.value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def assert_apart(boxes, size):
    """No two boxes overlap, none is cut by the window, and all text is legible."""
    for k, one in enumerate(boxes):
        assert one["left"] >= 0 and one["right"] <= size[0], one
        assert one["top"] >= 0 and one["bottom"] <= size[1], one
        assert one["size"] >= 8, one
        for other in boxes[:k]:
            across = min(one["right"], other["right"]) - max(one["left"], other["left"])
            down = min(one["bottom"], other["bottom"]) - max(one["top"], other["top"])
            assert min(across, down) <= 0, (one, other)


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("size", SIZES)
def test_no_text_lies_on_another_or_on_a_bar_and_none_is_cut(size, crowded, tmp_path):
    title = "A floor: position = front row of the lecture hall, albedo = 0.5, lamp = 2 m"
    path = scene_page(crowded[0], tmp_path / "scene.html", crowded[1], crowded[2], title)
    with Browser(tmp_path / "profile") as browser:
        shown_at(browser, size, path)
        for turn in range(4):
            boxes = browser.value(BOXES)
            words = " ".join(each["words"] for each in boxes)
            assert sum(each["words"].startswith("DIV") for each in boxes) == 3, words
            assert words.count("workplace") >= 2
            assert title in words and "histories" in words and "turn" in words
            assert_apart(boxes, size)
            # Nothing of the scene, such as a track, lies outside its own cell.
            cell = browser.value("document.querySelector('main').getBoundingClientRect().toJSON()")
            cell = {"words": "scene", "size": 8, **{k: cell[k] for k in ("left", "right", "top", "bottom")}}
            outside = [
                each for each in boxes if "workplace" not in each["words"] and "volume" not in each["words"]
            ]
            assert_apart([*outside, cell], size)
            canvas = browser.value("document.querySelector('canvas').getBoundingClientRect().toJSON()")
            assert all(canvas[k] == cell[k] for k in ("left", "right", "top", "bottom"))
            middle = (size[0] / 2, size[1] / 2)
            browser.drag(middle, (middle[0] + 60 + 20 * turn, middle[1] - 20))
            drawn_again(browser)
        assert browser.complaints == []


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("size", SIZES)
def test_the_whole_scene_is_seen(size, tmp_path):
    """A wide room fills most of the page's width on a phone, and ends before its edges."""
    room = tp.Surface(tp.Box(size=(4, 2, 1)), tp.Diffuse(0.5), "room")
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    path = scene_page(tp.Scene(lamp, room), tmp_path / "scene.html")
    with Browser(tmp_path / "profile") as browser:
        shown_at(browser, size, path)
        is_drawn = (np.abs(browser.picture().astype(int) - BACKGROUND) > 8).any(axis=2)
        columns = np.flatnonzero(is_drawn[size[1] // 4 : 3 * size[1] // 4].any(axis=0))
        assert 2 < columns[0] < columns[-1] < size[0] - 3
        assert np.ptp(columns) > 0.6 * min(size)


@pytest.mark.slow
@needs_browser
def test_one_finger_turns_two_zoom_and_a_button_resets(plotter, tmp_path):
    path = page(plotter, tmp_path / "page.html", "A red square")

    def touch(browser, *ways):
        """Move fingers from start to end, each given by (x, y, x, y).

        They rest there before they are lifted: a browser makes no click of a tap after a fling.
        """
        for share in (0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0):
            points = [
                {"x": x + share * (to_x - x), "y": y + share * (to_y - y), "id": k}
                for k, (x, y, to_x, to_y) in enumerate(ways)
            ]
            kind = "touchMove" if share else "touchStart"
            browser.ask("Input.dispatchTouchEvent", type=kind, touchPoints=points)
            time.sleep(0.02)
        browser.ask("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        drawn_again(browser)

    def square(browser):
        reds = (browser.picture() == [255, 0, 0]).all(axis=2)
        return np.array([reds.any(axis=0).sum(), reds.any(axis=1).sum()])

    with Browser(tmp_path / "profile") as browser:
        shown_at(browser, (390, 844), path)
        whole = square(browser)
        touch(browser, (195, 400, 195, 250))
        across, down = square(browser) / whole
        assert across > 0.8 > down
        button = browser.value("document.querySelector('button').getBoundingClientRect().toJSON()")
        x, y = (button["left"] + button["right"]) / 2, (button["top"] + button["bottom"]) / 2
        browser.value("window.clicked = new Promise(done => addEventListener('click', () => done(1))), 0")
        touch(browser, (x, y, x, y))
        assert browser.value("clicked") == 1
        drawn_again(browser)
        np.testing.assert_array_equal(square(browser), whole)
        touch(browser, (175, 400, 155, 400), (215, 400, 235, 400))
        assert (square(browser) / whole)[1] == pytest.approx(2.0, abs=0.2)  # the window cuts its width
        assert browser.value("document.querySelector('footer').innerText").startswith("one finger: turn")
        assert browser.complaints == []


def test_no_name_ends_the_script_and_labels_stand_at_their_places(tmp_path):
    """Names that open a comment and a script within the script; a mesh far off the origin, of which one corner is named."""
    name = "<!--<script>"
    plotter = pv.Plotter(off_screen=True)
    square = pv.Plane(center=(7, 0, 0), i_size=2, j_size=2, i_resolution=1, j_resolution=1)
    plotter.add_mesh(square, culling="front")
    plotter.add_point_labels(np.array([[8.0, 1.0, 0.0]]), [name], show_points=False, always_visible=True)
    path = page(plotter, tmp_path / "page.html", name)
    plotter.close()
    told, _, _ = read(path)
    [label] = told["labels"]
    assert label["words"] == name
    np.testing.assert_allclose(label["place"], [math.sqrt(0.5), math.sqrt(0.5), 0], atol=1e-6)
    assert [part["hidden"] for part in told["parts"]] == ["front"]
    script = path.read_text(encoding="utf-8").partition("<script>")[2]
    assert "<!--" not in script and "<script" not in script


def test_a_bar_of_colours_rises_from_low_to_high(tmp_path):
    plotter = pv.Plotter(off_screen=True)
    line = pv.Line()
    line.cell_data["E"] = [1.0]
    plotter.add_mesh(line, scalars="E", clim=(0, 1), cmap="gray")
    told, _, _ = read(page(plotter, tmp_path / "page.html", "A bar"))
    plotter.close()
    colours = told["bars"][0]["colours"]
    assert colours == sorted(colours) and (colours[0], colours[-1]) == ("#000000", "#ffffff")
