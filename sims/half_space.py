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
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import constant, provenance
from transport.theory import half_space as theory
from transport.theory import ordinates
from transport.verification.experiment import Outcome

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
    for name, value, known in (("setting", setting, SETTINGS), ("incidence", incidence, INCIDENCES)):
        if value not in known:
            raise tp.SceneError(f"half_space: {name} must be one of {', '.join(known)}, got {value!r}")
    if not 0 < mean_free_path < math.inf:
        raise tp.SceneError(f"half_space: mean_free_path must be above 0, got {mean_free_path} m")
    if setting == "milne":
        return _star(tau, mean_free_path)
    if not 0 < albedo < 1:
        must = "albedo must be above 0, or none would return, and below 1, or none would be gone"
        raise tp.SceneError(f"half_space: {must}, got {albedo}")
    if not 0 < mu0 <= 1:
        raise tp.SceneError(f"half_space: mu0 must be above 0 and at most 1, got {mu0}")
    has_boundary = setting == "boundary"
    if has_boundary and not 1 <= index < math.inf:
        raise tp.SceneError(
            f"half_space: index must be 1 or more, of the medium over that before it, got {index}"
        )
    extinction = 1 / mean_free_path
    medium = tp.Medium(
        absorption=(1 - albedo) * extinction,
        scattering=albedo * extinction,
        index=index if has_boundary else 1.0,
    )
    face = tp.Dielectric(index) if has_boundary else tp.Transparent()
    return tp.Scene(
        _source(incidence, mu0, mean_free_path),
        tp.Surface(tp.Plane(), face, "face", inside=medium),
        _detectors(setting, mu0, has_boundary and incidence == "beam"),
    )


def _detectors(setting: str, mu0: float, mirrors: bool) -> list[tp.Detector]:
    """All that leaves, by cosine; and what is mirrored, in a cone too narrow for anything else."""
    whole = tp.Detector("face", setting, directions=tp.Directions(mu=BINS))
    if not mirrors:
        return [whole]
    if np.abs(EDGES[:-1] - mu0).min() < EDGE:
        must = f"mu0 must not be an edge of the bins, a multiple of {1 / BINS:g}"
        raise tp.SceneError(f"half_space: {must}, got {mu0}, where what is mirrored is in neither")
    ray = tp.Directions.cone((math.sqrt((1 - mu0) * (1 + mu0)), 0, mu0), SHARP)
    return [whole, tp.Detector("face", "mirrored", directions=ray)]


def _source(incidence: str, mu0: float, height: float) -> tp.Source:
    if incidence == "lambertian":
        lamp = tp.Disk(center=(0, 0, height), normal=(0, 0, -1), radius=height)
        return tp.Source(lamp, tp.Lambertian(power=1.0))
    down = (math.sqrt((1 - mu0) * (1 + mu0)), 0, -mu0)
    return tp.Source(tp.Point(position=(0, 0, height)), tp.Beam(power=1.0, direction=down))


def _star(tau: float, mean_free_path: float) -> tp.Scene:
    """A slab below z = 0, lit from below."""
    if not 0 < tau < math.inf:
        raise tp.SceneError(f"half_space: tau must be above 0, got {tau}")
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


