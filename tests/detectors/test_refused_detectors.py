"""Every wrong detector, and every detector that an estimator cannot serve, is refused with object, parameter, value and cure."""

import math

import numpy as np
import pytest

import transport as tp
from tests.backward_scenes import fog as backward_fog
from tests.expected_scenes import WALLS, lamp, pane
from tests.refusals import BALL, CUBE, DISK, LAMP, WALL, assert_refused, meter

SHEET, EDGES, MESH = tp.Rectangle(width=2, height=4), (0, 1, 2), tp.Mesh.box(size=2)
TUBE, CONE = tp.Cylinder(radius=1, height=2), tp.Cone(radius=1, top_radius=0.25, height=2)
DISH, CAP = tp.Paraboloid(focal_length=0.5, radius=1, inner_radius=0.25), tp.Sphere(radius=2, mu_min=0.5)
FRAME = tp.Rectangle(width=2, height=1, hole=tp.Disk(center=(0.4, 0, 0), radius=0.25))
TRIANGLE = tp.Triangle(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)])
FOG = tp.Medium(absorption=0.1, scattering=0.9)
SHINING = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="back")
POINT = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
UP, FACING = tp.Disk(center=(0, 0, 1), radius=1), tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1)


def cloud(**how):
    return tp.PhaseSpace(**{"time": 1, "name": "cloud"} | how)


def volume(shape=CUBE, name="box", **how):
    return tp.VolumeDetector(shape, name, **how)


def collisions(*surfaces, tracking=None):
    scene = tp.Scene(SHINING, surfaces, volume(tp.Sphere(radius=0.8), estimator="collision"))
    return tp.simulate(scene, 1000, tracking=tracking, progress=False)


def body(shape, medium):
    return tp.Surface(shape, tp.Transparent(), "body", inside=medium)


def point(sources=POINT, place=(1, 0, 0), surfaces=(), tracking=None, **how):
    scene = tp.Scene(sources, surfaces, tp.PointDetector(place, "p"), **how)
    return tp.simulate(scene, 100, tracking=tracking, progress=False)


def behind(material):
    return point(surfaces=[tp.Surface(tp.Disk(center=(5, 0, 0), radius=1.0), material, name="glass")])


def camera(**how):
    said = {"name": "view", "position": (0, 0, 0), "direction": (1, 0, 0)}
    return tp.Camera(**said | {"field_of_view": 1.0, "pixels": (8, 6)} | how)


def expected(*detectors, **how):
    return tp.simulate(tp.Scene(lamp(), WALLS, detectors, **how), 100, estimator="expected")


def backward(*detectors, source=LAMP, surfaces=(), **how):
    return tp.simulate(
        tp.Scene(source, surfaces, detectors, **how), 1000, estimator="backward", progress=False
    )


def paths(media, estimator="analog"):
    """Mean paths in these media of light that passes a box of FOG."""
    far = tp.Detector(UP, "far", path_lengths=media)
    scene = tp.Scene(POINT, body(tp.Box(size=1), FOG), far)
    return tp.simulate(scene, 1000, estimator=estimator, progress=False)["far"].mean_path_in


def factor(a=DISK, b=FACING, blockers=(), **how):
    return tp.view_factor(a, b, blockers, **how)


