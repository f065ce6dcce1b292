"""What a hard case is: something found, what is exact, and what the naive formula gives instead.

A family is a module of this package with a docstring that names it, whose cases are functions marked by `case`:

    @case("the solid angle of a disk 1e9 radii away", naive="2π (1 - cos θ)")
    def far_disk() -> Seen:
        '''cos θ rounds to 1, and the difference is 0.'''
        ...
        return Seen(found, exact, naive=2 * math.pi * (1 - math.cos(1e-9)))

The function's docstring is the reason: why the case is hard.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from transport.results.estimates import Estimate
from transport.validation import SceneError, suggestion

FALSE_ALARM = 1e-3  # of all cases together, by chance


@dataclass(frozen=True)
class Seen:
    """What a case came to.

    found: an Estimate, judged by its error, or a number, judged by `within`;  exact: what it should be;  naive: what the
    naive formula gives, nan where that is no number, None where the naive way has no answer (it does not end, it is lost);
    within: relative difference allowed to a number, of rounding; 0 asks for the very number.
    """

    found: Estimate | float
    exact: float
    naive: float | None = None
    within: float = 1e-12

    def holds(self, false_alarm: float) -> bool:
        """Whether what was found agrees: an estimate two-sided at this rate of false alarms."""
        from scipy.special import ndtri

        limit = -ndtri(false_alarm / 2) if self.is_noisy else self.within
        return bool(abs(self.off) <= limit)

    @property
    def is_needed(self) -> bool:
        """Whether the naive formula fails where this does not: by as much as would be noticed."""
        if self.naive is None:
            return True
        allowed = 3 * self.found.error if self.is_noisy else self.within * (abs(self.exact) or 1.0)
        return not abs(self.naive - self.exact) <= allowed

    @property
    def value(self) -> float:
        """What was found, as a number."""
        return self.found.value if isinstance(self.found, Estimate) else self.found

    @property
    def off(self) -> float:
        """How far off: in standard errors as a normal score where these are known, else relative."""
        if self.is_noisy:
            return self.found.z(self.exact)
        return abs(self.value - self.exact) / (abs(self.exact) or 1.0)

    @property
    def is_noisy(self) -> bool:
        """Whether it is judged by its error."""
        return isinstance(self.found, Estimate) and self.found.error > 0


@dataclass(frozen=True)
class Case:
    """A hard case of a family.  naive: the formula, or way, that it breaks;  reason: why."""

    family: str
    title: str
    naive: str
    reason: str
    see: Callable[[], Seen]


def case(title: str, naive: str) -> Callable:
    """Mark a function that returns Seen as a hard case; its docstring is the reason."""

    def marked(function: Callable[[], Seen]) -> Callable[[], Seen]:
        family = function.__module__.rpartition(".")[2]
        reason = " ".join((function.__doc__ or "").split())
        function.case = Case(family, title, naive, reason, function)
        return function

    return marked


def families() -> list[str]:
    """Their names, in alphabetical order."""
    from transport import hard

    names = sorted(module.name for module in pkgutil.iter_modules(hard.__path__))
    return [name for name in names if name != "cases"]


def cases_of(chosen: list[str] | None = None) -> Iterator[Case]:
    """All cases of these families, or of all, in the order of their files.  Raises SceneError for one that is not known."""
    known = families()
    for name in chosen or known:
        if name not in known:
            raise SceneError(f"verify --hard: no family {name!r}; {suggestion(name, known)}")
        module = importlib.import_module(f"transport.hard.{name}")
        yield from (value.case for value in vars(module).values() if isinstance(_case(value), Case))


def family_title(name: str) -> str:
    """What a family is about: the first line of its file."""
    return (importlib.import_module(f"transport.hard.{name}").__doc__ or name).strip().splitlines()[0]


def _case(value: object) -> object:
    return getattr(value, "case", None) if callable(value) else None
