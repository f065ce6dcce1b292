"""Commands for saved runs: show and merge."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from transport.cli.console import say, say_json, say_labelled
from transport.cli.options import Json
from transport.cli.run import bins_record, numbers_of
from transport.results.report import head_of
from transport.results.result import Result
from transport.statistics.estimates import Estimate, EstimateArray
from transport.validation import SceneError

Files = Annotated[list[Path], typer.Argument(metavar="FILE...", help="Saved runs, .nc or .npz")]
MOST_BINS = 100_000  # per quantity in the JSON output


def show(files: Files, json: Json = False) -> None:
    """Print the results and the cost of a saved run.

    Several files: one line per run.

    \b
    Examples:
      transport show run.nc
      transport show run.npz --json
      transport show part1.nc part2.nc
    """
    from transport.io import load

    if len(files) == 1:
        _tell(load(files[0]), json)
    elif json:
        say_json([{"file": str(file)} | _record(load(file)) for file in files])
    else:
        for file in files:
            say_labelled(str(file), head_of(load(file)))


def merge(
    files: Files,
    out: Annotated[Path, typer.Option(metavar="FILE", help="File of the merged run")],
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Overwrite an existing file")] = False,
    json: Json = False,
) -> None:
    """Merge runs of one scene: parts of a run, or different seeds.

    \b
    Examples:
      transport merge part1.nc part2.nc --out whole.nc
    """
    from transport.io import merge
    from transport.io.runs import check_new, checked_place

    checked_place("--out", out)
    if out.exists() and out.resolve() in {file.resolve() for file in files}:
        raise SceneError(f"--out: {out} is one of the files to merge; name another output file")
    check_new("--out", out, overwrite)
    whole = merge(*files)
    whole.save(out)
    _tell(whole, json)


def _tell(result: Result, json: bool) -> None:
    if json:
        say_json(_record(result))
        return
    say(result.report())
    for origin in result.state.origins:
        say(
            f"run by: transport {origin.version} ({origin.sources}), {', '.join(origin.versions)};"
            f" {origin.machine}"
        )


def _record(result: Result) -> dict[str, object]:
    """Return the same data as JSON-ready types."""
    method = result.plan.method
    quantities = {
        f"{name}.{quantity}": estimate
        for name in result
        for quantity, estimate in getattr(result[name], "quantities", {}).items()
    }
    arrays = {name: q for name, q in quantities.items() if isinstance(q, EstimateArray)}
    limits = result.state.limits
    return {
        "particles": result.particles,
        "asked": limits.particles,
        "part": list(limits.part),
        "batches": len(result.batches),
        "seeds": sorted({batch.seed for batch in result.batches}),
        "method": {"estimator": method.estimator, "sampling": method.sampling},
        "complete": result.is_complete,
        "quantities": [
            {"name": name, **numbers_of(q)} for name, q in quantities.items() if isinstance(q, Estimate)
        ],
        "bins": [bins_record(name, q) for name, q in arrays.items() if q.value.size <= MOST_BINS],
        "left out": [name for name, q in arrays.items() if q.value.size > MOST_BINS],
        "ledger": {
            name: {"value": entry.value, "error": entry.error, "unit": str(entry.unit)}
            for name, entry in result._own_ledger.items()
        },
        "cost": None if result.cost is None else asdict(result.cost),
        "warnings": result.warnings,
        "done by": [vars(origin) for origin in result.state.origins],
    }
