"""Scenes that together call for every pass, each by the estimator that it is run with."""

from dataclasses import replace

from tests import backward_scenes, expected_scenes, media_scenes
from transport.compile.methods import Method
from transport.geometry.flat import Disk, Plane, Rectangle, Triangle
from transport.geometry.mesh import Mesh  # fmt: skip
from transport.geometry.polygon import Polygon
from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.shape import Cloud, Point
from transport.geometry.solid import Box, Sphere
from transport.scene.bins import Directions, Positions
from transport.scene.cameras import Camera, EnvironmentMap, LightField
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Effusive, Gas, Isotropic, Lambertian
from transport.scene.materials import (  # fmt: skip
    Black,
    Conductor,
    Dielectric,
    Diffuse,
    Glossy,
    Mirror,
    Mixture,
    Surface,
    ThinLens,
    TwoSided,
)
from transport.scene.media import Medium
from transport.scene.phase_space import PhaseSpace, Snapshot
from transport.scene.points import PointDetector
from transport.scene.pulses import BoxPulse, GaussianPulse, Instant
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.scene.speeds import Maxwellian, SpeedTable

LIGHT, GLOW = Lambertian(power=1.0), Isotropic(power=1.0)
SMALL = Scene(  # a lamp and a detector that faces it
    Source(Disk(radius=0.5), LIGHT),
    (),
    Detector(Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=0.5), "meter"),
)


def room():
    """Diffuse, mirror and black walls round a mirror ball and a black disk; meters with every kind of bins."""
    kinds = dict(
        zip(
            ("-x", "+x", "-y", "+y", "-z", "+z"),
            [Diffuse(0.5), Mirror(0.8), Mirror(), Diffuse(0.9), Black(), Diffuse(0.3)],
            strict=True,
        )
    )
    walls = [Surface(face, kinds[name], name) for name, face in Box(size=(2.0, 2.2, 2.4)).faces().items()]
    ball = Surface(Sphere(center=(0.3, 0.2, -0.4), radius=0.3), Mirror(), "ball")
    lump = Surface(Sphere(center=(-0.5, -0.3, 0.2), radius=0.2), Diffuse(0.6), "lump")
    plate = Surface(Disk(center=(-0.2, 0.5, 0.1), normal=(0.3, 1, 0.2), radius=0.25), Black(), "plate")
    meters = [
        Detector("-z", side="back", directions=Directions(mu=4, phi=3), positions=Positions(u=3, v=2)),
        Detector("-x", side="back", directions=Directions(mu=(0.0, 0.2, 0.7, 1.0))),
        Detector("+x", side="back", directions=Directions(mu=3, phi=4, frame="world")),
        Detector("+y", side="back", directions=Directions.cone((0.2, -1, 0.1), 0.6)),
        Detector("ball", directions=Directions(phi=5), positions=Positions(u=2, v=3)),
        Detector("lump", directions=Directions(mu=5)),
        Detector("plate", directions=Directions(theta=(0.0, 0.5, 1.2)), positions=Positions(u=2, v=2)),
        Detector(
            Rectangle(width=0.8, height=0.6, center=(0.1, 0, 0.3)),
            "pane",
            positions=Positions(v=(-0.3, 0.1, 0.3)),
        ),
    ]
    sources = [Source("+z", LIGHT, side="back"), Source("lump", LIGHT), Source("plate", LIGHT)]
    return Scene(sources, [*walls, ball, lump, plate], meters)


def furnace():
    """One material and one meter a wall, all alike."""
    walls = [Surface(face, Diffuse(0.7), name) for name, face in Box(size=1.0).faces().items()]
    return Scene(
        [Source(Point(), GLOW)],
        walls,
        [Detector(w.name, side="back", directions=Directions(mu=4)) for w in walls],
    )


def gas():
    """Particles against a clock, meters only; some are still flying at its end."""
    meters = [
        Detector(
            Rectangle(width=0.8, height=0.5, normal=(1, 0, 0)), "pane", directions=Directions(mu=4, phi=2)
        ),
        Detector(Disk(radius=0.4, center=(0, 0, 0.2)), "disk", positions=Positions(u=(0.0, 0.2, 0.3), v=3)),
        Detector(Sphere(radius=0.3, center=(0.1, 0, 0)), "ball", positions=Positions(u=3)),
    ]
    still, wind = Box(size=1.0), Box(size=1.0, center=(0.5, 0, 0))
    return Scene(
        [Source(still, Gas(100.0, 1.0)), Source(wind, Gas(50.0, 2.0, (-1, 0.1, 0)))], [], meters, duration=0.4
    )


