"""Gonioreflectometer: how reflection from a surface is characterised, measured as an instrument measures it.

Derivation.  An irradiance dE = L_in cosθ dω from one direction gives rise to a radiance dL_out into another; their ratio
f = dL_out/dE [sr⁻¹], for all pairs of directions, is all that there is to say about how an opaque surface reflects
("How is reflection from a surface characterized?", Hanrahan 2001, Stanford CS 348B, lecture 4; Nicodemus et al. 1977, NBS
Monograph 160).  It adds up over what arrives,

    L_out = ∫ f L_in cosθ dω,   which under a sky of one radiance is albedo · L_in,

the surface's part of the rendering equation (Kajiya 1986).  What leaves is at most what came, ∫ f cosθ dω ≤ 1; and lamp
and eye may be exchanged, f(i → o) = f(o → i) (Helmholtz 1856; Rayleigh 1900).  A cosine too many or too few, as in
dΦ_out/dω over dE, breaks that.  What passes through paper has an f of its own, from one side to the other.

Samples.  "matt": Diffuse, f = albedo/π.  "satin", "gloss": Glossy of roughness 0.5 and 0.2: microfacets, of which f has a
closed form (theory/microfacets.py).  "varnish": a Mixture of matt and gloss, whose f is the mean of both by shares.
"paper": Diffuse that lets a part through.

Shows.  "beam": a beam on the sample; a bin of directions round it reads the mean of f over the bin, weighted by cosθ dω,
and that is what the exact values are, by quadrature (theory/goniometry.py).  "swap": lamps at i and at o, cones of 10°;
cones of the same size look from o and from i, each at the other lamp's light only.  "lamp": a lamp as wide as 15° half
angle.  "sky": a dome of one radiance.  Lamps are 1 m away and the sample 1 mm wide, so that the lamp stands in one
direction from all of it: what that misses is of the order 1e-6.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import transport as tp
from transport.sims import figures, main, of_scene, one_of, require, rows_figure, sharp, where
from transport.theory import goniometry, microfacets
from transport.verification.experiment import Outcome

if TYPE_CHECKING:
    from transport.viz.lobes import Lobe

law = (
    "f = dL_out/dE_in, f(i → o) = f(o → i), L_out = ∫ f L_in cosθ dω (Nicodemus et al. 1977; Helmholtz 1856;"
    " Kajiya 1986; Walter et al. 2007)"
)
question = "What does a surface send where, of light from one direction, and may lamp and eye be exchanged?"
particles = 8_000_000
intended = {
    "aim": "only rays between the lamps and the sample are wanted",
}

SHOWS = ("beam", "swap", "lamp", "sky")
MATT, SATIN, GLOSS = tp.Diffuse(0.8), tp.Glossy(0.5, 0.9), tp.Glossy(0.2, 0.9)
SAMPLES = {
    "matt": MATT,
    "satin": SATIN,
    "gloss": GLOSS,
    "varnish": tp.Mixture({MATT: 0.7, GLOSS: 0.3}),
    "paper": tp.Diffuse(0.6, transmission=0.3),
}
RADIANCE = 100.0  # W m^-2 sr^-1, of lamps and sky
RADIUS = 5e-4  # m, of the sample; lamps are 1 m away
THETA = np.radians(np.arange(0, 91, 6))  # edges of bins
FORWARD, BACK = 0, 2  # bins of azimuth, opposite to the lamp and on its side
PHI = np.radians([-15, 15, 165, 195])
SHARP, SMOOTH = 64, 6  # points each way in a bin, for its exact mean in the picture
PICTURE = np.radians(np.arange(0, 91, 3)), np.radians([-5, 5, 175, 185])  # finer ones, for the figure
NEAR, FAR = 2, 11  # bins of the table, near the normal and far from it, beside the specular one
NARROW, WIDE = math.radians(10), math.radians(15)  # half angles of lamps
LAMP, EYE = (math.radians(25), math.pi), (math.radians(55), 0.0)  # polar angle and azimuth, of "swap"
ALBEDO, THERE, HERE, RATIO = "reflected of all", "f(i → o)", "f(o → i)", "f(i → o) / f(o → i)"
LIT, SIDES = "irradiance", {"front": "", "back": "behind it "}


def cases() -> list[dict[str, object]]:
    """Without "matt", which paper's front is too, and satin but for the beam: `--set sample=satin` runs all shows."""
    beams = [{"sample": sample} for sample in ("satin", "gloss", "varnish", "paper")]
    grazing = {"sample": "gloss", "angle": 75 * tp.deg}
    swaps = [{"show": "swap", "sample": sample} for sample in ("gloss", "varnish")]
    skies = [{"show": "sky", "sample": sample} for sample in ("gloss", "paper")]
    return [*beams[:3], grazing, beams[3], *swaps, {"show": "lamp", "sample": "gloss"}, *skies]


