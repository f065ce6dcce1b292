"""Prices of effects: the CPU time that each adds to a base room, or to the scene of an experiment.

    python -m tests.bench prices [SIM] [--turns 7] [--json]

A new effect adds its line here.  IN_ANY_SCENE can be added to any scene that allows them; IN_THE_ROOM only make
sense in the base room.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, replace

import numpy as np
import typer
from rich.table import Table

from transport.analysis.effects import Footprint, TimedRun, Treatment, footprint_of
from transport.cli.output import print_json, print_rich, table_of
from transport.cli.run import experiment_treatment
from transport.compile.compiler import compile_scene
from transport.compile.limits_exceeded import OverrunError
from transport.geometry.flat import Disk, Rectangle, Triangle
from transport.geometry.mesh import Mesh
from transport.geometry.revolved import Cone, Cylinder, Paraboloid
from transport.geometry.solid import Box, Sphere
from transport.run.progress import open_progress
from transport.scene.bins import Directions, Positions
from transport.scene.bodies import surrounding_medium
from transport.scene.cameras import Camera, EnvironmentMap, LightField
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
from transport.verification.experiment import cases_of, experiment, scene_of

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
    apply: Change
    over: str | None = None


def scene_change(change: Callable[[Scene], Scene]) -> Change:
    """Return a change of the treatment that applies `change` to its scene."""
    return lambda treatment: replace(treatment, scene=change(treatment.scene))


def set_on_detectors(**fields: object) -> Change:
    """Set these fields on every Detector, unless a detector has one of them already."""

    def change(scene: Scene) -> Scene:
        if any(getattr(detector, name) not in (None, False) for detector in scene.meters for name in fields):
            return scene
        changed = [replace(one, **fields) if isinstance(one, Detector) else one for one in scene.detectors]
        return replace(scene, detectors=changed)

    return scene_change(change)


def set_on_each(kind: str, **fields: object) -> Change:
    """Set these fields on all "sources" or "surfaces" of the scene."""
    return scene_change(
        lambda scene: replace(scene, **{kind: [replace(each, **fields) for each in getattr(scene, kind)]})
    )


def add_detector(make: Callable[[Scene], object]) -> Change:
    """Add the detector `make(scene)`, unless the scene has one of its type."""

    def change(scene: Scene) -> Scene:
        more = make(scene)
        if any(isinstance(one, type(more)) for one in scene.detectors):
            return scene
        return replace(scene, detectors=(*scene.detectors, more))

    return scene_change(change)


def add_surfaces(*surfaces: Surface) -> Change:
    """Add surfaces to the scene."""
    return scene_change(lambda scene: replace(scene, surfaces=(*scene.surfaces, *surfaces)))


def fill_with_medium(**coefficients: float) -> Change:
    """Fill a vacuum scene with a medium; coefficients are in units of 1 / (half the scene's size).

    A scene that has media stays unchanged.
    """

    def change(scene: Scene) -> Scene:
        plan = compile_scene(scene)
        if plan.has_media:
            return scene
        reach = 0.5 * plan.space.size
        return replace(scene, medium=Medium(**{name: value / reach for name, value in coefficients.items()}))

    return scene_change(change)


def change_medium(**changes: object) -> Change:
    """Change fields of the ambient medium, if there is one."""

    def change(scene: Scene) -> Scene:
        if not isinstance(scene.medium, Medium):
            return scene
        return replace(scene, medium=replace(scene.medium, **changes))

    return scene_change(change)


def change_method(**changes: str | int) -> Change:
    """Change the estimator, the sampling or the guide."""
    return lambda treatment: replace(treatment, method=replace(treatment.method, **changes))


def change_tracking(**choices: object) -> Change:
    """Change the tracking through media, if there are any."""

    def change(treatment: Treatment) -> Treatment:
        plan = compile_scene(treatment.scene, treatment.tracking)
        if not plan.has_media:
            return treatment
        return replace(treatment, tracking=replace(plan.tracking, **choices))

    return change


def central_box(scene: Scene) -> Box:
    """Return a cube of a quarter of the scene's size, at the mean centre of its shapes."""
    shapes = [scene.shape_of(one) for one in (*scene.sources, *scene.meters)]
    shapes += [surface.shape for surface in scene.surfaces]
    middle = np.mean([shape.middle for shape in shapes], axis=0)
    return Box(center=tuple(map(float, middle)), size=0.25 * compile_scene(scene).space.size)


# ---- The list of additions, and the base room.

LONG_DURATION = 1e6  # [s] duration in which nearly all histories end
GAS = Maxwellian(sigma=300.0)  # [m/s]
BALL, TILE, BODY = Sphere(radius=0.3), Disk(radius=0.3), Box(size=1.0)
VOXELS = 1.0 + np.arange(512.0).reshape(8, 8, 8) % 7  # non-uniform
VOXEL_GRID = Grid(box=BODY, absorption=0.02 * VOXELS, scattering=0.1 * VOXELS)
GLOWING_FOG = Medium(0.1, 0.5, emission=0.1)
PHASE_TABLE = Tabulated(mu=(-1, 0, 1), density=(1.0, 2.0, 3.0))
FINE_DIRECTIONS = Directions(mu=16, phi=32)


def base_room() -> Treatment:
    """Return a closed cube of diffuse walls with an emitting ceiling and a detector on the floor."""
    walls = [Surface(face, Diffuse(0.5), name) for name, face in Box(size=2.0).faces().items()]
    lamp = Source("+z", Lambertian(exitance=1.0), side="back")
    return Treatment(Scene([lamp], walls, [Detector("-z", "floor", side="back")]))


def _with_splitting(treatment: Treatment) -> Treatment:
    box = central_box(treatment.scene)
    end = (*box.center[:2], box.bounds[0][2])
    return change_tracking(splitting=Splitting(start=box.center, end=end, gain=4.0))(treatment)


def _phase_space(scene: Scene) -> PhaseSpace:
    return PhaseSpace(mu=16, time=0.5 * scene.duration)


def _snapshot(scene: Scene) -> Snapshot:
    return Snapshot(time=0.5 * scene.duration, particles=1000)


def _with_via(scene: Scene) -> Scene:
    names = [one.name for one in (*scene.surfaces, *scene.meters) if one.name is not None]
    return set_on_detectors(via=names[0])(Treatment(scene)).scene if names else scene


def _with_path_lengths(scene: Scene) -> Scene:
    return set_on_detectors(path_lengths=[surrounding_medium(scene)])(Treatment(scene)).scene


def _with_view(kind: type, **how: object) -> Change:
    """Replace the detectors by an instrument above the floor, for backward histories."""
    where = {"position": (0, 0, -0.9)}
    if kind is not EnvironmentMap:
        where |= {"direction": (0, 0, 1), "up": (0, 1, 0)}
    return scene_change(lambda scene: replace(scene, detectors=[kind(name="view", **where, **how)]))


def _replace_last(make: Callable[[Surface], Surface]) -> Change:
    """Replace the surface that was added last."""

    def change(scene: Scene) -> Scene:
        *others, last = scene.surfaces
        return replace(scene, surfaces=(*others, make(last)))

    return scene_change(change)


def _last_material(material: object) -> Change:
    return _replace_last(lambda surface: replace(surface, material=material))


def _filled_box(medium: Medium | Grid) -> Surface:
    return Surface(BODY, Transparent(), "box", inside=medium)


def _add_detectors(*more: Detector) -> Change:
    return scene_change(lambda scene: replace(scene, detectors=(*scene.detectors, *more)))


def _add_volume_detector(**fields: object) -> Change:
    return add_detector(lambda scene: VolumeDetector(central_box(scene), "volume", **fields))


def _with_duration(scene: Scene) -> Scene:
    return scene if scene.duration is not None else replace(scene, duration=LONG_DURATION)


CLOCK, FOG = "a clock", "absorption and scattering"
IN_ANY_SCENE = (
    Addition("bins of direction, 16", set_on_detectors(directions=Directions(mu=16))),
    Addition("bins of direction, 16 x 32", set_on_detectors(directions=FINE_DIRECTIONS)),
    Addition("bins of position, 16 x 16", set_on_detectors(positions=Positions(u=16, v=16))),
    Addition("filter by crossed surface (via)", scene_change(_with_via)),
    Addition("filter by events (events=0)", set_on_detectors(events=0)),
    Addition("moments of velocity", set_on_detectors(moments=True)),
    Addition("path lengths in the surrounding medium", scene_change(_with_path_lengths)),
    Addition(CLOCK, scene_change(_with_duration)),
    Addition("... bins of time, 16", set_on_detectors(times=16), CLOCK),
    Addition(
        "... phase space at an instant",
        add_detector(_phase_space),
        CLOCK,
    ),
    Addition(
        "... a snapshot",
        add_detector(_snapshot),
        CLOCK,
    ),
    Addition("a volume detector", _add_volume_detector()),
    Addition("a volume detector of 8 x 8 x 8 cells", _add_volume_detector(cells=(8, 8, 8))),
    Addition("absorption", fill_with_medium(absorption=0.5)),
    Addition("scattering", fill_with_medium(scattering=0.5)),
    Addition(FOG, fill_with_medium(absorption=0.1, scattering=0.5)),
    Addition("... analog absorption", change_tracking(absorption="analog"), FOG),
    Addition("... Henyey-Greenstein, g = 0.8", change_medium(phase=HenyeyGreenstein(0.8)), FOG),
    Addition("... Rayleigh", change_medium(phase=Rayleigh()), FOG),
    Addition("... a tabulated phase function", change_medium(phase=PHASE_TABLE), FOG),
    Addition("... forced first collisions", change_tracking(forced=True), FOG),
    Addition("... splitting", _with_splitting, FOG),
    Addition("... a volume detector, collision estimator", _add_volume_detector(estimator="collision"), FOG),
    Addition("... a volume detector", _add_volume_detector(), FOG),
    Addition("... estimator expected", change_method(estimator="expected"), FOG),
    Addition("estimator aimed", change_method(estimator="aimed")),
    Addition("estimator expected", change_method(estimator="expected")),
    Addition("estimator backward", change_method(estimator="backward")),
    Addition("guided births", change_method(guide=1)),
    Addition("sampling stratified", change_method(sampling="stratified")),
    Addition("sampling sobol", change_method(sampling="sobol")),
)


DIFFUSE, WITH_BALL, WITH_FOG_BOX = Diffuse(0.5), "a ball", "a box of fog"
BACKWARD, WITH_CAMERA = "estimator backward", "... a camera of 16 x 16 pixels"
LENSES = {
    "fisheye": {},
    "equal-area fisheye": {},
    "orthographic": {"width": 1.0},
    "thin lens": {"aperture": 0.1, "focal_length": 0.2, "focus": 1.5},
}
PROJECTIONS = {
    "latitude-longitude": {"theta": 16, "phi": 16},
    "cylinder": {"theta": 16, "phi": 16},
    "cube": {"pixels": 7},
    "fisheye": {"pixels": 18},
    "equal-area fisheye": {"pixels": 18},
    "mirrored ball": {"pixels": 18},
}
PLANES = {"distance": 1.5, "size": (0.1, 0.1), "far_size": (1.0, 1.0), "views": (2, 2), "pixels": (8, 8)}
WITH_GAS, WITH_BLACK_WALLS = "... a Maxwellian gas", "black walls"
IN_THE_ROOM = (
    Addition("a source aimed at a disk", set_on_each("sources", aim=TILE)),
    Addition(WITH_GAS, set_on_each("sources", emission=Effusive(exitance=1.0, speed=GAS)), CLOCK),
    Addition(
        "... ... bins of speed, 8", set_on_detectors(speeds=tuple(np.linspace(1.0, 1801.0, 9))), WITH_GAS
    ),
    Addition("... ... thermal walls", set_on_each("surfaces", material=Diffuse(0.5, speed=GAS)), WITH_GAS),
    Addition("... a pulse", set_on_each("sources", pulse=BoxPulse(0.0, 1.0)), CLOCK),
    Addition(WITH_BLACK_WALLS, set_on_each("surfaces", material=Black())),
    Addition("... estimator aimed", change_method(estimator="aimed"), WITH_BLACK_WALLS),
    Addition("a disk", add_surfaces(Surface(TILE, DIFFUSE))),
    Addition(
        "a triangle",
        add_surfaces(Surface(Triangle(vertices=((0, 0, 0), (0.5, 0, 0), (0, 0.5, 0.3))), DIFFUSE)),
    ),
    Addition(
        "a rectangle with a hole",
        add_surfaces(Surface(Rectangle(width=0.6, height=0.6, hole=Disk(radius=0.2)), DIFFUSE)),
    ),
    Addition("a box on a wall", add_surfaces(Surface(Box(center=(0.5, 0.5, -0.8), size=0.4), DIFFUSE))),
    Addition("a cylinder", add_surfaces(Surface(Cylinder(radius=0.3, height=0.6), DIFFUSE))),
    Addition("a cone", add_surfaces(Surface(Cone(radius=0.3, height=0.6), DIFFUSE))),
    Addition("a paraboloid", add_surfaces(Surface(Paraboloid(focal_length=0.2, radius=0.3), DIFFUSE))),
    Addition("a mesh of 1280 triangles", add_surfaces(Surface(Mesh.sphere(radius=0.3), DIFFUSE))),
    Addition(WITH_BALL, add_surfaces(Surface(BALL, DIFFUSE))),
    Addition("... black", _last_material(Black()), WITH_BALL),
    Addition("... a mirror", _last_material(Mirror(0.9)), WITH_BALL),
    Addition("... a half-transparent mirror", _last_material(Mirror(0.5, 0.5)), WITH_BALL),
    Addition("... diffuse with transmission", _last_material(Diffuse(0.3, 0.3)), WITH_BALL),
    Addition("... of glass", _last_material(Dielectric(1.5)), WITH_BALL),
    Addition("... glossy", _last_material(Glossy(0.3, 0.9)), WITH_BALL),
    Addition("... ... estimator expected", change_method(estimator="expected"), "... glossy"),
    Addition("... a mixture", _last_material(Mixture({Mirror(): 0.5, Diffuse(0.5): 0.5})), WITH_BALL),
    Addition("... a two-sided material", _last_material(TwoSided(Diffuse(0.5), Black())), WITH_BALL),
    Addition("... a thin lens", _last_material(ThinLens(0.5)), "a disk"),
    Addition("a detector on a separate disk", _add_detectors(Detector(TILE, "tile"))),
    Addition("a detector on the source", _add_detectors(Detector("+z", "lamp", side="back"))),
    Addition(
        "a detector on a window in front of the source",
        _add_detectors(Detector(Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=1, height=1), "window")),
    ),
    Addition(WITH_FOG_BOX, add_surfaces(_filled_box(Medium(0.1, 0.5)))),
    Addition("... of 8 x 8 x 8 voxels", _replace_last(lambda _: _filled_box(VOXEL_GRID)), WITH_FOG_BOX),
    Addition(
        "... with emission",
        _replace_last(lambda _: _filled_box(GLOWING_FOG)),
        WITH_FOG_BOX,
    ),
    Addition("a point detector", add_detector(lambda scene: PointDetector((0.2, 0.1, 0.0), "point"))),
    Addition(
        "... a point detector", add_detector(lambda scene: PointDetector((0.2, 0.1, 0.0), "point")), FOG
    ),
    Addition(WITH_CAMERA, _with_view(Camera, pixels=(16, 16)), BACKWARD),
    *(
        Addition(
            f"... a camera with the lens {lens!r}",
            _with_view(Camera, lens=lens, pixels=(16, 16), **how),
            BACKWARD,
        )
        for lens, how in LENSES.items()
    ),
    *(
        Addition(
            f"... a map as {projection!r}", _with_view(EnvironmentMap, projection=projection, **how), BACKWARD
        )
        for projection, how in PROJECTIONS.items()
    ),
    Addition("... a light field of 2 x 2 x 8 x 8 cells", _with_view(LightField, **PLANES), BACKWARD),
    Addition("... ... and a ball of glass", add_surfaces(Surface(BALL, Dielectric(1.5))), WITH_CAMERA),
)
ADDITIONS = {each.name: each for each in (*IN_ANY_SCENE, *IN_THE_ROOM)}


