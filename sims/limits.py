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
means and variances are integrals over the elements (theory/penumbra.py, theory/sectors.py, the error function).  The
meter for directions is half a millimetre, which moves their means by about (a/d)² ≲ 1e-6.

Measured.  Each batch, and in it each of 16 equal parts of the meter, is a measurement of its own with its share of the
particles: the root of their mean square deviation from the value at the point is what one of them must expect.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

import transport as tp
from sims import provenance
from transport.experiment import Outcome
from transport.theory import counting, penumbra, sectors
from transport.theory.counting import Moments

law = (
    "a mean over an element is off by f'' h²/24; the best element is (144 c/(f''² N))^(1/5) (Rosenblatt 1956)"
)
question = "How small should an element be, for a given number of particles?"
particles = 8_000_000

BINS, PARTS = 96, 16  # fine bins across, equal parts of the meter
CURVE = 384  # points of an exact curve
ROWS = (1, 2, 4, 8, 16, 32, 48)  # bins on either side of the point that the table's elements take
POINTS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48)  # the same for the figure

GAP, DISTANCE = 1.0, 2.0  # m, from the source to the edge and to the meter
OFFSET, HEIGHT = 1.0, 1.0  # m, middles of the two disks off the meter's axis and above it
RADIUS, METER = 0.2, 5e-4  # m, of the disks and of their meter
SPAN = 0.6  # rad on either side of the point
START, FLIGHT, STOP = 10.0, 3.0, 22.0  # peak, way to the meter, end: in standard deviations of the burst
BEAM = 1.5  # side of the beam over that of the meter
RADIANCE, ENERGY = 100.0, 1.0  # W m^-2 sr^-1, J

KINDS = {  # name of an element, how its width is shown, what is looked at, and the quantity
    "area": ("ΔA", 1e3, "mm", "an edge's penumbra", "irradiance"),
    "solid angle": ("Δω", 180 / math.pi, "°", "two disks", "radiance"),
    "time": ("Δt", 1e9, "ns", "a burst", "irradiance"),
}


def cases() -> list[dict[str, str]]:
    return [{"element": element} for element in KINDS]


def scene(
    element: str = "area", radius: float = 0.05, separation: float = 0.5, burst: float = 1e-9
) -> tp.Scene:
    """What one kind of element looks at.

    radius: of the disk behind the edge [m];  separation: of the two disks' middles in azimuth [rad];  burst: its
    standard deviation [s].
    """
    if element not in KINDS:
        raise tp.SceneError(f"limits: element must be one of {', '.join(KINDS)}, got {element!r}")
    if element == "area":
        return _penumbra(radius)
    return _two_disks(separation) if element == "solid angle" else _burst(burst)


def _penumbra(radius: float) -> tp.Scene:
    reach, middle = half_span("area", radius), _place_of_point(radius)
    meter = tp.Rectangle(center=(middle, 0, DISTANCE), width=2 * reach, height=2 * radius)
    side = 10 * radius
    edge = tp.Surface(tp.Rectangle(center=(-side / 2, 0, GAP), width=side, height=side), tp.Black())
    bins = tp.Positions(u=BINS, v=PARTS)
    return tp.Scene(
        sources=tp.Source(tp.Disk(radius=radius), tp.Lambertian(radiance=RADIANCE), aim=meter),
        surfaces=edge,
        detectors=tp.Detector(meter, "meter", side="back", positions=bins),
    )


def _place_of_point(radius: float) -> float:
    """Halfway from the middle of the penumbra into the shadow [m from the edge's plane x = 0]."""
    return -penumbra.half_width(radius, GAP, DISTANCE) / 2