def scene(show: str = "beam", sample: str = "satin", angle: float = math.pi / 4) -> tp.Scene:
    """A sample under one of SHOWS.  angle: of the beam, or the middle of the lamp, to the normal [rad]."""
    one_of("gonioreflectometer", show=(show, SHOWS), sample=(sample, SAMPLES))
    highest = math.pi / 2 - (WIDE if show == "lamp" else 0)
    must = f"0 to below {highest:.4g} rad, lest the lamp set"
    require("gonioreflectometer", angle=(angle, 0 <= angle < highest, must))
    disk = tp.Disk(radius=RADIUS)
    surface = tp.Surface(disk, SAMPLES[sample], name="sample")
    shine = tp.Lambertian(radiance=RADIANCE)
    if show == "swap":
        return _swap(surface, shine)
    bins = tp.Directions(theta=THETA) if show == "sky" else tp.Directions(theta=THETA, phi=PHI)
    fine = [tp.Directions(theta=PICTURE[0], phi=PICTURE[1])] if show in ("beam", "lamp") else []
    detectors = [
        tp.Detector("sample", f"{name}{side}", side=side, directions=each)
        for side in (SIDES if sample == "paper" else ("front",))
        for name, each in zip(("", "fine "), [bins, *fine], strict=False)
    ]
    to_lamp = _way(angle, math.pi)
    light = {
        "beam": lambda: tp.Source(tp.Point(position=to_lamp), tp.Beam([-x for x in to_lamp], power=1.0)),
        "lamp": lambda: tp.Source(_lamp(to_lamp, WIDE), shine, aim=disk),
        "sky": lambda: tp.Source(tp.Sphere(radius=1.0, mu_min=0.0), shine, side="back", aim=disk),
    }[show]()
    return tp.Scene(light, surface, detectors)


def _way(angle: float, azimuth: float) -> tuple[float, float, float]:
    """Unit vector at this angle to the normal; azimuth from x towards y, as the sample's own."""
    return math.sin(angle) * math.cos(azimuth), math.sin(angle) * math.sin(azimuth), math.cos(angle)


def _lamp(way: tuple[float, ...], half_angle: float) -> tp.Disk:
    """A disk that fills a cone from the sample, 1 m away."""
    return tp.Disk(center=way, normal=[-x for x in way], radius=math.tan(half_angle))


def _swap(surface: tp.Surface, shine: tp.Lambertian) -> tp.Scene:
    """Lamps at i and o; `via` tells their light apart."""
    ways = {"i": _way(*LAMP), "o": _way(*EYE)}
    lamps = {name: _lamp(way, NARROW) for name, way in ways.items()}
    counted = [tp.Detector(lamp, f"lamp {name}") for name, lamp in lamps.items()]
    eyes = [
        tp.Detector("sample", f"{a} to {b}", directions=tp.Directions.cone(ways[b], NARROW), via=f"lamp {a}")
        for a, b in ("io", "oi")
    ]
    sources = [tp.Source(lamp, shine, aim=surface.shape) for lamp in lamps.values()]
    return tp.Scene(sources, surface, [*counted, *eyes])


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    show = show_of(result)
    if show == "swap":
        there, here = (
            result[name].radiance_out[0] / result[name].irradiance for name in ("i to o", "o to i")
        )
        return {THERE: there, HERE: here, RATIO: there / here}
    front, material = result["front"], result.scene.surfaces[0].material
    share = front.flux_out / front.flux_in
    is_even = isinstance(material, tp.Glossy) or material == MATT  # every history loses the same share
    rows = {ALBEDO: sharp(share, of=share) if is_even else share}
    for side in SIDES:
        if side in result:
            read = result[side].radiance_out
            read = read / front.irradiance if show == "beam" else read
            rows |= {name: read[place] for place, name in named(show, angle_of(result), side).items()}
    return rows | ({LIT: front.irradiance} if show == "lamp" else {})


