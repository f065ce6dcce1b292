"""Every wrong input is refused when the object is made, with object, parameter and value named."""

import math

import numpy as np
import pytest

from transport.detectors import Detector, Directions, Positions
from transport.materials import Black, Diffuse, Mirror, Mixture, Surface
from transport.phase_space import PhaseSpace, Snapshot
from transport.scene import Scene
from transport.shapes import Box, Cloud, Disk, Point, Rectangle, Sphere, Triangle
from transport.sources import (
    Beam,
    BoxPulse,
    Effusive,
    Gas,
    GaussianPulse,
    Instant,
    Isotropic,
    Lambertian,
    Source,
)
from transport.speeds import InverseCDF, Maxwellian, SpeedTable
from transport.validation import SceneError

DISK, BALL, CUBE = Disk(radius=1), Sphere(radius=2), Box(size=(1, 2, 3))
SHEET = Rectangle(width=2, height=4)
LAMP = Source(DISK, Lambertian(power=1))
GAS = Source(CUBE, Gas(1e20, 500))
WALL = Surface(DISK, Black(), name="floor")
EDGES, CORNERS = (0, 1, 2), [(0, 0, 0), (1, 0, 0), (0, 1, 0)]


def meter(**how):
    return Detector(DISK, name="lid", **how)


