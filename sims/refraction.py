"""Refraction: what crosses the boundary of air and glass, and why it is L/n² that is conserved there.

Derivation.  A ray bends by Snell's law, sinθ = n sinθ'; squared and differentiated, cosθ dω = n² cosθ' dω'.  The pencil
through an element dA of the boundary has the throughput cosθ dω dA in air and 1/n² of it in glass, so that n² cosθ dω dA
is conserved (Straubel 1902), and what is not reflected, 1 - R, has in glass the radiance

    L' = (1 - R) n² L within the escape cone sinθ' < 1/n, and 0 beyond it,

and on its way out of glass L = (1 - R) L'/n² (Nicodemus 1963, Appl. Opt. 2, 368; that throughput is conserved in
refraction is Hanrahan's, 2001, Stanford CS 348B, lecture 4).  Beyond the critical angle all is reflected.  R is Fresnel's
reflectance (Born, Wolf 1999, 1.5.2).  Of equal radiance from all sides a boundary reflects r from outside (Walsh 1926)
and 1 - (1 - r)/n² from inside; the n² makes 9 % and 60 % of it for n = 1.5.  A plate of two boundaries lets (1 - R)/(1 + R)
through, all inner reflections added incoherently (Stokes 1862, Proc. R. Soc. 11, 545).

Unpolarised at every crossing, a known limit.  R is the mean of R_s and R_p at each boundary.  Light that a plate has
polarised stays so: true plates let the mean of (1 - R_s)/(1 + R_s) and (1 - R_p)/(1 + R_p) through, which is more; for
n = 1.5 by 1.0 % of it at Brewster's angle, 3.9 % at most (79°); for n = 2.4 by up to 16 %.  At one boundary, and at 0° and
90°, there is no difference.  The exact values here are those of unpolarised transport.

Shows.  "sky": a dome of radiance L over a disk of glass, read on both sides of the boundary, and by a meter in the glass,
so much smaller than the disk that all of the escape cone comes to it from there.  Bins in glass are the images of those
in air, so that what leaves both sides, in L/n², adds up to what came in each, history by history.  "glow": the dome is in
the glass.  "fan": beams at many angles, each onto glass of its own.  "beam": one, whose mirrored and refracted parts are
looked for in cones of a milliradian.  "plate": a beam through a slab.  "window": the dome over a slab; only a disk of it
is lit, and all that passes is added up, as much as a slab lit everywhere lets through.  "lamp": a point source in glass.
"""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import (
    constant,
    figures,
    grouped,
    main,
    of_scene,
    one_of,
    require,
    rows_figure,
    sentence,
    sharp,
    where,
)
from transport.theory import fresnel, solid_angles
from transport.verification.experiment import Outcome

law = (
    "L' = (1 − R) n² L in the escape cone, 0 beyond; Fresnel's R; plate (1 − R)/(1 + R); diffuse r, 1 − (1 − r)/n²"
    " (Nicodemus 1963; Born and Wolf 1999, 1.5.2; Stokes 1862; Walsh 1926)"
)
question = "How bright is it in glass under a sky of radiance L, and what gets out again?"
particles = 8_000_000
intended = {
    "aim": "only rays through the aperture at which the sky is aimed are wanted",
}

SHOWS = ("sky", "glow", "fan", "beam", "plate", "window", "lamp")
SIDES = ("air", "glass")
RADIANCE = 100.0  # W m^-2 sr^-1
AIR = np.radians(np.arange(0, 91, 5))  # edges of bins
BEYOND = 4  # bins from the critical angle to the boundary
SHOWN = (0, 8, 15)  # bins of AIR, and their images in glass, that the table has
FAN = np.radians([0, 15, 30, 40, 50, 55, 60, 65, 70, 75, 80, 83, 86, 89])  # in air
DEPTH = 0.01  # m, of the meter below the disk, whose radius is 1 m
CONE = 1e-3  # rad, half angle round Snell's direction
REACH = 1e5  # m, of the meters beside a slab: rays within 0.001° of the horizon pass by them
LEAST = 1.01  # index: with less the meter in the glass would be seen from beside the disk

MIRRORED, REFRACTED, SUM = "mirrored", "refracted, in Snell's direction", "mirrored + refracted"
DIFFUSE, CROSSED = "reflected of equal radiance", "let through of equal radiance"
PASSED, RETURNED = "let through by the plate", "reflected by the plate"
ESCAPED = "a lamp's power that escapes"
NOTHING, TOTAL = (f"radiance {what} beyond the critical angle" for what in ("in glass", "reflected"))


