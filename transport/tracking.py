"""How histories are followed through media: choices that change errors and cost, never what comes out."""

from __future__ import annotations

import math

from transport.fields import VectorField
from transport.validation import (
    as_float,
    check_one_of,
    check_type,
    refuse,
    scene_object,
    settle_vector,
    shown,
    store,
)
from transport.vectors import Vector, dot

RAISED = 10.0  # times the share at which roulette is played: what a survivor weighs


@scene_object(kw_only=True)
class Splitting:
    """Importance that rises by `gain` from `start` to `end` [m], exponentially: histories that get there are split.

    Those that come back are thinned out as much.  For deep penetration take about the inverse of the transmission.
    Before `start` and beyond `end` it is constant.
    """

    start: VectorField
    end: VectorField
    gain: float

    def __post_init__(self) -> None:
        settle_vector(self, "start", "end")
        if self.start == self.end:
            refuse(
                self, f"end must not be the start, got {shown(self.end)} for both; put it where it gets deep"
            )
        gain = as_float(self.gain)
        if gain is None or not 1 < gain < math.inf:
            cure = "write about 1 / transmission; exchange start and end to turn it round"
            refuse(self, f"gain must be above 1 and finite, got {shown(self.gain)}; {cure}")
        store(self, gain=gain)

    def rise_at(self, place: Vector) -> float:
        """The logarithm of importance at a place [m], from 0 to that of the gain."""
        way, ahead = (tuple(p - q for p, q in zip(to, self.start, strict=True)) for to in (self.end, place))
        return min(max(dot(ahead, way) / dot(way, way), 0.0), 1.0) * math.log(self.gain)


@scene_object(kw_only=True)
class Tracking:
    """How histories are followed through media; every choice gives the same means.

    absorption: "analog", a history ends where it is absorbed, or "weighted", its weight falls along the way.
    roulette: a weighted history whose weight falls below this share of what it was born with dies, or goes on at ten
    times that share, at most as heavy as it was born, with the chance that keeps the mean; at collisions and at walls.
    The less, the better is known what comes from the deep (a result warns where survivors may be missing); the more,
    the faster runs what is reflected.
    forced: a copy of each history makes its first collision before the next boundary, with the exact weight, in every
    body that it comes through uncollided: for thin media, not for stacks of many layers.
    splitting: a Splitting for deep penetration.
    """

    absorption: str = "weighted"
    roulette: float = 1e-2
    forced: bool = False
    splitting: Splitting | None = None

    @property
    def survivors_weight(self) -> float:
        """What a history weighs that survives roulette, as a share of what it was born with."""
        return min(1.0, RAISED * self.roulette)

    def __post_init__(self) -> None:
        check_one_of(self, "absorption", ("analog", "weighted"))
        roulette = as_float(self.roulette)
        if roulette is None or not 0 < roulette <= 1:
            must = "roulette must be above 0 and at most 1"
            refuse(self, f"{must}, got {shown(self.roulette)}; without it a history would never end")
        store(self, roulette=roulette)
        check_type(self, "forced", bool, "True or False")
        if self.splitting is not None:
            check_type(self, "splitting", Splitting, "Splitting(start=..., end=..., gain=...) or None")
            if self.forced:
                refuse(
                    self,
                    "forced does not go with a splitting, got both; thin media need the one, deep ones the other",
                )
