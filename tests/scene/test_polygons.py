"""A polygon: area, division into triangles, refusals; as a source, a wall, a detector and in view factors."""

import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from tests.refusals import assert_refused
from tests.round_trips import read_again
from tests.slow import quick
from transport.geometry import polygon as module
from transport.geometry.relations import are_on_one_support, overlap

L = ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))
U = ((0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2))
TURNS = np.arange(10) * math.pi / 5
RADII = np.where(np.arange(10) % 2, 0.4, 1.0)
STAR = np.stack([RADII * np.cos(TURNS), RADII * np.sin(TURNS)], axis=1)
TEETH = [corner for k in range(7, -1, -1) for corner in ((k + 0.9, 3), (k + 0.1, 3), (k, 0.1))]
COMB = [(8, 0.1), *TEETH, (0, 0), (8, 0)]
OUTLINES = {"L": L, "U": U, "star": STAR, "comb": COMB, "square": ((0, 0), (1, 0), (1, 1), (0, 1))}
EXACT = {"L": 3.0, "U": 5.0, "star": 2 * math.sin(math.pi / 5), "comb": None, "square": 1.0}


def lift(outline, z=0.0, scale=1.0, turned=False):
    """An outline as points in space, scaled; turned into an oblique plane."""
    points = np.column_stack([np.array(outline, dtype=float), np.full(len(outline), z)])
    if turned:
        a, b = 0.7, -1.1
        about_x = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
        about_z = np.array([[math.cos(b), -math.sin(b), 0], [math.sin(b), math.cos(b), 0], [0, 0, 1]])
        points = points @ (about_z @ about_x).T
    return [tuple(point) for point in (scale * points).tolist()]


def polygon(outline, **how):
    return tp.Polygon(vertices=lift(outline, **how))


def shoelace(outline):
    x, y = np.array(outline, dtype=float).T
    return 0.5 * math.fsum(x * np.roll(y, -1) - np.roll(x, -1) * y)


def moments(outline):
    """Exact mean and mean square of the coordinates over the area, from the sides (Green)."""
    (x, y), (s, t) = np.array(outline, dtype=float).T, np.roll(outline, -1, axis=0).astype(float).T
    cross, area = x * t - s * y, shoelace(outline)
    first = np.array([math.fsum((p + q) * cross) for p, q in ((x, s), (y, t))]) / (6 * area)
    second = np.array([math.fsum((p * p + p * q + q * q) * cross) for p, q in ((x, s), (y, t))]) / (12 * area)
    return first, second


# ---- geometry ----


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e9])
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("name", OUTLINES)
def test_area_is_that_of_its_outline_at_any_scale(name, turned, scale):
    shape = polygon(OUTLINES[name], scale=scale, turned=turned)
    assert shape.area == pytest.approx(shoelace(OUTLINES[name]) * scale**2, rel=1e-14)
    assert EXACT[name] is None or shoelace(OUTLINES[name]) == pytest.approx(EXACT[name], rel=1e-14)
    assert turned or len(shape.primitives()) == len(OUTLINES[name]) - 2  # some lie on a line within rounding
    if not turned:
        middle, _ = moments(OUTLINES[name])
        assert np.array(shape.center[:2]) / scale == pytest.approx(middle, rel=1e-13, abs=1e-13)
        assert shape.normal == (0.0, 0.0, 1.0)


@pytest.mark.parametrize("name", OUTLINES)
def test_triangles_share_sides_only_and_face_as_the_polygon(name):
    triangles = polygon(OUTLINES[name], turned=True).primitives()
    normal = np.array(polygon(OUTLINES[name], turned=True).normal)
    for number, one in enumerate(triangles):
        assert one.normal == pytest.approx(normal, abs=1e-14)
        assert not any(overlap(one, other) for other in triangles[:number])