def with_addition(name: str | None, treatment: Treatment) -> Treatment:
    """Return the treatment with this addition and those it needs.

    Raises SceneError if the scene does not allow them.
    """
    if name is None:
        return treatment
    addition = ADDITIONS[name]
    return addition.apply(with_addition(addition.over, treatment)).checked()


# ---- Price list: CPU time of a treatment without and with each addition, in turns; medians over turns.
#
# Differences and ratios are taken within a turn, so that other load of the machine affects both sides.

UNCHANGED = "unchanged"
TURNS, SECONDS = 7, 0.05  # turns of the price list, and approximate time of a run [s]
HEADS = (
    "effect~", "over~", "ns per history>", "adds ns>", "times>", "events>", "ns per event>", "passes>",
    "bytes per lane>",
)  # fmt: skip
NOTES = """CPU time per history, medians of alternating runs; an event is a crossing or a collision; an effect with
an entry under over is compared with a run that has that effect alone"""


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
    def ns_per_event(self) -> float:
        """CPU nanoseconds per crossing or collision; nan without events."""
        return self.ns / self.events if self.events else math.nan


@dataclass(frozen=True)
class PriceList:
    """Prices of additions to a treatment.

    `prices` starts with the unchanged treatment; `refused` maps the names of impossible additions to the
    reason; `idle` names additions that change nothing.
    """

    prices: tuple[Price, ...]
    refused: Mapping[str, str]
    idle: tuple[str, ...]


