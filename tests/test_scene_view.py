"""Pictures of scenes, by the data drawn: which walls are looked through, what is grey, what a scale says, where lines end."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import transport as tp
from transport.viz import night, scene_view
from transport.viz.scene_camera import _coarse, _crossed, view_of
from transport.viz.scene_frame import frame_of
from transport.viz.scene_parts import BACK, FRONT, NOWHERE, block_names, is_hazed, parts_of
from transport.viz.scene_things import _lifted, name_of
from transport.viz.scene_view import caption_of, scene_blocks
from transport.viz.solids import contours, solid
from transport.viz.track_lines import clipped, told_by, track_lines
from transport.viz.wording import lengths_text

ROOM = tp.Box(size=(4, 3, 2))
LAMP = tp.Source(tp.Point(position=(0, 0, 0.8)), tp.Isotropic(power=10.0))


def room(*more, detectors=()):
    walls = [tp.Surface(face, tp.Diffuse(0.5), name) for name, face in ROOM.faces().items()]
    return tp.Scene(LAMP, [*walls, *more], detectors)


def parts(scene, result=None):
    frame = frame_of(scene)
    return {part.name: part for part in parts_of(scene, frame, result) if part.kind == "surface"}, frame


def test_walls_show_their_inner_side_and_what_stands_in_the_room_all_round():
    ball = tp.Surface(tp.Sphere(radius=0.3), tp.Diffuse(0.5), "ball")
    found, _ = parts(room(ball))
    assert [found[name].seen_from for name in ROOM.faces()] == [BACK] * 6
    assert found["ball"].seen_from is None
    inwards = [
        tp.Surface(
            tp.Rectangle(center=f.center, normal=[-x for x in f.normal], width=f.width, height=f.height),
            tp.Black(),
        )
        for f in ROOM.faces().values()
    ]
    found, _ = parts(tp.Scene(LAMP, inwards))
    assert {part.seen_from for part in found.values()} == {FRONT}
    hollow, _ = parts(tp.Scene(LAMP, tp.Surface(tp.Sphere(radius=1.5), tp.Black(), "hollow")))
    assert hollow["hollow"].seen_from == BACK
    grounded, _ = parts(room(tp.Surface(tp.Plane(center=(0, 0, -3)), tp.Black(), "ground")))
    assert [grounded[name].seen_from for name in ROOM.faces()] == [BACK] * 6
    outside, _ = parts(tp.Scene(LAMP, tp.Surface(tp.Sphere(radius=0.5), tp.Black(), "ball")))
    assert outside["ball"].seen_from is None


def test_a_painted_wall_shows_the_side_that_was_looked_at():
    detectors = [tp.Detector("-z", "floor", side="back", positions=tp.Positions(u=4, v=4))]
    scene = room(detectors=detectors)
    result = tp.simulate(scene, particles=2000, seed=1, batches=4)
    frame = frame_of(scene)
    floor = [p for p in parts_of(scene, frame, result) if p.kind == "surface" and p.name == "-z"]
    assert [(p.seen_from, p.paint is not None) for p in floor] == [(BACK, True), (NOWHERE, False)]
    way = np.array(view_of(floor, frame, 1.5).position) - frame.middle
    assert way[2] > 0  # the lit side is above


def test_few_hits_are_told_and_blocks_hold_what_was_read():
    scene = room(detectors=[tp.Detector("-z", "floor", side="back", positions=tp.Positions(u=8, v=8))])
    result = tp.simulate(scene, particles=300, seed=1, batches=4)
    blocks = scene_blocks(scene, result, tp.tracks(scene, particles=20))
    assert {"surface -z back", "surface +x", "source source 0", "detector floor", "tracks"} <= set(
        blocks.keys()
    )
    floor = blocks["surface -z back"]
    reading = result["floor"]
    np.testing.assert_array_equal(floor.cell_data["irradiance"], reading.irradiance.value.ravel())
    np.testing.assert_array_equal(floor.cell_data["irradiance error"], reading.irradiance.error.ravel())
    np.testing.assert_array_equal(floor.cell_data["hits"], reading.counts.value.ravel())
    assert str(floor.field_data["unit"][0]) == "W m^-2"
    assert 0 < (floor.cell_data["hits"] < 4).sum() < 64
    frame = frame_of(scene)
    drawn = parts_of(scene, frame, result)
    assert len(set(block_names(drawn))) == len(drawn)
    words = caption_of(scene, result, None, drawn, frame)
    assert "300 histories" in words and "fewer than 4 hits grey" in words and "4 × 3 × 2 m" in words


def test_cuts_show_each_cell_of_a_volume_where_it_lies():
    """A beam along z: the cuts go through the cells that it crosses, each colour is that of the cell around it."""
    beam = tp.Source(tp.Point(position=(0.1, 0.3, -2)), tp.Beam((0, 0, 1), power=3.0))
    volume = tp.VolumeDetector(tp.Box(size=(2, 3, 4)), "cells", cells=(4, 6, 5))
    shells = tp.VolumeDetector(tp.Sphere(radius=1.0), "shells", cells=(0.2, 0.5, 1.0))
    scene = tp.Scene(beam, detectors=[volume, shells])
    result = tp.simulate(scene, particles=200, batches=4)
    cut, rings = [part for part in parts_of(scene, frame_of(scene), result) if part.kind == "cells"]
    place = np.floor((cut.facets.centres + (1 - 1e-9, 1.5 - 1e-9, 2 - 1e-9)) / (0.5, 0.5, 0.8)).astype(int)
    np.testing.assert_array_equal(np.ravel_multi_index(place.T, (4, 6, 5)), cut.facets.bins)
    assert len(cut.facets.faces) == 6 * 5 + 4 * 5 + 4 * 6
    lit = cut.paint.values[cut.facets.bins] > 0
    np.testing.assert_allclose(cut.paint.values[cut.facets.bins][lit], 3.0 / 0.25)  # W over the cell's face
    assert lit.sum() == 5 + 5 + 1
    radii = np.linalg.norm(rings.facets.centres, axis=1)
    np.testing.assert_array_equal(rings.facets.bins, np.searchsorted((0.2, 0.5, 1.0), radii) - 1)
    grid = scene_blocks(scene, result)["cells cells"]
    np.testing.assert_allclose(
        grid.cell_data["fluence_rate"][grid.find_containing_cell((0.1, 0.3, 0.5))], 12.0
    )
    assert {part.kind for part in parts_of(scene, frame_of(scene), result, "irradiance")} == {
        "detector",
        "source",
    }


@pytest.mark.parametrize("across, marks", [(600, "5·10²⁰"), (1400, "5·10²⁰"), (320, "0.5")])
def test_marks_of_a_bar_are_not_cut(across, marks):
    pyvista = pytest.importorskip("pyvista")
    written = []

    class Bar(SimpleNamespace):
        def __getattr__(self, name):
            return lambda *arguments: None

    bar = Bar(GetAnnotationTextProperty=lambda look=pyvista.TextProperty(): look)  # noqa: B008
    bar.SetPosition = lambda x, y: written.append(x + (1 - night.WIDE) * night.BAR)
    window = SimpleNamespace(GetSize=lambda: (across, 900), GetDPI=lambda: 72)
    plotter = SimpleNamespace(render_window=window, window_size=(across, 900), add_scalar_bar=lambda **k: bar)
    plotter.add_text = lambda words, **look: pyvista.Text(words)
    table = SimpleNamespace(SetAnnotation=lambda value, words: None)
    actor = SimpleNamespace(mapper=SimpleNamespace(lookup_table=table))
    night.add_bar(plotter, actor, "$E$", night.Scale(0, 1, ((0.5, marks),), True), (0.91, 0.4), 0.5)
    end = written[0] + night.WIDE * night.BAR + night.TICK / across + night.width_of(plotter, marks, 16)
    assert end < 1 and (written[0] == 0.91) == (across == 1400)


def test_no_haze_lies_over_colours_on_its_bounds():
    ball = tp.Surface(tp.Sphere(radius=1.0), tp.Transparent(), "ball", inside=tp.Medium(scattering=1.0))
    skin, apart = (
        tp.Detector("ball", side="outside"),
        tp.Detector(tp.Disk(center=(0, 0, 2), radius=1.0), "disk"),
    )
    for looks, hazed in ((skin, False), (apart, True)):
        scene = tp.Scene(LAMP, ball, looks)
        result, frame = tp.simulate(scene, particles=500, batches=4), frame_of(scene)
        found = parts_of(scene, frame, result)
        assert [is_hazed(part, found) for part in found if part.kind == "medium"] == [hazed]
        assert ("behind a haze" in caption_of(scene, result, None, found, frame)) == hazed


def test_a_ball_of_one_colour_has_level_lines_just_off_it():
    ball = solid(tp.Mesh.sphere(radius=0.5))
    radii = np.linalg.norm(contours(ball, 1e-3).points, axis=1)
    assert len(radii) > 200 and (np.abs(radii - 0.5) < 5e-3).all()
    assert contours(solid(tp.Disk(radius=1.0)), 1e-3).n_points == 0


@pytest.mark.parametrize("sides, words", [
    ((4e-6, 2.3e-6), "4 × 2.3 µm"), ((3.0, 0.01), "3 × 0.01 m"), ((5e3,), "5 km"), ((1.495978707e11,), "1 au"),
    ((2e-12,), "0.002 nm"), ((0.05,), "50 mm"), ((0.0, 0.0), "0 × 0 m"),
])  # fmt: skip
def test_lengths_are_told_in_the_unit_that_suits_them(sides, words):
    assert lengths_text(sides) == words


def test_exitance_is_drawn_where_nothing_arrives():
    disk = tp.Disk(radius=0.5)
    detector = tp.Detector(disk, "leaving", positions=tp.Positions(u=3))
    scene = tp.Scene(tp.Source(disk, tp.Lambertian(exitance=7.0)), detectors=detector)
    result = tp.simulate(scene, particles=3000, batches=4)
    (paint,) = [p.paint for p in parts_of(scene, frame_of(scene), result) if p.paint is not None]
    assert paint.quantity == "exitance" and paint.hits.sum() == 3000
    assert np.abs(paint.values - 7.0).max() < 5 * paint.errors.max()


def test_bins_of_time_are_averaged_over_their_widths():
    floor = tp.Rectangle(width=2, height=2)
    detector = tp.Detector(floor, "floor", positions=tp.Positions(u=2, v=2), times=(0.0, 4e-9, 5e-9, 1e-8))
    scene = tp.Scene(LAMP, detectors=detector, duration=1e-8)
    result = tp.simulate(scene, particles=4000, batches=4)
    (paint,) = [p.paint for p in parts_of(scene, frame_of(scene), result) if p.paint is not None]
    arrived = result["floor"].irradiance.value * np.array([4e-9, 1e-9, 5e-9])[:, None, None]
    np.testing.assert_allclose(paint.values, arrived.sum(axis=0).ravel() / 1e-8)
    assert paint.hits.sum() == result["floor"].counts.value.sum() > 100
    assert paint.only is None


def test_scales_end_at_whole_decades_and_say_each():
    scale = night.decades(np.array([0.0, 0.02, 30.0, np.nan]))
    assert (scale.low, scale.high) == (-2, 2)
    assert [words for _, words in scale.marks] == ["10⁻²", "0.1", "1", "10", "100"]
    np.testing.assert_allclose(scale.of(np.array([0.1, 10.0])), [-1, 1])
    assert np.isnan(scale.of(np.array([0.0, np.nan]))).all()
    one = night.decades(np.array([1372.9, 1373.1]))
    assert (one.low, one.high) == (3, 4)
    assert [words for _, words in one.marks] == ["1000", "2000", "5000", "10⁴"]
    assert night.decades(np.array([1e-30, 1.0])).low == -6
    assert night.decades(np.zeros(3)) is None
    assert night.in_words("(1.5 ± 0.1) W m^-2 sr^-1") == "(1.5 ± 0.1) W m⁻² sr⁻¹"
    unknown = "7.958 W m^-2 (error unknown: every batch gave the same)"
    assert night.in_words(unknown) == "7.958 W m⁻² (error unknown)"


@pytest.mark.parametrize("across, moves", [(3000, False), (600, True)])
def test_words_that_a_window_would_cut_begin_further_left(across, moves):
    pyvista = pytest.importorskip("pyvista")
    window = SimpleNamespace(GetSize=lambda: (across, 900), GetDPI=lambda: 72)
    text = pyvista.Text(r"$E\;[\mathrm{s^{-1}\,m^{-2}}]$", prop=pyvista.TextProperty(font_size=24))
    plotter = SimpleNamespace(
        render_window=window, window_size=(across, 900), add_text=lambda *a, **look: text
    )
    night.write(plotter, text.input, (0.91, 0.88), 12)
    box = [0, 0, 0, 0]
    vtkTextRenderer = pytest.importorskip("vtkmodules.vtkRenderingCore").vtkTextRenderer
    vtkTextRenderer.GetInstance().GetBoundingBox(text.GetTextProperty(), text.input, box, 72)
    assert 60 < box[1] - box[0] < 300
    assert (text.GetPosition()[0] < 0.91) == moves
    assert text.GetPosition()[0] + (box[1] - box[0]) / across < 1


def test_a_sun_is_left_out_beside_a_square_metre():
    sun = tp.Source(tp.Sphere(radius=7e8), tp.Lambertian(radiance=2e7))
    meter = tp.Rectangle(center=(1.5e11, 0, 0), normal=(-1, 0, 0), width=1, height=1)
    scene = tp.Scene(sun, detectors=tp.Detector(meter, "meter"))
    frame = frame_of(scene)
    assert set(frame.distant) == {0} and math.isclose(frame.size, math.sqrt(2))
    assert frame_of(scene, whole=True).size > 1.5e11
    near = tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=1.0))
    small = tp.Detector(tp.Disk(center=(0, 0, 2), radius=1e-3), "meter")
    assert frame_of(tp.Scene(near, detectors=small)).distant == {}


def test_a_ground_without_end_is_cut_and_a_point_alone_has_some_room():
    scene = tp.Scene(LAMP, tp.Surface(tp.Plane(), tp.Black(), "ground"))
    found, frame = parts(scene)
    assert 0 < frame.size < 100 and len(found["ground"].facets.faces) > 0
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
    middles = lines.points.reshape(-1, 2, 3).mean(axis=1)
    here = (
        tracks.starts[inside]
        + (lines.cell_data["age"] - tracks.ages[inside])[:, None] * tracks.directions[inside]
    )
    np.testing.assert_allclose(middles, here, atol=1e-12)
    assert told_by(lines) == "weight"
    everything = track_lines(tracks, frame_of(scene).grown())
    assert everything.n_cells == len(tracks)
    np.testing.assert_allclose(everything.points[1::2], tracks.ends(1.0), atol=1e-12)


def test_what_stands_before_something_is_known_to_hide_it():
    """A disk over a floor hides, along each way to the camera, what lies in its shadow along that way."""
    lid = tp.Surface(tp.Disk(center=(0, 0, 1), radius=0.5), tp.Black(), "lid")
    found, _ = parts(tp.Scene(LAMP, [lid, tp.Surface(tp.Rectangle(width=3, height=3), tp.Black(), "floor")]))
    coarse = replace(found["lid"], facets=_coarse(found["lid"]), seen_from=None)
    places = np.random.default_rng(1).uniform(-1.5, 1.5, (500, 3)) * (1, 1, 0)
    ways = np.array([(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.0, -0.8, 0.6), (0.0, 0.6, -0.8)])
    hidden = _crossed(coarse, places, ways)
    for way, row in zip(ways[:3], hidden, strict=False):
        meets = places + way / way[2]
        far = np.hypot(meets[:, 0], meets[:, 1])
        sure = np.abs(far - 0.5) > 0.05  # the disk has corners here
        np.testing.assert_array_equal(row[sure], far[sure] < 0.5)
    assert hidden[:3].any(axis=1).all() and not hidden[3].any()
    assert not _crossed(replace(coarse, seen_from=BACK), places, ways[:1]).any()


@pytest.mark.parametrize("scale", [1e-9, 1e11])
def test_pictures_know_no_unit_of_length(scale):
    np.testing.assert_allclose(camera_at(scale), camera_at(1.0), rtol=1e-9)


def camera_at(scale):
    """Where the camera of a lit floor half behind a wall stands, over the picture's size."""
    floor = tp.Surface(tp.Rectangle(width=2 * scale, height=3 * scale), tp.Black(), "floor")
    place = (0.6 * scale, -1.3 * scale, 1.3 * scale)  # where the camera would look from
    wall = tp.Rectangle(center=place, normal=(0.47, -0.88, 0), width=6 * scale, height=2.6 * scale)
    lamp = tp.Source(tp.Point(position=(0, 0, scale)), tp.Isotropic(power=1.0))
    detector = tp.Detector("floor", positions=tp.Positions(u=2, v=2))
    scene = tp.Scene(lamp, [floor, tp.Surface(wall, tp.Black())], detector)
    frame = frame_of(scene)
    parts = [
        replace(part, seen_from=None) for part in parts_of(scene, frame, tp.simulate(scene, particles=200))
    ]
    view = view_of(parts, frame, 1.5)
    return (view.position - frame.middle) / frame.size


