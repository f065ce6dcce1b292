"""Glow: hot fog between walls of its own temperature looks like nothing at all; alone in the dark it has a shape.

Derivation.  What absorbs the share σ_a ds of radiance emits σ_a n² L₀ ds, L₀ being a black body's radiance at that
temperature and n the index there (Kirchhoff 1860, Ann. Phys. 185, 275).  Along a ray dL/ds = σ_a (n² L₀ - L) + what
scattering brings less what it takes.  If L = n² L₀ in all directions, absorption and emission are in balance, and so is
scattering by any phase function, as ∫ p dω = 1: nothing changes along any ray.  Walls that give off (1 - albedo) L₀ and
send back the rest complete it: L is n² L₀ everywhere, fluence rate 4π n² L₀, irradiance π n² L₀, and what a body absorbs
is what it emits.

Take the walls away, and a ray that comes from the dark and runs s through the fog brings L₀ (1 - exp(-σ_a s)): a thin fog
shines by its depth, a thick one as a black body.  A ball of radius R sends out the share P = 3 ε/(4 σ_a R) of its own light,
ε = 1 - (1 - (1 + 2x) e^(-2x))/2x², x = σ_a R; a slab (1 - 2 E₃(τ))/2τ (Case, de Hoffmann and Placzek 1953).

Chi-square.  As in `furnace`, for the verdict: X² = Σ w (mean of d)² over all bins, d = L/(n² L₀) - 1, over its
expectation; bins are correlated, which `transport.theory.enclosures` deals with.

Scenes.  "furnace": a grey room of 1.2 m, in which air scatters but does not absorb, with a thin fog, a thick one that
touches it, a ball, glass that absorbs, scatters and glows (so that it is bright beyond its escape cone as well), and
voxels.  "ball", "slab": of the optical radius or thickness `depth`, alone; the slab is a box between four mirrors.
"""

from __future__ import annotations

import math

import numpy as np

import transport as tp
from transport.sims import (
    Deviations,
    constant,
    curves_figure,
    figures,
    main,
    of_scene,
    one_of,
    require,
    rows_figure,
    where,
)
from transport.theory import glow as theory
from transport.verification.experiment import Outcome

law = "L = n² L₀ between walls, L₀ (1 − e^(−σ_a s)) without; P = 3ε/4x, (1 − 2E₃)/2τ (Kirchhoff 1860; Case et al. 1953)"
question = "What does hot fog look like between hot walls, and in the dark?"
particles = 1_000_000

SHOWS = ("furnace", "ball", "slab")
ROOM, CELLS, SIDE = 1.2, 3, 0.3  # m; cells of the room along each axis; m, of a block of fog
BINS = 10  # of the cosine, alone
SHELLS = 8
BRIGHTEST = 1 - 1e-9  # L/L₀: what is nearer to a black body is drawn there
FOGS, BODIES = ("thin", "thick", "ball", "voxels"), ("thin", "thick", "ball", "voxels", "glass")
KINDS = {
    "the walls": ("walls",),
    "faces of fog": tuple(f"{name} {side}" for name in FOGS for side in ("inside", "outside")),
    "faces of glass": ("glass inside", "glass outside"),
    "within fog": tuple(f"in {name}" for name in FOGS),
    "within glass": ("in glass",),
    "the whole room": ("in room",),
}
ESCAPED = "escaped"
SHARE, TAKEN = "share of its light that escapes", "share that it absorbs"
GRAZING, STRAIGHT = "L/L₀ that leaves, μ 0.1 to 0.2", "L/L₀ that leaves, μ 0.9 to 1"
CENTRE, CRUST = "fluence rate / 4π L₀, innermost shell", "fluence rate / 4π L₀, outermost shell"


def cases() -> list[dict[str, object]]:
    balls = [{"show": "ball", "depth": depth} for depth in (0.1, 1.0, 5.0)]
    return [{"show": "furnace"}, *balls, {"show": "slab"}]


