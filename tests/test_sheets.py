"""Shapes on one support: meters on walls, sources on floors, patches side by side; every count right, to the last one."""

import dataclasses
import math

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees
from transport.results.detectors import BINS
from transport.results.tally import SIDES
from transport.vectors import unit_vector

BOX = tp.Box(size=2.0)
EXITANCE, ALBEDO = 3.0, 0.4
FURNACE = EXITANCE / (1 - ALBEDO)  # irradiance everywhere on the walls
FALSE_ALARM = 1e-5


def furnace(detectors, ceiling=None):
    """A closed box whose walls all emit and reflect alike: the irradiance is the same at every point."""
    faces = BOX.faces()
    whole = faces.pop("+z")
    patches = {"ceiling": whole} if ceiling is None else ceiling
    walls = [tp.Surface(shape, tp.Diffuse(ALBEDO), name=name) for name, shape in (faces | patches).items()]
    sources = [tp.Source(wall.name, tp.Lambertian(exitance=EXITANCE), side="back") for wall in walls]
    return tp.Scene(sources=sources, surfaces=walls, detectors=detectors)


def run(scene, particles=200_000):
    return tp.simulate(scene, particles=particles, seed=1)


def counted(reading):
    """Weights and counts of arrivals and departures of every batch."""
    return np.array(
        [[read(f"weight {side}") for read in (reading.sums, reading.counts_of)] for side in SIDES]
    )


def test_a_meter_of_a_walls_own_shape_counts_what_the_wall_counts():
    bins = tp.Directions(mu=8, phi=4)
    on_wall = tp.Detector("ceiling", side="back", directions=bins)
    over_wall = tp.Detector(BOX.faces()["+z"], name="meter", side="back", directions=bins)
    result = run(furnace([on_wall, over_wall]))
    one, other = result["ceiling"], result["meter"]
    for score in (f"{kind} {side}" for kind in ("weight", "count", "slant") for side in SIDES):
        for by in ((), BINS):  # with those outside all bins, and in each bin
            np.testing.assert_array_equal(one.sums(score, by), other.sums(score, by))
    assert result["ceiling"].counts.value.sum() > 10_000


def test_a_meter_that_faces_the_other_way_sees_the_other_side():
    inward = tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=2.0, height=2.0)
    detectors = [tp.Detector("ceiling", side="back"), tp.Detector(inward, name="inward")]
    detectors.append(tp.Detector(inward, name="outward", side="back"))
    result = run(furnace(detectors))
    np.testing.assert_array_equal(counted(result["ceiling"]), counted(result["inward"]))
    assert counted(result["outward"]).sum() == 0  # nothing gets behind the wall


@pytest.mark.parametrize("name", ["whole", "overhanging", "ring", "corner"])
def test_a_meter_on_a_wall_counts_the_part_that_lies_on_it(name):
    """The obvious way, remembering a surface and asking t > 0, counts 12 % of the arrivals on such a meter."""
    down = (0, 0, -1)
    shape, share = {
        "whole": (tp.Disk(center=(0.2, 0.1, 1), normal=down, radius=0.5), 1.0),
        "overhanging": (tp.Disk(center=(1, 0.1, 1), normal=down, radius=0.5), 0.5),
        "ring": (tp.Disk(center=(0, 0, 1), normal=down, radius=0.6, inner_radius=0.3), 1.0),
        "corner": (tp.Rectangle(center=(1, 1, 1), normal=down, width=0.8, height=1.2), 0.25),
    }[name]
    reading = run(furnace([tp.Detector(shape, name="meter")]))["meter"]
    assert_agrees(reading.flux_in, FURNACE * shape.area * share, FALSE_ALARM)
    assert_agrees(reading.flux_out, FURNACE * shape.area * share, FALSE_ALARM)  # M = M0 + rho E = E


