"""The type of `result["name"]` for type checkers.

The kind of detector decides it, and a name does not show the kind.
"""

# mypy: disable-error-code="misc, override"

from __future__ import annotations

from typing import Any

from transport.results.backward import BackwardReading, ViewReading
from transport.results.detectors import Reading
from transport.results.phase_space import PhaseReading, SnapshotReading
from transport.results.points import PointReading
from transport.results.volumes import VolumeReading


class AnyReading(
    BackwardReading, Reading, PhaseReading, VolumeReading, PointReading, ViewReading, SnapshotReading
):
    """Has the quantities of all readings and no others; never instantiated."""

    detector: Any
    by_source: dict[str, AnyReading]
