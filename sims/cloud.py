"""Cloud: what a cloud of voxels does to sunlight, and what can be known of it exactly.

A cumulus of 64 × 64 × 32 voxels of 20 m: domes on a flat base, roughened by noise of Kolmogorov's spectrum
(1941: k^(-11/3)), always the same.  Droplets scatter nearly all light that they meet, mostly forwards (Henyey
and Greenstein 1941, g = 0.85, albedo 0.999).  The sun shines from a side; the ground below scatters back a
fifth.

What is known.  (1) What comes straight through: E exp(-τ), τ the sum over the voxels along the ray, and its
mean over each bin of the ground in closed form (transport/theory/attenuation.py); the scattered light is told from
it by events=0.  The rows are means over zones of the shadow; the verdict tells χ² of all bins at once, over
what chance makes it.  (2) All light goes somewhere: what the ground and the cloud keep and what flies off up
is what came, in the mean, for roulette ends some histories and strengthens others.  (3) Layers: voxels as
wide as the sky, of unlike extinction and one albedo, reflect and let through what one slab of their optical
depth does (discrete ordinates, transport/theory/ordinates.py): R and T depend on τ alone.  A homogeneous grid
is the case of equal layers.

Free paths through voxels are drawn against majorants, without bias for fields that jump from cell to cell
(Woodcock et al. 1965).

Picture.  A view of the cloud, computed from the run: along each line of sight it adds what the voxels send
there, direct light by the phase function and the rest, from the fluence rate that a VolumeDetector counted,
evenly; the ground shines by the light that was counted on it, straight light by its exact means.  Colours,
and how bright the sky is, are chosen; how bright cloud and ground are is not.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

import transport as tp
from transport.sims import constant, figures, furthest, main, of_scene, one_of, require, rows_figure, where
from transport.theory import ordinates
from transport.theory.attenuation import optical_depths, shadow_means
from transport.theory.enclosures import chi_square_values
from transport.verification.experiment import Outcome

law = (
    "E = E₀ cosθ exp(−τ) straight through, R + T + A = 1, R(τ) and T(τ) of layers "
    "(Bouguer 1729; Chandrasekhar 1950; here by sums over voxels and discrete ordinates)"
)
question = "What does a cloud do to sunlight, and how dark is its shadow?"
particles = 4_000_000
intended = {
    "grazing": "no row or picture reads the fluence rate at the ground",
    "roulette survivors": "the map of the ground is for the picture; the rows are of the whole ground",
}

SUN = 1000.0  # W m^-2, across the beam
SKIES = ("cumulus", "layers")
VOXEL, SHAPE, BASE = 20.0, (64, 64, 32), 300.0  # m; voxels; m above the ground
LOW = (-VOXEL * SHAPE[0] / 2, -VOXEL * SHAPE[1] / 2, BASE)
HIGH = (-LOW[0], -LOW[1], BASE + VOXEL * SHAPE[2])
DOMES = ((0, 0, 0.62, 0.95), (-0.42, 0.18, 0.42, 0.6), (0.42, -0.22, 0.45, 0.66), (0.1, 0.45, 0.38, 0.5))
ROUGHNESS, STEEPNESS, SEED, LARGEST = 0.28, 3.0, 5, 2.0  # of the noise; LARGEST: waves across the box
SUNRISE = 1000.0  # m, the height from which the beam starts
GROUND, BIN = 2400.0, 40.0  # m: side of the ground's meter, and of its bins
CELLS = tuple(n // 2 for n in SHAPE)  # of the fluence rate
ZONES = {
    "deep shadow": (0.01, 0.2),
    "half-shadow": (0.2, 0.6),
    "thin rims": (0.6, 0.999),
    "the sun": (0.999, 2.0),
}
ENOUGH = 0.02  # of full light, expected in bins that are judged together
DEPTHS = (0.05, 1.2, 0.2, 0.5, 1.5, 0.0, 0.4, 0.15)  # optical, of layers
WIDE = 1e8  # m
EYE, TARGET = (-450.0, -3000.0, 800.0), (200.0, 0.0, 480.0)  # of the picture [m]
FARTHEST = math.radians(60)
PIXELS, STEPS = (760, 350), 100  # of the view; places along each line of sight
LINES = 40_000  # of sight, taken at a time
SKY_LOW, SKY_HIGH = np.array([0.20, 0.30, 0.40]), np.array([0.03, 0.09, 0.21])  # of white in full sun; chosen
EARTH = np.array([1.12, 1.06, 0.72])  # tint of the ground; chosen
EXPOSURE = 3.0
OPAQUE = 1e-3  # share of light let through, below which no more is added

ALL = "back to the sky + cloud + ground"
REFLECTED, THROUGH, STRAIGHT, KEPT = "reflected", "let through", "of that straight", "absorbed"


def cases() -> list[dict[str, object]]:
    return [{"sky": "cumulus"}, {"sky": "layers"}]


def scene(
    sky: str = "cumulus",
    zenith: float = 40 * tp.deg,
    albedo: float = 0.999,
    g: float = 0.85,
    extinction: float = 0.05,
    ground: float = 0.2,
) -> tp.Scene:
    """A cloud in the sun.  zenith: the sun's angle [rad];  albedo, g: of the droplets;  extinction: the
    cumulus' largest [m^-1];  ground: its albedo, below the cumulus; layers hang free.
    """
    one_of("cloud", sky=(sky, SKIES))
    require(
        "cloud",
        zenith=(zenith, 0 <= zenith <= FARTHEST, f"from 0 to {FARTHEST:.4g} rad"),
        g=(g, abs(g) <= 0.9, "from -0.9 to 0.9"),
        extinction=(extinction, 0 < extinction < math.inf, "above 0 and finite"),
        albedo=(albedo, 0 <= albedo <= 1, "from 0 to 1"),
    )
    down = (math.sin(zenith), 0.0, -math.cos(zenith))
    phase = tp.HenyeyGreenstein(g)
    return (
        _layers(down, albedo, phase) if sky == "layers" else _cumulus(down, albedo, phase, extinction, ground)
    )


def _cumulus(down, albedo, phase, extinction, ground) -> tp.Scene:
    box = tp.Box(center=(0, 0, (LOW[2] + HIGH[2]) / 2), size=np.subtract(HIGH, LOW))
    field = cumulus(extinction)
    grid = tp.Grid(box=box, absorption=(1 - albedo) * field, scattering=albedo * field, phase=phase)
    middle = shadow_middle(down)
    start = (middle + SUNRISE * down[0] / down[2], 0, SUNRISE)
    above = tp.Rectangle(center=start, normal=(0, 0, -1), width=GROUND, height=GROUND)
    meter = tp.Rectangle(center=(middle, 0, 0), up=(0, 1, 0), width=GROUND, height=GROUND)
    bins = tp.Positions(u=round(GROUND / BIN), v=round(GROUND / BIN))
    return tp.Scene(
        tp.Source(above, tp.Beam(down, irradiance=SUN)),
        [
            tp.Surface(tp.Plane(), tp.Diffuse(ground), "ground"),
            tp.Surface(box, tp.Transparent(), "cloud", inside=grid),
        ],
        [
            tp.Detector(tp.Plane(center=(0, 0, 1.1 * SUNRISE), normal=(0, 0, -1)), "sky"),
            tp.Detector("ground", "all ground"),
            tp.Detector(meter, "light", positions=bins),
            tp.Detector(meter, "direct", positions=bins, events=0),
            tp.VolumeDetector(box, "within", cells=CELLS),
        ],
    )


def _layers(down, albedo, phase) -> tp.Scene:
    height = HIGH[2] - LOW[2]
    field = np.array(DEPTHS).reshape(1, 1, -1) * len(DEPTHS) / height
    box = tp.Box(center=(0, 0, -height / 2), size=(WIDE, WIDE, height))
    grid = tp.Grid(box=box, absorption=(1 - albedo) * field, scattering=albedo * field, phase=phase)
    lamp = tp.Rectangle(center=(0, 0, VOXEL), normal=(0, 0, -1), width=VOXEL, height=VOXEL)
    below = tp.Plane(center=(0, 0, -height - VOXEL))
    return tp.Scene(
        tp.Source(lamp, tp.Beam(down, irradiance=SUN)),
        tp.Surface(box, tp.Transparent(), "cloud", inside=grid),
        [
            tp.Detector(tp.Plane(center=(0, 0, 2 * VOXEL), normal=(0, 0, -1)), "sky"),
            tp.Detector(below, "below"),
            tp.Detector(below, "straight", events=0),
        ],
    )


@lru_cache(maxsize=4)
def cumulus(extinction: float) -> np.ndarray:
    """Extinction of the voxels (64, 64, 32) [m^-1]: domes on a flat base, roughened."""
    x, y, z = np.meshgrid(*((np.arange(n) + 0.5) / n for n in SHAPE), indexing="ij")
    domes = [
        1 - ((2 * x - 1 - a) / r) ** 2 - ((2 * y - 1 - b) / r) ** 2 - (z / h) ** 2 for a, b, r, h in DOMES
    ]
    inside = np.max(domes, axis=0) - 0.05 + ROUGHNESS * _noise() * np.sqrt((6 * z).clip(0, 1))
    rim = np.min([x, 1 - x, y, 1 - y, 1 - z], axis=0)
    fades = (z / 0.06).clip(0, 1) * ((rim - 0.02) / 0.05).clip(0, 1)  # at the base, and before the box ends
    return extinction * (STEEPNESS * inside).clip(0, 1) * fades


def _noise() -> np.ndarray:
    """Gaussian noise of variance 1, of spectrum k^(-11/3) but for the largest waves."""
    draws = np.random.default_rng(SEED).standard_normal(SHAPE)
    waves = np.meshgrid(*(SHAPE[0] * np.fft.fftfreq(n) for n in SHAPE), indexing="ij")
    power = (sum(k * k for k in waves) + LARGEST**2) ** (-11 / 6)
    noise = np.fft.ifftn(np.fft.fftn(draws) * np.sqrt(power)).real
    return noise / noise.std()


def shadow_middle(down: tuple[float, float, float]) -> float:
    """x of the middle of the shadow on the ground [m]."""
    return -down[0] / down[2] * (LOW[2] + HIGH[2]) / 2


def direct_means(down: tuple[float, float, float], extinction: float) -> np.ndarray:
    """Exact means of exp(-τ) over the bins of the ground, (bins x, bins y)."""
    count = round(GROUND / BIN)
    edges = shadow_middle(down) + np.linspace(-GROUND / 2, GROUND / 2, count + 1)
    rows = np.ones((count, round(GROUND / VOXEL)))
    first = (rows.shape[1] - SHAPE[1]) // 2
    rows[:, first : first + SHAPE[1]] = shadow_means(
        cumulus(extinction), LOW, HIGH, -down[0] / down[2], edges
    )
    return rows.reshape(count, count, -1).mean(axis=2)


def lit_by(result: tp.Result) -> tuple[float, float, float]:
    """Direction of the sunlight."""
    return result.scene.sources[0].emission.direction


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    emitted = result.ledger["emitted"]
    if "below" in result:
        through = result["below"].flux_in
        return {
            REFLECTED: result["sky"].flux_in / emitted,
            THROUGH: through / emitted,
            STRAIGHT: result["straight"].flux_in / through,
            KEPT: result.ledger["absorbed"] / emitted,
        }
    exact_means, direct = _expected(result), result["direct"].irradiance
    full = constant(result, -SUN * lit_by(result)[2], "W m^-2")
    rows = {}
    for name, held in _zones(exact_means).items():
        rows[name] = tp.Estimate(direct.values[:, held].mean(axis=1), result.run, "W m^-2") / full
    return rows | {ALL: (result["sky"].flux_in + result.ledger["absorbed"]) / emitted}


def _zones(means: np.ndarray) -> dict[str, np.ndarray]:
    """Which bins of the ground each row is of; a thin cloud has no deep shadow, and no row for it."""
    held = {f"direct light in {name}": (means >= a) & (means < b) for name, (a, b) in ZONES.items()}
    return {name: bins for name, bins in held.items() if bins.any()}


def _expected(result: tp.Result) -> np.ndarray:
    """exp(-τ) in the bins of a run's meter."""
    return direct_means(lit_by(result), float(result.scene.surface("cloud").inside.extinction.max()))


