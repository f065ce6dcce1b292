"""Monte Carlo transport of photons and gas particles: radiometric quantities with standard errors.

Use it as `import transport as tp`: build a `tp.Scene` of sources, surfaces and detectors, run
`tp.simulate(scene, ...)`, and read the quantities of `result["detector name"]`.
"""

import numpy

# ---- Raise ImportError if a user's own file or folder named numpy shadows NumPy.
#
# The package imports this module first, so that the message names the cause.

if not hasattr(numpy, "ndarray"):
    raise ImportError(
        f"{getattr(numpy, '__file__', None) or 'a folder called numpy'} shadows NumPy: rename it"
        " (and remove the __pycache__ beside it)"
    )

import sys
from pathlib import Path as _Path
from typing import TYPE_CHECKING

# ---- In a clone `viz` and `sims` lie beside this folder: a script there finds them too.

if not (_Path(__file__).parent / "viz").is_dir():
    __path__.append(str(_Path(__file__).parents[1]))

from transport.analysis.binning import bins_against_noise
from transport.analysis.cost import CostOfAccuracy, cost_of_accuracy
from transport.analysis.solid_angle import solid_angle
from transport.analysis.tracks import Tracks, tracks
from transport.analysis.view_factors import etendue, view_factor
from transport.geometry.flat import Disk, Plane, Rectangle, Slab, Triangle
from transport.geometry.mesh import Mesh, MeshWarning
from transport.geometry.polygon import Polygon
from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.shape import Cloud, Point
from transport.geometry.solid import Box, Sphere
from transport.io import load, merge
from transport.renderers import register
from transport.results.result import Result
from transport.scene.bins import Directions, Positions
from transport.scene.cameras import Camera, EnvironmentMap, LightField
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Effusive, Gas, Isotropic, Lambertian
from transport.scene.materials import (
    Black,
    Conductor,
    Dielectric,
    Diffuse,
    Glossy,
    Mirror,
    Mixture,
    Surface,
    ThinLens,
    Transparent,
    TwoSided,
)
from transport.scene.media import Grid, Medium, Vacuum
from transport.scene.phase_functions import HenyeyGreenstein, Rayleigh, Tabulated
from transport.scene.phase_space import PhaseSpace, Snapshot
from transport.scene.points import PointDetector
from transport.scene.pulses import BoxPulse, GaussianPulse, Instant
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.scene.speeds import InverseCDF, Maxwellian, SpeedTable
from transport.scene.tracking import Splitting, Tracking
from transport.scene.volumes import VolumeDetector
from transport.simulate import simulate
from transport.statistics.estimates import Estimate, EstimateArray
from transport.units import (
    Unit,
    UnitError,
    arcmin,
    arcsec,
    au,
    cm,
    deg,
    km,
    mm,
    mrad,
    nm,
    ns,
    speed_of_light,
    um,
    us,
)
from transport.validation import SceneError

__version__ = "0.1.0"

# What objects of lower layers need of higher ones, by name; loaded at the first use.
register(
    "html",
    {
        "Estimate": "transport.io.html.estimates:estimate_html",
        "EstimateArray": "transport.io.html.estimates:array_html",
        "Tally": "transport.io.html.estimates:reading_html",
        "SnapshotReading": "transport.io.html.estimates:sample_html",
        "Result": "transport.io.html.results:result_html",
        "Ledger": "transport.io.html.results:ledger_html",
        "Scene": "transport.io.html.scenes:scene_html",
    },
)
register(
    "plot",
    {
        "EstimateArray": "transport.viz.plots:plot_array",
        "Tally": "transport.viz.plots:plot_tally",
        "Scene": "transport.viz.sections:plot_section",
        "Result": "transport.viz.plots:plot_result",
    },
)
register("view", {"Scene": "transport.viz.page:view_scene"})
register("map", {"EstimateArray": "transport.viz.maps:plot_map"})
register("save", {"Result": "transport.io.runs:save"})
register("to_dataset", {"Tally": "transport.io.tables:to_dataset"})
register("to_json", {"Scene": "transport.io.json.documents:scene_text"})
register("from_json", {"Scene": "transport.io.json.documents:read_scene"})
register("simulate", {"Scene": "transport.simulate:simulate"})

__all__ = [
    "Beam", "Black", "Box", "BoxPulse", "Camera", "Cloud", "Conductor", "Cone", "CostOfAccuracy",
    "Cylinder", "Detector", "Dielectric", "Diffuse", "Directions", "Disk", "Effusive", "EnvironmentMap",
    "Estimate", "EstimateArray", "Gas", "GaussianPulse", "Glossy", "Grid", "HenyeyGreenstein", "Instant",
    "InverseCDF", "Isotropic", "Lambertian", "LightField", "Maxwellian", "Medium", "Mesh", "MeshWarning",
    "Mirror", "Mixture", "Paraboloid", "PhaseSpace", "Plane", "Point", "PointDetector", "Polygon",
    "Positions", "Rayleigh", "Rectangle", "Result", "Scene", "SceneError", "Slab", "Snapshot", "Source",
    "SpeedTable", "Sphere", "Splitting", "Surface", "Tabulated", "ThinLens", "Tracking", "Tracks",
    "Transparent", "Triangle", "TwoSided", "Unit", "UnitError", "Vacuum", "VolumeDetector", "arcmin",
    "arcsec", "au", "bins_against_noise", "cm", "cost_of_accuracy", "deg", "etendue", "km", "load",
    "merge", "mm", "mrad", "nm", "ns", "simulate", "solid_angle", "speed_of_light", "tracks", "um", "us",
    "view_factor",
]  # fmt: skip


class _FormerPackages:
    """Finder that says where the former packages `sims` and `viz` are, if nothing else has these names."""

    @staticmethod
    def find_spec(name: str, path: object = None, target: object = None) -> None:
        """Raise ModuleNotFoundError for a former package."""
        if name in ("sims", "viz"):
            raise ModuleNotFoundError(
                f"{name!r} is a part of transport now: import transport.{name}", name=name
            )


sys.meta_path.append(_FormerPackages)  # last, so that a package of the user's with such a name is found first


if not TYPE_CHECKING:  # type checkers would accept any name

    def __getattr__(name: str):
        """Raise AttributeError and suggest the closest public name, or to import a package of this name."""
        from importlib.util import find_spec

        from transport.validation import name_hint

        cure = "" if name.startswith("_") else f"; {name_hint(name, __all__)}"
        if cure and find_spec(f"transport.{name}") is not None:
            cure = f"; write import transport.{name}"
        raise AttributeError(f"module 'transport' has no attribute {name!r}{cure}")
