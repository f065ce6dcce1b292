"""What all shapes answer: area, bounds, middle, extent and whether they are closed."""

import math

from transport.validation import (
    refuse,
    shown,
)
from transport.vectors import Vector


class Shape:
    """What all shapes share; not made itself."""

    is_closed = False

    @property
    def middle(self) -> Vector:
        """Centre [m]."""
        return self.center

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """Lower and upper corner [m] of the smallest box along the axes that holds the shape."""
        reach = list(zip(self.middle, self._reach(), strict=True))
        return tuple(c - r for c, r in reach), tuple(c + r for c, r in reach)

    @property
    def extent(self) -> float:
        """Half diagonal of its bounds [m]."""
        return math.hypot(*self._reach())

    def _check_size(self, *names: str) -> None:
        """Refuse lengths whose area, volume or bounds leave the range of doubles."""
        sizes = {"area": self.area} | ({"volume": self.volume} if self.is_closed else {})
        for quantity, size in sizes.items():
            if not 0 < size < math.inf:
                values = ", ".join(f"{name}={shown(getattr(self, name))}" for name in names)
                refuse(
                    self, f"{quantity} must be positive and finite, got {size} from {values}; change the unit"
                )
        if not all(map(math.isfinite, (*self.bounds[0], *self.bounds[1]))):
            refuse(self, f"bounds must be finite, got {self.bounds}; move center towards the origin")