def flash():
    """Steady emitters against a clock, within a black box."""
    speed = {"power": 1.0, "speed": 1.0}
    walls = [Surface(face, Black(), name) for name, face in Box(size=2.0).faces().items()]
    sources = [
        Source(Disk(radius=0.3), Lambertian(**speed)),
        Source(Point(position=(0, 0, 0.5)), Isotropic(**speed)),
    ]
    return Scene(sources, walls, [Detector("+z", side="back")], duration=2.0)


def vessel():
    """Gases of many speeds in a box of thermal and mixed walls; meters by time and speed, phase space, a sample."""
    hot = Maxwellian(sigma=1.5, mass=2.0)
    kinds = [Diffuse(1.0, speed=hot), Mirror(), Diffuse(1.0, speed=0.8), Black(), Diffuse(0.6)]
    kinds.append(Mixture({Mirror(): 0.25, Diffuse(0.9, speed=hot): 0.5, Black(): 0.25}))
    walls = [
        Surface(face, kind, name)
        for kind, (name, face) in zip(kinds, Box(size=2.0).faces().items(), strict=True)
    ]
    wind = Maxwellian(sigma=0.5, mass=2.0, drift=(0.3, 0.2, -0.1))
    sources = [
        Source(Cloud(sigma=(0.1, 0.2, 0.3)), Gas(50.0, wind)),
        Source(Box(size=1.0), Gas(50.0, Maxwellian(sigma=1.0, mass=2.0), direction=(1, 1, 0))),
        Source("-z", Effusive(20.0, wind), side="back"),
        Source(Sphere(radius=0.2), Gas(20.0, SpeedTable((0.5, 1.0, 1.0 + 1e-9, 2.0), (1.0, 0.5, 2.0, 0.0)))),
        Source("-x", Effusive(20.0, hot), side="back", pulse=BoxPulse(0.1, 0.5)),
    ]
    looks = [
        Detector("-x", side="back", times=3, moments=True, directions=Directions(mu=2)),
        Detector("+z", side="back", speeds=(0, 0.5, 1, 9), times=(0.2, 0.7), moments=True),
        Detector(Disk(radius=0.5), "pane", via="-x", events=(1, 3), positions=Positions(u=2)),
        Detector(Disk(radius=0.5, center=(0, 0, 0.5)), "other", via=("pane", "+y")),
        PhaseSpace(x=(-1, 0, 1), vx=(-2, 0, 2), time=(0.0, 0.5, 1.0), moments=True),
        PhaseSpace(mu=3, time=0.3, name="cosines", within=Box(size=1.5)),
        Snapshot(0.6, particles=40),
    ]
    return Scene(sources, walls, looks, duration=1.0)


def burst():
    """Pulses of light that all fly alike, seen by triangles, which are also aimed at."""
    triangle = Triangle(vertices=((1, 0, 0.2), (0, 1, 0.2), (-0.5, -0.5, 0.3)))
    glow = Isotropic(energy=1.0, speed=1.0)
    sources = [
        Source(Point(), glow, pulse=Instant(0.1)),
        Source(Point(position=(0, 0, 1)), glow, pulse=GaussianPulse(0.5, 0.05), aim=triangle),
        Source(Box(size=0.4), glow, aim=triangle),
        Source(Disk(center=(0, 0, -1), radius=0.5), Lambertian(energy=1.0, speed=1.0)),
    ]
    tile = Triangle(vertices=((0, 0, -1), (0.6, 0, -1), (0, 0.6, -1)))
    meters = [Detector(triangle, "triangle", times=4), Detector(tile, "tile")]
    return Scene(sources, [], meters, duration=1.5)


def glow():
    """Light in a steady scene of mirrors: its pressure, which needs a speed but no clock."""
    walls = [Surface(face, Mirror(0.5), name) for name, face in Box(size=2.0).faces().items()]
    return Scene([Source(Point(), GLOW)], walls, [Detector("+x", side="back", moments=True)])