# Words that the message must hold: the call that is refused.
DETECTORS = {
    "Detector: name ... None ... name='detector'": lambda: tp.Detector(DISK),
    "Detector 'lid': shape ... Point(": lambda: tp.Detector(tp.Point(), name="lid"),
    "Detector 'lid': side ... 'inside'": lambda: meter(side="inside"),
    "Detector 'lid': directions ... got 8": lambda: meter(directions=8),
    "Detector 'lid': positions ... got 8": lambda: meter(positions=8),
    "Detector 'lid': u x v x mu ... got 40000000": lambda: meter(directions=tp.Directions(mu=4000), positions=tp.Positions(u=10, v=1000)),
    "Detector 'lid' ... Positions: v ... [-2.0, 2.0] ... (0.0, 3.0)": lambda: tp.Detector(SHEET, name="lid", positions=tp.Positions(v=(0, 3))),
    "Detector 'lid': shape ... Cloud(": lambda: tp.Detector(tp.Cloud(sigma=1), name="lid"),
    "Detector 'lid': times ... a number of bins ... got 0": lambda: meter(times=0),
    "Detector 'lid': times ... increasing ... (0, 2, 1)": lambda: meter(times=(0, 2, 1)),
    "Detector 'lid': times ... 0 or above ... (-1, 2)": lambda: meter(times=(-1, 2)),
    "Detector 'lid': times edges ... [0.0, 2.0] ... duration ... (0.0, 3.0)": lambda: tp.Scene(LAMP, (), meter(times=(0, 3)), duration=2),
    "Detector 'lid': times need a clock ... got 4 ... Scene(..., duration=...)": lambda: tp.Scene(LAMP, (), meter(times=4)),
    "Detector 'lid': speeds ... edges ... got 4 ... linspace": lambda: meter(speeds=4),
    "Detector 'lid': speeds ... 0 or above ... (-1, 1)": lambda: meter(speeds=(-1, 1)),
    "Detector 'lid': via ... name ... got 3 ... via='pinhole'": lambda: meter(via=3),
    "Detector 'lid': via ... got ()": lambda: meter(via=()),
    "Detector 'lid': via ... once ... ('a', 'a')": lambda: meter(via=("a", "a")),
    "Detector 'lid': via must name a detector or a surface ... got 'flor' ... did you mean 'floor'?": lambda: tp.Scene(LAMP, WALL, meter(via="flor")),
    "Detector 'lid': events ... reflections ... got 1.0": lambda: meter(events=1.0),
    "Detector 'lid': events ... got -1": lambda: meter(events=-1),
    "Detector 'lid': events ... (least, most) ... (2, 1)": lambda: meter(events=(2, 1)),
    "Detector 'lid': events ... (0, 1, 2) ... math.inf": lambda: meter(events=(0, 1, 2)),
    "Detector 'lid': moments ... True or False ... 'all'": lambda: meter(moments="all"),
    "Detector 'lid.in': name ... '.' ... write name='lid_in'": lambda: tp.Detector(DISK, name="lid.in"),
    "Detector: name ... text ... 3": lambda: tp.Detector(DISK, name=3),
    "Plane has no coordinates ... Rectangle or Disk in it": lambda: tp.Detector(tp.Plane(), "m", positions=tp.Positions(u=2)),
    "Slab has no coord ... planes()": lambda: tp.Detector(tp.Slab(thickness=0.5), "m", positions=tp.Positions(u=2)),
    "a Rectangle with a hole has no bins": lambda: tp.Detector(FRAME, "m", positions=tp.Positions(u=2)),
    "u edges must be within [-1.0, 1.0] for Cyl": lambda: tp.Detector(TUBE, "m", positions=tp.Positions(u=(0, 1.5))),
    "u edges must be within [0.0, 1.04": lambda: tp.Detector(CAP, "m", positions=tp.Positions(u=(0, 2))),
    "Detector 'meter': ... Triangle has no coordinates ... ; put a Detector on a Rect": lambda: tp.Detector(TRIANGLE, "meter", positions=tp.Positions(u=2)),
    **{
        f"directions must be in the local frame on a ... {type(shape).__name__}, got {kind} ... write Directions(mu=..., frame='local')": lambda shape=shape, directions=directions: tp.Detector(shape, "m", directions=directions)
        for shape in (TUBE, CONE, DISH, CAP, MESH)
        for kind, directions in (("Directions", tp.Directions(mu=2, frame="world")), ("DirectionCone", tp.Directions.cone((0, 0, 1), 0.1)))
    },
}  # fmt: skip

