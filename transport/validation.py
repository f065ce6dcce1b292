"""Wrong input is refused when an object is made, with the object, the parameter, the value and the cure.

A user object is a frozen, hashable dataclass made by `scene_object`; its `__post_init__` calls the `settle_*`
functions below, each of which reads fields, refuses what is wrong and stores the rest in plain form (floats
and tuples of them), so that lists, NumPy arrays and integers give the same object.
"""

import dataclasses
import difflib
import functools
import math
import reprlib
from collections.abc import Iterable
from numbers import Integral, Real
from typing import Any, NoReturn, dataclass_transform

import numpy as np

from transport.vectors import unit_vector

_SYNONYMS = {  # what other programs call a parameter: its name here, and what else to know
    "reflectance": ("albedo", ""),
    "albedo": ("reflectance", ""),
    "center": ("position", ""),
    "position": ("center", ""),
    "diameter": ("radius", " (half of it)"),
}

SIMULATE = {  # what is said to `simulate`, not to the Scene
    "particles", "error", "seconds", "seed", "batches", "threads", "estimator", "sampling", "tracking",
    "progress", "cluster", "resume", "checkpoint", "every", "part",
}  # fmt: skip

UNMASK = "write .filled(0), or another number"  # the cure for masked values

_brief = reprlib.Repr()
_brief.maxstring = _brief.maxother = 80
_brief.maxlevel = 3


class SceneError(ValueError):
    """An input that is refused; the message names the object, the parameter, the value and the cure."""


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field,))
def scene_object(cls: type | None = None, *, kw_only: bool = False) -> Any:
    """A frozen dataclass that refuses wrong, missing and misplaced parameters with a SceneError."""
    if cls is None:
        return functools.partial(scene_object, kw_only=kw_only)
    made = dataclasses.dataclass(frozen=True, kw_only=kw_only)(cls)
    init, fields = made.__init__, [field for field in dataclasses.fields(made) if field.init]

    @functools.wraps(init)
    def checked_init(self, *values, **named):
        _check_parameters(made, fields, values, named)
        init(self, *values, **named)

    made.__init__ = checked_init
    return made


def _check_parameters(cls: type, fields: list[dataclasses.Field], values: tuple, named: dict) -> None:
    title, names = _title(cls, named.get("name")), [field.name for field in fields]
    call = getattr(cls, "written", cls.__name__)
    for name, value in named.items():
        if name not in names:
            is_for_run = name in SIMULATE and cls.__name__ == "Scene"
            cure = f"write simulate(scene, {name}=...)" if is_for_run else _suggested_parameter(name, names)
            raise SceneError(f"{title}: unknown parameter {name}={shown(value)}; {cure}")
    by_place = [field.name for field in fields if not field.kw_only]
    if len(values) > len(by_place):
        got = shown(values[len(by_place)])
        if len(by_place) == len(names):
            cure = ", ".join(f"{name}=..." for name in names)
            raise SceneError(
                f"{title} takes no more than {len(names)} parameters, got {got}; write {call}({cure})"
            )
        limit = f"only {' and '.join(by_place)} without a keyword" if by_place else "keywords only"
        keywords = [name for name in names if name not in by_place]
        required = [f.name for f in fields if f.name in keywords and _is_required(f)]
        cure = f"write {call}({', '.join(f'{name}=...' for name in required or keywords[:1])})"
        raise SceneError(f"{title} takes {limit}: {cure}, got {got} (keywords: {', '.join(keywords)})")
    for name in by_place[: len(values)]:
        if name in named:
            raise SceneError(
                f"{title}: {name} is given twice, the second time as {shown(named[name])}; drop one"
            )
    given = {*by_place[: len(values)], *named}
    missing = [f.name for f in fields if f.name not in given and _is_required(f)]
    if missing:
        cure = ", ".join(f"{name}=..." for name in missing)
        raise SceneError(f"{title}: {' and '.join(missing)} missing; write {call}({cure})")


def _is_required(field: dataclasses.Field) -> bool:
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def _title(cls: type, name: object) -> str:
    return f"{cls.__name__} {name!r}" if isinstance(name, str) and name else cls.__name__


def refuse(subject: object, problem: str) -> NoReturn:
    """Raise the SceneError "Detector 'lid': problem"."""
    raise SceneError(f"{_title(type(subject), getattr(subject, 'name', None))}: {problem}")


def shown(value: object) -> str:
    """The value as an error message shows it: plain numbers for NumPy's, long ones cut."""
    if is_masked(value):
        return f"{_brief.repr(value.tolist())} with masked values ({UNMASK})"
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    return _brief.repr(value)


def in_degrees(angle: float | None) -> str:
    """The cure for an angle [rad] that looks like degrees, as the end of a message; nothing for another."""
    return (
        f"; angles are in radians: write {angle:g} * tp.deg" if angle is not None and 1 < angle <= 360 else ""
    )


def is_masked(value: object) -> bool:
    """Whether an array has masked values, as files with gaps give: what lies under the mask is no number."""
    return isinstance(value, np.ma.MaskedArray) and bool(np.ma.getmaskarray(value).any())


