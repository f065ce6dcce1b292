"""Photon gas: what crosses a patch in a gas of particles, counted by direction.

Derivation.  Particles of density n fly with velocity v along a direction at the angle θ to the normal of a patch dA.
Those that cross it within dt start in the oblique prism of volume v cosθ dA dt, so that they are n v cosθ dA dt and
the flux density is n v cosθ (Hanrahan 2001, Stanford CS 348B, lecture 4, "Flows").  What meets the patch from behind
counts on its other side: the cosine is clamped at 0 (Akenine-Möller, Haines, Hoffman 2008, eq. 7.5).

In an isotropic gas n dω/4π of the particles fly within dω.  So dω brings n v cosθ/4π a steradian, and over the cosine
that is the radiance L = n v/4π, the same for all directions.  Over a hemisphere ∫ cosθ dω = π, so that n v/4 cross
one way (Reif 1965, 7.11); both ways are equal and the net flux density is 0; over all directions ∫ L dω = n v, the
fluence rate.  A bin of directions holds L ∫ cosθ dω exactly, over its solid angle L times its mean cosine.

Scene.  A transparent disk in a box of gas without walls.  Particles that can meet the disk within the duration start
within speed × duration of it, and the box holds all such places: nothing outside of it could matter.

Any stuff flows alike (Hanrahan 2001, "Flows"): if each particle carries s of it, s n v cosθ dA dt crosses, so that the
flux density is s n v cosθ, with s the mass of a molecule, the charge of an ion, the energy h c/λ of a photon.  The counts
are the same, the weight is another.  `stuff` is what is carried.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import transport as tp
from transport.sims import constant, figures, main, of_scene, one_of, sentence, where
from transport.theory import effusion
from transport.theory.solid_angles import bin_projected_solid_angles, bin_solid_angles
from transport.verification.experiment import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes

law = "flux density n v cosθ; one way n v/4, net 0, radiance n v/4π, fluence rate n v (Hanrahan 2001; Reif 1965, 7.11)"
question = "How many particles of a gas cross a patch, and from which directions?"
particles = 8_000_000
intended = {
    "all light": "a stream reaches one side of the disk, and nothing arrives at the other",
}

RADIUS = 1.0  # m, of the patch
REACH = {"isotropic": 0.25, "stream": 2.0}  # m that a particle flies within the duration
MARGIN = 0.01  # m of gas beyond what can matter
CELLS = 8  # bins
EDGES = np.sqrt(np.linspace(0, 1, CELLS + 1))  # of the cosine: bins of equal flux
STUFF = {  # what one particle carries
    "photons": (1.0, "1"),
    "molecules": (1.0, "1"),
    "mass": (4.65e-26, "kg"),  # of a nitrogen molecule
    "charge": (1.602176634e-19, "C"),  # elementary charge, exact (SI Brochure 2019, 2.2)
    "energy": (6.62607015e-34 * tp.speed_of_light / (550 * tp.nm), "J"),  # h c/λ
}
CARRIED = ("mass", "charge", "energy")  # the stuffs of the table


def cases() -> list[dict[str, object]]:
    streams = [{"motion": "stream", "tilt": angle * tp.deg} for angle in (0, 60, 89)]
    carried = [{"motion": "stream", "tilt": 60 * tp.deg, "stuff": stuff} for stuff in CARRIED]
    return [{"motion": "isotropic"}, *streams, *carried]


def scene(
    density: float = 1e13,
    speed: float = tp.speed_of_light,
    motion: str = "isotropic",
    tilt: float = 0.0,
    stuff: str = "photons",
) -> tp.Scene:
    """A disk in a gas.  density [m^-3], by default about that of sunlight;  tilt: of a stream on the disk [rad]."""
    one_of("photon_gas", motion=(motion, REACH), stuff=(stuff, STUFF))
    patch = tp.Disk(normal=(math.sin(tilt), 0, math.cos(tilt)), radius=RADIUS)
    directions = tp.Directions(mu=EDGES)
    detectors = [tp.Detector(patch, f"{stuff} on the {side}", side, directions) for side in ("front", "back")]
    reach = REACH[motion]
    sides = RADIUS * abs(math.cos(tilt)) + MARGIN, RADIUS + MARGIN, RADIUS * abs(math.sin(tilt)) + MARGIN
    if motion == "stream":  # along +z, from as far behind the disk as it flies
        box = tp.Box(center=(0, 0, -reach / 2), size=(2 * sides[0], 2 * sides[1], 2 * sides[2] + reach))
        source = tp.Source(box, tp.Gas(density, speed, direction=(0, 0, 1)))
    else:
        source = tp.Source(tp.Box(size=[2 * (side + reach) for side in sides]), tp.Gas(density, speed))
    return tp.Scene(sources=source, detectors=detectors, duration=reach / speed)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    front, back = (result[detector.name] for detector in result.scene.detectors)
    if result.scene.sources[0].emission.direction is not None:
        rows = {"leaving the front": front.exitance, "arriving at the back": back.irradiance}
    else:
        rows = {"one way, onto the front": front.irradiance, "one way, onto the back": back.irradiance}
        rows |= _by_bin("flux density", front.flux_density) | _by_bin("radiance", front.radiance)
    rows |= {"net": front.net_flux_density, "fluence rate": front.fluence_rate}
    carried = constant(result, *STUFF[front.name.split()[0]])
    return {name: estimate * carried for name, estimate in rows.items()}


def _by_bin(quantity: str, values: tp.EstimateArray | np.ndarray) -> dict[str, object]:
    return {f"{quantity}, μ {EDGES[i]:.3f} to {EDGES[i + 1]:.3f}": values[i] for i in range(CELLS)}


@of_scene(scene)
def exact(density: float, speed: float, motion: str, tilt: float, stuff: str) -> dict[str, float]:
    rows = {"fluence rate": effusion.fluence_rate(density, speed)}
    if motion == "stream":
        mu = math.cos(tilt)
        one_way = effusion.stream_flux_density(density, speed, mu)
        rows |= {"leaving the front": one_way, "arriving at the back": one_way}
        rows |= {"net": effusion.net_flux_density(density, speed, mu)}
    else:
        one_way = effusion.one_way_flux_density(density, speed)
        rows |= {"one way, onto the front": one_way, "one way, onto the back": one_way}
        rows |= {"net": effusion.net_flux_density(density, speed)}
        rows |= _by_bin("flux density", flux_densities(density, speed))
        rows |= _by_bin("radiance", np.full(CELLS, effusion.radiance(density, speed)))
    return {name: float(value) * STUFF[stuff][0] for name, value in rows.items()}


def flux_densities(density: float, speed: float) -> np.ndarray:
    """Flux density a steradian in each bin of an isotropic gas [m^-2 s^-1 sr^-1]: n v/4π times its mean cosine."""
    bins = EDGES, (0.0, 2 * math.pi)
    flux = effusion.flux_in_bin(density, speed, bin_projected_solid_angles(*bins))
    return (flux / bin_solid_angles(*bins))[:, 0]


def verdict(outcomes: list[Outcome]) -> str:
    said = []
    for outcome in where(motion="isotropic")(outcomes):
        share = outcome["one way, onto the front"].estimate / outcome["fluence rate"].estimate
        said.append(
            f"{share} of n v crosses one way, a quarter; each direction brings it with its cosine: n v cosθ"
        )
    if carried := where(stuff=CARRIED)(outcomes):
        flows = ", ".join(f"{o['net'].estimate} of {o.given['stuff']}" for o in carried)
        said.append(f"any stuff flows alike: {flows}")
    if not said:
        shares = [f"{o['net'].estimate / o['fluence rate'].estimate}" for o in outcomes]
        said.append(f"a stream brings n v cosθ: over its fluence rate, {', '.join(shares)}")
    return sentence(*said)


def draw_gas(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Flux density by direction, which falls with the cosine, beside the radiance, which is the same in all directions."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import figure

    result = outcomes[0].result
    front, emission = result[result.scene.detectors[0].name], result.scene.sources[0].emission
    level, bins = effusion.radiance(emission.density, emission.speed), EDGES
    quantities = {
        "flux density: n v cosθ / 4π": (front.flux_density, lambda mu: level * mu, "wrong: without the cosine", lambda mu: level + 0 * mu),
        "radiance: n v / 4π": (front.radiance, lambda mu: level + 0 * mu, "wrong: as the cosine", lambda mu: level * mu),
    }  # fmt: skip
    title = "A gas from all sides: flux falls with the cosine, radiance does not"
    with figure((18, 9.6), title, note, path) as page:
        grid = page.subplots(2, 2, sharex="col", sharey="row", height_ratios=(2.7, 1))
        for column, (words, (seen, law_of, wrong, guide)) in zip(grid.T, quantities.items(), strict=True):
            series = Series(bins, seen, law_of, law_of((bins[1:] + bins[:-1]) / 2))
            labels = {"xlabel": "μ = cosθ", "ylabel": "per steradian", "legend": "lower right"}
            plot_curves(series, ax=tuple(column), guides={wrong: guide}, **labels)
            column[0].set(title=words, ylim=(0, 1.35 * level))


def draw_stuff(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The same oblique prism three times, each particle with what it carries; the flux density beside its law."""
    from transport.viz.style import BLUE, GREEN, INK, MUTED, VERMILLION, figure, unit_label

    signs = {"mass": ("m", BLUE), "charge": ("q", VERMILLION), "energy": ("hν", GREEN)}
    with figure((7 * len(outcomes), 9), "The same counts carry any stuff: s n v cosθ", note, path) as page:
        pairs = page.subplots(
            2, len(outcomes), squeeze=False, sharey="row", gridspec_kw={"height_ratios": (1.1, 1)}
        )
        for (above, below), outcome in zip(pairs.T, outcomes, strict=True):
            kind, tilt, row = outcome.given["stuff"], outcome.given["tilt"], outcome["net"]
            sign, colour = signs[kind]
            _draw_carriers(above, tilt, sign, colour)
            carried = f"{STUFF[kind][0]:.3g} {STUFF[kind][1]}"
            above.set_title(f"{kind}: {sign} = {carried} each", color=colour)
            full = row.exact / math.cos(tilt)
            theta = np.linspace(0, 90, 181)
            below.plot(theta, full * np.cos(np.radians(theta)) / full, color=INK, lw=2.5, label="s n v cosθ")
            below.axhline(1, color=MUTED, ls="--", lw=2.5, label="without the cosine: s n v")
            reading = row.estimate / constant(outcome.result, full, str(row.estimate.unit))
            below.plot(math.degrees(tilt), reading.value, "o", color=colour, ms=15, mec="white")
            words = f"{row.estimate.value:.4g} {unit_label(row.estimate.unit)}"
            below.text(64, 0.84, words, ha="center", color=colour)
            below.set(xlabel="θ to the normal  [deg]", xlim=(0, 90), ylim=(0, 1.15), xticks=range(0, 91, 30))
        pairs[1, 0].set_ylabel("flux density / (s n v)")
        pairs[1, 0].legend(loc="lower left")


