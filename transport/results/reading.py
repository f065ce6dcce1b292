"""The base class of all readings: quantities by name, and the error message for unknown names."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from transport.renderers import function_for
from transport.statistics.estimates import EstimateOrArray
from transport.statistics.findings import Finding
from transport.validation import SceneError, name_hint

Note = tuple[str, str]  # name of a diagnostic, and its text


def empty_note(dark: str | None, deep: str | None = None) -> Note | None:
    """The note about a detector that no light can reach, or that lies behind too much optical depth."""
    return ("enclosed detector", dark) if dark else ("optical depth", deep) if deep else None


class ReadingBase:
    """Base class of readings.

    Attributes
    ----------
    name : str
        Name of the detector.
    known : tuple of str
        Names of its quantities.
    title : str
        Kind of detector, in front of its name in messages.
    cannot_arrive : bool
        Whether geometry proves that no light arrives at its side.
    note : tuple of str or None
        Why it has no score, if known: (name of the diagnostic, text).
    is_blind : bool
        Whether it has no score.
    """

    name: str
    known: tuple[str, ...] = ()
    title = ""
    cannot_arrive = False
    note: Note | None = None
    is_blind = False

    def why_unscored(self) -> Iterable[Finding]:
        """Findings that explain why the detector has no score, if only chance may have missed it."""
        return ()

    def binned(self) -> Iterable[tuple[str, EstimateOrArray]]:
        """The quantities with bins, by name, in which findings about single bins are searched."""
        return ()

    @property
    def quantities(self) -> dict[str, EstimateOrArray]:
        """All quantities for which the detector has the options.

        Returns
        -------
        dict of str to Estimate or EstimateArray
        """
        found = {}
        for name in self.known:
            try:
                found[name] = getattr(self, name)
            except SceneError:
                continue
        return found

    def _repr_html_(self) -> str:
        return function_for(type(self), "html")(self)

    if not TYPE_CHECKING:  # type checkers would accept any name

        def __getattr__(self, name: str):
            if name.startswith("_"):
                raise AttributeError(name)
            raise AttributeError(f"{self.title}{self.name!r} has no quantity {name!r}; {self._cure(name)}")

    def _cure(self, name: str) -> str:
        return name_hint(name, self.known)