def _two_disks(separation: float) -> tp.Scene:
    meter, half = tp.Disk(radius=METER), separation / 2
    middles = [(OFFSET * math.cos(phi), OFFSET * math.sin(phi), HEIGHT) for phi in (half, -half)]
    disks = [tp.Disk(center=middle, normal=(0, 0, -1), radius=RADIUS) for middle in middles]
    directions = tp.Directions(mu=_mu_range(), phi=half + np.linspace(-SPAN, SPAN, BINS + 1))
    return tp.Scene(
        sources=[tp.Source(disk, tp.Lambertian(radiance=RADIANCE), aim=meter) for disk in disks],
        detectors=tp.Detector(meter, "meter", directions=directions, positions=tp.Positions(v=PARTS)),
    )


def _mu_range() -> tuple[float, float]:
    """Cosines between which both disks lie, with a twentieth of their width to spare."""
    reach = OFFSET - 1.1 * RADIUS, OFFSET + 1.1 * RADIUS
    return tuple(HEIGHT / math.hypot(HEIGHT, rho) for rho in reversed(reach))


def _burst(burst: float) -> tp.Scene:
    way = FLIGHT * burst * tp.speed_of_light
    lamp = tp.Rectangle(width=BEAM, height=BEAM)
    meter = tp.Rectangle(center=(0, 0, way), normal=(0, 0, -1), width=1, height=1)
    half = half_span("time", burst=burst)
    times = (START + FLIGHT) * burst + np.linspace(-half, half, BINS + 1)
    return tp.Scene(
        sources=tp.Source(
            lamp, tp.Beam((0, 0, 1), energy=ENERGY), pulse=tp.GaussianPulse(START * burst, burst)
        ),
        detectors=tp.Detector(meter, "meter", times=times, positions=tp.Positions(v=PARTS)),
        duration=STOP * burst,
    )


def half_span(element: str, radius: float = 0.05, separation: float = 0.5, burst: float = 1e-9) -> float:
    """From the point to the end of the fine bins, as far on either side [m, rad or s]."""
    if element == "area":  # to the end of the penumbra that is lit, and as far into the full shadow
        return 1.5 * penumbra.half_width(radius, GAP, DISTANCE)
    return SPAN if element == "solid angle" else 3 * burst


def moments(
    low: np.ndarray,
    high: np.ndarray,
    element: str = "area",
    radius: float = 0.05,
    separation: float = 0.5,
    burst: float = 1e-9,
) -> Moments:
    """What elements hold that reach from low to high, measured from the point [m, rad or s]."""
    low, high = (np.atleast_1d(np.asarray(edge, dtype=float)) for edge in (low, high))
    if element == "area":
        middle, strip, meter = (
            _place_of_point(radius),
            (-radius, radius),
            4 * radius * half_span("area", radius),
        )
        return penumbra.penumbra_moments(
            middle + low, middle + high, strip, meter, RADIANCE, radius, GAP, DISTANCE
        )
    if element == "solid angle":
        disk = RADIUS, OFFSET, HEIGHT
        return sectors.sector_moments(low, high, _mu_range(), (0.0, -separation), RADIANCE, *disk)
    return counting.burst_moments(low, high, ENERGY / BEAM**2, burst, 1 / BEAM**2)


