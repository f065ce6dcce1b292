"""Goniophotometer: the intensity of a lamp by direction, and that its sum over all directions is the power.

Derivation.  I(ω) = dΦ/dω = ∫ L cosθ dA over what is seen of the lamp, so that ∫ I dω = Φ (Bala 2009, Cornell CS 6620, lecture 2;
Lambert 1760).  A goniophotometer measures it from so far away that all of the lamp is one point.

- A diffuse disk of area A shows A cosθ: I = L A cosθ, the cosine law, and half the light leaves within 45°.
- A diffuse sphere of radius R shows π R² to all sides: I = π L R² = Φ/4π.  An isotropic point is the same to all directions.
- A diffuse disk at the bottom of a black open tube of its own radius R and the length h is seen through the mouth, which lies
  h tanθ aside: what is seen is the overlap of two disks so far apart, O = 2R² (u − sin u cos u) with cos u = h tanθ/2R.  So
  I = L cosθ O(h tanθ), and the light is cut off exactly at tanθ = 2R/h.  What leaves is Φ F, with F the view factor of two equal
  coaxial disks (Howell, C-41); the tube absorbs the rest.
- A diffuse disk beneath a black shade, a disk of the same radius in front of it at the distance h, is the complement:
  I = L cosθ (A − O), zero on the axis, and Φ (1 − F) leaves.

A bin reads ∫ I dω/∫ dω between its edges, by Gauss-Legendre sums of the closed form to 1e-12; the cut-off is one of the edges.

Scene.  The lamp within a transparent sphere, which counts what leaves by direction and not by place: that is the view from far
away.  The shade's back is black too, and stops what the lamp sends to it.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import constant, figures, furthest, main, of_scene, one_of, require, sentence, sharp
from transport.statistics.quadrature import legendre_nodes
from transport.theory import view_factors
from transport.verification.experiment import Outcome

law = "I = ∫L cosθ dA, ∫I dω = Φ; disk L A cosθ, sphere Φ/4π, tube L cosθ O(h tanθ) (Lambert 1760; Bala 2009, Cornell CS 6620)"
question = (
    "How much light does a lamp send into each direction, and does the sum over directions give its power?"
)
particles = 16_000_000

LAMPS = ("disk", "sphere", "tube", "shade")
RADIUS = 0.05  # m, of all lamps
AROUND = 1.0  # m, radius of the sphere that counts
BINS = 12  # of the polar angle from 0 to the cut-off or to 90°; a sphere has twice as many
EVERY = 3  # bins of a row
TOTAL, SHARE, BEYOND = "∫I dω", "∫I dω / Φ of the lamp", "I beyond the cut-off"


def cases() -> list[dict[str, object]]:
    return [{"lamp": lamp} for lamp in LAMPS]


def scene(lamp: str = "disk", power: float = 10.0, length: float = 0.1) -> tp.Scene:
    """A lamp of that power [W].  length [m]: of the tube, or from the disk to the shade."""
    one_of("goniophotometer", lamp=(lamp, LAMPS))
    require(
        "goniophotometer", length=(length, 0 < length < 0.9 * AROUND, f"above 0 and below {0.9 * AROUND} m")
    )
    shape = tp.Sphere(radius=RADIUS) if lamp == "sphere" else tp.Disk(radius=RADIUS)
    surfaces = []
    if lamp == "tube":
        wall = tp.Cylinder(center=(0, 0, length / 2), axis=(0, 0, 1), radius=RADIUS, height=length)
        surfaces = [tp.Surface(wall, tp.Black(), "tube")]
    elif lamp == "shade":
        surfaces = [tp.Surface(tp.Disk(center=(0, 0, length), radius=RADIUS), tp.Black(), "shade")]
    directions = tp.Directions(theta=edges(lamp, length), frame="world")
    sphere = tp.Detector(tp.Sphere(radius=AROUND), "photometer", "outside", directions=directions)
    return tp.Scene(tp.Source(shape, tp.Lambertian(power=power)), surfaces=surfaces, detectors=sphere)


def cut_off(length: float) -> float:
    """Polar angle from which nothing of the disk is seen through the tube [rad]."""
    return math.atan(2 * RADIUS / length)


def edges(lamp: str, length: float) -> np.ndarray:
    """Edges of the bins of the polar angle [rad]."""
    if lamp == "sphere":
        return np.linspace(0, math.pi, 2 * BINS + 1)
    even = np.linspace(0, math.pi / 2, BINS + 1)
    if lamp == "disk":
        return even
    cut = cut_off(length)
    return np.array([*np.linspace(0, cut, BINS + 1), *np.linspace(cut, math.pi / 2, BINS // 2 + 1)[1:]])


def intensity(lamp: str, theta: np.ndarray, power: float, length: float) -> np.ndarray:
    """Exact intensity at a polar angle [W sr^-1]."""
    theta = np.asarray(theta, dtype=float)
    if lamp == "sphere":
        return np.full_like(theta, power / (4 * math.pi))
    mu = np.maximum(np.cos(theta), 0.0)
    whole = power / math.pi * mu
    if lamp == "disk":
        return whole
    u = np.arccos(np.clip(length * np.tan(np.minimum(theta, 1.57)) / (2 * RADIUS), 0, 1))
    seen = 2 / math.pi * (u - np.sin(u) * np.cos(u))
    return whole * (seen if lamp == "tube" else 1 - seen)


def bin_intensities(lamp: str, power: float, length: float) -> np.ndarray:
    """Exact mean intensity of each bin [W sr^-1]."""
    nodes, weights = legendre_nodes(96)
    ends = edges(lamp, length)
    low, high = ends[:-1, None], ends[1:, None]
    # Square-root ends at the cut-off: substitute θ = middle + half sin(π s/2).
    theta = (low + high) / 2 + (high - low) / 2 * np.sin(math.pi / 2 * nodes)
    slope = (high - low) / 2 * math.pi / 2 * np.cos(math.pi / 2 * nodes)
    flux = (intensity(lamp, theta, power, length) * np.sin(theta) * slope) @ weights
    return flux / -np.diff(np.cos(ends))


def power_out(lamp: str, power: float, length: float) -> float:
    """Exact power that leaves [W]."""
    through = float(view_factors.coaxial_disks(RADIUS, RADIUS, length))
    return power * {"tube": through, "shade": 1 - through}.get(lamp, 1.0)


def _row(ends: np.ndarray) -> str:
    low, high = np.degrees(ends)
    return f"I, θ {low:.4g}° to {high:.4g}°"


def _lamp(scene: tp.Scene) -> tuple[str, float]:
    """Which lamp a scene shows, and the length."""
    [source] = scene.sources
    if scene.surfaces:
        [surface] = scene.surfaces
        shape = surface.shape
        return surface.name, shape.height if surface.name == "tube" else shape.center[2]
    return ("sphere" if isinstance(source.shape, tp.Sphere) else "disk"), 0.1


def _shown(lamp: str, length: float) -> np.ndarray:
    """Bins of the table: those before a cut-off."""
    count = {"sphere": 2 * BINS, "disk": BINS}.get(lamp, BINS)
    return np.arange(EVERY // 2, count, EVERY)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    lamp, length = _lamp(result.scene)
    ends, measured = edges(lamp, length), result["photometer"].intensity_out
    rows = {_row(ends[i : i + 2]): measured[int(i)] for i in _shown(lamp, length)}
    if lamp == "tube":
        beyond = -np.diff(np.cos(ends[BINS:]))
        rows[BEYOND] = (measured[BINS:] * (beyond / beyond.sum())).sum()
    total = (measured * (-2 * math.pi * np.diff(np.cos(ends))) * constant(result, 1.0, "sr")).sum()
    total = sharp(total, of=total)  # all that is emitted leaves, unless something absorbs it
    return rows | {TOTAL: total, SHARE: total / result.ledger["emitted"]}


@of_scene(scene)
def exact(lamp: str, power: float, length: float) -> dict[str, float]:
    ends, means = edges(lamp, length), bin_intensities(lamp, power, length)
    rows = {_row(ends[i : i + 2]): float(means[i]) for i in _shown(lamp, length)}
    leaves = power_out(lamp, power, length)
    return rows | ({BEYOND: 0.0} if lamp == "tube" else {}) | {TOTAL: leaves, SHARE: leaves / power}


# ---- answer and pictures ----


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        share = outcome[SHARE].estimate
        said.append(f"{outcome.given['lamp']}: ∫I dω is {share.value:.4g} of its power")
    return sentence(*said, furthest(outcomes))


def draw_curves(outcomes: list[Outcome], path: Path, note: str) -> None:
    """For each lamp its section and its intensity as a polar curve, downwards the axis, as lamps are drawn."""
    from transport.viz.style import BLUE, INK, MUTED, ORANGE, figure

    columns = min(2, len(outcomes))
    rows = -(-len(outcomes) // columns)
    title = "A lamp's curve: intensity by direction, in W/sr"
    with figure((8.6 * columns, 7.4 * rows + 1.4), title, note, path) as page:
        grid = page.add_gridspec(rows, 2 * columns, width_ratios=(0.55, 1) * columns)
        for k, outcome in enumerate(outcomes):
            row, column = k // columns, 2 * (k % columns)
            lamp, power, length = (outcome.given[name] for name in ("lamp", "power", "length"))
            beside = page.add_subplot(grid[row, column])
            _draw_lamp(beside, lamp, length, INK, ORANGE)
            axes = page.add_subplot(grid[row, column + 1], projection="polar")
            theta = np.linspace(-math.pi, math.pi, 1441)
            axes.plot(theta, intensity(lamp, np.abs(theta), power, length), color=BLUE, lw=3, label="exact")
            level = np.full_like(theta, power_out(lamp, power, length) / (4 * math.pi))
            axes.plot(theta, level, "--", color=MUTED, lw=2.5, label="Φ/4π, alike to all sides")
            measured = outcome.result["photometer"].intensity_out
            ends = edges(lamp, length)
            middles = (ends[1:] + ends[:-1]) / 2
            for side in (1, -1):
                axes.errorbar(
                    side * middles,
                    measured.value,
                    np.nan_to_num(measured.error),
                    fmt="o",
                    color=BLUE,
                    label="counted" if side > 0 else None,
                    ms=9,
                    mec="white",
                )
            axes.set_theta_zero_location("S")
            axes.set_xticks(
                np.radians([0, 45, 90, 135, 180, 225, 270, 315]),
                ["0°", "45°", "90°", "", "180°", "", "90°", "45°"],
            )
            top = 1.15 * max(measured.value.max(), level[0])
            axes.set(ylim=(0, top), title=f"∫I dω = {outcome[TOTAL].estimate.value:.4g} W\nof {power:g} W")
            axes.set_yticks(
                np.linspace(0, top, 4)[1:], [f"{t:.2g}" for t in np.linspace(0, top, 4)[1:]], fontsize=18
            )
            if lamp == "tube":
                for side in (1, -1):
                    axes.plot([side * cut_off(length)] * 2, [0, top], ":", color=INK, lw=2)
                axes.text(cut_off(length) + 0.14, 0.62 * top, "cut-off", ha="left", va="center")
            axes.set_rlabel_position(157)
            if k == 0:
                page.legend(*axes.get_legend_handles_labels(), loc="outside lower left", ncols=3, fontsize=20)


def _draw_lamp(axes, lamp: str, length: float, ink: str, light: str) -> None:
    """Section of a lamp that shines down."""
    from matplotlib.patches import Circle

    wide = {"color": light, "lw": 9, "solid_capstyle": "butt"}
    edge = {"color": ink, "lw": 6, "solid_capstyle": "butt"}
    if lamp == "sphere":
        axes.add_patch(Circle((0, 0), RADIUS, fc=light, ec="none"))
    else:
        axes.plot([-RADIUS, RADIUS], [0, 0], **wide)
    if lamp == "tube":
        for side in (-1, 1):
            axes.plot([side * RADIUS] * 2, [0, -length], **edge)
            axes.plot([side * RADIUS, -side * RADIUS * 2], [0, -1.5 * length], ":", color=ink, lw=2)
    elif lamp == "shade":
        axes.plot([-RADIUS, RADIUS], [-length, -length], **edge)
    names = {
        "disk": "diffuse\ndisk",
        "sphere": "diffuse\nsphere",
        "tube": "disk in a\nblack tube",
        "shade": "disk above\na black disk",
    }
    axes.set_title(names[lamp])
    axes.set(aspect="equal", xlim=(-0.13, 0.13), ylim=(-0.16, 0.06))
    axes.set_axis_off()


draw = figures(curves=draw_curves)


if __name__ == "__main__":
    main(__file__)