def beams():
    """Parallel rays from all shapes on meters."""
    down = Beam((0.1, 0.2, -1), power=1.0)
    shapes = [
        Point(),
        Sphere(radius=0.3),
        Box(size=0.5),
        Disk(radius=0.2, normal=(0, 0, -1)),
        Rectangle(width=0.3, height=0.2, normal=(0.1, 0, -1)),
    ]
    return Scene(
        [Source(shape, down) for shape in shapes],
        [],
        [Detector(Disk(center=(0, 0, -1), radius=0.5), "meter", directions=Directions(mu=3))],
    )


def aims():
    """Every kind of source towards every kind of target, near and far; sources that are metered themselves."""
    targets = [
        Disk(center=(0, 0, 1), radius=0.5, normal=(0, 0.2, -1)),
        Rectangle(center=(0, 0.3, 3), width=1.0, height=0.5),
        Sphere(center=(0.2, 0, 1.5), radius=0.4),
        Box(center=(0, 0.4, 2), size=(0.5, 0.6, 0.7)),
    ]
    floor, tile, globe = (
        Disk(radius=0.4),
        Rectangle(center=(0.8, 0, 0), width=0.5, height=0.4),
        Sphere(center=(-1, 0, 0), radius=0.3),
    )
    places = [
        (floor, LIGHT),
        (tile, LIGHT),
        (globe, LIGHT),
        (Box(center=(0, -1, 0), size=0.4), LIGHT),
        (Point(position=(0, 0, -0.5)), GLOW),
    ]
    places += [(Sphere(center=(0, 0, -1), radius=0.2), GLOW), (Box(center=(0, 1, -1), size=0.3), GLOW)]
    sources = [Source(place, emission, targets[k % 4]) for k, (place, emission) in enumerate(places * 2)]
    meters = [Detector(shape, f"meter {k}") for k, shape in enumerate([*targets, floor, tile, globe])]
    return Scene([*sources, Source(floor, LIGHT)], [], meters)


def turned_shapes():
    """Surfaces of revolution in a can: acting, metered, emitting, aimed at."""
    can, lid = Cylinder(radius=2.0, height=4.0), Disk(center=(0, 0, 2), radius=2.0)
    floor = Disk(center=(0, 0, -2), radius=2.0, inner_radius=0.2, normal=(0, 0, -1))
    cone = Cone(center=(0.8, 0, 0), axis=(0.2, 0.1, 1), radius=0.6, top_radius=0.2, height=1.0)
    dish = Paraboloid(center=(-0.8, 0, 0), focal_length=0.4, radius=0.7, inner_radius=0.1)
    cap = Sphere(center=(0, -0.9, 0), radius=0.5, axis=(0, 1, 1), mu_min=-0.5, mu_max=0.7)
    pane = Cylinder(center=(0, 0.9, 0), radius=0.3, height=0.8, axis=(1, 0, 0))
    walls = [Surface(shape, Diffuse(0.8)) for shape in (lid, floor)]
    walls += [
        Surface(can, Diffuse(0.7), "can"),
        Surface(cone, Mirror(0.9), "cone"),
        Surface(dish, Mirror(), "dish"),
    ]
    walls.append(Surface(cap, Diffuse(0.6), "cap"))
    meters = [
        Detector("can", side="back", directions=Directions(mu=3, phi=4), positions=Positions(u=3, v=2)),
        Detector("cone", directions=Directions(mu=3)),
        Detector("dish", side="back", positions=Positions(v=3)),
        Detector("cap", positions=Positions(u=2, v=3)),
        Detector(pane, "pane", positions=Positions(u=3)),
        Detector(Sphere(center=(0, -0.9, 0), radius=0.5, axis=(0, 1, 1), mu_max=0.2), "part of the cap"),
    ]
    sources = [Source("cone", LIGHT, aim=pane), Source("dish", LIGHT, side="back"), Source("cap", LIGHT)]
    return Scene([*sources, Source(pane, LIGHT), Source(Disk(radius=0.1), LIGHT, aim=dish)], walls, meters)


