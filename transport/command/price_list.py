"""The price list: one line per effect, and the base room that prices are relative to.

A new effect adds its line here.  IN_ANY_SCENE can be added to any scene that allows them (`transport effects
SIM` prices them there); IN_THE_ROOM only make sense in the base room.
"""

from dataclasses import replace

import numpy as np

from transport.cameras import Camera
from transport.command.additions import (
    Addition,
    box_within,
    estimated,
    filled,
    in_scene,
    looks,
    medium_has,
    meters_ask,
    stands,
    tracked,
)
from transport.command.treatment import Treatment
from transport.detectors import Detector, Directions, Positions
from transport.emissions import Effusive, Lambertian
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
from transport.media import Grid, HenyeyGreenstein, Medium, Rayleigh, Tabulated
from transport.phase_space import PhaseSpace, Snapshot
from transport.points import PointDetector
from transport.pulses import BoxPulse
from transport.scene import Scene
from transport.shapes import Box, Cone, Cylinder, Disk, Mesh, Paraboloid, Rectangle, Sphere, Triangle
from transport.sources import Source
from transport.speeds import Maxwellian
from transport.tracking import Splitting
from transport.volumes import VolumeDetector

LONG = 1e6  # [s] duration in which nearly all histories end
GAS = Maxwellian(sigma=300.0)  # [m/s]
BALL, TILE, BODY = Sphere(radius=0.3), Disk(radius=0.3), Box(size=1.0)
VOXELS = 1.0 + np.arange(512.0).reshape(8, 8, 8) % 7  # non-uniform
CLOUD = Grid(box=BODY, absorption=0.02 * VOXELS, scattering=0.1 * VOXELS)
TABLE = Tabulated(mu=(-1, 0, 1), density=(1.0, 2.0, 3.0))
FINE = Directions(mu=16, phi=32)


def base_room() -> Treatment:
    """Return a closed cube of diffuse walls with an emitting ceiling and a detector on the floor."""
    walls = [Surface(face, Diffuse(0.5), name) for name, face in Box(size=2.0).faces().items()]
    lamp = Source("+z", Lambertian(exitance=1.0), side="back")
    return Treatment(Scene([lamp], walls, [Detector("-z", "floor", side="back")]))


def _effused(scene: Scene) -> Scene:
    lamps = [replace(lamp, emission=Effusive(exitance=1.0, speed=GAS)) for lamp in scene.sources]
    return replace(scene, sources=lamps)


def _warm(scene: Scene) -> Scene:
    walls = [replace(wall, material=Diffuse(0.5, speed=GAS)) for wall in scene.surfaces]
    return replace(scene, surfaces=walls)


def _blackened(scene: Scene) -> Scene:
    return replace(scene, surfaces=[replace(wall, material=Black()) for wall in scene.surfaces])


def _pulsed(scene: Scene) -> Scene:
    return replace(scene, sources=[replace(lamp, pulse=BoxPulse(0.0, 1.0)) for lamp in scene.sources])


def _aimed(scene: Scene) -> Scene:
    return replace(scene, sources=[replace(lamp, aim=TILE) for lamp in scene.sources])


def _split(treatment: Treatment) -> Treatment:
    box = box_within(treatment.scene)
    low, _ = box.bounds
    return tracked(splitting=Splitting(start=box.center, end=(*box.center[:2], low[2]), gain=4.0))(treatment)


def _phase_space(scene: Scene) -> PhaseSpace:
    return PhaseSpace(mu=16, time=0.5 * scene.duration)


def _snapshot(scene: Scene) -> Snapshot:
    return Snapshot(time=0.5 * scene.duration, particles=1000)


def _via(scene: Scene) -> Scene:
    names = [one.name for one in (*scene.surfaces, *scene.meters) if one.name is not None]
    return meters_ask(via=names[0])(Treatment(scene)).scene if names else scene


def _seen(scene: Scene) -> Scene:
    """Replace the detectors by a pinhole camera above the floor, for backward histories."""
    return replace(
        scene,
        detectors=[
            Camera(name="view", position=(0, 0, -0.9), direction=(0, 0, 1), up=(0, 1, 0), pixels=(16, 16))
        ],
    )


def _of(material: object):
    """Change the material of the surface that was added last."""
    return in_scene(
        lambda scene: _last_is(replace(scene.surfaces[-1], material=material))(Treatment(scene)).scene
    )


def _last_is(thing: Surface):
    """Replace the surface that was added last."""
    return in_scene(lambda scene: replace(scene, surfaces=(*scene.surfaces[:-1], thing)))


def _box_of(medium: Medium | Grid) -> Surface:
    return Surface(BODY, Transparent(), "box", inside=medium)


def _meters(*more: Detector):
    return in_scene(lambda scene: replace(scene, detectors=(*scene.detectors, *more)))


def _volume(**asked: object):
    return looks(lambda scene: VolumeDetector(box_within(scene), "volume", **asked))


def _clocked(scene: Scene) -> Scene:
    return scene if scene.duration is not None else replace(scene, duration=LONG)


