"""Shapes that cannot be are refused when made, with object, parameter and value named."""

import math

import numpy as np
import pytest

from tests.refusals import CORNERS, assert_refused
from transport.geometry.flat import Disk, Rectangle, Triangle
from transport.geometry.shape import Point
from transport.geometry.solid import Box, Sphere

REFUSALS = {
    # shapes
    "radius": (lambda: Disk(radius=-1.0), ["Disk: radius must be positive and finite, got -1.0"]),
    "radius nan": (lambda: Sphere(radius=math.nan), ["Sphere: radius", "positive and finite", "nan"]),
    "radius bool": (lambda: Disk(radius=True), ["Disk: radius", "number", "True"]),
    "radius text": (lambda: Disk(radius="1"), ["Disk: radius", "number", "'1'"]),
    "radius complex": (lambda: Disk(radius=1j), ["Disk: radius", "1j"]),
    "radius array": (lambda: Disk(radius=np.ones(1)), ["Disk: radius", "[1.0]"]),
    "radius numpy": (lambda: Disk(radius=np.float32(-1)), ["Disk: radius", "got -1.0"]),
    "radius huge": (lambda: Disk(radius=10**400), ["Disk: radius", "finite", "1000"]),
    "inner radius": (
        lambda: Disk(radius=1, inner_radius=1),
        ["Disk: inner_radius", "below radius 1.0", "got 1.0"],
    ),
    "inner below 0": (
        lambda: Disk(radius=1, inner_radius=-2),
        ["Disk: inner_radius", "zero or positive", "-2"],
    ),
    "width": (lambda: Rectangle(width=0, height=1), ["Rectangle: width", "positive", "got 0"]),
    "height": (lambda: Rectangle(width=1, height=math.inf), ["Rectangle: height", "finite", "inf"]),
    "area vanishes": (lambda: Rectangle(width=1e-200, height=1e-200), ["Rectangle: area", "1e-200", "unit"]),
    "area overflows": (lambda: Sphere(radius=1e200), ["Sphere: area", "1e+200", "unit"]),
    "volume vanishes": (lambda: Box(size=1e-120), ["Box: volume", "1e-120", "unit"]),
    "bounds": (
        lambda: Rectangle(center=(1.7976931348623157e308, 0, 0), width=1e300, height=1),
        ["Rectangle: bounds", "finite", "inf", "move center"],
    ),
    "size": (lambda: Box(size=(1, 2)), ["Box: size", "one or three", "(1, 2)"]),
    "size sign": (lambda: Box(size=(1, -2, 1)), ["Box: size", "positive", "(1, -2, 1)"]),
    "size text": (lambda: Box(size="123"), ["Box: size", "'123'"]),
    "center": (lambda: Disk(radius=1, center=(0, 0)), ["Disk: center", "three finite numbers", "(0, 0)"]),
    "center nan": (lambda: Box(size=1, center=[0, 0, math.nan]), ["Box: center", "finite", "nan"]),
    "center text": (lambda: Sphere(radius=1, center="abc"), ["Sphere: center", "'abc'"]),
    "center matrix": (lambda: Sphere(radius=1, center=np.eye(3)), ["Sphere: center", "[[1.0"]),
    "position": (lambda: Point(position=(1, 2, None)), ["Point: position", "None"]),
    "position bool": (lambda: Point(position=(True, 0, 0)), ["Point: position", "True"]),
    "normal": (lambda: Disk(radius=1, normal=(0, 0, 0)), ["Disk: normal", "not all zero", "(0, 0, 0)"]),
    "axis": (lambda: Sphere(radius=1, axis=(0, 0, math.inf)), ["Sphere: axis", "finite", "inf"]),
    "up": (lambda: Disk(radius=1, up=(0, 0, -3)), ["Disk: up", "parallel to normal", "(0, 0, -3)"]),
    "up zero": (lambda: Rectangle(width=1, height=1, up=(0, 0, 0)), ["Rectangle: up", "(0, 0, 0)"]),
    # triangles
    "triangle by place": (lambda: Triangle(CORNERS), ["Triangle", "keywords only", "vertices=..."]),
    "two vertices": (lambda: Triangle(vertices=CORNERS[:2]), ["Triangle: vertices", "three points"]),
    "flat vertices": (lambda: Triangle(vertices=((0, 0), (1, 0), (0, 1))), ["Triangle: vertices", "(0, 0)"]),
    "vertices text": (lambda: Triangle(vertices="abc"), ["Triangle: vertices", "'abc'"]),
    "vertices nan": (lambda: Triangle(vertices=(*CORNERS[:2], (0, 0, math.nan))), ["vertices", "nan"]),
    "vertices equal": (lambda: Triangle(vertices=CORNERS[:2] + CORNERS[:1]), ["must not lie on one line"]),
    "vertices tiny": (
        lambda: Triangle(vertices=1e-200 * np.array(CORNERS)),
        ["Triangle: area", "positive and finite", "1e-200", "unit"],
    ),
    "vertices huge": (
        lambda: Triangle(vertices=1e200 * np.array(CORNERS)),
        ["Triangle: area", "positive and finite", "1e+200", "unit"],
    ),
}


@pytest.mark.parametrize(("make", "words"), REFUSALS.values(), ids=REFUSALS)
def test_a_wrong_shape_is_refused_with_object_parameter_value_and_cure(make, words):
    assert_refused(make, words)
