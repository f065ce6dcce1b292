"""A surface: a shape with a material."""

from transport.materials.base import Material
from transport.materials.combined import simple_parts
from transport.materials.optical import ThinLens
from transport.shapes import Cloud, Disk, Point, Rectangle, Shape
from transport.validation import check_type, refuse, scene_object, settle_name


@scene_object
class Surface:
    """A shape with a material; its `name` lets sources and detectors refer to it."""

    shape: Shape
    material: Material
    name: str | None = None

    def __post_init__(self) -> None:
        settle_name(self)
        check_type(self, "shape", Shape, "a shape such as Disk(radius=...)")
        kind = type(self.shape).__name__
        if isinstance(self.shape, (Point, Cloud)):
            refuse(self, f"shape must have an area, got {self.shape}; a {kind} is for sources only")
        check_type(self, "material", Material, "a material such as Diffuse(0.5), made with its brackets")
        has_lens = any(isinstance(part, ThinLens) for part in simple_parts(self.material))
        if has_lens and not isinstance(self.shape, (Disk, Rectangle)):
            refuse(self, f"a ThinLens must be on a Disk or a Rectangle, got a {kind}; put it on one of these")
