"""Lobes of radiance point where the light comes from, on every side of every shape, and are as long as it is bright."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from transport.viz.directions import direction_bins
from transport.viz.facets import places_on
from transport.viz.lobes_in_place import _at_corners, hemisphere, lobe, place_and_frame

FINE = tp.Directions(theta=np.linspace(0, math.pi / 2, 19), phi=36)  # bins of 5 and 10 degrees
TILTED = (1.0, 2.0, 3.0)
STANDS = {
    "tilted disk": (tp.Disk(normal=TILTED, radius=0.5, up=(1, 0, 0)), "front", None, ()),
    "from behind": (tp.Disk(normal=TILTED, radius=0.5, up=(1, 0, 0)), "back", None, ()),
    "a corner of a rectangle": (
        tp.Rectangle(normal=TILTED, width=2, height=1),
        "front",
        tp.Positions(u=4, v=3),
        (3, 0),
    ),
    "a ball": (tp.Sphere(radius=1.0, axis=TILTED), "front", tp.Positions(u=12, v=24), (3, 5)),
    "in a ball": (tp.Sphere(radius=1.0, axis=TILTED), "inside", tp.Positions(u=12, v=24), (8, 17)),
    "a cone": (tp.Cone(radius=1, top_radius=0.5, height=1), "front", tp.Positions(u=3, v=24), (1, 9)),
}


@pytest.mark.parametrize("name", STANDS)
def test_a_lobe_points_at_the_light(name):
    """A pencil of light from 40 degrees off the normal: the lobe's tip is in its bin, within 5 degrees and 10 / 2 sin 40."""
    shape, side, positions, at = STANDS[name]
    detector = tp.Detector(shape, "meter", side=side, positions=positions, directions=FINE)
    place, (e_u, e_v, n) = _stand(shape, detector, at)
    light = math.sin(0.7) * (math.cos(2.05) * e_u + math.sin(2.05) * e_v) + math.cos(0.7) * n
    source = tp.Source(tp.Point(position=place + 0.05 * light), tp.Beam(tuple(-light), power=1.0))
    result = tp.simulate(tp.Scene(source, detectors=detector), particles=64, batches=2)
    reading = result["meter"]
    where, frame = place_and_frame(reading, at)
    np.testing.assert_allclose(where, place, atol=1e-12)
    radiance = reading.radiance[at] if at else reading.radiance
    drawn = lobe(direction_bins(radiance), where, frame, 2.0)
    brightest = drawn.cell_data["radiance"].argmax()
    assert drawn.cell_data["radiance"][brightest] == np.nanmax(radiance.value) > 0
    cell = np.flatnonzero(drawn.cell_data["radiance"] > 0)
    assert len(cell) == 2  # one bin of 10 degrees, in steps of 5
    tips = drawn.points[np.unique(drawn.regular_faces[cell])] - where
    assert tips.mean(axis=0) @ light / np.linalg.norm(tips.mean(axis=0)) > math.cos(math.radians(5))
    assert (np.linalg.norm(drawn.points - where, axis=1) <= 2.0 + 1e-12).all()


def _stand(shape, detector, at):
    """Place and frame of the side, told independently: from positions and the words of the design."""
    if detector.positions is None:
        place = np.array(shape.center)
        e_u, e_v, n = (np.array(axis) for axis in shape.frame)
    else:
        u, v = (
            (e[k] + e[k + 1]) / 2 for k, e in zip(at, detector.positions.edges(shape).values(), strict=True)
        )
        place = places_on(shape)(np.array([u]), np.array([v]))[0]
        if isinstance(shape, tp.Rectangle):
            e_u, e_v, n = (np.array(axis) for axis in shape.frame)
        else:
            step = 1e-6
            along_u = places_on(shape)(np.array([u + step]), np.array([v]))[0] - place
            along_v = places_on(shape)(np.array([u]), np.array([v + step]))[0] - place
            n = np.cross(along_u, along_v)
            n *= np.sign(n @ (place - np.array(shape.center) * 1.0)) / np.linalg.norm(n)
            e_v = np.array(shape.axis) - (np.array(shape.axis) @ n) * n
            e_v /= np.linalg.norm(e_v)
            e_u = np.cross(e_v, n)
    return (place, (-e_u, e_v, -n)) if detector.is_back else (place, (e_u, e_v, n))


def test_an_even_glow_is_a_hemisphere():
    disk = tp.Disk(radius=1.0)
    detector = tp.Detector(disk, "leaving", directions=tp.Directions(mu=4))
    scene = tp.Scene(tp.Source(disk, tp.Lambertian(radiance=3.0)), detectors=detector)
    reading = tp.simulate(scene, particles=200_000, batches=8)["leaving"]
    place, frame = place_and_frame(reading)
    drawn = lobe(direction_bins(reading.radiance_out), place, frame, 1.0)
    radii = np.linalg.norm(drawn.points, axis=1)
    assert radii.min() > 0.97 and radii.max() <= 1 + 1e-12 and drawn.points[:, 2].min() > -1e-12
    wire = hemisphere(place, frame, 1.0)
    assert wire.points[:, 2].min() > -1e-12 and math.isclose(np.linalg.norm(wire.points, axis=1).max(), 1.15)


def test_what_has_no_frame_or_no_bin_of_place_is_refused():
    box = tp.Box(size=1.0)
    scene = tp.Scene(
        tp.Source(box, tp.Lambertian(radiance=1.0)),
        detectors=tp.Detector(box, "box", directions=tp.Directions(mu=2)),
    )
    reading = tp.simulate(scene, particles=100, batches=2)["box"]
    with pytest.raises(ValueError, match="Box has no frame"):
        place_and_frame(reading)
    with pytest.raises(ValueError, match="at must name one bin"):
        place_and_frame(reading, (0,))


def test_corners_are_means_across_the_seam_of_a_turn():
    cells = np.array([[4.0, 0.0, 0.0, 2.0]])
    np.testing.assert_allclose(_at_corners(cells, True)[0], [3, 2, 0, 1, 3])
    np.testing.assert_allclose(_at_corners(cells, False)[0], [4, 2, 0, 1, 2])
