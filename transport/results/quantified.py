"""What the readings of all detectors share: their quantities by name, and a word on names that there are not."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from transport.renderers import function_for
from transport.results.estimates import EstimateOrArray
from transport.results.findings import Finding
from transport.validation import SceneError, suggestion

Note = tuple[str, str]  # the name of a diagnostic, and its words


def note_of(dark: str | None, deep: str | None = None) -> Note | None:
    """The note of a detector that no light can reach, or that lies too deep in media."""
    return ("enclosed detector", dark) if dark else ("optical depth", deep) if deep else None


class Quantified:
    """A reading with a `name` and the names of its quantities, `known`; not made itself."""

    name: str
    known: tuple[str, ...] = ()
    title = ""  # in front of its name, in messages
    cannot_arrive = False  # whether geometry proves that no light arrives at its side
    note: Note | None = None  # why it counted nothing, where that is known
    is_blind = False  # whether nothing was counted at all

    def why_unscored(self) -> Iterable[Finding]:
        """What is known of why it counted nothing, where chance alone may have missed it."""
        return ()

    def binned(self) -> Iterable[tuple[str, EstimateOrArray]]:
        """Its quantities with bins, by name, that findings about single bins are sought in."""
        return ()

    @property
    def quantities(self) -> dict[str, EstimateOrArray]:
        """All quantities that it was set up for."""
        found = {}
        for name in self.known:
            try:
                found[name] = getattr(self, name)
            except SceneError:
                continue
        return found

    def _repr_html_(self) -> str:
        return function_for(type(self), "html")(self)

    if not TYPE_CHECKING:  # to type checkers it would give every name a meaning

        def __getattr__(self, name: str):
            if name.startswith("_"):
                raise AttributeError(name)
            raise AttributeError(f"{self.title}{self.name!r} has no quantity {name!r}; {self._cure(name)}")

    def _cure(self, name: str) -> str:
        return suggestion(name, self.known)