def chi_square(direct: tp.EstimateArray, expected: np.ndarray) -> tp.Estimate:
    """X² over its expectation, of bins in which enough light is expected [W m^-2] to follow a normal law."""
    bright = expected > ENOUGH * expected.max()
    found = direct.values[:, bright] / expected[bright] - 1
    return tp.Estimate(chi_square_values(found, expected[bright], direct.run.sizes), direct.run, "1")


@of_scene(scene)
def exact(sky: str, zenith: float, albedo: float, g: float, extinction: float) -> dict[str, float]:
    if sky == "layers":
        depth, mu0 = math.fsum(DEPTHS), math.cos(zenith)
        slab = ordinates.slab(depth, albedo, ordinates.henyey_greenstein(g), mu0)
        straight, kept = math.exp(-depth / mu0) / slab.transmitted, slab.absorbed if albedo < 1 else 0.0
        return {REFLECTED: slab.reflected, THROUGH: slab.transmitted, STRAIGHT: straight, KEPT: kept}
    means = direct_means((math.sin(zenith), 0.0, -math.cos(zenith)), float(cumulus(extinction).max()))
    return {name: float(means[held].mean()) for name, held in _zones(means).items()} | {ALL: 1.0}


# ---- answer and picture ----


def verdict(outcomes: list[Outcome]) -> str:
    return " ".join(_said(outcome) for outcome in outcomes)