def exact(setting: str = "darkening", **parameters: object) -> dict[str, float]:
    if setting == "milne":
        tau = parameters.get("tau", 10.0)
        light = ordinates.slab(tau, 1.0, mu0=None)
        rows = {PASSED: light.transmitted, HOPF: theory.measured_extrapolation(light.transmitted, tau)}
        shares = light.transmitted_in(EDGES[::GROUP], straight=True) / light.transmitted
    else:
        light = _light(setting, **parameters)
        rows = {WHOLE if setting == "boundary" else BACK: light.reflected, ABSORBED: light.absorbed}
        if setting == "boundary" and _cosine(parameters) is not None:
            rows |= {MIRRORED: light.unscattered_back, DIFFUSE: light.reflected_diffuse}
        shares = light.reflected_in(EDGES[::GROUP], straight=True)
    return rows | {_bin(k): float(shares[k // GROUP]) for k in range(0, BINS, GROUP)}


def _cosine(parameters: dict[str, object]) -> float | None:
    return None if parameters.get("incidence") == "lambertian" else parameters.get("mu0", 1.0)


def _light(setting: str, **parameters: object) -> ordinates.Light:
    index = parameters.get("index", 1.5) if setting == "boundary" else 1.0
    return ordinates.half_space(parameters.get("albedo", 0.9), mu0=_cosine(parameters), index=index)


def verdict(outcomes: list[Outcome]) -> str:
    said = {
        "darkening": "a half space returns {0[reflected R].estimate}",
        "boundary": "behind a boundary {0[reflected R, with the specular].estimate}",
        "milne": "q(∞) of Milne's problem is {0[q(∞) by T].estimate}",
    }
    found = {o.result.scene.detectors[0].name: o for o in reversed(outcomes)}
    parts = [words.format(found[setting]) for setting, words in said.items() if setting in found]
    furthest = max((abs(row.z) for o in outcomes for row in o.rows if math.isfinite(row.z)), default=0.0)
    found_so = f"no share is further off than {furthest:.1f} standard errors"
    return f"{parts[0][0].upper()}{'; '.join(parts)[1:]}; {found_so}."


def draw(outcomes: list[Outcome], path: str) -> list[Path]:
    """Limb darkening of all, and the star's disk where there is one."""
    from transport.viz.limb_darkening import Limb, limb_darkening

    members = {}
    for outcome in outcomes:
        value, error, expected = _diffuse(outcome)
        total = expected.sum()
        scale = np.diff(EDGES**2) * total
        is_star = outcome.result.scene.detectors[0].name == "milne"
        members[_label(outcome)] = Limb(
            EDGES, value / scale, error / scale, expected / scale, _law(outcome, total), is_star
        )
    limb_darkening(
        members, path, title="A medium without end, seen from before it", note=provenance(outcomes)
    )
    return [Path(path)]


def _diffuse(outcome: Outcome) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shares that leave by cosine, their errors, and exact ones, without what is mirrored of a beam."""
    parameters = dict(outcome.parameters)
    setting, result = parameters.pop("setting", "darkening"), outcome.result
    if setting == "milne":
        light = ordinates.slab(parameters.get("tau", 10.0), 1.0, mu0=None)
        expected = light.transmitted_in(EDGES, straight=True)
    else:
        expected = _light(setting, **parameters).reflected_in(EDGES, straight=True)
    shares, mirrored = shares_out(result), share_mirrored(result)
    value, error = shares.value.copy(), shares.error.copy()
    if mirrored is not None:
        there = mirrored_bin(result)
        without = shares[there] - mirrored
        value[there], error[there] = without.value, without.error
    return value, error, expected


def _law(outcome: Outcome, total: float):
    """pi L over the exitance, a function of mu."""
    parameters = dict(outcome.parameters)
    setting = parameters.pop("setting", "darkening")
    if setting == "milne":
        return lambda mu: math.pi * theory.milne_radiance(mu)
    if setting == "boundary":
        light = _light(setting, **parameters)
        return lambda mu: math.pi * light.reflected_radiance(mu) / total
    albedo, mu0 = parameters.get("albedo", 0.9), _cosine(parameters)
    return lambda mu: math.pi * theory.darkening(mu, mu0, albedo) / total


def _label(outcome: Outcome) -> str:
    p = {"setting": "darkening", "albedo": 0.9, "mu0": 1.0} | outcome.parameters
    if p["setting"] == "milne":
        return f"Milne's problem, τ = {p.get('tau', 10.0):g}"
    falls = "Lambertian light" if _cosine(p) is None else f"μ₀ = {p['mu0']:g}"
    index = f", n = {p.get('index', 1.5):g}" if p["setting"] == "boundary" else ""
    return f"a = {p['albedo']:g}, {falls}{index}"


if __name__ == "__main__":
    from transport.sims import print_table

    print_table(__file__)
