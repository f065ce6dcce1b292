"""Bins of directions, positions, times and speeds: their edges, sizes and checks."""

import math
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from transport.geometry.shape import Shape
from transport.statistics.axes import SHAPE_COORDINATES
from transport.validation import (
    Bins,
    BinsParameter,
    OptionalBinsField,
    VectorField,
    as_float,
    as_floats,
    check_one_of,
    coerce_direction,
    degrees_hint,
    is_whole_number,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)
from transport.vectors import Vector, dot

Range = tuple[float, float]

MAX_BINS_PER_AXIS = 1_000_000  # per axis; more would be a mistake
MAX_BINS_PER_DETECTOR = 10_000_000  # per detector
# bytes of sums per bin, side and thread; bytes per bin and batch; usual number of batches
SUM_BYTES_PER_BIN, BATCH_BYTES_PER_BIN, TYPICAL_BATCHES = 32, 14, 8
PI = math.pi
MIN_COSINE_WIDTH = 2.0**-43  # width of a bin in cosine: rounding moves 0.1 % of it across its edges
DIRECTION_RANGES: dict[str, dict[str, Range]] = {
    "local": {"mu": (0.0, 1.0), "theta": (0.0, PI / 2), "phi": (0.0, 2 * PI)},
    "world": {"mu": (-1.0, 1.0), "theta": (0.0, PI), "phi": (0.0, 2 * PI)},
}
SPHERE_RANGES: dict[str, Range] = {"mu": (-1.0, 1.0), "phi": (0.0, 2 * PI)}


@scene_object(kw_only=True)
class Directions:
    """Bins of direction: each axis a number of equal bins or increasing edges.

    Give at least one of `mu`, `theta` and `phi`; `mu` and `theta` exclude each other.

    Parameters
    ----------
    mu : int or sequence of float, default None
        Cosine of the polar angle; within [0, 1] in the local frame, [-1, 1] in the world frame.
    phi : int or sequence of float, default None
        Azimuth [rad]; a number of bins covers [0, 2 pi]. Edges lie within [-2 pi, 2 pi] and span at most
        one turn: (-pi/4, pi/4) is a sector across phi = 0.
    theta : int or sequence of float, default None
        Polar angle [rad]; within [0, pi/2] in the local frame, [0, pi] in the world frame.
    frame : {"local", "world"}, default "local"
        "local": theta is measured from the normal of the detector's side, phi from e_u towards e_v.
        "world": theta is measured from +z, phi about +z from +x.

    Raises
    ------
    SceneError
        If no axis is given, if edges are out of range, or if a bin is narrower than 2^-43 in cos(theta).

    Notes
    -----
    Radiance is undefined in world-frame bins below the horizon of the detector's side. Directions of which
    all bins are below the horizon raise SceneError.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Directions(mu=4).edges()["mu"]
    array([0.  , 0.25, 0.5 , 0.75, 1.  ])
    >>> tp.Directions(theta=(0, 30 * tp.deg, 90 * tp.deg)).edges()["theta"].round(3)  # [rad]
    array([0.   , 0.524, 1.571])
    """

    mu: OptionalBinsField = None
    phi: OptionalBinsField = None
    theta: OptionalBinsField = None
    frame: str = "local"

    def __post_init__(self) -> None:
        check_one_of(self, "frame", DIRECTION_RANGES)
        if self.mu is not None and self.theta is not None:
            refuse(
                self,
                f"mu and theta exclude each other, got mu={short_repr(self.mu)},"
                f" theta={short_repr(self.theta)}",
            )
        _coerce_given_axes(self, "mu", "theta", "phi")
        check_axes_size(self, self)
        _check_cosine_widths(self, self.edges())

    @staticmethod
    def cone(*values: object, **named: object) -> "DirectionCone":
        """Return one bin: the directions within `half_angle` of `axis`, in the world frame.

        Parameters
        ----------
        axis : vector
            Axis of the cone, of any length except 0.
        half_angle : float
            Half angle of the cone [rad], in (0, pi/2].

        Returns
        -------
        DirectionCone

        Examples
        --------
        >>> import transport as tp
        >>> tp.Directions.cone((0, 0, 2), half_angle=0.1)
        DirectionCone(axis=(0.0, 0.0, 1.0), half_angle=0.1)
        """
        return DirectionCone(*values, **named)

    @staticmethod
    def sphere(*values: object, **named: object) -> "DirectionSphere":
        """Return bins over all directions of flight, for a VolumeDetector.

        Parameters
        ----------
        mu : int or sequence of float, default 8
            Bins of the cosine to `axis`, within [-1, 1].
        phi : int or sequence of float, default 16
            Bins of the azimuth about `axis` [rad].
        axis : vector, default (0, 0, 1)
            Polar axis.

        Returns
        -------
        DirectionSphere

        Examples
        --------
        >>> import transport as tp
        >>> tp.Directions.sphere(mu=2, phi=1).solid_angles().round(4)  # [sr]
        array([[6.2832],
               [6.2832]])
        """
        return DirectionSphere(*values, **named)

    def edges(self) -> dict[str, np.ndarray]:
        """Return the edges of each binned axis.

        Returns
        -------
        dict of str to array
            "mu" [1] or "theta" [rad], and "phi" [rad].
        """
        return _edges_by_axis(
            self, _extend_phi_range(self, DIRECTION_RANGES[self.frame]), f"frame {self.frame!r}"
        )


