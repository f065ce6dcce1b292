"""Bins: over directions of a hemisphere, over positions on a shape's own coordinates, over times, speeds and the like."""

import math
from itertools import pairwise

import numpy as np

from transport.fields import Bins, OptionalBins, VectorField
from transport.shapes import (
    Box,
    Cone,
    Cylinder,
    Disk,
    Mesh,
    Paraboloid,
    Plane,
    Rectangle,
    Revolved,
    Shape,
    Slab,
    Sphere,
    Triangle,
)
from transport.validation import (
    as_float,
    as_floats,
    check_one_of,
    in_degrees,
    is_count,
    refuse,
    scene_object,
    settle_direction,
    shown,
    store,
)

Range = tuple[float, float]

MOST_BINS = 1_000_000  # of one axis; more would be a slip
MOST_BINS_IN_ALL = 10_000_000  # of a detector
BYTES_OF_SUMS, BYTES_OF_A_BATCH, USUAL_BATCHES = (
    32,
    14,
    8,
)  # memory that a bin takes; sums on each side, of each thread
PI = math.pi
NARROWEST = 2.0**-43  # of a bin, in cosines: rounding moves a thousandth of it over its edges
DIRECTION_RANGES: dict[str, dict[str, Range]] = {
    "local": {"mu": (0.0, 1.0), "theta": (0.0, PI / 2), "phi": (0.0, 2 * PI)},
    "world": {"mu": (-1.0, 1.0), "theta": (0.0, PI), "phi": (0.0, 2 * PI)},
}
SPHERE_RANGES: dict[str, Range] = {"mu": (-1.0, 1.0), "phi": (0.0, 2 * PI)}
INSTEAD = {  # of bins of position on shapes without coordinates
    Box: "meter each of its faces() instead",
    Slab: "meter Rectangles on its planes() instead",
    Plane: "meter a Rectangle or Disk in it instead",
    Triangle: "meter a Rectangle or Disk in its plane instead",
    Mesh: "bin its directions, or put together what several meshes read",
}


@scene_object(kw_only=True)
class Directions:
    """Bins over directions, each a number of equal bins or increasing edges [rad; mu without unit].

    frame "local": `mu` = cos(theta) to the normal of the side looked at, `phi` from e_u towards e_v.
    frame "world": `mu` = cos(theta) to +z in [-1, 1], `phi` about +z from +x.
    Radiance is undefined in bins of the world that the side looked at cannot see; where it sees none they are refused.
    Edges of `phi` lie within [-2 pi, 2 pi], one turn in all at most: (-pi/4, pi/4) is a sector across phi = 0.
    """

    mu: OptionalBins = None
    phi: OptionalBins = None
    theta: OptionalBins = None
    frame: str = "local"

    def __post_init__(self) -> None:
        check_one_of(self, "frame", DIRECTION_RANGES)
        if self.mu is not None and self.theta is not None:
            refuse(
                self, f"mu and theta exclude each other, got mu={shown(self.mu)}, theta={shown(self.theta)}"
            )
        _settle_bins(self, "mu", "theta", "phi")
        check_number_of_bins(self, self)
        _check_cosines(self, self.edges())

    @staticmethod
    def cone(*values: object, **named: object) -> "DirectionCone":
        """cone(axis, half_angle), one bin: the directions within `half_angle` [rad] of `axis`, a vector in the world."""
        return DirectionCone(*values, **named)

    @staticmethod
    def sphere(*values: object, **named: object) -> "DirectionSphere":
        """sphere(mu=8, phi=16, axis=(0, 0, 1)): bins over all directions of flight, for a VolumeDetector."""
        return DirectionSphere(*values, **named)

    def edges(self) -> dict[str, np.ndarray]:
        """Edges of each binned axis, "mu" or "theta" [rad] and "phi" [rad]."""
        return _all_edges(self, _turned(self, DIRECTION_RANGES[self.frame]), f"frame {self.frame!r}")


