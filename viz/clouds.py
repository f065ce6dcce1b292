"""A cloud of voxels as it looks, computed from what a run counted; below, the light on the ground."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from transport import EstimateArray
from transport.viz.style import BLUE, INK, MUTED, POINTS, VERMILLION, figure_at, with_unit

PIXELS, STEPS = (760, 350), 100  # of the view; places along each line of sight
LINES = 40_000  # of sight, taken at a time
SKY_LOW, SKY_HIGH = np.array([0.20, 0.30, 0.40]), np.array([0.03, 0.09, 0.21])  # of white in full sun; chosen
EARTH = np.array([1.12, 1.06, 0.72])  # tint of the ground; chosen
EXPOSURE = 3.0
OPAQUE = 1e-3  # share of light let through, below which no more is added
COLOURS = "inferno"


class Voxels(NamedTuple):
    """A cloud between the corners low and high [m].

    extinction (nx, ny, nz) [m^-1];  direct (nx, ny, nz): fluence rate of straight light [W m^-2];  scattered
    (mx, my, mz): of the rest, in coarser cells;  albedo, density(mu): of the droplets;  down: where the light
    goes;  sun: irradiance across it [W m^-2].
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    extinction: np.ndarray
    direct: np.ndarray
    scattered: np.ndarray
    albedo: float
    density: Callable[[float | np.ndarray], float | np.ndarray]
    down: tuple[float, float, float]
    sun: float


class Ground(NamedTuple):
    """Bins of the ground at z = 0: x, y their edges [m]; irradiances, all light and straight light alone, and
    the exact means of the latter, (nx, ny) [W m^-2];  albedo: of the ground, which scatters evenly.
    """

    x: np.ndarray
    y: np.ndarray
    light: EstimateArray
    direct: EstimateArray
    expected: np.ndarray
    albedo: float


def cloud_picture(
    voxels: Voxels,
    ground: Ground,
    path: str | os.PathLike,
    eye: tuple[float, float, float],
    target: tuple[float, float, float],
    title: str | None = None,
    note: str | None = None,
) -> str | os.PathLike:
    """Draw the view from `eye` to `target` [m], maps of the light on the ground, and a cut through the
    shadow; returns the path.
    """
    with figure_at(path, (21, 19.6), title, note) as figure:
        above, below = figure.subfigures(2, 1, height_ratios=(1.12, 1))
        axes = above.subplots()
        axes.imshow(view(voxels, ground, eye, target), interpolation="bicubic")
        axes.axis("off")
        _point_out_sun(axes, voxels.down)
        _tell_how_it_was_made(axes)
        maps, cut = below.subfigures(1, 2, width_ratios=(1.62, 1))
        _draw_maps(maps, ground)
        _draw_cut(cut.subplots(), ground)
    return path


def _point_out_sun(axes: Axes, down: tuple[float, float, float]) -> None:
    """An arrow along the light, as it is seen from the south."""
    style = {"arrowstyle": "-|>", "color": "white", "lw": 3, "mutation_scale": 28}
    start, length = np.array([0.05, 0.94]), 0.2
    end = start + length * np.array([down[0] * PIXELS[1] / PIXELS[0], down[2]])
    axes.annotate("", end, start, xycoords="axes fraction", arrowprops=style)
    axes.text(
        *(start + (0.035, -0.03)), "sunlight", color="white", transform=axes.transAxes, va="top", fontsize=19
    )


def _tell_how_it_was_made(axes: Axes) -> None:
    """That it is no photograph: what of it was counted, and what was chosen."""
    words = "the view is computed from the light counted in the voxels and on the ground; colours and sky are chosen"
    axes.text(1.0, -0.015, words, color=MUTED, fontsize=18, ha="right", va="top", transform=axes.transAxes)


def view(
    voxels: Voxels,
    ground: Ground,
    eye: tuple[float, float, float],
    target: tuple[float, float, float],
    pixels: tuple[int, int] = PIXELS,
) -> np.ndarray:
    """Picture (height, width, 3) from 0 to 1: radiance over that of a white surface in full sun, darkened
    towards 1.
    """
    eye, rays = np.asarray(eye, float), _rays(eye, np.asarray(target, float), pixels)
    shades = np.concatenate(
        [_shades(voxels, ground, eye, rays[k : k + LINES]) for k in range(0, len(rays), LINES)]
    )
    bright = 1 - np.exp(-EXPOSURE * shades)
    return np.clip(bright ** (1 / 2.2), 0, 1).reshape(pixels[1], pixels[0], 3)


def along_sight(
    voxels: Voxels, eye: np.ndarray, rays: np.ndarray, steps: int = STEPS
) -> tuple[np.ndarray, np.ndarray]:
    """What the cloud sends along rays (n, 3) to the eye [W m^-2 sr^-1], and the share that passes through it,
    (n,) each.
    """
    low, high = np.asarray(voxels.low), np.asarray(voxels.high)
    with np.errstate(divide="ignore"):
        crossings = np.sort([(low - eye) / rays, (high - eye) / rays], axis=0)
    near, far = np.maximum(crossings[0].max(axis=1), 0), crossings[1].min(axis=1)
    phase = np.asarray(voxels.density(-rays @ np.asarray(voxels.down)))
    sent, passed = np.zeros(len(rays)), np.ones(len(rays))
    seen = np.flatnonzero(far > near)  # rays that still gather something
    for k in range(steps):
        seen = seen[passed[seen] > OPAQUE]
        length = (far - near)[seen] / steps
        places = eye + (near[seen] + (k + 0.5) * length)[:, None] * rays[seen]
        share = (places - low) / (high - low)
        through = np.exp(-_between(voxels.extinction, share) * length)
        glow = phase[seen] * _between(voxels.direct, share) + _between(voxels.scattered, share) / (
            4 * math.pi
        )
        sent[seen] += passed[seen] * (1 - through) * voxels.albedo * glow
        passed[seen] *= through
    return sent, passed


