"""Half spaces: a medium without end seen from before it, its limb darkening, Milne's problem, a boundary.

Derivation.  By invariance, a layer more on a medium without end changes nothing (Ambartsumian 1943): light of
irradiance E at the cosine mu0 returns with the radiance a/(4 pi) H(mu) H(mu0)/(mu + mu0) E, a the albedo, of
isotropic scattering, and 1 - sqrt(1 - a) H(mu0) returns in all (Chandrasekhar 1960, ch. 4 and 5).  H is known
by an integral.  Three settings:

darkening  A beam or Lambertian light on the half space: the whole and its parts by cosine, which are not
           Lambert's.
boundary   A medium of index 1.5, of which 0.04 is mirrored at once at normal incidence, and of what comes
           from within much is reflected again: 0.2599 of the light returns at a = 0.9, with these 0.04
           (Giovanelli 1955).
milne      A star's atmosphere: no absorption, light from far below.  What leaves is sqrt(3)/(4 pi) H(mu) F,
           three times as bright in the middle as at the limb (H(1)/H(0) = 2.908), and far below the mean
           radiance rises as tau + q, q = 0.7104 (Milne 1921; Hopf 1934).  A slab lit from below by
           Lambertian light has such a face, and transmits T = (4/3)/(tau + 2 q) (van de Hulst 1980):
           at tau = 10 both hold to 3e-6, and q = 2/(3 T) - tau/2 is measured.

Scene.  A Plane with the medium behind it, or a Slab; a pencil beam, or a Disk that emits on it: a flux
through a plane without end does not depend on where light leaves.  The mirrored part is counted in a cone of
1e-4 rad, in which there is less than 1e-7 of the other light.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import constant, figures, furthest, grouped, main, of_scene, one_of, require, sentence
from transport.sims.slab import falling_light
from transport.theory import half_space as theory
from transport.theory import ordinates
from transport.verification.experiment import Outcome, defaults_of

law = (
    "L = a H(μ)H(μ0)/4π(μ + μ0) E, R = 1 - √(1 - a) H(μ0), T = (4/3)/(τ + 2q), q = 0.710446,"
    " n = 1.5: R = 0.2599"
    " (Chandrasekhar 1960, ch. 5; Hopf 1934; Giovanelli 1955; van de Hulst 1980)"
)
question = "What does a medium without end send back, and how much darker is it at the limb?"
particles = 1_000_000

SETTINGS = ("darkening", "boundary", "milne")
INCIDENCES = ("beam", "lambertian")
BINS = 20
EDGES = np.linspace(0, 1, BINS + 1)
FINE, PIXELS = np.linspace(0, 1, 401)[1:], 801  # cosines of curves; across the picture of a star
SHARP = 1e-4  # rad, half angle of the cone that holds what is mirrored
EDGE = 1e-6  # of the bins' edges, from which the mirrored ray keeps away
GROUP = 4  # bins in a row of the table
BACK, WHOLE = "reflected R", "reflected R, with the specular"
MIRRORED, DIFFUSE = "reflected specular", "reflected diffuse"
PASSED, HOPF = "transmitted T", "q(∞) by T"
ABSORBED = "absorbed"


def cases() -> list[dict[str, object]]:
    """By parameters others: collisions a particle grow as 1/sqrt(1 - albedo), or as 2 tau in Milne's."""
    return [
        {"setting": "darkening", "albedo": 0.9, "mu0": 1.0},
        {"setting": "darkening", "albedo": 0.9, "mu0": 0.1},
        {"setting": "darkening", "albedo": 0.97, "incidence": "lambertian"},
        {"setting": "boundary", "albedo": 0.9, "index": 1.5},
        {"setting": "milne"},
    ]


