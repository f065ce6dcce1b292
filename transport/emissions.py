"""Emissions: how much leaves a source, in which directions and how fast.

An emission knows the shapes that it can leave from, and what it emits from one of them in all: its power [W],
or for a Gas its particles. A speed left out is that of light.
"""

import math
from dataclasses import field

from transport.shapes import Box, Disk, Point, Rectangle, Shape, Sphere
from transport.units import speed_of_light
from transport.validation import refuse, scene_object, settle_direction, settle_positive, shown, store
from transport.vectors import Vector


class Emission:
    """What all emissions share; not made itself."""

    measured_in = "watts"
    shapes: tuple[type, ...] = ()  # that it can leave from
    cure = ""  # for other shapes
    has_side = False  # whether it leaves from one side of a surface
    can_aim = False

    def emitted(self, shape: Shape) -> float:
        """Whole power [W] that leaves the shape, one of `shapes`; of a Gas, its particles."""
        raise NotImplementedError

    def _settle_amount(self, *names: str) -> None:
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) != 1:
            values = ", ".join(f"{name}={shown(getattr(self, name))}" for name in given) or "none"
            refuse(self, f"exactly one of {', '.join(names)} must be given, got {values}")
        if self.speed is None:
            store(self, speed=speed_of_light)
        settle_positive(self, given[0], "speed")


@scene_object(kw_only=True)
class Lambertian(Emission):
    """Diffuse emission from one side of a surface: equal radiance in all directions.

    One of `radiance` [W m^-2 sr^-1], `exitance` [W m^-2] and `power` [W] (of the whole shape) is given.
    """

    radiance: float | None = None
    exitance: float | None = None
    power: float | None = None
    speed: float | None = None

    shapes = (Rectangle, Disk, Sphere, Box)
    cure = "a Point emits Isotropic"
    has_side = can_aim = True

    def __post_init__(self) -> None:
        self._settle_amount("radiance", "exitance", "power")

    def emitted(self, shape: Shape) -> float:
        """pi radiance area, exitance area, or power [W]."""
        if self.radiance is not None:
            return math.pi * self.radiance * shape.area
        return self.power if self.exitance is None else self.exitance * shape.area


@scene_object(kw_only=True)
class Isotropic(Emission):
    """Equal intensity in all directions, from a Point or uniformly from the volume of a Box or Sphere.

    One of `power` [W] and `intensity` [W/sr] (of the whole source) is given.
    """

    power: float | None = None
    intensity: float | None = None
    speed: float | None = None

    shapes = (Point, Box, Sphere)
    cure = "a flat shape emits Lambertian"
    can_aim = True

    def __post_init__(self) -> None:
        self._settle_amount("power", "intensity")

    def emitted(self, shape: Shape) -> float:
        """power, or 4 pi intensity [W]."""
        return 4 * math.pi * self.intensity if self.power is None else self.power


@scene_object
class Beam(Emission):
    """Parallel rays along `direction`: a pencil from a Point, uniform over its section from other shapes.

    One of `power` [W] and `irradiance` [W m^-2] is given; the latter is that on a plane normal to the beam.
    """

    direction: Vector
    power: float | None = field(default=None, kw_only=True)
    irradiance: float | None = field(default=None, kw_only=True)
    speed: float | None = field(default=None, kw_only=True)

    shapes = (Point, Rectangle, Disk, Sphere, Box)
    cure = "choose one of them"
    has_side = True

    def __post_init__(self) -> None:
        settle_direction(self, "direction")
        self._settle_amount("power", "irradiance")

    def emitted(self, shape: Shape) -> float:
        """power, or irradiance times the area that the shape shows along the beam [W]."""
        return self.irradiance * shape.projected_area(self.direction) if self.power is None else self.power


@scene_object
class Gas(Emission):
    """Particles that fill a Box uniformly at time 0: `density` [m^-3], one `speed` [m/s].

    Their directions are isotropic, or all along `direction` where that is given.
    """

    density: float
    speed: float
    direction: Vector | None = None

    measured_in = "particles"
    shapes = (Box,)
    cure = "enclose it in a Box"

    def __post_init__(self) -> None:
        settle_positive(self, "density", "speed")
        if self.direction is not None:
            settle_direction(self, "direction")

    def emitted(self, shape: Box) -> float:
        """Number of particles."""
        return self.density * shape.volume