@scene_object
class DirectionCone:
    """One bin of directions: a cone about an axis in the world frame, made by `Directions.cone`.

    Parameters
    ----------
    axis : vector
        Axis of the cone, of any length except 0; stored as a unit vector.
    half_angle : float
        Half angle of the cone [rad], in (0, pi/2].
    """

    axis: VectorField
    half_angle: float

    written = "Directions.cone"

    def __post_init__(self) -> None:
        coerce_direction(self, "axis")
        angle = as_float(self.half_angle)
        if angle is None or not 0 < angle <= PI / 2:
            refuse(
                self,
                "half_angle must be in (0, pi/2] rad, got"
                f" {short_repr(self.half_angle)}{degrees_hint(angle)}",
            )
        set_fields(self, half_angle=angle)

    def edges(self) -> dict[str, np.ndarray]:
        """Return the edges of the bin.

        Returns
        -------
        dict of str to array
            "theta" [rad], measured from the axis.
        """
        return {"theta": np.array([0.0, self.half_angle])}


@scene_object
class DirectionSphere:
    """Bins over all directions of flight, made by `Directions.sphere`.

    Parameters
    ----------
    mu : int or sequence of float, default 8
        Number of equal bins of the cosine to `axis`, or increasing edges within [-1, 1].
    phi : int or sequence of float, default 16
        Number of equal bins of the azimuth about `axis`, or increasing edges [rad].
    axis : vector, default (0, 0, 1)
        Polar axis, of any length except 0; stored as a unit vector.

    Notes
    -----
    For the default axis phi is measured from +x. For another axis it is measured from e_u towards e_v: e_v is
    the component of +y normal to the axis (of +z if the axis is along y), and e_u = e_v x axis.
    """

    mu: OptionalBinsField = 8
    phi: OptionalBinsField = 16
    axis: VectorField = (0.0, 0.0, 1.0)

    written = "Directions.sphere"

    def __post_init__(self) -> None:
        _coerce_given_axes(self, "mu", "phi")
        coerce_direction(self, "axis")
        check_axes_size(self, self)
        _check_cosine_widths(self, self.edges())

    def edges(self) -> dict[str, np.ndarray]:
        """Return the edges of each binned axis.

        Returns
        -------
        dict of str to array
            "mu" [1] and "phi" [rad].
        """
        return _edges_by_axis(self, _extend_phi_range(self, SPHERE_RANGES), "all directions")

    def solid_angles(self) -> np.ndarray:
        """Return the solid angle of each bin.

        Returns
        -------
        array
            Solid angles [sr], shape (mu bins, phi bins); an axis without bins is omitted.
        """
        edges = self.edges()
        cosines, turns = (edges.get(name, np.array(span)) for name, span in SPHERE_RANGES.items())
        angles = np.outer(np.diff(cosines), np.diff(turns))
        return angles.reshape([len(bounds) - 1 for bounds in edges.values()])


