"""Shapes of sources, surfaces and detectors. Lengths are in metres; all parameters are keyword-only.

Every shape has `area` [m^2] (except Point and Cloud), `bounds` (lower and upper corner), `extent` (radius of
a sphere around `middle` that holds the shape), `is_closed` and `is_infinite`. Shapes with an axis or a normal
have a `frame`.
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
