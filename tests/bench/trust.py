"""Does the verdict of an estimate hold?  Scenes whose light some estimators find by chance alone, and random rooms.

    python -m tests.bench.trust named [--seeds 20] [--particles 1e6] [--scenes mirror ...] [--json named.json]
    python -m tests.bench.trust rooms [--first 0] [--last 300] [--step 1] [--particles 5e5] [--json rooms.json]
    python -m tests.bench.trust auto [--first 0] [--last 300] [--step 1] [--json auto.json]
    python -m tests.bench.trust references [--first 0] [--last 300] [--seconds 10]

A run is WRONG if it is off the exact value by more than 3 standard errors (Student's t of the same rate of false alarms, the
reference's error in quadrature) and by more than 1 %.  A wrong run must be doubtful, or bounded with the exact value in its interval; else it is
MISSED.  A run is COMPLETE if each class of light that brings more than 1 % of the value is connected exactly by its estimator, or has an
expected number of scores of at least 50: that is known of the scene beforehand, not of the run.  Complete runs may be wrong by
chance: how many of them are expected to be is printed beside how many were missed.  At most 5 % of complete runs may be doubtful.
"""

from __future__ import annotations

import itertools
import json
import math
import time
import zlib
from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

import typer
from scipy.special import ndtr, ndtri, stdtr, stdtrit

import transport as tp
from tests.bench import trust_references
from tests.bench.trust_references import Class, classes_of
from tests.specular_rooms import ROOMS, random_room
from tests.specular_scenes import CASES, Case

REFERENCES = Path(__file__).with_name("trust_references.json")
METHODS = {
    "analog": {"estimator": "analog"},
    "aimed": {"estimator": "aimed"},
    "expected": {"estimator": "expected"},
    "expected, sobol": {"estimator": "expected", "sampling": "sobol"},
    "backward": {"estimator": "backward"},
    "auto": {"estimator": "auto"},
}
OF_ROOMS = ("analog", "expected", "expected, sobol", "backward", "auto")
SIGMAS = 3.0  # beyond which a run is wrong, if it is also
OFF = 0.01  # off by this share
SURE = 2 * float(ndtr(SIGMAS)) - 1  # confidence of an interval of so many standard errors
SIGNIFICANT = 0.01  # share of the value from which a class matters
ENOUGH = 50.0  # scores with which a class is found
FAMILY = 1e-3  # rate of false alarms of all comparisons of rooms together


@dataclass(frozen=True)
class Run:
    """What one run said.  chosen: the estimator that "auto" took;  low, high: its interval of confidence SURE."""

    method: str
    chosen: str
    seed: int
    histories: int
    value: float
    error: float
    dof: float
    verdict: str
    low: float
    high: float
    seconds: float
    why: str


@dataclass(frozen=True)
class Judged:
    """A run against the truth.  is_complete: None where the truth is not known well enough to tell."""

    run: Run
    is_wrong: bool
    is_missed: bool
    is_complete: bool | None
    chance: float  # probability that a run whose error bar holds is wrong


def run_of(scene: tp.Scene, method: str, histories: float, seed: int, **more) -> Run | None:
    """One run on one thread; None where the scene does not allow the estimator."""
    begun = time.process_time()
    how = {"particles": histories} | METHODS[method] | {"threads": 1, "progress": False} | more
    try:
        result = tp.simulate(scene, seed=seed, **how)
    except tp.SceneError:
        return None
    estimate = result["m"].irradiance
    verdict, why = verdict_of(result)
    low, high = estimate.interval(SURE)
    return Run(
        method,
        result.plan.method.estimator,
        seed,
        result.particles,
        estimate.value,
        estimate.error,
        float(estimate.dof),
        verdict,
        low,
        high,
        time.process_time() - begun,
        why,
    )


def verdict_of(result: tp.Result) -> tuple[str, str]:
    """Return the verdict on the irradiance of detector "m", and its findings."""
    estimate = result["m"].irradiance
    return estimate.verdict, "; ".join(finding.what for finding in estimate.findings)


