"""Commands for saved runs: show and merge."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from transport.cli.options import Json
from transport.cli.output import print_json, print_labelled, print_rich
from transport.cli.run import bins_record, estimate_record, number_record
from transport.results.report import run_line
from transport.results.result import Result
from transport.statistics.estimates import Estimate, EstimateArray
from transport.validation import SceneError

Files = Annotated[list[Path], typer.Argument(metavar="FILE...", help="Saved runs, .nc or .npz")]
MAX_BINS = 100_000  # per quantity in the JSON output


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
        _print_result(load(files[0]), json)
    elif json:
        print_json([{"file": str(file)} | _result_record(load(file)) for file in files])
    else:
        for file in files:
            print_labelled(str(file), run_line(load(file)))


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
    from transport.io.runs import check_not_existing, checked_destination

    checked_destination("--out", out)
    if out.exists() and out.resolve() in {file.resolve() for file in files}:
        raise SceneError(f"--out: {out} is one of the files to merge; name another output file")
    check_not_existing("--out", out, overwrite)
    whole = merge(*files)
    whole.save(out)
    _print_result(whole, json)


def _print_result(result: Result, json: bool) -> None:
    if json:
        print_json(_result_record(result))
        return
    print_rich(result.report())
    for origin in result.state.origins:
        print_rich(
            f"run by: transport {origin.version} ({origin.sources}), {', '.join(origin.versions)};"
            f" {origin.machine}"
        )


def _result_record(result: Result) -> dict[str, object]:
    """Return the same data as JSON-ready types."""
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
        "method": asdict(result.plan.method),
        "complete": result.is_complete,
        "quantities": [
            {"name": name, **estimate_record(q)} for name, q in quantities.items() if isinstance(q, Estimate)
        ],
        "bins": [bins_record(name, q) for name, q in arrays.items() if q.value.size <= MAX_BINS],
        "left out": [name for name, q in arrays.items() if q.value.size > MAX_BINS],
        "ledger": {name: number_record(entry) for name, entry in result._own_ledger.items()},
        "cost": None if result.cost is None else asdict(result.cost),
        "warnings": result.warnings,
        "done by": [vars(origin) for origin in result.state.origins],
    }