def _draw_carriers(axes: Axes, tilt: float, sign: str, colour: str) -> None:
    """A patch, the prism of those that cross it within dt, and particles with what they carry."""
    from transport.viz.style import INK, MUTED

    across = np.array([math.sin(tilt), math.cos(tilt)])  # of the patch, in the plane (z, x)
    normal = np.array([math.cos(tilt), -math.sin(tilt)])
    ends = np.array([-across, across])
    back = np.array([2.6, 0.0])
    outline = np.array([*ends, *(ends[::-1] - back), ends[0]])
    axes.plot(*outline.T, "--", color=MUTED, lw=2.5)
    axes.plot(*ends.T, color=INK, lw=6, solid_capstyle="butt")
    for along, aside in ((0.18, -0.62), (0.5, 0.0), (0.25, 0.62), (0.66, -0.62), (0.72, 0.62)):
        place = aside * across - along * back
        axes.annotate(
            "",
            place + (0.5, 0),
            place + (0.15, 0),
            arrowprops={"arrowstyle": "-|>", "lw": 2.5, "color": colour},
        )
        axes.plot(*place, "o", ms=27, mfc="white", mec=colour, mew=2.5)
        axes.text(*place, sign, ha="center", va="center_baseline", color=colour, fontsize=15)
    axes.annotate("", 0.9 * normal, (0, 0), arrowprops={"arrowstyle": "-|>", "lw": 2.5, "color": INK})
    axes.text(*(1.1 * normal), "n", ha="center", va="center", fontweight="bold")
    axes.text(-2.2, -0.58, "v dt", color=MUTED, ha="center", va="top")
    axes.set(aspect="equal", xlim=(-3.6, 1.3), ylim=(-1.2, 0.65), xticks=[], yticks=[])
    axes.spines[:].set_visible(False)


draw = figures(
    gas=(draw_gas, where(motion="isotropic")), stuff=(draw_stuff, where(motion="stream", stuff=CARRIED))
)


if __name__ == "__main__":
    main(__file__)
