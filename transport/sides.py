"""What detectors share with one another, and with sources: the side that is looked at or emitted from."""

from transport.shapes import Shape
from transport.validation import check_one_of, refuse

IS_BACK = {"front": False, "back": True, "outside": False, "inside": True}
OTHER_SIDE = {"front": "back", "back": "front", "outside": "inside", "inside": "outside"}


class AnyDetector:
    """What all detectors share; not made itself.  A list of several kinds is a list of these to type checkers."""

    def check_clock(self, duration: float | None) -> None:
        """Refuse a scene with this duration [s], None for a steady one, that the detector cannot look at."""
        raise NotImplementedError


class Sided:
    """What Source and Detector share: `side`, the front (where the normal points) or the back.

    For closed shapes "outside" and "inside" mean the same.
    """

    @property
    def is_back(self) -> bool:
        """Whether the side is the one that the normal points away from."""
        return IS_BACK[self.side]

    def _check_side(self, shape: Shape | None = None) -> None:
        """Refuse an unknown side, and the inside of a shape that encloses nothing."""
        check_one_of(self, "side", IS_BACK)
        if shape is not None and self.side in ("outside", "inside") and not shape.is_closed:
            cure = "back" if self.is_back else "front"
            kind = type(shape).__name__
            refuse(
                self, f"side must be 'front' or 'back' on a {kind}, got {self.side!r}; write side={cure!r}"
            )