def scene(
    show: str = "furnace", depth: float = 1.0, albedo: float = 0.4, index: float = 1.5, radiance: float = 1.0
) -> tp.Scene:
    """Hot fog, one of SHOWS.  depth: optical, of a ball's radius or a slab;  albedo: of the furnace's walls, 0: black;
    index: of its glass;  radiance: L₀ [W m^-2 sr^-1].
    """
    one_of("glow", show=(show, SHOWS))
    require(
        "glow",
        albedo=(albedo, 0 <= albedo < 1, "0 to below 1 (a white wall does not glow)"),
        depth=(depth, 0 < depth < math.inf, "above 0 and finite"),
        radiance=(radiance, 0 < radiance < math.inf, "above 0 and finite"),
    )
    if show == "furnace":
        return _furnace(albedo, index, radiance)
    fog = tp.Medium(absorption=depth, emission=theory.emission(depth, radiance))
    bins = tp.Directions(mu=BINS)
    if show == "ball":
        ball = tp.Surface(tp.Sphere(radius=1.0), tp.Transparent(), "ball", inside=fog)
        shells = tp.VolumeDetector("ball", "shells", cells=(SHELLS,))
        return tp.Scene((), ball, [tp.Detector("ball", directions=bins), shells])
    box = tp.Box(size=1.0)
    top, sides = box.faces()["+z"], [face for face in box.faces().values() if face.normal[2] == 0]
    slab = tp.Surface(box, tp.Transparent(), "slab", inside=fog)
    mirrors = [tp.Surface(side, tp.Mirror(), f"mirror {k}") for k, side in enumerate(sides)]
    return tp.Scene((), [slab, *mirrors], tp.Detector(top, "top", directions=bins))


def _furnace(albedo: float, index: float, radiance: float) -> tp.Scene:
    air = tp.Medium(scattering=1.0, phase=tp.Rayleigh())
    wall = tp.Diffuse(albedo) if albedo > 0 else tp.Black()
    surfaces = [tp.Surface(tp.Box(size=ROOM), wall, "room", inside=air), *_bodies(index, radiance)]
    source = tp.Source("room", tp.Lambertian(radiance=(1 - albedo) * radiance), side="inside")
    cosines, around = tp.Directions(mu=6, phi=8), tp.Directions.sphere(mu=6, phi=4)
    meters = [tp.Detector("room", "walls", side="inside", directions=cosines)]
    for body in BODIES:
        for side in ("inside", "outside"):
            meters.append(tp.Detector(body, f"{body} {side}", side=side, directions=cosines))
        estimator = "collision" if body == "thick" else "track"
        meters.append(tp.VolumeDetector(body, f"in {body}", directions=around, estimator=estimator))
    cells = (CELLS,) * 3
    return tp.Scene(
        source, surfaces, [*meters, tp.VolumeDetector("room", "in room", cells=cells, directions=around)]
    )


def _bodies(index: float, radiance: float) -> list[tp.Surface]:
    """What glows in the room, each within one cell of it."""
    ball, glass = tp.Sphere(center=(0.4, 0.4, 0.4), radius=0.15), tp.Box(center=(-0.4, -0.4, 0.4), size=0.25)
    thin, thick = (tp.Box(center=(x, -0.4, -0.4), size=SIDE) for x in (-0.15, 0.15))
    voxels = tp.Box(center=(0, 0.4, 0), size=SIDE)
    scattering = 60 * np.random.default_rng(1).random((4, 4, 4))
    hg = tp.HenyeyGreenstein

    def fog(absorption: float, scattering: float = 0.0, phase=None, n: float = 1.0) -> tp.Medium:
        emission = theory.emission(absorption, radiance, n)
        return tp.Medium(absorption, scattering, phase or tp.Isotropic(), n, emission)

    glow = theory.emission(4.0, radiance)
    grid = tp.Grid(box=voxels, absorption=4.0, scattering=scattering, phase=hg(-0.5), emission=glow)
    return [
        tp.Surface(thin, tp.Transparent(), "thin", inside=fog(0.5)),
        tp.Surface(thick, tp.Transparent(), "thick", inside=fog(20.0, 40.0, hg(0.8))),
        tp.Surface(ball, tp.Transparent(), "ball", inside=fog(2.0, 10.0)),
        tp.Surface(voxels, tp.Transparent(), "voxels", inside=grid),
        tp.Surface(glass, tp.Dielectric(index), "glass", inside=fog(3.0, 5.0, tp.Rayleigh(), index)),
    ]