def cloud(**how):
    return PhaseSpace(**{"time": 1, "name": "cloud"} | how)


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
    # materials and surfaces
    "albedo": (lambda: Diffuse(1.5), ["Diffuse: albedo must be in [0, 1], got 1.5"]),
    "albedo nan": (lambda: Diffuse(math.nan), ["Diffuse: albedo", "nan"]),
    "reflectance": (lambda: Mirror(-0.1), ["Mirror: reflectance", "[0, 1]", "-0.1"]),
    "surface shape": (lambda: Surface("floor", Black()), ["Surface: shape", "'floor'"]),
    "surface point": (
        lambda: Surface(Point(), Black(), name="p"),
        ["Surface 'p': shape", "Point", "sources only"],
    ),
    "material": (lambda: Surface(DISK, Black), ["Surface: material", "Black", "brackets"]),
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
    # emissions
    "no amount": (lambda: Lambertian(), ["Lambertian", "exactly one of radiance, exitance, power", "none"]),
    "two amounts": (
        lambda: Isotropic(power=1, intensity=2),
        ["Isotropic", "exactly one", "power=1, intensity=2"],
    ),
    "zero radiance": (lambda: Lambertian(radiance=0), ["Lambertian: radiance", "positive", "got 0"]),
    "power": (lambda: Beam((0, 0, 1), power=-5), ["Beam: power", "positive", "-5"]),
    "direction": (lambda: Beam((0, 0, 0), power=5), ["Beam: direction", "not all zero", "(0, 0, 0)"]),
    "speed": (lambda: Isotropic(power=1, speed=0), ["Isotropic: speed", "positive", "got 0"]),
    "density": (lambda: Gas(-1, 500), ["Gas: density", "positive", "-1"]),
    "gas speed": (lambda: Gas(1, math.inf), ["Gas: speed", "finite", "inf"]),
    "gas direction": (lambda: Gas(1, 1, direction=(0, 0)), ["Gas: direction", "(0, 0)"]),
    # sources
    "source shape": (lambda: Source(3, Lambertian(power=1)), ["Source: shape", "got 3"]),
    "emission": (lambda: Source(DISK, Lambertian), ["Source: emission", "Lambertian(radiance=...)"]),
    "lambertian point": (
        lambda: Source(Point(), Lambertian(power=1)),
        ["Source", "Lambertian", "Point(", "Isotropic"],
    ),
    "isotropic disk": (
        lambda: Source(DISK, Isotropic(power=1)),
        ["Source", "Isotropic", "Disk(", "Lambertian"],
    ),
    "gas disk": (lambda: Source(DISK, Gas(1, 1)), ["Source", "Gas leaves from a Box", "Disk("]),
    "side": (
        lambda: Source(DISK, Lambertian(power=1), side="bak"),
        ["Source: side", "'bak'", "did you mean 'back'"],
    ),
    "side type": (lambda: Source(DISK, Lambertian(power=1), side=1), ["Source: side", "got 1"]),
    "inside flat": (
        lambda: Source(DISK, Lambertian(power=1), side="inside"),
        ["Source: side", "'inside'", "'back'"],
    ),
    "outside flat": (lambda: Source(DISK, Lambertian(power=1), side="outside"), ["Source: side", "'front'"]),
    "side of gas": (
        lambda: Source(CUBE, Gas(1, 1), side="back"),
        ["Source: side", "Gas", "'back'", "leave it out"],
    ),
    "side of point": (
        lambda: Source(Point(), Beam((0, 0, 1), power=1), side="back"),
        ["Source: side", "Point"],
    ),
    "aim type": (lambda: Source(DISK, Lambertian(power=1), aim="lid"), ["Source: aim", "a shape", "'lid'"]),
    "aim point": (lambda: Source(DISK, Lambertian(power=1), aim=Point()), ["Source: aim", "Point("]),
    "aim beam": (
        lambda: Source(DISK, Beam((0, 0, 1), power=1), aim=BALL),
        ["Source: aim", "Beam", "drop aim"],
    ),
    "aim gas": (lambda: Source(CUBE, Gas(1, 1), aim=BALL), ["Source: aim", "Gas", "drop aim"]),
    "beam irradiance": (
        lambda: Source(Point(), Beam((0, 0, 1), irradiance=7)),
        ["Source: irradiance", "7.0", "write power="],
    ),
    "beam inwards": (
        lambda: Source(DISK, Beam((0, 0, -1), power=1)),
        ["Source: direction", "-1.0", "side='back'"],
    ),
    "beam from back": (
        lambda: Source(DISK, Beam((0, 0, 1), power=1), side="back"),
        ["Source: direction", "(0.0, 0.0, 1.0)", "side='front'"],
    ),
    "beam along": (
        lambda: Source(DISK, Beam((1, 0, math.cos(math.pi / 2)), power=1)),
        ["Source: direction", "plane of the Disk", "(1.0, 0.0", "tilt"],
    ),
    "power overflows": (lambda: Source(BALL, Lambertian(radiance=1e308)), ["Source: power", "finite", "inf"]),
    # detectors
    "nameless": (lambda: Detector(DISK), ["Detector: name", "None", "name='meter'"]),
    "meter point": (lambda: Detector(Point(), name="lid"), ["Detector 'lid': shape", "Point("]),
    "meter inside flat": (
        lambda: Detector(DISK, name="lid", side="inside"),
        ["Detector 'lid': side", "'inside'"],
    ),
    "directions type": (
        lambda: Detector(DISK, name="lid", directions=8),
        ["Detector 'lid': directions", "got 8"],
    ),
    "positions type": (
        lambda: Detector(DISK, name="lid", positions=8),
        ["Detector 'lid': positions", "got 8"],
    ),
    "no directions": (lambda: Directions(), ["Directions", "mu, theta, phi", "none"]),
    "mu and theta": (lambda: Directions(mu=4, theta=2), ["Directions: mu and theta", "mu=4", "theta=2"]),
    "mu count": (lambda: Directions(mu=0), ["Directions: mu", "got 0"]),
    "mu many": (lambda: Directions(mu=10**12), ["Directions: mu", "1 000 000", "got 1000000000000"]),
    "mu float": (lambda: Directions(mu=8.0), ["Directions: mu", "got 8.0"]),
    "mu bool": (lambda: Directions(mu=True), ["Directions: mu", "True"]),
    "mu order": (lambda: Directions(mu=(0, 0.5, 0.5)), ["Directions: mu", "increasing", "(0, 0.5, 0.5)"]),
    "mu one edge": (lambda: Directions(mu=[0.5]), ["Directions: mu", "[0.5]"]),
    "mu nan": (lambda: Directions(mu=[0, math.nan]), ["Directions: mu", "nan"]),
    "mu range": (lambda: Directions(mu=(-0.5, 1)), ["Directions: mu", "[0.0, 1.0]", "(-0.5, 1.0)"]),
    "mu world range": (
        lambda: Directions(mu=(-2, 1), frame="world"),
        ["Directions: mu", "[-1.0, 1.0]", "-2.0"],
    ),
    "theta range": (lambda: Directions(theta=(0, 2)), ["Directions: theta", "2.0"]),
    "phi range": (lambda: Directions(phi=(-7, -1)), ["Directions: phi", "(-7.0, -1.0)"]),
    "phi over a turn": (
        lambda: Directions(phi=(-1, 0, 6)),
        ["Directions: phi", "one turn", "(-1.0, 0.0, 6.0)"],
    ),
    "bins in all": (
        lambda: Directions(mu=10_000, phi=np.linspace(0, 6, 2002)),
        [
            "Directions: mu x phi",
            "10000000",
            "got 20010000",
            "1.28 GB",
            "30.7 GB",
            "32 batches",
            "take fewer",
        ],
    ),
    "positions in all": (lambda: Positions(u=10_000, v=10_000), ["Positions: u x v", "got 100000000"]),
    "bins of a detector in all": (
        lambda: Detector(DISK, name="lid", directions=Directions(mu=4000), positions=Positions(u=10, v=1000)),
        ["Detector 'lid': u x v x mu", "got 40000000"],
    ),
    "vanishing bins": (lambda: Directions(mu=(0.5, 1, 1 + 4e-16)), ["Directions: mu", "vanish"]),
    "frame": (lambda: Directions(mu=1, frame="wold"), ["Directions: frame", "'wold'", "'world'"]),
    "half angle": (
        lambda: Directions.cone((0, 0, 1), 2),
        ["DirectionCone: half_angle", "(0, pi/2]", "got 2"],
    ),
    "half angle 0": (lambda: Directions.cone((0, 0, 1), 0), ["half_angle", "got 0"]),
    "cone without half angle": (
        lambda: Directions.cone((0, 0, 1)),
        ["half_angle missing", "write Directions.cone(half_angle=...)"],
    ),
    "cone unknown": (
        lambda: Directions.cone((0, 0, 1), halfangle=1),
        ["halfangle=1", "did you mean 'half_angle'?"],
    ),
    "cone too many": (lambda: Directions.cone((0, 0, 1), 1, 2), ["got 2", "write Directions.cone(axis=..."]),
    "cone axis": (lambda: Directions.cone((0, 0, 0), 1), ["DirectionCone: axis", "(0, 0, 0)"]),
    "no positions": (lambda: Positions(), ["Positions", "u, v", "none"]),
    "positions count": (lambda: Positions(u=-1), ["Positions: u", "got -1"]),
    "positions box": (lambda: Positions(u=2).edges(CUBE), ["Positions", "Box", "faces()"]),
    "positions point": (lambda: Positions(u=2).edges(Point()), ["Positions", "Point("]),
    "positions beyond": (
        lambda: Detector(SHEET, name="lid", positions=Positions(v=(0, 3))),
        ["Detector 'lid'", "Positions: v", "[-2.0, 2.0]", "(0.0, 3.0)"],
    ),
    "positions hole": (
        lambda: Positions(u=(0, 1)).edges(Disk(radius=1, inner_radius=0.5)),
        ["Positions: u", "[0.5, 1.0]", "(0.0, 1.0)"],
    ),
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
    # clocks, speeds and histories of detectors
    "meter cloud": (lambda: Detector(Cloud(sigma=1), name="lid"), ["Detector 'lid': shape", "Cloud("]),
    "times count": (lambda: meter(times=0), ["Detector 'lid': times", "a number of bins", "got 0"]),
    "times float": (lambda: meter(times=2.5), ["Detector 'lid': times", "got 2.5"]),
    "times order": (lambda: meter(times=(0, 2, 1)), ["Detector 'lid': times", "increasing", "(0, 2, 1)"]),
    "times before 0": (lambda: meter(times=(-1, 2)), ["Detector 'lid': times", "0 or above", "(-1, 2)"]),
    "times after the end": (
        lambda: Scene(LAMP, (), meter(times=(0, 3)), duration=2),
        ["Detector 'lid': times edges", "[0.0, 2.0]", "duration", "(0.0, 3.0)"],
    ),
    "times without a clock": (
        lambda: Scene(LAMP, (), meter(times=4)),
        ["Detector 'lid': times need a clock", "got 4", "Scene(..., duration=...)"],
    ),
    "speeds count": (lambda: meter(speeds=4), ["Detector 'lid': speeds", "edges", "got 4", "linspace"]),
    "speeds below 0": (lambda: meter(speeds=(-1, 1)), ["Detector 'lid': speeds", "0 or above", "(-1, 1)"]),
    "speeds infinite": (lambda: meter(speeds=(0, math.inf)), ["Detector 'lid': speeds", "finite", "inf"]),
    "via type": (lambda: meter(via=3), ["Detector 'lid': via", "name", "got 3", "via='pinhole'"]),
    "via empty": (lambda: meter(via=()), ["Detector 'lid': via", "got ()"]),
    "via blank": (lambda: meter(via=("a", " ")), ["Detector 'lid': via", "('a', ' ')"]),
    "via twice": (lambda: meter(via=("a", "a")), ["Detector 'lid': via", "once", "('a', 'a')"]),
    "via unknown": (
        lambda: Scene(LAMP, WALL, meter(via="flor")),
        ["Detector 'lid': via must name a detector or a surface", "got 'flor'", "did you mean 'floor'?"],
    ),
    "events type": (lambda: meter(events=1.0), ["Detector 'lid': events", "reflections", "got 1.0"]),
    "events bool": (lambda: meter(events=True), ["Detector 'lid': events", "True"]),
    "events below 0": (lambda: meter(events=-1), ["Detector 'lid': events", "got -1"]),
    "events order": (lambda: meter(events=(2, 1)), ["Detector 'lid': events", "(least, most)", "(2, 1)"]),
    "events three": (lambda: meter(events=(0, 1, 2)), ["Detector 'lid': events", "(0, 1, 2)", "math.inf"]),
    "events nan": (lambda: meter(events=(0, math.nan)), ["Detector 'lid': events", "nan"]),
    "moments": (lambda: meter(moments="all"), ["Detector 'lid': moments", "True or False", "'all'"]),
    # phase spaces and snapshots
    "phase space of nothing": (
        lambda: PhaseSpace(time=1),
        ["PhaseSpace 'phase_space': one or two of x, y, z, vx, vy, vz, speed, mu", "none", "x=edges"],
    ),
    "phase space of three": (
        lambda: PhaseSpace(x=EDGES, vx=EDGES, mu=4, time=1),
        ["PhaseSpace 'phase_space': one or two of", "got x, vx, mu", "each pair"],
    ),
    "phase space by place": (lambda: PhaseSpace(EDGES), ["PhaseSpace", "keywords only", "time=..."]),
    "phase space without time": (lambda: PhaseSpace(x=EDGES), ["PhaseSpace", "time missing"]),
    "x count": (lambda: cloud(x=8), ["PhaseSpace 'cloud': x", "edges", "got 8", "linspace"]),
    "x order": (lambda: cloud(x=(0, 2, 1)), ["PhaseSpace 'cloud': x", "increasing", "(0, 2, 1)"]),
    "x twice the same": (lambda: cloud(x=(0, 0)), ["PhaseSpace 'cloud': x", "increasing", "(0, 0)"]),
    "vx infinite": (lambda: cloud(vx=(-math.inf, 0)), ["PhaseSpace 'cloud': vx", "finite", "-inf"]),
    "speed below 0": (lambda: cloud(speed=(-1, 1)), ["PhaseSpace 'cloud': speed", "0 or above", "(-1, 1)"]),
    "cosine beyond 1": (lambda: cloud(mu=(0, 1.1)), ["PhaseSpace 'cloud': mu", "[-1.0, 1.0]", "1.1"]),
    "cosines none": (lambda: cloud(mu=0), ["PhaseSpace 'cloud': mu", "got 0"]),
    "bins in phase space": (
        lambda: cloud(x=range(10_001), vx=range(10_001)),
        ["PhaseSpace 'cloud': x x vx", "10000000", "got 100000000"],
    ),
    "time before 0": (lambda: PhaseSpace(x=EDGES, time=-1), ["PhaseSpace", "time", "0 or later", "got -1"]),
    "time nan": (lambda: PhaseSpace(x=EDGES, time=math.nan), ["PhaseSpace", "time", "nan"]),
    "time text": (lambda: PhaseSpace(x=EDGES, time="1"), ["PhaseSpace", "time", "'1'"]),
    "times none": (lambda: PhaseSpace(x=EDGES, time=()), ["PhaseSpace", "time", "got ()"]),
    "times falling": (lambda: PhaseSpace(x=EDGES, time=(1, 1)), ["PhaseSpace", "increasing", "(1, 1)"]),
    "within": (lambda: cloud(x=EDGES, within=BALL), ["PhaseSpace 'cloud': within", "Box", "Sphere("]),
    "moments of phase space": (lambda: cloud(x=EDGES, moments=1), ["PhaseSpace 'cloud': moments", "got 1"]),
    "nameless phase space": (lambda: PhaseSpace(x=EDGES, time=1, name=None), ["PhaseSpace", "name", "None"]),
    "name with a dot of a snapshot": (lambda: Snapshot(1, name="a.b"), ["Snapshot 'a.b'", "'a_b'"]),
    "snapshot of a series": (lambda: Snapshot((1, 2)), ["Snapshot 'snapshot': time", "(1, 2)", "of each"]),
    "snapshot before 0": (lambda: Snapshot(-1), ["Snapshot 'snapshot': time", "got -1"]),
    "snapshot without an end": (lambda: Snapshot(math.inf), ["Snapshot 'snapshot': time", "inf"]),
    "snapshot of none": (lambda: Snapshot(1, particles=0), ["Snapshot 'snapshot': particles", "got 0"]),
    "snapshot of half": (lambda: Snapshot(1, particles=0.5), ["particles", "whole", "got 0.5"]),
    "snapshot of too many": (lambda: Snapshot(1, particles=10**9), ["particles", "10000000", "1000000000"]),
    "look without a clock": (
        lambda: Scene(LAMP, detectors=Snapshot(1)),
        ["Snapshot 'snapshot': time needs a clock", "got 1.0", "Scene(..., duration=...)"],
    ),
    "look after the end": (
        lambda: Scene(LAMP, detectors=cloud(x=EDGES, time=(1, 3)), duration=2),
        ["PhaseSpace 'cloud': time", "duration of 2.0 s", "got 3.0", "look earlier"],
    ),
    "looks' names": (
        lambda: Scene(LAMP, (), [Snapshot(1), Snapshot(2)], duration=2),
        ["Scene: name", "unique", "2 Snapshots 'snapshot'", "name="],
    ),
    "names of unlike looks": (
        lambda: Scene(LAMP, (), [meter(), Snapshot(1, name="lid")], duration=2),
        ["Scene: name", "unique", "1 Detector and 1 Snapshot 'lid'"],
    ),
    "look named as a surface": (
        lambda: Scene(LAMP, WALL, Snapshot(1, name="floor"), duration=2),
        ["Snapshot 'floor': name", "surface", "rename"],
    ),
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
def test_wrong_input_is_refused_with_object_parameter_value_and_cure(make, words):
    with pytest.raises(SceneError) as caught:
        make()
    message = str(caught.value)
    assert [word for word in words if word not in message] == [], message


