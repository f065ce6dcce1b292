"""Shapes for sources only: a point and a Gaussian cloud."""

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
    """Point, for sources only.

    Parameters
    ----------
    position : three floats, default (0, 0, 0)
        Position [m].

    Examples
    --------
    >>> import transport as tp
    >>> tp.Point(position=(0, 0, 1)).middle
    (0.0, 0.0, 1.0)
    """

    position: VectorField = (0.0, 0.0, 0.0)
    extent = 0.0

    def __post_init__(self) -> None:
        settle_vector(self, "position")

    @property
    def middle(self) -> Vector:
        """Position [m]."""
        return self.position

    def _reach(self) -> Vector:
        """Half extents [m] along the axes: 0."""
        return 0.0, 0.0, 0.0


@scene_object(kw_only=True)
class Cloud(Shape):
    """Gaussian cloud of positions, for the emission Gas only.

    Parameters
    ----------
    center : three floats, default (0, 0, 0)
        Mean position [m].
    sigma : float or three floats
        Standard deviation [m], one for all axes or one per axis; 0 or more, not all 0.

    Notes
    -----
    `bounds` lie 8.5 sigma from the centre, beyond which no position is sampled.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Cloud(sigma=1e-3).sigma
    (0.001, 0.001, 0.001)
    """

    center: VectorField = (0.0, 0.0, 0.0)
    sigma: Lengths

    def __post_init__(self) -> None:
        settle_vector(self, "center")
        every = as_float(self.sigma)
        sigma = as_floats(self.sigma if every is None else (every,) * 3)
        if sigma is None or len(sigma) != 3 or min(sigma) < 0 or not 0 < max(sigma) < 1e300:
            must = f"one or three lengths, 0 or more and not all 0, got {shown(self.sigma)}"
            refuse(self, f"sigma must be {must}; for a source without extent write Point(position=...)")
        store(self, sigma=sigma)

    @property
    def volume(self) -> float:
        """Effective volume (2 pi)^(3/2) sigma_x sigma_y sigma_z [m^3]: number over density at the centre."""
        return (2 * math.pi) ** 1.5 * math.prod(self.sigma)

    def _reach(self) -> Vector:
        """Half extents [m] along the axes."""
        return tuple(REACH * length for length in self.sigma)