def show_of(result: tp.Result) -> str:
    return {"room": "furnace"}.get(result.scene.surfaces[0].name, result.scene.surfaces[0].name)


def shine_of(result: tp.Result) -> float:
    """L₀ [W m^-2 sr^-1]: what the first medium emits, over what it absorbs."""
    medium = result.scene.surfaces[1 if show_of(result) == "furnace" else 0].inside
    return medium.emission / medium.absorption


# ---- what is measured ----


def levels(scene: tp.Scene) -> dict[str, np.ndarray]:
    """Radiance over L₀ that the furnace's meters should have: n² of the medium, a mean in the cell that holds the glass."""
    glass = scene.surface("glass")
    bright = glass.inside.index**2
    found = {name: np.float64(1.0) for names in KINDS.values() for name in names}
    found |= {"glass inside": np.float64(bright), "in glass": np.float64(bright)}
    cells = np.ones((CELLS, CELLS, CELLS, 1, 1))
    cells[0, 0, 2] += (bright - 1) * glass.shape.volume / (ROOM / CELLS) ** 3
    return found | {"in room": cells}


def deviations(result: tp.Result, expected: dict[str, np.ndarray]) -> Deviations:
    """L/expected of all bins of these meters; a volume's cells count as 1/4 of their surface's solid angle."""
    found, weights, shine = [], [], shine_of(result)
    for name, level in expected.items():
        reading = result[name]
        meter, shape = reading.detector, result.scene.shape_of(reading.detector)
        mu, phi = meter.directions.edges().values()
        if isinstance(meter, tp.VolumeDetector):
            angles = np.outer(np.diff(mu), np.diff(phi)) / 4
            sizes = (meter.volumes(shape) ** (2 / 3) * 6)[..., None, None]
            radiances = (reading.radiance,)
        else:
            angles, sizes = np.outer(np.diff(mu**2), np.diff(phi)) / 2, shape.area
            radiances = (reading.radiance, reading.radiance_out)
        for radiance in radiances:
            bright, throughput = np.broadcast_arrays(level, sizes * angles)
            found.append((radiance.values / (shine * bright) - 1).reshape(len(result.run), -1))
            weights.append((bright * throughput).ravel())
    return Deviations(result, np.concatenate(found, axis=1), np.concatenate(weights))


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    if show_of(result) == "furnace":
        known, rows = levels(result.scene), {}
        for kind, names in KINDS.items():
            rows[f"L/n²L₀, {kind}"] = deviations(result, {name: known[name] for name in names}).mean()
        return rows | _balances(result) | {ESCAPED: result.ledger["escaped"]}
    emitted, leaving = result.ledger["emitted"], leaving_share(result)
    rows = {
        SHARE: result.ledger["escaped"] / emitted,
        TAKEN: result.ledger["absorbed"] / emitted,
        GRAZING: leaving[1],
        STRAIGHT: leaving[-1],
    }
    if show_of(result) == "slab":
        return rows
    shells = result["shells"].fluence_rate / constant(result, 4 * math.pi * shine_of(result), "W m^-2")
    return rows | {CENTRE: shells[0], CRUST: shells[-1]}


def leaving_share(result: tp.Result) -> tp.EstimateArray:
    """Radiance that leaves a ball or slab in the dark, over L₀, by the cosine to its normal, (BINS,) [1]."""
    meter = "ball" if show_of(result) == "ball" else "top"
    return result[meter].radiance_out / constant(result, shine_of(result), "W m^-2 sr^-1")


def _balances(result: tp.Result) -> dict[str, tp.Estimate]:
    """What each body absorbs over what it emits, and the walls."""
    scene, kept = result.scene, result.ledger.absorbed_by
    glow = {
        name: 4 * math.pi * scene.surface(name).inside.emission * scene.surface(name).shape.volume
        for name in BODIES
    }
    rows = {_balance(name): kept[f"inside {name}"] / constant(result, glow[name], "W") for name in BODIES}
    walls = math.pi * scene.sources[0].emission.radiance * scene.surface("room").shape.area
    return rows | {_balance("walls"): kept["room"] / constant(result, walls, "W")}


