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
from transport.sims import constant, curves_figure, figures, furthest, main, of_scene, require
from transport.theory.turbid import MAX_ALBEDO, MAX_G, Diffusion, Turbid, solved
from transport.verification.experiment import Outcome

law = "μ dL/dz = −σ_t L + σ_s ∫ p L dω behind Fresnel's boundary (Chandrasekhar 1950; here to 1e-9 by discrete ordinates)"
question = "How much light comes back out of tissue or milk, and how bright is it within?"
particles = 200_000

POWER = 1.0  # W
SHALLOW, DEEP = 3.0, 6.0  # depths looked at: transport mean free paths, lengths of decay
CELLS = {"shallow": 15, "deep": 24}
WIDTH = 40.0  # of the box, lengths of decay
WINDOWS = {"shallow": "Near the surface", "deep": "Deep down"}  # of the figure
ANGLES = 10  # bins of the cosine
SPECULAR, DIFFUSE, ABSORBED = "specular reflectance", "diffuse reflectance", "absorbed"
GRAZING = "leaves within 30° of the surface"
FIRST, UPPER, LOWER = (f"fluence / irradiance, {part}" for part in ("first cell", "upper half", "lower half"))


def scene(scattering: float = 1e4, absorption: float = 10.0, g: float = 0.9, index: float = 1.37) -> tp.Scene:
    """A pencil beam on a half space below z = 0.  scattering, absorption: coefficients [m^-1];  index: over that of air."""
    medium = tp.Medium(absorption, scattering, tp.HenyeyGreenstein(g), index)
    known = "others have no exact value here"
    require(
        "milk",
        absorption=(absorption, medium.albedo <= MAX_ALBEDO, f"1e-6 of both or more; {known}"),
        scattering=(scattering, medium.albedo > 0, f"above 0; {known}"),
        g=(g, abs(g) <= MAX_G, f"from -{MAX_G} to {MAX_G}; {known}"),
        index=(index, index >= 1, f"1 or more; {known}"),
    )
    skin = tp.Dielectric(index) if index > 1 else tp.Transparent()
    start = tp.Point(position=(0, 0, SHALLOW / medium.extinction))
    return tp.Scene(
        tp.Source(start, tp.Beam((0, 0, -1), power=POWER)),
        tp.Surface(tp.Plane(), skin, "surface", inside=medium),
        [
            tp.Detector("surface"),
            tp.Detector("surface", "within", side="back"),
            tp.Detector("surface", "diffuse", via="within", directions=tp.Directions(mu=ANGLES)),
            *_probes(medium),
        ],
    )


def medium_of(result: tp.Result) -> tp.Medium:
    return result.scene.surfaces[0].inside


def solution(medium: tp.Medium) -> Turbid:
    """The half space, solved; its depths are optical."""
    return solved(medium.scattering / medium.extinction, float(medium.phase.g), float(medium.index))


def depths(name: str, medium: tp.Medium) -> np.ndarray:
    """Edges of the cells of fluence, from the surface down [mean free paths]."""
    if name == "deep":
        reach = DEEP / solution(medium).slowest_rate
    else:
        reach = SHALLOW * medium.extinction / (medium.absorption + medium.scattering * (1 - medium.phase.g))
    return np.linspace(0, reach, CELLS[name] + 1)