def show_of(result: tp.Result) -> str:
    """Which show a run is of, by its light."""
    if "i to o" in result:
        return "swap"
    return {tp.Point: "beam", tp.Disk: "lamp", tp.Sphere: "sky"}[type(result.scene.sources[0].shape)]


def angle_of(result: tp.Result) -> float:
    """Between the normal and the light [rad]; of the sky 0."""
    shape = result.scene.sources[0].shape
    x, _, z = shape.position if isinstance(shape, tp.Point) else shape.center
    return math.atan2(-x, z)


def named(show: str, angle: float, side: str) -> dict[int | tuple[int, int], str]:
    """Bins of the table, with their names: the specular one, one near the normal, one far from it."""
    what = "f" if show == "beam" else "L_out"
    specular = int(np.searchsorted(THETA, angle, side="right")) - 1
    names = {}
    for k in sorted({NEAR, specular, FAR}):
        low, high = np.degrees(THETA[k : k + 2])
        where = f"{what} {SIDES[side]}at {low:.0f}° to {high:.0f}°"
        names[k if show == "sky" else (k, FORWARD)] = where
    return names


Law = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def law_of(material: tp.Material, side: str = "front") -> Law:
    """f [sr^-1] of a material as a function of (mu_in, mu_out, phi), for light on its front."""

    def f(mu_in: np.ndarray, mu_out: np.ndarray, phi: np.ndarray) -> np.ndarray:
        if isinstance(material, tp.Mixture):
            return sum(share * law_of(part, side)(mu_in, mu_out, phi) for part, share in material.parts)
        if isinstance(material, tp.Diffuse):
            share = material.albedo if side == "front" else material.transmission
            return np.full(np.broadcast(mu_in, mu_out, phi).shape, share / math.pi)
        return microfacets.brdf(mu_in, mu_out, phi, material.roughness, material.albedo)

    return f


def albedo_of(material: tp.Material, side: str = "front") -> float:
    """The share of what falls on the front that leaves this side, the same at every angle for these materials."""
    if isinstance(material, tp.Mixture):
        return sum(share * albedo_of(part, side) for part, share in material.parts)
    return material.albedo if side == "front" else material.transmission


@of_scene(scene)
def exact(show: str, sample: str, angle: float) -> dict[str, float]:
    material = SAMPLES[sample]
    if show == "swap":
        there, here = (
            goniometry.mean_between_cones(law_of(material), *ends, NARROW)
            for ends in ((LAMP, EYE), (EYE, LAMP))
        )
        return {THERE: there, HERE: here, RATIO: 1.0}
    rows = {ALBEDO: albedo_of(material)}
    for side in SIDES if sample == "paper" else ("front",):
        for place, name in named(show, 0.0 if show == "sky" else angle, side).items():
            rows[name] = _expected(show, material, side, angle, place)
    lit = math.pi * RADIANCE * math.sin(WIDE) ** 2 * math.cos(angle)
    return rows | ({LIT: lit} if show == "lamp" else {})


def _expected(
    show: str, material: tp.Material, side: str, angle: float, place: int | tuple[int, int]
) -> float:
    """What a bin holds, f [sr^-1] or L_out [W m^-2 sr^-1]."""
    if show == "sky":
        return RADIANCE * albedo_of(material, side)
    theta, phi = (edges[k : k + 2] for edges, k in zip((THETA, PHI - math.pi), place, strict=True))
    law = law_of(material, side)
    if show == "beam":
        return float(goniometry.bin_means(law, angle, theta, phi)[0, 0])
    return RADIANCE * float(goniometry.reflected_radiance(law, angle, WIDE, theta, phi)[0, 0])


HEADS = {
    "beam": "Of a beam f is",
    "swap": "Exchanging lamp and eye leaves f the same:",
    "lamp": "Under a wide lamp L_out is",
    "sky": f"Under a sky of {RADIANCE:g} L_out is",
}


def verdict(outcomes: list[Outcome]) -> str:
    """A sentence for each thing that was shown."""
    said: dict[str, list[str]] = {show: [] for show in HEADS}
    for outcome in outcomes:
        show = outcome.given["show"]
        seen = [row for row in outcome.rows if row.name.startswith(("f at", "L_out at"))]
        row = outcome[RATIO] if show == "swap" else max(seen, key=lambda row: row.estimate.value)
        what = "" if show == "swap" else f" at {row.name.split(' at ')[1]}"
        said[show].append(f"{row.estimate} of {outcome.given['sample']}{what}")
    return " ".join(f"{HEADS[show]} {', '.join(words)}." for show, words in said.items() if words)


