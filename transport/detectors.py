"""Detectors: what looks at which side of a shape, or of a surface known by its name."""

from transport.bins import DirectionCone, Directions, Positions, check_number_of_bins
from transport.shapes import Point, Shape
from transport.sides import Sided
from transport.validation import SceneError, check_type, refuse, scene_object, settle_name, store

__all__ = ["Detector", "DirectionCone", "Directions", "Positions"]


@scene_object
class Detector(Sided):
    """A transparent meter on a shape of its own, or a meter on the surface of that name.

    It counts what arrives at and what leaves from one `side`, in all, or in bins of `directions` (arriving
    particles by the direction that they come from) and of `positions`.
    """

    shape: Shape | str
    name: str | None = None
    side: str = "front"
    directions: Directions | DirectionCone | None = None
    positions: Positions | None = None

    def __post_init__(self) -> None:
        settle_name(self)
        check_type(self, "shape", (Shape, str), "a shape such as Disk(radius=...) or the name of a surface")
        if self.name is None:
            if not isinstance(self.shape, str):
                refuse(self, "name must be given with a shape, got None; write name='meter'")
            store(self, name=self.shape)
        self._check_side()
        if self.directions is not None:
            check_type(
                self,
                "directions",
                (Directions, DirectionCone),
                "Directions(mu=..., phi=...) or Directions.cone(...)",
            )
        if self.positions is not None:
            check_type(self, "positions", Positions, "Positions(u=..., v=...)")
        check_number_of_bins(self, self.positions, self.directions)
        if isinstance(self.shape, Shape):
            self.check_shape(self.shape)

    def check_shape(self, shape: Shape) -> None:
        """Refuse a resolved shape that cannot be looked at as told."""
        if isinstance(shape, Point):
            refuse(self, f"shape must have an area, got {shape}; meter a small Disk or Sphere")
        self._check_side(shape)
        if self.positions is not None:
            try:
                self.positions.edges(shape)
            except SceneError as error:
                refuse(self, str(error))
