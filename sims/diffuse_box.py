"""Diffuse box: light that is reflected again and again between six walls, and where all of it goes.

Derivation.  A diffuse wall of albedo ρ gives off what it emits and what it reflects, M = M_emitted + ρ E (Goral et al.
1984, the radiosity equation), so that M - ρ E is what it emits by itself: on every wall, whatever the others do.  In a
closed box all that is emitted is absorbed in the end, Σ (1 - ρ) Φ_in = P, so that the walls receive P/(1 - ρ) in all,
the geometric series of reflections.  Without reflection (ρ = 0) a wall receives P F, F the view factor from the ceiling
to it (Howell, C-11 and C-14).  Where all walls emit M0 alike, E = M0/(1 - ρ) at every point: a furnace, in which no
shape can be told (Kirchhoff 1860).

How sharp.  A particle of weight w leaves a wall with ρ w (roulette comes after it has been counted), and the ledger's
integers close exactly.  So the random parts of M and ρ E are the same numbers, and M - ρ E keeps about 1e-16 of M: rows
whose batches agree to 1e-12 are labelled exact.  Were E and M estimated from separate runs, the difference would have
their errors, about 1e-3 for a million particles.

Scene.  A room 4 m long, 3 m wide and 2.5 m high; the ceiling emits, or all walls do.
"""

from __future__ import annotations

from pathlib import Path

import transport as tp
from transport.sims import (
    constant,
    figures,
    main,
    of_scene,
    one_of,
    require,
    sentence,
    sharp,
    where,
)
from transport.theory import enclosures
from transport.theory.view_factors import box_view_factors
from transport.verification.experiment import Outcome

law = "M - ρE = M_emitted, Σ(1 - ρ)Φ = P, E = M0/(1 - ρ) where all walls emit (Goral et al. 1984; Kirchhoff 1860)"
question = "Where does the light of a closed room go, and what does each wall receive?"
particles = 1_000_000

ROOM = tp.Box(size=(4.0, 3.0, 2.5))
WALLS = {"left": "-x", "right": "+x", "back": "-y", "front": "+y", "floor": "-z", "ceiling": "+z"}
BRIGHT = 0.65  # of the colour map, above which words are dark


def cases() -> list[dict[str, object]]:
    return [*({"albedo": albedo} for albedo in (0.0, 0.5, 0.9)), {"albedo": 0.5, "emitting": "all walls"}]


def scene(albedo: float = 0.5, exitance: float = 100.0, emitting: str = "ceiling") -> tp.Scene:
    """Six diffuse walls seen from inside.  exitance: of the emitting walls [W m^-2];  emitting: "ceiling" or "all walls"."""
    require("diffuse_box", albedo=(albedo, albedo != 1, "below 1, as else nothing would ever be absorbed"))
    faces, emission = ROOM.faces(), tp.Lambertian(exitance=exitance)
    return tp.Scene(
        sources=[tp.Source(name, emission, side="back") for name in _emitting(emitting)],
        surfaces=[tp.Surface(faces[face], tp.Diffuse(albedo), name=name) for name, face in WALLS.items()],
        detectors=[tp.Detector(name, side="back") for name in WALLS],
    )


def _emitting(emitting: str) -> list[str]:
    walls = {"ceiling": ["ceiling"], "all walls": list(WALLS)}
    one_of("diffuse_box", emitting=(emitting, walls))
    return walls[emitting]


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    albedo = result.scene.surfaces[0].material.albedo
    walls = {name: result[name] for name in WALLS}
    emitted = result.ledger["emitted"]
    ends = sum(entry for name, entry in result.ledger.items() if name != "emitted")
    absorbed = sum((1 - albedo) * wall.flux_in for wall in walls.values())
    rows = {"ledger: sum of all ends": sharp(ends, of=emitted), "Σ (1 - ρ) Φ_in": sharp(absorbed, of=emitted)}
    given_off = {name: (wall.exitance, wall.irradiance) for name, wall in walls.items()}
    own = {name: sharp(m - albedo * e, of=m) for name, (m, e) in given_off.items()}
    received = _each("E", {name: wall.irradiance for name, wall in walls.items()})
    if len(result.scene.sources) > 1:
        total = sum(constant(result, wall.area, "m^2") * own[name] for name, wall in walls.items())
        return rows | {"Σ (M - ρE) A": sharp(total, of=emitted)} | received
    received.pop("E, ceiling")
    return rows | _each("M - ρE", own) | (received if albedo == 0 else {})


@of_scene(scene)
def exact(albedo: float, exitance: float, emitting: str) -> dict[str, float]:
    areas = {name: ROOM.faces()[face].area for name, face in WALLS.items()}
    own = {name: exitance * (name in _emitting(emitting)) for name in WALLS}
    power = sum(own[name] * areas[name] for name in WALLS)
    rows = {"ledger: sum of all ends": power, "Σ (1 - ρ) Φ_in": power}
    if emitting == "all walls":
        everywhere = enclosures.furnace_irradiance(exitance, albedo)
        return rows | {"Σ (M - ρE) A": power} | _each("E", dict.fromkeys(WALLS, everywhere))
    rows |= _each("M - ρE", own)
    if albedo == 0:
        shares = box_view_factors(ROOM.size)[-1]  # from the ceiling to each wall, in the order of WALLS
        received = {name: power * s / areas[name] for name, s in zip(WALLS, shares, strict=True)}
        rows |= _each("E", {name: value for name, value in received.items() if name != "ceiling"})
    return rows