WORDS = {
    "satin": "satin, roughness 0.5",
    "gloss": "gloss, roughness 0.2",
    "varnish": "varnish, 0.7 matt and 0.3 gloss",
    "paper": "paper, lets 30 % through",
}


def draw_beams(outcomes: list[Outcome], path: Path, note: str) -> None:
    """f by direction in the plane of incidence, a panel a beam."""
    from transport.viz.lobes import lobes

    panels = {}
    for outcome in outcomes:
        sample, degrees = outcome.given["sample"], math.degrees(outcome.given["angle"])
        panels[f"{WORDS.get(sample, sample)}: from {degrees:.0f}°"] = _panel(outcome)
    title = "What a goniometer reads of a beam, in the plane of incidence"
    lobes(panels, path, r"f  [$\mathrm{sr^{-1}}$]", title=title, note=note)


def _panel(outcome: Outcome) -> object:
    """Lobes of what is reflected, and of what passes through."""
    from transport.viz.lobes import Panel

    return Panel(_lobes_of_f(outcome), light=-outcome.given["angle"])


def _lobes_of_f(outcome: Outcome, words: dict[str, str] | None = None) -> list[Lobe]:
    """f of a beam, by side.  words: of the sides that are drawn."""
    from transport.viz.lobes import Lobe

    result, angle, material = outcome.result, outcome.given["angle"], SAMPLES[outcome.given["sample"]]
    found = []
    for side, label in (words or {"front": "reflected", "back": "let through"}).items():
        if side not in result:
            continue
        f, law = result[f"fine {side}"].radiance_out / result["front"].irradiance, law_of(material, side)
        expected = goniometry.bin_means(law, angle, PICTURE[0], PICTURE[1] - math.pi)
        edges, (value, error, means) = _in_plane(PICTURE[0], f.value, f.error, expected)

        def exact_law(t: np.ndarray, law: Law = law) -> np.ndarray:
            return law(np.cos(angle), np.abs(np.cos(t)), _azimuth(t))

        if side == "back":
            edges, value, error, means = math.pi - edges[::-1], value[::-1], error[::-1], means[::-1]
        found.append(Lobe(label, edges, value, error, exact_law, means))
    return found


