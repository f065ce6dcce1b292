"""Shapes: where sources emit, surfaces act and detectors look. Lengths in metres, keywords only.

Every shape answers `area` [m^2] (a Point has none), `bounds` (lower and upper corner), `extent` (radius of
the ball round its `middle` that just holds it), `is_closed` and `is_infinite`; those with an axis have a `frame`.
"""

from transport.shapes.base import Shape
from transport.shapes.flat import Disk, FlatShape, Rectangle, Triangle
from transport.shapes.infinite import Plane, Slab
from transport.shapes.mesh import Mesh, MeshWarning
from transport.shapes.places import Cloud, Point
from transport.shapes.revolved import Cone, Cylinder, Paraboloid, Profile, Revolved
from transport.shapes.solid import Box, Sphere

__all__ = [
    "Box", "Cloud", "Cone", "Cylinder", "Disk", "FlatShape", "Mesh", "MeshWarning", "Paraboloid", "Plane",
    "Point", "Profile", "Rectangle", "Revolved", "Shape", "Slab", "Sphere", "Triangle",
]  # fmt: skip
