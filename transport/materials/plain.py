"""Plain materials: black, diffuse, mirror and transparent."""

from dataclasses import field

from transport.materials.base import Material, settle_shares
from transport.speeds import SpeedDistribution
from transport.validation import refuse, scene_object, settle_positive, shown


@scene_object
class Black(Material):
    """A surface that absorbs everything.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Surface(tp.Disk(radius=1.0), tp.Black(), name="floor").material
    Black()
    """


@scene_object
class Diffuse(Material):
    """A Lambertian surface: reflects and transmits diffusely, absorbs the rest.

    Parameters
    ----------
    albedo : float
        Reflected fraction, in [0, 1].
    transmission : float, default 0
        Transmitted fraction, in [0, 1], which leaves the other side diffusely; albedo + transmission <= 1.
    speed : float or SpeedDistribution, default None
        Keyword only. None: particles keep their speed. Otherwise thermal re-emission: particles leave
        either side with this speed [m/s], or with speeds drawn from the distribution, weighted by the
        speed, as from a gas behind the surface. Not for watts.

    Raises
    ------
    SceneError
        If a fraction is out of range, or if speeds drift or are negative.

    Notes
    -----
    f = albedo/pi on the side of arrival and transmission/pi on the other [sr^-1] (Lambert 1760); reciprocal.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Diffuse(0.8).albedo
    0.8
    >>> wall = tp.Diffuse(1.0, speed=tp.Maxwellian(temperature=300, mass=4.65e-26))
    """

    albedo: float
    transmission: float = 0.0
    speed: float | SpeedDistribution | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        settle_shares(self, "albedo", "transmission")
        if not isinstance(self.speed, SpeedDistribution):
            if self.speed is not None:
                settle_positive(self, "speed")
        elif self.speed.has_drift:
            refuse(self, f"speed must be that of a gas at rest, got {shown(self.speed)}; leave out the drift")
        elif self.speed.is_signed:
            refuse(self, f"speed must not be negative, got {shown(self.speed)}; write speeds from 0 upwards")


@scene_object
class Mirror(Material):
    """An ideal mirror: reflects specularly, transmits straight on, absorbs the rest.

    Parameters
    ----------
    reflectance : float, default 1
        Reflected fraction, in [0, 1], the same at every angle.
    transmission : float, default 0
        Fraction that continues in a straight line, in [0, 1]; reflectance + transmission <= 1.

    Raises
    ------
    SceneError
        If a fraction is out of range.

    Examples
    --------
    >>> import transport as tp
    >>> beam_splitter = tp.Mirror(reflectance=0.5, transmission=0.5)
    """

    reflectance: float = 1.0
    transmission: float = 0.0

    def __post_init__(self) -> None:
        settle_shares(self, "reflectance", "transmission")


@scene_object
class Transparent(Material):
    """A surface that transmits everything unchanged; for detectors, sources and bodies of a medium.

    Examples
    --------
    >>> import transport as tp
    >>> fog = tp.Surface(tp.Box(size=1.0), tp.Transparent(), inside=tp.Medium(scattering=0.5))
    """
