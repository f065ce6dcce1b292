"""Tracking of histories through media: options that change errors and cost, but no mean."""

from __future__ import annotations

import math

from transport.validation import (
    VectorField,
    as_float,
    check_one_of,
    check_type,
    coerce_vector,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)
from transport.vectors import Vector, dot

SURVIVOR_FACTOR = 10.0  # weight of a survivor over the weight below which roulette is played


@scene_object(kw_only=True)
class Splitting:
    """Geometric splitting: importance that rises exponentially from `start` to `end`.

    Histories that go towards the end are split, those that come back are thinned by Russian roulette. Before
    `start` and beyond `end` the importance is constant. All parameters are keywords.

    Parameters
    ----------
    start : vector
        Point [m] where the importance is 1.
    end : vector
        Point [m] where the importance is `gain`.
    gain : float
        Ratio of importance, above 1; for deep penetration about the inverse of the transmission, not more.

    Raises
    ------
    SceneError
        If the points are equal, or if the gain is not above 1 and finite.

    Examples
    --------
    >>> import transport as tp
    >>> split = tp.Splitting(start=(0, 0, 0), end=(0, 0, -20), gain=1e8)
    >>> round(split.rise_at((0, 0, -10)), 4)  # log(1e8) / 2
    9.2103
    """

    start: VectorField
    end: VectorField
    gain: float

    def __post_init__(self) -> None:
        coerce_vector(self, "start", "end")
        if self.start == self.end:
            refuse(
                self,
                f"end must not be the start, got {short_repr(self.end)} for both; put it at the far side",
            )
        gain = as_float(self.gain)
        if gain is None or not 1 < gain < math.inf:
            cure = "write about 1 / transmission; exchange start and end to reverse it"
            refuse(self, f"gain must be above 1 and finite, got {short_repr(self.gain)}; {cure}")
        set_fields(self, gain=gain)

    def rise_at(self, place: Vector) -> float:
        """Return the logarithm of the importance at a point.

        Parameters
        ----------
        place : vector
            Point [m].

        Returns
        -------
        float
            From 0 to log(gain).
        """
        offset, ahead = (
            tuple(p - q for p, q in zip(to, self.start, strict=True)) for to in (self.end, place)
        )
        return min(max(dot(ahead, offset) / dot(offset, offset), 0.0), 1.0) * math.log(self.gain)


@scene_object(kw_only=True)
class Tracking:
    """Options of tracking through media; none of them changes a mean, only errors and cost.

    All parameters are keywords.

    Parameters
    ----------
    absorption : {"weighted", "analog"}, default "weighted"
        "weighted": absorption reduces the weight along the path. "analog": a history ends where it is
        absorbed.
    roulette : float, default 0.01
        Russian roulette in weighted tracking, in (0, 1]: a history whose weight falls below this share of
        its birth weight ends, or continues at ten times the share (at most at its birth weight), with the
        probability that keeps the mean. Played at collisions and at walls. A lower share estimates deep
        scattering better (a result warns if survivors may be missing); a higher one is faster with
        reflections.
    forced : bool, default False
        Forced first collision: in every body that a history enters uncollided, a copy of it collides
        before the next boundary, with the exact weight. For thin media, not for stacks of many layers.
    splitting : Splitting, default None
        For deep penetration; not together with `forced`.

    Raises
    ------
    SceneError
        If an argument is invalid.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Tracking(roulette=1e-3).survivors_weight
    0.01
    """

    absorption: str = "weighted"
    roulette: float = 1e-2
    forced: bool = False
    splitting: Splitting | None = None

    @property
    def survivors_weight(self) -> float:
        """Weight of a history that survives roulette, relative to its birth weight.

        Returns
        -------
        float
        """
        return min(1.0, SURVIVOR_FACTOR * self.roulette)

    def __post_init__(self) -> None:
        check_one_of(self, "absorption", ("analog", "weighted"))
        roulette = as_float(self.roulette)
        if roulette is None or not 0 < roulette <= 1:
            must = "roulette must be above 0 and at most 1"
            refuse(self, f"{must}, got {short_repr(self.roulette)}; without it a history would never end")
        set_fields(self, roulette=roulette)
        check_type(self, "forced", bool, "True or False")
        if self.splitting is not None:
            check_type(self, "splitting", Splitting, "Splitting(start=..., end=..., gain=...) or None")
            if self.forced:
                refuse(
                    self,
                    "forced cannot be combined with splitting; use forced in thin media,"
                    " splitting in deep ones",
                )
