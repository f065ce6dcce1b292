"""Commands for saved runs: what one found out, and several as one."""

from pathlib import Path
from typing import Annotated

import typer

from transport.command.console import say, say_json
from transport.command.options import Json
from transport.results import Result
from transport.results.estimates import Estimate

File = Annotated[Path, typer.Argument(metavar="FILE", help="A run that was saved, .nc or .npz.")]
Files = Annotated[list[Path], typer.Argument(metavar="FILE...", help="Runs that were saved.")]


def show(file: File, json: Json = False) -> None:
    """Print what a saved run found out, what it cost, and who did it.

    \b
    Examples:
      transport show run.nc
      transport show run.npz --json
    """
    from transport.saved import load

    _tell(load(file), json)


def merge(
    files: Files,
    out: Annotated[Path, typer.Option(metavar="FILE", help="Where the whole goes.")],
    json: Json = False,
) -> None:
    """Put runs of one scene together: parts of a run, or other seeds.

    \b
    Examples:
      transport merge part1.nc part2.nc --out whole.nc
    """
    from transport.saved import merge
    from transport.saved.record import checked_place

    checked_place("--out", out)
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
            f"done by: transport {origin.version} ({origin.sources}), {', '.join(origin.versions)}; {origin.machine}"
        )


def _record(result: Result) -> dict[str, object]:
    """The same for machines."""
    method = result.plan.method
    quantities = {
        f"{name}.{quantity}": estimate
        for name in result
        for quantity, estimate in getattr(result[name], "quantities", {}).items()
    }
    return {
        "particles": result.particles,
        "batches": len(result.batches),
        "seeds": sorted({batch.seed for batch in result.batches}),
        "method": {"estimator": method.estimator, "sampling": method.sampling},
        "complete": result.is_complete,
        "quantities": [
            {"name": name, "value": q.value, "error": q.error, "unit": str(q.unit)}
            for name, q in quantities.items()
            if isinstance(q, Estimate)
        ],
        "ledger": {
            name: {"value": entry.value, "error": entry.error, "unit": str(entry.unit)}
            for name, entry in result.ledger.items()
        },
        "warnings": result.warnings,
        "done by": [vars(origin) for origin in result.state.origins],
    }
