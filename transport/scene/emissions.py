"""Emissions: amount, directions and speeds of what leaves a source.

An emission lists the shapes that it can leave from and computes the emitted amount: with a clock an
energy [J] or a number of particles, in a steady scene a rate [W] or [s^-1]. The default speed is the
speed of light.
"""

import math
from dataclasses import field

import numpy as np

from transport.geometry.flat import Disk, Rectangle, Triangle
from transport.geometry.mesh import Mesh
from transport.geometry.polygon import Polygon
from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.shape import Cloud, Point, Shape
from transport.geometry.solid import Box, Sphere
from transport.scene.phase_functions import ISOTROPIC_DENSITY, Phase
from transport.scene.pulses import Pulse
from transport.scene.speeds import Maxwellian, SpeedDistribution
from transport.units import speed_of_light
from transport.validation import (
    OptionalVectorField,
    VectorField,
    coerce_direction,
    coerce_nonnegative,
    coerce_positive,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)

SURFACE_SHAPES = (Rectangle, Disk, Triangle, Polygon, Sphere, Box, Cylinder, Cone, Paraboloid, Mesh)


DIRECTION_DENSITIES = {"lambertian": 1 / math.pi, "isotropic": 0.25 / math.pi}  # [sr^-1] greatest, by law


class Emission:
    """Base class of emissions; not instantiated directly."""

    measured_in = "watts"
    whole = "energy"  # the parameter of the total amount, which needs a clock
    rates: tuple[str, ...] = ()  # the parameters that give a rate
    shapes: tuple[type, ...] = ()  # shapes that it can leave from
    cure = ""  # hint for other shapes
    has_side = False  # whether it leaves from one side of a surface
    needs_whole = False  # whether a Sphere must be all of it
    can_aim = False
    law = ""  # of the directions: "lambertian", "isotropic", or "beam" for a single one
    fills_volume = False  # whether it leaves from all points of a volume
    mass: float | None = None  # of a particle [kg]

    @property
    def given(self) -> str:
        """Name of the parameter that sets the amount.

        Returns
        -------
        str
        """
        return next(name for name in (*self.rates, self.whole) if getattr(self, name) is not None)

    @property
    def is_whole(self) -> bool:
        """Whether the total amount is given (energy or number) instead of a rate.

        Returns
        -------
        bool
        """
        return self.given == self.whole

    def amount(
        self, shape: Shape, duration: float | None = None, pulse: Pulse | None = None, is_back: bool = False
    ) -> float:
        """Return the amount that leaves one side of a shape.

        Parameters
        ----------
        shape : Shape
            Shape of the source.
        duration : float, default None
            Duration of the scene [s]; None for a steady scene.
        pulse : Pulse, default None
            Pulse of the source. A rate holds for the whole duration, or while a BoxPulse is on.
        is_back : bool, default False
            Whether the back of the surface emits.

        Returns
        -------
        float
            Energy [J] or number of particles; without a duration a rate [W] or [s^-1].
        """
        if self.is_whole:
            return getattr(self, self.whole)
        rate = self.rate(shape, is_back)
        if duration is None:
            return rate
        return rate * (duration if pulse is None else pulse.length)

    @property
    def ray_densities(self) -> dict[str, float]:
        """Greatest density of directions [sr^-1] by its law, if shadow rays connect births; else empty."""
        is_connected = self.measured_in == "watts" and self.law in DIRECTION_DENSITIES
        return {self.law: DIRECTION_DENSITIES[self.law]} if is_connected else {}

    def rate(self, shape: Shape, is_back: bool = False) -> float:
        """Return the rate at which one side of a shape emits.

        Returns
        -------
        float
            Power [W] or particles per time [s^-1].
        """
        raise NotImplementedError

    def _coerce_amount(self) -> None:
        names = (*self.rates, self.whole)
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) != 1:
            values = ", ".join(f"{name}={short_repr(getattr(self, name))}" for name in given) or "none"
            refuse(self, f"exactly one of {', '.join(names)} must be given, got {values}")
        coerce_positive(self, given[0])

    def _coerce_speed(self) -> None:
        if self.speed is None:
            set_fields(self, speed=speed_of_light)
        if isinstance(self.speed, SpeedDistribution):
            refuse(
                self,
                f"speed must be a number, got {short_repr(self.speed)}; for a distribution of speeds use"
                " Effusive from a surface, or Gas",
            )
        coerce_positive(self, "speed")


