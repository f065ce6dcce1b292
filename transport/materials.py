"""Materials: what a surface does with the particles that reach it; both sides are alike."""

import math
from collections.abc import Mapping
from dataclasses import field

from transport.shapes import Cloud, Point, Shape
from transport.speeds import SpeedDistribution
from transport.validation import (
    as_float,
    check_type,
    refuse,
    scene_object,
    settle_fraction,
    settle_name,
    settle_positive,
    shown,
    store,
)

ROUNDING = 1e-9  # of the sum of shares


class Material:
    """What all materials share; not made itself."""


@scene_object
class Black(Material):
    """Absorbs everything."""


@scene_object
class Diffuse(Material):
    """Reflects the share `albedo` in [0, 1] with equal radiance in all directions; absorbs the rest.

    Particles keep their speed, or leave with `speed`, a number [m/s] or a distribution, of which they are
    drawn weighted by the speed, as from a gas of it behind the surface: thermal re-emission.
    """

    albedo: float
    speed: float | SpeedDistribution | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        settle_fraction(self, "albedo")
        if not isinstance(self.speed, SpeedDistribution):
            if self.speed is not None:
                settle_positive(self, "speed")
        elif self.speed.has_drift:
            refuse(self, f"speed must be that of a gas at rest, got {shown(self.speed)}; leave out its drift")
        elif self.speed.is_signed:
            refuse(self, f"speed must not be negative, got {shown(self.speed)}; write speeds from 0 on")


@scene_object
class Mirror(Material):
    """Reflects the share `reflectance` in [0, 1] specularly, absorbs the rest."""

    reflectance: float = 1.0

    def __post_init__(self) -> None:
        settle_fraction(self, "reflectance")


@scene_object
class Transparent(Material):
    """Lets everything pass: a surface to be metered or to emit from."""


@scene_object
class Mixture(Material):
    """Each particle that arrives meets one of the materials, with the probability of its share.

    parts: {material: share, ...}, shares that add up to 1, of Black, Diffuse, Mirror and Transparent; kept as
    (material, share) pairs in an order that does not depend on how they were written, without those of share
    0.
    """

    parts: tuple[tuple[Material, float], ...]

    def __post_init__(self) -> None:
        store(self, parts=tuple(sorted(self._checked(), key=lambda part: repr(part[0]))))

    def _checked(self) -> list[tuple[Material, float]]:
        pairs = list(self.parts.items()) if isinstance(self.parts, Mapping) else self.parts
        if not _are_pairs(pairs):
            cure = "write {Mirror(): 0.5, ...}"
            refuse(self, f"parts must be materials with their shares, got {shown(self.parts)}; {cure}")
        for material, share in pairs:
            if isinstance(material, Mixture):
                refuse(
                    self, f"parts must not hold another Mixture, got {shown(material)}; write its parts out"
                )
            if not isinstance(material, Material):
                refuse(self, f"parts must be materials such as Mirror(), got {shown(material)}")
            if as_float(share) is None or not 0 <= share <= 1:
                refuse(self, f"the share of {material} must be in [0, 1], got {shown(share)}")
        if len({material for material, _ in pairs}) < len(pairs):
            refuse(self, f"parts must differ from one another, got {shown(pairs)}; add their shares up")
        total = math.fsum(share for _, share in pairs)
        if not abs(total - 1) <= ROUNDING:
            refuse(
                self,
                f"shares must add up to 1, got {total} from {shown(pairs)}; add Black() for what is missing",
            )
        return [(material, as_float(share)) for material, share in pairs if share > 0]


def _are_pairs(pairs: object) -> bool:
    return isinstance(pairs, (tuple, list)) and all(
        isinstance(pair, tuple) and len(pair) == 2 for pair in pairs
    )


@scene_object
class Surface:
    """A shape with a material; its `name` lets sources and detectors refer to it."""

    shape: Shape
    material: Material
    name: str | None = None

    def __post_init__(self) -> None:
        settle_name(self)
        check_type(self, "shape", Shape, "a shape such as Disk(radius=...)")
        if isinstance(self.shape, (Point, Cloud)):
            kind = type(self.shape).__name__
            refuse(self, f"shape must have an area, got {self.shape}; a {kind} is for sources only")
        check_type(self, "material", Material, "a material such as Diffuse(0.5), made with its brackets")
