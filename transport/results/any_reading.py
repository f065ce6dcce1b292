"""The type of `result["name"]` for type checkers.

The kind of detector decides it, and a name does not show the kind.
"""

# mypy: disable-error-code="misc, override"

from __future__ import annotations

from typing import Any

from transport.results.backward_readings import BackwardReading, ViewReading
from transport.results.phase_readings import PhaseReading, SnapshotReading
from transport.results.point_readings import PointReading
from transport.results.readings import Reading
from transport.results.volume_readings import VolumeReading


class AnyReading(
    BackwardReading, Reading, PhaseReading, VolumeReading, PointReading, ViewReading, SnapshotReading
):
    """Has the quantities of all readings and no others; never instantiated."""

    detector: Any
    by_source: dict[str, AnyReading]