@scene_object
class DirectionCone:
    """One bin round `axis` (world frame) of `half_angle` [rad] in (0, pi/2], made by Directions.cone."""

    axis: VectorField
    half_angle: float

    written = "Directions.cone"

    def __post_init__(self) -> None:
        settle_direction(self, "axis")
        angle = as_float(self.half_angle)
        if angle is None or not 0 < angle <= PI / 2:
            refuse(
                self, f"half_angle must be in (0, pi/2] rad, got {shown(self.half_angle)}{in_degrees(angle)}"
            )
        store(self, half_angle=angle)

    def edges(self) -> dict[str, np.ndarray]:
        """The one bin's "theta" [rad], measured from the axis."""
        return {"theta": np.array([0.0, self.half_angle])}


@scene_object
class DirectionSphere:
    """Bins over all directions of flight, made by Directions.sphere: numbers of equal bins or increasing edges.

    `mu` = cos(theta) to `axis` in [-1, 1];  `phi` about it [rad], for the default axis +z from +x; for another from e_u
    towards e_v of its frame: e_v the part of +y across it (of +z where the axis is along y), e_u = e_v x axis.
    """

    mu: OptionalBins = 8
    phi: OptionalBins = 16
    axis: VectorField = (0.0, 0.0, 1.0)

    written = "Directions.sphere"

    def __post_init__(self) -> None:
        _settle_bins(self, "mu", "phi")
        settle_direction(self, "axis")
        check_number_of_bins(self, self)
        _check_cosines(self, self.edges())

    def edges(self) -> dict[str, np.ndarray]:
        """Edges of each binned axis, "mu" and "phi" [rad]."""
        return _all_edges(self, _turned(self, SPHERE_RANGES), "all directions")

    def solid_angles(self) -> np.ndarray:
        """Solid angles [sr] of the bins, of shape (mu, phi); an axis that is not binned is left out."""
        edges = self.edges()
        cosines, turns = (edges.get(name, np.array(span)) for name, span in SPHERE_RANGES.items())
        angles = np.outer(np.diff(cosines), np.diff(turns))
        return angles.reshape([len(bounds) - 1 for bounds in edges.values()])


@scene_object(kw_only=True)
class Positions:
    """Bins over a shape's own coordinates, each a number of equal bins or increasing edges.

    Rectangle: `u`, `v` [m] from its centre along e_u and e_v. Disk: `u` radius [m], `v` azimuth [rad].
    Sphere and its zones: `u` polar angle from the axis, `v` azimuth [rad]. Cylinder, Cone, Paraboloid: `u` height [m]
    along the axis from `center`, `v` azimuth [rad]. Azimuth runs from e_u towards e_v.
    """

    u: OptionalBins = None
    v: OptionalBins = None

    def __post_init__(self) -> None:
        _settle_bins(self, "u", "v")
        check_number_of_bins(self, self)

    def edges(self, shape: Shape) -> dict[str, np.ndarray]:
        """Edges of each binned axis, "u" and "v", on the shape [m or rad]."""
        return _all_edges(self, self._ranges(shape), type(shape).__name__)

    def units(self, shape: Shape) -> dict[str, str]:
        """Of its coordinates "u" and "v" on the shape."""
        if isinstance(shape, Rectangle):
            return {"u": "m", "v": "m"}
        return {"u": "rad" if isinstance(shape, Sphere) else "m", "v": "rad"}

    def areas(self, shape: Shape) -> np.ndarray:
        """Areas [m^2] of the bins, of shape (u bins, v bins); an axis that is not binned is left out."""
        edges = self.edges(shape)
        u, v = (np.array(edges.get(name, whole)) for name, whole in self._ranges(shape).items())
        areas = np.outer(_widths(shape, u), np.diff(v))
        return areas.reshape([len(edges[name]) - 1 for name in edges])

    def _ranges(self, shape: Shape) -> dict[str, Range]:
        circle = (0.0, 2 * PI)
        match shape:
            case Rectangle():
                if shape.hole is not None:
                    cure = "meter Rectangles that leave the hole out"
                    refuse(
                        self, f"a Rectangle with a hole has no bins of known area, got {shown(shape)}; {cure}"
                    )
                half_width, half_height = shape.width / 2, shape.height / 2
                return {"u": (-half_width, half_width), "v": (-half_height, half_height)}
            case Disk():
                return {"u": (shape.inner_radius, shape.radius), "v": circle}
            case Sphere():
                return {"u": (math.acos(shape.mu_max), math.acos(shape.mu_min)), "v": circle}
            case Cylinder() | Cone():
                return {"u": (-shape.height / 2, shape.height / 2), "v": circle}
            case Paraboloid():
                return {"u": (shape.profile.low, shape.profile.high), "v": circle}
        kind = f"a {type(shape).__name__} has no coordinates"
        if type(shape) in INSTEAD:
            refuse(self, f"{kind}, got {shown(shape)}; {INSTEAD[type(shape)]}")
        must = "a Rectangle, Disk, Sphere, Cylinder, Cone or Paraboloid"
        refuse(self, f"positions need {must}, got {shown(shape)}")


