"""The types of objects in a scene, by their names in a file."""

import dataclasses
import functools
import typing

import numpy as np

from transport.geometry.flat import Disk, Plane, Rectangle, Slab, Triangle
from transport.geometry.mesh import Mesh
from transport.geometry.polygon import Polygon
from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.shape import Cloud, Point
from transport.geometry.solid import Box, Sphere
from transport.scene.bins import DirectionCone, Directions, DirectionSphere, Positions
from transport.scene.cameras import Camera, EnvironmentMap
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Effusive, Gas, Isotropic, Lambertian
from transport.scene.materials import (
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
from transport.scene.media import Grid, Medium, Vacuum
from transport.scene.phase_functions import HenyeyGreenstein, Rayleigh, Tabulated
from transport.scene.phase_space import PhaseSpace, Snapshot
from transport.scene.points import PointDetector
from transport.scene.pulses import BoxPulse, GaussianPulse, Instant
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.scene.speeds import Maxwellian, SpeedTable
from transport.scene.tracking import Splitting, Tracking
from transport.scene.volumes import VolumeDetector
from transport.units import speed_of_light

_SCENE_TYPES = (
    Beam, Black, Box, BoxPulse, Camera, Cloud, Cone, Cylinder, Detector, Dielectric, Diffuse, DirectionCone,
    DirectionSphere, Directions, Disk, Effusive, EnvironmentMap, Gas, GaussianPulse, Glossy, Grid,
    HenyeyGreenstein, Instant, Isotropic, Lambertian, Maxwellian, Medium, Mesh, Mirror, Mixture, Paraboloid,
    PhaseSpace, Plane, Point, PointDetector, Polygon, Positions, Rayleigh, Rectangle, Scene, Slab, Snapshot,
    Source, SpeedTable, Sphere, Splitting, Surface, Tabulated, ThinLens, Tracking, Transparent, Triangle,
    TwoSided, Vacuum, VolumeDetector,
)  # fmt: skip
SCENE_TYPES: dict[str, type] = {kind.__name__: kind for kind in _SCENE_TYPES}
UNSUPPORTED = {  # types that no file can hold: the reason, and what to write instead
    "InverseCDF": "holds a Python function, which no file can store;"
    " write SpeedTable(speeds=..., density=...) instead",
}
SHARED_TYPES = (Grid, Mesh, SpeedTable, Tabulated)  # written once if used several times


def init_fields(kind: type) -> list[dataclasses.Field]:
    """Return the init fields of a type, without derived attributes."""
    return [field for field in dataclasses.fields(kind) if field.init]


@functools.cache
def array_fields(kind: type) -> frozenset[str]:
    """Return the names of the fields that take an array."""
    hints = {name: typing.get_args(hint) or (hint,) for name, hint in typing.get_type_hints(kind).items()}
    names = {name for name, types in hints.items() if np.ndarray in types}
    return frozenset(names | ({"density"} if kind is Tabulated else set()))  # stored as a function


def default_value(field: dataclasses.Field) -> object:
    """Return the default of a field; MISSING for a required field."""
    return field.default if field.default_factory is dataclasses.MISSING else field.default_factory()


# ---- Derived fields: they follow from an object's other fields, so a file omits them.


def derived_fields(part: object) -> tuple[str, ...]:
    """Return the names of the fields that have the same value if omitted."""
    match part:
        case Surface():
            return ("front", "back") if part.shape.is_closed else ("outside", "inside")
        case Maxwellian(temperature=float()):
            return ("sigma",)
        case Gas(speed=Maxwellian(mass=mass)) | Effusive(speed=Maxwellian(mass=mass)) if part.mass == mass:
            return ("mass",)
        case Detector() | VolumeDetector() if part.name == part.shape:
            return ("name",)
        case Beam() | Isotropic() | Lambertian() if part.speed == speed_of_light:
            return ("speed",)
    return ()
