"""Beams aimed at what has no width, and bodies that have next to none: right, lost with a warning, or refused with the reason.

Tangents, rims, apexes, edges, corners of bodies that absorb: a beam is absorbed as on one side of the edge or on the other, or lost and
counted with a warning; never absorbed for ever in what it has left.  What is thinner than rounding leaves of it is refused; what is
a hundred times thicker is right.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from transport.compile import surfaces

FOG = tp.Medium(absorption=1.0)


def simulate(scene, particles=64):
    return tp.simulate(scene, particles=particles, seed=1, threads=1, progress=False)


def filled(shape, medium=FOG):
    return tp.Surface(shape, tp.Transparent(), inside=medium)


def beam(position, way):
    return tp.Source(
        tp.Point(position=tuple(map(float, position))), tp.Beam(tuple(map(float, way)), power=1.0)
    )


def base(height):
    return tp.Disk(center=(0, 0, -height), normal=(0, 0, -1), radius=1.0)


def can(medium=FOG, hole=0.0):
    lid = tp.Disk(center=(0, 0, 1), radius=1.0, inner_radius=hole)
    return [filled(shape, medium) for shape in (tp.Cylinder(radius=1.0, height=2.0), lid, base(1))]


def hut(height=2.0):
    return [filled(tp.Cone(radius=1.0, height=height)), filled(base(height / 2))]


def dome():
    return [filled(tp.Sphere(radius=1.0, mu_min=0.0)), filled(base(0))]


def bowl():
    """A paraboloid with its vertex at the origin, and its lid."""
    return [
        filled(tp.Paraboloid(focal_length=0.25, radius=1.0)),
        filled(tp.Disk(center=(0, 0, 1), radius=1.0)),
    ]


def followed(bodies, origin, target, particles=64):
    """Absorbed and lost shares of a beam from one point towards another, and the run's warnings."""
    result = simulate(tp.Scene(beam(origin, np.subtract(target, origin)), bodies), particles)
    return result.ledger["absorbed"].value, result.ledger["lost"].value, result.warnings


def absorbed(length):
    return -math.expm1(-length)


TANGENTS = {  # a body, a beam from where to where, the most that it absorbs
    "wall of a can": (can, (1, 3, 0), (1, 0, 0), 1e-12),
    "pole of a dome": (dome, (3, 0, 1), (0, 0, 1), 1e-12),
    "side of a dome": (dome, (1, 3, 0.5), (1, 0, 0.5), 1e-6),
    "vertex of a bowl": (bowl, (3, 0, 0), (0, 0, 0), 1e-12),
    "apex, from the side": (hut, (2, 0, 1), (0, 0, 1), 1e-12),
    "apex, obliquely past it": (hut, (2, 0, 2), (0, 0, 1), 1e-12),
}


@pytest.mark.parametrize(("solid", "origin", "target", "most"), TANGENTS.values(), ids=TANGENTS)
def test_a_beam_that_only_touches_stays_outside(solid, origin, target, most):
    share, lost, _ = followed(solid(), origin, target)
    assert lost == 0
    assert share <= most


APEXES = {  # height of a cone, a beam from where to where, the length within, relative tolerance
    f"{aside:g} aside, {way}": (2.0, (aside, 0, z), (aside, 0, 0), 2 * (1 - aside), 1e-12)
    for aside in (0.0, 1e-300, 1e-15, 1e-12, 1e-9, 1e-6)
    for z, way in ((3, "down"), (-3, "up"))
}  # so near to the axis that squares vanish
APEXES |= {f"tilt {t}": (2.0, (t, 0, 2), (0, 0, 1), 2 * math.hypot(1, t), 1e-12) for t in (0.1, 0.2, 0.4)}
APEXES |= {
    f"height {h:g} from {z}": (h, (0, 0, z), (0, 0, 0), h, 1e-9)
    for h in (1e-3, 1e-2, 0.1, 0.5, 10.0, 1e3)
    for z in (h / 2, h / 2 + 1, h / 2 + 3, h / 2 + 10, h / 2 + 1e4, -100 - h)
}  # flat cones and sharp ones; the slope at a flat cone's apex is steep in its height