def test_a_hollow_alone_shows_the_side_that_something_is_on():
    ball = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.5), "ball")
    for side in ("inside", "outside"):
        scene = tp.Scene(tp.Source("ball", tp.Lambertian(radiance=1.0), side=side), ball)
        assert parts(scene)[0]["ball"].seen_from == (BACK if side == "inside" else FRONT)


class Easel:
    """Takes the place of a plotter and keeps what it is told to draw; needs no screen."""

    def __init__(self):
        self.meshes, self.bars = [], []

    def add_mesh(self, mesh, **look):
        self.meshes.append((mesh, look))

    def __getattr__(self, name):
        return lambda *arguments, **look: None


@pytest.fixture
def easel(monkeypatch):
    made = Easel()
    monkeypatch.setattr(
        night, "add_bar", lambda plotter, actor, title, scale, *place: made.bars.append((title, scale))
    )
    return made


def test_colours_are_logarithms_of_what_was_read_and_few_hits_have_none(easel, monkeypatch):
    floor = tp.Detector("-z", "floor", side="back", positions=tp.Positions(u=8, v=8))
    scene = room(detectors=floor)
    result, tracks = tp.simulate(scene, particles=300, seed=1, batches=4), tp.tracks(scene, particles=20)
    frame = frame_of(scene, tracks)
    keep = easel.add_mesh
    monkeypatch.setattr(easel, "add_mesh", lambda *a, **look: (keep(*a, **look), object())[1], raising=False)
    scene_view._add_parts(easel, scene, parts_of(scene, frame, result), frame)
    scene_view._add_tracks(easel, tracks, frame, beside=True)
    (painted, look), (lines, way) = [(mesh, look) for mesh, look in easel.meshes if "shown" in mesh.cell_data]
    value, hits = (np.ravel(getattr(result["floor"], name).value) for name in ("irradiance", "counts"))
    expected = np.where(hits >= 4, np.log10(np.maximum(value, 1e-99)), np.nan)
    np.testing.assert_allclose(painted.cell_data["shown"], expected)
    assert 0 < np.isnan(expected).sum() < 64
    np.testing.assert_allclose(lines.cell_data["shown"], np.log10(tracks.weights))
    (title, scale), (_, of_ways) = easel.bars
    assert title == r"$E\;[\mathrm{W\,m^{-2}}]$"
    assert look["clim"] == (scale.low, scale.high) and way["clim"] == (of_ways.low, of_ways.high)
    assert scale.low <= np.nanmin(expected) and np.nanmax(expected) <= scale.high