def _said(outcome: Outcome) -> str:
    result, off = outcome.result, f"; {furthest([outcome])}"
    back = result["sky"].flux_in / result.ledger["emitted"]
    if "below" in result:
        return f"Layers of optical depth {math.fsum(DEPTHS):.3g} send back {back}, as a slab does{off}."
    share, full = _reflected(result), -SUN * lit_by(result)[2]
    bins = chi_square(result["direct"].irradiance, full * _expected(result))
    return (
        f"Of the light that meets the cumulus {share} more goes back to the sky than without it;{_darkest(result)}"
        f" χ² of all bins of direct light is {bins} of what chance makes it{off}."
    )


def _reflected(result: tp.Result) -> tp.Estimate:
    """Light that the cloud sends back more than the ground alone would, over what meets its shadow."""
    ground = result.scene.surface("ground").material.albedo
    emitted, back = result.ledger["emitted"], result["sky"].flux_in
    shaded = float((1 - _expected(result)).mean())
    return (back / emitted - constant(result, ground, "1")) / constant(result, shaded, "1")


def _darkest(result: tp.Result) -> str:
    """Mean light over full light where less than a thousandth comes straight, if that is anywhere."""
    dark, full = _expected(result) < 1e-3, constant(result, -SUN * lit_by(result)[2], "W m^-2")
    if not dark.any():
        return ""
    left = tp.Estimate(result["light"].irradiance.values[:, dark].mean(axis=1), result.run, "W m^-2") / full
    return f" in the middle of its shadow {left} of full light is left, nearly all of it scattered;"


