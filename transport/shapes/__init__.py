"""Shapes: where sources emit, surfaces act and detectors look. Lengths in metres, keywords only.

Every shape answers `area` [m^2] (a Point has none), `bounds` (lower and upper corner), `extent` (radius of
the ball round its `middle` that just holds it) and `is_closed`; those with an axis have a `frame`.
"""

from transport.shapes.base import Shape
from transport.shapes.flat import Disk, FlatShape, Rectangle, Triangle
from transport.shapes.places import Cloud, Point
from transport.shapes.solid import Box, Sphere

__all__ = ["Box", "Cloud", "Disk", "FlatShape", "Point", "Rectangle", "Shape", "Sphere", "Triangle"]