def flat_shapes():
    """Planes without end, rectangles with holes, triangles: acting, metered, emitting."""
    floor = Plane(center=(0, 0, -1))
    hole = Rectangle(center=(0.1, 0, 0.5), width=0.4, height=0.3, up=(1, 2, 0))
    screen = Rectangle(center=(0, 0, 0.5), width=1.5, height=1.2, hole=hole)
    window = Rectangle(center=(0, 0, 0.8), width=1.0, height=1.0, hole=Disk(center=(0, 0, 0.8), radius=0.3))
    roof = Triangle(vertices=((1, 0, 1), (0, 1, 1.1), (-0.5, -0.5, 1.2)))
    walls = [Surface(floor, Diffuse(0.5), "floor"), Surface(screen, Diffuse(0.9), "screen")]
    walls.append(Surface(roof, Mirror(0.8), "roof"))
    meters = [
        Detector("floor", directions=Directions(mu=3)),
        Detector("screen", directions=Directions(phi=3)),
    ]
    turned = Rectangle(center=(0.1, 0, 0.2), width=0.6, height=0.5, up=(1, 2, 0))
    meters += [Detector(window, "window"), Detector("roof", side="back"), Detector(Plane(), "plane")]
    meters.append(Detector(turned, "turned"))
    pairs = {"x": (1, 0, 0), "y": (0, 1, 0), "tilted": (1, 2, 2)}
    meters += [
        Detector(Plane(center=tuple(0.1 * place * n for n in normal), normal=normal), f"{name} {place}")
        for name, normal in pairs.items()
        for place in (-1, 2)
    ]
    sources = [
        Source("roof", LIGHT, side="back"),
        Source("screen", LIGHT),
        Source(window, LIGHT, side="back"),
    ]
    tile = Rectangle(center=(0, 0, 0.5), width=0.2, height=0.2, hole=Disk(center=(0, 0, 0.5), radius=0.05))
    return Scene([*sources, Source(Disk(radius=0.1), LIGHT)], walls, [*meters, Detector(tile, "tile")])


def furnished():
    """Boxes on all kinds of flat surfaces, of which one glows."""
    grounds = [
        Plane(center=(0, 0, -1)),
        Rectangle(center=(-2, 0, 0.1), width=1.5, height=1.5),
        Rectangle(center=(2, 0, 0.2), width=1.5, height=1.5, hole=Disk(center=(2.3, 0.3, 0.2), radius=0.2)),
        Disk(center=(0, 2, 0.3), radius=0.8),
        Triangle(vertices=((-1, -3, 0.4), (1, -3, 0.4), (0, -1, 0.4))),
    ]
    boxes = [(0, 0, -1), (-2, 0, 0.1), (2, 0, 0.2), (0, 2, 0.3), (0, -2, 0.4)]
    walls = [Surface(each, Diffuse(0.6), f"ground {k}") for k, each in enumerate(grounds)]
    walls += [
        Surface(Box(center=(x, y, z + 0.25), size=0.5), Diffuse(0.4), f"box {k}")
        for k, (x, y, z) in enumerate(boxes)
    ]
    sources = [
        Source("ground 1", LIGHT), Source("box 4", LIGHT), Source("ground 3", LIGHT, aim=Sphere(center=(0, 2, 2), radius=0.5)),
        Source(Disk(center=(0, 0, 3), normal=(0, 0, -1), radius=0.5), LIGHT),
    ]  # fmt: skip
    meters = [Detector(f"ground {k}") for k in range(5)] + [Detector("box 2", side="back")]
    return Scene(sources, walls, meters)


def optics():
    """Every material that bends, splits or scatters light."""
    kinds = [
        Dielectric(1.5), Glossy(0.3, 0.8), Diffuse(0.3, 0.5), Mirror(0.4, 0.5),
        TwoSided(Diffuse(0.5, 0.2), Glossy(0.6)), Mixture({Dielectric(1.3): 0.5, Glossy(0.2): 0.3, Black(): 0.2}),
    ]  # fmt: skip
    balls = [
        Surface(Sphere(center=(k - 2.5, 0, 0), radius=0.4), kind, f"ball {k}") for k, kind in enumerate(kinds)
    ]
    lens = Surface(Disk(center=(0, 0, 1), radius=1.0), ThinLens(0.8), "lens")
    walls = Surface(Box(size=8.0), Diffuse(0.5), "walls")
    meters = [Detector(ball.name, directions=Directions(mu=3)) for ball in balls]
    return Scene(
        [
            Source("walls", LIGHT, side="back"),
            Source(Disk(center=(0, 0, 2), radius=1), LIGHT, aim=balls[0].shape),
        ],
        [*balls, lens, walls],
        [*meters, Detector("lens", side="back", events=1), Detector("walls", side="back")],
    )