def _widths(shape: Shape, u: np.ndarray) -> np.ndarray:
    """Areas per unit of v; products of sums and differences, so that narrow bins do not cancel."""
    lower, upper = u[:-1], u[1:]
    match shape:
        case Disk():
            return (upper - lower) * (upper / 2 + lower / 2)
        case Sphere():
            return 2 * shape.radius**2 * np.sin(upper / 2 + lower / 2) * np.sin((upper - lower) / 2)
        case Revolved():
            profile = shape.profile
            return (upper - lower) * profile.area_per_height(lower - profile.lift, upper - profile.lift)
    return upper - lower


def _turned(subject: object, ranges: dict[str, Range]) -> dict[str, Range]:
    """The ranges; edges of phi may lie within a turn to either side, one turn in all at most."""
    phi = subject.phi
    if not isinstance(phi, tuple):
        return ranges
    if phi[-1] - phi[0] > 2 * PI * (1 + 1e-15):
        refuse(
            subject,
            f"phi edges must span one turn (2 pi) at most, got {shown(phi)}; take fewer{in_degrees(phi[-1] - phi[0])}",
        )
    return ranges | {"phi": (-2 * PI, 2 * PI)}


def _settle_bins(subject: object, *names: str) -> None:
    """Each field is None, a number of bins, or increasing edges; one of them at least is given."""
    if all(getattr(subject, name) is None for name in names):
        refuse(subject, f"at least one of {', '.join(names)} must be given, got none")
    for name in names:
        settle_bins(subject, name)


def _check_cosines(subject: object, edges: dict[str, np.ndarray]) -> None:
    """Refuse bins of polar angle that cosines do not resolve: near a pole they crowd together."""
    if "theta" not in edges and "mu" not in edges:
        return
    name = "theta" if "theta" in edges else "mu"
    cosines = edges["mu"] if name == "mu" else np.cos(edges["theta"])
    widths = np.abs(np.diff(cosines))
    if widths.min() < NARROWEST:
        cure = "take wider ones; Directions.cone(axis, half_angle) resolves any angle round one axis"
        got = shown(getattr(subject, name))
        refuse(subject, f"{name} bins must be at least {NARROWEST:.2g} wide in cos(theta), got {got}; {cure}")