# ---- judging ----


def judge(run: Run, value: float, error: float, classes: list[Class], missing: float = 0.0) -> Judged:
    """A run against a reference of that error; missing: of the reference itself, beyond its error."""
    off = abs(run.value - value)
    is_known = run.error >= 0  # not nan
    reach = math.inf
    if is_known:
        reach = math.hypot(quantile(run.dof) * run.error, SIGMAS * error) + missing
    is_wrong = off > OFF * value and not off <= reach if is_known else off > OFF * value
    slack = SIGMAS * error + missing
    is_bounded = run.verdict == "bounded" and run.low - slack <= value <= run.high + slack
    is_missed = is_wrong and not (run.verdict == "doubtful" or is_bounded)
    chance = 0.0
    if is_known and run.error > 0:
        chance = 2 * float(stdtr(run.dof, -max(reach, OFF * value) / math.hypot(run.error, error)))
    return Judged(run, is_wrong, is_missed, is_complete(classes, run.histories), chance)


def quantile(dof: float) -> float:
    """Student's t that is exceeded as rarely as SIGMAS normal standard errors are."""
    return SIGMAS if math.isinf(dof) else float(stdtrit(dof, ndtr(SIGMAS)))


def is_complete(classes: Iterable[Class], histories: int) -> bool | None:
    """Whether each class that matters is connected, or is expected to score often enough; None where that is not known."""
    answers = [_is_found(each, histories) for each in classes]
    return False if False in answers else None if None in answers else True


def _is_found(light: Class, histories: int) -> bool | None:
    low, high = light.share - 2 * light.error, light.share + 2 * light.error
    if high <= SIGNIFICANT or histories * light.rate * max(low, SIGNIFICANT) >= ENOUGH:
        return True
    return False if low > SIGNIFICANT and histories * light.rate * high < ENOUGH else None


def summary_of(judged: list[Judged]) -> dict[str, float]:
    """Counts of runs: wrong, and of these doubtful, bounded and missed; complete, and of these by verdict."""
    wrong = [each for each in judged if each.is_wrong]
    complete = [each for each in judged if each.is_complete]
    counts = {"runs": len(judged), "wrong": len(wrong)}
    counts |= {"wrong doubtful": sum(each.run.verdict == "doubtful" for each in wrong)}
    counts |= {"wrong bounded": sum(not each.is_missed and each.run.verdict == "bounded" for each in wrong)}
    counts |= {"missed": sum(each.is_missed for each in wrong), "complete": len(complete)}
    for verdict in ("sound", "bounded", "doubtful"):
        counts[f"complete {verdict}"] = sum(each.run.verdict == verdict for each in complete)
    counts |= {"missed complete": sum(each.is_missed for each in complete)}
    counts |= {"chance": math.fsum(each.chance for each in complete if each.run.verdict != "doubtful")}
    counts |= {"chance of all": math.fsum(each.chance for each in judged if each.run.verdict != "doubtful")}
    counts |= {"unknown": sum(each.is_complete is None for each in judged)}
    return counts | {"seconds": math.fsum(each.run.seconds for each in judged)}


HEADER = (
    f"{'':40s} {'runs':>5s} | {'wrong':>5s} {'doubt':>5s} {'bound':>5s} {'MISS':>5s} |"
    f" {'compl':>5s} {'sound':>5s} {'bound':>5s} {'doubt':>5s} {'miss':>4s} {'exp.':>5s} | {'s/run':>5s}"
)


def line_of(title: str, counts: dict[str, float]) -> str:
    """One line of the table."""
    c = counts
    return (
        f"{title:40s} {c['runs']:5d} | {c['wrong']:5d} {c['wrong doubtful']:5d} {c['wrong bounded']:5d} {c['missed']:5d} |"
        f" {c['complete']:5d} {c['complete sound']:5d} {c['complete bounded']:5d} {c['complete doubtful']:5d}"
        f" {c['missed complete']:4d} {c['chance']:5.2f} | {c['seconds'] / max(c['runs'], 1):5.2f}"
    )