def test_a_detector_on_what_has_no_outline_has_its_name():
    ball = tp.Mesh.sphere(radius=0.5)
    scene = tp.Scene(LAMP, detectors=tp.Detector(ball, "ball", side="outside"))
    (part,) = [each for each in parts_of(scene, frame_of(scene)) if each.kind == "detector"]
    assert part.outlined().n_points == 0
    place, words = name_of(part, np.array([0.0, 0.0, 1.0]))
    assert words == "ball"
    np.testing.assert_allclose(place, (0, 0, 0.5), atol=0.02)


@pytest.mark.parametrize("side, sign", [("front", 1), ("back", -1)])
def test_what_lies_on_a_wall_is_drawn_off_it_on_the_side_that_counts(side, sign):
    meter = tp.Detector(tp.Disk(normal=(1, 2, 3), radius=0.5), "meter", side=side)
    scene = tp.Scene(LAMP, detectors=meter)
    (part,) = [each for each in parts_of(scene, frame_of(scene)) if each.kind == "detector"]
    away = _lifted(part.drawn(), part, 1.0).points - part.drawn().points
    assert (sign * away @ np.array([1, 2, 3]) > 0).all()


@pytest.mark.parametrize("largest", [1.0, 1.2, 2.5, 7.1, 9.99, 1.01e-8])
def test_an_even_scale_reaches_the_largest_value(largest):
    assert largest <= night.evenly(np.array([0.1 * largest, largest])).high <= 2 * largest


def test_it_is_said_what_is_not_drawn_and_what_alone_was_counted():
    """A ball on a floor 3000 times its size; a meter that sees only what comes straight."""
    lamp = tp.Source(tp.Point(position=(0, 0, 0.5)), tp.Isotropic(power=1.0))
    ball = tp.Surface(tp.Sphere(center=(0, 0, 0.2), radius=0.1), tp.Black(), "ball")
    floor = tp.Surface(tp.Rectangle(width=1000, height=1000), tp.Black(), "floor")
    straight = tp.Detector("ball", "straight", events=0)
    scene = tp.Scene(lamp, [ball, floor], [straight, tp.Detector("ball", "all", via="floor")])
    result, frame = tp.simulate(scene, particles=2000, batches=4), frame_of(scene)
    words = caption_of(scene, result, None, parts_of(scene, frame, result), frame)
    assert "not drawn, far larger: floor" in words
    assert "of ball only what counts with events=(0, 0)" in words
    with pytest.raises(ValueError, match="irradiance, exitance, got 'net_flux_density'"):
        parts_of(scene, frame, result, "net_flux_density")