def test_meters_side_by_side_and_within_each_other_add_up():
    """Two halves of a wall, and a disk with the ring about it: integers that are equal history by history."""
    half = {"height": 2.0, "width": 1.0, "normal": (0, 0, -1)}
    detectors = [
        tp.Detector("ceiling", side="back"),
        tp.Detector(tp.Rectangle(center=(-0.5, 0, 1), **half), name="left"),
        tp.Detector(tp.Rectangle(center=(0.5, 0, 1), **half), name="right"),
        tp.Detector(tp.Disk(center=(0.1, 0.2, 1), normal=(0, 0, -1), radius=0.7), name="disk"),
        tp.Detector(tp.Disk(center=(0.1, 0.2, 1), normal=(0, 0, 1), radius=0.3), name="core", side="back"),
        tp.Detector(
            tp.Disk(center=(0.1, 0.2, 1), normal=(0, 0, -1), radius=0.7, inner_radius=0.3), name="ring"
        ),
    ]
    result = run(furnace(detectors))
    np.testing.assert_array_equal(
        counted(result["left"])[:, 1] + counted(result["right"])[:, 1], counted(result["ceiling"])[:, 1]
    )
    np.testing.assert_array_equal(
        counted(result["core"])[:, 1] + counted(result["ring"])[:, 1], counted(result["disk"])[:, 1]
    )


def test_a_wall_of_two_patches_is_the_wall():
    """Unequal rectangles side by side; sources and detectors on each of them."""
    narrow = tp.Rectangle(center=(-0.7, 0, 1), normal=(0, 0, 1), width=0.6, height=2.0)
    wide = tp.Rectangle(center=(0.3, 0, 1), normal=(0, 0, 1), width=1.4, height=2.0)
    patches = {"narrow": narrow, "wide": wide}
    result = run(furnace([tp.Detector(name, side="back") for name in patches], ceiling=patches))
    for name, shape in patches.items():
        assert_agrees(result[name].flux_in, FURNACE * shape.area, FALSE_ALARM)
        assert_agrees(result[name].flux_out, FURNACE * shape.area, FALSE_ALARM)
    assert result.ledger["lost"].value == 0
    assert result.ledger["escaped"].value == 0


def test_a_disk_in_a_floor_with_a_hole_of_its_size():
    """A black disk fills the hole of a white annulus: unequal shapes on one plane, of which one acts at each point."""
    lamp = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=2.0)
    core, ring = tp.Disk(radius=0.5), tp.Disk(radius=1.5, inner_radius=0.5)
    scene = tp.Scene(
        sources=[tp.Source(lamp, tp.Lambertian(radiance=1.0))],
        surfaces=[tp.Surface(core, tp.Black(), name="core"), tp.Surface(ring, tp.Diffuse(1.0), name="ring")],
        detectors=[tp.Detector("core"), tp.Detector("ring"), tp.Detector(tp.Disk(radius=1.5), name="both")],
    )
    result = run(scene)
    np.testing.assert_array_equal(
        counted(result["core"])[0, 1] + counted(result["ring"])[0, 1], counted(result["both"])[0, 1]
    )
    assert counted(result["core"])[1].sum() == 0
    np.testing.assert_allclose(
        result.ledger.absorbed_by["core"].value, result["core"].flux_in.value, rtol=1e-12
    )


def test_a_source_on_a_floor_leaves_it():
    """A patch that lies on an opaque floor: nothing that is born there is stopped by the floor at birth."""
    floor = tp.Surface(tp.Rectangle(width=4.0, height=4.0), tp.Black(), name="floor")
    patch = tp.Disk(center=(0.3, 0, 0), radius=0.5)
    detectors = [
        tp.Detector("floor"),
        tp.Detector(tp.Disk(center=(0.3, 0, 1e-9), radius=0.5), name="just above", side="back"),
    ]
    result = run(
        tp.Scene(sources=[tp.Source(patch, tp.Lambertian(power=7.0))], surfaces=[floor], detectors=detectors)
    )
    assert result["floor"].flux_in.value == 0
    np.testing.assert_allclose(result["floor"].flux_out.value, 7.0, rtol=1e-12)
    np.testing.assert_allclose(result.ledger["escaped"].value, 7.0, rtol=1e-12)
    np.testing.assert_allclose(result["just above"].flux_in.value, 7.0, rtol=1e-6)