def _balance(name: str) -> str:
    return f"absorbed / emitted, {name}"


@of_scene(scene)
def exact(show: str, depth: float) -> dict[str, float]:
    if show == "furnace":
        ones = [*(f"L/n²L₀, {kind}" for kind in KINDS), *map(_balance, (*BODIES, "walls"))]
        return dict.fromkeys(ones, 1.0) | {ESCAPED: 0.0}
    leaving = expected_leaving(show, depth)
    share = theory.ball_escape(depth) if show == "ball" else theory.slab_escape(depth)
    rows = {
        SHARE: float(share),
        TAKEN: float(1 - share),
        GRAZING: float(leaving[1]),
        STRAIGHT: float(leaving[-1]),
    }
    if show == "slab":
        return rows
    shells = theory.ball_shell_shares(depth, np.linspace(0, 1, SHELLS + 1))
    return rows | {CENTRE: float(shells[0]), CRUST: float(shells[-1])}


def expected_leaving(show: str, depth: float) -> np.ndarray:
    """Exact means of `leaving_share`, (BINS,)."""
    share = theory.ball_rim_share if show == "ball" else theory.slab_face_share
    return share(depth, np.linspace(0, 1, BINS + 1))


# ---- answer and pictures ----


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in where(show="furnace")(outcomes):
        off = deviations(outcome.result, levels(outcome.result.scene))
        words = f"in {off.weights.size} bins of place and direction χ² is {off.chi_square()} of what chance makes it"
        said.append(f"Between hot walls it looks like nothing: {words}.")
    if dark := [f"{o[SHARE].estimate} of {_words(o)}" for o in where(show=("ball", "slab"))(outcomes)]:
        said.append(f"In the dark it shines by its depth: of its own light escapes {', '.join(dark)}.")
    return " ".join(said)


def _words(outcome: Outcome) -> str:
    show, depth = outcome.given["show"], outcome.given["depth"]
    return f"a {show} of optical {'radius' if show == 'ball' else 'thickness'} {depth:g}"


@curves_figure(
    xlabel=r"optical length of the (mean) ray  $\tau = \sigma_a s$",
    ylabel="radiance / that of a black body",
    title="Hot fog in the dark and between hot walls",
    guides={r"thin: $\tau$": lambda t: np.where(t < 2, t, np.nan), "black body: 1": np.ones_like},
    log_x=True,
    log_y=True,
)
def draw_rays(outcomes: list[Outcome]) -> dict[str, object]:
    """Radiance by the optical length of the (mean) ray, in the dark and between walls."""
    series = {}
    for outcome in where(show=("ball", "slab"))(outcomes):
        expected = expected_leaving(outcome.given["show"], outcome.given["depth"])
        lengths = theory.mean_beam_length(np.minimum(expected, BRIGHTEST), 1.0)
        series[_words(outcome)] = lengths, leaving_share(outcome.result), theory.ray_share, expected
    for outcome in where(show="furnace")(outcomes)[:1]:
        series["between hot walls"] = _fogs(outcome.result)
    lengths = np.concatenate([fields[0] for fields in series.values()])
    return {"series": series, "span": (0.7 * lengths.min(), 1.4 * lengths.max())}


def _fogs(result: tp.Result) -> tuple:
    """The mean L/L₀ that leaves each fog of a furnace, by σ_a times its mean chord."""
    whole, lengths, found = constant(result, math.pi * shine_of(result), "W m^-2"), [], []
    for name in FOGS:
        surface = result.scene.surface(name)
        chord = 4 * surface.shape.volume / surface.shape.area
        lengths.append(chord * float(np.max(surface.inside.absorption)))
        found.append(result[f"{name} outside"].exitance / whole)
    return lengths, found, np.ones_like


def _dark(outcomes: list[Outcome]) -> list[Outcome]:
    """All, if there is anything in the dark."""
    return outcomes if where(show=("ball", "slab"))(outcomes) else []


_furnace_rows = rows_figure(
    "Fog in a furnace: the same everywhere", lambda row, _: row.name, lambda row: row.name != ESCAPED
)
draw = figures(rays=(draw_rays, _dark), furnace=(_furnace_rows, where(show="furnace")))


if __name__ == "__main__":
    main(__file__)
