"""A surface: a shape with a material."""

from dataclasses import field

from transport.materials.base import Material
from transport.materials.combined import check_material, simple_parts
from transport.materials.optical import ThinLens
from transport.media import Grid, Medium, Vacuum
from transport.shapes import Cloud, Disk, Point, Rectangle, Shape
from transport.validation import check_type, refuse, scene_object, settle_name, shown, store

AnyMedium = Medium | Grid | Vacuum


@scene_object
class Surface:
    """A shape with a material; its `name` lets sources and detectors refer to it.

    front, back: the media on the side that the normal points to and on the other; `outside` and `inside` are other
    words for the same, and either may be read.  A side left out (None) is in whatever surrounds the surface there;
    `Vacuum()` says vacuum.
    """

    shape: Shape
    material: Material
    name: str | None = None
    front: AnyMedium | None = None
    back: AnyMedium | None = None
    outside: AnyMedium | None = field(default=None, repr=False)
    inside: AnyMedium | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        settle_name(self)
        check_type(self, "shape", Shape, "a shape such as Disk(radius=...)")
        kind = type(self.shape).__name__
        if isinstance(self.shape, (Point, Cloud)):
            refuse(self, f"shape must have an area, got {self.shape}; a {kind} is for sources only")
        check_material(self, "material")
        has_lens = any(isinstance(part, ThinLens) for part in simple_parts(self.material))
        if has_lens and not isinstance(self.shape, (Disk, Rectangle)):
            refuse(self, f"a ThinLens must be on a Disk or a Rectangle, got a {kind}; put it on one of these")
        self._settle_side("front", "outside")
        self._settle_side("back", "inside")

    def _settle_side(self, side: str, alias: str) -> None:
        """The medium of a side under both of its names."""
        for name in (side, alias):
            value = getattr(self, name)
            if value is not None:
                settled_medium(self, name, value)
        one, other = getattr(self, side), getattr(self, alias)
        if one is not None and other is not None and one != other:
            cure = f"{alias} is another word for {side}: leave one of them out"
            refuse(self, f"{side} and {alias} must not differ, got {shown(one)} and {shown(other)}; {cure}")
        medium = other if one is None else one
        store(self, **{side: medium, alias: medium})


def settled_medium(subject: object, name: str, value: object) -> AnyMedium:
    """The medium of that field; SceneError where it is none."""
    if isinstance(value, type) and issubclass(value, AnyMedium):
        refuse(
            subject,
            f"{name} must be made with its brackets, got {value.__name__}; write {value.__name__}(...)",
        )
    if not isinstance(value, AnyMedium):
        must = "a medium such as Medium(absorption=...) or Vacuum()"
        refuse(subject, f"{name} must be {must}, got {shown(value)}")
    return value


def titled(surface: Surface, number: int) -> str:
    """What a message calls the surface of that number in its scene."""
    return f"Surface {surface.name!r}" if surface.name else f"surfaces[{number}]"
