"""Milk: a pencil of light in a medium that scatters a thousand times before it absorbs, mostly forwards.

Derivation.  Radiance in a plane medium obeys μ dL/dz = -σ_t L + σ_s ∫ p L dω (Chandrasekhar 1950), with Henyey and
Greenstein's phase (1941) of the mean cosine g.  Behind a smooth surface of the index n the light of a beam at right angles
enters but for the specular share ((n - 1)/(n + 1))², and what comes back to the surface from within is reflected by
Fresnel's law, most of it totally.  There is no closed form; discrete ordinates of 192 cosines with all moments of the
phase function give reflectance and fluence to 1e-9 (transport/theory/turbid.py).  Of a pencil beam, what is integrated
over a horizontal plane is what a broad beam makes at each place: fluence by depth over irradiance.

Fluence rate counts light from all directions.  Right below the surface it is five times the irradiance that comes to
it: what is scattered back is held by total reflection.  Deep down it falls by diffusion, exp(-z sqrt(3 σ_a (σ_a + σ_s
(1 - g)))), which is good there and 15 % off near the surface (transport/theory/turbid.py).

"Diffuse reflectance" is what comes out of the medium; the specular share, which has not been in it, is a row of its own.

Scene.  A medium like tissue: σ_a = 10 m^-1, σ_s = 1e4 m^-1 (0.1 and 100 in a centimetre), g = 0.9, n = 1.37.  A photon
goes ten mean free paths, a millimetre, before it forgets where it came from, and collides 600 times; 1e5 photons take
two or three seconds.  With ten times less absorption 0.84 comes back, with a hundred times less, --set absorption=0.1,
0.93: white as milk, and 10 times the work.  Fluence is counted at collisions, of which there are plenty, in layers of
a box so wide that exp(-20) of it is beside.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import constant, provenance
from transport.theory.turbid import MAX_ALBEDO, MAX_G, Diffusion, Turbid, solved
from transport.verification.experiment import Outcome

law = "μ dL/dz = −σ_t L + σ_s ∫ p L dω behind Fresnel's boundary (Chandrasekhar 1950; here to 1e-9 by discrete ordinates)"
question = "How much light comes back out of tissue or milk, and how bright is it within?"
particles = 200_000

POWER = 1.0  # W
SHALLOW, DEEP = 3.0, 6.0  # depths looked at: transport mean free paths, lengths of decay
CELLS = {"shallow": 15, "deep": 24}
WIDTH = 40.0  # of the box, lengths of decay
ANGLES = 10  # bins of the cosine
SPECULAR, DIFFUSE, ABSORBED = "specular reflectance", "diffuse reflectance", "absorbed"
GRAZING = "leaves within 30° of the surface"
FIRST, UPPER, LOWER = (
    "fluence / irradiance, first cell",
    "fluence / irradiance, upper half",
    "fluence / irradiance, lower half",
)


def scene(scattering: float = 1e4, absorption: float = 10.0, g: float = 0.9, index: float = 1.37) -> tp.Scene:
    """A pencil beam on a half space below z = 0.  scattering, absorption: coefficients [m^-1];  index: over that of air."""
    medium = tp.Medium(absorption, scattering, tp.HenyeyGreenstein(g), index)
    if not (0 < medium.albedo <= MAX_ALBEDO and abs(g) <= MAX_G and index >= 1):
        must = f"absorption and scattering above 0, absorption 1e-6 of both or more, |g| up to {MAX_G}, index from 1"
        got = f"{absorption=}, {scattering=}, {g=}, {index=}"
        raise tp.SceneError(f"milk: must have {must}, got {got}; others have no exact value here")
    skin = tp.Dielectric(index) if index > 1 else tp.Transparent()
    start = tp.Point(position=(0, 0, SHALLOW / medium.extinction))
    return tp.Scene(
        tp.Source(start, tp.Beam((0, 0, -1), power=POWER)),
        tp.Surface(tp.Plane(), skin, "surface", inside=medium),
        [
            tp.Detector("surface"),
            tp.Detector("surface", "within", side="back"),
            tp.Detector("surface", "diffuse", via="within", directions=tp.Directions(mu=ANGLES)),
            *_probes(scattering, absorption, g, index),
        ],
    )


def medium_of(result: tp.Result) -> tp.Medium:
    return result.scene.surfaces[0].inside


def solution(
    scattering: float = 1e4, absorption: float = 10.0, g: float = 0.9, index: float = 1.37
) -> Turbid:
    """The half space, solved; its depths are optical."""
    return solved(scattering / (absorption + scattering), float(g), float(index))


def depths(name: str, scattering: float = 1e4, absorption: float = 10.0, g: float = 0.9, index: float = 1.37):
    """Edges of the cells of fluence, from the surface down [mean free paths]."""
    if name == "deep":
        reach = DEEP / solution(scattering, absorption, g, index).slowest_rate
    else:
        reach = SHALLOW * (absorption + scattering) / (absorption + scattering * (1 - g))
    return np.linspace(0, reach, CELLS[name] + 1)


def _probes(*parameters: float) -> list[tp.VolumeDetector]:
    """Boxes that hang from the surface, wide enough for all that the beam lights, in layers."""
    extinction = parameters[0] + parameters[1]
    width = WIDTH / solution(*parameters).slowest_rate / extinction
    found = []
    for name, count in CELLS.items():
        depth = depths(name, *parameters)[-1] / extinction
        box = tp.Box(center=(0, 0, -depth / 2), size=(width, width, depth))
        found.append(tp.VolumeDetector(box, name, cells=(1, 1, count), estimator="collision"))
    return found


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    emitted, diffuse = result.ledger["emitted"], result["diffuse"].flux_out
    deep = fluence(result, "deep")
    grazing = result["diffuse"].intensity_out[: ANGLES // 2].sum() * constant(
        result, 2 * math.pi / ANGLES, "sr"
    )
    return {
        SPECULAR: (result["surface"].flux_out - diffuse) / emitted,
        DIFFUSE: diffuse / emitted,
        ABSORBED: result.ledger["absorbed"] / emitted,
        GRAZING: grazing / emitted,
        FIRST: fluence(result, "shallow")[0],
        UPPER: deep[: len(deep) // 2].mean(),
        LOWER: deep[len(deep) // 2 :].mean(),
    }


def fluence(result: tp.Result, name: str) -> tp.EstimateArray:
    """Means over layers of the fluence rate over the irradiance, both of a broad beam, from the surface down, (cells,) [1]."""
    reading = result[name]
    width = reading.detector.shape.size[0]
    layers = reading.fluence_rate.values.reshape(len(result.run), -1)[:, ::-1] * width**2 / POWER
    edges = np.linspace(0, reading.detector.shape.size[2], layers.shape[1] + 1)
    return tp.EstimateArray(layers, result.run, "1", ("z",), {"z": edges})


def exact(
    scattering: float = 1e4, absorption: float = 10.0, g: float = 0.9, index: float = 1.37
) -> dict[str, float]:
    parameters = (scattering, absorption, g, index)
    half_space = solution(*parameters)
    deep = half_space.mean_fluence(depths("deep", *parameters))
    return {
        SPECULAR: half_space.specular,
        DIFFUSE: half_space.reflectance,
        ABSORBED: half_space.absorbed,
        GRAZING: float(half_space.leaving([0, 0.5])[0]),
        FIRST: float(half_space.mean_fluence(depths("shallow", *parameters))[0]),
        UPPER: float(deep[: len(deep) // 2].mean()),
        LOWER: float(deep[len(deep) // 2 :].mean()),
    }


# ---- answer and pictures ----


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        medium, rows = medium_of(outcome.result), [row for row in outcome.rows if not math.isnan(row.z)]
        furthest = max((abs(row.z) for row in rows), default=0.0)
        said.append(
            f"Where light is scattered {medium.scattering / medium.absorption:.4g} times before it is absorbed,"
            f" {outcome[DIFFUSE].estimate} of it comes back and {_kept_out(outcome)} does not enter; under the"
            f" surface it is {outcome[FIRST].estimate} times as bright as the beam; the furthest of {len(rows)} figures"
            f" is {furthest:.1f} standard errors off."
        )
    return " ".join(said)


def _kept_out(outcome: Outcome) -> str:
    return str(outcome[SPECULAR].estimate) if medium_of(outcome.result).index > 1 else "nothing"


def draw(outcomes: list[Outcome], path: str) -> list[Path]:
    """Fluence by depth, of the case that scatters most; beside it, as <name>_angles, where light leaves to."""
    path = Path(path)
    paths = [path, path.with_stem(f"{path.stem}_angles")]
    outcome = max(outcomes, key=lambda o: medium_of(o.result).albedo)
    draw_depths(outcome, paths[0])
    draw_angles(outcomes, paths[1])
    return paths


def draw_depths(outcome: Outcome, path: Path) -> None:
    """Near the surface and deep down, beside diffusion."""
    from transport.viz.depths import Window, depth_windows

    medium, result = medium_of(outcome.result), outcome.result
    half_space = solved(medium.albedo, medium.phase.g, medium.index)
    diffusion = Diffusion(medium.albedo, medium.phase.g, medium.index)
    optical = medium.extinction * 1e-3  # mean free paths in a millimetre
    windows = [
        Window(
            words,
            fluence(result, name),
            half_space.mean_fluence(depths(name, **outcome.parameters)),
            name == "deep",
        )
        for name, words in {"shallow": "Near the surface", "deep": "Deep down"}.items()
    ]
    depth_windows(
        windows,
        path,
        exact=lambda z: half_space.fluence(z * optical),
        guides={"diffusion": lambda z: diffusion.fluence(z * optical)},
        title=f"Light below a milky surface: {_ratio(medium)}, $g = {medium.phase.g:g}$, $n = {medium.index:g}$",
        note=provenance([outcome]),
    )


def _ratio(medium: tp.Medium) -> str:
    return rf"$\sigma_s/\sigma_a = {medium.scattering / medium.absorption:.4g}$"


def draw_angles(outcomes: list[Outcome], path: Path) -> None:
    """Radiance that leaves, over that of a white surface, by the angle."""
    from transport.viz.catalogue import Entry, catalogue

    entries, edges = {}, np.linspace(0, 1, ANGLES + 1)
    middles = np.sqrt((edges[1:] ** 2 + edges[:-1] ** 2) / 2)  # of the bins' projected solid angles
    areas = np.diff(edges**2)  # of bins: projected solid angle over π
    for outcome in outcomes:
        medium, result = medium_of(outcome.result), outcome.result
        half_space = solved(medium.albedo, medium.phase.g, medium.index)
        per_bin = constant(result, 2 * math.pi / ANGLES / POWER, "W^-1 sr")
        shares = [
            each * per_bin / constant(result, float(a), "1")
            for each, a in zip(result["diffuse"].intensity_out, areas, strict=True)
        ]
        entries[_ratio(medium)] = Entry(
            middles,
            shares,
            lambda mu, h=half_space: math.pi * h.radiance(mu),
            half_space.leaving(edges) / areas,
        )
    catalogue(
        entries,
        path,
        xlabel="cosine of the angle to the surface's normal",
        ylabel="radiance × π / irradiance",
        title="Light that comes back out of a milky medium, by direction",
        note=provenance(outcomes),
    )


if __name__ == "__main__":
    from transport.sims import print_table

    print_table(__file__)