@scene_object(kw_only=True)
class Lambertian(Emission):
    """Diffuse emission from one side of a surface: equal radiance in all directions.

    Give exactly one of `radiance`, `exitance`, `power` and `energy`.

    Parameters
    ----------
    radiance : float, default None
        Radiance L of the surface [W m^-2 sr^-1].
    exitance : float, default None
        Emitted power per area M = pi L [W m^-2].
    power : float, default None
        Power of the whole surface [W].
    energy : float, default None
        Energy of the whole surface [J]; needs a scene with a duration.
    speed : float, default speed_of_light
        Speed of the particles [m/s].

    Raises
    ------
    SceneError
        If not exactly one amount is given, or if it is not positive and finite.

    Notes
    -----
    Allowed shapes: Rectangle, Disk, Triangle, Polygon, Sphere, Box, Cylinder, Cone, Paraboloid, Mesh.
    Power P = pi L A (Lambert 1760).

    Examples
    --------
    >>> import transport as tp
    >>> round(tp.Lambertian(radiance=100.0).rate(tp.Disk(radius=0.5)), 3)  # [W]
    246.74
    """

    radiance: float | None = None
    exitance: float | None = None
    power: float | None = None
    energy: float | None = None
    speed: float | None = None

    rates = ("radiance", "exitance", "power")
    law = "lambertian"
    shapes = SURFACE_SHAPES
    cure = "use Isotropic for a Point"
    has_side = can_aim = True

    def __post_init__(self) -> None:
        self._coerce_amount()
        self._coerce_speed()

    def rate(self, shape: Shape, is_back: bool = False) -> float:
        """Return the power pi radiance area, exitance area, or `power`.

        Returns
        -------
        float
            Power [W].
        """
        if self.radiance is not None:
            return math.pi * self.radiance * shape.area
        return self.power if self.exitance is None else self.exitance * shape.area


@scene_object(kw_only=True)
class Isotropic(Emission, Phase):
    """Isotropic emission from a Point or from a volume; without an amount, the isotropic phase function.

    As an emission it has equal intensity in all directions, from a Point or uniformly from the volume of a
    Box or Sphere. Give exactly one of `power`, `intensity` and `energy`. `Isotropic()` without any is the
    phase function of a medium that scatters equally in all directions; a Source cannot use it.

    Parameters
    ----------
    power : float, default None
        Power of the whole source [W].
    intensity : float, default None
        Radiant intensity of the whole source [W/sr].
    energy : float, default None
        Energy of the whole source [J]; needs a scene with a duration.
    speed : float, default speed_of_light
        Speed of the particles [m/s].

    Raises
    ------
    SceneError
        If more than one amount is given, or if it is not positive and finite.

    Examples
    --------
    >>> import transport as tp
    >>> round(tp.Isotropic(intensity=1.0).rate(tp.Point()), 4)  # 4 pi [W]
    12.5664
    >>> tp.Medium(absorption=0.1, scattering=0.9).phase
    Isotropic()
    """

    power: float | None = None
    intensity: float | None = None
    energy: float | None = None
    speed: float | None = None

    rates = ("power", "intensity")
    shapes = (Point, Box, Sphere)
    cure = "use Lambertian for a surface"
    can_aim = needs_whole = True
    g, law, max_density = 0.0, "isotropic", ISOTROPIC_DENSITY
    fills_volume = True

    def __post_init__(self) -> None:
        if not self.is_phase:
            self._coerce_amount()
            self._coerce_speed()

    def __repr__(self) -> str:
        names = () if self.is_phase else ("power", "intensity", "energy", "speed")
        return f"Isotropic({', '.join(f'{name}={getattr(self, name)!r}' for name in names)})"

    @property
    def is_phase(self) -> bool:
        """Whether it has no amount and so is a phase function.

        Returns
        -------
        bool
        """
        return all(getattr(self, name) is None for name in (*self.rates, self.whole, "speed"))

    @property
    def given(self) -> str:
        """Name of the parameter that sets the amount.

        Returns
        -------
        str

        Raises
        ------
        SceneError
            If it is a phase function, which has no amount.
        """
        if self.is_phase:
            self._coerce_amount()
        return super().given

    def rate(self, shape: Shape, is_back: bool = False) -> float:
        """Return `power`, or 4 pi times `intensity`.

        Returns
        -------
        float
            Power [W].
        """
        return 4 * math.pi * self.intensity if self.power is None else self.power

    def density(self, mu: np.ndarray | float) -> np.ndarray | float:
        """Return the phase function 1/(4 pi) at cosines mu of the scattering angle.

        Parameters
        ----------
        mu : float or array
            Cosines of the scattering angle, in [-1, 1].

        Returns
        -------
        float or array
            Density per solid angle [sr^-1], of the shape of mu.
        """
        return np.full(np.shape(mu), 1 / (4 * math.pi))[()]


