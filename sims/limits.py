"""Limits: how small an element must be, and how small it may be.

Derivation.  Densities are limits, n(x, v, t) = lim N/(Δ³x Δ³v) as the elements shrink (Hanrahan 2001, Stanford CS 348B,
lecture 4, "Particle Density").  A count has elements of some size.  One of width h about a point finds the mean of a
quantity f over itself, which is off by about f'' h²/24: the surface must be small enough that what falls on it is
constant, and the same holds for a cone of directions (Scratchapixel, lesson on radiometry), and for a span of time, of
which the lesson says that it can be anything: only while nothing changes.  But an element of width h catches in
proportion to h of N particles, so that its variance is c/(N h).  The mean square of the deviation,

    (f'' h²/24)² + c/(N h),   is least at h* = (144 c/(f''² N))^(1/5),

where the variance is four times the square of the bias (Rosenblatt 1956, Ann. Math. Stat. 27, 832): 32 times the
particles halve the best element and quarter its error.  There is no limit without particles to pay for it.

Scenes.  "area": the penumbra of a straight edge before a diffuse disk, by strips ΔA along the edge; the point is
halfway into the shadow.  "solid angle": two diffuse disks, by sectors Δω of azimuth; the point is the middle of one.
"time": a Gaussian burst, by spans Δt; the point is its peak.  The bins are fine, and elements are made of them.  Exact
means and variances are integrals over the elements (theory/shadows.py, theory/solid_angles.py, the error function).  The
meter for directions is half a millimetre, which moves their means by about (a/d)² ≲ 1e-6.

Measured.  Each batch, and in it each of 16 equal parts of the meter, is a measurement of its own with its share of the
particles: the root of their mean square deviation from the value at the point is what one of them must expect.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

import transport as tp
from transport.sims import figures, main, one_of
from transport.theory import counting, shadows, solid_angles
from transport.theory.counting import Moments
from transport.verification.experiment import Outcome

law = "mean over an element: off by f'' h²/24; best element (144 c/(f''² N))^(1/5) (Rosenblatt 1956)"
question = "How small should an element be, for a given number of particles?"
particles = 8_000_000

BINS, PARTS = 96, 16  # fine bins across, equal parts of the meter
MIDDLE = BINS // 2
ROWS = (1, 2, 4, 8, 16, 32, 48)  # bins on either side of the point that the table's elements take
POINTS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48)  # the same for the figure
RADIANCE = 100.0  # W m^-2 sr^-1


@dataclass(frozen=True)
class Penumbra:
    """Strips ΔA along the edge's shadow, across x; the point is halfway from the middle of the penumbra into the shadow."""

    radius: float  # m, of the source

    name, scale, unit, looked_at, quantity = "ΔA", 1e3, " mm", "an edge's penumbra", "irradiance"
    mixed = "shadow and light"  # what too large an element takes together
    gap, distance = 1.0, 2.0  # m, from the source to the edge and to the meter

    @property
    def span(self) -> float:
        """From the point to the end of the bins, where the source is seen in full; as far on the other side [m]."""
        return 1.5 * shadows.half_width(self.radius, self.gap, self.distance)

    @property
    def place(self) -> float:
        """The point's x [m]."""
        return -shadows.half_width(self.radius, self.gap, self.distance) / 2

    def scene(self) -> tp.Scene:
        center, side = (self.place, 0, self.distance), 10 * self.radius
        meter = tp.Rectangle(center=center, width=2 * self.span, height=2 * self.radius)
        edge = tp.Rectangle(center=(-side / 2, 0, self.gap), width=side, height=side)
        bins = tp.Positions(u=BINS, v=PARTS)
        return tp.Scene(
            sources=tp.Source(tp.Disk(radius=self.radius), tp.Lambertian(radiance=RADIANCE), aim=meter),
            surfaces=tp.Surface(edge, tp.Black()),
            detectors=tp.Detector(meter, "meter", side="back", positions=bins),
        )

    def moments(self, low: np.ndarray, high: np.ndarray) -> Moments:
        meter = 4 * self.radius * self.span
        return shadows.penumbra_moments(self.place + low, self.place + high, meter, RADIANCE, *self._geometry)

    @property
    def value(self) -> float:
        return RADIANCE * shadows.geometry_at(self.place, *self._geometry)

    @property
    def _geometry(self) -> tuple:
        return (-self.radius, self.radius), self.radius, self.gap, self.distance