@pytest.mark.parametrize("inside", [True, False])
def test_meters_and_sources_on_one_sphere(inside):
    """An integrating sphere whose wall emits, reflects, and carries a meter of its own shape."""
    sphere = tp.Sphere(center=(0.3, -0.2, 0.1), radius=0.7)
    side = "inside" if inside else "outside"
    scene = tp.Scene(
        sources=[tp.Source("wall", tp.Lambertian(exitance=EXITANCE), side=side)],
        surfaces=[tp.Surface(sphere, tp.Diffuse(ALBEDO), name="wall")],
        detectors=[tp.Detector("wall", side=side), tp.Detector(sphere, name="meter", side=side)],
    )
    result = run(scene)
    np.testing.assert_array_equal(counted(result["wall"]), counted(result["meter"]))
    if inside:
        assert_agrees(result["wall"].irradiance, FURNACE, FALSE_ALARM)
        assert result.ledger["escaped"].value == 0
    else:
        assert result["wall"].flux_in.value == 0
        np.testing.assert_allclose(result["wall"].exitance.value, EXITANCE, rtol=1e-12)


def test_a_ray_crosses_a_sphere_meter_twice():
    """A pencil beam through a sphere: in on one side, out on the other, fluence by the chord's cosine."""
    sphere = tp.Sphere(radius=1.0)
    beam = tp.Source(tp.Point(position=(-2, 0.6, 0)), tp.Beam((1, 0, 0), power=1.0))
    detectors = [tp.Detector(sphere, name=side, side=side) for side in ("outside", "inside")]
    result = run(tp.Scene(sources=[beam], detectors=detectors), 1000)
    for name in ("outside", "inside"):
        np.testing.assert_allclose([result[name].flux_in.value, result[name].flux_out.value], 1.0, rtol=1e-12)
        np.testing.assert_allclose(result[name].fluence_rate.value, 2 / 0.8 / sphere.area, rtol=1e-6)


# ---- surfaces of revolution, triangles, holes, planes ----

AXIS = unit_vector((0.3, -0.2, 0.9))
BACK = tuple(-x for x in AXIS)


def at(height):
    """A point of the axis of the rooms below."""
    return tuple(o + height * a for o, a in zip((0.1, 0.2, 0.3), AXIS, strict=True))


def lid(height, radius, inner_radius=0.0):
    return tp.Disk(
        center=at(height), normal=AXIS if height > 0 else BACK, radius=radius, inner_radius=inner_radius
    )


def cap(height, radius, **bounds):
    return tp.Sphere(center=at(height), axis=AXIS, radius=radius, **bounds)


TUBE = tp.Cylinder(center=at(0), axis=AXIS, radius=0.7, height=2)
BOWL = math.sqrt(1 - (0.4 / 1.3) ** 2)  # cosine of the half angle of a lens
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
ROOMS = {  # closed rooms, seen from within: all walls but those named "front" show their backs
    "tube": [TUBE, lid(1, 0.7), lid(-1, 0.7)],
    "tube of two": [
        tp.Cylinder(center=at(-0.6), axis=BACK, radius=0.7, height=0.8),
        tp.Cylinder(center=at(0.4), axis=AXIS, radius=0.7, height=1.2),
        lid(1, 0.7),
        lid(-1, 0.7),
    ],
    "capsule": [TUBE, cap(1, 0.7, mu_min=0), cap(-1, 0.7, mu_max=0)],
    "cone": [tp.Cone(center=at(0), axis=AXIS, radius=0.7, height=2), lid(-1, 0.7)],
    "frustum": [
        tp.Cone(center=at(0), axis=AXIS, radius=0.7, top_radius=0.5, height=2), lid(-1, 0.7), lid(1, 0.5)
    ],
    "dish": [tp.Paraboloid(center=at(0), axis=AXIS, focal_length=0.3, radius=0.6), lid(0.3, 0.6)],
    "lens": [cap(-1.3 * BOWL, 1.3, mu_min=BOWL), cap(1.3 * BOWL, 1.3, mu_max=-BOWL)],
    "zones": [cap(0, 1, mu_min=0.2), cap(0, 1, mu_max=-0.3), cap(0, 1, mu_min=-0.3, mu_max=0.2)],
    "tetrahedron": [
        tp.Triangle(vertices=[CORNERS[k] for k in order]) for order in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    ],
    "wall with a window": [
        *(face for name, face in BOX.faces().items() if name != "+z"),
        tp.Rectangle(center=(0, 0, 1), width=2, height=2, hole=tp.Disk(center=(0.3, 0.1, 1), radius=0.6)),
        tp.Disk(center=(0.3, 0.1, 1), radius=0.6),
    ],
    "tube through a tube": [
        TUBE, lid(1, 0.7, 0.2), lid(-1, 0.7, 0.2), ("front", tp.Cylinder(center=at(0), axis=AXIS, radius=0.2, height=2))
    ],
}  # fmt: skip


