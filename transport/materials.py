"""Materials: what a surface does with the particles that reach it; both sides are alike."""

from transport.shapes import Point, Shape
from transport.validation import check_type, refuse, scene_object, settle_fraction, settle_name


class Material:
    """What all materials share; not made itself."""


@scene_object
class Black(Material):
    """Absorbs everything."""


@scene_object
class Diffuse(Material):
    """Reflects the share `albedo` in [0, 1] with equal radiance in all directions; absorbs the rest."""

    albedo: float

    def __post_init__(self) -> None:
        settle_fraction(self, "albedo")


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
class Surface:
    """A shape with a material; its `name` lets sources and detectors refer to it."""

    shape: Shape
    material: Material
    name: str | None = None

    def __post_init__(self) -> None:
        settle_name(self)
        check_type(self, "shape", Shape, "a shape such as Disk(radius=...)")
        if isinstance(self.shape, Point):
            refuse(self, f"shape must have an area, got {self.shape}; a Point is for sources only")
        check_type(self, "material", Material, "a material such as Diffuse(0.5), made with its brackets")
