"""Detectors on one side of a shape, or of a named surface."""

import math
from collections.abc import Sequence

import numpy as np

from transport.geometry.flat import FlatShape
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.scene.bins import (
    DirectionCone,
    Directions,
    Positions,
    check_axes_size,
    coerce_bins,
    edges_of,
    is_above_horizon,
)
from transport.scene.materials import AnyMedium
from transport.scene.media import canonical_medium
from transport.scene.sides import AnyDetector, Sided
from transport.validation import (
    ConvertedAs,
    OptionalBinsField,
    OptionalNumbersField,
    SceneError,
    check_type,
    coerce_name,
    is_whole_number,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)

MAX_PATHS = 8  # media in which the path lengths of a scene are kept, at most: fields of a lane

__all__ = ["Detector", "DirectionCone", "Directions", "Positions"]


@scene_object
class Detector(Sided, AnyDetector):
    """A transparent detector: counts the particles that arrive at and leave one side of a shape.

    The shape may be its own, or that of a named surface. It affects no particle.

    Parameters
    ----------
    shape : Shape or str
        Shape with an area (not a Point or Cloud), or the name of a surface of the scene.
    name : str, default the surface's name
        Key of the detector in the result; required with a shape.
    side : {"front", "back", "outside", "inside"}, default "front"
        Side at which particles are counted. The normal points to the front. On closed shapes "outside"
        and "inside" are synonyms of "front" and "back".
    directions : Directions, default None
        Bins of direction, from `Directions(...)` or `Directions.cone(...)`. Arriving particles are
        binned by the direction that they come from.
    positions : Positions, default None
        Bins of position on the shape.
    times : int or sequence of float, default None
        Number of equal bins of the scene's duration, or increasing edges [s] within it. Needs a scene
        with a duration.
    speeds : sequence of float, default None
        Increasing edges [m/s] of bins of speed, zero or positive.
    via : str or sequence of str, default None
        Names of detectors or surfaces: count only particles that crossed all of these detectors, and
        arrived at or left all of these surfaces, at an earlier crossing.
    events : int or (int, float), default None
        A number n or a range (least, most): count only particles with that many events so far. An event
        is a scattering by a medium (a particle is scattered), or a reflection, refraction, diffuse
        transmission or passage of a lens at a surface. `events=0` is the direct part;
        `events=(1, math.inf)` the rest.
    moments : bool, default False
        Whether to add pressure and mean speed and energy.
    path_lengths : Medium, Grid or Vacuum, or a sequence of them, default None
        Media of the scene, in which to average the path lengths of the particles that arrive and leave:
        `mean_path_in` and `mean_path_out` [m], in this order. Media are compared by value; all detectors
        together name eight at most. Estimators "expected" and "backward" do not know paths.

    Raises
    ------
    SceneError
        If an argument is invalid, if there are more than 10 million bins, or if the bins do not fit the
        shape.

    Notes
    -----
    Quantities of the result are read as attributes of `result[name]`, such as `irradiance` [W m^-2] and
    `radiance` [W m^-2 sr^-1]. World-frame directions need a flat shape, a Box, a Slab or a whole Sphere.

    Examples
    --------
    >>> import transport as tp
    >>> plate = tp.Detector(tp.Disk(radius=0.1), name="plate", times=4)
    >>> plate.time_edges(2.0)  # [s]
    array([0. , 0.5, 1. , 1.5, 2. ])
    >>> tp.Detector("wall", side="inside").name
    'wall'

    A run of a point source over a black disk:

    >>> disk = tp.Surface(tp.Disk(radius=1.0), tp.Black(), name="disk")
    >>> lamp = tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0))
    >>> scene = tp.Scene(sources=[lamp], surfaces=[disk], detectors=[tp.Detector("disk")])
    >>> result = tp.simulate(scene, particles=1e4, seed=1, progress=False)
    >>> flux = result["disk"].flux_in  # exactly (1 - cos 45 degrees) / 2 = 0.14645 W
    >>> bool(abs(flux.value - 0.14645) < 0.02)
    True
    """

    shape: Shape | str
    name: ConvertedAs[str | None, str, str | None] = None
    side: str = "front"
    directions: Directions | DirectionCone | None = None
    positions: Positions | None = None
    times: OptionalBinsField = None
    speeds: OptionalNumbersField = None
    via: ConvertedAs[str | Sequence[str] | None, tuple[str, ...] | None, tuple[str, ...] | str | None] = None
    events: tuple[int, float] | int | None = None
    moments: bool = False
    path_lengths: ConvertedAs[
        AnyMedium | Sequence[AnyMedium] | None, tuple[AnyMedium, ...] | None, tuple[AnyMedium, ...] | None
    ] = None

    def __post_init__(self) -> None:
        coerce_name(self)
        check_type(self, "shape", (Shape, str), "a shape such as Disk(radius=...) or the name of a surface")
        if self.name is None:
            if not isinstance(self.shape, str):
                refuse(self, "name must be given with a shape, got None; write name='detector'")
            set_fields(self, name=self.shape)
        self._check_side()
        self._coerce_path_lengths()
        self._coerce_bins()
        self._coerce_via()
        self._coerce_events()
        check_type(self, "moments", bool, "True or False")
        if isinstance(self.shape, Shape):
            self.check_shape(self.shape)

    @property
    def options_of_crossings(self) -> dict[str, object]:
        """The options in use that only a particle's own crossing can score, not next-event estimation."""
        return {
            name: value for name in ("speeds", "moments", "path_lengths") if (value := getattr(self, name))
        }

    @property
    def options_of_the_past(self) -> dict[str, object]:
        """The options in use that depend on a particle's past or speed, unknown to backward histories."""
        past = {name: getattr(self, name) for name in ("times", "via", "events")}
        return {name: value for name, value in past.items() if value is not None} | self.options_of_crossings

    @property
    def long_sums(self) -> int:
        """Number of sums per bin beside weight, count and slant."""
        paths = 1 + len(self.path_lengths) if self.path_lengths else 0  # their weight, and one per medium
        return (3 if self.moments else 0) + paths

    def time_edges(self, duration: float | None) -> np.ndarray | None:
        """Return the edges of the time bins.

        Parameters
        ----------
        duration : float or None
            Duration of the scene [s].

        Returns
        -------
        array or None
            Edges [s]; None if there are no time bins.

        Raises
        ------
        SceneError
            If the scene has no duration, or if an edge lies beyond its end.
        """
        if self.times is None:
            return None
        if duration is None:
            cure = "write Scene(..., duration=...) in seconds"
            refuse(self, f"times need a clock, got {short_repr(self.times)} in a scene without one; {cure}")
        return edges_of(self, "times", self.times, 0.0, duration, "the scene's duration")

    def speed_edges(self) -> np.ndarray | None:
        """Return the edges of the speed bins.

        Returns
        -------
        array or None
            Edges [m/s]; None if there are no speed bins.
        """
        return None if self.speeds is None else np.array(self.speeds)

    def check_clock(self, duration: float | None) -> None:
        """Raise SceneError if the time bins do not fit the duration [s] of the scene."""
        self.time_edges(duration)

    def check_shape(self, shape: Shape) -> None:
        """Raise SceneError if this shape cannot have a detector with these bins."""
        if not shape.has_area:
            refuse(self, f"shape must have an area, got {shape}; use a small Disk or Sphere")
        self._check_side(shape)
        self._check_frame(shape)
        if self.positions is not None:
            try:
                self.positions.edges(shape)
            except SceneError as error:
                refuse(self, str(error))

    def _check_frame(self, shape: Shape) -> None:
        """Raise SceneError for world-frame directions on a shape where their bins cannot be normalized.

        There the mean of |cos(theta)| over a bin has no closed form, or it is 0 in every bin.
        """
        directions = self.directions
        is_world = isinstance(directions, DirectionCone) or getattr(directions, "frame", "local") == "world"
        # Raise for shapes whose world-frame bins have no closed form.
        if is_world and not (shape.is_flat or shape.is_convex):
            kind = "zone of a Sphere" if isinstance(shape, Sphere) else type(shape).__name__
            cure = "write Directions(mu=..., frame='local'), or use a flat shape or a whole Sphere"
            refuse(
                self,
                f"directions must be in the local frame on a {kind}, got {short_repr(directions)}; {cure}",
            )

        if is_world and shape.is_flat:
            self._check_horizon(shape)

    def _check_horizon(self, shape: FlatShape) -> None:
        """Raise SceneError if no world-frame direction bin is above the horizon of this side."""
        side = -1.0 if self.is_back else 1.0
        normal = tuple(side * x + 0.0 for x in shape.normal)
        if not is_above_horizon(self.directions, normal):
            must = f"directions need a bin above the horizon of its {self.side} (normal {normal})"
            cure = f"write side={'front' if self.is_back else 'back'!r}, or reverse directions or shape"
            refuse(self, f"{must}, got {short_repr(self.directions)}; {cure}")

    def _coerce_bins(self) -> None:
        if self.directions is not None:
            must = "Directions(mu=..., phi=...) or Directions.cone(...)"
            check_type(self, "directions", (Directions, DirectionCone), must)
        if self.positions is not None:
            check_type(self, "positions", Positions, "Positions(u=..., v=...)")
        coerce_bins(self, "times", least=0.0)
        coerce_bins(self, "speeds", least=0.0, may_count=False)
        check_axes_size(self, self, self.positions, self.directions)

    def _coerce_via(self) -> None:
        """Convert `via` to None or a tuple of distinct names; the scene checks that they exist."""
        if self.via is None:
            return
        names = (self.via,) if isinstance(self.via, str) else self.via
        is_list = isinstance(names, tuple | list) and len(names) > 0
        if not is_list or not all(isinstance(name, str) and name.strip() for name in names):
            refuse(
                self,
                f"via must be a name or a list of names, got {short_repr(self.via)}; write via='pinhole'",
            )
        if len(set(names)) < len(names):
            refuse(self, f"via must name each surface or detector once, got {short_repr(self.via)}")
        set_fields(self, via=tuple(map(str, names)))

    def _coerce_events(self) -> None:
        """Convert `events` to None or a range (least, most); a number n becomes (n, n)."""
        if self.events is None:
            return
        span = (self.events, self.events) if is_whole_number(self.events) else self.events
        is_pair = isinstance(span, tuple | list) and len(span) == 2 and is_whole_number(span[0])
        if (
            not is_pair
            or not (is_whole_number(span[1]) or span[1] == math.inf)
            or not 0 <= span[0] <= span[1]
        ):
            must = "a number of reflections, refractions and scatterings, 0 or more, or (least, most), rising"
            refuse(
                self,
                f"events must be {must}, got {short_repr(self.events)}; write events=(1, math.inf) for any",
            )
        least, most = span
        set_fields(self, events=(int(least), math.inf if most == math.inf else int(most)))

    def _coerce_path_lengths(self) -> None:
        """Convert `path_lengths` to None or a tuple of distinct media; the scene checks that it has them."""
        if self.path_lengths is None:
            return
        media = self.path_lengths if isinstance(self.path_lengths, tuple | list) else (self.path_lengths,)
        if not media or not all(isinstance(medium, AnyMedium) for medium in media):
            must = "path_lengths must be a medium of the scene or a list of them"
            refuse(self, f"{must}, got {short_repr(self.path_lengths)}; write path_lengths=[tissue]")
        media = tuple(map(canonical_medium, media))
        if len(set(media)) < len(media):
            refuse(self, f"path_lengths must name each medium once, got {short_repr(self.path_lengths)}")
        set_fields(self, path_lengths=media)
