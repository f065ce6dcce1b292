"""A file of a scene as an experiment without a law: run, seen and priced as those of Python are."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

from transport.results import Result
from transport.results.estimates import Estimate, EstimateArray
from transport.written.documents import document_of


def experiment_of_file(path: str) -> ModuleType:
    """The experiment whose scene is that of a JSON file; what it measures are all numbers of all detectors.

    Raises SceneError for what is no scene, with its place in the file.
    """
    document, module = document_of(Path(path)), ModuleType(Path(path).stem)
    module.__file__ = path
    module.scene, module.about = lambda: document.scene, document.about
    module.measure, module.in_bins = numbers_of, bins_of
    return module


def numbers_of(result: Result) -> dict[str, Estimate]:
    """What each detector measures as a whole: {"meter.irradiance": Estimate}."""
    return {name: quantity for name, quantity in _quantities(result) if isinstance(quantity, Estimate)}


def bins_of(result: Result) -> dict[str, EstimateArray]:
    """What each detector measures in bins: {"meter.radiance": EstimateArray}."""
    return {name: quantity for name, quantity in _quantities(result) if isinstance(quantity, EstimateArray)}


def _quantities(result: Result) -> Iterator[tuple[str, Estimate | EstimateArray]]:
    for detector in result.scene.detectors:
        for name, quantity in result[detector.name].quantities.items():
            yield f"{detector.name}.{name}", quantity