BINS = {
    "Directions ... mu, theta, phi ... none": lambda: tp.Directions(),
    "Directions: mu and theta ... mu=4 ... theta=2": lambda: tp.Directions(mu=4, theta=2),
    "Directions: mu ... got 0": lambda: tp.Directions(mu=0),
    "Directions: mu ... 1 000 000 ... got 1000000000000": lambda: tp.Directions(mu=10**12),
    "Directions: mu ... increasing ... (0, 0.5, 0.5)": lambda: tp.Directions(mu=(0, 0.5, 0.5)),
    "Directions: mu ... [0.0, 1.0] ... (-0.5, 1.0)": lambda: tp.Directions(mu=(-0.5, 1)),
    "Directions: mu ... [-1.0, 1.0] ... -2.0": lambda: tp.Directions(mu=(-2, 1), frame="world"),
    "Directions: theta ... 2.0": lambda: tp.Directions(theta=(0, 2)),
    "Directions: phi ... (-7.0, -1.0)": lambda: tp.Directions(phi=(-7, -1)),
    "Directions: phi ... one turn ... (-1.0, 0.0, 6.0)": lambda: tp.Directions(phi=(-1, 0, 6)),
    "Directions: mu x phi ... 10000000 ... got 20010000 ... 1.28 GB ... 4.48 GB ... 8 batches ... use fewer": lambda: tp.Directions(mu=10_000, phi=np.linspace(0, 6, 2002)),
    "Positions: u x v ... got 100000000": lambda: tp.Positions(u=10_000, v=10_000),
    "Directions: mu ... vanish": lambda: tp.Directions(mu=(0.5, 1, 1 + 4e-16)),
    "Directions: frame ... 'wold' ... 'world'": lambda: tp.Directions(mu=1, frame="wold"),
    "DirectionCone: half_angle ... (0, pi/2] ... got 2": lambda: tp.Directions.cone((0, 0, 1), 2),
    "half_angle missing ... write Directions.cone(half_angle=...)": lambda: tp.Directions.cone((0, 0, 1)),
    "halfangle=1 ... did you mean 'half_angle'?": lambda: tp.Directions.cone((0, 0, 1), halfangle=1),
    "got 2 ... write Directions.cone(axis=...": lambda: tp.Directions.cone((0, 0, 1), 1, 2),
    "DirectionCone: axis ... (0, 0, 0)": lambda: tp.Directions.cone((0, 0, 0), 1),
    "Positions ... u, v ... none": lambda: tp.Positions(),
    "Positions: u ... got -1": lambda: tp.Positions(u=-1),
    "Positions ... Box ... faces()": lambda: tp.Positions(u=2).edges(CUBE),
    "Positions ... Point(": lambda: tp.Positions(u=2).edges(tp.Point()),
    "Positions: u ... [0.5, 1.0] ... (0.0, 1.0)": lambda: tp.Positions(u=(0, 1)).edges(tp.Disk(radius=1, inner_radius=0.5)),
}  # fmt: skip

PHASE_SPACES = {
    "PhaseSpace 'phase_space': one or two of x, y, z, vx, vy, vz, speed, mu ... none ... x=edges": lambda: tp.PhaseSpace(time=1),
    "PhaseSpace 'phase_space': one or two of ... got x, vx, mu ... per pair": lambda: tp.PhaseSpace(x=EDGES, vx=EDGES, mu=4, time=1),
    "PhaseSpace ... keywords only ... time=...": lambda: tp.PhaseSpace(EDGES),
    "PhaseSpace ... time missing": lambda: tp.PhaseSpace(x=EDGES),
    "PhaseSpace 'cloud': x ... edges ... got 8 ... linspace": lambda: cloud(x=8),
    "PhaseSpace 'cloud': x ... increasing ... (0, 2, 1)": lambda: cloud(x=(0, 2, 1)),
    "PhaseSpace 'cloud': vx ... finite ... -inf": lambda: cloud(vx=(-math.inf, 0)),
    "PhaseSpace 'cloud': speed ... 0 or above ... (-1, 1)": lambda: cloud(speed=(-1, 1)),
    "PhaseSpace 'cloud': mu ... [-1.0, 1.0] ... 1.1": lambda: cloud(mu=(0, 1.1)),
    "PhaseSpace 'cloud': x x vx ... 10000000 ... got 100000000": lambda: cloud(x=range(10_001), vx=range(10_001)),
    "PhaseSpace ... time ... 0 or later ... got -1": lambda: tp.PhaseSpace(x=EDGES, time=-1),
    "PhaseSpace ... time ... got ()": lambda: tp.PhaseSpace(x=EDGES, time=()),
    "PhaseSpace ... increasing ... (1, 1)": lambda: tp.PhaseSpace(x=EDGES, time=(1, 1)),
    "PhaseSpace 'cloud': within ... Box ... Sphere(": lambda: cloud(x=EDGES, within=BALL),
    "PhaseSpace 'cloud': moments ... got 1": lambda: cloud(x=EDGES, moments=1),
    "Snapshot 'a.b' ... 'a_b'": lambda: tp.Snapshot(1, name="a.b"),
    "Snapshot 'snapshot': time ... (1, 2) ... one Snapshot per time": lambda: tp.Snapshot((1, 2)),
    "Snapshot 'snapshot': time ... got -1": lambda: tp.Snapshot(-1),
    "Snapshot 'snapshot': particles ... got 0": lambda: tp.Snapshot(1, particles=0),
    "particles ... whole ... got 0.5": lambda: tp.Snapshot(1, particles=0.5),
    "particles ... 10000000 ... 1000000000": lambda: tp.Snapshot(1, particles=10**9),
    "Snapshot 'snapshot': time needs a clock ... got 1.0 ... Scene(..., duration=...)": lambda: tp.Scene(LAMP, detectors=tp.Snapshot(1)),
    "PhaseSpace 'cloud': time ... duration of 2.0 s ... got 3.0 ... earlier time": lambda: tp.Scene(LAMP, detectors=cloud(x=EDGES, time=(1, 3)), duration=2),
    "Scene: name ... unique ... 2 Snapshots 'snapshot' ... name=": lambda: tp.Scene(LAMP, (), [tp.Snapshot(1), tp.Snapshot(2)], duration=2),
    "Scene: name ... unique ... 1 Detector and 1 Snapshot 'lid'": lambda: tp.Scene(LAMP, (), [meter(), tp.Snapshot(1, name="lid")], duration=2),
    "Snapshot 'floor': name ... surface ... rename": lambda: tp.Scene(LAMP, WALL, tp.Snapshot(1, name="floor"), duration=2),
}  # fmt: skip

