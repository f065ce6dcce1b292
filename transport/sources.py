"""Sources: an emission that leaves a shape, or a surface known by its name."""

import math

from transport.emissions import Beam, Emission, Gas, Isotropic, Lambertian
from transport.shapes import FlatShape, Point, Shape
from transport.sides import Sided
from transport.validation import check_type, refuse, scene_object, shown
from transport.vectors import dot

__all__ = ["Beam", "Emission", "Gas", "Isotropic", "Lambertian", "Source"]

ALONG_PLANE = 1e-15  # the cosine that two rounded unit vectors at right angles may have


@scene_object
class Source(Sided):
    """An emission from a shape, or from the surface of that name.

    `side` is the one that a surface source emits from. With `aim`, a shape, directions are sampled only
    towards it, with the exact weight; the power stays that of the whole source.
    """

    shape: Shape | str
    emission: Emission
    aim: Shape | None = None
    side: str = "front"

    def __post_init__(self) -> None:
        check_type(self, "shape", (Shape, str), "a shape such as Disk(radius=...) or the name of a surface")
        check_type(self, "emission", Emission, "an emission such as Lambertian(radiance=...)")
        self._check_side()
        self._check_aim()
        if isinstance(self.shape, Shape):
            self.check_shape(self.shape)

    def power(self, shape: Shape) -> float:
        """Whole power [W] emitted from the resolved shape; for a Gas, its number of particles."""
        return self.emission.emitted(shape)

    def check_shape(self, shape: Shape) -> None:
        """Refuse a resolved shape that the emission cannot leave from as told."""
        kind, emission = type(shape).__name__, type(self.emission).__name__
        if not isinstance(shape, self.emission.shapes):
            possible = " or ".join(cls.__name__ for cls in self.emission.shapes)
            refuse(
                self, f"{emission} leaves from a {possible}, got shape={shown(shape)}; {self.emission.cure}"
            )
        is_surface_source = self.emission.has_side and not isinstance(shape, Point)
        if self.side != "front" and not is_surface_source:
            refuse(self, f"side means nothing for {emission} from a {kind}, got {self.side!r}; leave it out")
        self._check_side(shape)
        if isinstance(self.emission, Beam):
            self._check_beam(shape)
        if not 0 < self.power(shape) < math.inf:
            refuse(
                self,
                f"power must be positive and finite, got {self.power(shape)} from {shown(self.emission)}",
            )

    def _check_aim(self) -> None:
        if self.aim is None:
            return
        emission = type(self.emission).__name__
        if not self.emission.can_aim:
            refuse(
                self, f"aim goes with Lambertian or Isotropic, got {emission} and {shown(self.aim)}; drop aim"
            )
        check_type(self, "aim", Shape, "a shape such as Disk(radius=...)")
        if isinstance(self.aim, Point):
            refuse(self, f"aim must have an area, got {self.aim}; aim at a small Disk or Sphere")

    def _check_beam(self, shape: Shape) -> None:
        beam = self.emission
        if isinstance(shape, Point) and beam.irradiance is not None:
            refuse(self, f"irradiance needs an area, got {beam.irradiance} from a Point; write power=")
        if not isinstance(shape, FlatShape):
            return
        mu, kind = dot(beam.direction, shape.normal) * (-1 if self.is_back else 1), type(shape).__name__
        if abs(mu) <= ALONG_PLANE:
            refuse(self, f"direction must leave the plane of the {kind}, got {beam.direction}; tilt it")
        if mu < 0:
            other = "front" if self.is_back else "back"
            must = f"direction must leave the {self.side} (normal {shape.normal})"
            refuse(self, f"{must}, got {beam.direction}; write side={other!r} or turn it")
