"""The kinds of objects that a scene is made of, by the names that they have in a file."""

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
    Beam, Black, Box, BoxPulse, Camera, Cloud, Cone, Cylinder, Detector, Dielectric, Diffuse, DirectionCone, DirectionSphere,
    Directions, Disk, Effusive, EnvironmentMap, Gas, GaussianPulse, Glossy, Grid, HenyeyGreenstein, Instant, Isotropic,
    Lambertian, Maxwellian, Medium, Mesh, Mirror, Mixture, Paraboloid, PhaseSpace, Plane, Point, PointDetector, Positions,
    Rayleigh, Rectangle, Scene, Slab, Snapshot, Source, SpeedTable, Sphere, Splitting, Surface, Tabulated, ThinLens,
    Tracking, Transparent, Triangle, TwoSided, Vacuum, VolumeDetector,
)  # fmt: skip
KINDS: dict[str, type] = {kind.__name__: kind for kind in _ALL}
UNWRITTEN = {  # kinds that no file holds: why, and what to write instead
    "InverseCDF": "holds a function of Python, which no file can; write SpeedTable(speeds=..., density=...) instead",
}
HEAVY = (Grid, Mesh, SpeedTable, Tabulated)  # written once where they are used more often


def fields_of(kind: type) -> list[dataclasses.Field]:
    """What an object of that kind is made of; without what is worked out of that."""
    return [field for field in dataclasses.fields(kind) if field.init]


@functools.cache
def arrays_of(kind: type) -> frozenset[str]:
    """The names of the fields that take an array."""
    hints = {name: typing.get_args(hint) or (hint,) for name, hint in typing.get_type_hints(kind).items()}
    names = {name for name, types in hints.items() if np.ndarray in types}
    return frozenset(names | ({"density"} if kind is Tabulated else set()))  # it becomes a function


def default_of(field: dataclasses.Field) -> object:
    """What the field is where nothing is said; MISSING where something must be said."""
    return field.default if field.default_factory is dataclasses.MISSING else field.default_factory()
