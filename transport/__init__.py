"""Monte Carlo transport of photons and gas particles: radiometric quantities with standard errors.

Use it as `import transport as tp`: build a `tp.Scene` of sources, surfaces and detectors, run
`tp.simulate(scene, ...)`, and read the quantities of `result["detector name"]`.
"""

from typing import TYPE_CHECKING

from transport import namesakes  # noqa: F401  must be imported first
from transport.cameras import Camera, EnvironmentMap
from transport.counting import solid_angle
from transport.detectors import Detector, Directions, Positions
from transport.emissions import Beam, Effusive, Gas, Isotropic, Lambertian
from transport.exchange import etendue, view_factor
from transport.materials import (
    Black,
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
from transport.media import Grid, HenyeyGreenstein, Medium, Rayleigh, Tabulated, Vacuum
from transport.phase_space import PhaseSpace, Snapshot
from transport.points import PointDetector
from transport.pricing.cost import CostOfAccuracy, cost_of_accuracy
from transport.pricing.discretisation import bins_against_noise
from transport.pulses import BoxPulse, GaussianPulse, Instant
from transport.renderers import register
from transport.results import Result
from transport.results.estimates import Estimate, EstimateArray
from transport.saved import load, merge
from transport.scene import Scene
from transport.shapes import (
    Box,
    Cloud,
    Cone,
    Cylinder,
    Disk,
    Mesh,
    MeshWarning,
    Paraboloid,
    Plane,
    Point,
    Rectangle,
    Slab,
    Sphere,
    Triangle,
)
from transport.simulate import simulate
from transport.sources import Source
from transport.speeds import InverseCDF, Maxwellian, SpeedTable
from transport.tracking import Splitting, Tracking
from transport.tracks import Tracks, tracks
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
from transport.volumes import VolumeDetector

__version__ = "0.1.0"

# What objects of lower layers need of higher ones, by name; loaded at the first use.
register(
    "html",
    {
        "Estimate": "transport.html.estimates:estimate_html",
        "EstimateArray": "transport.html.estimates:array_html",
        "Quantified": "transport.html.readings:reading_html",
        "SnapshotReading": "transport.html.readings:sample_html",
        "Result": "transport.html.results:result_html",
        "Ledger": "transport.html.results:ledger_html",
        "Scene": "transport.html.scenes:scene_html",
    },
)
register("save", {"Result": "transport.saved.record:save"})
register("to_json", {"Scene": "transport.written.documents:scene_text"})
register("from_json", {"Scene": "transport.written.documents:scene_of"})
register("simulate", {"Scene": "transport.simulate:simulate"})

__all__ = [
    "Beam", "Black", "Box", "BoxPulse", "Camera", "Cloud", "Cone", "CostOfAccuracy", "Cylinder",
    "Detector", "Dielectric", "Diffuse", "Directions", "Disk", "Effusive", "EnvironmentMap", "Estimate",
    "EstimateArray", "Gas", "GaussianPulse", "Glossy", "Grid", "HenyeyGreenstein", "Instant",
    "InverseCDF", "Isotropic", "Lambertian", "Maxwellian", "Medium", "Mesh", "MeshWarning", "Mirror",
    "Mixture", "Paraboloid", "PhaseSpace", "Plane", "Point", "PointDetector", "Positions", "Rayleigh",
    "Rectangle", "Result", "Scene", "SceneError", "Slab", "Snapshot", "Source", "SpeedTable", "Sphere",
    "Splitting", "Surface", "Tabulated", "ThinLens", "Tracking", "Tracks", "Transparent", "Triangle",
    "TwoSided", "Unit", "UnitError", "Vacuum", "VolumeDetector", "arcmin", "arcsec", "au",
    "bins_against_noise", "cm", "cost_of_accuracy", "deg", "etendue", "km", "load", "merge", "mm", "mrad",
    "nm", "ns", "simulate", "solid_angle", "speed_of_light", "tracks", "um", "us", "view_factor",
]  # fmt: skip


if not TYPE_CHECKING:  # type checkers would accept any name

    def __getattr__(name: str):
        """Raise AttributeError and suggest the closest public name."""
        from transport.validation import suggestion

        cure = "" if name.startswith("_") else f"; {suggestion(name, __all__)}"
        raise AttributeError(f"module 'transport' has no attribute {name!r}{cure}")