def room(walls, detectors=()):
    """A furnace of these walls, each a detector too."""
    sides = [wall if isinstance(wall, tuple) else ("back", wall) for wall in walls]
    surfaces = [tp.Surface(shape, tp.Diffuse(ALBEDO), name=str(k)) for k, (_, shape) in enumerate(sides)]
    lamps = [
        tp.Source(str(k), tp.Lambertian(exitance=EXITANCE), side=side) for k, (side, _) in enumerate(sides)
    ]
    looks = [tp.Detector(str(k), side=side) for k, (side, _) in enumerate(sides)]
    return tp.Scene(sources=lamps, surfaces=surfaces, detectors=[*looks, *detectors])


@pytest.mark.parametrize("walls", ROOMS.values(), ids=ROOMS)
def test_a_closed_room_of_any_walls_is_a_furnace(walls):
    result = run(room(walls))
    for name in map(str, range(len(walls))):
        assert_agrees(result[name].irradiance, FURNACE, FALSE_ALARM)
    assert result.ledger["lost"].value == result.ledger["escaped"].value == 0


@pytest.mark.parametrize("name", ["tube", "cone", "frustum", "dish", "zones"])
def test_radiance_is_the_same_in_all_bins_of_place_and_direction(name):
    """On the room's first wall; planted: bins by height taken for bins of equal area."""
    [shape, *_] = ROOMS[name]
    bins = {"positions": tp.Positions(u=4, v=3), "directions": tp.Directions(mu=3, phi=4)}
    reading = run(room(ROOMS[name], [tp.Detector(shape, name="meter", side="back", **bins)]), 400_000)[
        "meter"
    ]
    assert reading.radiance.value.shape == (4, 3, 3, 4)
    assert_agrees(reading.radiance, FURNACE / math.pi, FALSE_ALARM)
    assert_agrees(reading.irradiance, FURNACE, FALSE_ALARM)
    if name in ("cone", "dish"):
        areas = bins["positions"].areas(shape)
        with pytest.raises(AssertionError):
            assert_agrees(reading.irradiance, FURNACE * areas / areas.mean(), FALSE_ALARM)


@pytest.mark.parametrize("name", ["tube", "cone", "frustum", "dish", "lens"])
def test_a_meter_on_part_of_a_curved_wall_counts_what_falls_there(name):
    """Two bands that together are the wall, of which one is turned over, and the wall as a whole."""
    [shape, *_] = ROOMS[name]
    low, high = band(shape, 0.0, 0.37), band(shape, 0.37, 1.0)
    looks = [
        tp.Detector(part, name=key, side="back")
        for key, part in (("low", low), ("high", high), ("all", shape))
    ]
    result = run(room(ROOMS[name], looks))
    np.testing.assert_array_equal(counted(result["all"]), counted(result["0"]))
    total = counted(result["low"])[:, 1] + counted(result["high"])[:, 1]
    np.testing.assert_array_equal(total, counted(result["0"])[:, 1])
    for key, part in (("low", low), ("high", high)):
        assert_agrees(result[key].flux_in, FURNACE * part.area, FALSE_ALARM)


