"""Pages of the reference: every public name on the page of its module, with its docstring."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import transport

UNITS = {  # SI units of the conversion factors, as in 650 * tp.nm
    name: unit
    for names, unit in (
        ("nm um mm cm km au", "m"),
        ("ns us", "s"),
        ("deg arcmin arcsec mrad", "rad"),
        ("speed_of_light", "m s^-1"),
    )
    for name in names.split()
}
READ = (
    "results.readings.Reading",
    "results.volume_readings.VolumeReading",
    "results.point_readings.PointReading",
    "results.phase_readings.PhaseReading",
    "results.phase_readings.SnapshotReading",
    "results.result.Ledger",
    "results.backward_readings.ViewReading",
    "results.result.Cost",
)


@dataclass
class Page:
    """A page of the reference: its title, the modules that it covers, and their public names."""

    file: str
    title: str
    modules: tuple[str, ...]
    also: tuple[str, ...] = ()  # classes that results return
    names: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The page as MyST Markdown for Sphinx."""
        entries = [*map(_entry, self.names), *(f".. autoclass:: transport.{name}" for name in self.also)]
        return f"# {self.title}\n\n```{{eval-rst}}\n{chr(10).join(entries)}\n```\n"


def pages() -> list[Page]:
    """Return the pages with all public names.  Raises LookupError for a name without a page."""
    found = [
        Page("scene", "Scenes and sources", ("scene", "sources", "emissions", "pulses", "validation")),
        Page("shapes", "Shapes", ("shapes",)),
        Page("materials", "Surfaces and materials", ("materials",)),
        Page("media", "Media", ("media", "tracking")),
        Page("speeds", "Speeds and phase space", ("speeds", "phase_space")),
        Page("detectors", "Detectors", ("detectors", "bins", "cameras", "volumes", "points")),
        Page("runs", "Runs", ("simulate", "tracks", "counting", "exchange")),
        Page("results", "Results", ("results",), READ),
        Page("cost", "What accuracy costs", ("pricing",)),
        Page("units", "Units", ("units",)),
        Page("files", "Saved runs", ("saved",)),
    ]
    for name in sorted(transport.__all__, key=str.lower):
        module = getattr(getattr(transport, name), "__module__", "transport.units")
        _page_of(module, name, found).names.append(name)
    return found


def _page_of(module: str, name: str, found: list[Page]) -> Page:
    for page in found:
        if module.removeprefix("transport.").split(".")[0] in page.modules:
            return page
    raise LookupError(f"transport.{name} of {module} has no page: add its module to one")


def _entry(name: str) -> str:
    value = getattr(transport, name)
    if isinstance(value, type):
        is_error = issubclass(value, BaseException)
        return f".. autoclass:: transport.{name}" + "\n   :no-inherited-members:" * is_error
    if callable(value):
        return f".. autofunction:: transport.{name}"
    return f".. py:data:: {name}\n   :value: {value!r} {UNITS[name]}"


def command_pages(group: Any) -> Iterator[tuple[str, str]]:
    """Yield the name of each command of a click group and the text of `transport NAME --help`."""
    for name, command in group.commands.items():
        context = command.make_context(name, [], parent=_root(group), resilient_parsing=True)
        yield name, command.get_help(context)


def _root(group):
    return group.make_context("transport", [], resilient_parsing=True)