@dataclass(frozen=True)
class TwoDisks:
    """Sectors Δω of azimuth across two disks; the point is the middle of the first."""

    separation: float  # rad between their middles

    name, scale, unit, looked_at, quantity = "Δω", 180 / math.pi, "°", "two disks", "radiance"
    mixed = "two disks and a gap"
    radius, offset, height, meter = 0.2, 1.0, 1.0, 5e-4  # m
    span = 0.6  # rad

    @property
    def mu_range(self) -> tuple[float, float]:
        """Cosines between which both disks lie, with a tenth of their radius to spare."""
        return tuple(
            self.height / math.hypot(self.height, self.offset + reach * self.radius) for reach in (1.1, -1.1)
        )

    def scene(self) -> tp.Scene:
        half, meter = self.separation / 2, tp.Disk(radius=self.meter)
        middles = [
            (self.offset * math.cos(phi), self.offset * math.sin(phi), self.height) for phi in (half, -half)
        ]
        disks = [tp.Disk(center=middle, normal=(0, 0, -1), radius=self.radius) for middle in middles]
        sectors = half + np.linspace(-self.span, self.span, BINS + 1)
        directions = tp.Directions(mu=self.mu_range, phi=sectors)
        return tp.Scene(
            sources=[tp.Source(disk, tp.Lambertian(radiance=RADIANCE), aim=meter) for disk in disks],
            detectors=tp.Detector(meter, "meter", directions=directions, positions=tp.Positions(v=PARTS)),
        )

    def moments(self, low: np.ndarray, high: np.ndarray) -> Moments:
        disk = self.radius, self.offset, self.height
        return solid_angles.sector_moments(low, high, self.mu_range, (0.0, -self.separation), RADIANCE, *disk)

    @property
    def value(self) -> float:
        seen = solid_angles.projected_solid_angle_a_radian(0.0, self.radius, self.offset, self.height)
        return float(RADIANCE * seen / (np.diff(np.square(self.mu_range))[0] / 2))


@dataclass(frozen=True)
class Burst:
    """Spans Δt across a Gaussian burst of a parallel beam; the point is its peak."""

    sigma: float  # s

    name, scale, unit, looked_at, quantity = "Δt", 1e9, " ns", "a burst", "irradiance"
    mixed = "the burst and the time beside it"
    start, flight, stop = 10.0, 3.0, 22.0  # peak, way to the meter, end: in standard deviations
    energy, side, meter = 1.0, 1.5, 1.0  # J and m: of the beam; side of the meter

    @property
    def span(self) -> float:
        return 3 * self.sigma

    def scene(self) -> tp.Scene:
        way = self.flight * self.sigma * tp.speed_of_light
        lamp = tp.Rectangle(width=self.side, height=self.side)
        meter = tp.Rectangle(center=(0, 0, way), normal=(0, 0, -1), width=self.meter, height=self.meter)
        beam = tp.Beam((0, 0, 1), energy=self.energy)
        pulse = tp.GaussianPulse(self.start * self.sigma, self.sigma)
        times = (self.start + self.flight) * self.sigma + np.linspace(-self.span, self.span, BINS + 1)
        return tp.Scene(
            sources=tp.Source(lamp, beam, pulse=pulse),
            detectors=tp.Detector(meter, "meter", times=times, positions=tp.Positions(v=PARTS)),
            duration=self.stop * self.sigma,
        )

    def moments(self, low: np.ndarray, high: np.ndarray) -> Moments:
        share = (self.meter / self.side) ** 2
        return counting.burst_moments(low, high, self.energy / self.side**2, self.sigma, share)

    @property
    def value(self) -> float:
        return counting.burst_peak(self.energy / self.side**2, self.sigma)


Limit = Penumbra | TwoDisks | Burst
ELEMENTS = ("area", "solid angle", "time")


def cases() -> list[dict[str, str]]:
    return [{"element": element} for element in ELEMENTS]


def scene(
    element: str = "area", radius: float = 0.05, separation: float = 0.5, burst: float = 1e-9
) -> tp.Scene:
    """What one kind of element looks at.

    radius: of the disk behind the edge [m];  separation: of the two disks' middles in azimuth [rad];  burst: its
    standard deviation [s].
    """
    one_of("limits", element=(element, ELEMENTS))
    limits = {"area": Penumbra(radius), "solid angle": TwoDisks(separation), "time": Burst(burst)}
    return limits[element].scene()


def limit_of(scene: tp.Scene) -> Limit:
    """What a scene of this experiment shows."""
    source = scene.sources[0]
    if scene.duration is not None:
        return Burst(source.pulse.sigma)
    if len(scene.sources) > 1:
        x, y, _ = source.shape.center
        return TwoDisks(2 * math.atan2(y, x))
    return Penumbra(source.shape.radius)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    fine = by_part(result).mean("v")
    return {name: fine[MIDDLE - j : MIDDLE + j].mean() for name, j in _names(limit_of(result.scene)).items()}