VOLUMES = {
    "from face to face": lambda: volume(tp.Slab(thickness=1.0)),
    "a Box, a Sphere or a Cylinder": lambda: volume(DISK),
    "shape must be a Box, a Sphere or a Cylinder, got a Cone": lambda: volume(CONE, cells=(5, 7)),
    "whole Sphere": lambda: volume(CAP),
    "name must be given": lambda: volume(name=None),
    "three whole numbers ... (2, 2)": lambda: volume(cells=(2, 2)),
    "from 1 to ... (2, 0, 2)": lambda: volume(cells=(2, 0, 2)),
    "three whole numbers ... got (3,)": lambda: volume(cells=3),
    "must be ... 'many'": lambda: volume(cells="many"),
    "10000000": lambda: volume(cells=(500, 500, 500)),
    "radii ... (0.1, 0.9)": lambda: volume(tp.Sphere(radius=0.8), cells=(0.1, 0.9)),
    "radii ... (0.3, 0.2)": lambda: volume(BALL, cells=(0.3, 0.2)),
    "number of shells ... 0.5": lambda: volume(BALL, cells=(0.5,)),
    "Directions.sphere": lambda: volume(directions=tp.Directions(mu=4)),
    "'track' or 'collision'": lambda: volume(estimator="chord"),
    "mu ... within": lambda: tp.Directions.sphere(mu=(-1.5, 1)),
    "phi ... one turn": lambda: tp.Directions.sphere(phi=(0, 7)),
    "axis": lambda: tp.Directions.sphere(axis=(0, 0, 0)),
    "directions ... Directions": lambda: meter(directions=tp.Directions.sphere()),
    "must name a surface": lambda: tp.Scene(SHINING, [], tp.VolumeDetector("fog")),
    "unique": lambda: tp.Scene(SHINING, [], [volume(), tp.Detector(CUBE, "box")]),
    "error names no quantity 'flux_in'": lambda: tp.simulate(tp.Scene(SHINING, [], volume()), error={"box.flux_in": 0.1}),
    "duration": lambda: tp.simulate(tp.Scene(SHINING, [], volume()), error={"box.fluence": 0.1}),
    "'box'": lambda: tp.simulate(tp.Scene(SHINING, [], volume()), error={"box": 0.1}),
    "Vacuum": lambda: collisions(),
    "scatter": lambda: collisions(body(tp.Sphere(radius=0.8), tp.Medium(absorption=1.0)), tracking="weighted"),
    "got Vacuum": lambda: collisions(body(tp.Sphere(radius=0.5), FOG), tracking="analog"),
    **{
        f"two whole numbers for a Cylinder ... {cells} ... write cells=(nr, nz)": lambda cells=cells: volume(TUBE, cells=cells)
        for cells in (5, (3,), (3, 4, 5), (0, 3), (2.5, 3), (0.1, 0.2))
    },
}  # fmt: skip

