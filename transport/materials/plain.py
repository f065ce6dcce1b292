"""Plain materials: what arrives is absorbed, scattered with equal radiance, mirrored or let pass."""

from dataclasses import field

from transport.materials.base import Material, settle_shares
from transport.speeds import SpeedDistribution
from transport.validation import refuse, scene_object, settle_positive, shown


@scene_object
class Black(Material):
    """Absorbs everything."""


@scene_object
class Diffuse(Material):
    """Reflects the share `albedo` with equal radiance in all directions, lets the share `transmission` through.

    What is let through leaves the other side with equal radiance in all directions too; the rest is absorbed.
    Shares in [0, 1], and so is their sum.  Reciprocal: f = albedo/pi on the side of arrival, transmission/pi
    on the other [sr^-1] (Lambert 1760).

    Particles keep their speed, or leave either side with `speed`, a number [m/s] or a distribution, of which
    they are drawn weighted by the speed, as from a gas of it behind the surface: thermal re-emission.
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
            refuse(self, f"speed must be that of a gas at rest, got {shown(self.speed)}; leave out its drift")
        elif self.speed.is_signed:
            refuse(self, f"speed must not be negative, got {shown(self.speed)}; write speeds from 0 on")


@scene_object
class Mirror(Material):
    """Reflects the share `reflectance` specularly, lets the share `transmission` go straight on.

    Shares in [0, 1], the same at every angle, and so is their sum; the rest is absorbed.
    """

    reflectance: float = 1.0
    transmission: float = 0.0

    def __post_init__(self) -> None:
        settle_shares(self, "reflectance", "transmission")


@scene_object
class Transparent(Material):
    """Lets everything pass: a surface to be metered or to emit from."""