def prices_of(treatment: Treatment, additions: Iterable[Addition], turns: int, seconds: float) -> PriceList:
    """Measure a treatment and each addition to it, with a progress bar during compilation."""
    found, refused, idle = {UNCHANGED: (None, treatment)}, {}, []
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
    runs, overruns = _prepare(wanted, seconds)
    refused |= {name: overruns[after] for name, (_, after) in found.items() if after in overruns}
    spent = _time_turns(runs, turns)
    prices = [
        _price(name, _base_name(name, before, treatment), runs[after], spent[after], spent[before or after])
        for name, (before, after) in found.items()
        if after in runs and (before is None or before in runs)
    ]
    return PriceList(tuple(prices), refused, tuple(idle))


def _base_name(name: str, before: Treatment | None, treatment: Treatment) -> str | None:
    """Return the name of the treatment that a price is relative to: the needed addition, or UNCHANGED."""
    if before is None:
        return None
    return UNCHANGED if before == treatment else ADDITIONS[name].over


def _prepare(treatments: Iterable[Treatment], seconds: float) -> tuple[dict, dict]:
    """Compile each treatment; return the runs, and the reason for each treatment that cannot run."""
    runs, overruns = {}, {}
    with open_progress(None) as bar:
        for treatment in treatments:
            try:
                runs[treatment] = TimedRun(treatment, seconds, bar.compiling)
            except OverrunError as reason:
                overruns[treatment] = str(reason)
    return runs, overruns


