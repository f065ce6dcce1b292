"""Where particles start, and nothing acts or is measured: a point, a cloud."""

import math

from transport.fields import Lengths, VectorField
from transport.normals import REACH
from transport.shapes.base import Shape
from transport.validation import (
    as_float,
    as_floats,
    refuse,
    scene_object,
    settle_vector,
    shown,
    store,
)
from transport.vectors import Vector


@scene_object(kw_only=True)
class Point(Shape):
    """A point, for sources only."""

    position: VectorField = (0.0, 0.0, 0.0)
    extent = 0.0

    def __post_init__(self) -> None:
        settle_vector(self, "position")

    @property
    def middle(self) -> Vector:
        """Its position [m]."""
        return self.position

    def _reach(self) -> Vector:
        return 0.0, 0.0, 0.0


@scene_object(kw_only=True)
class Cloud(Shape):
    """A Gaussian cloud, for a Gas only; `sigma` [m], one or along each axis, bounds 8.5 sigma away."""

    center: VectorField = (0.0, 0.0, 0.0)
    sigma: Lengths

    def __post_init__(self) -> None:
        settle_vector(self, "center")
        every = as_float(self.sigma)
        sigma = as_floats(self.sigma if every is None else (every,) * 3)
        if sigma is None or len(sigma) != 3 or min(sigma) < 0 or not 0 < max(sigma) < 1e300:
            must = f"one or three lengths, 0 or more and not all 0, got {shown(self.sigma)}"
            refuse(self, f"sigma must be {must}; a Point has no extent")
        store(self, sigma=sigma)

    @property
    def volume(self) -> float:
        """Volume [m^3] that holds as many particles at the density of the centre."""
        return (2 * math.pi) ** 1.5 * math.prod(self.sigma)

    def _reach(self) -> Vector:
        return tuple(REACH * length for length in self.sigma)