# ---- named scenes ----


def named_runs(
    case: Case, radius: float, seeds: int, histories: float, methods: Iterable[str]
) -> list[Judged]:
    """All runs of a scene with a detector of that radius."""
    scene, (value, error) = case.scene(radius), case.value(radius)
    found = []
    for method in methods:
        first = zlib.crc32(
            f"{case.name} {radius} {method}".encode()
        )  # so that no two lines are wrong by the same chance
        for seed in range(first, first + seeds):
            run = run_of(scene, method, histories * case.histories, seed)
            if run is None:
                break
            classes = [
                Class(light.value / value, 0.0, light.rates[run.chosen] * value / light.value)
                for light in case.lights(radius)
                if run.chosen in light.rates and light.value > 0
            ]
            found.append(judge(run, value, error, classes))
    return found


# ---- random rooms ----


def room_runs(k: int, reference: dict, histories: float, methods: Iterable[str] = OF_ROOMS) -> list[Judged]:
    """One run of each estimator that room k allows, with seeds of their own."""
    scene = random_room(k)
    runs = [run_of(scene, method, histories, 100 * k + number) for number, method in enumerate(methods)]
    return [_judged_in_room(run, reference) for run in runs if run is not None]


def _judged_in_room(run: Run, reference: dict) -> Judged:
    value, error, missing = (reference[name] for name in ("value", "error", "missing"))
    return judge(run, value, error, classes_of(reference, run.chosen), missing * value)


def disagreements(rooms: dict[int, list[Judged]]) -> tuple[list[tuple], int, int]:
    """Pairs of estimates of one room, neither doubtful, that differ beyond the family's rate; pairs, and those beyond SIGMAS."""
    pairs = [
        (k, a.run, b.run)
        for k, judged in rooms.items()
        for a, b in itertools.combinations([each for each in judged if each.run.verdict == "sound"], 2)
    ]
    scores = [z_between((a.value, a.error, a.dof), (b.value, b.error, b.dof)) for _, a, b in pairs]
    limit = family_limit(len(pairs))
    far = [(*pair, z) for pair, z in zip(pairs, scores, strict=True) if not z <= limit]
    return far, len(pairs), sum(not z <= SIGMAS for z in scores)


def family_limit(comparisons: int) -> float:
    """The normal score beyond which one of so many comparisons comes with probability FAMILY (Bonferroni)."""
    return float(-ndtri(FAMILY / max(comparisons, 1) / 2))


def z_between(a: tuple[float, float, float], b: tuple[float, float, float]) -> float:
    """Size of the normal score of the difference of two (value, error, dof), by Welch's t."""
    error = math.hypot(a[1], b[1])
    if not error > 0:
        return 0.0 if a[0] == b[0] else math.inf
    dof = error**4 / sum((each[1] ** 4 / each[2] if each[2] > 0 else 0.0) for each in (a, b))
    return float(-ndtri(max(stdtr(dof, -abs(a[0] - b[0]) / error), 1e-300)))


def off_reference(judged: Judged, reference: dict) -> float:
    """Normal score of a run's difference from the reference, less what the reference may have missed."""
    value, error = reference["value"], reference["error"]
    apart = max(abs(judged.run.value - value) - reference["missing"] * value, 0.0)
    return z_between((value + apart, judged.run.error, judged.run.dof), (value, error, 31.0))


def judge_rooms(numbers: Iterable[int], histories: float = 2e5, methods: Iterable[str] = OF_ROOMS) -> dict:
    """Runs of so many rooms and what came of them: for the suite `judge_rooms(range(0, 300, 10))`, under a minute once compiled."""
    references = stored_references()
    numbers = [k for k in numbers if str(k) in references]
    rooms = {k: room_runs(k, references[str(k)], histories, methods) for k in numbers}
    return {"rooms": rooms} | verdicts_on(rooms, references)