@scene_object
class Beam(Emission):
    """Parallel rays: a pencil beam from a Point, a uniform beam from other shapes.

    Give exactly one of `power`, `irradiance` and `energy`.

    Parameters
    ----------
    direction : vector
        Direction of flight, of any length except 0; stored as a unit vector.
    power : float, default None
        Power of the beam [W].
    irradiance : float, default None
        Power per area on a plane normal to the beam [W m^-2]; not from a Point.
    energy : float, default None
        Energy of the beam [J]; needs a scene with a duration.
    speed : float, default speed_of_light
        Speed of the particles [m/s].

    Raises
    ------
    SceneError
        If not exactly one amount is given, or if it is not positive and finite.

    Notes
    -----
    Allowed shapes: Point, Rectangle, Disk, Triangle, Polygon, Sphere, Box. The direction must point out of
    the emitting side of a flat shape.

    Examples
    --------
    >>> import transport as tp
    >>> sun = tp.Beam((0, 0, -2), irradiance=1000.0)
    >>> sun.direction
    (0.0, 0.0, -1.0)
    >>> round(sun.rate(tp.Disk(radius=1.0, normal=(0, 0, -1))), 3)  # [W]
    3141.593
    """

    direction: VectorField
    power: float | None = field(default=None, kw_only=True)
    irradiance: float | None = field(default=None, kw_only=True)
    energy: float | None = field(default=None, kw_only=True)
    speed: float | None = field(default=None, kw_only=True)

    rates = ("power", "irradiance")
    law = "beam"
    shapes = (Point, Rectangle, Disk, Triangle, Polygon, Sphere, Box)
    cure = "choose one of them"
    has_side = needs_whole = True

    def __post_init__(self) -> None:
        coerce_direction(self, "direction")
        self._coerce_amount()
        self._coerce_speed()

    def rate(self, shape: Shape, is_back: bool = False) -> float:
        """Return `power`, or `irradiance` times the projected area of the shape.

        Returns
        -------
        float
            Power [W].
        """
        return self.irradiance * shape.projected_area(self.direction) if self.power is None else self.power


class ParticleEmission(Emission):
    """Base class of Gas and Effusive: particles with a mass or a distribution of speeds."""

    measured_in = "particles"
    whole = "number"

    def _coerce_particles(self) -> None:
        self._coerce_amount()
        if self.speed is None:
            refuse(self, f"speed missing; write {type(self).__name__}(speed=...)")
        if isinstance(self.speed, Maxwellian):
            self._coerce_mass(self.speed)
        if self.mass is not None:
            coerce_positive(self, "mass")

    def _coerce_mass(self, gas: Maxwellian) -> None:
        if self.mass is None:
            set_fields(self, mass=gas.mass)
        elif gas.mass is not None and gas.mass != self.mass:
            refuse(
                self,
                f"mass must be that of its Maxwellian, {gas.mass} kg, got {short_repr(self.mass)};"
                " leave it out",
            )


