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

import numpy as np

import transport as tp
from transport.sims import constant, provenance, sharp
from transport.theory import enclosures
from transport.theory.view_factors import box_view_factors
from transport.verification.experiment import Outcome

law = "M - ρE = M_emitted, Σ(1 - ρ)Φ = P, E = M0/(1 - ρ) where all walls emit (Goral et al. 1984; Kirchhoff 1860)"
question = "Where does the light of a closed room go, and what does each wall receive?"
particles = 1_000_000

ROOM = tp.Box(size=(4.0, 3.0, 2.5))
WALLS = {"left": "-x", "right": "+x", "back": "-y", "front": "+y", "floor": "-z", "ceiling": "+z"}


def cases() -> list[dict[str, object]]:
    return [*({"albedo": albedo} for albedo in (0.0, 0.5, 0.9)), {"albedo": 0.5, "emitting": "all walls"}]


def scene(albedo: float = 0.5, exitance: float = 100.0, emitting: str = "ceiling") -> tp.Scene:
    """Six diffuse walls seen from inside.  exitance: of the emitting walls [W m^-2];  emitting: "ceiling" or "all walls"."""
    if albedo == 1:
        raise tp.SceneError("diffuse_box: albedo must be below 1, got 1: nothing would ever be absorbed")
    faces, emission = ROOM.faces(), tp.Lambertian(exitance=exitance)
    return tp.Scene(
        sources=[tp.Source(name, emission, side="back") for name in _emitting(emitting)],
        surfaces=[tp.Surface(faces[face], tp.Diffuse(albedo), name=name) for name, face in WALLS.items()],
        detectors=[tp.Detector(name, side="back") for name in WALLS],
    )


def _emitting(emitting: str) -> list[str]:
    walls = {"ceiling": ["ceiling"], "all walls": list(WALLS)}
    if emitting not in walls:
        raise tp.SceneError(f"diffuse_box: emitting must be 'ceiling' or 'all walls', got {emitting!r}")
    return walls[emitting]


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    albedo = result.scene.surfaces[0].material.albedo
    walls = {name: result[name] for name in WALLS}
    emitted = result.ledger["emitted"]
    ends = sum(entry for name, entry in result.ledger.items() if name != "emitted")
    absorbed = sum((1 - albedo) * wall.flux_in for wall in walls.values())
    rows = {"ledger: sum of all ends": sharp(ends, of=emitted), "Σ (1 - ρ) Φ_in": sharp(absorbed, of=emitted)}
    own = {
        name: sharp(wall.exitance - albedo * wall.irradiance, of=wall.exitance)
        for name, wall in walls.items()
    }
    if len(result.scene.sources) > 1:
        total = sum(constant(result, wall.area, "m^2") * own[name] for name, wall in walls.items())
        return (
            rows
            | {"Σ (M - ρE) A": sharp(total, of=emitted)}
            | _each("E", {n: w.irradiance for n, w in walls.items()})
        )
    rows |= _each("M - ρE", own)
    if albedo == 0:
        rows |= _each("E", {name: walls[name].irradiance for name in list(WALLS)[:-1]})
    return rows


def exact(albedo: float = 0.5, exitance: float = 100.0, emitting: str = "ceiling") -> dict[str, float]:
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
        rows |= _each(
            "E", {n: power * s / areas[n] for n, s in zip(WALLS, shares, strict=True) if n != "ceiling"}
        )
    return rows


def _each(quantity: str, values: dict) -> dict:
    return {f"{quantity}, {name}": value for name, value in values.items()}


def verdict(outcomes: list[Outcome]) -> str:
    shares = [o.result.ledger["absorbed"].value / o.result.ledger["emitted"].value for o in outcomes]
    said = f"All that is emitted is absorbed ({min(shares):.4f} to {max(shares):.4f}; the rest is roulette's noise)"
    sharpest = [o for o in outcomes if "M - ρE, ceiling" in [row.name for row in o.rows]]
    if sharpest:
        off = np.max(
            [abs(o["M - ρE, ceiling"].estimate.value / o["M - ρE, ceiling"].exact - 1) for o in sharpest]
        )
        said += f"; on the ceiling M - ρE is what it emits to {off:.0e}"
    for outcome in outcomes:
        if "Σ (M - ρE) A" in [row.name for row in outcome.rows]:
            found = [row.estimate.value for row in outcome.rows if row.name.startswith("E, ")]
            said += f"; where all walls emit, each receives {min(found):.2f} to {max(found):.2f} W m^-2"
    return said + "."


def draw(outcomes: list[Outcome], path: str) -> None:
    from transport.viz.comparisons import comparison

    table = {
        f"{row.name}\n{_setting(o.result.scene)}": (row.estimate, row.exact)
        for o in outcomes
        for row in o.rows
        if not row.estimate.exact
    }
    if not table:
        table = {row.name: (row.estimate, row.exact) for row in outcomes[0].rows}
    comparison(table, path, title="A closed diffuse box", note=provenance(outcomes))


def _setting(scene: tp.Scene) -> str:
    lit = "all walls emit" if len(scene.sources) > 1 else "ceiling emits"
    return f"ρ = {scene.surfaces[0].material.albedo:g}, {lit}"


if __name__ == "__main__":
    from transport.sims import print_table

    print_table(__file__)
