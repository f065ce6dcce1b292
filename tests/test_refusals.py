"""Every wrong input is refused when the object is made, with object, parameter and value named."""

import pytest

from tests.refusals import BALL, DISK, GAS, LAMP, WALL, assert_refused
from transport.geometry.flat import Disk, Rectangle
from transport.geometry.shape import Point
from transport.scene.bins import Directions, Positions
from transport.scene.detectors import Detector
from transport.scene.emissions import Beam, Isotropic, Lambertian
from transport.scene.materials import Black, Diffuse, Mirror
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.validation import SceneError

REFUSALS = {
    # names and places of parameters
    "unknown": (lambda: Disk(radus=1), ["Disk", "radus=1", "did you mean 'radius'"]),
    "unknown with name": (
        lambda: Detector(DISK, name="lid", sides=1),
        ["Detector 'lid'", "sides=1", "'side'"],
    ),
    "unknown, none near": (lambda: Disk(radius=1, q=2), ["Disk", "q=2", "'inner_radius'"]),
    "unknown, none at all": (lambda: Black(albedo=1), ["Black", "albedo=1"]),
    "synonym reflectance": (lambda: Diffuse(reflectance=0.5), ["reflectance=0.5", "did you mean 'albedo'?"]),
    "synonym albedo": (lambda: Mirror(albedo=0.5), ["albedo=0.5", "did you mean 'reflectance'?"]),
    "synonym center": (lambda: Point(center=(0, 0, 1)), ["center=(0, 0, 1)", "did you mean 'position'?"]),
    "synonym position": (lambda: Disk(radius=1, position=(0, 0, 1)), ["did you mean 'center'?"]),
    "synonym diameter": (lambda: Disk(diameter=2), ["diameter=2", "did you mean 'radius' (half of it)?"]),
    "what is no medium": (
        lambda: Scene([LAMP], medium=3),
        ["Scene: medium must be a medium", "Medium(absorption", "got 3"],
    ),
    "positional": (
        lambda: Disk((0, 0, 1)),
        ["Disk takes keywords only: write Disk(radius=...)", "(0, 0, 1)"],
    ),
    "positional sizes": (lambda: Rectangle(1, 2), ["write Rectangle(width=..., height=...)", "got 1"]),
    "positional point": (lambda: Point((0, 0, 1)), ["Point takes keywords only: write Point(position=...)"]),
    "positional radiance": (
        lambda: Lambertian(100.0),
        ["Lambertian", "keywords only", "radiance=...", "100.0"],
    ),
    "positional power": (lambda: Beam((0, 0, 1), 5.0), ["Beam", "direction", "write Beam(power=...)", "5.0"]),
    "positional bins": (
        lambda: Directions(8),
        ["Directions takes keywords only: write Directions(mu=...)", "8"],
    ),
    "too many": (lambda: Mirror(0.5, 0.25, 0.125), ["Mirror", "0.125", "Mirror(reflectance=..."]),
    "none wanted": (lambda: Black(1), ["Black", "got 1", "write Black()"]),
    "twice": (lambda: Diffuse(0.5, albedo=0.25), ["Diffuse", "albedo", "twice", "0.25"]),
    "missing": (lambda: Rectangle(width=1), ["Rectangle", "height missing", "height=..."]),
    "missing emission": (lambda: Source(DISK), ["Source", "emission missing"]),
    "missing sources": (lambda: Scene(), ["Scene", "sources missing"]),
    # scenes
    "no source": (lambda: Scene([]), ["Scene: sources", "at least one", "none"]),
    "detector as source": (
        lambda: Scene([Detector("floor")]),
        ["Scene: sources", "Source", "Detector(", "sources[0]"],
    ),
    "source as surface": (lambda: Scene(LAMP, LAMP), ["Scene: surfaces", "Source("]),
    "shape as detector": (lambda: Scene(LAMP, (), [DISK]), ["Scene: detectors", "Disk(", "detectors[0]"]),
    "text as sources": (lambda: Scene("lamp"), ["Scene: sources", "'lamp'"]),
    "duration": (lambda: Scene(LAMP, duration=-1), ["Scene: duration", "positive", "-1"]),
    "gas without duration": (lambda: Scene(GAS), ["Scene: duration", "Gas", "None", "duration=..."]),
    "mixed": (
        lambda: Scene([GAS, LAMP], duration=1),
        ["Scene: sources", "watts", "particles", "Gas, Lambertian"],
    ),
    "surfaces' names": (lambda: Scene(LAMP, [WALL, WALL]), ["Scene: name", "unique", "'floor'"]),
    "detectors' names": (
        lambda: Scene(LAMP, WALL, [Detector("floor"), Detector("floor", side="back")]),
        ["Scene: name", "unique", "2 Detectors 'floor'", "name="],
    ),
    "name of another": (
        lambda: Scene(LAMP, WALL, Detector(BALL, name="floor")),
        ["Detector 'floor': name", "surface", "rename"],
    ),
    "unknown surface": (
        lambda: Scene(LAMP, WALL, Detector("flor")),
        ["Detector 'flor': shape", "got 'flor'", "did you mean 'floor'"],
    ),
    "unknown surface of source": (
        lambda: Scene(Source("lid", Lambertian(power=1)), WALL),
        ["Source: shape", "got 'lid'", "'floor'"],
    ),
    "no such surface": (lambda: Scene(LAMP, WALL).surface("roof"), ["Scene: name", "got 'roof'", "'floor'"]),
    "resolved source": (
        lambda: Scene(Source("floor", Isotropic(power=1)), WALL),
        ["Source", "Isotropic", "Disk("],
    ),
    "resolved side": (
        lambda: Scene(LAMP, WALL, Detector("floor", side="inside")),
        ["Detector 'floor': side"],
    ),
    "resolved positions": (
        lambda: Scene(LAMP, WALL, Detector("floor", positions=Positions(u=(0, 2)))),
        ["Detector 'floor'", "Positions: u", "(0.0, 2.0)"],
    ),
}


@pytest.mark.parametrize(("make", "words"), REFUSALS.values(), ids=REFUSALS)
def test_wrong_input_is_refused_with_object_parameter_value_and_cure(make, words):
    assert_refused(make, words)


def test_a_refusal_is_a_value_error():
    assert issubclass(SceneError, ValueError)