def at_point(
    element: str = "area", radius: float = 0.05, separation: float = 0.5, burst: float = 1e-9
) -> float:
    """The value at the point, which elements tend to as they shrink [W m^-2 or W m^-2 sr^-1]."""
    if element == "area":
        place, strip = _place_of_point(radius), (-radius, radius)
        return RADIANCE * penumbra.geometry_at(place, strip, radius, GAP, DISTANCE)
    if element == "solid angle":
        low, high = _mu_range()
        seen = sectors.projected_solid_angle_a_radian(0.0, RADIUS, OFFSET, HEIGHT)
        return float(RADIANCE * seen / ((high**2 - low**2) / 2))
    return counting.burst_peak(ENERGY / BEAM**2, burst)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    fine = fine_means(result)
    return {
        name: fine[BINS // 2 - j : BINS // 2 + j].mean() for name, j in _rows(_parameters(result)).items()
    }


def fine_means(result: tp.Result) -> tp.EstimateArray:
    """Means over the fine bins, (BINS,), of the whole meter."""
    return _by_part(result).mean("v")


def _by_part(result: tp.Result) -> tp.EstimateArray:
    """Means over the fine bins and the parts of the meter."""
    meter = result["meter"]
    return meter.irradiance if meter.detector.directions is None else meter.radiance.sum("mu")


def _rows(parameters: dict[str, object]) -> dict[str, int]:
    """The names of the table's rows, and how many fine bins on either side of the point each takes."""
    name, scale, unit, *_ = KINDS[parameters.get("element", "area")]
    width = 2 * half_span(**parameters) / BINS
    return {f"mean over {name} of {2 * j * width * scale:.4g} {unit}": j for j in ROWS}


def _parameters(result: tp.Result) -> dict[str, object]:
    """Those of `scene` that made this run's scene, as far as they matter to it."""
    meter, source = result["meter"].detector, result.scene.sources[0]
    if meter.directions is not None:
        return {"element": "solid angle", "separation": 2 * math.atan2(*source.shape.center[1::-1])}
    if result.scene.duration is not None:
        return {"element": "time", "burst": source.pulse.sigma}
    return {"element": "area", "radius": source.shape.radius}


def exact(
    element: str = "area", radius: float = 0.05, separation: float = 0.5, burst: float = 1e-9
) -> dict[str, float]:
    parameters = {"element": element, "radius": radius, "separation": separation, "burst": burst}
    rows = _rows(parameters)
    half = np.array(list(rows.values())) / (BINS // 2) * half_span(**parameters)
    return dict(zip(rows, moments(-half, half, **parameters).mean.tolist(), strict=True))


class Budget(NamedTuple):
    """Repeated measurements, each with its share of the particles, by elements of POINTS bins a side.

    measured, error: root mean square deviations from the value at the point and their standard errors, over that value.
    """

    histories: float  # of a run, of which one of `parts` parts of the meter is looked at
    parts: int
    measured: np.ndarray
    error: np.ndarray

    @property
    def particles(self) -> float:
        return self.histories / self.parts


def budgets(result: tp.Result) -> list[Budget]:
    """The smaller one, each part of the meter in each batch, and the larger one, each batch."""
    value, run = at_point(**_parameters(result)), _by_part(result)
    axes = [1 + run.dims.index("v"), 0]
    values = np.moveaxis(run.values, axes, [0, 1])  # part, batch, fine bin
    return [
        _budget(each.reshape(-1, BINS), value, result.run.sizes.mean(), parts)
        for each, parts in ((values, PARTS), (values.mean(axis=0), 1))
    ]


def squared_deviations(means: np.ndarray, value: float) -> np.ndarray:
    """Of elements of POINTS bins a side, over the value at the point: (measurements, points)."""
    middle = BINS // 2
    elements = [means[:, middle - j : middle + j].mean(axis=1) for j in POINTS]
    return (np.stack(elements, axis=1) / value - 1) ** 2


def _budget(means: np.ndarray, value: float, histories: float, parts: int) -> Budget:
    squares = squared_deviations(means, value)
    measured = np.sqrt(squares.mean(axis=0))
    error = squares.std(axis=0, ddof=1) / math.sqrt(len(squares)) / (2 * measured)
    return Budget(histories, parts, measured, error)


def best_of(
    parameters: dict[str, object], histories: float, parts: int = 1, points: int = 400
) -> tuple[float, float]:
    """Width of the element of least expected deviation [m, rad or s], and that deviation over the point's value."""
    half = half_span(**parameters) * np.geomspace(0.25 / BINS, 1, points)
    expected = moments(-half, half, **parameters).deviation(at_point(**parameters), histories, parts)
    least = int(np.argmin(expected))
    return float(2 * half[least]), float(expected[least]) / at_point(**parameters)


def verdict(outcomes: list[Outcome]) -> str:
    sentences = []
    for outcome in outcomes:
        parameters = _parameters(outcome.result)
        name, scale, unit, *_ = KINDS[parameters["element"]]
        few, many = budgets(outcome.result)
        (h, error), (h_many, error_many) = (
            best_of(parameters, each.histories, each.parts, 100) for each in (few, many)
        )
        sentences.append(
            f"{few.particles:.3g} particles pay for a {name} of {h * scale:.2g} {unit} and {error:.1%},"
            f" {many.particles / few.particles:.3g} times as many for {h_many * scale:.2g} {unit} and {error_many:.1%}."
        )
    return " ".join(sentences)


def draw(outcomes: list[Outcome], path: str) -> list[Path]:
    """Deviation against the element's size; beside it, as <name>_seen, the same run through three sizes."""
    from viz.resolution import resolutions
    from viz.tradeoff import tradeoff

    path = Path(path)
    paths = [path, path.with_stem(path.stem + "_seen")]
    panels, columns = {}, {}
    for outcome in outcomes:
        name, _, _, looked_at, _ = KINDS[_parameters(outcome.result)["element"]]
        panels[f"{name}: {looked_at}"] = _panel(outcome.result)
        columns[name] = _column(outcome.result)
    note, title = provenance(outcomes), "Smaller elements: less bias, more noise"
    tradeoff(panels, paths[0], "deviation from the point, rms  [%]", title, note)
    resolutions(columns, paths[1], "One measurement by elements of three sizes", note)
    return paths


def _panel(result: tp.Result):
    """The expected deviations at many widths, and those found."""
    from viz.tradeoff import Budget as Curve
    from viz.tradeoff import Tradeoff

    parameters = _parameters(result)
    name, scale, unit, *_ = KINDS[parameters["element"]]
    value, span = at_point(**parameters), half_span(**parameters)
    half = span * np.geomspace(0.8 / (BINS // 2), 1, 80)
    of = moments(-half, half, **parameters)
    seconds = result.cost.seconds / result.particles
    sizes = 2 * np.array(POINTS) / (BINS // 2) * span * scale
    curves = []
    for each in budgets(result):
        expected = 100 * of.deviation(value, each.histories, each.parts) / value
        label = f"{each.particles:.3g} particles, {1e3 * seconds * each.particles:.2g} ms"
        curves.append(Curve(label, expected, sizes, 100 * each.measured, 100 * each.error))
    whole = 100 * of.deviation(value, result.particles) / value
    label = f"{result.particles:.3g} particles, {1e3 * seconds * result.particles:.2g} ms"
    xlabel = f"width of the element {name}  [{unit}]"
    bias = 100 * (of.mean / value - 1)
    return Tradeoff(xlabel, 2 * half * scale, bias, [*curves, Curve(label, whole)])


def _column(result: tp.Result):
    """One part of the meter in one batch, through elements that are too small, the best, and too large."""
    from viz.resolution import Resolved
    from viz.style import with_unit

    parameters = _parameters(result)
    name, scale, unit, _, quantity = KINDS[parameters["element"]]
    span = half_span(**parameters)
    edges, places = np.linspace(-span, span, BINS + 1), np.linspace(-span, span, CURVE + 1)
    of = moments(places[:-1], places[1:], **parameters)
    run = _by_part(result)
    means = np.moveaxis(run.values, 1 + run.dims.index("v"), 1)[0, 0]
    few = budgets(result)[0]
    best, _ = best_of(parameters, few.histories, few.parts, 100)
    best_bins = min(POINTS, key=lambda j: abs(math.log(2 * j * span / (BINS // 2) / best)))
    sizes = {
        f"{words}: {name} = {2 * j * span / (BINS // 2) * scale:.3g} {unit}": j
        for words, j in (("noise", 1), ("best", best_bins), ("blur", 24))
    }
    return Resolved(
        xlabel=f"from the point  [{unit}]",
        ylabel=with_unit(quantity, run.unit),
        edges=edges * scale,
        means=means,
        curve=((places[1:] + places[:-1]) / 2 * scale, of.mean),
        sizes=sizes,
    )


if __name__ == "__main__":
    from sims import print_table

    print_table(__file__)
