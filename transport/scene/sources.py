"""Sources: a shape (or a named surface) with an emission, an aim and a pulse."""

import math

from transport.geometry.shape import Cloud, Point, Shape
from transport.geometry.solid import Sphere
from transport.scene.emissions import Beam, Effusive, Emission, Gas, Isotropic, Lambertian
from transport.scene.pulses import BoxPulse, GaussianPulse, Instant, Pulse
from transport.scene.sides import Sided
from transport.scene.speeds import SpeedDistribution
from transport.validation import SceneError, check_type, refuse, scene_object, short_repr
from transport.vectors import dot

__all__ = [
    "Beam", "BoxPulse", "Effusive", "Emission", "Gas", "GaussianPulse", "Instant", "Isotropic", "Lambertian",
    "Source",
]  # fmt: skip

MAX_COSINE_IN_PLANE = 1e-15  # largest cosine between two rounded unit vectors at right angles


@scene_object
class Source(Sided):
    """A source: a shape that emits, or a surface of the scene that emits.

    Parameters
    ----------
    shape : Shape or str
        Where particles start. A string is the name of a surface of the scene.
        The emission limits the kinds of shape (see its documentation).
    emission : Lambertian, Isotropic, Beam, Gas or Effusive
        How much is emitted, in which directions and at which speeds.
    aim : Shape, default None
        Sample directions towards this shape only (importance sampling). Each particle carries the
        weight that keeps every mean; the amount stays that of the whole source. Allowed with
        `Lambertian`, `Isotropic` and `Effusive` without drift. The shape must have a finite area.
        What misses the aim is booked as "unsampled" in the energy balance.
    side : {"front", "back", "outside", "inside"}, default "front"
        Side of a surface from which particles leave. The normal points to the front. On closed
        shapes "outside" and "inside" are synonyms of "front" and "back".
    pulse : Instant, BoxPulse or GaussianPulse, default None
        When the source emits, within the scene's duration. None: uniformly over the duration.

    Raises
    ------
    SceneError
        If shape, emission, side, aim or pulse do not fit together.

    Examples
    --------
    >>> import transport as tp
    >>> lamp = tp.Source(tp.Disk(radius=0.5), tp.Lambertian(radiance=100.0))
    >>> round(lamp.amount(lamp.shape, duration=None), 3)  # [W]
    246.74
    >>> lamp.is_back
    False
    """

    shape: Shape | str
    emission: Emission
    aim: Shape | None = None
    side: str = "front"
    pulse: Pulse | None = None

    def __post_init__(self) -> None:
        check_type(self, "shape", (Shape, str), "a shape such as Disk(radius=...) or the name of a surface")
        check_type(self, "emission", Emission, "an emission such as Lambertian(radiance=...)")
        self._check_side()
        self._check_aim()
        self._check_pulse()
        if isinstance(self.shape, Shape):
            self.check_shape(self.shape)

    def amount(self, shape: Shape, duration: float | None) -> float:
        """Return the total amount that the source emits.

        Parameters
        ----------
        shape : Shape
            The source's shape; for a named surface, that surface's shape.
        duration : float or None
            Duration of the scene [s]; None for a steady scene.

        Returns
        -------
        float
            Energy [J] or number of particles; without a duration a rate [W] or [s^-1].
        """
        return self.emission.amount(shape, duration, self.pulse, self.is_back)

    def check_clock(self, duration: float | None) -> None:
        """Raise SceneError if the source needs a clock that the scene lacks, or if its pulse ends too late.

        Parameters
        ----------
        duration : float or None
            Duration of the scene [s]; None for a steady scene.
        """
        emission, kind = self.emission, type(self.emission).__name__
        if duration is None:
            needs = {
                "a Gas": isinstance(emission, Gas),
                f"a pulse such as {short_repr(self.pulse)}": self.pulse is not None,
                f"{kind}({emission.given}=...)": emission.is_whole,
            }
            for what, is_there in needs.items():
                if is_there:
                    raise SceneError(
                        f"Scene: duration must be given with {what}, got None; write duration=... in seconds"
                    )
        elif self.pulse is not None and not (self.pulse.first < duration and self.pulse.last <= duration):
            reach = f"from {self.pulse.first:g} to {self.pulse.last:g} s"
            refuse(
                self,
                f"pulse must lie within the duration, {duration:g} s, got {self.pulse}, which lasts {reach};"
                " make the duration longer",
            )

    def check_shape(self, shape: Shape) -> None:
        """Raise SceneError if the emission cannot leave this shape.

        Parameters
        ----------
        shape : Shape
            The source's shape; for a named surface, that surface's shape.
        """
        kind, emission = type(shape).__name__, type(self.emission).__name__
        self._check_kind(shape)
        is_surface_source = self.emission.has_side and not isinstance(shape, Point)
        if self.side != "front" and not is_surface_source:
            refuse(self, f"side has no effect for {emission} from a {kind}, got {self.side!r}; leave it out")
        self._check_side(shape)
        # Check what only some emissions require.
        match self.emission:
            case Beam():
                self._check_beam(shape)
            case Gas(density=density) if density is not None:
                self._check_density(shape)
            case Effusive(speed=SpeedDistribution(has_drift=True)):
                self._check_drift(shape)
        amount = self.amount(shape, None)
        if not 0 < amount < math.inf:
            what = "power" if self.emission.measured_in == "watts" else "number of particles"
            refuse(self, f"{what} must be positive and finite, got {amount} from {short_repr(self.emission)}")

    def _check_kind(self, shape: Shape) -> None:
        """Raise SceneError if the emission does not allow this kind of shape."""
        emission = type(self.emission).__name__
        *others, last = [cls.__name__ for cls in self.emission.shapes]
        got = f"{emission} leaves from a {', '.join(others)} or {last}, got shape={short_repr(shape)}"
        if shape.is_infinite:
            refuse(self, f"{got}, whose area is infinite; use a large Rectangle")
        if not isinstance(shape, self.emission.shapes):
            refuse(self, f"{got}; {self.emission.cure}")
        if self.emission.needs_whole and isinstance(shape, Sphere) and shape.is_zone:
            refuse(self, f"{got}, a zone; leave out mu_min and mu_max, or use Lambertian")

    def _check_aim(self) -> None:
        if self.aim is None:
            return
        emission = type(self.emission).__name__
        if not self.emission.can_aim:
            refuse(
                self,
                f"aim needs Lambertian, Isotropic or Effusive, got {emission} and {short_repr(self.aim)};"
                " drop aim",
            )
        if isinstance(self.emission.speed, SpeedDistribution) and self.emission.speed.has_drift:
            refuse(
                self,
                f"aim cannot be combined with a drift, got {short_repr(self.emission.speed)};"
                " leave one of them out",
            )
        check_type(self, "aim", Shape, "a shape such as Disk(radius=...)")
        if not self.aim.has_area:
            refuse(self, f"aim must have an area, got {self.aim}; use a small Disk or Sphere")
        if self.aim.is_infinite:
            refuse(self, f"aim must be finite, got {self.aim}; use a Rectangle in it, or leave out aim")

    def _check_pulse(self) -> None:
        if self.pulse is None:
            return
        check_type(self, "pulse", Pulse, "a pulse such as Instant() or BoxPulse(start, stop)")
        emission = self.emission
        if isinstance(emission, Gas):
            refuse(
                self, f"pulse has no effect for a Gas, which exists from time 0, got {self.pulse}; drop it"
            )
        if not (self.pulse.holds_rates or emission.is_whole):
            got = f"{emission.given}={short_repr(getattr(emission, emission.given))}"
            refuse(
                self,
                f"pulse {self.pulse} needs the whole amount, {emission.whole}=..., got {got};"
                " rates are allowed with a BoxPulse",
            )

    def _check_beam(self, shape: Shape) -> None:
        beam = self.emission
        if isinstance(shape, Point) and beam.irradiance is not None:
            refuse(self, f"irradiance needs an area, got {beam.irradiance} from a Point; write power=")
        if not shape.is_flat:
            return
        mu, kind = dot(beam.direction, shape.normal) * (-1 if self.is_back else 1), type(shape).__name__
        if abs(mu) <= MAX_COSINE_IN_PLANE:
            refuse(self, f"direction must not lie in the plane of the {kind}, got {beam.direction}; tilt it")
        if mu < 0:
            other = "front" if self.is_back else "back"
            must = f"direction must point out of the {self.side} (normal {shape.normal})"
            refuse(self, f"{must}, got {beam.direction}; write side={other!r} or reverse it")

    def _check_density(self, shape: Shape) -> None:
        if isinstance(shape, Point) or (isinstance(shape, Cloud) and 0 in shape.sigma):
            refuse(self, f"density needs a volume, got {self.emission.density} in {shape}; write number=")

    def _check_drift(self, shape: Shape) -> None:
        speed, kind = self.emission.speed, type(shape).__name__
        if not shape.is_flat:
            cure = "take a Rectangle or Disk"
            refuse(self, f"drift needs a flat shape, got {short_repr(speed.drift)} through a {kind}; {cure}")
        # Raise SceneError if the drift is out of range.
        speed.one_way_flux(speed.drift_through(shape, self.is_back))
