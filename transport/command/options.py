"""What several commands take on the command line."""

from pathlib import Path
from typing import Annotated

import typer

Sim = Annotated[
    str,
    typer.Argument(
        metavar="SIM", help="An experiment's name, or the path of one: a .py file, or a scene's .json."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON for machines.")]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="A parameter of the scene; repeatable."),
]
Particles = Annotated[str | None, typer.Option(metavar="N", help="Histories of each case, such as 1e7.")]
Seed = Annotated[int, typer.Option(help="The same seed gives the same digits.")]
Batches = Annotated[
    str | None,
    typer.Option(
        metavar="N", help="Independent batches, no fewer than threads; 32 for most runs if not said."
    ),
]
Threads = Annotated[int | None, typer.Option(help="One a core where it is not said.")]
Save = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Save the run, in .nc or .npz; of several cases each by its number."),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Let --save take the place of other files.")]
Resume = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Go on with a saved run; limits count from its beginning.")
]
Checkpoint = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Save it while it runs; with the same --resume it may be started again and again.",
    ),
]
Cluster = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS", help="Of a Dask scheduler whose workers do it, or local: a process a thread."
    ),
]
Every = Annotated[str | None, typer.Option(metavar="S", help="Seconds between checkpoints; 60 if not said.")]
Part = Annotated[
    str | None,
    typer.Option(metavar="K/N", help="Only the k-th of n parts of the batches, for 'transport merge'."),
]