def band(shape, first, last):
    """The part between two shares of its height."""
    lower, upper = (shape.profile.low + s * (shape.profile.high - shape.profile.low) for s in (first, last))
    middle = tuple(o + (lower + upper) / 2 * a for o, a in zip(shape.profile.origin, shape.axis, strict=True))
    radii = shape.profile.radius_at(lower), shape.profile.radius_at(upper)
    match shape:
        case tp.Cylinder():
            return tp.Cylinder(center=middle, axis=BACK, radius=shape.radius, height=upper - lower)
        case tp.Cone():
            turned = {"radius": radii[1], "top_radius": radii[0]}
            return tp.Cone(center=middle, axis=BACK, height=upper - lower, **turned)
        case tp.Paraboloid():
            return dataclasses.replace(shape, inner_radius=radii[0], radius=radii[1])
    return dataclasses.replace(shape, mu_min=lower / shape.radius, mu_max=upper / shape.radius)


@pytest.mark.parametrize(
    "shape", [TUBE, ROOMS["cone"][0], ROOMS["dish"][0], ROOMS["zones"][0]], ids=lambda s: type(s).__name__
)
def test_what_leaves_a_hollow_falls_on_itself_by_its_view_factor(shape):
    """The inside of a hollow with one mouth sees itself but for its mouth, F = 1 − A_mouth/A; the outside sees none of it."""
    mouths = {tp.Cone: math.pi * 0.49, tp.Paraboloid: math.pi * 0.36, tp.Sphere: math.pi * 0.96}
    x = 2 + (2 / 0.7) ** 2
    # of a tube's ends, but for what passes both
    seen = math.pi * 0.49 * 2 * (1 - (x - math.sqrt(x * x - 4)) / 2)
    mouth = mouths.get(type(shape), seen)
    for side, share in (("back", 1 - mouth / shape.area), ("front", 0.0)):
        lamp = tp.Source(shape, tp.Lambertian(exitance=1.0), side=side)
        result = run(tp.Scene(lamp, (), tp.Detector(shape, "own", side=side)))
        np.testing.assert_allclose(result["own"].exitance.value, 1.0, rtol=1e-12)
        if share:
            assert_agrees(result["own"].irradiance, share, FALSE_ALARM)
        else:
            assert result["own"].irradiance.value == 0


def test_a_slab_keeps_what_its_planes_absorb():
    """A point between two black planes; a beam along them would never meet them."""
    slab = tp.Slab(thickness=2.0, normal=(0, 0.6, 0.8))
    lamp = tp.Source(tp.Point(position=(7, 0.3, 0.4)), tp.Isotropic(power=1.0))
    patch = tp.Disk(center=(7, 0.6, 0.8), normal=(0, 0.6, 0.8), radius=1.0)
    looks = [tp.Detector("wall", side="inside"), tp.Detector(patch, name="patch", side="back")]
    result = run(tp.Scene(lamp, tp.Surface(slab, tp.Black(), name="wall"), looks))
    np.testing.assert_allclose(result["wall"].flux_in.value, 1.0, rtol=1e-9)
    half_angle = math.atan(1 / 0.5)
    assert_agrees(result["patch"].flux_in, (1 - math.cos(half_angle)) / 2, FALSE_ALARM)
    with pytest.raises(tp.SceneError, match="Slab"):
        print(result["wall"].irradiance)


def test_light_passes_a_hole_and_no_more():
    """A lamp above a plate: through the hole falls what would fall on a disk there."""
    hole = tp.Disk(center=(0.3, -0.1, 0), radius=0.25)
    plate = tp.Rectangle(width=2, height=1.5, up=(1, 2, 0), hole=hole)
    lamp = tp.Source(tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.5), tp.Lambertian(radiance=1.0))
    looks = [tp.Detector(hole, name="hole"), tp.Detector(tp.Plane(center=(0, 0, -1)), name="below")]
    result = run(tp.Scene(lamp, tp.Surface(plate, tp.Black(), name="plate"), [*looks, tp.Detector("plate")]))
    bare = run(
        tp.Scene(lamp, (), [looks[0], tp.Detector(dataclasses.replace(plate, hole=None), name="plate")])
    )
    np.testing.assert_array_equal(counted(result["hole"]), counted(bare["hole"]))
    np.testing.assert_array_equal(
        counted(result["plate"])[0, 1] + counted(result["hole"])[0, 1], counted(bare["plate"])[0, 1]
    )
    assert counted(result["below"])[0, 1].sum() >= counted(result["hole"])[0, 1].sum() > 1000