def cases() -> list[dict[str, object]]:
    fans = [{"show": "fan", "side": side} for side in SIDES]
    beams = [{"show": "beam", "angle": 75 * tp.deg}, {"show": "beam", "angle": 38 * tp.deg, "side": "glass"}]
    plates = [{"show": "plate", "angle": angle * tp.deg} for angle in (0, 56.3, 75, 89)]
    return [{"show": "sky"}, {"show": "glow"}, *fans, *beams, *plates, {"show": "window"}, {"show": "lamp"}]


def scene(show: str = "sky", index: float = 1.5, angle: float = 0.5, side: str = "air") -> tp.Scene:
    """Light at the boundary of air and glass of this `index`, one of SHOWS.

    angle: between a beam and the normal [rad];  side: from which beams come, "air" or "glass".
    """
    one_of("refraction", show=(show, SHOWS), side=(side, SIDES))
    require(
        "refraction",
        index=(index, LEAST <= index < math.inf, f"{LEAST} or more (glass has 1.5)"),
        angle=(angle, 0 <= angle < math.pi / 2, "0 to below pi/2 rad, such as 60 * tp.deg"),
    )
    glass = tp.Dielectric(float(index))
    if show == "fan":
        return _fan(glass, side)
    if show in ("plate", "window"):
        return _slab(glass, angle if show == "plate" else None)
    shape = tp.Plane() if show == "lamp" else tp.Disk(radius=1.0)
    boundary = tp.Surface(shape, glass, name="glass")
    match show:
        case "beam":
            return tp.Scene(_pencil(angle, side), boundary, _cones(angle, index, side))
        case "lamp":
            lamp = tp.Source(tp.Point(position=(0, 0, -1)), tp.Isotropic(power=1.0))
            return tp.Scene(lamp, boundary, tp.Detector("glass", "in air"))
    return tp.Scene(_dome(show == "sky"), boundary, _meters(index, show))


def _dome(is_above: bool) -> tp.Source:
    """A hemisphere of equal radiance that shines at the disk of 1 m round the origin."""
    dome = tp.Sphere(radius=10.0, axis=(0, 0, 1 if is_above else -1), mu_min=0.0)
    return tp.Source(dome, tp.Lambertian(radiance=RADIANCE), side="back", aim=tp.Disk(radius=1.0))


def _meters(index: float, show: str) -> list[tp.Detector]:
    air, within = (tp.Directions(theta=each) for each in edges(index))
    sides = [
        tp.Detector("glass", "in air", directions=air),
        tp.Detector("glass", "in glass", side="back", directions=within),
    ]
    if show == "glow":
        return sides
    radius = 0.99 * (1 - DEPTH * math.tan(critical(index)))
    return [*sides, tp.Detector(tp.Disk(center=(0, 0, -DEPTH), radius=radius), "meter", directions=within)]


def critical(index: float) -> float:
    """The angle in glass beyond which all is reflected [rad]."""
    return float(fresnel.critical_angle(1 / index))


def edges(index: float) -> tuple[np.ndarray, np.ndarray]:
    """Edges of bins of polar angle in air and, behind their images, up to the boundary in glass [rad]."""
    images = np.arcsin(np.sin(AIR) / index)
    return AIR, np.array([*images, *np.linspace(images[-1], math.pi / 2, BEYOND + 1)[1:]])


def fan_angles(index: float, side: str) -> np.ndarray:
    """Angles of a fan's beams [rad]; in glass the images of those in air, and three beyond the critical one."""
    if side == "air":
        return FAN
    return np.array([*np.arcsin(np.sin(FAN) / index), *np.linspace(critical(index), math.pi / 2, 5)[1:4]])


def _fan(glass: tp.Dielectric, side: str) -> tp.Scene:
    beams, pieces, detectors = [], [], []
    for k, angle in enumerate(fan_angles(glass.index_inside, side)):
        place, name = (0.0, 3.0 * k, 0.0), f"piece {k}"
        beams.append(_pencil(angle, side, place))
        pieces.append(tp.Surface(tp.Disk(center=place, radius=1.0), glass, name=name))
        detectors.append(tp.Detector(name, side="front" if side == "air" else "back"))
    return tp.Scene(beams, pieces, detectors)