def draw_cloud(outcomes: list[Outcome], path: Path, note: str) -> None:
    """A view of the cumulus from the south, the sun on the left; maps of the light on the ground, and a cut."""
    from transport.viz.style import figure

    seen, ground = voxels_of(outcomes[0].result), ground_of(outcomes[0].result)
    with figure((21, 19.6), "A cloud in the sun, and its shadow", note, path) as page:
        above, below = page.subfigures(2, 1, height_ratios=(1.12, 1))
        _draw_view(above.subplots(), seen, ground)
        maps, cut = below.subfigures(1, 2, width_ratios=(1.62, 1))
        _draw_maps(maps, ground)
        _draw_cut(cut.subplots(), ground)


class Voxels(NamedTuple):
    """A cloud between the corners LOW and HIGH.

    extinction (nx, ny, nz) [m^-1];  direct (nx, ny, nz): fluence rate of straight light [W m^-2];  scattered
    (mx, my, mz): of the rest, in coarser cells;  albedo, density(mu): of the droplets;  down: where the light goes.
    """

    extinction: np.ndarray
    direct: np.ndarray
    scattered: np.ndarray
    albedo: float
    density: Callable[[float | np.ndarray], float | np.ndarray]
    down: tuple[float, float, float]
    low: tuple[float, float, float] = LOW
    high: tuple[float, float, float] = HIGH