def scene(
    setting: str = "darkening",
    albedo: float = 0.9,
    mu0: float = 1.0,
    incidence: str = "beam",
    index: float = 1.5,
    tau: float = 10.0,
    mean_free_path: float = 1.0,
) -> tp.Scene:
    """One of the settings; 1 W falls on it.

    albedo: of the medium, below 1;  mu0: cosine of the beam's incidence;  incidence: of a "beam" or
    "lambertian" light; index: of the medium with a boundary;  tau: depth of Milne's slab;  mean_free_path: of
    the medium [m].
    """
    one_of("half_space", setting=(setting, SETTINGS), incidence=(incidence, INCIDENCES))
    is_finite = 0 < mean_free_path < math.inf
    require("half_space", mean_free_path=(mean_free_path, is_finite, "above 0 and finite"))
    if setting == "milne":
        return _star(tau, mean_free_path)
    has_boundary = setting == "boundary"
    can_refract = not has_boundary or 1 <= index < math.inf
    scatters = "above 0, or none would return, and below 1, or none would be gone"
    require(
        "half_space",
        albedo=(albedo, 0 < albedo < 1, scatters),
        mu0=(mu0, 0 < mu0 <= 1, "above 0 and at most 1"),
        index=(index, can_refract, "1 or more, of the medium over that before it"),
    )
    extinction = 1 / mean_free_path
    coefficients = {"absorption": (1 - albedo) * extinction, "scattering": albedo * extinction}
    medium = tp.Medium(**coefficients, index=index if has_boundary else 1.0)
    face = tp.Dielectric(index) if has_boundary else tp.Transparent()
    return tp.Scene(
        falling_light(incidence, mu0, mean_free_path),
        tp.Surface(tp.Plane(), face, "face", inside=medium),
        _detectors(setting, mu0, has_boundary and incidence == "beam"),
    )


def _detectors(setting: str, mu0: float, mirrors: bool) -> list[tp.Detector]:
    """All that leaves, by cosine; and what is mirrored, in a cone too narrow for anything else."""
    whole = tp.Detector("face", setting, directions=tp.Directions(mu=BINS))
    if not mirrors:
        return [whole]
    must = f"off the edges of the bins, the multiples of {1 / BINS:g}, where what is mirrored is in neither"
    require("half_space", mu0=(mu0, np.abs(EDGES[:-1] - mu0).min() >= EDGE, must))
    ray = tp.Directions.cone((math.sqrt((1 - mu0) * (1 + mu0)), 0, mu0), SHARP)
    return [whole, tp.Detector("face", "mirrored", directions=ray)]