POSITION_NAMES = {
    axis: tuple(name for name, each in SHAPE_COORDINATES.items() if each.column == axis) for axis in "uv"
}
SYNONYMS = tuple(name for names in POSITION_NAMES.values() for name in names)


class _Unchanged:
    """What a synonym of a coordinate reads as: the bins are stored once, as `u` and `v`.

    `dataclasses.replace` passes it on for each synonym that it was not given.
    """

    def __init__(self, positions: "Positions") -> None:
        self.positions = positions

    def __repr__(self) -> str:
        return f"<another name of u or v of {self.positions!r}>"


class _Synonym:
    """Another name of a coordinate, for the constructor only; None where it is not given."""

    def __get__(self, positions: "Positions | None", owner: type) -> _Unchanged | None:
        return None if positions is None else _Unchanged(positions)


def _synonym() -> Any:
    return _Synonym()


@scene_object(kw_only=True)
class Positions:
    """Bins of position in a shape's own coordinates u and v.

    Give at least one of them, as u or v or by the names that they have on the shape, such as
    ``Positions(radius=10)`` of a Disk.

    Parameters
    ----------
    u, v : int or sequence of float, default None
        Number of equal bins, or increasing edges [m or rad].
    x, radius, height, polar_angle : int or sequence of float, default None
        Other names of u. Positions with equal bins are equal, whatever the names.
    y, azimuth : int or sequence of float, default None
        Other names of v.

    Raises
    ------
    SceneError
        If no coordinate or one under two names is given; with the detector's shape, if the shape has no
        coordinate of that name.

    Notes
    -----
    ========================== ========================================= =============
    Shape                      u                                         v
    ========================== ========================================= =============
    Rectangle                  x, from the centre along e_u [m]          y, along e_v [m]
    Disk                       radius [m]                                azimuth [rad]
    Sphere or zone             polar_angle from the axis [rad]           azimuth [rad]
    Cylinder, Cone, Paraboloid height along the axis from `center` [m]   azimuth [rad]
    ========================== ========================================= =============

    Azimuth runs from e_u towards e_v. Other shapes have no coordinates. The bins are read as
    `u` and `v`, and results have the axes u and v, by whichever name the bins were given.

    Examples
    --------
    >>> import transport as tp
    >>> rings = tp.Positions(radius=2)
    >>> rings.edges(tp.Disk(radius=1.0))["u"]  # [m]
    array([0. , 0.5, 1. ])
    >>> rings.areas(tp.Disk(radius=1.0)).round(3)  # [m^2]
    array([0.785, 2.356])
    """

    u: OptionalBinsField = None
    v: OptionalBinsField = None
    x: BinsParameter = _synonym()
    radius: BinsParameter = _synonym()
    height: BinsParameter = _synonym()
    polar_angle: BinsParameter = _synonym()
    y: BinsParameter = _synonym()
    azimuth: BinsParameter = _synonym()
    _names: ClassVar[tuple[str, ...]]  # those of u and v as they were given, of each object

    def __post_init__(self, *synonyms: object) -> None:
        given = dict(zip(SYNONYMS, synonyms, strict=True))
        replaced = next((each.positions for each in synonyms if isinstance(each, _Unchanged)), None)
        names = []
        for place, (name, others) in enumerate(POSITION_NAMES.items()):
            coerce_bins(self, name)
            bins, called = getattr(self, name), name
            values = {each: as_bins(self, each, given[each]) for each in others if _is_given(given[each])}
            # Carry over what `dataclasses.replace` leaves, unless a synonym is new.
            if replaced is not None and bins == getattr(replaced, name):
                called = replaced._names[place]
                bins = None if any(given[each] is None for each in others) else bins
            elif bins is not None:
                values = {name: bins} | values
            if len(set(values.values())) > 1 or len(values.keys() - {name}) > 1:
                refuse(
                    self,
                    f"{' and '.join(values)} are one coordinate, got {short_repr(values)}; give one of them",
                )
            if values:
                called, bins = list(values.items())[-1]
            set_fields(self, **{name: bins})
            names.append(called)
        set_fields(self, _names=tuple(names))
        _coerce_given_axes(self, "u", "v")
        check_axes_size(self, self)

    def __repr__(self) -> str:
        named = zip(self._names, (self.u, self.v), strict=True)
        return f"Positions({', '.join(f'{name}={bins!r}' for name, bins in named if bins is not None)})"

    def edges(self, shape: Shape) -> dict[str, np.ndarray]:
        """Return the edges of each binned axis on a shape.

        Returns
        -------
        dict of str to array
            "u" and "v" [m or rad].
        """
        return _edges_by_axis(self, self._ranges(shape), type(shape).__name__)

    def units(self, shape: Shape) -> dict[str, str]:
        """Return the units of the coordinates on a shape.

        Returns
        -------
        dict of str to str
            "m" or "rad" for "u" and "v".
        """
        return {name: unit for name, (_, _, unit) in shape.coordinates().items()}

    def areas(self, shape: Shape) -> np.ndarray:
        """Return the area of each bin on a shape.

        Returns
        -------
        array
            Areas [m^2], shape (u bins, v bins); an axis without bins is omitted.
        """
        edges = self.edges(shape)
        u, v = (np.array(edges.get(name, whole)) for name, whole in self._ranges(shape).items())
        areas = np.outer(shape.strip_areas(u), np.diff(v))
        return areas.reshape([len(edges[name]) - 1 for name in edges])

    def _ranges(self, shape: Shape) -> dict[str, Range]:
        ranges = {name: (low, high) for name, (low, high, _) in shape.coordinates().items()}
        if not ranges:
            lacks = "has no coordinates" if shape.hole is None else "with a hole has no bins of known area"
            got = f"got {short_repr(shape)}; {shape.coordinates_cure}"
            refuse(self, f"a {type(shape).__name__} {lacks}, {got}")
        for own, name, called in zip(shape.coordinate_names, "uv", self._names, strict=True):
            if called not in (name, own):
                kind, got = type(shape).__name__, f"{called}={short_repr(getattr(self, name))}"
                refuse(self, f"a {kind} has no {called}, got {got}; write {own}=")
        return ranges