def meshed():
    """Meshes: acting, metered, emitting."""
    room, ball = Mesh.box(size=2.0), Mesh.sphere(radius=0.4, triangles=20)
    veil = Mesh.sphere(radius=0.8, triangles=80)
    surfaces = [Surface(room, Diffuse(0.6), "room"), Surface(ball, Dielectric(1.5), "ball")]
    meters = [Detector("room", side="back", directions=Directions(mu=3, phi=2)), Detector(veil, "veil")]
    meters += [
        Detector("ball"),
        Detector(Disk(radius=0.3, center=(0, 0, 0.6)), "pane"),
        Detector(veil, "again"),
    ]
    return Scene([Source("room", LIGHT, side="back"), Source(veil, LIGHT)], surfaces, meters)


def view():
    """A camera, a map of all directions and a point, which begin backwards; bins of places and a cone."""
    walls = Surface(Box(size=2.0), Diffuse(0.6), "walls")
    cone = Directions.cone(axis=(0.2, 0, 1), half_angle=0.3)
    meters = [
        Detector(Disk(radius=0.2, center=(0, 0, -0.5)), "cone", directions=cone),
        Detector(Rectangle(width=0.4, height=0.2, center=(0.3, 0, -0.4)), "patch", positions=Positions(u=2)),
        Detector(Disk(radius=0.2, center=(0, 0.5, 0)), "ring", positions=Positions(u=2, v=2)),
        Detector(Sphere(radius=0.2, center=(-0.5, 0, 0)), "ball", positions=Positions(u=2, v=2)),
        Detector(Sphere(radius=0.1, center=(-0.5, 0.5, 0)), "bead", directions=cone),
        PointDetector(position=(0.4, 0.4, 0.0), name="point"),
        Camera(name="camera", position=(0, -0.8, 0), look_at=(0, 1, 0), pixels=(4, 3)),
        EnvironmentMap(name="map", position=(0.1, 0, 0.2), theta=3, phi=4),
    ]
    lamps = [
        Source(Disk(radius=0.3, center=(0, 0, 0.9)), LIGHT, side="back"),
        Source(Sphere(radius=0.1, center=(0.6, -0.6, 0)), GLOW),
    ]
    return Scene(lamps, walls, meters)


def lit_by_rays():
    """A Point, and Beams from a disk, a rectangle and a triangle, in mist: only rays of backward runs find them."""
    walls = Surface(Box(size=2.0), Diffuse(0.6), "walls")
    mist = Medium(absorption=0.1, scattering=0.4)
    shapes = [
        Disk(radius=0.3, center=(0, 0, 0.9), normal=(0, 0, -1)),
        Rectangle(width=0.4, height=0.2, center=(0.5, 0, 0.8), normal=(0, 0, -1)),
        Triangle(vertices=((-0.9, 0, 0.8), (-0.6, 0.4, 0.8), (-0.5, 0, 0.8))),
    ]
    lamps = [Source(shape, Beam((0.1, 0.2, -1), power=1.0)) for shape in shapes]
    lamps += [Source(Point(position=(0.1, 0.2, 0.3)), Isotropic(power=1.0))]
    lamps += [Source(Disk(radius=0.1, center=(0, 0, -0.9)), LIGHT)]
    detectors = [
        Detector(Disk(radius=0.2, center=(0, 0, -0.5)), "disk"),
        Camera(name="camera", position=(0, -0.8, 0), look_at=(0, 1, 0), pixels=(4, 3)),
    ]
    return Scene(lamps, walls, detectors, medium=mist)


