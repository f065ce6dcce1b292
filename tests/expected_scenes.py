"""Scenes in which events tell detectors what they send there: every kind of event, of detector and of what lies between."""

import numpy as np

import transport as tp

FOG = tp.Medium(absorption=0.3, scattering=1.5, phase=tp.HenyeyGreenstein(0.6))
WALLS = tp.Surface(tp.Box(size=2.0), tp.Diffuse(0.7), "room")


def lamp(z=-0.9, radius=0.2):
    return tp.Source(tp.Disk(center=(0.3, -0.2, z), radius=radius), tp.Lambertian(radiance=1.0))


def pane(name, z, **looks):
    """A meter that looks down."""
    return tp.Detector(tp.Disk(center=(0, 0.3, z), normal=(0, 0, -1), radius=0.3), name, **looks)


def tilted(name="tilted", **looks):
    return tp.Detector(tp.Disk(center=(0, 0.4, 0.5), normal=(0, 0.6, -0.8), radius=0.2), name, **looks)


def ball(name, center, radius, **looks):
    return tp.Detector(tp.Sphere(center=center, radius=radius), name, **looks)


def room():
    """Diffuse walls; bins of direction; a meter close to a wall, and a patch on one."""
    near = tp.Detector(tp.Disk(center=(0, 0.4, 0.99), radius=0.2), "near")
    corner = tp.Rectangle(center=(0.7, 0.7, -1.0), width=0.5, height=0.5)
    patch = tp.Detector(corner, "patch", positions=tp.Positions(u=2, v=2))
    return tp.Scene(lamp(0.0), WALLS, [tilted(directions=tp.Directions(mu=3, phi=2)), near, patch])


def disks():
    """Two disks: all that arrives is told."""
    return tp.Scene(lamp(0.0), (), [pane("above", 0.5), pane("higher", 0.9)])


def balls():
    """Balls far and near, and one about the lamp."""
    about = ball("about", (0.3, -0.2, 0.1), 0.5, side="back")
    return tp.Scene(lamp(0.0), WALLS, [ball("far", (0.3, 0.1, 0.5), 0.3), about])


def hollow():
    """A named ball that is its own detector."""
    walls = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.7), "ball")
    return tp.Scene(lamp(0.0), walls, tp.Detector("ball", side="inside"))


def half_mirrors():
    """Half of what walls reflect no ray can tell of."""
    walls = tp.Surface(tp.Box(size=2.0), tp.Mixture({tp.Diffuse(0.8): 0.5, tp.Mirror(0.9): 0.5}), "room")
    corners = (0, 0, 0.5), (0.4, 0, 0.5), (0, 0.4, 0.8)
    triangle = tp.Detector(tp.Triangle(vertices=corners), "triangle", directions=tp.Directions(mu=2))
    return tp.Scene(lamp(0.0), walls, [triangle, tilted()])


def pasts():
    """Meters that ask where light has been."""
    return tp.Scene(
        lamp(0.0),
        WALLS,
        [pane("low", 0.2, events=(1, 2)), pane("high", 0.5, via="low"), pane("direct", 0.7, events=0)],
    )


def fog():
    """All in fog that scatters forwards."""
    return tp.Scene(
        lamp(0.0),
        (),
        [tilted(directions=tp.Directions(mu=3)), ball("drop", (0.3, 0.1, 0.5), 0.1)],
        medium=FOG,
    )


def cloud():
    """A ball of fog in a room, with a meter in it and one behind it."""
    body = tp.Surface(tp.Sphere(radius=0.5), tp.Transparent(), "fog", inside=FOG)
    return tp.Scene(lamp(), [WALLS, body], [pane("behind", 0.8), pane("within", 0.1)])


def glass():
    """What passes glass no ray can tell of."""
    body = tp.Surface(tp.Sphere(radius=0.5), tp.Dielectric(1.5), "glass")
    return tp.Scene(lamp(), [WALLS, body], pane("behind", 0.8))


