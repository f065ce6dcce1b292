"""References of the random rooms of tests/specular_rooms.py: the irradiance of each, and what it is made of.

`reference_of(scene)` runs every estimator that is right for a room, takes the most accurate and keeps the others beside it.  An
estimator is right where each class of paths that it finds by chance alone has come often enough (MIN_SCORES), or brings less
than NEGLIGIBLE of the value.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import transport as tp
from tests.specular_rooms import power_of, radiances, random_room, without_specular
from transport.compile.methods import refusal

SEED = 20_260_000  # of the references; runs that are judged in rooms have seeds below 30 000
PILOT = 1_000_000  # histories of the first run of each estimator
TARGET = 0.002  # relative standard error at which a reference is good enough
MIN_SCORES = 200  # of a class that is found by chance alone, for its error to be known
FEW = 10  # scores of a class below which more may be missing than the error says
NEGLIGIBLE = 0.0005  # of the value
SMALLEST_RUN = 200_000


def reference_of(scene: tp.Scene, seconds: float = 10.0) -> dict:
    """The irradiance of detector "m" with its error, the runs behind it and the shares of its classes of paths.

    seconds: of CPU for the best estimator; the others take half as long.
    """
    names = [name for name in ("expected", "backward") if refusal(scene, name) is None]
    pilots = {name: run_of(scene, name, PILOT, SEED) for name in names}
    if len(names) == 1:  # another estimator shall agree
        pilots["analog"] = run_of(scene, "analog", PILOT, SEED)
    foreseen = {name: _foreseen_error(scene, name, pilots) for name in pilots}
    best = min(foreseen, key=foreseen.get)
    runs = [
        run_of(
            scene, name, _histories(pilot, foreseen[name], seconds * (1.0 if name == best else 0.5)), SEED + 1
        )
        for name, pilot in pilots.items()
    ]
    shares = shares_of(scene, next(run["value"] for run in runs if run["estimator"] == best))
    for run in runs:
        run["missing"] = missing_of(scene, run, shares)
    chosen = min(runs, key=lambda run: math.hypot(run["error"], run["missing"] * run["value"]) / run["value"])
    return {
        **{name: chosen[name] for name in ("value", "error", "missing", "estimator", "histories")},
        "runs": runs,
        "shares": shares,
        "power": power_of(scene),
        "radiances": radiances(scene),
        "area": scene.shape_of(scene.detectors[0]).area,
    }


def missing_of(scene: tp.Scene, run: dict, shares: dict) -> float:
    """Share of the value that a run may have missed: at most three scores of a class (rule of three), or all that there is of it."""
    histories, value = run["histories"], run["value"]
    via = max(shares["via"][0] + 2 * shares["via"][1], 0.0)
    if run["estimator"] != "backward":
        by_one = power_of(scene) / (scene.shape_of(scene.detectors[0]).area * value * histories)
        scores = run["crossings"][0][1] if run["estimator"] == "expected" else via / by_one
        return 0.0 if scores >= FEW else min(3 * by_one, via)
    missing = 0.0
    for radiance, (direct, _), (_, scores) in zip(
        radiances(scene), shares["direct"], run["crossings"], strict=True
    ):
        by_one = math.pi * radiance / (value * histories)
        missing += 0.0 if scores >= FEW else min(3 * by_one, direct + via)
    return missing


@dataclass(frozen=True)
class Class:
    """A class of light that an estimator finds by chance alone.

    share: of the value, with its error;  rate: scores of a history on average for a share of 1, at least.
    """

    share: float
    error: float
    rate: float


def classes_of(reference: dict, estimator: str) -> list[Class]:
    """The classes that an estimator finds by chance alone in a room of that reference.

    Of light that met a specular object last (what "expected" cannot connect) or first ("backward") the share is that of the crossings of
    a long run, or what its rays leave of the value.  It is at most that of all light that met one.
    """
    value, shares = reference["value"], reference["shares"]
    forward = value * reference["area"] / reference["power"]
    via = (max(shares["via"][0], 0.0), math.hypot(shares["via"][1], reference["error"] / value))
    if estimator == "expected":
        return [Class(*_specular_last(reference, via), forward)]
    if estimator == "backward":
        return list(_backward(reference, via))
    direct = [Class(share, error, forward) for share, error in shares["direct"]]
    rest = max(1.0 - via[0] - sum(share for share, _ in shares["direct"]), 0.0)
    return [*direct, Class(*via, forward), Class(rest, via[1], forward)]


def _specular_last(reference: dict, via: tuple[float, float]) -> tuple[float, float]:
    """Share of the light that met a specular object last."""
    run = next(run for run in reference["runs"] if run["estimator"] == "expected")
    ((share, scores),) = run["crossings"]
    found = (share, share / math.sqrt(max(scores, 1)))
    if scores < MIN_SCORES:
        rays = run["value"] * (1 - share) / reference["value"]
        errors = (
            run["error"] / run["value"] if scores < FEW else 0.0,
            reference["error"] / reference["value"],
        )
        found = (max(1 - rays, 0.0), math.hypot(*errors))
    return min(found, via, key=lambda each: each[0] + 2 * each[1])


def _backward(reference: dict, via: tuple[float, float]) -> Iterator[Class]:
    """Of each lamp the direct light, and that which meets a specular object first."""
    run = next((run for run in reference["runs"] if run["estimator"] == "backward"), None)
    if run is None:
        return
    for radiance, (direct, error), (share, scores) in zip(
        reference["radiances"], reference["shares"]["direct"], run["crossings"], strict=True
    ):
        rate = reference["value"] / (math.pi * radiance)
        yield Class(direct, error, rate)
        rest = (max(share - direct, 0.0), math.hypot(share / math.sqrt(max(scores, 1)), error))
        yield Class(*min(rest, via, key=lambda each: each[0] + 2 * each[1]), rate)


def run_of(scene: tp.Scene, estimator: str, histories: int, seed: int) -> dict:
    """What a run of one thread gives: its value and error, and what of it crossings brought that no ray connects."""
    result = tp.simulate(scene, histories, seed=seed, estimator=estimator, threads=1, progress=False)
    estimate = result["m"].irradiance
    crossings = _crossings_backward(result) if estimator == "backward" else _crossings_forward(result)
    return {
        "estimator": estimator,
        "histories": result.particles,
        "seed": seed,
        "value": estimate.value,
        "error": estimate.error,
        "seconds": round(result.cost.seconds, 3),
        "crossings": crossings,  # [share of the value, number] of each lamp, or of all lamps together
        "lost": result.ledger["lost"].value,
    }


def shares_of(scene: tp.Scene, value: float) -> dict:
    """[share, its error] of the value: of light that met a specular object (via), and direct light of each lamp."""
    dark = _irradiance(without_specular(scene), "expected", 2 * PILOT)
    direct = [
        _irradiance(_direct(replace(scene, sources=(lamp,))), "expected", SMALLEST_RUN)
        for lamp in scene.sources
    ]
    return {
        "via": [1 - dark.value / value, _known(dark) / value],
        "direct": [[each.value / value, _known(each) / value] for each in direct],
    }


def _irradiance(scene: tp.Scene, estimator: str, histories: int) -> tp.Estimate:
    run = tp.simulate(scene, histories, seed=SEED + 2, estimator=estimator, threads=1, progress=False)
    return run["m"].irradiance


def _direct(scene: tp.Scene) -> tp.Scene:
    """The same scene, its detector counting only what nothing has turned."""
    (detector,) = scene.detectors
    return replace(scene, detectors=(replace(detector, events=0),))


def _known(estimate: tp.Estimate) -> float:
    """Its error, 0 where it has none."""
    return estimate.error if math.isfinite(estimate.error) else 0.0


def _foreseen_error(scene: tp.Scene, name: str, pilots: dict[str, dict]) -> float:
    """Relative error of an estimator for each root of a second, infinite where its crossings have come too rarely."""
    pilot = pilots[name]
    if not (pilot["error"] > 0 and pilot["value"] > 0):
        return math.inf
    error = pilot["error"] / pilot["value"]
    if name == "expected" and "backward" in pilots:
        seen = pilots["backward"]["value"]
        rays = pilot["value"] * (1 - sum(share for share, _ in pilot["crossings"]))
        share = max(1 - rays / seen, 0.0)
        scores = share * seen * scene.shape_of(scene.detectors[0]).area / power_of(scene) * pilot["histories"]
        if share > NEGLIGIBLE + 2 * pilots["backward"]["error"] / seen and scores < MIN_SCORES / 10:
            return math.inf
        error = math.hypot(error, share / math.sqrt(max(scores, 1.0)))
    return error * math.sqrt(pilot["seconds"])


def _histories(pilot: dict, foreseen: float, seconds: float) -> int:
    """As many as fit into the seconds, or fewer where the target needs fewer."""
    rate = pilot["histories"] / pilot["seconds"]
    wanted = (foreseen / TARGET) ** 2 if math.isfinite(foreseen) else seconds
    return max(SMALLEST_RUN, int(rate * min(seconds, max(wanted, 1.0))) // 10_000 * 10_000)


def _crossings_forward(result: tp.Result) -> list[list[float]]:
    """Share of the value and number of the crossings of the detector that histories made themselves."""
    tally = result["m"]
    rows, weights = tally.scores["weight in"].rows, tally.sums("weight in").sum()
    if not any(each.detector.name == "m" for each in tally.plan.expectations):  # an analog run: all of them
        return [[1.0, tally.number_of("weight in")]]
    own = [
        sum(getattr(batch, kind)[rows.first : rows.first + rows.count].sum() for batch in tally.batches)
        for kind in ("weights", "counts")
    ]
    return [[float(own[0] / weights) if weights else 0.0, int(own[1])]]


def _crossings_backward(result: tp.Result) -> list[list[float]]:
    """The same of the lamps that histories from the detector came to themselves, lamp by lamp."""
    sums = result["m"]._cells
    (part,) = sums.parts
    whole = sum(float(sums._radiance_sums(part, lamp).sum()) for lamp in sums.lamps)
    found = []
    for lamp in sums.lamps:
        weights, counts = (sums._rows(part, kind, 1 + lamp).sum() for kind in ("weights", "counts"))
        found.append([float(weights * part.gains[lamp] / whole) if whole else 0.0, int(counts)])
    return found


def main(first: int, last: int, seconds: float, path: Path, worse_than: float = math.inf) -> None:
    """Add references of rooms first to last - 1 to the file; those that it has are left as they are, if their relative errors are small enough."""
    stored = json.loads(path.read_text()) if path.exists() else {}
    for k in range(first, last):
        one = stored.get(str(k))
        if one is not None and math.hypot(one["error"] / one["value"], one["missing"]) <= worse_than:
            continue
        begun = time.perf_counter()
        stored[str(k)] = reference_of(random_room(k), seconds)
        write(stored, path)
        one = stored[str(k)]
        print(
            f"room {k:3d}  {one['value']:10.5g} ± {100 * one['error'] / one['value']:.2f} % by {one['estimator']}, {one['histories']:.2g}"
            f" histories; z of the others {disagreement(one):.1f}; via specular objects {100 * one['shares']['via'][0]:.2f} %;"
            f" {time.perf_counter() - begun:.0f} s",
            flush=True,
        )


def disagreement(reference: dict) -> float:
    """The largest z among the runs of a reference, each against the one that was taken; what they may have missed is no difference."""
    value, error, missing = reference["value"], reference["error"], reference["missing"]
    found = [0.0]
    for run in reference["runs"]:
        if run["estimator"] != reference["estimator"] and run["error"] > 0:
            apart = abs(run["value"] - value) - run["missing"] * run["value"] - missing * value
            found.append(apart / math.hypot(run["error"], error))
    return max(found)


def write(stored: dict, path: Path) -> None:
    """One line a room, so that changes can be read."""
    lines = ",\n".join(f"{json.dumps(k)}: {json.dumps(stored[k])}" for k in sorted(stored, key=int))
    temporary = path.with_suffix(".new")
    temporary.write_text("{\n" + lines + "\n}\n")
    temporary.replace(path)
