"""Furnace: in a closed enclosure of one temperature radiance is the same everywhere, whatever stands in it.

Derivation.  Let every surface glow with what it fails to return: a black one with L₀, one that absorbs the share a
with a L₀ (Kirchhoff 1860, Ann. Phys. 185, 275).  If L₀ comes to it from everywhere, it gives off a L₀ + ∫ f L₀ cosθ dω
in each direction, and ∫ f cosθ dω = 1 − a, as f is the same both ways: L₀ again.  Through a boundary of media L/n²
stays, so that in glass L = n² L₀ (Clausius 1864, Ann. Phys. 197, 1).  So L₀ is in balance at each surface by itself,
and nothing is left by which one thing could be told from another.

Glass in which nothing scatters, absorbs or glows is filled by refraction alone.  In an empty ball a ray comes to the
boundary at one angle for ever: what came in has sinθ < 1/n, and beyond that escape cone it is dark, in equilibrium
with nothing.  A black lamp of n² L₀ in the block and a diffuse ball in the tank fill all directions there.

Detailed balance.  A path is as likely as its reverse (Helmholtz 1867, Physiologische Optik, § 16): of two black
bodies each sends the other the same power, Φ(A → B) = Φ(B → A), through all that is between them.

What a furnace cannot see.  A boundary with a wrong share R of reflection is in balance all the same, if R is the same
both ways along a ray.  Sines for the tangents in Fresnel's formula pass here (`refraction` finds them); on one side
only they do not.

Chi-square.  With d = L/(n² L₀) − 1 and w a bin's throughput, X² = Σ w (mean of d)² over all bins, over its
expectation, which the spread of the batches tells.  Bins are correlated, as one history crosses many of them;
`transport.theory.enclosures` says how the error follows all the same.

Scene.  A box 2.8 m long, whose floor is a mirror and whose ceiling is white, both without end; four black walls glow,
and a black disk plugs the hole in one.  In it stand all shapes and all materials, on a grid of 0.7 m, with meters on
both sides of every thing and free ones in between.  3e7 particles make 1e8 crossings.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import Deviations, constant, figures, main, of_scene, require, sharp
from transport.theory.enclosures import escape_cosine
from transport.theory.solid_angles import bin_projected_solid_angles
from transport.verification.experiment import Outcome

law = "L/n² = L₀ in all directions; Φ(A → B) = Φ(B → A) (Kirchhoff 1860; Clausius 1864; Helmholtz 1867)"
question = "What can be told from what in an enclosure of one temperature?"
particles = 2_000_000
intended = {
    "bins": "χ² weighs all bins together, also those with few particles",
}

LENGTH, WIDTH, HEIGHT, CELL = 2.8, 1.4, 1.4, 0.7  # m
WATER, DENSE = 1.33, 1.2  # index of the tank; of the dense ball over that of the block
WALLS = ("left", "plug", "right", "near", "far")
GLOWING = (*WALLS, "lamp front", "lamp back", "ember")
ONE_SIDED = (*WALLS, "ember", "urchin", "pearl", "seed")  # no light comes to their other side
EMPTY = ("ball inside", "dense inside")
BODIES = {  # of glass, and the meters in it
    "ball": ("ball inside", "core"),
    "dense": ("dense inside",),
    "block": ("block inside", "lamp front", "lamp back", "bubble outside", "dense outside"),
    "tank": ("tank inside", "seed"),
}
KINDS = {  # meters, by what they are on
    "black walls": WALLS,
    "diffuse": ("ceiling patch", "tube front", "tube back", "sheet front", "sheet back"),
    "mirrors": ("floor patch", "dish front", "dish back", "zone front", "zone back"),
    "glossy": ("cone front", "cone back", "screen front", "screen back", "urchin", "pearl"),
    "a mixture": ("pane front", "pane back"),
    "a thin lens": ("lens front", "lens back"),
    "grey, glowing": ("ember",),
    "glass from outside": ("ball outside", "block outside", "tank outside", "bubble inside"),
    "within filled glass": (*BODIES["block"], *BODIES["tank"]),
    "within empty glass": (*BODIES["ball"], *BODIES["dense"]),
    "in between": ("free disk", "free cylinder", "free mesh", "free box", "shell"),
}
PAIRS = (("plug", "right"), ("near", "far"), ("lamp", "near"))
UNNAMED = ("floor", "lamp", "bubble", "dense")  # on the map of the floor
FLOOR = tp.Rectangle(center=(0, 0, -HEIGHT / 2), width=LENGTH, height=WIDTH)
ENOUGH = 100  # counts
BOTH = ("radiance", "radiance_out")
CHI_SQUARE = "χ² of all bins / expectation"
LOSSLESS, OWN = "Φ_out − Φ_in, lossless things", "Φ_out − ρ Φ_in, glowing things"
DARK, ESCAPED = "L, beyond the escape cone", "escaped"


def scene(index: float = 1.5, radiance: float = 1.0) -> tp.Scene:
    """The furnace.  index: of the ball and the block of glass;  radiance: L₀ of a black wall [W m^-2 sr^-1]."""
    require("furnace", index=(index, 1.01 <= index <= 3, "1.01 to 3 (glass has 1.5)"))
    surfaces = [*_enclosure(), *_opaque_things(), *_sheets(), *_glass(index)]
    glows = [(wall, "front", 1.0) for wall in WALLS] + [("ember", "front", 0.5)]
    glows += [("lamp", side, index**2) for side in ("front", "back")]
    sources = [tp.Source(n, tp.Lambertian(radiance=share * radiance), side=side) for n, side, share in glows]
    return tp.Scene(sources, surfaces, [*_meters(surfaces), *_free_meters(), *_exchanges()])


def _at(i: int, j: int, k: int, *shift: float) -> tuple[float, ...]:
    """The middle of a cell of the grid [m], or a point beside it."""
    middle = (CELL * (i - 1.5), CELL * (j - 0.5), CELL * (k - 0.5))
    return tuple(m + s for m, s in zip(middle, shift or (0, 0, 0), strict=True))


def _enclosure() -> list[tp.Surface]:
    x, y, z = LENGTH / 2, WIDTH / 2, HEIGHT / 2
    plug = tp.Disk(center=(-x, 0, 0), normal=(1, 0, 0), radius=0.4)
    end, side = {"width": HEIGHT, "height": WIDTH}, {"width": LENGTH, "height": HEIGHT}
    walls = {
        "left": tp.Rectangle(center=(-x, 0, 0), normal=(1, 0, 0), **end, hole=plug),
        "plug": plug,
        "right": tp.Rectangle(center=(x, 0, 0), normal=(-1, 0, 0), **end),
        "near": tp.Rectangle(center=(0, -y, 0), normal=(0, 1, 0), **side),
        "far": tp.Rectangle(center=(0, y, 0), normal=(0, -1, 0), **side),
    }
    return [
        tp.Surface(tp.Plane(center=(0, 0, -z)), tp.Mirror(), "floor"),
        tp.Surface(tp.Slab(center=(0, 0, z + 0.05), thickness=0.1), tp.Diffuse(1.0), "ceiling"),
        *(tp.Surface(shape, tp.Black(), name) for name, shape in walls.items()),
    ]


def _opaque_things() -> list[tp.Surface]:
    cone = tp.Cone(center=_at(3, 0, 0), axis=(1, -1, 2), radius=0.25, top_radius=0.1, height=0.3)
    dish = tp.Paraboloid(center=_at(0, 1, 0, 0, 0, -0.15), axis=(0.3, 0, 1), focal_length=0.08, radius=0.25)
    tube = tp.Cylinder(center=_at(2, 0, 0), axis=(1, 1, 1), radius=0.18, height=0.36)
    urchin = tp.Mesh.sphere(center=_at(1, 0, 1), radius=0.28, triangles=320)
    return [
        tp.Surface(cone, tp.Glossy(1.0), "cone"),
        tp.Surface(dish, tp.Mirror(), "dish"),
        tp.Surface(tube, tp.Diffuse(1.0), "tube"),
        tp.Surface(urchin, tp.Glossy(0.5), "urchin"),
        tp.Surface(tp.Sphere(center=_at(1, 1, 1), radius=0.12), tp.Glossy(0.05), "pearl"),
        tp.Surface(tp.Sphere(center=_at(2, 0, 1), radius=0.2), tp.Diffuse(0.5), "ember"),
    ]


def _sheets() -> list[tp.Surface]:
    """What is thin; some of it lets light through."""
    zone = tp.Sphere(center=_at(1, 1, 0), axis=(1, 0, 1), radius=0.28, mu_min=-0.3, mu_max=0.8)
    corners = (0.25, 0, 0.1), (-0.2, 0.2, -0.1), (-0.2, -0.2, 0.2)
    sheet = tp.Triangle(vertices=[_at(2, 1, 0, *corner) for corner in corners])
    hole = tp.Disk(center=_at(3, 1, 0), normal=(1, 1, 1), radius=0.1)
    screen = tp.Rectangle(center=_at(3, 1, 0), normal=(1, 1, 1), width=0.5, height=0.4, hole=hole)
    lens = tp.Disk(center=_at(0, 0, 1), normal=(1, 0, 1), radius=0.3)
    pane = tp.Rectangle(center=_at(3, 0, 1), normal=(2, 1, 0), width=0.5, height=0.5)
    blend = {tp.Mirror(0.5, 0.5): 0.25, tp.Diffuse(0.5, 0.5): 0.25, tp.Glossy(0.25): 0.5}
    return [
        tp.Surface(zone, tp.Mirror(0.375, 0.625), "zone"),
        tp.Surface(sheet, tp.Diffuse(0.625, 0.375), "sheet"),
        tp.Surface(screen, tp.TwoSided(front=tp.Glossy(0.1), back=tp.Diffuse(1.0)), "screen"),
        tp.Surface(lens, tp.ThinLens(0.5), "lens"),
        tp.Surface(pane, tp.Mixture(blend), "pane"),
    ]


def _glass(index: float) -> list[tp.Surface]:
    bubble = tp.Sphere(center=_at(1, 0, 0, 0.14, 0.14, -0.14), radius=0.09)
    dense = tp.Sphere(center=_at(1, 0, 0, -0.14, -0.14, 0.14), radius=0.09)
    half_silvered = tp.Mixture({tp.Dielectric(1.0, index): 0.75, tp.Mirror(): 0.25})
    return [
        tp.Surface(tp.Sphere(center=_at(0, 0, 0), radius=0.28), tp.Dielectric(index), "ball"),
        tp.Surface(tp.Box(center=_at(1, 0, 0), size=0.5), tp.Dielectric(index), "block"),
        tp.Surface(tp.Disk(center=_at(1, 0, 0), normal=(1, 2, 3), radius=0.1), tp.Black(), "lamp"),
        tp.Surface(bubble, half_silvered, "bubble"),
        tp.Surface(dense, tp.Dielectric(DENSE * index, index), "dense"),
        tp.Surface(tp.Mesh.box(center=_at(0, 1, 1), size=0.4), tp.Dielectric(WATER), "tank"),
        tp.Surface(tp.Sphere(center=_at(0, 1, 1), radius=0.12), tp.Diffuse(1.0), "seed"),
    ]


def _meters(surfaces: list[tp.Surface]) -> list[tp.Detector]:
    """On the sides to which light comes: by direction, and by place where the shape has coordinates."""
    found = []
    for surface in (surface for surface in surfaces if not surface.shape.is_infinite):  # those have patches
        name, shape = surface.name, surface.shape
        sides = ("outside", "inside") if shape.is_closed else ("front", "back")
        named = {name: "front"} if name in ONE_SIDED else {f"{name} {side}": side for side in sides}
        found += [_meter(name, shape, title, side, surface) for title, side in named.items()]
    return found


def _meter(what, shape, title: str, side: str = "front", surface: tp.Surface | None = None) -> tp.Detector:
    is_whole = isinstance(shape, tp.Box | tp.Triangle | tp.Mesh) or getattr(shape, "hole", None)
    mu = _cone_edges(surface.material) if title in EMPTY else 6
    places = None if is_whole or title in EMPTY else tp.Positions(u=2, v=3)
    return tp.Detector(what, title, side, tp.Directions(mu=mu, phi=16), places)


def _cone_edges(glass: tp.Dielectric) -> tuple[float, ...]:
    """Bins of mu within an empty body: two beyond the escape cone, three in it."""
    edge = escape_cosine(glass.index_inside / glass.index_outside)
    return (0.0, edge / 2, *np.linspace(edge, 1, 4))


def _free_meters() -> list[tp.Detector]:
    shapes = {
        "free disk": tp.Disk(center=_at(3, 1, 0), normal=(1, 1, 1), radius=0.1),  # in the screen's hole
        "free cylinder": tp.Cylinder(center=_at(2, 1, 1), axis=(1, 2, 0), radius=0.2, height=0.4),
        "free mesh": tp.Mesh.sphere(center=_at(1, 1, 1), radius=0.25, triangles=20),  # about the pearl
        "free box": tp.Box(center=_at(3, 1, 1), size=(0.5, 0.4, 0.3)),
        "shell": tp.Sphere(center=_at(2, 0, 1), radius=0.28),  # about the ember
        "core": tp.Sphere(center=_at(0, 0, 0), radius=0.08),  # of the empty ball
        "floor patch": FLOOR,
        "ceiling patch": tp.Disk(center=(0, 0, HEIGHT / 2), normal=(0, 0, -1), radius=0.6),
    }
    return [_meter(shape, shape, name) for name, shape in shapes.items()]


def _exchanges() -> list[tp.Detector]:
    """What black bodies send one another, and what the floor receives from one of them and from all."""
    found = []
    for one, other in PAIRS:
        for there, here in ((one, other), (other, one)):
            sides = ("front", "back") if here == "lamp" else ("front",)
            found += [tp.Detector(here, f"{there} to {here} {side}", side, via=there) for side in sides]
    maps = {"all to floor": None, "plug to floor": "plug"}
    squares = tp.Positions(u=40, v=20)
    return found + [tp.Detector(FLOOR, name, positions=squares, via=via) for name, via in maps.items()]


# ---- what is measured ----


def levels(scene: tp.Scene) -> dict[str, np.ndarray]:
    """Radiance over L₀ that meters of directions should have, (mu, 1): n² of the medium, 0 where none gets to."""
    found, hosts = {}, {name: body for body, names in BODIES.items() for name in names}
    for meter in (meter for meter in scene.meters if meter.directions is not None):
        name = meter.name
        index = scene.surface(hosts[name]).material.index_inside if name in hosts else 1.0
        found[name] = np.full((len(meter.directions.edges()["mu"]) - 1, 1), index**2)
        found[name][: 2 if name in EMPTY else 0] = 0.0
    return found


def deviations(result: tp.Result, expected: dict[str, np.ndarray], what=BOTH) -> Deviations:
    """L/expected of all bins in which light is expected.

    expected: over L₀, by meter; broadcasts to its bins.  what: the radiances taken, that arrive and that leave.
    """
    found, weights, shine = [], [], result.scene.sources[0].emission.radiance
    for name, share in expected.items():
        reading = result[name]
        shape, meter = result.scene.shape_of(reading.detector), reading.detector
        areas = np.array(shape.area if meter.positions is None else meter.positions.areas(shape))
        angles = bin_projected_solid_angles(*meter.directions.edges().values())
        for radiance in (getattr(reading, name) for name in what):
            bright, throughput = np.broadcast_arrays(share, areas[..., None, None] * angles)
            lit = bright > 0
            found.append(radiance.values[:, lit] / (shine * bright[lit]) - 1)
            weights.append((bright * throughput)[lit])
    return Deviations(result, np.concatenate(found, axis=1), np.concatenate(weights))


def scores(result: tp.Result) -> np.ndarray:
    """z of the bins in which at least ENOUGH counts are expected: those of fewer follow no normal law."""
    _, found, weights = deviations(result, levels(result.scene))
    rate = result.particles * result.scene.sources[0].emission.radiance / result.ledger["emitted"].value
    found = found[:, rate * weights >= ENOUGH]
    number = {"x": np.arange(found.shape[1] + 1.0)}
    return tp.EstimateArray(found, result.run, "1", ("x",), number).z(0.0)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    known = levels(result.scene)
    rows = {CHI_SQUARE: deviations(result, known).chi_square()}
    for kind, names in KINDS.items():
        rows[f"L/n²L₀, {kind}"] = deviations(result, {name: known[name] for name in names}).mean()
    for one, other in PAIRS:
        rows[_exchange(one, other)] = _sent(result, one, other) / _sent(result, other, one)
    dark = result["ball inside"].radiance[:2].mean()  # in the bins beyond the escape cone of the empty ball
    return rows | _balances(result) | {DARK: dark, ESCAPED: result.ledger["escaped"]}


def _exchange(one: str, other: str) -> str:
    return f"Φ({one} → {other}) / Φ({other} → {one})"


def _sent(result: tp.Result, there: str, here: str) -> tp.Estimate:
    """Power that leaves one black body and arrives at the other, by any way [W]."""
    return sum(result[name].flux_in for name in result if name.startswith(f"{there} to {here} "))


def _balances(result: tp.Result) -> dict[str, tp.Estimate]:
    """What things give off beyond what they return of what they receive; the same in every history."""
    on_things = [m.name for m in result.scene.meters if m.directions and isinstance(m.shape, str)]
    lossless = [result[name] for name in (*on_things, "floor patch", "ceiling patch") if name not in GLOWING]
    own = sum(result[name].flux_out for name in GLOWING) - 0.5 * result["ember"].flux_in
    received = sum(reading.flux_in for reading in lossless)
    given_off = sum(reading.flux_out for reading in lossless)
    return {LOSSLESS: sharp(given_off - received, of=received), OWN: sharp(own, of=result.ledger["emitted"])}


@of_scene(scene)
def exact(index: float, radiance: float) -> dict[str, float]:
    ones = [CHI_SQUARE, *(f"L/n²L₀, {kind}" for kind in KINDS), *(_exchange(*pair) for pair in PAIRS)]
    surfaces = {surface.name: surface.shape.area for surface in scene(index, radiance).surfaces}
    own = sum(surfaces[wall] for wall in WALLS) + 2 * index**2 * surfaces["lamp"] + 0.5 * surfaces["ember"]
    zeros = {LOSSLESS: 0.0, OWN: np.pi * radiance * own, DARK: 0.0, ESCAPED: 0.0}
    return dict.fromkeys(ones, 1.0) | zeros


# ---- answer and picture ----


def verdict(outcomes: list[Outcome]) -> str:
    outcome = outcomes[0]
    kinds = [row for row in outcome.rows if row.name.startswith("L/n²")]
    bins = deviations(outcome.result, levels(outcome.result.scene)).weights.size
    worst = max(kinds, key=lambda row: abs(row.estimate.value - 1))
    return (
        f"Nothing from anything: in {bins} bins of direction and place χ² is"
        f" {outcome[CHI_SQUARE].estimate} of what chance makes it; by kind of thing farthest off is"
        f" {worst.name} = {worst.estimate}; and as much goes from A to B as from B to A."
    )


def draw_equilibrium(outcomes: list[Outcome], path: Path, note: str) -> None:
    """What the plug and what all bring to the floor; below, L by kind of thing, in empty glass, and in all bins."""
    from transport.viz.style import figure

    with figure((23, 14.6), "In a furnace all things look alike", note, path) as page:
        above, below = page.subfigures(2, 1, height_ratios=(1, 1.2))
        left, middle, right = below.subplots(1, 3, width_ratios=(1.25, 1, 1))
        _draw_floor(above.subplots(1, 2, sharey=True), outcomes[0].result)
        _draw_kinds(left, outcomes[0])
        _draw_angles(middle, outcomes[0].result)
        _draw_scores(right, scores(outcomes[0].result))


def _shine(result: tp.Result) -> tp.Estimate:
    return constant(result, result.scene.sources[0].emission.radiance, "W m^-2 sr^-1")


def _draw_floor(panels: np.ndarray, result: tp.Result) -> None:
    from transport.viz.style import SEQUENTIAL, outlined

    labels = {"plug to floor": "Light on the floor from the plug alone …", "all to floor": "… and from all"}
    low = [s for s in result.scene.surfaces if s.shape.middle[2] < -0.1 and s.name not in UNNAMED]
    for axes, (name, label) in zip(panels, labels.items(), strict=True):
        found = result[name].irradiance / (_shine(result) * constant(result, np.pi, "sr"))
        style = {"vmin": 0, "vmax": 1.2 * np.quantile(found.value, 0.98), "cmap": SEQUENTIAL}
        shown = axes.pcolormesh(found.coords["u"], found.coords["v"], found.value.T, rasterized=True, **style)
        axes.figure.colorbar(shown, ax=axes, shrink=0.8, pad=0.015, extend="max").set_label("E / π L₀")
        for surface in low:
            words = {"color": "white", "fontsize": "small", "ha": "center", "va": "center"}
            axes.text(*surface.shape.middle[:2], surface.name, path_effects=outlined(2.4), **words)
        axes.set(title=label, xlabel="x  [m]", aspect="equal")
        axes.grid(False)
    panels[0].set_ylabel("y  [m]")


def _draw_kinds(axes, outcome: Outcome) -> None:
    from transport.viz.style import BLUE, INK, POINTS

    found = [outcome[f"L/n²L₀, {kind}"].estimate for kind in KINDS]
    values, bars = [100 * (each.value - 1) for each in found], [200 * each.error for each in found]
    axes.errorbar(values, range(len(found)), xerr=bars, fmt="o", color=BLUE, **POINTS)
    axes.axvline(0, color=INK, lw=1.6)
    axes.set_yticks(range(len(KINDS)), list(KINDS))
    axes.set_ylim(len(KINDS) - 0.4, -0.6)
    axes.grid(False, axis="y")
    axes.set(xlabel="L / n²L₀ − 1  [%],  ± 2 standard errors", title="Radiance by kind of thing")


def _draw_angles(axes, result: tp.Result) -> None:
    from transport.viz.curves import Series, plot_curves

    bright, series = levels(result.scene), {}
    for name, place in zip(EMPTY, ("air", "the block"), strict=True):
        seen = result[name].radiance.mean("phi") / _shine(result)
        theta = np.degrees(np.arccos(seen.coords["mu"]))
        series[f"n = {bright[name].max() ** 0.5:g} in {place}"] = Series(
            theta, seen, expected=bright[name][:, 0]
        )
    words = {"xlabel": "angle to the normal, in the glass  [deg]", "ylabel": "L / L₀"}
    plot_curves(series, ax=axes, legend="upper right", **words)
    axes.set_ylim(top=1.6 * axes.get_ylim()[1])  # for the legend
    axes.set_title("Glass with nothing in it")


def _draw_scores(axes, found: np.ndarray) -> None:
    from transport.viz.style import BLUE, MUTED, VERMILLION, WITHIN_TWO

    reach, cell = 5.0, 0.25
    edges, z = np.arange(-reach, reach + cell / 2, cell), np.linspace(-reach, reach, 401)
    axes.axvspan(-2, 2, color=WITHIN_TWO, lw=0)
    counts, bins = np.histogram(found, edges)[0], f"{found.size} bins"
    axes.stairs(counts, edges, fill=True, color=BLUE, alpha=0.75, label=bins)
    chance = found.size * cell * np.exp(-z * z / 2) / np.sqrt(2 * np.pi)
    axes.plot(z, chance, color=VERMILLION, lw=3, label="chance alone")
    beyond = f"{np.count_nonzero(np.abs(found) > reach)} beyond ±{reach:g}"
    axes.text(0.03, 0.97, beyond, transform=axes.transAxes, va="top", color=MUTED, fontsize="small")
    axes.set(xlabel="z  [standard errors]", ylabel="bins", title=f"Bins of {ENOUGH} counts and more")
    axes.legend(loc="upper right")


draw = figures(equilibrium=draw_equilibrium)


if __name__ == "__main__":
    main(__file__)