CLOCK, FOG = "a clock", "absorption and scattering"
IN_ANY_SCENE = (
    Addition("bins of direction, 16", meters_ask(directions=Directions(mu=16))),
    Addition("bins of direction, 16 x 32", meters_ask(directions=FINE)),
    Addition("bins of position, 16 x 16", meters_ask(positions=Positions(u=16, v=16))),
    Addition("filter by crossed surface (via)", in_scene(_via)),
    Addition("filter by events (events=0)", meters_ask(events=0)),
    Addition("moments of velocity", meters_ask(moments=True)),
    Addition(CLOCK, in_scene(_clocked)),
    Addition("... bins of time, 16", meters_ask(times=16), CLOCK),
    Addition("... phase space at an instant", looks(_phase_space), CLOCK),
    Addition("... a snapshot", looks(_snapshot), CLOCK),
    Addition("a volume detector", _volume()),
    Addition("a volume detector of 8 x 8 x 8 cells", _volume(cells=(8, 8, 8))),
    Addition("absorption", filled(absorption=0.5)),
    Addition("scattering", filled(scattering=0.5)),
    Addition(FOG, filled(absorption=0.1, scattering=0.5)),
    Addition("... analog absorption", tracked(absorption="analog"), FOG),
    Addition("... Henyey-Greenstein, g = 0.8", medium_has(phase=HenyeyGreenstein(0.8)), FOG),
    Addition("... Rayleigh", medium_has(phase=Rayleigh()), FOG),
    Addition("... a tabulated phase function", medium_has(phase=TABLE), FOG),
    Addition("... forced first collisions", tracked(forced=True), FOG),
    Addition("... splitting", _split, FOG),
    Addition("... a volume detector, collision estimator", _volume(estimator="collision"), FOG),
    Addition("... a volume detector", _volume(), FOG),
    Addition("... estimator expected", estimated(estimator="expected"), FOG),
    Addition("estimator aimed", estimated(estimator="aimed")),
    Addition("estimator expected", estimated(estimator="expected")),
    Addition("estimator backward", estimated(estimator="backward")),
    Addition("sampling stratified", estimated(sampling="stratified")),
    Addition("sampling sobol", estimated(sampling="sobol")),
)


DIFFUSE, BALL_STANDS, BOXED = Diffuse(0.5), "a ball", "a box of fog"
GAS_FLIES, BLACK = "... a Maxwellian gas", "black walls"
IN_THE_ROOM = (
    Addition("a source aimed at a disk", in_scene(_aimed)),
    Addition(GAS_FLIES, in_scene(_effused), CLOCK),
    Addition("... ... bins of speed, 8", meters_ask(speeds=tuple(np.linspace(1.0, 1801.0, 9))), GAS_FLIES),
    Addition("... ... thermal walls", in_scene(_warm), GAS_FLIES),
    Addition("... a pulse", in_scene(_pulsed), CLOCK),
    Addition(BLACK, in_scene(_blackened)),
    Addition("... estimator aimed", estimated(estimator="aimed"), BLACK),
    Addition("a disk", stands(Surface(TILE, DIFFUSE))),
    Addition(
        "a triangle", stands(Surface(Triangle(vertices=((0, 0, 0), (0.5, 0, 0), (0, 0.5, 0.3))), DIFFUSE))
    ),
    Addition(
        "a rectangle with a hole",
        stands(Surface(Rectangle(width=0.6, height=0.6, hole=Disk(radius=0.2)), DIFFUSE)),
    ),
    Addition("a cylinder", stands(Surface(Cylinder(radius=0.3, height=0.6), DIFFUSE))),
    Addition("a cone", stands(Surface(Cone(radius=0.3, height=0.6), DIFFUSE))),
    Addition("a paraboloid", stands(Surface(Paraboloid(focal_length=0.2, radius=0.3), DIFFUSE))),
    Addition("a mesh of 1280 triangles", stands(Surface(Mesh.sphere(radius=0.3), DIFFUSE))),
    Addition(BALL_STANDS, stands(Surface(BALL, DIFFUSE))),
    Addition("... black", _of(Black()), BALL_STANDS),
    Addition("... a mirror", _of(Mirror(0.9)), BALL_STANDS),
    Addition("... a half-transparent mirror", _of(Mirror(0.5, 0.5)), BALL_STANDS),
    Addition("... diffuse with transmission", _of(Diffuse(0.3, 0.3)), BALL_STANDS),
    Addition("... of glass", _of(Dielectric(1.5)), BALL_STANDS),
    Addition("... glossy", _of(Glossy(0.3, 0.9)), BALL_STANDS),
    Addition("... a mixture", _of(Mixture({Mirror(): 0.5, Diffuse(0.5): 0.5})), BALL_STANDS),
    Addition("... a two-sided material", _of(TwoSided(Diffuse(0.5), Black())), BALL_STANDS),
    Addition("... a thin lens", _of(ThinLens(0.5)), "a disk"),
    Addition(
        "a detector on a separate disk",
        _meters(Detector(TILE, "tile")),
    ),
    Addition("a detector on the source", _meters(Detector("+z", "lamp", side="back"))),
    Addition(
        "a detector on a window in front of the source",
        _meters(Detector(Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=1, height=1), "window")),
    ),
    Addition(BOXED, stands(_box_of(Medium(0.1, 0.5)))),
    Addition("... of 8 x 8 x 8 voxels", _last_is(_box_of(CLOUD)), BOXED),
    Addition("... with emission", _last_is(_box_of(Medium(0.1, 0.5, emission=0.1))), BOXED),
    Addition("a point detector", looks(lambda scene: PointDetector((0.2, 0.1, 0.0), "point"))),
    Addition("... a point detector", looks(lambda scene: PointDetector((0.2, 0.1, 0.0), "point")), FOG),
    Addition("... a camera of 16 x 16 pixels", in_scene(_seen), "estimator backward"),
)
ADDITIONS = {each.name: each for each in (*IN_ANY_SCENE, *IN_THE_ROOM)}


def with_addition(name: str | None, treatment: Treatment) -> Treatment:
    """Return the treatment with this addition and those it needs.

    Raises SceneError if the scene does not allow them.
    """
    if name is None:
        return treatment
    addition = ADDITIONS[name]
    return addition.to(with_addition(addition.over, treatment)).checked()