def _each(quantity: str, values: dict) -> dict:
    return {f"{quantity}, {name}": value for name, value in values.items()}


def verdict(outcomes: list[Outcome]) -> str:
    shares = [o.result.ledger["absorbed"].value / o.result.ledger["emitted"].value for o in outcomes]
    said = [
        f"All that is emitted is absorbed ({min(shares):.4f} to {max(shares):.4f}; the rest is roulette's noise)"
    ]
    if sharpest := [o["M - ρE, ceiling"] for o in where(emitting="ceiling")(outcomes)]:
        off = max(abs(row.estimate.value / row.exact - 1) for row in sharpest)
        said.append(f"on the ceiling M - ρE is what it emits to {off:.0e}")
    for outcome in where(emitting="all walls")(outcomes):
        found = [row.estimate.value for row in outcome.rows if row.name.startswith("E, ")]
        said.append(f"where all walls emit, each receives {min(found):.2f} to {max(found):.2f} W m^-2")
    return sentence(*said)


def draw_unfolded(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The box of each case unfolded to its six faces, coloured by irradiance over the emitted exitance."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm

    from transport.viz.style import SEQUENTIAL, figure, tick_log

    shares = {id(o): _shares(o) for o in outcomes}
    top = max(share.value for each in shares.values() for share in each.values())
    norm = LogNorm(0.06 * top, 1.35 * top, clip=True)
    columns = 2 if len(outcomes) > 1 else 1
    rows = -(-len(outcomes) // columns)
    title = "The walls of a closed box receive P/(1 − ρ) in all, and absorb P"
    with figure((9.4 * columns + 1.6, 7.2 * rows + 1.0), title, note, path) as page:
        grid = page.subplots(rows, columns, squeeze=False)
        for axes, outcome in zip(grid.flat, outcomes, strict=False):
            _draw_faces(axes, outcome, shares[id(outcome)], norm)
        for axes in list(grid.flat)[len(outcomes) :]:
            axes.remove()
        bar = page.colorbar(ScalarMappable(norm, SEQUENTIAL), ax=grid, aspect=34, pad=0.01)
        tick_log(bar.ax.yaxis)
        bar.set_label("E of a wall / M of an emitting one")


def _shares(outcome: Outcome) -> dict[str, tp.Estimate]:
    """Irradiance of each wall over the exitance of an emitting one."""
    emitted = constant(outcome.result, outcome.given["exitance"], "W m^-2")
    return {name: outcome.result[name].irradiance / emitted for name in WALLS}


def _draw_faces(axes, outcome: Outcome, shares: dict[str, tp.Estimate], norm) -> None:
    """Floor in the middle, walls about it, the ceiling beside the right one; emitting walls have a broad rim."""
    from matplotlib import colormaps
    from matplotlib.patches import Rectangle

    from transport.viz.style import INK, SEQUENTIAL, SKY, outlined
    from transport.viz.wording import number_text

    length, width, height = ROOM.size
    places = {  # corner and size
        "left": (-height, 0, height, width), "floor": (0, 0, length, width), "right": (length, 0, height, width),
        "ceiling": (length + height, 0, length, width), "front": (0, -height, length, height), "back": (0, width, length, height),
    }  # fmt: skip
    albedo, emitting = outcome.given["albedo"], _emitting(outcome.given["emitting"])
    for name, (x, y, wide, high) in places.items():
        colour = colormaps[SEQUENTIAL](norm(shares[name].value))
        axes.add_patch(Rectangle((x, y), wide, high, fc=colour, ec="white", lw=3))
        if name in emitting:
            inner = Rectangle(
                (x + 0.13, y + 0.13), wide - 0.26, high - 0.26, fc="none", ec=SKY, lw=6, zorder=3
            )
            axes.add_patch(inner)
        is_bright = norm(shares[name].value) > BRIGHT
        ink = {"color": INK} if is_bright else {"color": "white", "path_effects": outlined()}
        words = {"ha": "center", "va": "center", "zorder": 4, "fontsize": 20} | ink
        number = number_text(shares[name]).replace(" ± ", "\n± ")
        axes.text(x + wide / 2, y + 0.82 * high, name, **words)
        axes.text(x + wide / 2, y + 0.5 * high, number, fontweight="bold", linespacing=1.0, **words)
        if (row := f"E, {name}") in outcome:
            known = f"exact {outcome[row].exact / outcome.given['exitance']:.4g}"
            axes.text(x + wide / 2, y + 0.17 * high, known, **words | {"fontsize": 17})
    walls = (outcome.result[name] for name in WALLS)
    received = sum(wall.flux_in for wall in walls) / outcome.result.ledger["emitted"]
    said = f"received / emitted:\n{number_text(received)}\n1/(1 − ρ) = {1 / (1 - albedo):.4g}"
    axes.text(length + 0.4, -0.5 * height, said, fontsize=20, va="center")
    lit = {"ceiling": "ceiling emits", "all walls": "all walls emit"}[outcome.given["emitting"]]
    axes.set(
        aspect="equal",
        xlim=(-height - 0.1, 2 * length + height + 0.1),
        ylim=(-height - 0.1, width + height + 0.1),
    )
    axes.set_title(f"ρ = {albedo:g}, {lit}")
    axes.axis("off")


draw = figures(unfolded=draw_unfolded)


if __name__ == "__main__":
    main(__file__)