@pytest.mark.quick_cases("0 aside, down", "0 aside, up")
@pytest.mark.parametrize(("height", "origin", "target", "length", "within"), APEXES.values(), ids=APEXES)
def test_a_beam_through_the_apex_of_a_cone_is_absorbed_by_its_chord(height, origin, target, length, within):
    share, lost, _ = followed(hut(height), origin, target)
    assert lost == 0
    assert share == pytest.approx(absorbed(length), rel=within)


@pytest.mark.parametrize("height", [0.01, 0.1, 2.0])
@pytest.mark.parametrize(("z", "into", "out"), [(10.0, "cone", "base"), (-100.0, "base", "cone")])
def test_detectors_on_a_cone_and_its_base_count_a_ray_through_the_apex_once(height, z, into, out):
    looks = [tp.Detector(tp.Cone(radius=1.0, height=height), "cone"), tp.Detector(base(height / 2), "base")]
    result = simulate(tp.Scene(beam((0, 0, z), (0, 0, -z)), [], looks))
    assert (result[into].flux_in.value, result[into].flux_out.value) == (1, 0)
    assert (result[out].flux_in.value, result[out].flux_out.value) == (0, 1)


def aimed_at_rims(number):
    """Beams from all around at points of the rims and corners of solids."""
    rng = np.random.default_rng(number)
    turn, height = rng.uniform(0, 2 * math.pi), rng.choice([-1.0, 1.0])
    rim = (math.cos(turn), math.sin(turn), height)
    corner = tuple(rng.choice([-1.0, 1.0], 3))
    edge = (rng.uniform(-1, 1), *rng.choice([-1.0, 1.0], 2))
    boxes = [[filled(tp.Mesh.box(size=2.0))], [filled(tp.Box(size=2.0))]]
    for bodies, target in [(can(), rim)] + [(box, place) for box in boxes for place in (corner, edge)]:
        for _ in range(6):
            way = rng.normal(size=3)
            yield bodies, tuple(np.array(target) - 3 * way / np.linalg.norm(way)), target


def chord(origin, target, is_can):
    """Length of a line within the can or the box of half sides 1."""
    o, u = np.array(origin, float), np.array(target, float) - origin
    u /= np.linalg.norm(u)
    axes = (2,) if is_can else (0, 1, 2)
    ends = [sorted(((-1 - o[axis]) / u[axis], (1 - o[axis]) / u[axis])) for axis in axes]
    if is_can:
        a, b, c = u[:2] @ u[:2], o[:2] @ u[:2], o[:2] @ o[:2] - 1
        root = math.sqrt(max(b * b - a * c, 0.0))
        ends.append([(-b - root) / a, (-b + root) / a])
    return max(min(far for _, far in ends) - max(near for near, _ in ends), 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(2))
def test_at_rims_and_corners_a_beam_is_absorbed_rightly_or_lost_with_a_warning(number):
    """Through the solid, or past it by nothing."""
    for bodies, origin, target in aimed_at_rims(number):
        share, lost, warnings = followed(bodies, origin, target)
        assert lost in (0.0, 1.0)
        assert lost > 0 or share == pytest.approx(absorbed(chord(origin, target, len(bodies) == 3)), abs=1e-6)
        assert lost == 0 or any("lost" in warning for warning in warnings)


ENDLESS = {
    "outside of a ball": tp.Scene(
        beam((0, 0, 2), (0, 0, 1)),
        tp.Surface(tp.Sphere(radius=1.0), tp.Transparent(), outside=FOG),
        medium=FOG,
    ),
    "a half space under a disk, which bounds nothing": tp.Scene(
        beam((0, 0, 1), (0, 0, -1)),
        [
            tp.Surface(tp.Rectangle(width=1, height=1, center=(0, 0, 0.5)), tp.Transparent()),
            filled(tp.Plane()),
        ],
        tp.Detector(tp.Plane(), "top"),
    ),
}