def _star(tau: float, mean_free_path: float) -> tp.Scene:
    """A slab below z = 0, lit from below."""
    require("half_space", tau=(tau, 0 < tau < math.inf, "above 0 and finite"))
    depth = tau * mean_free_path
    slab = tp.Slab(center=(0, 0, -depth / 2), thickness=depth)
    medium = tp.Medium(scattering=1 / mean_free_path)
    lamp = tp.Disk(center=(0, 0, -depth - mean_free_path), radius=mean_free_path)
    return tp.Scene(
        tp.Source(lamp, tp.Lambertian(power=1.0)),
        tp.Surface(slab, tp.Transparent(), "atmosphere", inside=medium),
        tp.Detector(tp.Plane(), "milne", directions=tp.Directions(mu=BINS)),
    )


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    setting, emitted = result.scene.detectors[0].name, result.ledger["emitted"]
    out, shares = result[setting].flux_out / emitted, shares_out(result)
    parts = {first: shares[first : first + GROUP].sum() for first in range(0, BINS, GROUP)}
    if setting == "milne":
        body = result.scene.surfaces[0]
        tau = constant(result, body.shape.thickness * body.inside.extinction, "1")
        rows = {PASSED: out, HOPF: (constant(result, 4 / 3, "1") / out - tau) / 2}
        return rows | {_bin(first): part / out for first, part in parts.items()}
    rows = {WHOLE if setting == "boundary" else BACK: out, ABSORBED: result.ledger["absorbed"] / emitted}
    mirrored = share_mirrored(result)
    if mirrored is not None:
        rows |= {MIRRORED: mirrored, DIFFUSE: out - mirrored}
        first = GROUP * (mirrored_bin(result) // GROUP)
        parts[first] = parts[first] - mirrored
    return rows | {_bin(first): part for first, part in parts.items()}


def shares_out(result: tp.Result) -> tp.EstimateArray:
    """Share of the light that leaves by the face in each bin of cosine, with what is mirrored [1]."""
    intensity = result[result.scene.detectors[0].name].intensity_out
    return intensity * constant(result, 2 * math.pi / BINS, "sr") / result.ledger["emitted"]


def share_mirrored(result: tp.Result) -> tp.Estimate | None:
    """Share of a beam that the boundary mirrors; None without one [1]."""
    if "mirrored" not in result:
        return None
    cone = constant(result, 4 * math.pi * math.sin(SHARP / 2) ** 2, "sr")
    return result["mirrored"].intensity_out[0] * cone / result.ledger["emitted"]


def mirrored_bin(result: tp.Result) -> int:
    """The bin of cosine that the mirrored beam leaves in."""
    return min(int(-result.scene.sources[0].emission.direction[2] * BINS), BINS - 1)


def _bin(first: int) -> str:
    return f"leaving, μ {EDGES[first]:.1f} to {EDGES[first + GROUP]:.1f}"


@of_scene(scene)
def light_of(
    setting: str, albedo: float, mu0: float, incidence: str, index: float, tau: float
) -> ordinates.Light:
    """What leaves the medium, by discrete ordinates."""
    if setting == "milne":
        return ordinates.slab(tau, 1.0, mu0=None)
    cosine, index = mu0 if incidence == "beam" else None, index if setting == "boundary" else 1.0
    return ordinates.half_space(albedo, mu0=cosine, index=index)


def exact(**parameters: object) -> dict[str, float]:
    light, given = light_of(**parameters), defaults_of(scene) | parameters
    setting, tau = given["setting"], given["tau"]
    if setting == "milne":
        rows = {PASSED: light.transmitted, HOPF: theory.measured_extrapolation(light.transmitted, tau)}
        shares = light.transmitted_in(EDGES[::GROUP], straight=True) / light.transmitted
    else:
        rows = {WHOLE if setting == "boundary" else BACK: light.reflected, ABSORBED: light.absorbed}
        if setting == "boundary" and given["incidence"] == "beam":
            rows |= {MIRRORED: light.unscattered_back, DIFFUSE: light.reflected_diffuse}
        shares = light.reflected_in(EDGES[::GROUP], straight=True)
    return rows | {_bin(k): float(shares[k // GROUP]) for k in range(0, BINS, GROUP)}


def verdict(outcomes: list[Outcome]) -> str:
    said = {
        "darkening": "a half space returns {0[reflected R].estimate}",
        "boundary": "behind a boundary {0[reflected R, with the specular].estimate}",
        "milne": "q(∞) of Milne's problem is {0[q(∞) by T].estimate}",
    }
    found = grouped(outcomes, "setting")
    parts = [words.format(found[setting][0]) for setting, words in said.items() if setting in found]
    return sentence(*parts, furthest(outcomes))


def draw_limbs(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Radiance by cosine over that of a Lambertian face, and the star's disk where there is one."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import figure

    series, stars = {}, []
    middles = np.sqrt((EDGES[1:] ** 2 + EDGES[:-1] ** 2) / 2)  # of the bins' projected solid angles
    for outcome in outcomes:
        value, error, expected, law = _diffuse(outcome)
        scale = np.diff(EDGES**2) * expected.sum()
        curve = FINE, law(FINE)
        series[_label(outcome)] = Series(middles, (value / scale, error / scale), curve, expected / scale)
        stars += [(value / scale, curve)] if outcome.given["setting"] == "milne" else []
    with figure((19 if stars else 13, 10), "A medium without end, seen from before it", note, path) as page:
        grid = page.add_gridspec(2, 2 if stars else 1, height_ratios=(2.6, 1))
        main = page.add_subplot(grid[0, 0])
        panels = main, page.add_subplot(grid[1, 0], sharex=main)
        words = {"xlabel": "cosine μ of the angle to the normal", "ylabel": "radiance  π L / exitance"}
        plot_curves(series, ax=panels, guides={"Lambert's law": np.ones_like}, legend="best", **words)
        main.tick_params(labelbottom=False)
        if stars:
            _draw_star(page.add_subplot(grid[:, 1]), *stars[0])


def _draw_star(axes, counted: np.ndarray, law: tuple[np.ndarray, np.ndarray]) -> None:
    """The disk as it is seen from afar, half by bins and half by the law: at the distance r of its middle mu is sqrt(1 - r^2)."""
    from transport.viz.style import INK

    across = np.linspace(-1, 1, PIXELS)
    r2 = across**2 + across[:, None] ** 2
    mu = np.sqrt(np.clip(1 - r2, 0, 1))
    place = np.clip(np.searchsorted(EDGES, mu, side="right") - 1, 0, BINS - 1)
    shown = np.ma.masked_where(r2 > 1, np.where(across < 0, counted[place], np.interp(mu, *law)))
    style = {"cmap": "afmhot", "vmin": 0, "vmax": 1.15 * float(shown.max()), "rasterized": True}
    picture = axes.pcolormesh(across, across, shown, **style)
    axes.plot([0, 0], [-1.06, 1.06], color=INK, lw=1.2, ls=":")
    for x, words in ((-0.5, "counted, by bins"), (0.5, "by the law")):
        axes.text(x, 1.1, words, ha="center")
    axes.set(aspect="equal", xlim=(-1.08, 1.08), ylim=(-1.36, 1.24), title="Milne's star, seen from afar")
    axes.set_axis_off()
    bar = axes.inset_axes([0.15, 0.07, 0.7, 0.025])
    axes.figure.colorbar(picture, cax=bar, orientation="horizontal").set_label("π L / exitance")


def _diffuse(outcome: Outcome) -> tuple[np.ndarray, np.ndarray, np.ndarray, Callable]:
    """Shares that leave by cosine, their errors, and exact ones, without what a boundary mirrors; π L/exitance by μ."""
    light, of, result = light_of(**outcome.parameters), outcome.given, outcome.result
    shares, mirrored = shares_out(result), share_mirrored(result)
    value, error = shares.value.copy(), shares.error.copy()
    if mirrored is not None:
        there = mirrored_bin(result)
        without = shares[there] - mirrored
        value[there], error[there] = without.value, without.error
    if of["setting"] == "milne":
        expected = light.transmitted_in(EDGES, straight=True)
        return value, error, expected, lambda mu: math.pi * theory.milne_radiance(mu)
    expected = light.reflected_in(EDGES, straight=True)
    mu0, total = of["mu0"] if of["incidence"] == "beam" else None, expected.sum()
    radiance = light.reflected_radiance
    if of["setting"] == "darkening":
        radiance = partial(theory.darkening, mu0=mu0, albedo=of["albedo"])
    return value, error, expected, lambda mu: math.pi * radiance(mu) / total


def _label(outcome: Outcome) -> str:
    of = outcome.given
    if of["setting"] == "milne":
        return f"Milne's problem, τ = {of['tau']:g}"
    falls = "Lambertian light" if of["incidence"] == "lambertian" else f"μ₀ = {of['mu0']:g}"
    index = f", n = {of['index']:g}" if of["setting"] == "boundary" else ""
    return f"a = {of['albedo']:g}, {falls}{index}"


draw = figures(limbs=draw_limbs)


if __name__ == "__main__":
    main(__file__)