def _probes(medium: tp.Medium) -> list[tp.VolumeDetector]:
    """Boxes that hang from the surface, wide enough for all that the beam lights, in layers."""
    width = WIDTH / solution(medium).slowest_rate / medium.extinction
    found = []
    for name, count in CELLS.items():
        depth = depths(name, medium)[-1] / medium.extinction
        box = tp.Box(center=(0, 0, -depth / 2), size=(width, width, depth))
        found.append(tp.VolumeDetector(box, name, cells=(1, 1, count), estimator="collision"))
    return found


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    emitted, diffuse = result.ledger["emitted"], result["diffuse"].flux_out
    deep = fluence(result, "deep")
    bin_size = constant(result, 2 * math.pi / ANGLES, "sr")
    grazing = result["diffuse"].intensity_out[: ANGLES // 2].sum() * bin_size
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


@of_scene(scene)
def exact(scattering: float, absorption: float, g: float, index: float) -> dict[str, float]:
    medium = tp.Medium(absorption, scattering, tp.HenyeyGreenstein(g), index)
    half_space = solution(medium)
    deep = half_space.mean_fluence(depths("deep", medium))
    return {
        SPECULAR: half_space.specular,
        DIFFUSE: half_space.reflectance,
        ABSORBED: half_space.absorbed,
        GRAZING: float(half_space.leaving([0, 0.5])[0]),
        FIRST: float(half_space.mean_fluence(depths("shallow", medium))[0]),
        UPPER: float(deep[: len(deep) // 2].mean()),
        LOWER: float(deep[len(deep) // 2 :].mean()),
    }


# ---- answer and pictures ----


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in outcomes:
        medium = medium_of(outcome.result)
        kept_out = outcome[SPECULAR].estimate if medium.index > 1 else "nothing"
        said.append(
            f"Where light is scattered {medium.scattering / medium.absorption:.4g} times before it is absorbed,"
            f" {outcome[DIFFUSE].estimate} of it comes back and {kept_out} does not enter; under the"
            f" surface it is {outcome[FIRST].estimate} times as bright as the beam; {furthest([outcome])}."
        )
    return " ".join(said)


def _whitest(outcomes: list[Outcome]) -> list[Outcome]:
    """The case that scatters most."""
    return [max(outcomes, key=lambda o: medium_of(o.result).albedo)]


def draw_depths(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Fluence near the surface and deep down, beside diffusion."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import figure

    result = outcomes[0].result
    medium = medium_of(result)
    half_space, diffusion = solution(medium), Diffusion(medium.albedo, medium.phase.g, medium.index)
    optical = medium.extinction * 1e-3  # mean free paths in a millimetre
    title = f"Light below a milky surface: {_ratio(medium)}, $g = {medium.phase.g:g}$, $n = {medium.index:g}$"
    with figure((16, 9.6), title, note, path) as page:
        columns = page.subplots(2, 2, sharex="col", height_ratios=(2.6, 1)).T
        for column, (name, words) in zip(columns, WINDOWS.items(), strict=True):
            means, shown = half_space.mean_fluence(depths(name, medium)), fluence(result, name)
            series = Series(1e3 * shown.coords["z"], shown, lambda z: half_space.fluence(z * optical), means)
            axes = {"ax": tuple(column), "xlabel": "depth  [mm]", "ylabel": "fluence rate / irradiance"}
            guides = {"diffusion": lambda z: diffusion.fluence(z * optical)}
            level = {"the beam's irradiance": 1.0}
            plot_curves(series, guides=guides, levels=level, log_y=name == "deep", **axes)
            column[0].set_title(words)


def _ratio(medium: tp.Medium) -> str:
    return rf"$\sigma_s/\sigma_a = {medium.scattering / medium.absorption:.4g}$"


@curves_figure(
    xlabel="cosine of the angle to the surface's normal",
    ylabel="radiance × π / irradiance",
    title="Light that comes back out of a milky medium, by direction",
)
def draw_angles(outcomes: list[Outcome]) -> dict[str, object]:
    """Radiance that leaves, over that of a white surface, by the angle."""
    series, edges = {}, np.linspace(0, 1, ANGLES + 1)
    middles = np.sqrt((edges[1:] ** 2 + edges[:-1] ** 2) / 2)  # of the bins' projected solid angles
    areas = np.diff(edges**2)  # of bins: projected solid angle over π
    for result in (outcome.result for outcome in outcomes):
        half_space, unit = (
            solution(medium_of(result)),
            constant(result, 2 * math.pi / ANGLES / POWER, "W^-1 sr"),
        )
        shares = result["diffuse"].intensity_out * unit / areas
        law, means = lambda mu, h=half_space: math.pi * h.radiance(mu), half_space.leaving(edges) / areas
        series[_ratio(medium_of(result))] = middles, shares, law, means
    return {"series": series}


draw = figures(depths=(draw_depths, _whitest), angles=draw_angles)


if __name__ == "__main__":
    main(__file__)