@pytest.mark.parametrize("scene", ENDLESS.values(), ids=ENDLESS)
def test_nothing_is_lost_in_endless_bodies(scene):
    result = simulate(scene)
    assert result.ledger["absorbed"].value == pytest.approx(1.0) and result.ledger["lost"].value == 0


def test_light_that_enters_by_a_gap_is_reported_when_it_leaves():
    """A hole too small for the lines that search for gaps: light that comes in by it is in no fog, and the result says so."""
    leaky = can(hole=0.01)
    share, lost, warnings = followed(leaky, (0, 0, 3), (0, 0, 0))
    assert (share, lost) == (0.0, 0.0)
    assert any("without having entered it: its surfaces leave a gap" in warning for warning in warnings)
    share, lost, warnings = followed(leaky, (0, 0, -3), (0, 0, 0))
    assert lost == pytest.approx(1.0) and any("histories were lost" in warning for warning in warnings)
    assert followed(can(), (0, 0, 3), (0, 0, 0))[2] == []


@pytest.mark.parametrize("balls", [0, 2, 9])
def test_lost_light_of_a_body_is_found_by_its_own_box(balls):
    """A ray that grazes the rim of a can, with other bodies far off: it does not collide in the empty space between them."""
    haze = tp.Medium(absorption=0.01, scattering=0.09)
    far = [filled(tp.Sphere(center=(50.0 + 9 * k, 60, 70), radius=1.0), haze) for k in range(balls)]
    origin = np.array([3.1510952907115253, -0.41387957380853624, 0.10639802125006559])
    way = np.array([-0.938251256781713, -0.17595350266540644, 0.29786732624997814])
    share, lost, warnings = followed([*can(haze), *far], origin, origin + way, particles=2000)
    assert share < 0.1  # 0.8 where one box is laid about all bodies
    assert lost in (0.0, pytest.approx(1.0, abs=0.1))
    assert lost == 0 or any("histories were lost" in warning for warning in warnings)


# ---- thinner than rounding leaves of it ----


def strip(width, aside):
    """What a strip of this width and length 1 absorbs of a beam so many half widths from its middle."""
    shape = tp.Rectangle(center=(0.3, -0.2, 0.7), width=width, height=1.0)
    ray = beam((0.3 + aside * width / 2, -0.2, 1.7), (0, 0, -1))
    return simulate(tp.Scene(ray, tp.Surface(shape, tp.Black(), "strip"))).ledger["absorbed"].value


@pytest.mark.parametrize("width", [1e-8, 1e-10])
def test_a_strip_is_as_wide_as_specified(width):
    assert strip(width, 0.999) == 1
    assert strip(width, 1.001) == 0


def test_without_that_care_light_beside_a_strip_is_absorbed(monkeypatch):
    """Planted: any width is taken."""
    monkeypatch.setattr(surfaces, "MAX_WIDENING", float("inf"))
    assert strip(1e-14, 1.1) == 1


def fibre(radius):
    """A turned can of glass, 1 m long, lit at its end."""
    axis, center = np.array([1.0, 2.0, 3.0]) / math.sqrt(14), np.array([3.0, -2.0, 1.0])

    def end(way, normal=1.0, size=1.0):
        return tp.Disk(center=center + way * axis, normal=normal * axis, radius=size * radius)

    side = tp.Cylinder(center=center, axis=axis, radius=radius, height=1.0)
    glass = [tp.Surface(shape, tp.Dielectric(1.5)) for shape in (end(0.5), end(-0.5, -1.0))]
    lamp = tp.Source(end(0.9, -1.0, 5.0), tp.Lambertian(power=1.0), aim=end(0.5))
    return tp.Scene(lamp, [tp.Surface(side, tp.Dielectric(1.5), "fibre"), *glass])