def by_part(result: tp.Result) -> tp.EstimateArray:
    """Means over the fine bins in each of the equal parts of the meter."""
    meter = result["meter"]
    return meter.irradiance if meter.detector.directions is None else meter.radiance.sum("mu")


def _names(limit: Limit) -> dict[str, int]:
    """The rows of the table, and how many fine bins on either side of the point each takes."""
    widths = {j: f"{2 * j * limit.span / MIDDLE * limit.scale:.4g}{limit.unit}" for j in ROWS}
    return {f"mean over {limit.name} = {width}": j for j, width in widths.items()}


def exact(**parameters: object) -> dict[str, float]:
    limit = limit_of(scene(**parameters))
    names = _names(limit)
    half = np.array(list(names.values())) / MIDDLE * limit.span
    return dict(zip(names, limit.moments(-half, half).mean.tolist(), strict=True))


class Budget(NamedTuple):
    """Measurements of one kind: each with so many histories, in one of so many parts of the meter.

    measured, error: root mean square deviations from the value at the point, by elements of POINTS bins on either side,
    and their standard errors, over that value.
    """

    histories: float
    parts: int = 1
    measured: np.ndarray | None = None
    error: np.ndarray | None = None

    @property
    def particles(self) -> float:
        return self.histories / self.parts


def budgets(result: tp.Result) -> list[Budget]:
    """Each part of the meter in each batch by itself, and the whole meter in each batch."""
    value, each, histories = limit_of(result.scene).value, measurements(result), result.run.sizes.mean()
    sets = {PARTS: each.reshape(-1, BINS), 1: each.mean(axis=0)}
    squares = {parts: squared_deviations(means, value) for parts, means in sets.items()}
    return [Budget(histories, parts, *counting.root_mean(of)) for parts, of in squares.items()]


def measurements(result: tp.Result) -> np.ndarray:
    """Means over the fine bins by part of the meter and batch, (PARTS, batches, BINS)."""
    parts = by_part(result)
    return np.moveaxis(parts.values, [1 + parts.dims.index("v"), 0], [0, 1])


def squared_deviations(means: np.ndarray, value: float) -> np.ndarray:
    """Of elements of POINTS bins on either side, from and over the value at the point: (measurements, points)."""
    elements = [means[:, MIDDLE - j : MIDDLE + j].mean(axis=1) for j in POINTS]
    return (np.stack(elements, axis=1) / value - 1) ** 2


def best_of(limit: Limit, histories: float, parts: int = 1) -> tuple[float, float]:
    """Width of the element of least expected deviation [m, rad or s], and that deviation over the value at the point."""
    half = limit.span * np.geomspace(1 / MIDDLE, 1, 120)
    expected = limit.moments(-half, half).deviation(limit.value, histories, parts)
    least = int(np.argmin(expected))
    return float(2 * half[least]), float(expected[least] / limit.value)


def verdict(outcomes: list[Outcome]) -> str:
    sentences = []
    for result in (outcome.result for outcome in outcomes):
        limit, sets = limit_of(result.scene), budgets(result)
        bests = [best_of(limit, each.histories, each.parts) for each in sets]
        few, many = (
            f"{limit.name} = {h * limit.scale:.2g}{limit.unit} and {error:.1%}" for h, error in bests
        )
        times = sets[1].particles / sets[0].particles
        sentences.append(
            f"{_count(sets[0].particles)} particles pay for {few}, {times:.3g} times as many for {many}."
        )
    return " ".join(sentences)


def _count(number: float) -> str:
    return f"{number:,.0f}".replace(",", " ")


