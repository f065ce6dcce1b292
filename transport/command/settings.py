"""What is said on the command line, as Python values: name=value, 1e7 particles, a relative error to reach."""

import ast
from collections.abc import Callable, Iterable

from transport.tracking import Tracking
from transport.validation import SceneError


def named_values(texts: Iterable[str]) -> dict[str, object]:
    """{"albedo": 0.3} from ["albedo=0.3"]; what is no number, tuple or the like is a text."""
    return _named("--set", texts, _literal)


def named_errors(texts: Iterable[str]) -> dict[str, float] | None:
    """{"meter.flux_in": 1e-3} from ["meter.flux_in=1e-3"], None where nothing was said."""
    return _named("--error", texts, lambda text: number("--error", text)) or None


def whole_number(option: str, text: str | None) -> int | None:
    """10000000 from "1e7" or "10_000_000".  Raises SceneError where a fraction would be left."""
    if text is None:
        return None
    value = number(option, text, "whole number such as 1e7")
    if not value.is_integer():
        raise SceneError(f"{option} must be a whole number such as 1e7, got {text!r}")
    return int(text) if text.replace("_", "").lstrip("+-").isdigit() else int(value)


def number(option: str, text: str, kind: str = "finite number such as 1e-3") -> float:
    """A finite number.  Raises SceneError for anything else."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if value - value != 0:
        raise SceneError(f"{option} must be a {kind}, got {text!r}")
    return value


def part_of(text: str | None) -> tuple[int, int] | None:
    """(2, 8) from "2/8".  Raises SceneError for anything else."""
    if text is None:
        return None
    one, slash, of = text.partition("/")
    if not (slash and one.strip().isdigit() and of.strip().isdigit()):
        raise SceneError(f"--part must be like 2/8, the second of eight parts, got {text!r}")
    return int(one), int(of)


def tracking_of(text: str | None) -> Tracking | str | None:
    """What `simulate` takes: "analog" or "weighted", or a Tracking from "forced" or "roulette=1e-8"."""
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
        return ast.literal_eval(_Unending().visit(ast.parse(text, mode="eval")))
    except (ValueError, SyntaxError):
        return text


class _Unending(ast.NodeTransformer):
    """Reads nan and inf as the numbers that they are, for which Python has no literals."""

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return ast.Constant(float(node.id)) if node.id in ("nan", "inf") else node