@pytest.mark.parametrize("radius", [1e-3, 1e-6, 1e-7])
def test_fibres_of_glass_know_their_medium(radius):
    result = simulate(fibre(radius), 2000)
    assert result.ledger["lost"].value == 0 and not result.warnings


LIMIT = "must not differ by more than 1 : 1.1e[+]12"
LAMP = tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0))
RING = tp.Disk(radius=1.0, inner_radius=1 - 1e-13)
SPLINTER = tp.Triangle(vertices=((0, 0, 0), (1, 0, 0), (0.5, 1e-13, 0)))
NARROW = r"Surface 'strip': a flat surface here must be wider than .* got"
GLASS = r"'fibre': glass .* long must have a radius above .* got"  # at 1e-8 a few take glass for air, at 1e-9 light stays in
REFUSED = {
    "needle": (lambda: tp.Cylinder(radius=1e-13, height=1.0), LIMIT),
    "coin": (lambda: tp.Cylinder(radius=1.0, height=1e-13), LIMIT),
    "flat cone": (lambda: tp.Cone(radius=1.0, height=1e-15), LIMIT),
    "sharp cone": (lambda: tp.Cone(radius=1e-100, height=1.0), LIMIT),
    "deep dish": (lambda: tp.Paraboloid(focal_length=1e-139, radius=1.0), LIMIT),
    "flat dish": (lambda: tp.Paraboloid(focal_length=1e50, radius=1e-50), LIMIT),
    "tiny dish": (lambda: tp.Paraboloid(focal_length=1e-300, radius=1e-300), "squares .* must not vanish"),
    "bin at the pole": (lambda: tp.Directions(theta=(0, 1e-9, 1)), "theta bins must be at least .* wide"),
    "bin of the world": (lambda: tp.Directions(theta=(0, 1e-9, 1), frame="world"), "theta bins .*cone"),
    "bin of cosines": (lambda: tp.Directions(mu=(0, 1 - 1e-15, 1)), "mu bins must be at least"),
    "bin of a sphere": (lambda: tp.Directions.sphere(mu=(-1, 1 - 1e-15, 1)), "mu bins must be at least"),
    "strip of 1e-12": (lambda: strip(1e-12, 0.5), NARROW),
    "strip of 1e-14": (lambda: strip(1e-14, 0.5), NARROW),
    "ring": (lambda: simulate(tp.Scene(LAMP, tp.Surface(RING, tp.Black()))), "must be wider"),
    "splinter": (lambda: simulate(tp.Scene(LAMP, tp.Surface(SPLINTER, tp.Black()))), "must be wider"),
    **{f"fibre of {r:g}": (lambda r=r: simulate(fibre(r)), GLASS) for r in (1e-8, 1e-9, 1e-11)},
}


@pytest.mark.parametrize(("make", "words"), REFUSED.values(), ids=REFUSED)
def test_a_shape_or_bin_without_digits_is_refused(make, words):
    with pytest.raises(tp.SceneError, match=words):
        make()


TURNED = {"center": (0.3, -0.2, 0.7), "axis": (1, 2, 3)}
THIN = {
    "needle": tp.Cylinder(**TURNED, radius=1e-11, height=1.0),
    "flat cone": tp.Cone(**TURNED, radius=1.0, height=1e-11),
    "sharp cone": tp.Cone(**TURNED, radius=1e-11, height=1.0),
    "flat dish": tp.Paraboloid(axis=(1, 2, 3), focal_length=1e10, radius=1.0),
}


@pytest.mark.parametrize("shape", THIN.values(), ids=THIN)
def test_light_that_leaves_the_outside_of_thin_bodies_is_gone(shape):
    lamp = tp.Source("wall", tp.Lambertian(power=1.0))
    ledger = simulate(tp.Scene(lamp, tp.Surface(shape, tp.Black(), "wall")), 2000).ledger
    assert ledger["escaped"].value == pytest.approx(1, rel=1e-14)