def draw_tradeoff(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Deviation at the point against the element's width: bias dashed, a star where a budget's deviation is least."""
    from transport.viz.style import figure

    with figure(
        (2 + 7.2 * len(outcomes), 10.2), "Smaller elements: less bias, more noise", note, path
    ) as page:
        row = page.subplots(1, len(outcomes), squeeze=False)[0]
        for axes, outcome in zip(row, outcomes, strict=True):
            _draw_budgets(axes, limit_of(outcome.result.scene), outcome.result)
        row[0].set_ylabel("rms error at the point  [%]")


def _draw_budgets(axes, limit: Limit, result: tp.Result) -> None:
    from transport.viz.curves import draw_points
    from transport.viz.style import INK, MUTED, look, tick_log

    half = limit.span * np.geomspace(0.8 / MIDDLE, 1, 80)
    of, percent, widths, bests = limit.moments(-half, half), 100 / limit.value, 2 * half * limit.scale, []
    sizes = 2 * np.array(POINTS) / MIDDLE * limit.span * limit.scale
    axes.set(xscale="log", yscale="log", title=f"{limit.name}: {limit.looked_at}")
    for rank, each in enumerate((*budgets(result), Budget(result.particles))):
        milliseconds = float(f"{1e3 * result.cost.seconds / result.particles * each.particles:.2g}")
        label = f"{_count(each.particles)} particles, {milliseconds:g} ms"
        expected = percent * of.deviation(limit.value, each.histories, each.parts)
        axes.plot(widths, expected, color=look(rank)[0], lw=2.4, label=label)
        if each.measured is not None:
            draw_points(axes, sizes, 100 * each.measured, 100 * each.error, rank)
        bests.append((widths[np.argmin(expected)], expected.min()))
    axes.set_ylim(axes.get_ylim())
    axes.plot(widths, percent * np.abs(of.mean - limit.value), "--", color=INK, lw=2.4, label="bias, exact")
    axes.plot([], [], "o", color=MUTED, label="measured, ± 2 standard errors")
    axes.plot(
        *zip(*bests, strict=True), "*-", color=INK, mec="white", ms=26, lw=1.2, zorder=5, label="best element"
    )
    axes.set_xlabel(f"width of {limit.name}  [{limit.unit.strip()}]")
    for axis in (axes.xaxis, axes.yaxis):
        tick_log(axis)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncol=1)


def draw_seen(outcomes: list[Outcome], path: Path, note: str) -> None:
    """One measurement by elements of three sizes, a column a kind of element: too fine is noise, too coarse is blur."""
    from transport.viz.style import figure

    few = _count(budgets(outcomes[0].result)[0].particles)
    title = f"One measurement of {few} particles by elements of three sizes"
    with figure((2 + 6.4 * len(outcomes), 14.2), title, note, path) as page:
        grid = page.subplots(3, len(outcomes), squeeze=False, sharex="col", sharey="col")
        for column, outcome in zip(grid.T, outcomes, strict=True):
            _draw_elements(column, limit_of(outcome.result.scene), outcome.result)


def _draw_elements(column: np.ndarray, limit: Limit, result: tp.Result) -> None:
    """The element about the point is filled; a dot is the value that is sought."""
    from transport.viz.style import BLUE, INK, MUTED, with_unit

    few, ends = budgets(result)[0], limit.span * limit.scale
    best, _ = best_of(limit, few.histories, few.parts)
    nearest = min(POINTS, key=lambda j: abs(math.log(2 * j * limit.span / MIDDLE / best)))
    places = np.linspace(-limit.span, limit.span, 4 * BINS + 1)
    curve = (places[1:] + places[:-1]) / 2 * limit.scale, limit.moments(places[:-1], places[1:]).mean
    fine, kinds = (
        np.linspace(-ends, ends, BINS + 1),
        {"too small": 1, "best": nearest, f"too large:\n{limit.mixed}": 32},
    )
    for axes, (words, bins) in zip(column, kinds.items(), strict=True):
        edges, means = grouped_bins(fine, measurements(result)[0, 0], bins)
        middle = len(means) // 2
        axes.stairs(means, edges, baseline=None, color=BLUE, lw=2.2)
        axes.stairs(means[middle : middle + 1], edges[middle : middle + 2], fill=True, color=BLUE, alpha=0.35)
        axes.plot(*curve, color=INK, lw=2.2)
        axes.axvline(0, color=MUTED, lw=1.2, ls=":")
        axes.plot(0, limit.value, "o", color=INK, ms=11)
        width = f"{bins * 2 * ends / MIDDLE:.3g}{limit.unit}"
        axes.set_title(f"{limit.name} = {width}, {words}", fontsize="medium")
        axes.set(xlim=(-ends, ends), ylim=(0, None))
    column[1].set_ylabel(with_unit(limit.quantity, by_part(result).unit))
    column[2].set_xlabel(f"from the point  [{limit.unit.strip()}]")


def grouped_bins(edges: np.ndarray, means: np.ndarray, bins: int) -> tuple[np.ndarray, np.ndarray]:
    """Edges and means of elements of 2 × bins fine bins, one of them about the middle; what is left at the ends is dropped."""
    middle, width = len(means) // 2, 2 * bins
    beside = (middle - bins) // width  # whole elements on either side
    first, last = middle - bins - beside * width, middle + bins + beside * width
    return edges[first : last + 1 : width], means[first:last].reshape(-1, width).mean(axis=1)


draw = figures(tradeoff=draw_tradeoff, seen=draw_seen)


if __name__ == "__main__":
    main(__file__)
