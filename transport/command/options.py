"""Arguments and options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

Sim = Annotated[
    str,
    typer.Argument(metavar="SIM", help="Name of an experiment, or path of a .py or scene .json file"),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of text")]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Set a parameter of the scene; repeatable"),
]
Particles = Annotated[str | None, typer.Option(metavar="N", help="Particles per case, such as 1e7")]
Seed = Annotated[int, typer.Option(help="Random seed; the same seed gives the same digits")]
Batches = Annotated[
    str | None,
    typer.Option(
        metavar="N",
        help="Number of independent batches, at least one per thread [default: 32 for most runs]",
    ),
]
Threads = Annotated[int | None, typer.Option(help="Number of threads [default: all cores]")]
Save = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Save the run as .nc or .npz; several cases get numbered files"),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Overwrite existing files")]
Resume = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Continue a saved run; limits count from its beginning"),
]
Checkpoint = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Save the run to this file while it runs; pass the same file to --resume to continue it",
    ),
]
Cluster = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Address of a Dask scheduler, or local: one worker process per thread",
    ),
]
Every = Annotated[str | None, typer.Option(metavar="S", help="Seconds between checkpoints [default: 60]")]
Part = Annotated[
    str | None,
    typer.Option(metavar="K/N", help="Run part k of n of the batches; join parts with 'transport merge'"),
]