def test_order_and_number_of_vertices():
    """The normal follows their order; those on a side change nothing; there may be a thousand."""
    assert polygon(L[::-1]).normal == (0.0, 0.0, -1.0) and polygon(L[::-1]).area == 3.0
    more = ((0, 0), (0.3, 0), (1, 0), (2, 0), (2, 0.5), (2, 1), (1, 1), (1, 2), (0.5, 2), (0, 2), (0, 1))
    assert polygon(more).area == pytest.approx(3.0, rel=1e-15)
    assert polygon(more).center == pytest.approx(polygon(L).center, rel=1e-14)
    turns = np.linspace(0, 2 * math.pi, 1001)[:-1]
    circle = polygon(np.stack([np.cos(turns), np.sin(turns)], axis=1))
    assert circle.area == pytest.approx(500 * math.sin(2 * math.pi / 1000), rel=1e-13)


def test_covered_points_and_distances():
    shape, rng = polygon(L), np.random.default_rng(1)
    points = rng.uniform(-0.5, 2.5, (2000, 2))
    is_in = (points > 0).all(axis=1) & (points < 2).all(axis=1) & (points < 1).any(axis=1)
    flat = np.column_stack([points, np.zeros(len(points))])
    assert (shape.covers(flat) == is_in).all()
    assert shape.distance((0.5, 0.5, 0.3)) == pytest.approx(0.3, rel=1e-15)
    assert shape.distance((1.5, 1.5, 0.0)) == pytest.approx(0.5, rel=1e-15)
    assert shape.distance((3.0, 2.0, 2.0)) == pytest.approx(math.sqrt(6), rel=1e-14)


def unfair(areas, numbers):
    """Triangles that are not chosen by area."""
    facets = (numbers * len(areas)).astype(int)
    return facets, (numbers * len(areas) - facets)[:, None]


def test_points_are_even_over_the_area_and_triangles_not_chosen_by_area_are_seen(monkeypatch):
    shape, numbers = polygon(L), np.random.default_rng(3).random((200_000, 2))

    def deviations():
        points, normals = shape.sample_area(numbers)
        assert shape.covers(points).all() and (normals == (0, 0, 1)).all()
        powers = [points[:, :2] ** n for n in (1, 2)]
        errors = [each.std(axis=0) / math.sqrt(len(points)) for each in powers]
        return [(p.mean(axis=0) - m) / e for p, m, e in zip(powers, moments(L), errors, strict=True)]

    assert np.abs(deviations()).max() < 4.5
    monkeypatch.setattr(module, "even_facets", unfair)
    assert np.abs(deviations()).max() > 4.5


# ---- refusals ----

BAD = {
    "two": ([(0, 0, 0), (1, 0, 0)], "3 to 1000 points .* got 2 .*; write vertices="),
    "a number": (3, "3 to 1000 points"),
    "not finite": ([(0, 0, 0), (1, 0, math.nan), (0, 1, 0)], "finite"),
    "repeated": ([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 0, 0)], r"must differ, got \(0.0, 0.0, 0.0\) as number 0 and 3.*leave"),
    "a line": ([(0, 0, 0), (1, 1, 1), (2, 2, 2), (3, 3, 3)], "one line.*no area; move"),
    "bent": ([(0, 0, 0), (1, 0, 0), (1, 1, 1e-9), (0, 1, 0)], "one plane.* m off.*Mesh"),
    "bow tie": ([(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0)], "cross or touch.*sides 0 and 2.*order"),
    "touching": ([(0, 0, 0), (2, 0, 0), (2, 2, 0), (1, 0, 0), (0, 2, 0)], "cross or touch.*sides 0 and 2"),
    "spike": ([(0, 0, 0), (2, 0, 0), (1, 0, 0), (1, 1, 0)], "cross or touch.*sides 0 and 1"),
}  # fmt: skip


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e9])
@pytest.mark.parametrize("name", BAD)
def test_refused(name, scale):
    vertices, message = BAD[name]
    if scale != 1 and isinstance(vertices, list) and "number" not in message and "off" not in message:
        vertices = [tuple(scale * x for x in vertex) for vertex in vertices]
    with pytest.raises(tp.SceneError, match=f"Polygon: .*{message}"):
        tp.Polygon(vertices=vertices)


def test_a_plane_is_judged_by_the_rounding_of_coordinates():
    def lifted(shift):
        return [(x + shift, y + shift, shift + 3e-10 * (k == 3)) for k, (x, y) in enumerate(L)]

    tp.Polygon(vertices=lifted(1e6))  # 3e-10 m are two roundings of a coordinate of 1e6 m
    assert_refused(lambda: tp.Polygon(vertices=lifted(0.0)), "one plane")


