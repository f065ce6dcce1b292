"""Base class of all shapes: bounds, middle, extent, closed or open, finite or infinite."""

import math

from transport.validation import (
    refuse,
    shown,
)
from transport.vectors import Vector

ROUNDING = 8 * 2.0**-52  # relative tolerance: supports that differ only by rounding of coordinates are equal


class Shape:
    """Base class of all shapes; not instantiated itself."""

    is_closed = False
    is_infinite = False

    @property
    def middle(self) -> Vector:
        """Centre [m]."""
        return self.center

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest axis-aligned box that holds the shape."""
        return self._box(self._reach())

    def _box(self, reach: Vector) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] at distances `reach` from the middle."""
        reach = list(zip(self.middle, reach, strict=True))
        return tuple(c - r for c, r in reach), tuple(c + r for c, r in reach)

    @property
    def extent(self) -> float:
        """Half diagonal of the bounds [m]."""
        return math.hypot(*self._reach())

    def _check_size(self, *names: str) -> None:
        """Raise if area, volume or bounds overflow or underflow a double."""
        sizes = {"area": self.area} | ({"volume": self.volume} if self.is_closed else {})
        for quantity, size in sizes.items():
            if not 0 < size < math.inf:
                values = ", ".join(f"{name}={shown(getattr(self, name))}" for name in names)
                refuse(
                    self, f"{quantity} must be positive and finite, got {size} from {values}; change the unit"
                )
        if not all(map(math.isfinite, (*self.bounds[0], *self.bounds[1]))):
            refuse(self, f"bounds must be finite, got {self.bounds}; move center towards the origin")