def _is_given(value: object) -> bool:
    return value is not None and not isinstance(value, _Unchanged)


def _extend_phi_range(subject: object, ranges: dict[str, Range]) -> dict[str, Range]:
    """Extend the range of phi by one turn to either side; edges may span one turn in all."""
    phi = subject.phi
    if not isinstance(phi, tuple):
        return ranges
    if phi[-1] - phi[0] > 2 * PI * (1 + 1e-15):
        refuse(
            subject,
            f"phi edges must span one turn (2 pi) at most, got {short_repr(phi)}; use fewer"
            f"{degrees_hint(phi[-1] - phi[0])}",
        )
    return ranges | {"phi": (-2 * PI, 2 * PI)}


def _coerce_given_axes(subject: object, *names: str) -> None:
    """Convert each field to None, a number of bins or edges; at least one must be given."""
    if all(getattr(subject, name) is None for name in names):
        refuse(subject, f"at least one of {', '.join(names)} must be given, got none")
    for name in names:
        coerce_bins(subject, name)


def _check_cosine_widths(subject: object, edges: dict[str, np.ndarray]) -> None:
    """Raise SceneError for polar bins that are too narrow in cos(theta), as close to a pole."""
    if "theta" not in edges and "mu" not in edges:
        return
    name = "theta" if "theta" in edges else "mu"
    cosines = edges["mu"] if name == "mu" else np.cos(edges["theta"])
    widths = np.abs(np.diff(cosines))
    if widths.min() < MIN_COSINE_WIDTH:
        cure = "use wider ones; Directions.cone(axis, half_angle) resolves any angle about one axis"
        got = short_repr(getattr(subject, name))
        refuse(
            subject,
            f"{name} bins must be at least {MIN_COSINE_WIDTH:.2g} wide in cos(theta), got {got}; {cure}",
        )


