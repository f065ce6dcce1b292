"""What several commands take on the command line."""

from typing import Annotated

import typer

Sim = Annotated[
    str, typer.Argument(metavar="SIM", help="An experiment's name, or the path of a .py file that is one.")
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON for machines.")]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="A parameter of the scene; repeatable."),
]
Particles = Annotated[str | None, typer.Option(metavar="N", help="Histories of each case, such as 1e7.")]
Seed = Annotated[int, typer.Option(help="The same seed gives the same digits.")]
Threads = Annotated[int | None, typer.Option(help="One a core where it is not said.")]
