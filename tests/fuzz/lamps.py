"""Random sources: glowing surfaces and shapes, points, beams, volumes, gases; some of them aim, some flash."""

from __future__ import annotations

from hypothesis import strategies as st

import transport as tp
from tests.fuzz import contacts, shapes
from transport.scene.materials import Surface
from transport.vectors import Vector

LAMP = 0.3  # m, half the size of a lamp of its own
WARM = tp.Maxwellian(temperature=300.0, mass=4.65e-26)


@st.composite
def lamps(
    draw,
    surfaces: list[Surface],
    cell: Vector,
    middle: Vector,
    light: bool,
    duration: float | None,
    is_broad: bool = False,
):
    """A source on one of the surfaces, on the wall of a room, or in a cell of its own; a broad one is of some size and shines all ways."""
    glowing = [surface for surface in surfaces if glows_well(surface)]
    kinds = ["shape", "volume"] + ["point"] * (not is_broad) + ["surface", "surface"] * bool(glowing)
    kinds += ["beam"] * (light and not is_broad)
    kind = draw(st.sampled_from(kinds))
    pulse = draw(pulses(duration)) if light else None
    if kind == "surface":
        surface = draw(st.sampled_from(glowing))
        is_open = not surface.shape.is_closed
        side = "back" if surface.name == "room" or (is_open and draw(st.booleans())) else "front"
        emission = draw(glow(light, pulse))
        return tp.Source(
            surface.name, emission, side=side, pulse=pulse, aim=draw(aims(middle, surface.shape))
        )
    if kind == "shape":
        own = (shapes.flat(cell, LAMP), shapes.balls(cell, LAMP), shapes.revolved(cell, LAMP))
        shape = draw(st.one_of([*contacts.patches(surfaces), *own]))
        return tp.Source(shape, draw(glow(light, pulse)), pulse=pulse, aim=draw(aims(middle, shape)))
    place = tp.Point(position=cell)
    volume = draw(st.one_of(shapes.balls(cell, LAMP), shapes.boxes(cell, LAMP)))
    if not light:
        shape = volume if kind == "volume" else place
        speed = draw(st.sampled_from([500.0, WARM]))
        return tp.Source(shape, tp.Gas(number=1e6, speed=speed))
    amount = {"power": 3.0} if pulse is None else {"energy": 3.0}
    if kind == "beam":
        shape = draw(st.sampled_from([place, volume]))
        return tp.Source(shape, tp.Beam(draw(shapes.directions()), **amount), pulse=pulse)
    shape = volume if kind == "volume" else place
    return tp.Source(shape, tp.Isotropic(**amount), pulse=pulse, aim=draw(aims(middle, shape)))


@st.composite
def wide_lamps(draw, cell: Vector) -> tp.Source:
    """A large shape, or a volume, that sends light into all directions."""
    if draw(st.booleans()):
        volume = (
            tp.Box(center=cell, size=2 * LAMP) if draw(st.booleans()) else tp.Sphere(center=cell, radius=LAMP)
        )
        return tp.Source(volume, tp.Isotropic(power=3.0))
    shape = draw(st.sampled_from([tp.Sphere(center=cell, radius=LAMP), tp.Box(center=cell, size=LAMP)]))
    return tp.Source(shape, tp.Lambertian(radiance=1.0))


def glow(light: bool, pulse: object) -> st.SearchStrategy:
    """What leaves a surface."""
    if not light:
        effusive = [tp.Effusive(number=1e6, speed=500.0), tp.Effusive(density=1e3, speed=WARM)]
        return st.sampled_from([*effusive, tp.Effusive(exitance=1e9, speed=1e3)])
    if pulse is not None:
        return st.just(tp.Lambertian(energy=2.0))
    return st.sampled_from(
        [tp.Lambertian(radiance=1.0), tp.Lambertian(exitance=7.0), tp.Lambertian(power=0.1)]
    )


@st.composite
def aims(draw, middle: Vector, shape):
    """Mostly none; else a disk or a ball somewhere in the middle."""
    kind = draw(st.sampled_from([None, None, None, "disk", "ball"]))
    if kind is None:
        return None
    return (
        draw(shapes.balls(middle, 0.1))
        if kind == "ball"
        else tp.Disk(center=middle, normal=(0, 0.6, 0.8), radius=0.1)
    )


def pulses(duration: float | None) -> st.SearchStrategy:
    """When it emits, within the duration."""
    if duration is None:
        return st.none()
    third = duration / 3
    said = [
        tp.Instant(),
        tp.Instant(third),
        tp.BoxPulse(third, 2 * third),
        tp.GaussianPulse(third, third / 9),
    ]
    return st.sampled_from([None, *said])


def glows_well(surface: Surface) -> bool:
    """Whether a surface may emit: it ends, has an outside, and lets histories end that it sends out."""
    is_clear = any(
        isinstance(part, tp.Dielectric | tp.ThinLens | tp.Transparent) for part in surface.material.elements
    )
    return not surface.shape.is_infinite and not is_clear and not _keeps_nothing(surface)


def _keeps_nothing(surface: Surface) -> bool:
    """Whether a hollow shape returns nearly all that it sends into itself: its light might never leave it."""
    is_hollow = not surface.shape.is_closed and not hasattr(surface.shape, "normal")
    return is_hollow and all(_returned(part) > 0.95 for part in surface.material.elements)


def _returned(part) -> float:
    first = ("albedo", "reflectance")
    return sum(getattr(part, name, 0.0) for name in first)
