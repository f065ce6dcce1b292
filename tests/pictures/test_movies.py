"""Movies: particles lie where their tracks or the clock put them, and each frame of the GIF shows its own instant."""

from __future__ import annotations

import numpy as np
import pytest

import transport as tp
from transport.viz.movie import (
    Flying,
    along,
    clock_movie,
    clock_text,
    filmed,
    flights,
    from_entry,
    tracks_movie,
)
from transport.viz.screen import has_screen

needs_screen = pytest.mark.skipif(not has_screen(), reason="no OpenGL here")
BOX = (np.full(3, -2.0), np.full(3, 2.0))


def beam(**more):
    """A beam along +x that a mirror at x = 3 m sends to +z."""
    mirror = tp.Rectangle(center=(3, 0, 0), normal=(-1, 0, 1), width=2, height=2)
    source = tp.Source(tp.Point(), tp.Beam((1, 0, 0), power=1.0))
    return tp.Scene(source, surfaces=tp.Surface(mirror, tp.Mirror(), name="mirror"), **more)


@pytest.mark.parametrize("way, place, direction, tails", [
    (0.0, (0, 0, 0), (1, 0, 0), []), (2.0, (2, 0, 0), (1, 0, 0), [1.0]), (5.0, (3, 0, 2), (0, 0, 1), [1.0]),
    (3.25, (3, 0, 0.25), (0, 0, 1), [0.25, 0.75]),  # around the corner
])  # fmt: skip
def test_particles_have_flown_as_far_as_the_clock_says_with_the_last_of_it_as_their_tail(
    way, place, direction, tails
):
    frame = along(tp.tracks(beam(), 10, seed=1), way, tail=1.0)
    assert frame.seconds == pytest.approx(way / tp.speed_of_light)
    np.testing.assert_allclose(frame.heads.places, np.tile(place, (10, 1)), atol=1e-9)
    np.testing.assert_allclose(frame.heads.directions, np.tile(direction, (10, 1)), atol=1e-9)
    lengths = np.linalg.norm(np.diff(frame.tails.places, axis=1)[:, 0], axis=-1)
    np.testing.assert_allclose(np.sort(lengths), np.repeat(tails, 10), atol=1e-9)
    ends = np.abs(frame.tails.places[:, 1] - np.array(place)).max(axis=1) < 1e-9
    assert ends.sum() == (10 if tails else 0)


def test_light_from_afar_is_followed_from_the_edge_of_the_picture():
    """From two places 1e9 m and 3e9 m away: both particles are at the edge at first, and neither has got lost."""
    sources = [
        tp.Source(tp.Point(position=(x, 0, 0)), tp.Beam((np.sign(-x), 0, 0), power=1.0)) for x in (1e9, -3e9)
    ]
    meter = tp.Detector(tp.Disk(normal=(1, 0, 0), radius=1), "meter")
    tracks = tp.tracks(tp.Scene(sources, detectors=meter), 8, seed=1)
    assert flights(tracks, BOX)[1]
    near = from_entry(tracks, BOX)
    places = along(near, 0.5, 0.1).heads.places
    assert len(places) == 8
    np.testing.assert_allclose(np.abs(places[:, 0]), 1.5, atol=1e-6)
    assert len(np.unique(np.sign(places[:, 0]))) == 2
    np.testing.assert_allclose(along(near, 2.5, 0.1).heads.places, -places / 3, atol=1e-6)


def test_no_particle_is_left_where_all_were_absorbed():
    wall = tp.Surface(tp.Sphere(radius=1), tp.Black(), name="wall")
    scene = tp.Scene(tp.Source(tp.Point(), tp.Isotropic(power=1.0)), surfaces=wall)
    tracks = tp.tracks(scene, 50, seed=1)
    assert [len(along(tracks, way, 0.1).heads.places) for way in (0.999, 1.001)] == [50, 0]
    instants, is_from_edge = flights(tracks, BOX, 5)
    assert [len(instant.heads.places) for instant in instants] == [50, 50, 50, 50, 0]
    assert not is_from_edge


def test_a_film_has_snapshots_from_the_first_to_the_last_instant():
    scene = filmed(beam(duration=2e-8), frames=5, particles=20)
    assert [shot.time for shot in scene.snapshots] == pytest.approx([0, 5e-9, 1e-8, 1.5e-8, 2e-8])
    with pytest.raises(tp.SceneError, match="duration"):
        filmed(beam())


@pytest.mark.slow
@needs_screen
def test_the_frames_of_both_movies_show_the_particles_where_they_are(tmp_path):
    """The same beam by the clock and along its tracks: the particle climbs in the picture after the mirror."""
    from PIL import Image

    own = tp.Snapshot(1e-9, particles=50, name="own")  # is no frame
    scene = beam(duration=5 / tp.speed_of_light, detectors=own)
    result = tp.simulate(filmed(scene, frames=6, particles=5), 100, seed=1, threads=1)
    clocked = clock_movie(scene, tmp_path / "clock.gif", result, title="A beam")
    steady = tracks_movie(beam(), tmp_path / "tracks.gif", tp.tracks(beam(), 5, seed=1), "weight", frames=6)
    for path in (clocked, steady):
        with Image.open(path) as movie:
            assert (movie.n_frames, movie.info["loop"]) == (6, 0)
            shown = []
            for k in (0, 2, 5):
                movie.seek(k)
                picture = np.asarray(movie.convert("RGB")).astype(int)
                shown.append(picture[: 4 * len(picture) // 5])  # without the label
        moved = [(abs(a - b).sum(axis=2) > 60).sum() for a, b in zip(shown, shown[1:], strict=False)]
        assert all(5 < pixels < 2000 for pixels in moved)


def test_a_result_without_snapshots_and_an_unknown_colour_are_refused(tmp_path):
    result = tp.simulate(beam(), 10, seed=1, threads=1)
    with pytest.raises(ValueError, match="no snapshots"):
        clock_movie(beam(), tmp_path / "a.gif", result)
    with pytest.raises(ValueError, match="direction, weight"):
        tracks_movie(beam(), tmp_path / "a.gif", tp.tracks(beam(), 5), colour="age")


def test_colours_are_cosines_or_weights_and_clocks_have_units():
    some = Flying(np.zeros((2, 3)), np.array([[0.6, 0.0, 0.8], [1.0, 0.0, 0.0]]), np.array([1.0, 1e-3]))
    np.testing.assert_array_equal(some.values("direction"), [0.8, 0.0])
    np.testing.assert_array_equal(some.values("weight"), [1.0, 1e-3])
    assert clock_text("t", 5e-9)(2.5e-9) == "t = 2.50 ns"
    assert clock_text("t", 40.0)(7.0) == "t = 7.0 s"


def test_frames_are_in_the_order_of_their_times(tmp_path, monkeypatch):
    frames = []
    monkeypatch.setattr(
        "transport.viz.movie._film", lambda scene, path, instants, *more: frames.extend(instants)
    )
    late, soon = (tp.Snapshot(time, particles=5, name=f"at {time}") for time in (1e-8, 1e-9))
    result = tp.simulate(beam(duration=2e-8, detectors=[late, soon]), 20, seed=1, threads=1)
    clock_movie(beam(duration=2e-8), tmp_path / "clock.gif", result)
    assert [instant.seconds for instant in frames] == [1e-9, 1e-8]