def _in_plane(theta: np.ndarray, *values: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Edges of angle and values by bin in the plane of incidence, the lamp's side first; (theta,) or (theta, phi)."""
    edges = np.concatenate([-theta[:0:-1], theta])
    halves = [(each, each) if each.ndim == 1 else (each[:, BACK], each[:, FORWARD]) for each in values]
    return edges, [np.concatenate([back[::-1], forward]) for back, forward in halves]


def _azimuth(t: np.ndarray) -> np.ndarray:
    """Azimuth from the lamp's of an angle in the plane of incidence, which is negative on the lamp's side."""
    return np.where(np.sin(t) < 0, 0.0, math.pi)


def draw_rendering(outcomes: list[Outcome], path: Path, note: str) -> None:
    """A row per light: the radiance that arrives, f from the beams, the radiance that leaves with its integral."""
    from transport.viz.lobes import lobes

    panels = {}
    for outcome in where(show=("lamp", "sky"))(outcomes):
        panels |= _row_of_rendering(outcome, where(show="beam", sample=outcome.given["sample"])(outcomes))
    title = r"L$_{out}$ = ∫ f L$_{in}$ cosθ dω: each direction of the light adds its lobe"
    lobes(panels, path, r"radiance  [$\mathrm{W\,m^{-2}\,sr^{-1}}$]", title=title, note=note)


def _row_of_rendering(outcome: Outcome, beams: list[Outcome]) -> dict[str, object]:
    """Panels of L_in, f and L_out under a lamp or sky.  beams: of the same sample."""
    from transport.viz.lobes import Lobe, Panel

    show, sample, angle = (outcome.given[name] for name in ("show", "sample", "angle"))
    law, front = law_of(SAMPLES[sample]), outcome.result["front" if show == "sky" else "fine front"]
    theta, phi = (THETA, None) if show == "sky" else PICTURE
    arriving, leaving = front.radiance, front.radiance_out

    def lobe(words: str, seen: tp.EstimateArray, at: Law, points: int) -> Lobe:
        """Of a radiance at(mu, phi), phi from the lamp's azimuth."""
        exact = _bin_averages(at, theta, (PHI if phi is None else phi) - math.pi, points)
        edges, (value, error, means) = _in_plane(theta, seen.value, seen.error, exact)
        return Lobe(words, edges, value, error, lambda t: at(np.cos(t), _azimuth(t)), means)

    if show == "sky":
        words = f"a sky of {RADIANCE:g}"
        incoming, outgoing = _everywhere(RADIANCE), _everywhere(RADIANCE * albedo_of(SAMPLES[sample]))
        guide = None
    else:
        words = f"a lamp of {RADIANCE:g}, ±{math.degrees(WIDE):.0f}° about {math.degrees(angle):.0f}°"
        incoming, outgoing = _lamp_at(angle), _reflected_at(law, angle)
        lit = outcome[LIT].exact
        guide = (
            "if all light came from the lamp's middle: f E",
            lambda t: lit * law(np.cos(angle), np.cos(t), _azimuth(t)),
        )
    chosen = [o for o in beams if show == "sky" or math.isclose(o.given["angle"], angle)]
    of_f = [
        _lobes_of_f(o, {"front": f"f from {math.degrees(o.given['angle']):.0f}°"})[0] for o in chosen
    ] or [
        Lobe(
            "f",
            np.array([-1, 1]) * math.pi / 2,
            np.empty(0),
            np.empty(0),
            lambda t: law(np.cos(angle), np.cos(t), _azimuth(t)),
        )
    ]
    return {
        f"L$_{{in}}$ of {words}": Panel([lobe("L$_{in}$", arriving, incoming, SHARP)], first=1),
        f"× f of {sample}{', summed over all directions' if show == 'sky' else ''}": Panel(
            of_f, label=r"f  [$\mathrm{sr^{-1}}$]", first=2
        ),
        f"= L$_{{out}}$ under the {show}": Panel([lobe("L$_{out}$", leaving, outgoing, SMOOTH)], guide=guide),
    }


def _everywhere(level: float) -> Law:
    return lambda mu, phi: level + 0 * mu * phi


def _lamp_at(angle: float) -> Law:
    """Radiance that arrives from a direction, RADIANCE within the lamp's cone."""

    def at(mu: np.ndarray, phi: np.ndarray) -> np.ndarray:
        to_middle = mu * math.cos(angle) + np.sqrt(1 - mu**2) * math.sin(angle) * np.cos(phi)
        return np.where(to_middle > math.cos(WIDE), RADIANCE, 0.0)

    return at


def _reflected_at(law: Law, angle: float) -> Law:
    """Radiance that leaves in a direction, the integral over the lamp's cone."""
    lamp, weights = goniometry.cone(angle, 0.0, WIDE)
    azimuth = np.arctan2(lamp[:, 1], lamp[:, 0])

    def at(mu: np.ndarray, phi: np.ndarray) -> np.ndarray:
        mu, phi = np.broadcast_arrays(mu, phi)
        return RADIANCE * (law(lamp[:, 2], mu[..., None], phi[..., None] - azimuth) @ weights)

    return at


def _bin_averages(at: Law, theta: np.ndarray, phi: np.ndarray, points: int) -> np.ndarray:
    """Means of a radiance at(mu, phi) over bins of directions, by midpoints of equal projected solid angle."""
    parts = (np.arange(points) + 0.5) / points
    squares = np.cos(theta) ** 2
    mu = np.sqrt(squares[:-1, None] + np.diff(squares)[:, None] * parts)[:, :, None, None]
    turn = phi[:-1, None] + np.diff(phi)[:, None] * parts
    return at(mu, turn).mean(axis=(1, 3))


def _of_rendering(outcomes: list[Outcome]) -> list[Outcome]:
    """A lamp and a sky over samples, and beams on the same ones; nothing without a lamp or sky."""
    lit = where(show=("lamp", "sky"))(outcomes)[:2]
    samples = tuple({o.given["sample"] for o in lit})
    return [*lit, *where(show="beam", sample=samples)(outcomes)] if lit else []


draw = figures(
    beams=(draw_beams, where(show="beam")),
    laws=(draw_rendering, _of_rendering),
    swap=(
        rows_figure(
            "Exchanging lamp and eye leaves f the same",
            lambda row, o: f"{row.name}\n{o.given['sample']}",
        ),
        where(show="swap"),
    ),
)


if __name__ == "__main__":
    main(__file__)