def _time_turns(runs: Mapping[Treatment, TimedRun], turns: int) -> dict[Treatment, np.ndarray]:
    """Return the CPU nanoseconds per history of each treatment, shape (turns,).

    The order rotates each turn, so that no treatment always follows the most expensive one.
    """
    spent, order = {treatment: np.zeros(turns) for treatment in runs}, list(runs)
    for turn in range(turns):
        for treatment in order[turn % len(order) :] + order[: turn % len(order)]:
            spent[treatment][turn] = runs[treatment].ns(turn + 1)
    return spent


def _price(name: str, over: str | None, run: TimedRun, spent: np.ndarray, before: np.ndarray) -> Price:
    return Price(
        name,
        over,
        ns=float(np.median(spent)),
        added=float(np.median(spent - before)),
        ratio=float(np.median(spent / before)),
        events=run.events,
        passes=len(run.program.passes),
        footprint=footprint_of(run.program),
    )


def price_table(prices: Iterable[Price]) -> Table:
    """Return a table with a row per price; `over` is empty for additions to the unchanged scene."""
    rows = []
    for price in prices:
        over = "" if price.over in (None, UNCHANGED) else price.over
        added = ("", "") if price.over is None else (f"{price.added:+.3g}", f"{price.ratio:.2f}")
        each = f"{price.ns_per_event:.3g}" if price.events else "–"
        sizes = str(price.passes), str(price.footprint.touched)
        rows.append([price.name, over, f"{price.ns:.3g}", *added, f"{price.events:.3g}", each, *sizes])
    return table_of(HEADS, rows)


def first_case(sim: str) -> Treatment:
    """Return the treatment of the first case of an experiment."""
    module = experiment(sim)
    return experiment_treatment(module, scene_of(module, cases_of(module, {})[0], {}))


def main(
    sim: str = typer.Argument("", help="Experiment to add effects to [default: the base room]"),
    turns: int = TURNS,
    seconds: float = SECONDS,
    json: bool = False,
) -> None:
    """Price the effects that can be added to the base room, or to the first case of an experiment."""
    if sim:
        found = prices_of(first_case(sim), IN_ANY_SCENE, turns, seconds)
    else:
        found = prices_of(base_room(), ADDITIONS.values(), turns, seconds)
    if json:
        print_json([asdict(price) | {"ns_per_event": price.ns_per_event} for price in found.prices])
        return
    print_rich(price_table(found.prices), " ".join(NOTES.split()))
    print_rich(f"no change, present already or without effect: {', '.join(found.idle) or 'none'}")
    print_rich(f"impossible in this scene: {', '.join(found.refused) or 'none'}")


if __name__ == "__main__":
    typer.run(main)