def _pencil(angle: float, side: str, target: tuple[float, ...] = (0.0, 0.0, 0.0)) -> tp.Source:
    """A beam of 1 W that starts 1 m away from its target."""
    way = _way(angle, -1 if side == "air" else 1)
    start = [place - component for place, component in zip(target, way, strict=True)]
    return tp.Source(tp.Point(position=start), tp.Beam(way, power=1.0))


def _way(angle: float, up: int) -> tuple[float, float, float]:
    return math.sin(angle), 0.0, up * math.cos(angle)


def _cones(angle: float, index: float, side: str) -> list[tp.Detector]:
    """Round the directions of the mirrored and the refracted beam, where there is one."""
    from_air = "front", "back", 1, index
    before, behind, up, ratio = from_air if side == "air" else ("back", "front", -1, 1 / index)
    mirrored, sine = tp.Directions.cone(_way(angle, up), CONE), math.sin(angle) / ratio
    refracted = tp.Directions.cone(_way(math.asin(sine), -up), CONE) if sine < 1 else None
    return [
        tp.Detector("glass", MIRRORED, side=before, directions=mirrored),
        tp.Detector("glass", REFRACTED, side=behind, directions=refracted),
    ]


def _slab(glass: tp.Dielectric, angle: float | None) -> tp.Scene:
    """A slab of 1 m below the plane z = 0, under a beam, or without an angle under the dome."""
    plate = tp.Surface(tp.Slab(center=(0, 0, -0.5), thickness=1.0), glass, name="plate")
    above, below = (tp.Disk(center=(0, 0, 2 * up), normal=(0, 0, -up), radius=REACH) for up in (1, -1))
    meters = [tp.Detector(above, "above"), tp.Detector(below, "below")]
    if angle is not None:
        return tp.Scene(_pencil(angle, "air"), plate, meters)
    return tp.Scene(_dome(True), plate, [*meters, tp.Detector(tp.Disk(radius=1.0), "lit", events=0)])


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    show, emitted = show_of(result), result.ledger["emitted"]
    match show:
        case "sky" | "glow":
            return _read_dome(result, show)
        case "fan":
            readings = [result[detector.name] for detector in result.scene.detectors]
            shares, side = [each.flux_out / each.flux_in for each in readings], _side(result)
            if side == "glass":  # the last are beyond the critical angle
                shares[len(FAN) :] = [sharp(share, of=share) for share in shares[len(FAN) :]]
            return dict(zip(_fan_names(index_of(result), side), shares, strict=True))
        case "beam":
            return _read_beam(result)
        case "lamp":
            return {ESCAPED: result["in air"].flux_out / emitted}
    fallen = result["lit"].flux_in if show == "window" else emitted
    return {PASSED: result["below"].flux_in / fallen, RETURNED: result["above"].flux_in / fallen}


def show_of(result: tp.Result) -> str:
    """Which show a run is of: the first mark that it has."""
    names = {detector.name for detector in result.scene.detectors}
    marks = {"meter": "sky", "in glass": "glow", "piece 0": "fan", MIRRORED: "beam", "lit": "window"}
    marks |= {"below": "plate", "in air": "lamp"}
    return next(show for name, show in marks.items() if name in names)


def index_of(result: tp.Result) -> float:
    """Of the glass."""
    return result.scene.surfaces[0].material.index_inside


def _side(result: tp.Result) -> str:
    """From which a fan comes."""
    return "glass" if result.scene.detectors[0].is_back else "air"


def _read_dome(result: tp.Result, show: str) -> dict[str, tp.Estimate]:
    air, glass, index = result["in air"], result["in glass"], index_of(result)
    before, behind = (air, glass) if show == "sky" else (glass, air)
    rows = {DIFFUSE: before.flux_out / before.flux_in, CROSSED: behind.flux_out / before.flux_in}
    seen = result["meter"].radiance if show == "sky" else air.radiance_out
    rows |= {name: seen[k] for k, name in _seen_names(index, show).items()}
    square = constant(result, index**2, "1")
    came = air.radiance if show == "sky" else glass.radiance / square
    left = [air.radiance_out[k] + glass.radiance_out[k] / square for k in SHOWN]
    kept = {_kept(k): sharp(each / came[k], of=each / came[k]) for k, each in zip(SHOWN, left, strict=True)}
    last = len(AIR) - 1  # the first bin beyond the critical angle
    return rows | kept | ({NOTHING: seen[last]} if show == "sky" else {TOTAL: glass.radiance_out[last]})


