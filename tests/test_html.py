"""In a notebook objects say what their text says, in HTML that is well-formed whatever their names are."""

import ast
import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import transport as tp
from tests import plain_scenes
from tests.browser import CHROMIUM, Browser
from tests.html_pages import Page, column, page
from tests.synthetic import EVEN_RUN, grid, noisy
from transport.analysis.work_precision import MethodCost, Point
from transport.io.html.charts import BAR_COLOUR
from transport.io.html.elements import STYLE, framed, plain_typeset, typeset
from transport.io.html.scenes import MAX_ROWS
from transport.statistics.convergence import TimeModel
from transport.statistics.estimates import Estimate

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
    named = (*scene.surfaces[:MAX_ROWS], *scene.detectors[:MAX_ROWS])
    assert all(part.name in seen for part in named if part.name)
    assert "None" not in seen and "299792458" not in seen


def test_prices_say_what_their_text_says():
    tried = Point(1000, 2, 0.1, 0.1, math.nan, math.nan, math.nan)
    ways = tuple(
        MethodCost(name, (tried,), None, None, TimeModel(0.0, 1e-6), 0.25, math.nan)
        for name in ("analog", HOSTILE)
    )
    cost = tp.CostOfAccuracy(
        "meter.flux_in", "W", 2.5e-7, "exact", ways, (0.01, 1e-8), {"backward <i>": "no"}, "a <machine>", 1
    )
    seen = page(cost).text
    words = {
        word
        for line in str(cost).splitlines()
        if "particles in the largest" not in line
        for word in line.split()
    }
    assert {word for word in words if word not in seen} == set()
    assert page(cost).tags.count("tr") == 3 and not {"script", "i"} & set(page(cost).tags)


def test_a_reading_of_very_many_bins_works_out_one_of_its_quantities(monkeypatch, foggy):
    from transport.io.html import estimates

    result = tp.Result(foggy.plan, foggy.batches, 1, None, True, [])
    top = result[HOSTILE + "top"]
    monkeypatch.setattr(estimates, "MAX_NUMBERS", 100)
    assert "not computed for so many bins" in page(top).text
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
    used = set(re.findall(r"#[0-9a-f]{6}", STYLE)) | {BAR_COLOUR}
    assert len(used) == 2
    for colour in used:
        shine = _shine(colour)
        assert (1.05 / (shine + 0.05)) > 2.8 and (shine + 0.05) / (_shine("#111111") + 0.05) > 3


def _shine(colour):
    channels = np.array(list(bytes.fromhex(colour[1:]))) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def test_html_needs_nothing_but_numpy():
    folder = Path(tp.__file__).parent / "io" / "html"
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
