"""Pictures of scenes, by the data drawn: which walls are looked through, what is grey, what a scale says, where lines end."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import transport as tp
from transport.viz import scene_style as style
from transport.viz.lobes_in_place import add_lobe
from transport.viz.scene import (
    caption_of,
    clipped,
    draw_scene,
    label_of,
    lifted,
    plot_unrendered,
    scene_blocks,
    track_colours,
    track_lines,
)
from transport.viz.scene_camera import View, coarse_facets, hides, view_of
from transport.viz.scene_parts import BACK, FRONT, NOWHERE, block_names, frame_of, parts_of
from transport.viz.screen import has_screen, without_screen
from transport.viz.wording import lengths_text

pyvista = pytest.importorskip("pyvista")

ROOM = tp.Box(size=(4, 3, 2))
LAMP = tp.Source(tp.Point(position=(0, 0, 0.8)), tp.Isotropic(power=10.0))
FLOOR = tp.Detector("-z", "floor", side="back", positions=tp.Positions(u=8, v=8))
BALL = tp.Sphere(radius=1.0)


def room(*more, detectors=()):
    walls = [tp.Surface(face, tp.Diffuse(0.5), name) for name, face in ROOM.faces().items()]
    return tp.Scene(LAMP, [*walls, *more], detectors)


def drawn_of(scene, particles=0, kind=None, quantity=None):
    """The parts of a kind, the frame, and the result of a run."""
    result = tp.simulate(scene, particles=particles, seed=1, batches=4) if particles else None
    frame = frame_of(scene)
    found = parts_of(scene, frame, result, quantity)
    return [part for part in found if kind in (None, part.kind)], frame, result


def paint_in(scene, particles):
    found, _, result = drawn_of(scene, particles)
    (paint,) = [part.paint for part in found if part.paint is not None]
    return paint, result


@pytest.fixture
def plotter():
    with without_screen():
        made = pyvista.Plotter(off_screen=True, window_size=[1400, 900])
        yield made
        made.close()


INWARDS = [
    tp.Surface(replace(face, normal=[-x for x in face.normal]), tp.Black(), name)
    for name, face in ROOM.faces().items()
]
GLOW = tp.Lambertian(radiance=1.0)


@pytest.mark.parametrize("scene, sides", [
    pytest.param(room(tp.Surface(tp.Sphere(radius=0.3), tp.Diffuse(0.5), "ball")),
                 dict.fromkeys(ROOM.faces(), BACK) | {"ball": None}, id="a ball in a room"),
    pytest.param(tp.Scene(LAMP, INWARDS), dict.fromkeys(ROOM.faces(), FRONT), id="walls with normals inwards"),
    pytest.param(room(tp.Surface(tp.Plane(center=(0, 0, -3)), tp.Black(), "ground")),
                 dict.fromkeys(ROOM.faces(), BACK), id="a room on the ground"),
    pytest.param(tp.Scene(LAMP, tp.Surface(tp.Sphere(radius=1.5), tp.Black(), "ball")), {"ball": BACK}, id="a hollow"),
    pytest.param(tp.Scene(LAMP, tp.Surface(tp.Sphere(radius=0.5), tp.Black(), "ball")), {"ball": None}, id="a ball"),
    pytest.param(tp.Scene(tp.Source("ball", GLOW, side="inside"), tp.Surface(BALL, tp.Diffuse(0.5), "ball")),
                 {"ball": BACK}, id="a hollow that glows inside"),
    pytest.param(tp.Scene(tp.Source("ball", GLOW, side="outside"), tp.Surface(BALL, tp.Diffuse(0.5), "ball")),
                 {"ball": FRONT}, id="a ball that glows outside"),
])  # fmt: skip
def test_walls_show_the_side_that_the_scene_is_on(scene, sides):
    found = {part.name: part.seen_from for part in drawn_of(scene, kind="surface")[0]}
    assert {name: found[name] for name in sides} == sides


def test_a_painted_wall_shows_the_side_of_its_detector():
    found, frame, _ = drawn_of(room(detectors=[FLOOR]), 2000, "surface")
    floor = [part for part in found if part.name == "-z"]
    assert [(part.seen_from, part.paint is not None) for part in floor] == [(BACK, True), (NOWHERE, False)]
    assert view_of(floor, frame, 1.5).position[2] > frame.middle[2]  # the lit side is above


@pytest.mark.slow
def test_blocks_and_colours_are_what_was_read_and_few_hits_have_none():
    scene = room(detectors=FLOOR)
    found, _, result = drawn_of(scene, 300)
    tracks, reading = tp.tracks(scene, particles=20), result["floor"]
    blocks = scene_blocks(scene, result, tracks)
    names = {"surface -z back", "surface +x", "source source 0", "detector floor", "tracks"}
    assert names <= set(blocks.keys()) and len(set(block_names(found))) == len(found)
    floor, read = blocks["surface -z back"], reading.irradiance
    for name, column in {
        "irradiance": read.value,
        "irradiance error": read.error,
        "hits": reading.counts.value,
    }.items():
        np.testing.assert_array_equal(floor.cell_data[name], column.ravel())
    assert str(floor.field_data["unit"][0]) == "W m^-2"
    with without_screen():
        plotter, _ = plot_unrendered(scene, result, tracks)
        mappers = [each.mapper for each in plotter.actors.values() if isinstance(each, pyvista.Actor)]
        coloured = [each for each in mappers if "shown" in each.dataset.cell_data]
        assert list(plotter.scalar_bars.keys()) == [r"$E\;[\mathrm{W\,m^{-2}}]$", r"$\mathrm{weight}$"]
        painted, weights = [np.array(each.dataset.cell_data["shown"]) for each in coloured]
        for values, mapper in zip((painted, weights), coloured, strict=True):
            np.testing.assert_allclose(
                mapper.scalar_range, (np.nanmin(values), np.nanmax(values)), atol=1e-12
            )
        plotter.close()
    known = reading.counts.value.ravel() >= 4
    assert 0 < known.sum() < 64
    np.testing.assert_allclose(
        painted, np.where(known, np.log10(np.maximum(read.value.ravel(), 1e-99)), np.nan)
    )
    np.testing.assert_allclose(weights, np.log10(tracks.weights))


FOGGY = tp.Surface(BALL, tp.Transparent(), "ball", inside=tp.Medium(scattering=1.0))
SMALL = tp.Surface(tp.Sphere(center=(0, 0, 0.2), radius=0.1), tp.Black(), "ball")
LARGE = tp.Surface(tp.Rectangle(width=1000, height=1000), tp.Black(), "floor")
LIMITED = [tp.Detector("ball", "straight", events=0), tp.Detector("ball", "all", via="floor")]
HAZE = "behind a haze"


@pytest.mark.parametrize("scene, said, not_said", [
    (room(detectors=FLOOR), ("500 histories", "fewer than 4 hits grey", "4 × 3 × 2 m"), (HAZE, "not drawn")),
    (tp.Scene(LAMP, FOGGY, tp.Detector("ball", side="outside")), (), (HAZE,)),  # the paint is on its boundary
    (tp.Scene(LAMP, FOGGY, tp.Detector(tp.Disk(center=(0, 0, 2), radius=1.0), "disk")), (HAZE,), ()),
    (tp.Scene(LAMP, [SMALL, LARGE], LIMITED),
     ("not drawn, far larger: floor", "of ball only what counts with events=(0, 0)"), ("grey",)),
], ids=["few hits", "painted fog", "fog", "a large floor, limited detectors"])  # fmt: skip
def test_the_caption_names_what_is_drawn_and_what_is_not(scene, said, not_said):
    found, frame, result = drawn_of(scene, 500)
    words = caption_of(scene, result, None, found, frame)
    assert all(each in words for each in said) and not any(each in words for each in not_said)
    with pytest.raises(ValueError, match="irradiance, exitance, fluence_rate, got 'net_flux_density'"):
        parts_of(scene, frame, result, "net_flux_density")


def test_cuts_show_each_cell_of_a_volume_where_it_lies():
    """A beam along z: the cuts go through the cells that it crosses, each colour is that of the cell around it."""
    beam = tp.Source(tp.Point(position=(0.1, 0.3, -2)), tp.Beam((0, 0, 1), power=3.0))
    volume = tp.VolumeDetector(tp.Box(size=(2, 3, 4)), "cells", cells=(4, 6, 5))
    shells = tp.VolumeDetector(BALL, "shells", cells=(0.2, 0.5, 1.0))
    rod = tp.VolumeDetector(tp.Cylinder(radius=1.0, height=2.0), "rod", cells=(4, 5))
    scene = tp.Scene(beam, detectors=[volume, shells, rod])
    (cut, rings, halves), _, result = drawn_of(scene, 200, "cells")
    place = np.floor((cut.facets.centres + (1 - 1e-9, 1.5 - 1e-9, 2 - 1e-9)) / (0.5, 0.5, 0.8)).astype(int)
    np.testing.assert_array_equal(np.ravel_multi_index(place.T, (4, 6, 5)), cut.facets.bins)
    assert len(cut.facets.faces) == 6 * 5 + 4 * 5 + 4 * 6
    values = cut.paint.values[cut.facets.bins]
    np.testing.assert_allclose(values[values > 0], 3.0 / 0.25)  # W over the cell's face
    assert (values > 0).sum() == 5 + 5 + 1
    radii = np.linalg.norm(rings.facets.centres, axis=1)
    np.testing.assert_array_equal(rings.facets.bins, np.searchsorted((0.2, 0.5, 1.0), radii) - 1)
    x, y, z = halves.facets.centres.T
    layer = np.floor((z + 1) / 0.4).astype(int)
    np.testing.assert_array_equal(halves.facets.bins, 5 * np.floor(4 * np.hypot(x, y)).astype(int) + layer)
    grid = scene_blocks(scene, result)["cells cells"]
    lit = grid.find_containing_cell((0.1, 0.3, 0.5))
    np.testing.assert_allclose(grid.cell_data["fluence_rate"][lit], 12.0)
    assert {part.kind for part in drawn_of(scene, 20, quantity="irradiance")[0]} == {"detector", "source"}


@pytest.mark.parametrize("sides, words", [
    ((4e-6, 2.3e-6), "4 × 2.3 µm"), ((3.0, 0.01), "3 × 0.01 m"), ((5e3,), "5 km"), ((1.495978707e11,), "1 au"),
    ((2e-12,), "0.002 nm"), ((0.05,), "50 mm"), ((0.0, 0.0), "0 × 0 m"),
])  # fmt: skip
def test_lengths_have_the_unit_that_suits_them(sides, words):
    assert lengths_text(sides) == words


def test_exitance_is_drawn_where_nothing_arrives():
    disk = tp.Disk(radius=0.5)
    detector = tp.Detector(disk, "leaving", positions=tp.Positions(u=3))
    paint, _ = paint_in(tp.Scene(tp.Source(disk, tp.Lambertian(exitance=7.0)), detectors=detector), 3000)
    assert paint.quantity == "exitance" and paint.hits.sum() == 3000
    assert np.abs(paint.values - 7.0).max() < 5 * paint.errors.max()


def test_bins_of_time_are_averaged_over_their_widths():
    times = (0.0, 4e-9, 5e-9, 1e-8)
    detector = tp.Detector(
        tp.Rectangle(width=2, height=2), "floor", positions=tp.Positions(u=2, v=2), times=times
    )
    paint, result = paint_in(tp.Scene(LAMP, detectors=detector, duration=1e-8), 4000)
    arrived = result["floor"].irradiance.value * np.diff(times)[:, None, None]
    np.testing.assert_allclose(paint.values, arrived.sum(axis=0).ravel() / 1e-8)
    assert paint.hits.sum() == result["floor"].counts.value.sum() > 100
    assert paint.only is None


@pytest.mark.parametrize("values, low, high, marks", [
    ([0.0, 0.02, 30.0, np.nan], 0.02, 30, ["0.1", "1", "10"]),
    ([0.15, 7.0], 0.15, 7, ["0.2", "0.5", "1", "2", "5"]),
    ([1372.9, 1373.1], 1372.9, 1373.1, ["1372.9", "1372.95", "1373", "1373.05", "1373.1"]),
    ([3e-5, 4e-5], 3e-5, 4e-5, ["3·10⁻⁵", "3.2·10⁻⁵", "3.4·10⁻⁵", "3.6·10⁻⁵", "3.8·10⁻⁵", "4·10⁻⁵"]),
    ([1e-30, 1.0], 1e-6, 1, ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "0.01", "0.1", "1"]),
    ([5.0, 5.0], 5 / 1.1, 5.5, ["4.6", "4.8", "5", "5.2", "5.4"]),
])  # fmt: skip
def test_logarithmic_scales_have_the_range_of_the_values_and_round_marks(values, low, high, marks):
    scale = style.logarithmic(np.array(values))
    np.testing.assert_allclose((scale.low, scale.high), np.log10([low, high]), atol=1e-12)
    assert [words for _, words in scale.marks] == marks
    np.testing.assert_allclose(scale.of(np.array([0.1, 10.0, 0.0, np.nan])), [-1, 1, np.nan, np.nan])


@pytest.mark.parametrize("values, low, high, marks", [
    ([0.0, 2.5, np.nan], 0, 2.5, ["0", "0.5", "1", "1.5", "2", "2.5"]),
    ([17.0, 20.5], 17, 20.5, ["17", "18", "19", "20"]),
    ([1.1e-9, 1.01e-8], 1.1e-9, 1.01e-8, ["2·10⁻⁹", "4·10⁻⁹", "6·10⁻⁹", "8·10⁻⁹", "10⁻⁸"]),
])  # fmt: skip
def test_linear_scales_have_the_range_of_the_values_and_round_marks(values, low, high, marks):
    scale = style.linear(np.array(values))
    assert (scale.low, scale.high) == (low, high)
    assert [words for _, words in scale.marks] == marks


def test_zeros_have_no_scale():
    assert style.logarithmic(np.zeros(3)) is style.linear(np.zeros(3)) is None


def test_colour_bars_end_at_the_least_and_the_largest_finite_value():
    scene = room(detectors=FLOOR)
    result, tracks = tp.simulate(scene, 20_000, seed=1, threads=1), tp.tracks(scene, 30, seed=1)
    plotter, _ = plot_unrendered(scene, result, tracks)
    irradiance, hits = result["floor"].irradiance.value, result["floor"].counts.value
    lines = track_lines(tracks, frame_of(scene, tracks).margins)
    data = {"E": irradiance[hits >= 4], "weight": lines.cell_data["weight"]}
    for title, bar in plotter.scalar_bars.items():
        (values,) = [values for name, values in data.items() if name in title]
        ends = np.log10([values.min(), values.max()])
        np.testing.assert_allclose(bar.GetLookupTable().GetRange(), ends, atol=1e-12)
    assert len(plotter.scalar_bars) == 2
    plotter.close()


@pytest.mark.parametrize("place, is_uniform", [((0, 0, 0), True), ((0, 0, 0.3), False)])
def test_the_caption_names_colours_that_are_noise(place, is_uniform):
    """A lamp in the middle of a ball lights it uniformly, one beside the middle does not."""
    lamp = tp.Source(tp.Point(position=place), tp.Isotropic(power=1.0))
    look = tp.Detector("ball", side="inside", positions=tp.Positions(u=4, v=8))
    scene = tp.Scene(lamp, tp.Surface(BALL, tp.Black(), "ball"), look)
    result = tp.simulate(scene, 40_000, seed=1, threads=1)
    frame = frame_of(scene)
    words = caption_of(scene, result, None, parts_of(scene, frame, result), frame)
    assert ("E differs by no more than its errors" in words) == is_uniform


@pytest.mark.parametrize("estimate, short", [
    ("(1.5 ± 0.1) W m^-2 sr^-1", "(1.5 ± 0.1) W m⁻² sr⁻¹"),
    ("7.958 W m^-2 (error unknown: every batch gave the same)", "7.958 W m⁻² (error unknown)"),
])  # fmt: skip
def test_estimates_are_short(estimate, short):
    assert style.short_estimate(estimate) == short


@pytest.mark.parametrize("across, marks, moves", [
    (600, "5·10²⁰", True), (1400, "5·10²⁰", False), (320, "0.5", True),
])  # fmt: skip
def test_a_bar_and_its_title_stand_farther_left_where_a_window_would_cut_them(plotter, across, marks, moves):
    plotter.window_size = [across, 900]
    mesh = pyvista.Sphere()
    mesh.cell_data["E"] = np.linspace(0, 1, mesh.n_cells)
    actor = plotter.add_mesh(mesh, scalars="E", show_scalar_bar=False)
    title, scale = r"$E\;[\mathrm{s^{-1}\,m^{-2}}]$", style.Scale(0, 1, ((0.5, marks),), True)
    style.add_bar(plotter, actor, title, scale, (0.91, 0.4), 0.5)
    left = plotter.scalar_bars[title].GetPosition()[0] + (1 - style.BAR_SHARE) * style.BAR
    end = left + style.BAR_SHARE * style.BAR + style.TICK / across + style.text_width(plotter, marks, 16)
    assert end < 1 and (left < 0.909) == moves
    (text,) = [each for each in plotter.actors.values() if isinstance(each, pyvista.Text)]
    assert 0.05 < (width := style.text_width(plotter, title, text.prop.font_size)) < 0.6
    assert text.GetPosition()[0] + width < 1


def test_a_sun_is_left_out_beside_a_square_metre():
    sun = tp.Source(tp.Sphere(radius=7e8), tp.Lambertian(radiance=2e7))
    meter = tp.Rectangle(center=(1.5e11, 0, 0), normal=(-1, 0, 0), width=1, height=1)
    scene = tp.Scene(sun, detectors=tp.Detector(meter, "meter"))
    frame = frame_of(scene)
    assert set(frame.distant) == {0} and math.isclose(frame.size, math.sqrt(2))
    assert frame_of(scene, whole=True).size > 1.5e11
    near = tp.Source(tp.Disk(radius=0.5), GLOW)
    small = tp.Detector(tp.Disk(center=(0, 0, 2), radius=1e-3), "meter")
    assert frame_of(tp.Scene(near, detectors=small)).distant == {}
    hall = tp.Surface(tp.Box(size=6), tp.Diffuse(0.5))
    assert frame_of(tp.Scene(near, hall, small)).size == pytest.approx(6 * math.sqrt(3))


def test_an_infinite_ground_is_cut_and_a_point_alone_has_some_room():
    ((ground,), frame, _) = drawn_of(tp.Scene(LAMP, tp.Surface(tp.Plane(), tp.Black())), kind="surface")
    assert 0 < frame.size < 100 and len(ground.facets.faces) > 0
    fog = tp.Scene(tp.Source(tp.Point(), tp.Isotropic(power=1.0)), medium=tp.Medium(absorption=1e6))
    assert 1e-6 < frame_of(fog).size < 1e-4


def test_tracks_end_where_the_picture_does():
    scene = room()
    tracks = tp.tracks(scene, particles=30, seed=2)
    bounds = (np.array([-1.0, -1.0, -1.0]), np.array([0.5, 1.0, 1.0]))
    lines = track_lines(tracks, bounds)
    assert (lines.points >= bounds[0] - 1e-12).all() and (lines.points <= bounds[1] + 1e-12).all()
    first, last = clipped(tracks, bounds)
    inside = first < last
    assert 0 < lines.n_cells == inside.sum() < len(tracks)
    np.testing.assert_array_equal(lines.cell_data["weight"], tracks.weights[inside])
    flown = (lines.cell_data["age"] - tracks.ages[inside])[:, None] * tracks.directions[inside]
    middles = lines.points.reshape(-1, 2, 3).mean(axis=1)
    np.testing.assert_allclose(middles, tracks.starts[inside] + flown, atol=1e-12)
    assert track_colours(lines)[0] == "weight"
    everything = track_lines(tracks, frame_of(scene).margins)
    assert everything.n_cells == len(tracks)
    np.testing.assert_allclose(everything.points[1::2], tracks.ends(1.0), atol=1e-12)


def test_a_disk_hides_its_shadow_along_the_way_to_the_camera():
    lid = tp.Surface(tp.Disk(center=(0, 0, 1), radius=0.5), tp.Black(), "lid")
    floor = tp.Surface(tp.Rectangle(width=3, height=3), tp.Black(), "floor")
    part = drawn_of(tp.Scene(LAMP, [lid, floor]), kind="surface")[0][0]
    coarse = replace(part, facets=coarse_facets(part), seen_from=None)
    places = np.random.default_rng(1).uniform(-1.5, 1.5, (500, 3)) * (1, 1, 0)
    ways = np.array([(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.0, -0.8, 0.6), (0.0, 0.6, -0.8)])
    hidden = hides(coarse, places, ways)
    for way, row in zip(ways[:3], hidden, strict=False):
        meets = places + way / way[2]
        distance = np.hypot(meets[:, 0], meets[:, 1])
        sure = np.abs(distance - 0.5) > 0.05  # the disk has corners here
        np.testing.assert_array_equal(row[sure], distance[sure] < 0.5)
    assert hidden[:3].any(axis=1).all() and not hidden[3].any()
    assert not hides(replace(coarse, seen_from=BACK), places, ways[:1]).any()


@pytest.mark.parametrize("scale", [1e-9, 1e11])
def test_pictures_know_no_unit_of_length(scale):
    np.testing.assert_allclose(camera_at(scale), camera_at(1.0), rtol=1e-9)


def camera_at(scale):
    """The place of the camera for a lit floor half behind a wall, over the picture's size."""
    floor = tp.Surface(tp.Rectangle(width=2 * scale, height=3 * scale), tp.Black(), "floor")
    place = (0.6 * scale, -1.3 * scale, 1.3 * scale)  # where the camera would look from
    wall = tp.Rectangle(center=place, normal=(0.47, -0.88, 0), width=6 * scale, height=2.6 * scale)
    lamp = tp.Source(tp.Point(position=(0, 0, scale)), tp.Isotropic(power=1.0))
    detector = tp.Detector("floor", positions=tp.Positions(u=2, v=2))
    found, frame, _ = drawn_of(tp.Scene(lamp, [floor, tp.Surface(wall, tp.Black())], detector), 200)
    view = view_of([replace(part, seen_from=None) for part in found], frame, 1.5)
    return (view.position - frame.middle) / frame.size