def _seen_names(index: float, show: str) -> dict[int, str]:
    """Rows of the radiance behind the boundary, by bin."""
    where, degrees = ("glass", np.degrees(edges(index)[1])) if show == "sky" else ("air", np.degrees(AIR))
    return {k: f"radiance in {where}, {degrees[k]:.3g}° to {degrees[k + 1]:.3g}°" for k in SHOWN}


def _kept(k: int) -> str:
    low, high = np.degrees(AIR[k : k + 2])
    return f"L/n² that leaves over what came, {low:.3g}° to {high:.3g}° in air"


def _fan_names(index: float, side: str) -> list[str]:
    return [f"reflected at {angle:.4g}°" for angle in np.degrees(fan_angles(index, side))]


def _read_beam(result: tp.Result) -> dict[str, tp.Estimate]:
    mirrored, refracted, emitted = result[MIRRORED], result[REFRACTED], result.ledger["emitted"]
    cone = constant(result, solid_angles.cap_solid_angle(CONE), "sr")
    is_total = refracted.detector.directions is None
    passed = refracted.flux_out if is_total else refracted.intensity_out[0] * cone
    back = mirrored.intensity_out[0] * cone / emitted
    total = (mirrored.flux_out + refracted.flux_out) / emitted
    return {
        MIRRORED: sharp(back, of=back) if is_total else back,
        REFRACTED: passed / emitted,
        SUM: sharp(total, of=total),
    }


@of_scene(scene)
def exact(show: str, index: float, angle: float, side: str) -> dict[str, float]:
    ratio = index if side == "air" else 1 / index
    match show:
        case "sky" | "glow":
            return _exact_dome(show, index)
        case "fan":
            shares = fresnel.reflectance(np.cos(fan_angles(index, side)), ratio)
            return dict(zip(_fan_names(index, side), map(float, shares), strict=True))
        case "beam":
            share = float(fresnel.reflectance(math.cos(angle), ratio))
            return {MIRRORED: share, REFRACTED: 1 - share, SUM: 1.0}
        case "lamp":
            return {ESCAPED: fresnel.escape_from_point(index)}
        case "window":
            passed = float(fresnel.means_in_air(fresnel.through_plate, AIR[[0, -1]], index)[0])
            return {PASSED: passed, RETURNED: 1 - passed}
    passed = float(fresnel.plate_transmittance(math.cos(angle), index))
    return {PASSED: passed, RETURNED: 1 - passed}


def _exact_dome(show: str, index: float) -> dict[str, float]:
    air, within = edges(index)
    share = float(fresnel.diffuse_reflectance(index if show == "sky" else 1 / index))
    if show == "sky":
        seen, end = index**2 * fresnel.means_in_glass(fresnel.through, within, index), {NOTHING: 0.0}
    else:
        seen, end = fresnel.means_in_air(fresnel.through, air, index) / index**2, {TOTAL: RADIANCE}
    rows = {name: RADIANCE * seen[k] for k, name in _seen_names(index, show).items()}
    return {DIFFUSE: share, CROSSED: 1 - share} | rows | {_kept(k): 1.0 for k in SHOWN} | end


SAID = {
    "sky": ("under a sky of 100 the radiance in glass is {}", "radiance in glass"),
    "glow": ("of 100 in glass {} come out", "radiance in air"),
    "fan": ("{} of a beam at grazing incidence is reflected", "reflected at 89"),
    "beam": ("{} of one goes on in Snell's direction", REFRACTED),
    "plate": ("a plate lets {} of it through", PASSED),
    "window": ("and {} of the sky", PASSED),
    "lamp": ("of a lamp in glass {} gets out", ESCAPED),
}


def verdict(outcomes: list[Outcome]) -> str:
    """A clause for each thing that was shown."""
    found, clauses = grouped(outcomes, "show"), []
    for show, (words, name) in SAID.items():
        if show in found:
            rows = found[show][0].rows
            row = next((r for r in rows if r.name.startswith(name)), rows[0])
            clauses.append(words.format(row.estimate))
    return sentence(*clauses)