POINTS = {
    **{
        f"PointDetector 'p' ... {type(each).__name__} ... 'glass'": lambda each=each: behind(each)
        for each in (tp.Mirror(), tp.Dielectric(1.5), tp.Glossy(0.2), tp.ThinLens(1.0))
    },
    "PointDetector 'p' ... Transparent ... 'glass'": lambda: behind(tp.Mixture({tp.Transparent(): 0.5, tp.Black(): 0.5})),
    "PointDetector 'p' ... must not lie on Surface 'wall'": lambda: point(surfaces=tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.5), "wall"), place=(0.6, 0.8, 0)),
    "PointDetector 'p' ... point source": lambda: point(place=(0, 0, 0)),
    "PointDetector 'p' ... must not lie on a source": lambda: point(tp.Source(tp.Disk(radius=2.0), tp.Lambertian(power=1.0))),
    "PointDetector 'p' ... steady": lambda: point(duration=1.0),
    "PointDetector 'p' ... aim": lambda: point(tp.Source(tp.Point(), tp.Isotropic(power=1.0), aim=UP)),
    "PointDetector 'p' ... Effusive": lambda: point(tp.Source(tp.Disk(radius=0.5), tp.Effusive(exitance=1.0, speed=1.0))),
    "PointDetector 'p' ... forced": lambda: point(surfaces=body(tp.Box(size=1.0), FOG), tracking=tp.Tracking(forced=True)),
    "position ... (0, 0)": lambda: tp.PointDetector((0, 0), "p"),
    "name missing": lambda: tp.PointDetector(position=(0, 0, 1)),
    "name ... None": lambda: tp.PointDetector((0, 0, 1), None),
    "name ... 'a_b'": lambda: tp.PointDetector((0, 0, 1), "a.b"),
    "'position'": lambda: tp.PointDetector(center=(0, 0, 1), name="p"),
}  # fmt: skip

CAMERAS = {
    "Camera ... got both": lambda: camera(look_at=(1, 0, 0)),
    "got none": lambda: camera(direction=None),
    "line of sight": lambda: camera(up=(1, 0, 0)),
    "field_of_view ... (0, pi)": lambda: camera(field_of_view=math.pi),
    "pixels ... whole numbers": lambda: camera(pixels=(8, 0)),
    "must differ from position": lambda: camera(direction=None, look_at=(0, 0, 0)),
    "name must be given": lambda: camera(name=None),
    "theta": lambda: tp.EnvironmentMap(name="map", position=(0, 0, 0), theta=0),
    "leave duration out": lambda: tp.Scene(LAMP, (), [camera()], duration=1.0),
}  # fmt: skip

EXPECTED = {
    "leave duration out": lambda: expected(pane("meter", 0.5), duration=1.0),
    "PointDetector 'there'": lambda: expected(pane("meter", 0.5), tp.PointDetector((0, 0, 0.1), "there")),
    "use a Detector on a Rectangle, Disk, Triangle, Polygon or whole Sphere": lambda: expected(tp.Detector(tp.Cylinder(radius=0.1, height=0.2), "rod")),
}  # fmt: skip

METER, NO = tp.Detector(FACING, "meter"), "does not go with this scene ... "
UNLIKE = tp.TwoSided(tp.Diffuse(0.1, 0.5), tp.Diffuse(0.1, 0.2))
BACKWARD = {
    NO + "leave duration out": lambda: backward(METER, duration=1.0),
    NO + "via=": lambda: backward(METER, tp.Detector(tp.Disk(center=(0, 0, 2), radius=1), "next", via="meter")),
    NO + "leave it out": lambda: backward(tp.Detector(FACING, "meter", events=0)),
    NO + "no history starts from": lambda: backward(volume()),
    NO + "detectors=[...]": lambda: backward(),
    NO + "not reciprocal": lambda: backward(METER, surfaces=tp.Surface(tp.Disk(center=(0, 0, 0.5), radius=1), tp.ThinLens(1.0))),
    NO + "different shares": lambda: backward(METER, surfaces=tp.Surface(tp.Disk(center=(0, 0, 0.5), radius=1), UNLIKE)),
    NO + "must be finite": lambda: backward(tp.Detector(tp.Plane(center=(0, 0, 1)), "plane")),
    "sampling 'sobol' does not go with estimator 'backward'": lambda: tp.simulate(backward_fog(), 1000, estimator="backward", sampling="sobol"),
}  # fmt: skip