@pytest.mark.parametrize("detector, top, has_outline", [
    (tp.Detector(tp.Mesh.sphere(radius=0.5), "it", side="outside"), (0, 0, 0.5), False),
    (tp.Detector(tp.Rectangle(width=2, height=4), "it"), (1, 2, 0), True),
    (tp.Detector(tp.Box(size=(2, 4, 6)), "it", side="outside"), (1, 2, 3), True),
    (tp.PointDetector((1, 2, 3), "it"), (1, 2, 3), False),
], ids=["fine mesh", "rectangle", "box", "point"])  # fmt: skip
def test_the_name_of_a_detector_is_at_its_top_far_right(detector, top, has_outline):
    """The camera is on the side of -y, a little to +x."""
    ((part,), frame, _) = drawn_of(tp.Scene(LAMP, detectors=detector), kind="detector")
    assert (part.outline.n_points > 0) == has_outline
    view = View(frame.middle + (1.0, -5.0, 2.0), frame.middle, np.array([0.0, 0.0, 1.0]))
    place, words = label_of(part, view)
    assert words == "it"
    np.testing.assert_allclose(place, top, atol=0.02)


@pytest.mark.parametrize("side, sign", [("front", 1), ("back", -1)])
def test_detectors_on_a_wall_are_drawn_off_it_on_their_side(side, sign):
    meter = tp.Detector(tp.Disk(normal=(1, 2, 3), radius=0.5), "meter", side=side)
    ((part,), _, _) = drawn_of(tp.Scene(LAMP, detectors=meter), kind="detector")
    away = lifted(part.drawn(), part, 1.0).points - part.drawn().points
    assert (sign * away @ np.array([1, 2, 3]) > 0).all()


