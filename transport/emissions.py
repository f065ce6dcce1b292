"""Emissions: how much leaves a source, in which directions and how fast.

An emission knows the shapes that it can leave from, and what leaves one of them: with a clock the whole
amount, an energy [J] or a number of particles; in a steady scene a rate [W] or [s^-1].  A speed left out is
that of light.
"""

import math
from dataclasses import field

import numpy as np

from transport.fields import OptionalVector, VectorField
from transport.media.base import Phase
from transport.pulses import Pulse
from transport.shapes import (
    Box,
    Cloud,
    Cone,
    Cylinder,
    Disk,
    FlatShape,
    Mesh,
    Paraboloid,
    Point,
    Rectangle,
    Shape,
    Sphere,
    Triangle,
)
from transport.speeds import Maxwellian, SpeedDistribution
from transport.units import speed_of_light
from transport.validation import (
    refuse,
    scene_object,
    settle_direction,
    settle_nonnegative,
    settle_positive,
    shown,
    store,
)

SURFACES = (Rectangle, Disk, Triangle, Sphere, Box, Cylinder, Cone, Paraboloid, Mesh)


class Emission:
    """What all emissions share; not made itself."""

    measured_in = "watts"
    whole = "energy"  # the parameter that gives the whole amount, which only a clock gives a meaning
    rates: tuple[str, ...] = ()  # the others that give the amount
    shapes: tuple[type, ...] = ()  # that it can leave from
    cure = ""  # for other shapes
    has_side = False  # whether it leaves from one side of a surface
    needs_whole = False  # whether a Sphere must be all of it
    can_aim = False
    mass: float | None = None  # of a particle [kg]

    @property
    def given(self) -> str:
        """Name of the parameter that says how much leaves."""
        return next(name for name in (*self.rates, self.whole) if getattr(self, name) is not None)

    @property
    def is_whole(self) -> bool:
        """Whether it is the whole amount that is given, not a rate."""
        return self.given == self.whole

    def amount(
        self,
        shape: Shape,
        duration: float | None = None,
        pulse: Pulse | None = None,
        is_back: bool = False,
    ) -> float:
        """All that leaves one side of the shape [J or 1]; without a duration [s] a rate [W or s^-1].

        A rate holds for the duration, or while a BoxPulse is on.
        """
        if self.is_whole:
            return getattr(self, self.whole)
        rate = self.rate(shape, is_back)
        if duration is None:
            return rate
        return rate * (duration if pulse is None else pulse.length)

    def rate(self, shape: Shape, is_back: bool = False) -> float:
        """What leaves one side of the shape [W] or [s^-1]."""
        raise NotImplementedError

    def _settle_amount(self) -> None:
        names = (*self.rates, self.whole)
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) != 1:
            values = ", ".join(f"{name}={shown(getattr(self, name))}" for name in given) or "none"
            refuse(self, f"exactly one of {', '.join(names)} must be given, got {values}")
        settle_positive(self, given[0])

    def _settle_speed(self) -> None:
        if self.speed is None:
            store(self, speed=speed_of_light)
        if isinstance(self.speed, SpeedDistribution):
            refuse(
                self,
                f"speed must be a number, got {shown(self.speed)}; particles of many speeds leave as Effusive"
                " from a surface, or as Gas",
            )
        settle_positive(self, "speed")


@scene_object(kw_only=True)
class Lambertian(Emission):
    """Diffuse emission from one side of a surface: equal radiance in all directions.

    One of `radiance` [W m^-2 sr^-1], `exitance` [W m^-2], `power` [W] and `energy` [J] (both of the whole
    shape) is given.
    """

    radiance: float | None = None
    exitance: float | None = None
    power: float | None = None
    energy: float | None = None
    speed: float | None = None

    rates = ("radiance", "exitance", "power")
    shapes = SURFACES
    cure = "a Point emits Isotropic"
    has_side = can_aim = True

    def __post_init__(self) -> None:
        self._settle_amount()
        self._settle_speed()

    def rate(self, shape: Shape, is_back: bool = False) -> float:
        """pi radiance area, exitance area, or power [W]."""
        if self.radiance is not None:
            return math.pi * self.radiance * shape.area
        return self.power if self.exitance is None else self.exitance * shape.area


@scene_object(kw_only=True)
class Isotropic(Emission, Phase):
    """Equal intensity in all directions, from a Point or uniformly from the volume of a Box or Sphere.

    One of `power` [W], `intensity` [W/sr] and `energy` [J] (of the whole source) is given.  Without any it is the
    phase function of a medium that scatters into all directions alike, and no Source has it.
    """

    power: float | None = None
    intensity: float | None = None
    energy: float | None = None
    speed: float | None = None

    rates = ("power", "intensity")
    shapes = (Point, Box, Sphere)
    cure = "a surface emits Lambertian"
    can_aim = needs_whole = True
    g = 0.0

    def __post_init__(self) -> None:
        if not self.is_phase:
            self._settle_amount()
            self._settle_speed()

    def __repr__(self) -> str:
        names = () if self.is_phase else ("power", "intensity", "energy", "speed")
        return f"Isotropic({', '.join(f'{name}={getattr(self, name)!r}' for name in names)})"

    @property
    def is_phase(self) -> bool:
        """Whether it has no amount, and so is a phase function."""
        return all(getattr(self, name) is None for name in (*self.rates, self.whole, "speed"))

    @property
    def given(self) -> str:
        """Name of the parameter that says how much leaves; SceneError for a phase function."""
        if self.is_phase:
            self._settle_amount()
        return super().given

    def rate(self, shape: Shape, is_back: bool = False) -> float:
        """power, or 4 pi intensity [W]."""
        return 4 * math.pi * self.intensity if self.power is None else self.power

    def density(self, mu: np.ndarray | float) -> np.ndarray | float:
        """As a phase function: 1/(4 pi) [sr^-1] at all cosines mu."""
        return np.full(np.shape(mu), 1 / (4 * math.pi))[()]


