"""The plan of a scene: its tables in scene lengths, and properties that select the passes."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType

import numpy as np

from transport.compile import layout
from transport.compile.arena import Arena
from transport.compile.methods import ANALOG, Method
from transport.compile.rows import Rows
from transport.compile.space import Space
from transport.geometry.mesh import Mesh
from transport.geometry.shape import Shape
from transport.scene.scene import Scene
from transport.scene.scene_speeds import max_speed, needs_particle_speeds, scene_speeds
from transport.scene.sources import Source
from transport.scene.tracking import Tracking

Step = tuple[str, np.ndarray]  # name of a pass, row of its table


@dataclass(frozen=True)
class Emitter:
    """One kind of birth of particles: names of the passes, with the rows of their tables."""

    source: Source
    shape: Shape  # the piece of the source's shape that the emitter lies on or fills
    amount: float  # [J] or particles with a clock, else [W] or [s^-1]
    weight: float  # largest weight of a particle, relative to a birth without a target
    birth: np.ndarray
    place: Step
    facing: np.ndarray | None  # normal of the emitting side; None where it depends on the place
    law: Step
    moment: Step | None  # time of birth
    speed: tuple[Step, ...]  # speed at birth
    target: tuple[Step, ...] | None
    medium: np.ndarray | None  # refractive index that it emits into, where the scene has any
    inside: np.ndarray | None  # bodies that it emits into, where the scene has any
    beside: list[np.ndarray]  # boundaries of bodies on which it lies
    # for a detector that particles start at (estimator "backward"): sampling of its cells
    cells: tuple[Step, ...] = ()
    is_divided: bool = False  # whether directions are sampled within such a cell
    is_guided: bool = False  # whether births follow a learnt density (compile/guides.py)

    @property
    def weighs_births(self) -> bool:
        """Whether its particles are born with different weights."""
        return self.target is not None or self.is_guided

    @property
    def ray_densities(self) -> dict[str, float]:
        """Greatest density of directions [sr^-1] by its law; empty where no ray in any direction is cast.

        None is from births in a bin of directions, nor on the boundary of a body, where a ray would start in
        the body that the flight starts in.
        """
        return {} if self.is_divided or self.beside else self.source.emission.ray_densities

    @property
    def bound(self) -> float:
        """Return what its particles would stand for if all had the largest weight."""
        return self.amount * self.weight


@dataclass
class MeshTable:
    """A mesh as arrays; the engine sorts its facets, and adds a hierarchy and cumulative areas."""

    vertices: np.ndarray  # (n, 3) [scene lengths]
    faces: np.ndarray  # (m, 3) int32
    normals: np.ndarray  # (m, 3)
    areas: np.ndarray  # (m,) [m^2]
    center: np.ndarray  # of its bounds
    rows: list[np.ndarray] = field(default_factory=list)  # rows that refer to these arrays
    nodes: np.ndarray | None = None
    leaves: np.ndarray | None = None
    margin: float = 0.0
    shares: np.ndarray | None = None

    def place(self, arena: Arena) -> None:
        """Place the arrays, and write their offsets and lengths into the rows."""
        for row in self.rows:
            for name in ("vertices", "faces", "normals", "nodes", "leaves", "shares"):
                if name in row.dtype.names and getattr(self, name) is not None:
                    row[name] = arena.place(getattr(self, name))
            counts = {"vertex_count": self.vertices, "facet_count": self.faces, "node_count": self.nodes}
            if "margin" in row.dtype.names:
                row["margin"] = self.margin
            for name, counted in counts.items():
                if name in row.dtype.names and counted is not None:
                    row[name] = len(counted)


def _read_only(value: object) -> object:
    """Return a table or a collection of a plan that cannot be changed."""
    match value:
        case np.ndarray():
            value.flags.writeable = False
        case list():
            return tuple(value)
        case set():
            return frozenset(value)
        case dict():
            return MappingProxyType(value)
    return value


@dataclass
class Plan:
    """All data about a scene that the engine needs: assembled once by `compiler`, read-only afterwards."""

    scene: Scene
    space: Space
    tracking: Tracking
    method: Method = ANALOG
    emitters: list[Emitter] = field(default_factory=list)
    # Shape rows: name of the pass, such as "meet_disk", its row, its shape.
    members: list[tuple[str, np.ndarray, Shape]] = field(default_factory=list)
    # surfaces that cut or touch the interior of another
    contacts: list[np.ndarray] = field(default_factory=list)
    sheets: np.ndarray = None
    surfaces: np.ndarray = None
    optics: np.ndarray = None  # same rows as `surfaces`
    albedo_laws: set[str] = field(default_factory=set)  # of materials whose albedo depends on the direction
    rims: np.ndarray = None
    curved_sheets: np.ndarray = None  # same rows as `sheets`
    meshed_sheets: list[np.ndarray] = field(default_factory=list)  # one row per sheet
    meshes: dict[Mesh, MeshTable] = field(default_factory=dict)
    layers: list[np.ndarray] = field(default_factory=list)
    detectors: np.ndarray = None
    rows: int = 1  # number of rows of sums; row 0 belongs to no detector
    rows_of: dict[str, Rows] = field(default_factory=dict)  # rows of each tally; of a detector its arrivals
    absorbed_rows_of: dict[str, Rows] = field(default_factory=dict)  # absorbed weight in cells of volumes
    half: int = 1  # number of rows from a detector's arrivals to its departures
    # Index in scene.surfaces of each row of `surfaces` after the first.
    surface_numbers: list[int] = field(default_factory=list)
    axes: set[str] = field(default_factory=set)  # kinds of finer bins in use: "time", "cosine", ...
    # Subset of "visits", "reflections": conditions of detectors on a particle's path.
    filters: set[str] = field(default_factory=set)
    # Bit of each detector or surface named in a `via`.
    marks: dict[str, int] = field(default_factory=dict)
    long_scores: list = field(default_factory=list)  # the compile.detectors.LongScores that detectors ask for
    phase_spaces: list[np.ndarray] = field(default_factory=list)  # one row per time
    snapshots: list[np.ndarray] = field(default_factory=list)
    first_long_rows: dict[str, int] = field(default_factory=dict)  # first long row of each PhaseSpace
    long_rows: int = 0  # rows of four limbs: long scores of detectors, then moments of phase spaces
    max_path_segments: int = 0  # number of path segments to record for a picture; 0: none
    volumes: list = field(default_factory=list)  # one compile.volumes.Volume per volume detector
    # one compile.points.PointPlan per point detector, or per source that rays of a backward run end at
    points: list = field(default_factory=list)
    # One next_event.Expectation per detector that events send shadow rays to.
    expectations: list = field(default_factory=list)
    links: np.ndarray | None = None  # layout.LINK by row of surfaces, where shadow rays pass them
    # One next_event.Guard per such detector that specular surfaces may send light to.
    guards: list = field(default_factory=list)
    # like `layers`, for shadow rays to these detectors
    expected_layers: list[np.ndarray] = field(default_factory=list)
    # names of the detectors in the rows of `detectors`
    detector_names: list[str] = field(default_factory=list)
    # by row of a detector, where its histogram cells of score sizes begin
    size_numbers: np.ndarray | None = None
    # By detector and side (0: arrivals), where its cells of score sizes begin; for an expected detector, then
    # those of shadow rays.
    size_blocks: dict[tuple[str, int], list[int]] = field(default_factory=dict)
    size_cells: int = 0
    adjoint: object = None  # an adjoint.Adjoint in the plan of an adjoint scene
    has_media: bool = False
    bodies: tuple = ()  # of the scene, innermost first
    distinct_media: tuple = ()
    media: np.ndarray | None = None  # by body (layout.MEDIA)
    phase_laws: list[tuple[str, np.ndarray]] = field(default_factory=list)  # ("scatter_...", its row)
    # Number of each phase function; of a mixture, that of its first part.
    phase_numbers: dict[object, int] = field(default_factory=dict)
    # layout.GRID of bodies of voxels where particles collide.
    grids: list[np.ndarray] = field(default_factory=list)
    absorbing_grids: list[np.ndarray] = field(default_factory=list)  # grids that only reduce weights
    arena: Arena = field(default_factory=Arena)  # arrays that tables refer to, and the tables of steps

    def freeze(self) -> None:
        """Let nothing change the plan any more: plans are shared between runs.

        Arrays reject writes, lists become tuples, sets and mappings are read-only. Only the arena still
        grows: a program places the tables of its steps there.
        """
        for name, value in list(vars(self).items()):
            setattr(self, name, _read_only(value))
        vars(self)["is_frozen"] = True

    def apart(self) -> Plan:
        """Return the same plan with an arena of its own, for a program of one run."""
        other = copy.copy(self)
        vars(other)["arena"] = self.arena.copy()
        return other

    def __getstate__(self) -> dict:
        return {name: dict(v) if isinstance(v, MappingProxyType) else v for name, v in vars(self).items()}

    def __setstate__(self, state: dict) -> None:
        vars(self).update({name: _read_only(value) for name, value in state.items()})

    def __setattr__(self, name: str, value: object) -> None:
        if vars(self).get("is_frozen"):
            raise AttributeError(f"a plan is read-only once it is assembled, so {name} cannot be set")
        super().__setattr__(name, value)

    def add_rows(self, name: str, rows: Rows) -> Rows:
        """Add the rows of a tally, which begin after all rows before, and return them."""
        self.rows_of[name], self.rows = rows, rows.past
        return rows

    @cached_property
    def first_detector_rows(self) -> np.ndarray:
        """Return the first row of each detector on a shape or surface, in the order of the scene."""
        return np.array([self.rows_of[detector.name].base for detector in self.scene.meters], np.intp)

    @cached_property
    def rows_of_surfaces(self) -> dict[int, list[int]]:
        """Return the places in `surface_numbers` of each acting surface, by its index in the scene."""
        rows: dict[int, list[int]] = {}
        for row, number in enumerate(self.surface_numbers):
            rows.setdefault(number, []).append(row)
        return rows

    @property
    def targets(self) -> list:
        """What events send shadow rays to: detectors, or sources of a backward run."""
        return [*self.points, *self.expectations]

    @property
    def is_guided(self) -> bool:
        """Whether births follow a learnt density."""
        return any(emitter.is_guided for emitter in self.emitters)

    @property
    def sends_shadow_rays(self) -> bool:
        """Whether events send shadow rays to detectors."""
        return self.method.estimator in ("expected", "backward")

    @property
    def has_clock(self) -> bool:
        """Whether the scene has a duration, so that particles carry a time."""
        return self.scene.duration is not None

    @property
    def time_unit(self) -> float:
        """Return the unit of time [s]: the duration, or 1 s without a clock."""
        return self.scene.duration if self.has_clock else 1.0

    @property
    def speed_unit(self) -> float:
        """Return the unit of speed [m/s]: a scene length per unit of time."""
        return self.space.size / self.time_unit

    @property
    def units(self) -> dict[str, float]:
        """Return the size of the units of the engine, by SI unit."""
        return {"m": self.space.size, "s": self.time_unit, "m s^-1": self.speed_unit}

    @cached_property
    def has_speeds(self) -> bool:
        """Whether particles carry speeds.

        They do where speeds differ and a clock runs, or where a detector measures speeds.
        """
        return needs_particle_speeds(self.scene)

    @cached_property
    def slowness(self) -> float:
        """Return 1/speed of all particles [durations per scene length]; 0 where speeds differ."""
        speeds = scene_speeds(self.scene)
        speed = speeds.pop() if len(speeds) == 1 else None
        if self.has_speeds or not isinstance(speed, float):
            return 0.0
        scaled = speed / self.speed_unit
        return 1.0 / scaled if scaled > 0 else math.inf

    @cached_property
    def fastest(self) -> float:
        """Return an upper bound of all speeds [m/s]."""
        return max(max_speed(speed) for speed in scene_speeds(self.scene))

    @property
    def scatters(self) -> bool:
        """Whether media collide: they scatter, or absorb analog."""
        return self.has_media and (bool((self.media["mfp"] < math.inf).any()) or bool(self.grids))

    @property
    def attenuates(self) -> bool:
        """Whether media reduce weights along the path."""
        return self.has_media and bool((self.media["sigma_a"] > 0).any())

    @property
    def absorbs_analog(self) -> bool:
        """Whether a collision in some medium may end a particle."""
        return self.scatters and bool((self.media["survival"] < 1).any())

    @property
    def absorbs_weighted(self) -> bool:
        """Whether collisions in grids reduce weights."""
        is_analog = self.tracking.absorption == "analog"
        return not is_analog and any(row["absorbs"] for row in self.grids)

    @property
    def has_roulette_in_flight(self) -> bool:
        """Whether weights reduced by media are subject to Russian roulette at collisions."""
        return self.scatters and self.reduces_weights and not self.splits

    @property
    def reduces_weights(self) -> bool:
        """Whether media reduce weights, along the path or at collisions."""
        return self.attenuates or self.absorbs_weighted or bool(self.absorbing_grids)

    @property
    def has_bodies(self) -> bool:
        """Whether particles must track which bodies they are in."""
        return self.has_media and len(self.media) > 1

    @property
    def can_escape_at_once(self) -> bool:
        """Whether a particle that leaves towards an empty side escapes without another flight."""
        is_empty = self.has_media and self.media["mfp"][0] == math.inf and self.media["sigma_a"][0] == 0
        is_unseen = not self.scene.volumes and not self.max_path_segments
        return is_empty and self.scatters and not self.has_clock and is_unseen

    @property
    def bounds_bodies(self) -> bool:
        """Whether crossing some surface may lead into another body."""
        return self.has_bodies and any((rows["front"] != rows["back"]).any() for rows in self.layers)

    @property
    def media_rows(self) -> int:
        """Return the number of ledger rows for absorption in media, after those of surfaces."""
        return len(self.media) if self.has_media else 0

    @property
    def absorbing_media(self) -> list[int]:
        """Return the rows of `media` that absorb."""
        if not self.has_media:
            return []
        absorbs = (self.media["sigma_a"] > 0) | (
            (self.media["mfp"] < math.inf) & (self.media["survival"] < 1)
        )
        absorbs[[row["medium"] for row in (*self.grids, *self.absorbing_grids) if row["absorbs"]]] = True
        return np.flatnonzero(absorbs).tolist()

    @property
    def counts_reflections(self) -> bool:
        """Whether some detector filters particles by their number of reflections."""
        return "reflections" in self.filters

    @property
    def has_mixtures(self) -> bool:
        """Whether some surface has a mixture of materials."""
        return bool((self.surfaces["parts"] > 1).any())

    @property
    def selects_material(self) -> bool:
        """Whether the acting material depends on the side or on chance."""
        return self.has_mixtures or bool((self.surfaces["back"] != 0).any())

    @property
    def transmits(self) -> bool:
        """Whether a surface transmits a share, diffusely or straight."""
        return bool((self.optics["through"] > 0).any())

    @property
    def has_optics(self) -> bool:
        """Whether lanes need refractive indices, roughness or transmitted shares."""
        return self.transmits or bool({layout.DIELECTRIC, layout.GLOSSY} & self.materials)

    @property
    def has_quadrics(self) -> bool:
        """Whether some sheet is a quadric."""
        return bool((self.curved_sheets["is_curved"] != 0).any())

    @property
    def has_rims(self) -> bool:
        """Whether points within rounding of an edge are clamped inside it on some surface."""
        return bool((self.rims["form"] != 0).any())

    @property
    def has_thermal_walls(self) -> bool:
        """Whether some wall gives particles a speed from its own distribution."""
        return self.has_speeds and bool((self.surfaces["quantiles"] != 0).any())

    @property
    def connects_gloss(self) -> bool:
        """Whether glossy surfaces send next-event rays."""
        return bool(self.expectations) and bool((self.optics["lobe_peak"] > 0).any())

    @property
    def needs_more_random_numbers(self) -> bool:
        """Whether some surface needs a second block of random numbers per crossing."""
        return self.has_mixtures or self.has_thermal_walls or layout.GLOSSY in self.materials

    @property
    def is_curved(self) -> bool:
        """Whether some sheet is curved."""
        return bool((self.sheets["curvature"] != 0).any())

    @property
    def has_acting_surfaces(self) -> bool:
        """Whether some surface acts on particles."""
        return len(self.surfaces) > 1

    @property
    def crosses_detectors(self) -> bool:
        """Whether rays go on through detectors, to other sheets or to the same mesh or quadric."""
        passes = [name for name, *_ in self.members if name.startswith(("cover", "bound"))]
        return bool(passes) and (len(self.sheets) > 2 or bool({"cover_mesh", "cover_quadric"} & set(passes)))

    @property
    def materials(self) -> set[int]:
        """Return the codes of all materials in the scene (compile/layout.py)."""
        return set(self.surfaces["material"].tolist())

    @property
    def absorbs(self) -> bool:
        """Whether some surface absorbs."""
        return bool((self.surfaces["albedo"] < 1).any())

    @property
    def reflects(self) -> bool:
        """Whether some surface sends particles on."""
        return bool((self.surfaces["albedo"][1:] > 0).any())

    @property
    def has_roulette(self) -> bool:
        """Whether a particle can go on from a surface at a fraction of its weight."""
        is_grey = bool(((self.surfaces["albedo"] > 0) & (self.surfaces["albedo"] < 1)).any())
        return (
            is_grey or ((self.reduces_weights or self.forces_collisions) and self.reflects)
        ) and not self.splits

    @property
    def splits(self) -> bool:
        """Whether particles are split in media."""
        return self.scatters and self.tracking.splitting is not None

    @property
    def forces_collisions(self) -> bool:
        """Whether first collisions in media are forced."""
        return self.scatters and self.tracking.forced

    @property
    def plays_roulette(self) -> bool:
        """Whether Russian roulette may change a weight, at surfaces or in media."""
        return self.has_roulette or self.has_roulette_in_flight or self.splits or self.forces_collisions

    @property
    def needs_random_numbers(self) -> bool:
        """Whether crossings need random numbers."""
        is_chancy = bool({layout.DIFFUSE, layout.DIELECTRIC} & self.materials)
        return self.has_roulette or self.needs_more_random_numbers or is_chancy or self.transmits

    @property
    def long_sums(self) -> tuple[str, ...]:
        """Names of the long sums of each row of a detector, as they lie next to each other."""
        return tuple(name for score in self.long_scores for name in score.sums)

    @property
    def unit(self) -> float:
        """Return what all particles of a run stand for at weight 1.

        [J] or particles with a clock, else [W] or [s^-1].
        """
        return math.fsum(emitter.bound for emitter in self.emitters)