def settle_bins(subject: object, name: str, least: float = -math.inf, may_count: bool = True) -> None:
    """The field is None, increasing edges from `least` up, or a number of bins where their range is known."""
    value = getattr(subject, name)
    if value is None:
        return
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    bins = int(value) if is_count(value) and may_count else as_floats(value)
    if bins is None or not _are_bins(bins):
        must = "increasing finite edges (2 or more)"
        if may_count:
            refuse(subject, f"{name} must be a number of bins (1 to 1 000 000) or {must}, got {shown(value)}")
        cure = "; write numpy.linspace(lowest, highest, bins + 1)" if as_float(value) is not None else ""
        refuse(subject, f"{name} must be {must}, got {shown(value)}{cure}")
    if not isinstance(bins, int) and bins[0] < least:
        refuse(subject, f"{name} edges must be {least:g} or above, got {shown(value)}")
    store(subject, **{name: bins})


def check_number_of_bins(subject: object, *axes: object) -> None:
    """Refuse more bins, over all axes that these parts of a detector have together, than a detector may have."""
    given = {
        name: bins if isinstance(bins, int) else len(bins) - 1
        for each in axes
        for name in ("times", "speeds", "u", "v", "mu", "theta", "phi")
        if (bins := getattr(each, name, None)) is not None
    }
    check_total(subject, given, sides=2, moments=3 if getattr(subject, "moments", False) else 0)


def check_total(subject: object, given: dict[str, int], sides: int = 1, moments: int = 0) -> None:
    """Refuse a product of these numbers of bins that would take more memory than any detector should.

    moments: velocity sums beside each bin.
    """
    total = math.prod(given.values())
    most = MOST_BINS_IN_ALL // (1 + moments)
    if total > most:
        sums = total * sides * (1 + moments) * BYTES_OF_SUMS / 1e9
        batches = total * sides * (BYTES_OF_A_BATCH + 8 * moments) * USUAL_BATCHES / 1e9
        kind = "bins with moments" if moments else "bins"
        refuse(
            subject,
            f"{' x '.join(given)} must be {most} {kind} at most, got {total}, which would take"
            f" {sums:.3g} GB for sums and {batches:.3g} GB for {USUAL_BATCHES} batches; take fewer",
        )


def _are_bins(bins: Bins) -> bool:
    if isinstance(bins, int):
        return 1 <= bins <= MOST_BINS
    return len(bins) > 1 and all(lower < upper for lower, upper in pairwise(bins))


def _all_edges(subject: object, ranges: dict[str, Range], where: str) -> dict[str, np.ndarray]:
    given = {name: getattr(subject, name) for name in ranges if getattr(subject, name) is not None}
    return {name: edges_of(subject, name, bins, *ranges[name], where) for name, bins in given.items()}


def _cure_of_angles(name: str, edges: np.ndarray) -> str:
    """The cure for edges out of range that look like degrees, as the end of a message."""
    if name == "mu":
        return "; mu is a cosine: for angles write theta=" if edges[-1] > 1 else ""
    return in_degrees(float(np.abs(edges).max())) if name in ("theta", "phi") else ""


def edges_of(subject: object, name: str, bins: Bins, lower: float, upper: float, where: str) -> np.ndarray:
    """Edges of bins over [lower, upper], or given ones that must lie in it, the last rounding forgiven."""
    edges = _equal_bins(lower, upper, bins) if isinstance(bins, int) else np.array(bins)
    rounding = 1e-15 * max(abs(lower), abs(upper))  # so that 360 * deg or a sum of steps is not beyond
    if edges[0] < lower - rounding or edges[-1] > upper + rounding:
        must = f"{name} edges must be within [{lower}, {upper}] for {where}, got {shown(bins)}"
        refuse(subject, must + _cure_of_angles(name, edges))
    edges = edges.clip(lower, upper)
    if not (edges[:-1] < edges[1:]).all():
        refuse(subject, f"{name} bins must not vanish in rounding for {where}, got {shown(bins)}; take fewer")
    return edges


def _equal_bins(lower: float, upper: float, bins: int) -> np.ndarray:
    """Edges rounded as numbers that are written down are: the seventh tenth of 1 s is 0.7 s; in steps of 0.1 it is later."""
    edges = lower + np.arange(bins + 1) * (upper - lower) / bins
    edges[-1] = upper
    return edges