@scene_object
class Gas(ParticleEmission):
    """A gas in flight from time 0: uniform in a Box or Sphere, in a Gaussian Cloud, or from a Point.

    Needs a scene with a duration. Give exactly one of `density` and `number`.

    Parameters
    ----------
    density : float, default None
        Number density [m^-3]; for a Cloud, at its centre.
    speed : float or SpeedDistribution
        Speed [m/s], 0 for particles at rest, or a distribution such as Maxwellian. Required.
    direction : vector, default None
        None: directions are isotropic. Otherwise all particles fly along this direction: a Maxwellian
        then gives one signed velocity component, and negative speeds fly the other way.
    number : float, default None
        Number of particles in all.
    mass : float, default that of the Maxwellian, else None
        Mass of a particle [kg].

    Raises
    ------
    SceneError
        If not exactly one amount is given, if speeds are negative without a direction, if a drift is
        combined with a direction, or if the mass differs from that of the Maxwellian.

    Examples
    --------
    >>> import transport as tp
    >>> gas = tp.Gas(density=1e20, speed=tp.Maxwellian(temperature=300, mass=4.65e-26))
    >>> gas.amount(tp.Box(size=0.5))
    1.25e+19
    >>> gas.mass  # [kg]
    4.65e-26
    """

    density: float | None = None
    speed: float | SpeedDistribution | None = None
    direction: OptionalVectorField = None
    number: float | None = None
    mass: float | None = None

    rates = ("density",)
    shapes = (Box, Sphere, Cloud, Point)
    cure = "enclose it in a Box"
    needs_whole = True
    fills_volume = True

    @property
    def law(self) -> str:
        return "isotropic" if self.direction is None else "beam"

    def __post_init__(self) -> None:
        self._coerce_particles()
        if self.direction is not None:
            coerce_direction(self, "direction")
        if not isinstance(self.speed, SpeedDistribution):
            coerce_nonnegative(self, "speed")
        elif self.direction is None and self.speed.is_signed:
            refuse(
                self,
                f"speed must not be negative without a direction, got {short_repr(self.speed)};"
                " add direction=...",
            )
        elif self.direction is not None and self.speed.has_drift:
            cure = "leave out direction, or include the drift in a SpeedTable along it"
            refuse(self, f"direction cannot be combined with a drift, got {short_repr(self.speed)}; {cure}")

    def amount(
        self, shape: Shape, duration: float | None = None, pulse: Pulse | None = None, is_back: bool = False
    ) -> float:
        """Return the number of particles.

        Parameters
        ----------
        shape : Shape
            Shape of the source; its volume is used with a `density`.
        duration, pulse, is_back
            Not used.

        Returns
        -------
        float
            Number of particles.
        """
        return self.density * shape.volume if self.number is None else self.number


@scene_object
class Effusive(ParticleEmission):
    """Effusion: particles that a gas behind a surface would send through it.

    Directions follow the cosine law, speeds are weighted by the speed. Give exactly one of `density`,
    `exitance` and `number`.

    Parameters
    ----------
    density : float, default None
        Number density of the gas behind the surface [m^-3].
    speed : float or SpeedDistribution
        Speed [m/s] or distribution of speeds of that gas. Required. A Maxwellian with drift is
        allowed on flat shapes only.
    exitance : float, default None
        Emitted particles per time and area [s^-1 m^-2].
    number : float, default None
        Number of particles in all, within the duration or pulse; needs a scene with a duration.
    mass : float, default that of the Maxwellian, else None
        Mass of a particle [kg].

    Raises
    ------
    SceneError
        If not exactly one amount is given, if speeds are not positive, or if the mass differs from that
        of the Maxwellian.

    Notes
    -----
    Allowed shapes: Rectangle, Disk, Triangle, Polygon, Sphere, Box, Cylinder, Cone, Paraboloid, Mesh. A gas
    at rest sends n <v> / 4 per area and time (Reif 1965, 7.11).

    Examples
    --------
    >>> import transport as tp
    >>> hole = tp.Effusive(density=1e20, speed=400.0)
    >>> hole.crossing_speed(tp.Disk(radius=0.01))  # a quarter of the speed [m/s]
    100.0
    """

    density: float | None = None
    speed: float | SpeedDistribution | None = None
    exitance: float | None = None
    number: float | None = None
    mass: float | None = None

    rates = ("density", "exitance")
    law = "lambertian"
    shapes = SURFACE_SHAPES
    cure = "use Gas for a Point"
    has_side = can_aim = True

    def __post_init__(self) -> None:
        self._coerce_particles()
        if not isinstance(self.speed, SpeedDistribution):
            coerce_positive(self, "speed")
        elif self.speed.is_signed:
            refuse(
                self,
                f"speed must not be negative, got {short_repr(self.speed)};"
                " use a table of speeds from 0 upwards",
            )

    def rate(self, shape: Shape, is_back: bool = False) -> float:
        """Return exitance times area, or density times area times `crossing_speed` (Reif 1965, 7.11).

        Returns
        -------
        float
            Particles per time [s^-1].
        """
        return (
            self.density * self.crossing_speed(shape, is_back) if self.exitance is None else self.exitance
        ) * shape.area

    def crossing_speed(self, shape: Shape, is_back: bool = False) -> float:
        """Return the one-way flux density divided by the density of the gas.

        Returns
        -------
        float
            Velocity [m/s]; for a gas at rest a quarter of the mean speed.
        """
        if not isinstance(self.speed, SpeedDistribution):
            return self.speed / 4
        if self.speed.has_drift and shape.is_flat:
            return self.speed.one_way_flux(self.speed.drift_through(shape, is_back))
        return self.speed.mean_speed / 4