@scene_object
class Beam(Emission):
    """Parallel rays along `direction`: a pencil from a Point, uniform over its section from other shapes.

    One of `power` [W], `irradiance` [W m^-2] (on a plane normal to the beam) and `energy` [J] is given.
    """

    direction: VectorField
    power: float | None = field(default=None, kw_only=True)
    irradiance: float | None = field(default=None, kw_only=True)
    energy: float | None = field(default=None, kw_only=True)
    speed: float | None = field(default=None, kw_only=True)

    rates = ("power", "irradiance")
    shapes = (Point, Rectangle, Disk, Triangle, Sphere, Box)
    cure = "choose one of them"
    has_side = needs_whole = True

    def __post_init__(self) -> None:
        settle_direction(self, "direction")
        self._settle_amount()
        self._settle_speed()

    def rate(self, shape: Shape, is_back: bool = False) -> float:
        """power, or irradiance times the area that the shape shows along the beam [W]."""
        return self.irradiance * shape.projected_area(self.direction) if self.power is None else self.power


class ParticleEmission(Emission):
    """What Gas and Effusive share: particles, which may have a mass and a distribution of speeds."""

    measured_in = "particles"
    whole = "number"

    def _settle_particles(self) -> None:
        self._settle_amount()
        if self.speed is None:
            refuse(self, f"speed missing; write {type(self).__name__}(speed=...)")
        if isinstance(self.speed, Maxwellian):
            self._settle_mass_of(self.speed)
        if self.mass is not None:
            settle_positive(self, "mass")

    def _settle_mass_of(self, gas: Maxwellian) -> None:
        if self.mass is None:
            store(self, mass=gas.mass)
        elif gas.mass is not None and gas.mass != self.mass:
            refuse(
                self,
                f"mass must be that of its Maxwellian, {gas.mass} kg, got {shown(self.mass)}; leave it out",
            )


@scene_object
class Gas(ParticleEmission):
    """Particles that fly from time 0 on: uniform in a Box or Sphere, in a Gaussian Cloud, or from a Point.

    One of `density` [m^-3] (of a Cloud: at its centre) and `number` is given.  `speed`: a number [m/s], 0 for
    particles at rest, or a distribution.  Their directions are isotropic, or all along `direction`; there a
    Maxwellian gives one signed velocity component, and negative speeds fly the other way.  `mass` of a
    particle [kg]: that of its Maxwellian where it is left out.
    """

    density: float | None = None
    speed: float | SpeedDistribution | None = None
    direction: OptionalVector = None
    number: float | None = None
    mass: float | None = None

    rates = ("density",)
    shapes = (Box, Sphere, Cloud, Point)
    cure = "enclose it in a Box"
    needs_whole = True

    def __post_init__(self) -> None:
        self._settle_particles()
        if self.direction is not None:
            settle_direction(self, "direction")
        if not isinstance(self.speed, SpeedDistribution):
            settle_nonnegative(self, "speed")
        elif self.direction is None and self.speed.is_signed:
            refuse(
                self,
                f"speed must not be negative without a direction, got {shown(self.speed)}; add direction=...",
            )
        elif self.direction is not None and self.speed.has_drift:
            cure = "leave direction out, or give the drift to a SpeedTable along it"
            refuse(self, f"direction does not go with a drift, got {shown(self.speed)}; {cure}")

    def amount(
        self,
        shape: Shape,
        duration: float | None = None,
        pulse: Pulse | None = None,
        is_back: bool = False,
    ) -> float:
        """Number of particles."""
        return self.density * shape.volume if self.number is None else self.number


@scene_object
class Effusive(ParticleEmission):
    """What a gas behind a surface would send through it: the cosine law, speeds weighted by the speed.

    One of `density` of that gas [m^-3], `exitance` [s^-1 m^-2] and `number` (in all, within the duration or
    pulse) is given.  `speed`: a number [m/s] or a distribution; the drift of a Maxwellian only on flat
    shapes.  `mass` of a particle [kg]: that of its Maxwellian where it is left out.
    """

    density: float | None = None
    speed: float | SpeedDistribution | None = None
    exitance: float | None = None
    number: float | None = None
    mass: float | None = None

    rates = ("density", "exitance")
    shapes = SURFACES
    cure = "particles leave a Point as a Gas"
    has_side = can_aim = True

    def __post_init__(self) -> None:
        self._settle_particles()
        if not isinstance(self.speed, SpeedDistribution):
            settle_positive(self, "speed")
        elif self.speed.is_signed:
            refuse(
                self,
                f"speed must not be negative, got {shown(self.speed)}; write a table of speeds from 0 on",
            )

    def rate(self, shape: Shape, is_back: bool = False) -> float:
        """exitance area, or density area mean speed / 4 [s^-1] (Reif 1965, 7.11)."""
        return (
            self.density * self.crossing_speed(shape, is_back) if self.exitance is None else self.exitance
        ) * shape.area

    def crossing_speed(self, shape: Shape, is_back: bool = False) -> float:
        """One-way flux density over the density of the gas [m/s]: at rest a quarter of the mean speed."""
        if not isinstance(self.speed, SpeedDistribution):
            return self.speed / 4
        if self.speed.has_drift and isinstance(shape, FlatShape):
            return self.speed.one_way_flux(self.speed.drift_through(shape, is_back))
        return self.speed.mean_speed / 4