def verdicts_on(rooms: dict[int, list[Judged]], references: dict) -> dict:
    """What the rooms are judged by."""
    judged = [(k, each) for k, runs in rooms.items() for each in runs]
    sound = [(k, each) for k, each in judged if each.run.verdict == "sound"]
    scores = [off_reference(each, references[str(k)]) for k, each in sound]
    limit = family_limit(len(sound))
    pairs, compared, beyond = disagreements(rooms)
    complete = [each for _, each in judged if each.is_complete]
    return {
        "disagreements": pairs,
        "pairs": compared,
        "pairs beyond 3": beyond,
        "off reference": [
            (k, each.run, z) for (k, each), z in zip(sound, scores, strict=True) if not z <= limit
        ],
        "sound": len(sound),
        "sound beyond 3": sum(not z <= SIGMAS for z in scores),
        "complete": len(complete),
        "complete sound": _share(complete, "sound"),
        "complete bounded": _share(complete, "bounded"),
        "complete doubtful": _share(complete, "doubtful"),
        "missed": sum(each.is_missed for _, each in judged),
    }


def _share(judged: list[Judged], verdict: str) -> float:
    return sum(each.run.verdict == verdict for each in judged) / max(len(judged), 1)


def stored_references() -> dict:
    """By the number of the room, as a text."""
    return json.loads(REFERENCES.read_text())


# ---- the command ----

app = typer.Typer(add_completion=False, help=__doc__)


@app.command()
def named(
    scenes: list[str] = typer.Option(None, help="names of CASES; all where none is given"),  # noqa: B008
    seeds: int = 20,
    particles: float = 1e6,
    methods: list[str] = typer.Option(None),  # noqa: B008
    json_: Path = typer.Option(None, "--json"),  # noqa: B008
) -> None:
    """Named scenes: a line per scene, radius and estimator."""
    stored, everything = [], []
    print(HEADER)
    for case in CASES.values():
        if scenes and case.name not in scenes:
            continue
        for radius in case.radii:
            judged = named_runs(case, radius, seeds, particles, methods or METHODS)
            everything += judged
            for method in dict.fromkeys(each.run.method for each in judged):
                of_method = [each for each in judged if each.run.method == method]
                counts = summary_of(of_method)
                print(line_of(f"{case.name} {1000 * radius:g} mm {method}", counts), flush=True)
                stored.append({"scene": case.name, "radius": radius, "method": method} | counts)
                stored[-1]["each"] = [_stored(each) for each in of_method]
            _store(json_, stored)
    _print_total(everything)


@app.command()
def rooms(
    first: int = 0,
    last: int = ROOMS,
    step: int = 1,
    particles: float = 5e5,
    json_: Path = typer.Option(None, "--json"),  # noqa: B008
) -> None:
    """Random rooms: one run of each estimator in each."""
    references, found = stored_references(), {}
    for k in (k for k in range(first, last, step) if str(k) in references):
        found[k] = room_runs(k, references[str(k)], particles)
        _store(json_, {k: [_stored(each) for each in judged] for k, judged in found.items()})
        for each in found[k]:
            if each.is_missed:
                print(f"room {k}: missed by {told(each, references[str(k)])}", flush=True)
    everything = [each for judged in found.values() for each in judged]
    print(HEADER)
    for method in OF_ROOMS:
        print(line_of(method, summary_of([each for each in everything if each.run.method == method])))
    _print_total(everything)
    _print_verdicts(verdicts_on(found, references))