def lit_through_glass():
    """A ball of glass and a mirror ball in a room, seen by a camera and a map: histories from the lamps reach these."""
    surfaces = [
        Surface(Box(size=2.0), Diffuse(0.6), "walls"),
        Surface(Sphere(center=(0.4, 0.3, -0.3), radius=0.3), Dielectric(1.5), "glass"),
        Surface(Sphere(center=(-0.4, 0.3, -0.3), radius=0.3), Mirror(0.9), "mirror"),
    ]
    lamps = [
        Source(Disk(radius=0.3, center=(0, 0, 0.9)), LIGHT, side="back"),
        Source(Sphere(radius=0.1, center=(0.6, -0.6, 0.5)), LIGHT),
    ]
    views = [
        Camera(name="camera", position=(0, -0.8, 0), look_at=(0, 1, 0), pixels=(4, 3)),
        EnvironmentMap(name="map", position=(0.1, -0.4, 0.2), theta=3, phi=4),
        Detector(Disk(radius=0.2, center=(0, -0.5, -0.5)), "patch"),
    ]
    return Scene(lamps, surfaces, views)


def instruments():
    """Cameras of all lenses, maps of all projections and a light field, in a room with a ball of glass and one of metal."""
    surfaces = [
        Surface(Box(size=2.0), Diffuse(0.6), "walls"),
        Surface(Sphere(center=(0.4, 0.3, -0.3), radius=0.3), Dielectric(1.5), "glass"),
    ]
    lamp = Source(Disk(radius=0.3, center=(0, 0, 0.9)), LIGHT, side="back")
    ahead = {"position": (0, -0.8, 0), "look_at": (0, 1, 0)}
    lens = {"aperture": 0.1, "focal_length": 0.2, "focus": 0.9}
    views = [
        Camera(name="fisheye", lens="fisheye", pixels=(4, 3), **ahead),
        Camera(name="equal area", lens="equal-area fisheye", pixels=(4, 3), **ahead),
        Camera(name="parallel", lens="orthographic", width=0.5, pixels=(4, 3), **ahead),
        Camera(name="photo", lens="thin lens", pixels=(4, 3), **lens, **ahead),
        LightField(
            name="field", distance=0.9, size=(0.1, 0.1), far_size=(1, 1), views=(2, 2), pixels=(3, 2), **ahead
        ),
    ]
    views += [
        EnvironmentMap(name=projection, position=(0.1, -0.4, 0.2), projection=projection, pixels=3)
        for projection in ("cube", "fisheye", "equal-area fisheye", "mirrored ball")
    ]
    views += [
        EnvironmentMap(name="cylinder", position=(0.1, -0.4, 0.2), projection="cylinder", theta=3, phi=4)
    ]
    return Scene([lamp], surfaces, [replace(view, name=f"view {k}") for k, view in enumerate(views)])


def plate():
    """A polygon, which events tell what they send there, and a ball of metal."""
    corners = ((0, 0, 1), (1, 0, 1), (1, 0.5, 1), (0.5, 0.5, 1), (0.5, 1, 1), (0, 1, 1))
    ball = Surface(Sphere(center=(0, 0, -1), radius=0.4), Conductor(0.2, 3.4), "ball")
    walls = Surface(Box(size=6.0), Diffuse(0.5), "walls")
    lamp = Source(Disk(center=(-1, 0, -2), radius=0.2), LIGHT)
    return Scene([lamp], [ball, walls], [Detector(Polygon(vertices=corners), "plate", side="back")])


SCENES = {
    scene.__name__: scene
    for scene in (
        room, furnace, gas, flash, vessel, burst, glow, beams, aims, turned_shapes, flat_shapes, furnished, optics,
        meshed,
    )
} | media_scenes.MEDIA  # fmt: skip
TOLD = {
    f"expected {name}": expected_scenes.SCENES[name]
    for name in ("room", "balls", "half_mirrors", "fog", "disks")
} | {"expected plate": plate}
BACK = {f"backward {name}": scene for name, scene in backward_scenes.SCENES.items()}
BACK |= {"backward view": view, "backward lit by rays": lit_by_rays}
BACK |= {"backward lit through glass": lit_through_glass, "backward instruments": instruments}
METHODS = dict.fromkeys(TOLD, Method("expected")) | dict.fromkeys(
    BACK, Method("backward")
)  # of those that are not analog
SCENES |= TOLD | BACK
