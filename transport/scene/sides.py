"""Base classes of detectors, and the side of a surface that detectors and sources use."""

from transport.geometry.shape import Shape
from transport.validation import check_one_of, refuse

IS_BACK = {"front": False, "back": True, "outside": False, "inside": True}
OTHER_SIDE = {"front": "back", "back": "front", "outside": "inside", "inside": "outside"}


class AnyDetector:
    """Base class of all detectors; not instantiated directly.

    Type checkers accept a list of several kinds of detector as a list of this class.
    """

    def check_clock(self, duration: float | None) -> None:
        """Raise SceneError if the detector does not work in a scene of this duration.

        Parameters
        ----------
        duration : float or None
            Duration of the scene [s]; None for a steady scene.
        """
        raise NotImplementedError


class Sided:
    """Base class of Source and Detector: the attribute `side`.

    The normal points to the front. For closed shapes "outside" and "inside" are synonyms of "front" and
    "back".
    """

    @property
    def is_back(self) -> bool:
        """Whether the side is the one that the normal points away from.

        Returns
        -------
        bool
        """
        return IS_BACK[self.side]

    def _check_side(self, shape: Shape | None = None) -> None:
        """Raise SceneError for an unknown side, and for the inside of a shape that is not closed."""
        check_one_of(self, "side", IS_BACK)
        if shape is not None and self.side in ("outside", "inside") and not shape.is_closed:
            cure = "back" if self.is_back else "front"
            kind = f"{type(shape).__name__} that is not closed"
            refuse(
                self, f"side must be 'front' or 'back' on a {kind}, got {self.side!r}; write side={cure!r}"
            )
