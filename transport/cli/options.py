"""Arguments and options that several commands share."""

import ast
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from transport.scene.tracking import Tracking
from transport.validation import SceneError

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
    typer.Option(metavar="FILE", help="Save the run as .nc or .npz; several cases get files FILE_1, ..."),
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


# ---- Parsers of command-line values: name=value, numbers such as 1e7, parts, tracking.


def named_values(texts: Iterable[str]) -> dict[str, object]:
    """Return {"albedo": 0.3} for ["albedo=0.3"]; a value that is no Python literal is a string."""
    return _named("--set", texts, _literal)


def swept(texts: Sequence[str], settings: Mapping[str, object]) -> tuple[str, list[object]]:
    """Return ("length", [1, 2, 4]) for ["length=[1,2,4]"].

    Raises SceneError for anything else, for several parameters, and for one that is set.
    """
    if len(texts) > 1:
        raise SceneError(f"--sweep takes one parameter, got {' and '.join(texts)}; run one after the other")
    (text,) = texts
    ((name, values),) = _named("--sweep", texts, _literal).items()
    if name in settings:
        raise SceneError(f"--sweep and --set both give {name}; leave out --set {name}={settings[name]!r}")
    if not isinstance(values, list | tuple) or len(values) < 2:
        raise SceneError(f"--sweep takes several values, such as --sweep {name}=[1,2,4], got {text!r}")
    for value in values:
        if not isinstance(value, int | float | str):
            raise SceneError(f"--sweep takes numbers or words, got {value!r} in {text!r}")
    return name, list(values)


def named_errors(texts: Iterable[str]) -> dict[str, float] | None:
    """Return {"meter.flux_in": 1e-3} for ["meter.flux_in=1e-3"], and None for no texts."""
    return _named("--error", texts, lambda text: number("--error", text)) or None


def whole_number(option: str, text: str | None) -> int | None:
    """Return 10000000 for "1e7" or "10_000_000".  Raises SceneError for a fraction."""
    if text is None:
        return None
    value = number(option, text, "whole number such as 1e7")
    if not value.is_integer():
        raise SceneError(f"{option} must be a whole number such as 1e7, got {text!r}")
    return int(text) if text.replace("_", "").lstrip("+-").isdigit() else int(value)


def number(option: str, text: str, kind: str = "finite number such as 1e-3") -> float:
    """Return a finite number.  Raises SceneError for anything else."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if value - value != 0:
        raise SceneError(f"{option} must be a {kind}, got {text!r}")
    return value


def parse_part(text: str | None) -> tuple[int, int] | None:
    """Return (2, 8) for "2/8".  Raises SceneError for anything else."""
    if text is None:
        return None
    one, slash, of = text.partition("/")
    if not (slash and one.strip().isdigit() and of.strip().isdigit()):
        raise SceneError(f"--part must be like 2/8 (part 2 of 8), got {text!r}")
    return int(one), int(of)


def parse_tracking(text: str | None) -> Tracking | str | None:
    """Return `simulate`'s argument: the text, or a Tracking for "forced" or "roulette=1e-8"."""
    if text == "forced":
        return Tracking(forced=True)
    name, equals, value = (text or "").partition("=")
    return Tracking(roulette=number("--tracking roulette=", value)) if equals and name == "roulette" else text


def _named(option: str, texts: Iterable[str], read: Callable[[str], object]) -> dict:
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip()
        if not equals or not name or not value.strip():
            raise SceneError(
                f"{option} must be name=value, got {text!r}; write {option} {name or 'name'}=1.0"
            )
        if name in found:
            raise SceneError(f"{option} is given twice for {name!r}, the second time as {value!r}; drop one")
        found[name] = read(value.strip())
    return found


def _literal(text: str) -> object:
    try:
        return ast.literal_eval(_Words().visit(ast.parse(text, mode="eval")))
    except (ValueError, SyntaxError):
        return text


class _Words(ast.NodeTransformer):
    """Reads nan and inf, for which Python has no literals, as numbers, and other words as they stand."""

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Return the number or the word as a literal."""
        return ast.Constant(float(node.id) if node.id in ("nan", "inf") else node.id)
