"""Random rooms full of a gas that nothing changes: uniform, isotropic and of one temperature at every instant, or of light.

Walls, things and fogs keep all that comes to them, and what they send back is as a gas in equilibrium would send it.
"""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st

import transport as tp
from tests.fuzz import shapes
from tests.fuzz.agreements import ENOUGH, Scores, checked, run_of, score_of
from tests.fuzz.lamps import WARM
from tests.fuzz.looks import THERMAL
from tests.fuzz.worlds import MIDDLES, ROOM, WITHIN, World, cells_about
from transport.scene.materials import Material
from transport.vectors import Vector

DENSITY = 1e3  # m^-3, of particles, or J m^-3
HALF = 0.45 * ROOM  # m, of the part of the room that is looked at
MANY = 1_000_000  # particles of a sample, more than there are


@st.composite
def gases(draw) -> World:
    """A room of gas, thermal or of one speed, or of light that fills it from the start."""
    middle = draw(MIDDLES)
    cells = draw(st.permutations(cells_about(middle)))
    speed = draw(st.sampled_from([None, THERMAL, WARM]))
    shape = draw(st.sampled_from([tp.Box(center=middle, size=ROOM), tp.Sphere(center=middle, radius=ROOM)]))
    walls = draw(st.sampled_from([shape, tp.Mesh.box(center=middle, size=ROOM)]))
    if isinstance(walls, tp.Mesh):
        shape = tp.Box(center=middle, size=ROOM)
    surfaces = [tp.Surface(walls, draw(lossless(speed).filter(_is_opaque)), "room")]
    surfaces += [draw(_thing(cells.pop(), k, speed)) for k in range(draw(st.integers(0, 3)))]
    duration = draw(st.sampled_from([0.3, 3.0])) * ROOM / _mean_speed(speed)
    parts = {"sources": (_filling(shape, speed),), "surfaces": tuple(surfaces), "medium": None}
    parts |= {"detectors": tuple(looks_at(middle, cells, duration)), "duration": duration}
    return World(parts, unit=draw(st.tuples(st.integers(-30, 30), st.integers(-40, 40))))


def lossless(speed: object) -> st.SearchStrategy[Material]:
    """What keeps all that comes: diffuse, mirroring, glossy, passing a half; thermal walls in a thermal gas."""
    walls = [
        tp.Diffuse(1.0),
        tp.Diffuse(0.5, transmission=0.5),
        tp.Mirror(),
        tp.Mirror(0.25, 0.75),
        tp.Glossy(0.3),
    ]
    walls.append(tp.Mixture({tp.Diffuse(1.0): 0.5, tp.Mirror(): 0.25, tp.Glossy(0.1): 0.25}))
    if speed is WARM:
        walls += [tp.Diffuse(1.0, speed=WARM), tp.Diffuse(0.5, transmission=0.5, speed=WARM)] * 2
    return st.sampled_from(walls)


def _is_opaque(material: Material) -> bool:
    return all(getattr(part, "transmission", 0.0) == 0 for part in material.elements)


@st.composite
def _thing(draw, place: Vector, number: int, speed: object) -> tp.Surface:
    """A sheet or a body that keeps all, or fog that scatters light."""
    kind = draw(st.sampled_from(["sheet", "body", "fog"] if speed is None else ["sheet", "body"]))
    if kind == "sheet":
        return tp.Surface(draw(shapes.sheets(place, WITHIN)), draw(lossless(speed)), f"thing {number}")
    shape = draw(shapes.closed(place, WITHIN))
    if kind == "body":
        return tp.Surface(shape, draw(lossless(speed)), f"thing {number}")
    fog = tp.Medium(scattering=draw(st.sampled_from([0.1, 5.0])) / WITHIN, phase=tp.HenyeyGreenstein(0.5))
    return tp.Surface(shape, tp.Transparent(), f"thing {number}", inside=fog)


def _filling(shape, speed: object) -> tp.Source:
    """The room's whole volume, filled at once."""
    if speed is None:
        return tp.Source(shape, tp.Isotropic(energy=DENSITY * shape.volume), pulse=tp.Instant())
    return tp.Source(shape, tp.Gas(density=DENSITY, speed=speed))


def looks_at(middle: Vector, cells: list[Vector], duration: float) -> list:
    """Phase space by place, direction and moments, a sample, and meters."""
    times = (0.0, 0.5 * duration, duration)
    part = tp.Box(center=middle, size=2 * HALF)
    edges = [tuple(m + HALF * edge for edge in (-1.0, -0.2, 0.4, 1.0)) for m in middle]
    return [
        tp.PhaseSpace(x=edges[0], mu=4, time=times, within=part, name="x mu"),
        tp.PhaseSpace(y=edges[1], z=edges[2], time=times, within=part, name="y z", moments=True),
        tp.Snapshot(times[1], MANY, "sample"),
        tp.Detector(tp.Disk(center=cells[0], normal=(1, 2, -3), radius=WITHIN), "disk", moments=True),
        tp.VolumeDetector(part, "volume"),
    ]


def check_gas(world: World) -> list[str]:
    """Density, flux, fluence rate and temperature are those of the gas, in all bins and at all times.  Raises AssertionError."""
    return checked(lambda seed, more: _levels(world, seed, more))


def _levels(world: World, seed: int, more: int) -> Scores:
    """Scores of all that phase space and the meters tell, and one where number itself is not kept."""
    result = run_of(world, seed, more)
    emission = result.scene.sources[0].emission
    speed = getattr(emission, "speed", None) if result.scene.measured_in == "particles" else None
    mean = _mean_speed(speed)
    unit = 2.0 ** (world.unit[1] - 3 * world.unit[0])
    # energies grow with the length
    density = DENSITY * unit * (2.0 ** world.unit[0] if speed is None else 1.0)
    for look in result.scene.phase_spaces:
        kept = np.asarray(result[look.name].alive.value) / result.ledger["emitted"].value
        assert np.allclose(kept, 1.0, rtol=1e-12, atol=0), f"alive in {look.name}: {kept} of all"
    exact = {"x mu.density": density / 2, "y z.density": density, "y z.fluence_rate": density * mean}
    exact |= {"disk.irradiance": density * mean / 4, "disk.exitance": density * mean / 4}
    exact |= {"volume.fluence_rate": density * mean}
    if isinstance(speed, tp.Maxwellian):
        exact |= {"y z.temperature": speed.temperature, "y z.variance_vx": _variance(speed)}
        exact |= {"disk.mean_speed_in": 3 * math.pi / 8 * mean}
    found: Scores = {}
    for name, level in exact.items():
        found |= _scores(result, name, level)
    return found


def _scores(result: tp.Result, name: str, level: float) -> Scores:
    """z of a quantity, or of each of its bins in which enough have been counted."""
    quantity = result.quantity(name)
    if np.ndim(quantity.value) == 0:
        counts = np.sum(result[name.partition(".")[0]].counts.value)
        return {name: score_of(quantity, level)} if counts >= ENOUGH else {}
    number = np.asarray(result[name.partition(".")[0]].number.value) / result.ledger["emitted"].value
    enough = number * result.particles >= ENOUGH
    return {
        f"{name}{list(map(int, place))}": score_of(quantity[tuple(place)], level)
        for place in np.argwhere(enough)
    }


def _mean_speed(speed: object) -> float:
    if speed is None:
        return tp.speed_of_light
    return speed.mean_speed if isinstance(speed, tp.Maxwellian) else speed


def _variance(speed: tp.Maxwellian) -> float:
    """Of a component of the velocity [m^2 s^-2]."""
    return math.pi / 8 * speed.mean_speed**2
