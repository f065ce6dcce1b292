"""A surface: a shape with a material and the media on its sides."""

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
    """A surface: a shape with a material, a name and the media on its two sides.

    Parameters
    ----------
    shape : Shape
        Shape with an area (not a Point or Cloud).
    material : Material
        How the surface acts on particles.
    name : str, default None
        Name by which sources and detectors refer to the surface.
    front, back : Medium, Grid or Vacuum, default None
        Medium on the side that the normal points to, and on the other side. None: the medium that
        surrounds the surface there. `Vacuum()` means vacuum.
    outside, inside : Medium, Grid or Vacuum, default None
        Synonyms of `front` and `back`; both names can be read.

    Raises
    ------
    SceneError
        If the shape has no area, if the material is none or does not fit the shape, or if a side has two
        different media.

    Examples
    --------
    >>> import transport as tp
    >>> fog = tp.Medium(absorption=0.1, scattering=0.9)
    >>> cloud = tp.Surface(tp.Sphere(radius=1.0), tp.Transparent(), "cloud", inside=fog)
    >>> cloud.back == fog
    True
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
        """Store the medium of a side under both of its names."""
        for name in (side, alias):
            value = getattr(self, name)
            if value is not None:
                settled_medium(self, name, value)
        one, other = getattr(self, side), getattr(self, alias)
        if one is not None and other is not None and one != other:
            cure = f"{alias} is a synonym of {side}: leave one of them out"
            refuse(self, f"{side} and {alias} must not differ, got {shown(one)} and {shown(other)}; {cure}")
        medium = other if one is None else one
        store(self, **{side: medium, alias: medium})


def settled_medium(subject: object, name: str, value: object) -> AnyMedium:
    """Return the medium of a field; raise SceneError for anything else."""
    if isinstance(value, type) and issubclass(value, AnyMedium):
        refuse(
            subject,
            f"{name} must be an instance, got the class {value.__name__}; write {value.__name__}(...)",
        )
    if not isinstance(value, AnyMedium):
        must = "a medium such as Medium(absorption=...) or Vacuum()"
        refuse(subject, f"{name} must be {must}, got {shown(value)}")
    return value


def titled(surface: Surface, number: int) -> str:
    """Return how a message names a surface, given its number in the scene."""
    return f"Surface {surface.name!r}" if surface.name else f"surfaces[{number}]"