def test_two_acting_surfaces_over_one_point_are_refused():
    floor = tp.Surface(tp.Rectangle(width=2.0, height=2.0), tp.Black(), name="floor")
    for shape in (
        tp.Disk(center=(0.9, 0, 0), radius=0.5),
        tp.Rectangle(center=(1.5, 0, 0), width=1.1, height=1.0),
    ):
        with pytest.raises(tp.SceneError, match="'floor' and Surface 'rug' overlap"):
            tp.Scene(
                sources=[tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0))],
                surfaces=[floor, tp.Surface(shape, tp.Diffuse(0.5), name="rug")],
            )
    rug = tp.Surface(tp.Rectangle(center=(1.5, 0, 0), width=1.0, height=1.0), tp.Diffuse(0.5), name="rug")
    tp.Scene(
        sources=[tp.Source("rug", tp.Lambertian(power=1.0))], surfaces=[floor, rug]
    )  # they share an edge


def test_light_shut_in_without_loss_is_refused():
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    for shape in (tp.Sphere(radius=1.0), tp.Box(size=2.0)):
        wall = tp.Surface(shape, tp.Mirror(), name="wall")
        with pytest.raises(tp.SceneError, match="nothing absorbs inside Surface 'wall'"):
            tp.Scene(sources=[lamp], surfaces=[wall])
        tp.Scene(sources=[lamp], surfaces=[wall], duration=1.0)
        tp.Scene(sources=[tp.Source(tp.Point(position=(3, 0, 0)), tp.Isotropic(power=1.0))], surfaces=[wall])


def test_a_corner_of_three_mirrors_sends_light_back():
    """A beam into the very corner, edge and face of a mirror corner: retroreflected, never lost between two walls."""
    walls = [
        tp.Surface(tp.Rectangle(center=c, normal=n, width=1.0, height=1.0), tp.Mirror(), name=str(n))
        for c, n in (((0.5, 0.5, 0), (0, 0, 1)), ((0.5, 0, 0.5), (0, 1, 0)), ((0, 0.5, 0.5), (1, 0, 0)))
    ]
    back = tp.Disk(center=(0.5, 0.5, 0.5), normal=(1, 1, 1), radius=2.0)
    for target in ((0, 0, 0), (0.3, 0, 0), (0, 0.2, 0.1), (1 / 3, 1 / 3, 0)):
        start = tuple(t + s for t, s in zip(target, (0.5, 0.4, 0.45), strict=True))
        direction = tuple(t - s for t, s in zip(target, start, strict=True))
        beam = tp.Source(tp.Point(position=start), tp.Beam(direction, power=1.0))
        result = run(
            tp.Scene(sources=[beam], surfaces=walls, detectors=[tp.Detector(back, name="back", side="back")]),
            64,
        )
        assert result.ledger["lost"].value == 0
        np.testing.assert_allclose(result["back"].flux_in.value, 1.0, rtol=1e-12)


def test_closed_boxes_of_any_proportion_keep_everything():
    """Thin, tiny, huge and far from the origin: nothing escapes through an edge."""
    for size, center in (
        ((1, 1, 1e-6), (0, 0, 0)),
        ((1e-9, 2e-9, 3e-9), (0, 0, 0)),
        ((3, 2, 1), (1e6, -2e6, 7e5)),
    ):
        box = tp.Box(size=size, center=center)
        walls = [tp.Surface(face, tp.Diffuse(0.9), name=name) for name, face in box.faces().items()]
        scene = tp.Scene(sources=[tp.Source("-x", tp.Lambertian(power=1.0), side="back")], surfaces=walls)
        result = run(scene, 50_000)
        assert result.ledger["escaped"].value == 0
        assert result.ledger["lost"].value == 0
        assert math.isclose(
            result.ledger["absorbed"].value + result.ledger["roulette"].value, 1.0, rel_tol=1e-12
        )