# ---- Four pictures against pictures that were looked at (tests/images), by the differences that pyvista allows.
# Bins are few and particles many, so that no noise is seen. New ones: add --reset_image_cache.


@pytest.fixture
def check(verify_image_cache):
    if not has_screen():
        pytest.skip("no libraries of OpenGL here")

    def drawn(scene, particles, tracks=0, finish=lambda plotter, result: None):
        result = tp.simulate(scene, particles=particles, seed=1, batches=4) if particles else None
        ways = tp.tracks(scene, particles=tracks) if tracks else None
        plotter = draw_scene(scene, result, ways, window_size=(480, 320))
        finish(plotter, result)
        plotter.show()

    return drawn


@pytest.mark.slow
def test_scene_room(check):
    """A closed room seen into: the walls before the camera are looked through; a mirror ball, a glass one, a lamp."""
    balls = [
        tp.Surface(tp.Sphere(center=(0.9, 0.4, -0.6), radius=0.4), tp.Mirror(0.9), "mirror"),
        tp.Surface(tp.Sphere(center=(-0.8, -0.4, -0.5), radius=0.35), tp.Dielectric(1.5), "glass"),
    ]
    walls = [tp.Surface(face, tp.Diffuse(0.6), name) for name, face in ROOM.faces().items()]
    ceiling = tp.Rectangle(center=(0, 0, 0.95), normal=(0, 0, -1), width=1, height=1)
    places = tp.Positions(u=6, v=6)
    looks = [tp.Detector(name, side="back", positions=places) for name in ("-z", "+y", "-x", "+x", "-y")]
    check(tp.Scene(tp.Source(ceiling, tp.Lambertian(power=10.0)), walls + balls, looks), particles=200_000)