def beam():
    """A beam, and what it lights."""
    source = tp.Source(tp.Disk(radius=0.1), tp.Beam(direction=(0.1, 0.2, 1), power=1.0))
    hit = tp.Detector(tp.Disk(center=(0.05, 0.1, 0.5), normal=(0, 0, -1), radius=0.08), "hit")
    return tp.Scene(source, WALLS, [tilted(), hit])


def glow():
    """A box and a point that shine into all directions, about and beside detectors."""
    box = tp.Source(tp.Box(center=(0, 0, 0.2), size=0.5), tp.Isotropic(power=1.0))
    point = tp.Source(tp.Point(position=(0.1, 0.2, 0.3)), tp.Isotropic(power=1.0))
    return tp.Scene(
        [box, point],
        WALLS,
        [tilted(), ball("core", (0, 0, 0), 0.2), ball("about", (0, 0, 0), 0.8, side="back")],
    )


def voxels():
    """Voxels of fog, with a meter in them and one behind them."""
    grid = tp.Grid(
        box=tp.Box(size=1.0),
        absorption=0.2,
        scattering=np.linspace(0, 4, 27).reshape(3, 3, 3),
        phase=tp.HenyeyGreenstein(0.5),
    )
    body = tp.Surface(tp.Box(size=1.0), tp.Transparent(), "fog", inside=grid)
    return tp.Scene(lamp(), body, [pane("behind", 0.8), pane("within", 0.1)])


def facing():
    """Two walls, one of which shines, both metered."""
    low = tp.Surface(tp.Rectangle(width=1, height=1), tp.Diffuse(0.5), "low")
    high = tp.Surface(
        tp.Rectangle(center=(0, 0, 0.5), normal=(0, 0, -1), width=1, height=1), tp.Diffuse(0.9), "high"
    )
    return tp.Scene(
        tp.Source("low", tp.Lambertian(radiance=1.0)), [low, high], [tp.Detector("low"), tp.Detector("high")]
    )


def backlit():
    """Thin walls, metered in front and lit from behind, by a lamp and by what it lights."""
    slanted = tp.Rectangle(center=(0, 0.2, 0.3), normal=(0.2, 0, 1), width=0.8, height=0.6)
    screen = tp.Surface(slanted, tp.Diffuse(0.6), "screen")
    black = tp.Surface(tp.Disk(center=(-0.5, 0, 0), normal=(-1, 0, 0), radius=0.3), tp.Black(), "black")
    looks = [tp.Detector("screen"), tp.Detector("black"), pane("above", 0.8)]
    return tp.Scene(lamp(), [WALLS, screen, black], looks)


def shadow():
    """A mesh and a pane that lets a share through, diffusely, before the meter; haze with a mixture of phase functions."""
    corners, faces = (
        [(0, 0, 0.1), (0.5, 0, -0.4), (-0.4, 0.4, -0.4), (-0.3, -0.4, -0.4)],
        [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)],
    )
    rock = tp.Surface(tp.Mesh(vertices=corners, faces=faces), tp.Diffuse(0.5), "rock")
    screen = tp.Surface(tp.Disk(center=(0, 0, 0.4), radius=0.9), tp.Diffuse(0.4, transmission=0.5), "screen")
    phase = tp.Mixture({tp.Rayleigh(): 0.5, tp.Isotropic(): 0.5})
    return tp.Scene(
        lamp(),
        [WALLS, rock, screen],
        pane("behind", 0.8),
        medium=tp.Medium(absorption=0.2, scattering=0.5, phase=phase),
    )


def aimed():
    """Births towards an aim count as they come, what walls send of them is told."""
    source = tp.Source(
        tp.Disk(radius=0.2), tp.Lambertian(power=1.0), aim=tp.Sphere(center=(0.1, 0, 0.5), radius=0.2)
    )
    return tp.Scene([source, lamp()], WALLS, [pane("meter", 0.5), pane("high", 0.8)])


SCENES = {
    scene.__name__: scene
    for scene in (aimed, disks, room, balls, hollow, half_mirrors, pasts, fog, cloud, glass, beam, glow, voxels, facing, backlit, shadow)
}  # fmt: skip