def coerce_bins(subject: object, name: str, least: float = -math.inf, may_count: bool = True) -> None:
    """Convert a field to None, a tuple of increasing edges, or a number of bins; as `as_bins`."""
    value = getattr(subject, name)
    if value is not None:
        set_fields(subject, **{name: as_bins(subject, name, value, least, may_count)})


def as_bins(
    subject: object, name: str, value: object, least: float = -math.inf, may_count: bool = True
) -> Bins:
    """Return a tuple of increasing edges, or a number of bins; raise SceneError for anything else.

    Parameters
    ----------
    least : float
        Lowest allowed edge.
    may_count : bool
        Whether a number of bins is allowed, because their range is known.
    """
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    bins = int(value) if is_whole_number(value) and may_count else as_floats(value)
    if bins is None or not _are_bins(bins):
        must = "increasing finite edges (2 or more)"
        if may_count:
            refuse(
                subject,
                f"{name} must be a number of bins (1 to 1 000 000) or {must}, got {short_repr(value)}",
            )
        cure = "; write numpy.linspace(lowest, highest, bins + 1)" if as_float(value) is not None else ""
        refuse(subject, f"{name} must be {must}, got {short_repr(value)}{cure}")
    if not isinstance(bins, int) and bins[0] < least:
        refuse(subject, f"{name} edges must be {least:g} or above, got {short_repr(value)}")
    return bins


def check_axes_size(subject: object, *axes: object) -> None:
    """Raise SceneError if all axes of these parts of a detector make too many bins together."""
    given = {
        name: bins if isinstance(bins, int) else len(bins) - 1
        for each in axes
        for name in ("times", "speeds", "u", "v", "mu", "theta", "phi")
        if (bins := getattr(each, name, None)) is not None
    }
    check_bin_count(subject, given, sides=2, long_sums=getattr(subject, "long_sums", 0))


def check_bin_count(subject: object, given: dict[str, int], sides: int = 1, long_sums: int = 0) -> None:
    """Raise SceneError if the product of the numbers of bins would take too much memory.

    Parameters
    ----------
    given : dict of str to int
        Number of bins per axis.
    sides : int
        Number of sides that are counted.
    long_sums : int
        Number of sums per bin beside weight, count and slant.
    """
    total = math.prod(given.values())
    most = MAX_BINS_PER_DETECTOR // (1 + long_sums)
    if total > most:
        sums = total * sides * (1 + long_sums) * SUM_BYTES_PER_BIN / 1e9
        batches = total * sides * (BATCH_BYTES_PER_BIN + 8 * long_sums) * TYPICAL_BATCHES / 1e9
        kind = "bins with moments or path lengths" if long_sums else "bins"
        refuse(
            subject,
            f"{' x '.join(given)} must be {most} {kind} at most, got {total}, which would take"
            f" {sums:.3g} GB for sums and {batches:.3g} GB for {TYPICAL_BATCHES} batches; use fewer",
        )


def _are_bins(bins: Bins) -> bool:
    if isinstance(bins, int):
        return 1 <= bins <= MAX_BINS_PER_AXIS
    return len(bins) > 1 and all(lower < upper for lower, upper in pairwise(bins))


