"""Hard cases: the result found, the exact value, and the value of the naive formula.

A family is a module of this package whose docstring is its title and whose cases are functions marked
by `case`:

    @case("the solid angle of a disk 1e9 radii away", naive="2π (1 - cos θ)")
    def far_disk() -> Seen:
        '''cos θ rounds to 1, and the difference is 0.'''
        ...
        return CaseResult(found, exact, naive=2 * math.pi * (1 - math.cos(1e-9)))

The function's docstring is the reason why the case is hard.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from transport.statistics.estimates import Estimate
from transport.validation import SceneError, name_hint

FALSE_ALARM = 1e-3  # probability that any case fails by chance


@dataclass(frozen=True)
class CaseResult:
    """Result of a case.

    Parameters
    ----------
    found : Estimate or float
        An Estimate, compared within its standard error, or a number, compared within `within`.
    exact : float
        Exact value.
    naive : float or None, default None
        Value of the naive formula; nan if it is not a number, None if the naive method has no result
        (it does not end, or its particle is lost).
    within : float, default 1e-12
        Allowed relative difference of a number; 0 requires equality.
    """

    found: Estimate | float
    exact: float
    naive: float | None = None
    within: float = 1e-12

    def holds(self, false_alarm: float) -> bool:
        """Return whether the result agrees with the exact value.

        Parameters
        ----------
        false_alarm : float
            Probability of rejecting a correct estimate, two-sided.

        Returns
        -------
        bool
            True if it agrees.
        """
        from scipy.special import ndtri

        limit = -ndtri(false_alarm / 2) if self.is_noisy else self.within
        return bool(abs(self.off) <= limit)

    @property
    def naive_fails(self) -> bool:
        """Whether the naive formula fails noticeably on this case."""
        if self.naive is None:
            return True
        allowed = 3 * self.found.error if self.is_noisy else self.within * (abs(self.exact) or 1.0)
        return not abs(self.naive - self.exact) <= allowed

    @property
    def value(self) -> float:
        """The result as a number."""
        return self.found.value if isinstance(self.found, Estimate) else self.found

    @property
    def off(self) -> float:
        """Deviation from the exact value: as a normal score if the error is known, else relative."""
        if self.is_noisy:
            return self.found.z(self.exact)
        return abs(self.value - self.exact) / (abs(self.exact) or 1.0)

    @property
    def is_noisy(self) -> bool:
        """Whether the result is an estimate with a standard error."""
        return isinstance(self.found, Estimate) and self.found.error > 0


@dataclass(frozen=True)
class Case:
    """A hard case.

    Parameters
    ----------
    family : str
        Name of its family (its module).
    title : str
        What is computed.
    naive : str
        The naive formula or method that fails.
    reason : str
        Why it fails.
    see : Callable[[], Seen]
        Function that runs the case.
    """

    family: str
    title: str
    naive: str
    reason: str
    run: Callable[[], CaseResult]


def case(title: str, naive: str) -> Callable:
    """Mark a function that returns Seen as a hard case; its docstring is the reason."""

    def marked(function: Callable[[], CaseResult]) -> Callable[[], CaseResult]:
        """Attach the Case to the function."""
        family = function.__module__.rpartition(".")[2]
        reason = " ".join((function.__doc__ or "").split())
        function.case = Case(family, title, naive, reason, function)
        return function

    return marked


def families() -> list[str]:
    """Names of all families, in alphabetical order."""
    from transport.verification import hard

    names = sorted(module.name for module in pkgutil.iter_modules(hard.__path__))
    return [name for name in names if name != "cases"]


def cases_of(chosen: list[str] | None = None) -> Iterator[Case]:
    """Yield the cases of some families, in the order of their files.

    Parameters
    ----------
    chosen : list of str or None, default None
        Names of families; None: all.

    Returns
    -------
    iterator of Case
        The cases.

    Raises
    ------
    SceneError
        If a family is unknown.
    """
    known = families()
    for name in chosen or known:
        if name not in known:
            raise SceneError(f"verify --hard: no family {name!r}; {name_hint(name, known)}")
        module = importlib.import_module(f"transport.verification.hard.{name}")
        yield from (value.case for value in vars(module).values() if isinstance(_case_of(value), Case))


def family_title(name: str) -> str:
    """Title of a family: the first line of its module's docstring."""
    return (
        (importlib.import_module(f"transport.verification.hard.{name}").__doc__ or name)
        .strip()
        .splitlines()[0]
    )


def _case_of(value: object) -> object:
    return getattr(value, "case", None) if callable(value) else None
