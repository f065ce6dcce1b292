"""A scene file as an experiment without a law, for the commands run, view, cost and effects."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

from transport.io.json.documents import read_document
from transport.results.result import Result
from transport.statistics.estimates import Estimate, EstimateArray


def experiment_of_file(path: str) -> ModuleType:
    """Return an experiment with the scene of a JSON file; it measures all quantities of all detectors.

    Raises SceneError with the place in the file if it is not a scene.
    """
    document, module = read_document(Path(path)), ModuleType(Path(path).stem)
    module.__file__ = path
    module.scene, module.about = lambda: document.scene, document.about
    module.measure, module.in_bins = scalar_quantities, binned_quantities
    return module


def scalar_quantities(result: Result) -> dict[str, Estimate]:
    """Return the scalar quantities of all detectors: {"meter.irradiance": Estimate}."""
    return {name: quantity for name, quantity in _quantities(result) if isinstance(quantity, Estimate)}


def binned_quantities(result: Result) -> dict[str, EstimateArray]:
    """Return the binned quantities of all detectors: {"meter.radiance": EstimateArray}."""
    return {name: quantity for name, quantity in _quantities(result) if isinstance(quantity, EstimateArray)}


def _quantities(result: Result) -> Iterator[tuple[str, Estimate | EstimateArray]]:
    for detector in result.scene.detectors:
        for name, quantity in result[detector.name].quantities.items():
            yield f"{detector.name}.{name}", quantity
