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
from functools import lru_cache

import numpy as np

import transport as tp
from transport.sims import constant, provenance
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
    if sky not in SKIES or not 0 <= zenith <= FARTHEST or not abs(g) <= 0.9:
        must = f"sky {' or '.join(SKIES)}, zenith from 0 to {FARTHEST:.4g} rad, g from -0.9 to 0.9"
        raise tp.SceneError(f"cloud: must have {must}, got {sky=}, {zenith=}, {g=}")
    if not (0 < extinction < math.inf and 0 <= albedo <= 1):
        raise tp.SceneError(
            f"cloud: must have extinction above 0, albedo 0 to 1, got {extinction=}, {albedo=}"
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
    above = tp.Rectangle(
        center=(middle + SUNRISE * down[0] / down[2], 0, SUNRISE),
        normal=(0, 0, -1),
        width=GROUND,
        height=GROUND,
    )
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


def _zone(name: str) -> str:
    return f"direct light in {name}"


def _zones(means: np.ndarray) -> dict[str, np.ndarray]:
    """Which bins of the ground each row is of; a thin cloud has no deep shadow, and no row for it."""
    held = {_zone(name): (means >= low) & (means < high) for name, (low, high) in ZONES.items()}
    return {name: bins for name, bins in held.items() if bins.any()}


def _expected(result: tp.Result) -> np.ndarray:
    """exp(-τ) in the bins of a run's meter."""
    return direct_means(lit_by(result), float(result.scene.surface("cloud").inside.extinction.max()))


def chi_square(direct: tp.EstimateArray, expected: np.ndarray) -> tp.Estimate:
    """X² over its expectation, of bins in which enough light is expected [W m^-2] to follow a normal law."""
    bright = expected > ENOUGH * expected.max()
    found = direct.values[:, bright] / expected[bright] - 1
    return tp.Estimate(chi_square_values(found, expected[bright], direct.run.sizes), direct.run, "1")


def exact(
    sky: str = "cumulus",
    zenith: float = 40 * tp.deg,
    albedo: float = 0.999,
    g: float = 0.85,
    extinction: float = 0.05,
    ground: float = 0.2,
) -> dict[str, float]:
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
    result, scores = outcome.result, [abs(row.z) for row in outcome.rows if not math.isnan(row.z)]
    off = f"; the furthest of {len(scores)} figures is {max(scores, default=0):.1f} standard errors off"
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


def draw(outcomes: list[Outcome], path: str) -> None:
    """The cumulus and the light below it; of layers alone, their shares against the slab's."""
    shown = next((outcome for outcome in outcomes if "light" in outcome.result), None)
    if shown is None:
        draw_shares(outcomes, path)
    else:
        draw_cloud(shown, path)


def draw_cloud(outcome: Outcome, path: str) -> None:
    """A view from the south, the sun on the left; maps and a cut."""
    from transport.viz.clouds import Ground, Voxels, cloud_picture

    result = outcome.result
    grid, down = result.scene.surface("cloud").inside, lit_by(result)
    straight = SUN * np.exp(-_depths_within(grid.extinction, down))
    coarse = straight.reshape([m for n, c in zip(SHAPE, CELLS, strict=True) for m in (c, n // c)]).mean(
        axis=(1, 3, 5)
    )
    rest = np.maximum(result["within"].fluence_rate.value - coarse, 0.0)
    albedo = float(grid.albedo.max())
    voxels = Voxels(LOW, HIGH, grid.extinction, straight, rest, albedo, grid.phase.density, down, SUN)
    light, direct = (result[name].irradiance for name in ("light", "direct"))
    x, y = shadow_middle(down) + light.coords["u"], light.coords["v"]
    expected = -SUN * down[2] * _expected(result)
    ground = Ground(x, y, light, direct, expected, result.scene.surface("ground").material.albedo)
    title = "A cloud in the sun, and its shadow"
    cloud_picture(voxels, ground, path, EYE, TARGET, title, provenance([outcome]))


def _depths_within(extinction: np.ndarray, down: tuple[float, float, float]) -> np.ndarray:
    """Optical depths from the sun to the middle of each voxel."""
    edges = [np.linspace(a, b, n + 1) for a, b, n in zip(LOW, HIGH, extinction.shape, strict=True)]
    middles = np.meshgrid(*((e[1:] + e[:-1]) / 2 for e in edges), indexing="ij")
    places = np.stack([m.ravel() for m in middles], axis=1)
    towards = [-x for x in down]
    return optical_depths(extinction, LOW, HIGH, places, towards).reshape(extinction.shape)


def draw_shares(outcomes: list[Outcome], path: str) -> None:
    """Estimates of layers against the slab."""
    from transport.viz.comparisons import comparison

    table = {row.name: (row.estimate, row.exact) for row in outcomes[0].rows}
    comparison(table, path, title="Layers of voxels, and the slab of their depth", note=provenance(outcomes))


if __name__ == "__main__":
    from transport.sims import print_table

    print_table(__file__)