def test_a_refusal_is_a_value_error():
    assert issubclass(SceneError, ValueError)


WARM, DRIFTING = Maxwellian(temperature=300, mass=4.65e-26), Maxwellian(sigma=1, drift=(0, 0, 31))
SIGNED = SpeedTable((-1, 1), (1, 1))
INSTANT, FLASH = Instant(0.5), Isotropic(energy=1)

REFUSALS_OF_EMISSION = {
    # speeds
    "maxwellian of nothing": (
        lambda: Maxwellian(),
        ["Maxwellian", "temperature and mass, or sigma", "neither"],
    ),
    "maxwellian without mass": (
        lambda: Maxwellian(temperature=300),
        ["Maxwellian: mass", "300.0", "write mass="],
    ),
    "maxwellian cold": (
        lambda: Maxwellian(temperature=0, mass=1),
        ["Maxwellian: temperature", "positive", "got 0"],
    ),
    "maxwellian mass": (lambda: Maxwellian(sigma=1, mass=-1), ["Maxwellian: mass", "-1"]),
    "maxwellian sigma": (lambda: Maxwellian(sigma=math.nan), ["Maxwellian: sigma", "nan"]),
    "maxwellian drift": (lambda: Maxwellian(sigma=1, drift=(1, 2)), ["Maxwellian: drift", "(1, 2)"]),
    "maxwellian twice": (
        lambda: Maxwellian(temperature=300, mass=1e-26, sigma=5),
        ["Maxwellian: sigma", "643.5", "got 5", "leave it out"],
    ),
    "maxwellian too fast": (lambda: Maxwellian(sigma=1e308), ["Maxwellian", "sigma=1e+308", "unit"]),
    "maxwellian by place": (lambda: Maxwellian(300), ["Maxwellian", "keywords only", "300"]),
    "rate of a drift": (lambda: WARM.one_way_flux(1e5), ["Maxwellian: drift", "30 sigma", "100000 m/s"]),
    "quantile of a drift": (lambda: WARM.normal_quantile(0.5, -1e5), ["30 sigma", "-100000 m/s"]),
    "table's speeds": (
        lambda: SpeedTable((0, 1, 1), (1, 1, 1)),
        ["SpeedTable: speeds", "increasing", "1.0 after 1.0"],
    ),
    "table's speed": (lambda: SpeedTable((1,), (1,)), ["SpeedTable: speeds", "two finite numbers", "(1,)"]),
    "table's density": (
        lambda: SpeedTable((0, 1), (1, -1)),
        ["SpeedTable: density", "zero or positive", "-1.0"],
    ),
    "table's zeros": (
        lambda: SpeedTable((0, 1), (0, 0)),
        ["SpeedTable: density", "not all zero", "(0.0, 0.0)"],
    ),
    "table's lengths": (
        lambda: SpeedTable((0, 1), (1, 2, 3)),
        ["SpeedTable: density", "as many", "2, got 3"],
    ),
    "table's infinity": (lambda: SpeedTable((0, math.inf), (1, 1)), ["SpeedTable: speeds", "inf"]),
    "table's range": (
        lambda: SpeedTable((-1e308, 1e308), (1, 1)),
        ["SpeedTable: speeds", "finite range", "1e+308"],
    ),
    "quantile no function": (lambda: InverseCDF(3), ["InverseCDF: quantile", "function", "got 3"]),
    "quantile of one u": (
        lambda: InverseCDF(math.sqrt),
        ["InverseCDF: quantile", "array", "TypeError", "NumPy"],
    ),
    "quantile with if": (
        lambda: InverseCDF(lambda u: 1 if u < 0.5 else 2),
        ["InverseCDF: quantile", "ValueError"],
    ),
    "quantile constant": (lambda: InverseCDF(lambda u: 3.0), ["InverseCDF: quantile", "shape ()", "NumPy"]),
    "quantile complex": (lambda: InverseCDF(lambda u: u + 1j), ["InverseCDF: quantile", "complex128"]),
    "quantile infinite": (
        lambda: InverseCDF(lambda u: 1 / u),
        ["InverseCDF: quantile", "inf at u = 0.0", "2**-54"],
    ),
    "quantile falls": (lambda: InverseCDF(lambda u: 1 - u), ["InverseCDF: quantile", "not fall", "u = "]),
    "quantile zero": (lambda: InverseCDF(lambda u: 0 * u), ["InverseCDF: quantile", "Gas(speed=0)"]),
    # emissions
    "gas without speed": (lambda: Gas(1e20), ["Gas: speed missing", "Gas(speed=...)"]),
    "effusive without speed": (lambda: Effusive(number=1), ["Effusive: speed missing"]),
    "gas of nothing": (lambda: Gas(speed=1), ["Gas", "exactly one of density, number", "none"]),
    "gas twice": (lambda: Gas(1, 500, number=2), ["Gas", "exactly one", "density=1, number=2"]),
    "effusive twice": (lambda: Effusive(1, 5, exitance=2), ["exactly one of density, exitance, number"]),
    "effusive at rest": (lambda: Effusive(1, 0), ["Effusive: speed", "positive", "got 0"]),
    "effusive backwards": (lambda: Effusive(1, SIGNED), ["Effusive: speed", "negative", "SpeedTable"]),
    "gas backwards": (lambda: Gas(1, SIGNED), ["Gas: speed", "negative", "direction=..."]),
    "gas of negative speed": (lambda: Gas(1, -5), ["Gas: speed", "zero or positive", "-5"]),
    "gas of text": (lambda: Gas(1, "fast"), ["Gas: speed", "'fast'"]),
    "drift along": (lambda: Gas(1, DRIFTING, direction=(0, 0, 1)), ["Gas: direction", "drift", "Maxwellian"]),
    "two masses": (lambda: Gas(1, WARM, mass=1), ["Gas: mass", "4.65e-26", "got 1", "leave it out"]),
    "mass": (lambda: Effusive(1, 5, mass=0), ["Effusive: mass", "positive", "got 0"]),
    "light of many speeds": (
        lambda: Lambertian(power=1, speed=WARM),
        ["Lambertian: speed", "Maxwellian", "Effusive"],
    ),
    "beam of many speeds": (
        lambda: Beam((0, 0, 1), power=1, speed=SIGNED),
        ["Beam: speed", "SpeedTable", "Gas"],
    ),
    "energy and power": (
        lambda: Lambertian(power=1, energy=2),
        ["Lambertian", "exactly one", "power=1, energy=2"],
    ),
    "energy": (lambda: Isotropic(energy=-1), ["Isotropic: energy", "positive", "-1"]),
    # sources and pulses
    "density in a point": (lambda: Source(Point(), Gas(1, 1)), ["Source: density", "Point", "number="]),
    "density in a flat cloud": (
        lambda: Source(Cloud(sigma=(0, 1, 1)), Gas(1, 1)),
        ["Source: density", "Cloud", "number="],
    ),
    "cloud of light": (
        lambda: Source(Cloud(sigma=1), Isotropic(power=1)),
        ["Isotropic leaves from", "Cloud("],
    ),
    "effusive point": (lambda: Source(Point(), Effusive(1, 5)), ["Effusive leaves from", "Point(", "Gas"]),
    "drift on a ball": (
        lambda: Source(BALL, Effusive(1, DRIFTING)),
        ["Source: drift", "flat", "Sphere", "31.0"],
    ),
    "drift on a box": (lambda: Source(CUBE, Effusive(1, DRIFTING)), ["Source: drift", "flat", "Box"]),
    "drift too fast": (
        lambda: Source(DISK, Effusive(1, DRIFTING)),
        ["Maxwellian: drift", "30 sigma", "31 m/s"],
    ),
    "drift too fast away": (
        lambda: Source(DISK, Effusive(number=1, speed=DRIFTING), side="back"),
        ["Maxwellian: drift", "-31 m/s"],
    ),
    "triangle of gas": (
        lambda: Source(Triangle(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 0))), Gas(1, 1)),
        ["Source", "Gas leaves from a Box", "Triangle(", "enclose it in a Box"],
    ),
    "aim drift": (
        lambda: Source(DISK, Effusive(1, Maxwellian(sigma=1, drift=(1, 0, 0))), aim=BALL),
        ["Source: aim", "drift", "leave one of them out"],
    ),
    "aim cloud": (lambda: Source(DISK, Lambertian(power=1), aim=Cloud(sigma=1)), ["Source: aim", "Cloud("]),
    "pulse type": (
        lambda: Source(Point(), FLASH, pulse=0.5),
        ["Source: pulse", "a pulse such as", "got 0.5"],
    ),
    "pulse of a gas": (lambda: Source(CUBE, Gas(1, 1), pulse=INSTANT), ["Source: pulse", "Gas", "drop it"]),
    "power at an instant": (
        lambda: Source(Point(), Isotropic(power=5), pulse=INSTANT),
        ["Source: pulse Instant", "energy=...", "power=5.0", "BoxPulse"],
    ),
    "density at an instant": (
        lambda: Source(DISK, Effusive(1, 5), pulse=GaussianPulse(9, 1)),
        ["Source: pulse GaussianPulse", "number=...", "density=1.0"],
    ),
    "energy without clock": (
        lambda: Source(Point(), FLASH).check_clock(None),
        ["Scene: duration", "Isotropic(energy=...)", "None", "duration=..."],
    ),
    "number without clock": (
        lambda: Source(DISK, Effusive(number=1, speed=5)).check_clock(None),
        ["Scene: duration", "Effusive(number=...)"],
    ),
    "gas without clock": (lambda: GAS.check_clock(None), ["Scene: duration", "a Gas", "None"]),
    "pulse without clock": (
        lambda: Source(Point(), Isotropic(power=1), pulse=BoxPulse(0, 1)).check_clock(None),
        ["Scene: duration", "BoxPulse(", "None"],
    ),
    "pulse after the end": (
        lambda: Source(Point(), FLASH, pulse=INSTANT).check_clock(0.5),
        ["Source: pulse", "0.5 s", "Instant", "longer"],
    ),
    "pulse over the end": (
        lambda: Source(Point(), FLASH, pulse=BoxPulse(0, 1)).check_clock(0.75),
        ["Source: pulse", "0.75 s", "from 0 to 1 s"],
    ),
    "bell over the end": (
        lambda: Source(Point(), FLASH, pulse=GaussianPulse(1, 0.1)).check_clock(1.5),
        ["Source: pulse", "1.5 s", "to 1.85 s"],
    ),
    "instant": (lambda: Instant(-1), ["Instant: time", "zero or positive", "-1"]),
    "box pulse": (lambda: BoxPulse(2, 1), ["BoxPulse: stop", "after start=2.0", "got 1.0"]),
    "box pulse start": (lambda: BoxPulse(-1, 1), ["BoxPulse: start", "-1"]),
    "bell before 0": (
        lambda: GaussianPulse(1, 1),
        ["GaussianPulse: time", "8.5 sigma", "got 1.0", "time=8.5"],
    ),
    "bell sigma": (lambda: GaussianPulse(1, 0), ["GaussianPulse: sigma", "positive", "got 0"]),
    "cloud of no size": (lambda: Cloud(sigma=(0, 0, 0)), ["Cloud: sigma", "not all 0", "Point"]),
    "cloud of two": (lambda: Cloud(sigma=(1, 2)), ["Cloud: sigma", "one or three", "(1, 2)"]),
    "cloud sign": (lambda: Cloud(sigma=(1, -2, 1)), ["Cloud: sigma", "(1, -2, 1)"]),
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
        ["Mixture: parts", "differ", "add their shares"],
    ),
    "mixture of mixtures": (
        lambda: Mixture({Mixture({Black(): 1}): 1}),
        ["Mixture: parts", "another Mixture", "write its parts out"],
    ),
}


@pytest.mark.parametrize(("make", "words"), REFUSALS_OF_EMISSION.values(), ids=REFUSALS_OF_EMISSION)
def test_wrong_emission_is_refused_with_object_parameter_value_and_cure(make, words):
    with pytest.raises(SceneError) as caught:
        make()
    message = str(caught.value)
    assert [word for word in words if word not in message] == [], message