@pytest.mark.slow
def test_scene_maps(check):
    """Maps by place on a cylinder, a zone of a sphere and a tilted floor, lit by a point from one side."""
    lamp = tp.Source(tp.Point(position=(-2.0, -2.5, 3.0)), tp.Isotropic(power=100.0))
    shapes = {
        "floor": tp.Rectangle(normal=(0, -0.2, 1), width=5, height=4, up=(0.3, 1, 0)),
        "pipe": tp.Cylinder(center=(1, 0.5, 1.4), axis=(1, 0.3, 0.2), radius=0.4, height=2),
        "cap": tp.Sphere(center=(-0.8, 0.2, 1.0), radius=0.7, axis=(0, 0, 1), mu_min=-0.2),
    }
    surfaces = [tp.Surface(shape, tp.Black(), name) for name, shape in shapes.items()]
    looks = [tp.Detector(name, positions=tp.Positions(u=8, v=12)) for name in shapes]
    check(tp.Scene(lamp, surfaces, looks), particles=2_000_000)


def test_scene_fog(check):
    """Voxels and a body of fog as translucent volumes, a beam as a glowing dot, flights by weight."""
    x, y, z = np.indices((12, 12, 12)) - 5.5
    cloud = np.where(x**2 + y**2 + 2 * z**2 < 25, 4.0, 0.0)
    grid = tp.Grid(box=tp.Box(size=2.0), scattering=0.8 * cloud, absorption=0.2 * cloud)
    fog = tp.Medium(scattering=1.0, absorption=0.3, emission=0.1)
    ball = tp.Sphere(center=(2.2, 0, 0), radius=0.8)
    surfaces = [
        tp.Surface(grid.box, tp.Transparent(), "cloud", inside=grid),
        tp.Surface(ball, tp.Transparent(), "ball", inside=fog),
    ]
    beam = tp.Source(tp.Point(position=(-2.0, 0.2, 0.1)), tp.Beam((1, 0, 0), power=1.0))
    check(tp.Scene(beam, surfaces), particles=0, tracks=12)


def test_scene_lobe(check):
    """A lobe of radiance on a patch points at the lamp; few tracks; a detector's name and number."""
    lamp = tp.Disk(center=(0.8, 0, 1.5), normal=(0, 0, -1), radius=0.4)
    patch = tp.Disk(center=(-0.5, 0, 0), radius=0.3)
    directions = tp.Directions(theta=np.linspace(0, math.pi / 2, 10), phi=18)
    source = tp.Source(lamp, tp.Lambertian(radiance=10.0), aim=patch)
    scene = tp.Scene(source, detectors=tp.Detector(patch, "patch", directions=directions))
    check(scene, 500_000, 10, lambda plotter, result: add_lobe(plotter, result["patch"], size=1.0))