def _rays(eye: np.ndarray, target: np.ndarray, pixels: tuple[int, int]) -> np.ndarray:
    """Directions of the pixels, row by row from above; the target is in the middle, 48 degrees are across."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, (0, 0, 1))
    right /= np.linalg.norm(right)
    up, half = np.cross(right, forward), math.tan(math.radians(24))
    x = half * (2 * (np.arange(pixels[0]) + 0.5) / pixels[0] - 1)
    y = half * pixels[1] / pixels[0] * (1 - 2 * (np.arange(pixels[1]) + 0.5) / pixels[1])
    rays = forward + x[None, :, None] * right + y[:, None, None] * up
    return (rays / np.linalg.norm(rays, axis=-1, keepdims=True)).reshape(-1, 3)


def _shades(voxels: Voxels, ground: Ground, eye: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Radiance over that of a white surface across the sun, (n, 3)."""
    white = voxels.sun / math.pi
    sent, passed = along_sight(voxels, eye, rays)
    down = rays[:, 2] < 0
    behind = SKY_LOW + (SKY_HIGH - SKY_LOW) * np.clip(rays[:, 2:] / 0.35, 0, 1) ** 0.7
    hit = eye[:2] - rays[down, :2] * (eye[2] / rays[down, 2:])
    behind[down] = (ground.albedo / math.pi / white * _lit(ground, hit))[:, None] * EARTH
    haze = np.clip(-eye[2] / np.where(down, rays[:, 2], -1) / 60_000, 0, 1)[:, None] * down[:, None]
    behind = behind * (1 - haze) + SKY_LOW * haze
    return (sent / white)[:, None] + passed[:, None] * behind


def _lit(ground: Ground, places: np.ndarray) -> np.ndarray:
    """Irradiance at places (n, 2) of the ground: straight light exactly, the rest as counted, smoothed over 3
    by 3 bins.
    """
    from scipy.ndimage import uniform_filter

    rest = uniform_filter(ground.light.value - ground.direct.value, 3, mode="nearest")
    share = np.stack(
        [(places[:, k] - e[0]) / (e[-1] - e[0]) for k, e in enumerate((ground.x, ground.y))], axis=1
    )
    return _between(ground.expected + rest, share)


def _between(field: np.ndarray, share: np.ndarray) -> np.ndarray:
    """A field of cells at places, as shares (n, dims) of its extent, linear between the cells' middles."""
    from scipy.ndimage import map_coordinates

    return map_coordinates(field, (share * field.shape - 0.5).T, order=1, mode="nearest")


def _draw_maps(figure, ground: Ground) -> None:
    """All light, and what of it was scattered."""
    panels = figure.subplots(1, 2, sharey=True)
    fields = {
        "light on the ground": ground.light.value,
        "of that scattered": ground.light.value - ground.direct.value,
    }
    for axes, (label, field) in zip(panels, fields.items(), strict=True):
        mesh = axes.pcolormesh(
            ground.x / 1e3,
            ground.y / 1e3,
            field.T,
            cmap=COLOURS,
            vmin=0,
            vmax=np.quantile(field, 0.998),
            rasterized=True,
        )
        axes.set_aspect("equal")
        axes.grid(False)
        axes.set_title(label)
        axes.set_xlabel("x  [km]")
        axes.axhline(0, color="white", lw=1.2, ls="--")
        bar = figure.colorbar(mesh, ax=axes, orientation="horizontal", pad=0.03, extend="max")
        bar.set_label(with_unit("irradiance", ground.light.unit))
        bar.ax.xaxis.set_major_locator(MaxNLocator(5))
    panels[0].set_ylabel("y  [km]")


def _draw_cut(axes: Axes, ground: Ground) -> None:
    """The two rows of bins about y = 0: straight light on its exact means, and all light."""
    middle = np.searchsorted(ground.y, 0.0)
    rows = slice(middle - 1, middle + 1)
    x = (ground.x[1:] + ground.x[:-1]) / 2e3
    exact, style = ground.expected[:, rows].mean(axis=1), {"color": INK, "lw": 2, "label": "straight, exact"}
    axes.stairs(exact, ground.x / 1e3, baseline=None, **style)
    for field, colour, marker, label in (
        (ground.direct, BLUE, "o", "straight, simulated"),
        (ground.light, VERMILLION, "s", "all light"),
    ):
        cut = field[:, rows].mean("v")
        axes.errorbar(
            x,
            cut.value,
            2 * np.nan_to_num(cut.error),
            fmt=marker,
            color=colour,
            label=label,
            **POINTS | {"ms": 7},
        )
    axes.set_ylim(bottom=0)
    axes.set_xlabel("x  [km]")
    axes.set_ylabel(with_unit("irradiance", ground.light.unit))
    axes.set_title("cut at y = 0, ± 2 std. errors")
    place = {"bbox_to_anchor": _middle_of_shadow(ground, exact), "bbox_transform": axes.transData}
    axes.legend(loc="center", fontsize=15, handlelength=1.2, handletextpad=0.5, framealpha=0, **place)


def _middle_of_shadow(ground: Ground, exact: np.ndarray) -> tuple[float, float]:
    """Where in the cut no light is drawn, x [km] and irradiance; the middle where nothing is dark."""
    dark = np.flatnonzero(exact < 0.5 * exact.max())
    middle = (ground.x[1:] + ground.x[:-1])[dark].mean() if len(dark) else ground.x[[0, -1]].sum()
    return middle / 2e3, 0.68 * exact.max()