PATH_LENGTHS = {
    "path_lengths=(Vacuum(),), which only forward histories know": lambda: paths(tp.Vacuum(), "backward"),
    "path_lengths=(Vacuum(),), which only a particle's own crossing can score": lambda: paths(tp.Vacuum(), "expected"),
    "path_lengths must name media of the scene, got Medium(scattering=2.0)": lambda: paths(tp.Medium(scattering=2.0)),
    "path_lengths must name each medium once": lambda: paths([FOG, tp.Medium(absorption=0.1, scattering=0.9)]),
    "write path_lengths=[tissue]": lambda: paths("tissue"),
    "mean_path_in needs path_lengths": lambda: paths(None),
}  # fmt: skip

VIEW_FACTORS = {
    "view_factor: a must be a shape with an area ... got Point": lambda: factor(tp.Point(), DISK),
    "view_factor: b must be a shape with an area ... 'lid'": lambda: factor(b="lid"),
    "etendue: a must be a shape": lambda: tp.etendue(3, DISK),
    "a must be ... finite area ... exchange a and b": lambda: factor(tp.Plane(), DISK),
    "side_b must be 'front', 'back', 'outside' or 'inside' on a Sphere, got 'left'": lambda: factor(b=tp.Sphere(radius=3), side_b="left"),
    "side_a must be 'front' or 'back' on a Disk": lambda: factor(b=tp.Sphere(radius=3), side_a="inside"),
    "blockers must be shapes, got 'wall'": lambda: factor(blockers="wall"),
    "blockers[0] must be a shape": lambda: factor(blockers=[tp.Cloud(sigma=1)]),
    "'a' and Surface 'b' overlap": lambda: factor(b=tp.Disk(radius=0.5)),
    "blockers[0] must be a shape ... pass its shape, surface.shape": lambda: factor(blockers=tp.Surface(tp.Sphere(radius=3), tp.Black())),
    "view_factor: unknown parameter error=0.001; choose from": lambda: factor(error=1e-3),
    "etendue: unknown parameter n_photons=10; did you mean 'particles'?": lambda: tp.etendue(DISK, FACING, n_photons=10),
    "solid_angle: unknown parameter samples=10; did you mean 'particles'?": lambda: tp.solid_angle(DISK, (0, 0, 1), samples=10),
    "tracks: unknown parameter rays=10; did you mean 'particles'?": lambda: tp.tracks(None, rays=10),
    "cost_of_accuracy: unknown parameter time=10; did you mean 'seconds'?": lambda: tp.cost_of_accuracy(None, "d.flux_in", time=10),
    "bins_against_noise: unknown parameter axis='u'": lambda: tp.bins_against_noise(None, axis="u"),
    "merge: unknown parameter runs=[]; it takes no keywords": lambda: tp.merge(runs=[]),
    "load: unknown parameter file='x.nc'": lambda: tp.load(file="x.nc"),
    "overlap on one plane": lambda: factor(blockers=[DISK]),
    "particles must be": lambda: factor(particles=0),
    "side_b must be 'back' where a lies inside b ... write side_b": lambda: factor(tp.Sphere(radius=1), tp.Sphere(radius=1.1)),
    "side_a must be 'back' where b lies inside a": lambda: factor(tp.Box(size=4), tp.Sphere(radius=1)),
    "side_b must be 'back'": lambda: factor(b=tp.Sphere(radius=3)),
}  # fmt: skip

TABLES = (
    DETECTORS,
    BINS,
    PHASE_SPACES,
    VOLUMES,
    POINTS,
    CAMERAS,
    EXPECTED,
    BACKWARD,
    PATH_LENGTHS,
    VIEW_FACTORS,
)


@pytest.mark.slow
@pytest.mark.parametrize(("words", "make"), [case for table in TABLES for case in table.items()])
def test_a_wrong_detector_is_refused_with_object_parameter_value_and_cure(words, make):
    assert_refused(make, words)