@app.command()
def auto(
    first: int = 0,
    last: int = ROOMS,
    step: int = 1,
    seconds: float = 30.0,
    json_: Path = typer.Option(None, "--json"),  # noqa: B008
) -> None:
    """The way that the guides recommend: an error of 1 % by estimator="auto", with a limit of time."""
    references, found, late = stored_references(), {}, 0
    for k in (k for k in range(first, last, step) if str(k) in references):
        begun, scene = time.perf_counter(), random_room(k)
        run = run_of(scene, "auto", None, 1, error={"m.irradiance": 0.01}, seconds=seconds)
        took = time.perf_counter() - begun
        found[k] = [_judged_in_room(run, references[str(k)])]
        late += took > seconds + 5  # compilation counts as preparation
        print(f"room {k:3d} {took:5.1f} s {told(found[k][0], references[str(k)])}", flush=True)
        _store(json_, {k: [_stored(each) for each in judged] for k, judged in found.items()})
    everything = [judged[0] for judged in found.values()]
    print(HEADER)
    print(line_of("auto, error 1 %", summary_of(everything)))
    print(f"{late} of {len(everything)} took more than {seconds + 5:g} s with their compilation")
    _print_verdicts(verdicts_on(found, references))


@app.command()
def references(
    first: int = 0, last: int = ROOMS, seconds: float = 10.0, worse_than: float = math.inf
) -> None:
    """Add references of random rooms that the file does not have; worse_than: make those again whose relative error is larger."""
    trust_references.main(first, last, seconds, REFERENCES, worse_than)


def told(judged: Judged, reference: dict) -> str:
    """One run in words."""
    run, value = judged.run, reference["value"]
    way = run.method if run.chosen in run.method else f"{run.method} ({run.chosen})"
    text = f"{way}: {run.value:.5g} ± {run.error:.2g} against {value:.5g} ± {reference['error']:.2g}, {run.verdict}"
    state = {True: "complete", False: "incomplete", None: "completeness not known"}[judged.is_complete]
    return f"{text}, {state}{', WRONG' * judged.is_wrong}{', MISSED' * judged.is_missed}"


def _print_total(judged: list[Judged]) -> None:
    counts = summary_of(judged)
    print(line_of("all", counts))
    complete = max(counts["complete"], 1)
    print(
        f"missed {counts['missed']}, where chance brings {counts['chance of all']:.1f}, of these {counts['missed complete']} of complete runs,"
        f" where chance brings {counts['chance']:.1f};"
        f" doubtful {100 * counts['complete doubtful'] / complete:.1f} % of {counts['complete']} complete runs;"
        f" {counts['unknown']} runs of which the truth is not known well enough to call them complete or not"
    )
    estimators = Counter(each.run.chosen for each in judged if each.run.method == "auto")
    print(
        "auto took " + (", ".join(f"{name} {count}" for name, count in estimators.most_common()) or "nothing")
    )


def _print_verdicts(found: dict) -> None:
    beyond = 2 * (1 - float(ndtr(SIGMAS)))
    print(
        f"pairs of sound estimates: {found['pairs']}, beyond 3 standard errors {found['pairs beyond 3']} (chance:"
        f" {beyond * found['pairs']:.1f}), beyond the family's rate {len(found['disagreements'])}"
    )
    for k, a, b, z in found["disagreements"]:
        print(
            f"  room {k}: {a.method} {a.value:.5g} ± {a.error:.2g}, {b.method} {b.value:.5g} ± {b.error:.2g}, z = {z:.1f}"
        )
    print(
        f"sound estimates against references: {found['sound']}, beyond 3 {found['sound beyond 3']} (chance:"
        f" {beyond * found['sound']:.1f}), beyond the family's rate {len(found['off reference'])}"
    )
    for k, run, z in found["off reference"]:
        print(f"  room {k}: {run.method} {run.value:.5g} ± {run.error:.2g}, z = {z:.1f}")
    print(
        f"of {found['complete']} complete runs sound {100 * found['complete sound']:.1f} %, bounded"
        f" {100 * found['complete bounded']:.1f} %, doubtful {100 * found['complete doubtful']:.1f} %; missed {found['missed']}"
    )


def _stored(judged: Judged) -> dict:
    return asdict(judged.run) | {
        "is_wrong": judged.is_wrong, "is_missed": judged.is_missed, "is_complete": judged.is_complete
    }  # fmt: skip


def _store(path: Path | None, found: object) -> None:
    if path is not None:
        path.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    app()
