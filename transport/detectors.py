"""Detectors: what looks at which side of a shape, or of a surface known by its name."""

import math
from collections.abc import Sequence

import numpy as np

from transport.bins import (
    DirectionCone,
    Directions,
    Positions,
    check_number_of_bins,
    edges_of,
    settle_bins,
)
from transport.fields import ConvertedAs, OptionalBins, OptionalNumbers
from transport.horizon import is_in_sight
from transport.shapes import Box, Cloud, FlatShape, Point, Shape, Slab, Sphere
from transport.sides import AnyDetector, Sided
from transport.validation import (
    SceneError,
    check_type,
    is_count,
    refuse,
    scene_object,
    settle_name,
    shown,
    store,
)

__all__ = ["Detector", "DirectionCone", "Directions", "Positions"]


@scene_object
class Detector(Sided, AnyDetector):
    """A transparent meter on a shape of its own, or a meter on the surface of that name.

    It counts what arrives at and what leaves from one `side`, in all, or in bins of `directions` (arriving
    particles by the direction that they come from) and of `positions`, of `times` (edges [s] within the scene's
    duration, or a number of equal bins of it) and of `speeds` (edges [m/s]).
    `via`, a name or several: only particles that crossed those detectors, or met or left those surfaces, at an
    earlier crossing.  `events`, a number or (least, most): only those to which so much has happened until now, each
    time that a medium scattered them, or that a surface reflected, refracted or let them through diffusely, or by a lens.
    `moments` adds pressure and means of speed and energy.
    """

    shape: Shape | str
    name: ConvertedAs[str | None, str, str | None] = None
    side: str = "front"
    directions: Directions | DirectionCone | None = None
    positions: Positions | None = None
    times: OptionalBins = None
    speeds: OptionalNumbers = None
    via: ConvertedAs[str | Sequence[str] | None, tuple[str, ...] | None, tuple[str, ...] | str | None] = None
    events: tuple[int, float] | int | None = None
    moments: bool = False

    def __post_init__(self) -> None:
        settle_name(self)
        check_type(self, "shape", (Shape, str), "a shape such as Disk(radius=...) or the name of a surface")
        if self.name is None:
            if not isinstance(self.shape, str):
                refuse(self, "name must be given with a shape, got None; write name='meter'")
            store(self, name=self.shape)
        self._check_side()
        self._settle_bins()
        self._settle_via()
        self._settle_events()
        check_type(self, "moments", bool, "True or False")
        if isinstance(self.shape, Shape):
            self.check_shape(self.shape)

    def time_edges(self, duration: float | None) -> np.ndarray | None:
        """Edges [s] of the bins of time in a scene of that duration; None without them.

        Raises SceneError without a clock, and for edges beyond its end.
        """
        if self.times is None:
            return None
        if duration is None:
            cure = "write Scene(..., duration=...) in seconds"
            refuse(self, f"times need a clock, got {shown(self.times)} in a scene without one; {cure}")
        return edges_of(self, "times", self.times, 0.0, duration, "the scene's duration")

    def speed_edges(self) -> np.ndarray | None:
        """Edges [m/s] of the bins of speed; None without them."""
        return None if self.speeds is None else np.array(self.speeds)

    def check_clock(self, duration: float | None) -> None:
        """Refuse a duration that the bins of time do not fit into."""
        self.time_edges(duration)

    def check_shape(self, shape: Shape) -> None:
        """Refuse a resolved shape that cannot be looked at as told."""
        if isinstance(shape, (Point, Cloud)):
            refuse(self, f"shape must have an area, got {shape}; meter a small Disk or Sphere")
        self._check_side(shape)
        self._check_frame(shape)
        if self.positions is not None:
            try:
                self.positions.edges(shape)
            except SceneError as error:
                refuse(self, str(error))

    def _check_frame(self, shape: Shape) -> None:
        """Refuse directions in the world's frame where the mean of |cosθ| over a bin has no closed form, or is 0 in all."""
        directions = self.directions
        is_world = isinstance(directions, DirectionCone) or getattr(directions, "frame", "local") == "world"
        is_plain = isinstance(shape, FlatShape | Box | Slab) or (
            isinstance(shape, Sphere) and shape.is_closed
        )
        if is_world and not is_plain:
            kind = "zone of a Sphere" if isinstance(shape, Sphere) else type(shape).__name__
            cure = "write Directions(mu=..., frame='local'), or meter a flat shape or a whole Sphere"
            refuse(
                self, f"directions must be in the local frame on a {kind}, got {shown(directions)}; {cure}"
            )

        if is_world and isinstance(shape, FlatShape):
            self._check_horizon(shape)

    def _check_horizon(self, shape: FlatShape) -> None:
        """Refuse directions in the world's frame of which the side looked at can see none."""
        side = -1.0 if self.is_back else 1.0
        normal = tuple(side * x + 0.0 for x in shape.normal)
        if not is_in_sight(self.directions, normal):
            must = f"directions must be above the horizon of its {self.side}, which faces {normal}, in one bin at least"
            cure = f"write side={'front' if self.is_back else 'back'!r}, or turn the directions or the shape round"
            refuse(self, f"{must}, got {shown(self.directions)}; {cure}")

    def _settle_bins(self) -> None:
        if self.directions is not None:
            must = "Directions(mu=..., phi=...) or Directions.cone(...)"
            check_type(self, "directions", (Directions, DirectionCone), must)
        if self.positions is not None:
            check_type(self, "positions", Positions, "Positions(u=..., v=...)")
        settle_bins(self, "times", least=0.0)
        settle_bins(self, "speeds", least=0.0, may_count=False)
        check_number_of_bins(self, self, self.positions, self.directions)

    def _settle_via(self) -> None:
        """None, or a tuple of names, each once; whether there are such is known in the scene."""
        if self.via is None:
            return
        names = (self.via,) if isinstance(self.via, str) else self.via
        is_list = isinstance(names, tuple | list) and len(names) > 0
        if not is_list or not all(isinstance(name, str) and name.strip() for name in names):
            refuse(self, f"via must be a name or a list of names, got {shown(self.via)}; write via='pinhole'")
        if len(set(names)) < len(names):
            refuse(self, f"via must name each surface or detector once, got {shown(self.via)}")
        store(self, via=tuple(map(str, names)))

    def _settle_events(self) -> None:
        """None, or (least, most) events; a number n stands for (n, n)."""
        if self.events is None:
            return
        span = (self.events, self.events) if is_count(self.events) else self.events
        is_pair = isinstance(span, tuple | list) and len(span) == 2 and is_count(span[0])
        if not is_pair or not (is_count(span[1]) or span[1] == math.inf) or not 0 <= span[0] <= span[1]:
            must = "a number of reflections, refractions and scatterings, 0 or more, or (least, most) of them"
            refuse(
                self, f"events must be {must}, got {shown(self.events)}; write events=(1, math.inf) for any"
            )
        least, most = span
        store(self, events=(int(least), math.inf if most == math.inf else int(most)))