def draw_lobes(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Radiance that leaves both sides of the boundary by direction, of equal radiance from one of them."""
    from transport.viz.lobes import lobes

    panels = {DOMES[outcome.given["show"]]: _panel(outcome) for outcome in outcomes}
    unit = r"radiance  [$\mathrm{W\,m^{-2}\,sr^{-1}}$]"
    lobes(panels, path, unit, f"Air and glass, n = {outcomes[0].given['index']:g}", note)


DOMES = {"sky": "Light from the air: L' = (1 − R) n² L", "glow": "Light from the glass: L = (1 − R) L'/n²"}


def _panel(outcome: Outcome) -> object:
    """What leaves, to the left and to the right of both normals; all azimuths are in one bin."""
    from transport.viz.lobes import Lobe, Panel

    index, from_air = outcome.given["index"], outcome.given["show"] == "sky"

    def law(side: str, angle: np.ndarray) -> np.ndarray:
        """Radiance that leaves on this side."""
        share = fresnel.reflectance(np.abs(np.cos(angle)), index if side == "air" else 1 / index)
        if (side == "air") == from_air:
            return RADIANCE * share
        return RADIANCE * (1 - share) * (index**2 if from_air else 1 / index**2)

    found = []
    for side, normal in (("air", 0.0), ("glass", math.pi)):
        leaving = outcome.result[f"in {side}"].radiance_out
        words, edges = "reflected" if (side == "air") == from_air else "let through", leaving.coords["theta"]
        value, error = (np.concatenate([part[::-1], part]) for part in (leaving.value, leaving.error))
        edges = normal + np.concatenate([-edges[:0:-1], edges])
        found.append(Lobe(words, edges, value, error, partial(law, side)))
    limit, low = critical(index), -math.pi / 2 if from_air else math.pi / 2
    rays = {math.pi + sign * limit: f"{math.degrees(limit):.1f}°" for sign in (-1, 1)}
    arc = (f"L = {RADIANCE:g} that arrives", RADIANCE, low, low + math.pi)
    order = sorted(found, key=lambda lobe: lobe.label)
    return Panel(order, rays, media=("air", f"glass,\nn = {index:.4g}"), arc=arc)


def draw_shares(outcomes: list[Outcome], path: Path, note: str) -> None:
    """What one boundary reflects, and what a plate lets through, by the angle of incidence."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import figure

    index, panels = outcomes[0].given["index"], {}

    def mu(degrees: np.ndarray) -> np.ndarray:
        return np.cos(np.radians(degrees))

    for outcome in where(show="fan")(outcomes):
        side, ratio = outcome.given["side"], index if outcome.given["side"] == "air" else 1 / index
        angles, shares = np.degrees(fan_angles(index, side)), [row.estimate for row in outcome.rows]
        reflected = Series(angles, shares, lambda degrees, r=ratio: fresnel.reflectance(mu(degrees), r))
        panels.setdefault("Reflected by one boundary", {})[f"from {side}"] = reflected
    if plates := where(show="plate")(outcomes):
        angles, passed = (
            [math.degrees(o.given["angle"]) for o in plates],
            [o[PASSED].estimate for o in plates],
        )
        series = Series(angles, passed, lambda degrees: fresnel.plate_transmittance(mu(degrees), index))
        panels["Let through by a plate"] = {"(1 − R)/(1 + R)": series}
    guides = {
        "Reflected by one boundary": {
            "from air, Rₛ": lambda degrees: fresnel.reflectances(mu(degrees), index).s,
            "from air, Rₚ": lambda degrees: fresnel.reflectances(mu(degrees), index).p,
        },
        "Let through by a plate": {
            "if it stayed polarised": lambda degrees: fresnel.plate_transmittance(mu(degrees), index, True)
        },
    }
    with figure((9.6 * len(panels) + 0.6, 10.4), f"Air and glass, n = {index:g}", note, path) as page:
        grid = page.subplots(2, len(panels), sharex="col", height_ratios=(2.6, 1), squeeze=False)
        for column, (title, series) in zip(grid.T, panels.items(), strict=True):
            words = {"xlabel": "angle of incidence  [deg]", "ylabel": "share of the light"}
            plot_curves(series, ax=tuple(column), guides=guides[title], span=(0, 90), legend="best", **words)
            column[0].set_title(title)


draw = figures(
    lobes=(draw_lobes, where(show=("sky", "glow"))),
    shares=(draw_shares, where(show=("fan", "plate"))),
    laws=(
        rows_figure("Air and glass", lambda row, o: f"{row.name}\n{o.given['show']}"),
        where(show=("beam", "window", "lamp")),
    ),
)


if __name__ == "__main__":
    main(__file__)