# ---- in a scene ----


def exact_view_factor(a, b):
    """View factor between two polygons that do not touch: the double integral of ln r along their outlines."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    total = 0.0
    for p, q in zip(a, [*a[1:], a[0]], strict=True):
        one, along = np.array(p) + np.outer((nodes + 1) / 2, np.subtract(q, p)), np.subtract(q, p)
        for s, t in zip(b, [*b[1:], b[0]], strict=True):
            other, across = np.array(s) + np.outer((nodes + 1) / 2, np.subtract(t, s)), np.subtract(t, s)
            logs = np.log(np.linalg.norm(one[:, None] - other[None], axis=2))
            total += float(along @ across) * float(weights @ logs @ weights) / 4
    area = tp.Polygon(vertices=a).area
    return abs(total) / (2 * math.pi * area)


LAMP = lift(STAR, z=1.2)[::-1]  # shines downwards
FLOOR = lift(L)
POINT = tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0))


def run(sources, surfaces=(), detectors=(), particles=200_000, **how):
    return tp.simulate(tp.Scene(sources, surfaces, detectors), particles, progress=False, **how)


def shower(width, power):
    """Parallel light on (1, 1, 0) from 1 m above."""
    shape = tp.Rectangle(center=(1, 1, 1), normal=(0, 0, -1), width=width, height=width)
    return tp.Source(shape, tp.Beam((0, 0, -1), power=power))


@pytest.mark.parametrize("estimator", ["analog", "aimed", "expected", "backward"])
def test_a_star_lights_an_l_in_every_estimator(estimator):
    exact = exact_view_factor(LAMP, FLOOR)
    triangles = [each.vertices for each in tp.Polygon(vertices=FLOOR).primitives()]
    assert math.fsum(exact_view_factor(LAMP, list(t)) for t in triangles) == pytest.approx(exact, rel=1e-12)
    lamp = tp.Source(tp.Polygon(vertices=LAMP), tp.Lambertian(power=1.0))
    floor = tp.Detector(tp.Polygon(vertices=FLOOR), "floor")
    assert_agrees(run(lamp, (), floor, seed=2, estimator=estimator)["floor"].flux_in, exact)


@pytest.mark.parametrize("scale", [1e-6, 1e9])
def test_view_factors_at_any_scale(scale):
    a, b = (tp.Polygon(vertices=[tuple(scale * x for x in v) for v in points]) for points in (LAMP, FLOOR))
    assert_agrees(tp.view_factor(a, b, particles=100_000, seed=3), exact_view_factor(LAMP, FLOOR))
    assert_agrees(tp.view_factor(b, a, particles=100_000, seed=3), exact_view_factor(FLOOR, LAMP))


def test_a_beam_fills_it_evenly_by_its_projected_area():
    """The power of an irradiance; and the image of the polygon on a screen of pixels."""
    shape = polygon(L, turned=True)
    direction = np.array(shape.normal) * 0.8 + np.array(shape.frame[0]) * 0.6
    source = tp.Source(shape, tp.Beam(tuple(direction), irradiance=2.0))
    power = run(source, particles=1000, seed=1).ledger["emitted"].value
    assert power == pytest.approx(2.0 * 3.0 * 0.8, rel=1e-12)
    screen = tp.Rectangle(center=(1, 1, 1), width=2, height=2, normal=(0, 0, 1))
    detector = tp.Detector(screen, "screen", side="back", positions=tp.Positions(u=2, v=2))
    beam = tp.Source(polygon(L), tp.Beam((0, 0, 1), power=1.0))
    light = run(beam, (), detector, particles=100_000, seed=5)["screen"].irradiance
    z = light.z(np.array([[1, 1], [1, 0]]) / 3)
    assert np.abs(z[[0, 0, 1], [0, 1, 0]]).max() < 4.5 and light.value[1, 1] == 0


def test_a_plate_shades_what_lies_behind_it():
    """A beam on a black plate: what passes is the light beside the plate, by area."""
    plate = tp.Surface(polygon(U), tp.Black(), name="plate")
    below = tp.Detector(tp.Rectangle(center=(1, 1, -1), width=8, height=8), "below")
    result = run(shower(4, 16.0), plate, below, seed=6)
    assert_agrees(result["below"].flux_in, 16.0 - 5.0)
    assert_agrees(result.ledger.absorbed_by["plate"], 5.0)
    assert result.ledger["lost"].value == 0


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e9])
@pytest.mark.parametrize("turned", [False, True])
def test_polygons_that_share_sides_lose_nothing(turned, scale):
    """A square of an L and its complement, with a notch: all light is absorbed by one of the two."""
    rest = ((2, 1), (2, 2), (1, 2), (1, 1))
    walls = [
        tp.Surface(polygon(outline, turned=turned, scale=scale), tp.Black(), name=name)
        for name, outline in (("L", L), ("rest", rest))
    ]
    normal = np.array(walls[0].shape.normal)
    middle = tuple((np.array(lift([(1, 1)], turned=turned)[0]) + 0.5 * normal) * scale)
    lamp = tp.Source(tp.Point(position=middle), tp.Isotropic(power=1.0), aim=walls[1].shape)
    center, size = tuple(np.array(middle) - scale * normal), {"width": 1e-3 * scale, "height": 1e-3 * scale}
    beyond = tp.Detector(tp.Rectangle(center=center, normal=tuple(normal), **size), "behind")
    result = run(lamp, walls, beyond, seed=7)
    assert result["behind"].flux_in.value == 0 and result.ledger["lost"].value == 0
    assert walls[0].shape.area + walls[1].shape.area == pytest.approx(4 * scale**2, rel=1e-14)


def test_a_room_of_polygons_leaks_nothing():
    """A prism over a star, its walls and lids black: no particle escapes."""
    low, high = lift(STAR), lift(STAR, z=1.0)
    sides = [tp.Polygon(vertices=(low[k], low[k - 1], high[k - 1], high[k])) for k in range(len(low))]
    shapes = [tp.Polygon(vertices=low), tp.Polygon(vertices=high[::-1]), *sides]
    walls = [tp.Surface(shape, tp.Diffuse(albedo=0.8), name=f"w{k}") for k, shape in enumerate(shapes)]
    lamp = tp.Source(tp.Point(position=(0.1, 0, 0.4)), tp.Isotropic(power=1.0))
    result = run(lamp, walls, particles=100_000, seed=8)
    assert result.ledger["escaped"].value == 0 and result.ledger["lost"].value == 0


def test_a_patch_on_a_polygon_wall_counts_each_arrival_once():
    wall = tp.Surface(polygon(L), tp.Black(), name="wall")
    outline = ((0.2, 0.2), (1.8, 0.2), (1.8, 0.6), (0.6, 0.6), (0.6, 1.8), (0.2, 1.8))
    patch = tp.Detector(polygon(outline), "patch")
    result = run(shower(2, 4.0), wall, [patch, tp.Detector("wall", "all")], seed=9)
    assert_agrees(result["all"].flux_in, 3.0)
    assert_agrees(result["patch"].flux_in, patch.shape.area)
    assert not are_on_one_support(wall.shape, tp.Plane(center=(0, 0, 1e-9)))


def test_directions_are_measured_in_its_own_frame_in_every_estimator():
    """Bins of azimuth of a detector: a lamp beside it fills one half of them."""
    detector = tp.Detector(polygon(L), "floor", directions=tp.Directions(phi=4))
    corners = [(3, 0, 0.2), (3, 0, 1), (3, 1, 1), (3, 1, 0.2)]
    lamp = tp.Source(tp.Polygon(vertices=corners), tp.Lambertian(power=1.0))
    assert lamp.shape.normal == (-1.0, 0.0, 0.0)
    ways = {"analog": 1, "backward": 2}
    forward, backward = (
        run(lamp, (), detector, seed=seed, estimator=way)["floor"].radiance for way, seed in ways.items()
    )
    apart = (forward.value - backward.value) / np.maximum(np.hypot(forward.error, backward.error), 1e-300)
    lit = (forward.value > 0) | (backward.value > 0)
    assert lit.any() and not lit.all() and np.abs(apart[lit]).max() < 4.5


def test_overlapping_polygons_are_refused_and_shared_sides_are_not():
    def scene(other):
        return tp.Scene(POINT, [tp.Surface(each, tp.Black()) for each in (polygon(L), other)])

    scene(polygon(((2, 1), (2, 2), (1, 2), (1, 1))))
    scene(tp.Rectangle(center=(1.5, 1.5, 0), width=1, height=1))
    square, disk = (
        tp.Rectangle(center=(1.4, 1.4, 0), width=1, height=1),
        tp.Disk(center=(0.5, 1.5, 0), radius=0.1),
    )
    for other in (square, disk, polygon(L)):
        assert_refused(lambda other=other: scene(other), "overlap on one plane")


def test_files_keep_it(tmp_path):
    floor = tp.Detector(polygon(L), "floor")
    scene = tp.Scene(tp.Source(tp.Polygon(vertices=LAMP), tp.Lambertian(power=1.0)), detectors=floor)
    read_again(scene)
    tp.simulate(scene, particles=1000, seed=1).save(tmp_path / "run.nc")
    assert tp.load(tmp_path / "run.nc").scene == scene


def test_it_is_drawn_with_its_area_and_its_outline():
    from transport.viz.facets import facets_of, outline

    drawn = facets_of(polygon(U))
    assert drawn.vector_areas.sum(axis=0) == pytest.approx([0, 0, 5.0], rel=1e-14)
    length = outline(polygon(U)).compute_cell_sizes()["Length"].sum()
    assert length == pytest.approx(3 + 2 + 1 + 1 + 1 + 1 + 1 + 2, rel=1e-6)


def square(normal, across, shift):
    """A square of 2 m whose normal passes through its middle, `shift` along it."""
    along = np.cross(normal, across)
    corners = [(shift * normal + p * across + q * along) for p, q in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return tp.Polygon(vertices=[tuple(map(float, corner)) for corner in corners])


@pytest.mark.parametrize("kind", quick(["detector", "transparent", "body"], "transparent"))
def test_no_ray_passes_between_the_triangles_of_a_polygon(kind):
    """Pencils at the centre of a square, where its diagonals are, whatever way it is turned."""
    rng = np.random.default_rng(3)
    for _ in range(24):
        x, y, z = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        lamp = tp.Source(tp.Point(position=tuple(3 * z)), tp.Beam(power=1.0, direction=tuple(-z)))
        if kind == "body":
            normals = [(z, x), (-z, x), (x, y), (-x, y), (y, z), (-y, z)]
            fog, faces = tp.Medium(absorption=1.0), [square(*each, 1.0) for each in normals]
            cube = [tp.Surface(face, tp.Transparent(), back=fog) for face in faces]
            ledger = run(lamp, cube, particles=64, seed=1, threads=1).ledger
            found, exact = sum(each.value for each in ledger.absorbed_by.values()), 1 - math.exp(-2)
        else:
            plate = square(z, x, 0.0)
            walls = [tp.Surface(plate, tp.Transparent(), "plate")] if kind == "transparent" else []
            meter = tp.Detector("plate" if walls else plate, "meter")
            result = run(lamp, walls, meter, particles=64, seed=1, threads=1)
            found, exact = result["meter"].flux_in.value, 1.0
        assert found == pytest.approx(exact, rel=1e-9)


def test_a_polygon_of_three_vertices_is_a_triangle_in_every_role():
    corners, light = [(0, 0, 1), (0, 1, 1), (1, 0, 1)], tp.Lambertian(power=1.0)
    below = tp.Detector(tp.Disk(center=(0, 0, -3), radius=1.0), "meter")
    lamp, how = tp.Source(tp.Disk(radius=0.1), light), {"particles": 1000, "seed": 1}

    def numbers(shape):
        for name in ("analog", "aimed", "expected", "backward"):
            yield run(tp.Source(shape, light), (), below, estimator=name, **how)["meter"].flux_in.value
        yield run(lamp, (), tp.Detector(shape, "meter"), estimator="expected", **how)["meter"].flux_in.value
        yield tp.solid_angle(shape, (0, 0, 0), **how).value

    one, other = (list(numbers(kind(vertices=corners))) for kind in (tp.Polygon, tp.Triangle))
    assert one == pytest.approx(other, rel=1e-12)
