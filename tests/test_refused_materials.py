"""Materials and surfaces that cannot be are refused when made, with object, parameter and value named."""

import math

import pytest

from tests.refusals import DISK, DRIFTING, SIGNED, assert_refused
from transport.geometry.shape import Cloud, Point
from transport.scene.detectors import Detector
from transport.scene.materials import Black, Diffuse, Mirror, Mixture, Surface

REFUSALS = {
    # materials and surfaces
    "albedo": (lambda: Diffuse(1.5), ["Diffuse: albedo must be in [0, 1], got 1.5"]),
    "albedo nan": (lambda: Diffuse(math.nan), ["Diffuse: albedo", "nan"]),
    "reflectance": (lambda: Mirror(-0.1), ["Mirror: reflectance", "[0, 1]", "-0.1"]),
    "surface shape": (lambda: Surface("floor", Black()), ["Surface: shape", "'floor'"]),
    "surface point": (
        lambda: Surface(Point(), Black(), name="p"),
        ["Surface 'p': shape", "Point", "sources only"],
    ),
    "material": (lambda: Surface(DISK, Black), ["Surface: material", "Black", "an instance"]),
    "name": (lambda: Surface(DISK, Black(), name=""), ["Surface: name", "not empty", "''"]),
    "name with a dot": (
        lambda: Detector(DISK, name="lid.in"),
        ["Detector 'lid.in': name", "'.'", "write name='lid_in'"],
    ),
    "surface's name with a dot": (
        lambda: Surface(DISK, Black(), name="a.b"),
        ["Surface 'a.b': name", "'a_b'"],
    ),
    "name number": (lambda: Detector(DISK, name=3), ["Detector: name", "text", "3"]),
    # materials
    "surface cloud": (lambda: Surface(Cloud(sigma=1), Black()), ["Surface: shape", "Cloud(", "sources only"]),
    "wall at rest": (lambda: Diffuse(1, speed=0), ["Diffuse: speed", "positive", "got 0"]),
    "wall drifts": (lambda: Diffuse(1, speed=DRIFTING), ["Diffuse: speed", "gas at rest", "drift"]),
    "wall backwards": (lambda: Diffuse(1, speed=SIGNED), ["Diffuse: speed", "negative", "SpeedTable"]),
    "wall speed by place": (lambda: Diffuse(1, 0, 5), ["Diffuse", "without a keyword", "speed=...", "got 5"]),
    "shares": (lambda: Mixture({Mirror(): 0.5}), ["Mixture: shares", "add up to 1", "0.5", "Black()"]),
    "share": (lambda: Mixture({Mirror(): -1, Black(): 2}), ["Mixture: the share of Mirror", "[0, 1]", "-1"]),
    "mixture of shares": (lambda: Mixture([1.0]), ["Mixture: parts", "with their shares", "[1.0]"]),
    "mixture of numbers": (lambda: Mixture({3: 1}), ["Mixture: parts", "Mirror()", "got 3"]),
    "mixture twice": (
        lambda: Mixture([(Black(), 0.5)] * 2),
        ["Mixture: parts", "differ", "add up their shares"],
    ),
    "mixture of mixtures": (
        lambda: Mixture({Mixture({Black(): 1}): 1}),
        ["Mixture: parts", "another Mixture", "list its parts"],
    ),
}


@pytest.mark.parametrize(("make", "words"), REFUSALS.values(), ids=REFUSALS)
def test_a_wrong_material_is_refused_with_object_parameter_value_and_cure(make, words):
    assert_refused(make, words)
