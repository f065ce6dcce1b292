"""The price list: one line per effect, and the base room that prices are relative to.

A new effect adds its line here.  IN_ANY_SCENE can be added to any scene that allows them (`transport effects
SIM` prices them there); IN_THE_ROOM only make sense in the base room.
"""

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, replace

import numpy as np

from transport.cli.effects.costs import Footprint, footprint_of
from transport.cli.effects.treatment import Treatment
from transport.compile.compiler import compile_scene
from transport.compile.limits_exceeded import OverrunError
from transport.geometry.flat import Disk, Rectangle, Triangle
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.solid import Box, Sphere
from transport.run.progress import progress_on
from transport.scene.bins import Directions, Positions
from transport.scene.cameras import Camera
from transport.scene.detectors import Detector
from transport.scene.emissions import Effusive, Lambertian
from transport.scene.materials import (
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
from transport.scene.media import Grid, Medium
from transport.scene.phase_functions import HenyeyGreenstein, Rayleigh, Tabulated
from transport.scene.phase_space import PhaseSpace, Snapshot
from transport.scene.points import PointDetector
from transport.scene.pulses import BoxPulse
from transport.scene.scene import Scene
from transport.scene.sources import Source
from transport.scene.speeds import Maxwellian
from transport.scene.tracking import Splitting
from transport.scene.volumes import VolumeDetector
from transport.validation import SceneError

# ---- Additions: functions that add one effect to a scene or to the settings of its run, for the price list.

Change = Callable[[Treatment], Treatment]


@dataclass(frozen=True)
class Addition:
    """An effect that can be added to a treatment.

    `to(treatment)` returns the treatment with the effect, or an equal treatment if the effect is present
    already or does not apply.  `over` names the addition that this one needs and that its price is relative
    to; None: the unchanged scene.
    """

    name: str
    to: Change
    over: str | None = None


def in_scene(change: Callable[[Scene], Scene]) -> Change:
    """Return a change of the treatment that applies `change` to its scene."""
    return lambda treatment: replace(treatment, scene=change(treatment.scene))


def meters_ask(**asked: object) -> Change:
    """Set these fields on every Detector, unless a detector has one of them already."""

    def change(scene: Scene) -> Scene:
        if any(getattr(meter, name) not in (None, False) for meter in scene.meters for name in asked):
            return scene
        return replace(scene, detectors=[_asking(one, asked) for one in scene.detectors])

    return in_scene(change)


def looks(make: Callable[[Scene], object]) -> Change:
    """Add the detector `make(scene)`, unless the scene has one of its type."""

    def change(scene: Scene) -> Scene:
        more = make(scene)
        if any(isinstance(one, type(more)) for one in scene.detectors):
            return scene
        return replace(scene, detectors=(*scene.detectors, more))

    return in_scene(change)


def stands(*surfaces: Surface) -> Change:
    """Add surfaces to the scene."""
    return in_scene(lambda scene: replace(scene, surfaces=(*scene.surfaces, *surfaces)))


def filled(**coefficients: float) -> Change:
    """Fill a vacuum scene with a medium; coefficients are in units of 1 / (half the scene's size).

    A scene that has media stays unchanged.
    """

    def change(scene: Scene) -> Scene:
        plan = compile_scene(scene)
        if plan.has_media:
            return scene
        reach = 0.5 * plan.space.size
        return replace(scene, medium=Medium(**{name: value / reach for name, value in coefficients.items()}))

    return in_scene(change)


def medium_has(**changes: object) -> Change:
    """Change fields of the ambient medium, if there is one."""

    def change(scene: Scene) -> Scene:
        if not isinstance(scene.medium, Medium):
            return scene
        return replace(scene, medium=replace(scene.medium, **changes))

    return in_scene(change)


def estimated(**changes: str) -> Change:
    """Change the estimator or the sampling."""
    return lambda treatment: replace(treatment, method=replace(treatment.method, **changes))


def tracked(**choices: object) -> Change:
    """Change the tracking through media, if there are any."""

    def change(treatment: Treatment) -> Treatment:
        plan = compile_scene(treatment.scene, treatment.tracking)
        if not plan.has_media:
            return treatment
        return replace(treatment, tracking=replace(plan.tracking, **choices))

    return change


def box_within(scene: Scene) -> Box:
    """Return a cube of a quarter of the scene's size, at the mean centre of its shapes."""
    shapes = [scene.shape_of(one) for one in (*scene.sources, *scene.meters)]
    shapes += [surface.shape for surface in scene.surfaces]
    middle = np.mean([shape.middle for shape in shapes], axis=0)
    return Box(center=tuple(map(float, middle)), size=0.25 * compile_scene(scene).space.size)


def _asking(one: object, asked: dict[str, object]) -> object:
    return replace(one, **asked) if isinstance(one, Detector) else one


# ---- The price list: one line per effect, and the base room that prices are relative to.

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


# ---- Price list: CPU time of a treatment without and with each addition, run in turns; medians over the turns.
#
# Differences and ratios are taken within a turn, so that other load of the machine affects both sides.

AS_IT_IS = "unchanged"
TURNS, SECONDS = 7, 0.05  # turns of the price list, and approximate time of a run [s]
MOST = 1 << 22  # largest number of histories of a run


@dataclass(frozen=True)
class Price:
    """Cost of a treatment per history, and the cost that its addition adds to the treatment `over`.

    `ns` and `added` are medians of CPU nanoseconds per history, `ratio` is the ratio of the two treatments.
    `events` is the number of crossings and collisions per history, `passes` the number of passes of the
    program.
    """

    name: str
    over: str | None
    ns: float
    added: float
    ratio: float
    events: float
    passes: int
    footprint: Footprint

    @property
    def ns_an_event(self) -> float:
        """CPU nanoseconds per crossing or collision; nan without events."""
        return self.ns / self.events if self.events else math.nan

    @property
    def record(self) -> dict[str, object]:
        """All values as one dictionary for JSON."""
        return asdict(self) | {"ns_an_event": self.ns_an_event}


@dataclass(frozen=True)
class PriceList:
    """Prices of additions to a treatment.

    `prices` starts with the unchanged treatment; `refused` maps the names of impossible additions to the
    reason; `idle` names additions that change nothing.
    """

    prices: tuple[Price, ...]
    refused: Mapping[str, str]
    idle: tuple[str, ...]


def base_prices(turns: int = TURNS, seconds: float = SECONDS) -> PriceList:
    """Measure the price list of all effects, relative to the base room."""
    return prices_of(base_room(), ADDITIONS.values(), turns, seconds)


def price_rows(turns: int = TURNS, share: int = 1) -> list[dict]:
    """Return the price list as benchmark rows {name, value, unit, ratio}; ratio is relative to `over`.

    Runs are shorter by the factor `share`.
    """
    prices = base_prices(turns, SECONDS / share).prices
    return [
        {
            "name": f"base room, {price.name}",
            "value": price.ns,
            "unit": "ns/history",
            "ratio": None if price.over is None else price.ratio,
        }
        for price in prices
    ]


def prices_in(scene: Treatment, turns: int = 3, seconds: float = 0.02) -> PriceList:
    """Measure the cost in this scene of each effect that can be added to any scene."""
    return prices_of(scene, IN_ANY_SCENE, turns, seconds)


def prices_of(treatment: Treatment, additions: Iterable[Addition], turns: int, seconds: float) -> PriceList:
    """Measure a treatment and each addition to it, with a progress bar during compilation."""
    found, refused, idle = {AS_IT_IS: (None, treatment)}, {}, []
    for addition in additions:
        try:
            before, after = (with_addition(name, treatment) for name in (addition.over, addition.name))
            _ = after.plan
        except SceneError as reason:
            refused[addition.name] = str(reason)
            continue
        if after == before:
            idle.append(addition.name)
        else:
            found[addition.name] = (before, after)
    wanted = dict.fromkeys(each for pair in found.values() for each in pair if each is not None)
    works, overruns = _works(wanted, seconds)
    refused |= {name: overruns[after] for name, (_, after) in found.items() if after in overruns}
    spent = _spent(works, turns)
    prices = [
        _price(name, _over(name, before, treatment), works[after], spent[after], spent[before or after])
        for name, (before, after) in found.items()
        if after in works and (before is None or before in works)
    ]
    return PriceList(tuple(prices), refused, tuple(idle))


def _over(name: str, before: Treatment | None, treatment: Treatment) -> str | None:
    """Return the name of the treatment that a price is relative to: the needed addition, or AS_IT_IS."""
    if before is None:
        return None
    return AS_IT_IS if before == treatment else ADDITIONS[name].over


class _Work:
    """A compiled treatment, with a number of histories whose run takes about `seconds`.

    Raises OverrunError.
    """

    def __init__(self, treatment: Treatment, seconds: float, compiling) -> None:
        from transport.engine.driver import machine_of
        from transport.engine.program import program_of

        self.program = program_of(treatment.plan)
        self.machine = machine_of(self.program, compiling)
        self.histories, self.events = 1 << 10, 0.0
        self.run(0)  # load everything before timing
        while (spent := self.run(0)) < 0.7 * seconds and self.histories < MOST:
            wanted = self.histories * seconds / max(spent, 1e-6)
            self.histories = min(MOST, max(2 * self.histories, 1 << round(math.log2(wanted))))

    def run(self, batch: int) -> float:
        """Run one batch and return its CPU time [s]; store the events per history."""
        from transport.engine.driver import run_batch

        begun = time.process_time()
        sums = run_batch(self.machine, 1, batch, self.histories)
        spent = time.process_time() - begun
        self.events = (sums.crossings + sums.collisions) / self.histories
        return spent


def _works(treatments: Iterable[Treatment], seconds: float) -> tuple[dict, dict]:
    """Compile each treatment; return the works, and the reason for each treatment that cannot run."""
    works, overruns = {}, {}
    with progress_on(None) as bar:
        for treatment in treatments:
            try:
                works[treatment] = _Work(treatment, seconds, bar.compiling)
            except OverrunError as reason:
                overruns[treatment] = str(reason)
    return works, overruns


def _spent(works: Mapping[Treatment, _Work], turns: int) -> dict[Treatment, np.ndarray]:
    """Return the CPU nanoseconds per history of each treatment, shape (turns,).

    The order rotates each turn, so that no treatment always follows the most expensive one.
    """
    spent, order = {treatment: np.zeros(turns) for treatment in works}, list(works)
    for turn in range(turns):
        for treatment in order[turn % len(order) :] + order[: turn % len(order)]:
            work = works[treatment]
            spent[treatment][turn] = 1e9 * work.run(turn + 1) / work.histories
    return spent


def _price(name: str, over: str | None, work: _Work, spent: np.ndarray, before: np.ndarray) -> Price:
    return Price(
        name,
        over,
        ns=float(np.median(spent)),
        added=float(np.median(spent - before)),
        ratio=float(np.median(spent / before)),
        events=work.events,
        passes=len(work.program.passes),
        footprint=footprint_of(work.program),
    )