class Ground(NamedTuple):
    """Bins of the ground at z = 0: x, y their edges [m]; irradiances, all light and straight light alone, and
    the exact means of the latter, (nx, ny) [W m^-2];  albedo: of the ground, which scatters evenly.
    """

    x: np.ndarray
    y: np.ndarray
    light: tp.EstimateArray
    direct: tp.EstimateArray
    expected: np.ndarray
    albedo: float


def voxels_of(result: tp.Result) -> Voxels:
    grid, down = result.scene.surface("cloud").inside, lit_by(result)
    straight = SUN * np.exp(-_depths_within(grid.extinction, down))
    coarse = straight.reshape([m for n, c in zip(SHAPE, CELLS, strict=True) for m in (c, n // c)])
    rest = np.maximum(result["within"].fluence_rate.value - coarse.mean(axis=(1, 3, 5)), 0.0)
    return Voxels(grid.extinction, straight, rest, float(grid.albedo.max()), grid.phase.density, down)


def ground_of(result: tp.Result) -> Ground:
    light, direct = (result[name].irradiance for name in ("light", "direct"))
    x, y = shadow_middle(lit_by(result)) + light.coords["u"], light.coords["v"]
    expected = -SUN * lit_by(result)[2] * _expected(result)
    return Ground(x, y, light, direct, expected, result.scene.surface("ground").material.albedo)


def _depths_within(extinction: np.ndarray, down: tuple[float, float, float]) -> np.ndarray:
    """Optical depths from the sun to the middle of each voxel."""
    edges = [np.linspace(a, b, n + 1) for a, b, n in zip(LOW, HIGH, extinction.shape, strict=True)]
    middles = np.meshgrid(*((e[1:] + e[:-1]) / 2 for e in edges), indexing="ij")
    places = np.stack([m.ravel() for m in middles], axis=1)
    return optical_depths(extinction, LOW, HIGH, places, [-x for x in down]).reshape(extinction.shape)


def _draw_view(axes, seen: Voxels, ground: Ground) -> None:
    """The view, with an arrow along the light as it is seen from the south."""
    from transport.viz.style import MUTED

    axes.imshow(view(seen, ground), interpolation="bicubic")
    axes.axis("off")
    start = np.array([0.05, 0.94])
    end = start + 0.2 * np.array([seen.down[0] * PIXELS[1] / PIXELS[0], seen.down[2]])
    style = {"arrowstyle": "-|>", "color": "white", "lw": 3, "mutation_scale": 28}
    axes.annotate("", end, start, xycoords="axes fraction", arrowprops=style)
    beside = {"transform": axes.transAxes, "va": "top", "fontsize": 19}
    axes.text(*(start + (0.035, -0.03)), "sunlight", color="white", **beside)
    words = "the view is computed from the light counted in the voxels and on the ground; colours and sky are chosen"
    axes.text(1.0, -0.015, words, color=MUTED, ha="right", **beside)


def view(voxels: Voxels, ground: Ground) -> np.ndarray:
    """Picture (height, width, 3) from 0 to 1: radiance over that of a white surface in full sun, darkened towards 1."""
    eye, rays = np.array(EYE), _rays(np.array(EYE), np.array(TARGET), PIXELS)
    parts = [_shades(voxels, ground, eye, rays[k : k + LINES]) for k in range(0, len(rays), LINES)]
    bright = 1 - np.exp(-EXPOSURE * np.concatenate(parts))
    return np.clip(bright ** (1 / 2.2), 0, 1).reshape(PIXELS[1], PIXELS[0], 3)


def along_sight(
    voxels: Voxels, eye: np.ndarray, rays: np.ndarray, steps: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """What the cloud sends along rays (n, 3) to the eye [W m^-2 sr^-1], and the share that passes through it,
    (n,) each.
    """
    low, high = np.asarray(voxels.low), np.asarray(voxels.high)
    with np.errstate(divide="ignore"):
        crossings = np.sort([(low - eye) / rays, (high - eye) / rays], axis=0)
    near, far = np.maximum(crossings[0].max(axis=1), 0), crossings[1].min(axis=1)
    phase = np.asarray(voxels.density(-rays @ np.asarray(voxels.down)))
    sent, passed, steps = np.zeros(len(rays)), np.ones(len(rays)), steps or STEPS
    seen = np.flatnonzero(far > near)  # rays that still gather something
    for k in range(steps):
        seen = seen[passed[seen] > OPAQUE]
        length = (far - near)[seen] / steps
        places = eye + (near[seen] + (k + 0.5) * length)[:, None] * rays[seen]
        share = (places - low) / (high - low)
        through = np.exp(-_between(voxels.extinction, share) * length)
        even = _between(voxels.scattered, share) / (4 * math.pi)
        glow = phase[seen] * _between(voxels.direct, share) + even
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
    white = SUN / math.pi
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
    shares = [(places[:, k] - e[0]) / (e[-1] - e[0]) for k, e in enumerate((ground.x, ground.y))]
    return _between(ground.expected + rest, np.stack(shares, axis=1))


def _between(field: np.ndarray, share: np.ndarray) -> np.ndarray:
    """A field of cells at places, as shares (n, dims) of its extent, linear between the cells' middles."""
    from scipy.ndimage import map_coordinates

    return map_coordinates(field, (share * field.shape - 0.5).T, order=1, mode="nearest")


def _draw_maps(page, ground: Ground) -> None:
    """All light, and what of it was scattered."""
    from transport.viz.style import SEQUENTIAL, with_unit

    panels, scattered = page.subplots(1, 2, sharey=True), ground.light.value - ground.direct.value
    fields = {"light on the ground": ground.light.value, "of that scattered": scattered}
    for axes, (label, field) in zip(panels, fields.items(), strict=True):
        style = {"cmap": SEQUENTIAL, "vmin": 0, "vmax": np.quantile(field, 0.998), "rasterized": True}
        mesh = axes.pcolormesh(ground.x / 1e3, ground.y / 1e3, field.T, **style)
        axes.set(aspect="equal", title=label, xlabel="x  [km]")
        axes.grid(False)
        axes.axhline(0, color="white", lw=1.2, ls="--")
        bar = page.colorbar(mesh, ax=axes, orientation="horizontal", pad=0.03, extend="max")
        bar.set_label(with_unit("irradiance", ground.light.unit))
        bar.ax.locator_params(nbins=5)
    panels[0].set_ylabel("y  [km]")


def _draw_cut(axes, ground: Ground) -> None:
    """The two rows of bins about y = 0: straight light on its exact means, and all light."""
    from transport.viz.curves import Series, plot_curves

    middle = np.searchsorted(ground.y, 0.0)
    rows, edges = slice(middle - 1, middle + 1), ground.x / 1e3
    straight, light = (field[:, rows].mean("v") for field in (ground.direct, ground.light))
    expected = ground.expected[:, rows].mean(axis=1)
    series = {"straight": Series(edges, straight, expected=expected), "all light": Series(edges, light)}
    plot_curves(series, ax=axes, xlabel="x  [km]", ylabel="irradiance", legend="below")
    axes.set_title("cut at y = 0")


draw = figures(
    cloud=(draw_cloud, where(sky="cumulus")),
    layers=(
        rows_figure("Layers of voxels, and the slab of their depth", lambda row, _: row.name),
        lambda of: [] if where(sky="cumulus")(of) else of,
    ),
)


if __name__ == "__main__":
    main(__file__)
