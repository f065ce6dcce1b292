"""The types of objects in a scene, by their names in a file."""

import dataclasses
import functools
import typing

import numpy as np

from transport.bins import DirectionCone, Directions, DirectionSphere, Positions
from transport.cameras import Camera, EnvironmentMap
from transport.detectors import Detector
from transport.emissions import Beam, Effusive, Gas, Isotropic, Lambertian
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
from transport.pulses import BoxPulse, GaussianPulse, Instant
from transport.scene import Scene
from transport.shapes import (
    Box,
    Cloud,
    Cone,
    Cylinder,
    Disk,
    Mesh,
    Paraboloid,
    Plane,
    Point,
    Rectangle,
    Slab,
    Sphere,
    Triangle,
)
from transport.sources import Source
from transport.speeds import Maxwellian, SpeedTable
from transport.tracking import Splitting, Tracking
from transport.volumes import VolumeDetector

_ALL = (
    Beam, Black, Box, BoxPulse, Camera, Cloud, Cone, Cylinder, Detector, Dielectric, Diffuse, DirectionCone,
    DirectionSphere, Directions, Disk, Effusive, EnvironmentMap, Gas, GaussianPulse, Glossy, Grid,
    HenyeyGreenstein, Instant, Isotropic, Lambertian, Maxwellian, Medium, Mesh, Mirror, Mixture, Paraboloid,
    PhaseSpace, Plane, Point, PointDetector, Positions, Rayleigh, Rectangle, Scene, Slab, Snapshot, Source,
    SpeedTable, Sphere, Splitting, Surface, Tabulated, ThinLens, Tracking, Transparent, Triangle, TwoSided,
    Vacuum, VolumeDetector,
)  # fmt: skip
KINDS: dict[str, type] = {kind.__name__: kind for kind in _ALL}
UNWRITTEN = {  # types that no file can hold: the reason, and what to write instead
    "InverseCDF": "holds a Python function, which no file can store;"
    " write SpeedTable(speeds=..., density=...) instead",
}
HEAVY = (Grid, Mesh, SpeedTable, Tabulated)  # written once if used several times


def fields_of(kind: type) -> list[dataclasses.Field]:
    """Return the init fields of a type, without derived attributes."""
    return [field for field in dataclasses.fields(kind) if field.init]


@functools.cache
def arrays_of(kind: type) -> frozenset[str]:
    """Return the names of the fields that take an array."""
    hints = {name: typing.get_args(hint) or (hint,) for name, hint in typing.get_type_hints(kind).items()}
    names = {name for name, types in hints.items() if np.ndarray in types}
    return frozenset(names | ({"density"} if kind is Tabulated else set()))  # stored as a function


def default_of(field: dataclasses.Field) -> object:
    """Return the default of a field; MISSING for a required field."""
    return field.default if field.default_factory is dataclasses.MISSING else field.default_factory()