def listed(names: list[str], most: int = 6) -> str:
    """The names as "a, b and c"; of more than `most` the others are counted."""
    if len(names) > most:
        names = [*names[:most], f"{len(names) - most} more"]
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


def suggestion(word: object, names: Iterable[str]) -> str:
    """The cure for an unknown name: the nearest valid one, or all of them where none is near."""
    names = list(names)
    near = difflib.get_close_matches(str(word), names, n=1, cutoff=0.5)
    if near:
        return f"did you mean {near[0]!r}?"
    return f"choose from {', '.join(map(repr, names))}" if names else "there is none to choose from"


def _suggested_parameter(word: str, names: list[str]) -> str:
    """As `suggestion`, and by another name that the parameter goes by."""
    meant, aside = _SYNONYMS.get(word, (None, ""))
    return f"did you mean {meant!r}{aside}?" if meant in names else suggestion(word, names)


def store(subject: object, **values: object) -> None:
    """Set fields of a frozen object while it is being made."""
    for name, value in values.items():
        object.__setattr__(subject, name, value)


def as_float(value: object) -> float | None:
    """A real number as a float (infinite where it overflows), None for anything else: bool, text, complex."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Real):
        return None
    try:
        return float(value) + 0.0  # -0.0 becomes 0.0
    except OverflowError:
        return math.inf


def is_count(value: object) -> bool:
    """Whether the value is an integer (bool is none)."""
    return isinstance(value, Integral) and not isinstance(value, (bool, np.bool_))


def as_floats(value: object) -> tuple[float, ...] | None:
    """A sequence of finite real numbers as a tuple of floats, None for anything else."""
    if isinstance(value, (str, bytes, dict, set, frozenset)) or not isinstance(value, Iterable):
        return None
    if isinstance(value, np.ndarray) and value.ndim != 1:
        return None
    numbers = tuple(as_float(item) for item in value)
    return numbers if all(number is not None and math.isfinite(number) for number in numbers) else None


def settle_positive(subject: object, *names: str) -> None:
    """Each field is a positive finite number."""
    _settle_numbers(subject, names, "positive and finite", lambda number: 0 < number < math.inf)


def settle_nonnegative(subject: object, *names: str) -> None:
    """Each field is a finite number, zero or above."""
    _settle_numbers(subject, names, "zero or positive, and finite", lambda number: 0 <= number < math.inf)


def settle_fraction(subject: object, *names: str) -> None:
    """Each field is a number in [0, 1]."""
    _settle_numbers(
        subject, names, "in [0, 1]", lambda number: 0 <= number <= 1, "; a share, of which 1 is all"
    )


def _settle_numbers(subject, names, must, is_right, cure="") -> None:
    for name in names:
        value = getattr(subject, name)
        number = as_float(value)
        if number is None:
            refuse(subject, f"{name} must be a number, {must}, got {shown(value)}")
        if not is_right(number):
            refuse(subject, f"{name} must be {must}, got {shown(value)}{cure}")
        store(subject, **{name: number})


def settle_vector(subject: object, *names: str) -> None:
    """Each field is a vector of three finite numbers."""
    for name in names:
        value = getattr(subject, name)
        vector = as_floats(value)
        if vector is None or len(vector) != 3:
            refuse(subject, f"{name} must be three finite numbers, got {shown(value)}")
        store(subject, **{name: vector})


def settle_direction(subject: object, *names: str) -> None:
    """Each field is a vector of any length but zero; its unit vector is stored."""
    for name in names:
        value = getattr(subject, name)
        vector = as_floats(value)
        if vector is None or len(vector) != 3 or not any(vector):
            refuse(subject, f"{name} must be three finite numbers, not all zero, got {shown(value)}")
        store(subject, **{name: unit_vector(vector)})


def settle_name(subject: object) -> None:
    """The field `name` is a text that is not empty and has no ".", or None."""
    name = subject.name
    if name is not None and (not isinstance(name, str) or not name.strip()):
        refuse(subject, f"name must be a text that is not empty, got {shown(name)}")
    if name is not None and "." in name:
        cure = f"write name={name.replace('.', '_')!r}"
        refuse(subject, f"name must not contain '.', as in 'meter.flux_in', got {shown(name)}; {cure}")
    store(subject, name=None if name is None else str(name))


def check_one_of(subject: object, name: str, choices: Iterable[str]) -> None:
    """The field is one of the texts."""
    value, choices = getattr(subject, name), list(choices)
    if not isinstance(value, str) or value not in choices:
        valid = " or ".join(map(repr, choices))
        refuse(subject, f"{name} must be {valid}, got {shown(value)}; {suggestion(value, choices)}")


def check_type(subject: object, name: str, types: type | tuple[type, ...], must: str) -> None:
    """The field is an instance of the types; `must` says which in words."""
    value = getattr(subject, name)
    if not isinstance(value, types):
        refuse(subject, f"{name} must be {must}, got {shown(value)}")