def _edges_by_axis(subject: object, ranges: dict[str, Range], where: str) -> dict[str, np.ndarray]:
    given = {name: getattr(subject, name) for name in ranges if getattr(subject, name) is not None}
    return {name: edges_of(subject, name, bins, *ranges[name], where) for name, bins in given.items()}


def _angle_hint(name: str, edges: np.ndarray) -> str:
    """Return a hint for edges out of range that are probably degrees, as the end of a message."""
    if name == "mu":
        return "; mu is a cosine: for angles write theta=" if edges[-1] > 1 else ""
    return degrees_hint(float(np.abs(edges).max())) if name in ("theta", "phi") else ""


def edges_of(subject: object, name: str, bins: Bins, lower: float, upper: float, where: str) -> np.ndarray:
    """Return edges of bins over [lower, upper], or the given edges, which must lie within it.

    Excess by rounding is clipped.
    """
    edges = _equal_edges(lower, upper, bins) if isinstance(bins, int) else np.array(bins)
    rounding = 1e-15 * max(abs(lower), abs(upper))  # so that 360 * deg or a sum of steps is not out of range
    if edges[0] < lower - rounding or edges[-1] > upper + rounding:
        must = f"{name} edges must be within [{lower}, {upper}] for {where}, got {short_repr(bins)}"
        refuse(subject, must + _angle_hint(name, edges))
    edges = edges.clip(lower, upper)
    if not (edges[:-1] < edges[1:]).all():
        refuse(
            subject, f"{name} bins must not vanish in rounding for {where}, got {short_repr(bins)}; use fewer"
        )
    return edges


def _equal_edges(lower: float, upper: float, bins: int) -> np.ndarray:
    """Return equally spaced edges, rounded like decimal numbers.

    The seventh tenth of 1 s is 0.7 s; adding steps of 0.1 would exceed it.
    """
    edges = lower + np.arange(bins + 1) * (upper - lower) / bins
    edges[-1] = upper
    return edges


# ---- Horizon of a flat shape: whether one side sees any of the world-frame direction bins.

COSINE_ROUNDING = 1e-15  # of a cosine: accuracy of edges such as pi/2 at the horizon


def is_above_horizon(directions: Directions | DirectionCone, normal: Vector) -> bool:
    """Return whether any world-frame direction bin is above the horizon of a side with this unit normal."""
    if isinstance(directions, DirectionCone):
        return -dot(directions.axis, normal) < math.sin(directions.half_angle)
    return _largest_cosine(directions, normal) > COSINE_ROUNDING


def _largest_cosine(directions: Directions, normal: Vector) -> float:
    """Return the largest cosine to the normal over all directions between the first and last edges."""
    # Range of polar angles; `across` is the largest component normal to z on the allowed azimuths.
    edges = directions.edges()
    first, last = (edges["theta"][i] for i in (0, -1)) if "theta" in edges else _polar_range(edges.get("mu"))
    across = math.hypot(normal[0], normal[1])
    if "phi" in edges:
        begin, end = (edge - math.atan2(normal[1], normal[0]) for edge in edges["phi"][[0, -1]])
        holds_normal = math.floor(end / (2 * math.pi)) > math.floor(begin / (2 * math.pi))
        across *= 1.0 if holds_normal else max(math.cos(begin), math.cos(end))
    # On the best meridian the cosine is normal_z cos(theta) + across sin(theta), which has one maximum.
    peak = min(max(math.atan2(across, normal[2]), first), last)
    return max(normal[2] * math.cos(theta) + across * math.sin(theta) for theta in (first, peak, last))


def _polar_range(mu) -> tuple[float, float]:
    """Return the polar angles [rad] of the first and last edge; (0, pi) without bins."""
    return (0.0, math.pi) if mu is None else (math.acos(mu[-1]), math.acos(mu[0]))
