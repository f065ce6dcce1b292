"""The plan of a scene: tables in scene lengths for just the steps that it calls for, and what it calls for."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from transport.compile import layout
from transport.compile.space import Space
from transport.estimators.methods import ANALOG, Method
from transport.scene import Scene
from transport.scene_speeds import fastest_of, scene_has_speeds, scene_speeds
from transport.shapes import Mesh, Shape
from transport.sources import Source
from transport.tracking import Tracking

Step = tuple[str, np.ndarray]  # name of a pass, row of its table


@dataclass(frozen=True)
class Emitter:
    """Names of passes, with the rows of their tables."""

    source: Source
    shape: Shape  # the piece of the source's shape that it lies on or fills
    amount: float  # [J] or particles with a clock, else [W] or [s^-1]
    weight: float  # largest weight of a history, relative to one that is not aimed
    birth: np.ndarray
    place: Step
    facing: np.ndarray | None  # the normal of the side that emits; None where places have one each
    law: Step
    moment: Step | None  # when
    speed: tuple[Step, ...]  # how fast
    target: tuple[Step, ...] | None
    medium: np.ndarray | None  # the refractive index that it emits into, where the scene has any
    inside: np.ndarray | None  # the bodies that it emits into, where the scene has any
    beside: list[np.ndarray]  # boundaries of bodies on which it lies
    cells: tuple[Step, ...] = ()  # of a detector that histories start at: how they are dealt to its cells

    @property
    def bound(self) -> float:
        """What its histories would stand for if all were born at the largest weight."""
        return self.amount * self.weight


@dataclass
class MeshTable:
    """A mesh as arrays; the engine puts its facets in order, and adds the nodes of a hierarchy and the shares of area."""

    vertices: np.ndarray  # (n, 3)
    faces: np.ndarray  # (m, 3) int32
    normals: np.ndarray  # (m, 3)
    areas: np.ndarray  # (m,) [m^2]
    center: np.ndarray  # of its bounds
    rows: list[np.ndarray] = field(default_factory=list)  # that point to all these
    nodes: np.ndarray | None = None
    shares: np.ndarray | None = None

    def point(self) -> None:
        """Tell the rows where the arrays are."""
        for row in self.rows:
            for name in ("vertices", "faces", "normals", "nodes", "shares"):
                if name in row.dtype.names and getattr(self, name) is not None:
                    row[name] = getattr(self, name).ctypes.data
            counts = {"vertex_count": self.vertices, "facet_count": self.faces, "node_count": self.nodes}
            for name, counted in counts.items():
                if name in row.dtype.names and counted is not None:
                    row[name] = len(counted)


@dataclass
class Plan:
    """All that the engine needs to know of a scene."""

    scene: Scene
    space: Space
    tracking: Tracking
    method: Method = ANALOG
    emitters: list[Emitter] = field(default_factory=list)
    members: list[tuple[str, np.ndarray, Shape]] = field(
        default_factory=list
    )  # ("meet_disk", its row, its shape)
    contacts: list[np.ndarray] = field(default_factory=list)  # surfaces that cut or touch one another inside
    sheets: np.ndarray = None
    surfaces: np.ndarray = None
    optics: np.ndarray = None  # of the same rows as `surfaces`
    rims: np.ndarray = None
    curved_sheets: np.ndarray = None  # of the same rows as `sheets`
    meshed_sheets: np.ndarray = None
    meshes: dict[Mesh, MeshTable] = field(default_factory=dict)
    layers: list[np.ndarray] = field(default_factory=list)
    meters: np.ndarray = None
    bases: dict[str, int] = field(default_factory=dict)  # first row of each detector
    half: int = 1  # rows from a detector's arrivals to its departures
    owners: list[int] = field(
        default_factory=list
    )  # index in scene.surfaces of each row of `surfaces` after the first
    axes: set[str] = field(default_factory=set)  # of program.REFINEMENTS: the finer bins called for
    filters: set[str] = field(
        default_factory=set
    )  # of "visits", "reflections": what detectors ask of a history
    marks: dict[str, int] = field(
        default_factory=dict
    )  # the bit of each detector or surface named in a `via`
    moments: np.ndarray | None = None  # the extreme speeds, where a detector takes moments
    phase_spaces: list[np.ndarray] = field(default_factory=list)  # a row for each instant
    snapshots: list[np.ndarray] = field(default_factory=list)
    long_bases: dict[str, int] = field(default_factory=dict)  # first long row of each PhaseSpace
    long_rows: int = 0  # rows of four limbs: a meter's moments, then those of phase space
    ways_room: int = 0  # how many ways are written down for a picture; 0: none
    volumes: list = field(default_factory=list)  # a compile.volumes.Volume for each volume detector
    volume_rows: int = 0  # of their sums, behind those of phase space
    points: list = field(default_factory=list)  # a compile.points.PointPlan for each point detector
    point_rows: int = 0  # of their sums, behind those of the volumes
    expectations: list = field(
        default_factory=list
    )  # a compile.expected.Expectation for each detector that events tell what they send it
    guards: list = field(
        default_factory=list
    )  # a compile.expected.Guard for each of them that mirrors may send light to
    expected_layers: list[np.ndarray] = field(default_factory=list)  # as `layers`, of rays to these detectors
    meter_names: list[str] = field(default_factory=list)  # of the detectors of the rows of `meters`
    size_numbers: np.ndarray | None = None  # by row of a meter, where its cells of sizes begin, if it has any
    size_blocks: dict[tuple[str, int], list[int]] = field(
        default_factory=dict
    )  # where those of a detector and side (0: arrivals) begin; where it expects, then those of what events tell it
    size_cells: int = 0
    turned: object = None  # a compile.adjoint.Turned, where it is of a scene that is run backwards
    cell_rows: int = 0  # of sums by cell of birth, behind all others
    has_media: bool = False
    bodies: tuple = ()  # of scene.bodies, innermost first
    distinct_media: tuple = ()
    media: np.ndarray | None = None  # by body (layout.MEDIA)
    phase_laws: list[tuple[str, np.ndarray]] = field(default_factory=list)  # ("scatter_...", its row)
    phase_numbers: dict[object, int] = field(
        default_factory=dict
    )  # of a phase function, or the first of a mixture's
    grids: list[np.ndarray] = field(
        default_factory=list
    )  # layout.GRID of bodies of voxels where flights collide
    thinning_grids: list[np.ndarray] = field(default_factory=list)  # and of those that only lessen weights
    kept: list[np.ndarray] = field(default_factory=list)  # alive: the tables hold their addresses

    @property
    def expects(self) -> bool:
        """Whether events tell detectors what they send there."""
        return self.method.estimator in ("expected", "backward")

    @property
    def has_clock(self) -> bool:
        return self.scene.duration is not None

    @property
    def tempo(self) -> float:
        """The unit of time [s]: the duration, or a second where there is no clock."""
        return self.scene.duration if self.has_clock else 1.0

    @property
    def speed_unit(self) -> float:
        """The unit of speed [m/s]: a scene length in a unit of time."""
        return self.space.size / self.tempo

    @cached_property
    def has_speeds(self) -> bool:
        """Whether particles carry speeds: where these differ and a clock runs, or where something looks at them."""
        return scene_has_speeds(self.scene)

    @cached_property
    def slowness(self) -> float:
        """One over the speed that all have [durations per scene length]; 0 where speeds differ."""
        speeds = scene_speeds(self.scene)
        speed = speeds.pop() if len(speeds) == 1 else None
        if self.has_speeds or not isinstance(speed, float):
            return 0.0
        scaled = speed / self.speed_unit
        return 1.0 / scaled if scaled > 0 else math.inf

    @cached_property
    def fastest(self) -> float:
        """A bound of all speeds [m/s]."""
        return max(fastest_of(speed) for speed in scene_speeds(self.scene))

    @property
    def scatters(self) -> bool:
        """Whether anything happens in a medium that has to be drawn: scattering, or absorption by chance."""
        return self.has_media and (bool((self.media["mfp"] < math.inf).any()) or bool(self.grids))

    @property
    def attenuates(self) -> bool:
        """Whether media lessen weights along the way."""
        return self.has_media and bool((self.media["sigma_a"] > 0).any())

    @property
    def absorbs_by_chance(self) -> bool:
        return self.scatters and bool((self.media["survival"] < 1).any())

    @property
    def absorbs_by_share(self) -> bool:
        """Whether collisions in grids lessen weights."""
        is_analog = self.tracking.absorption == "analog"
        return not is_analog and any(row["absorbs"] for row in self.grids)

    @property
    def has_roulette_in_flight(self) -> bool:
        return self.scatters and self.lessens and not self.splits

    @property
    def lessens(self) -> bool:
        """Whether flights through media lessen weights, along the way or at collisions."""
        return self.attenuates or self.absorbs_by_share or bool(self.thinning_grids)

    @property
    def has_bodies(self) -> bool:
        """Whether particles must know where they are."""
        return self.has_media and len(self.media) > 1

    @property
    def can_escape_at_once(self) -> bool:
        """Whether what leaves to where nothing is need not fly to find that out."""
        is_empty = self.has_media and self.media["mfp"][0] == math.inf and self.media["sigma_a"][0] == 0
        is_unseen = not self.scene.volumes and not self.ways_room
        return is_empty and self.scatters and not self.has_clock and is_unseen

    @property
    def bounds_bodies(self) -> bool:
        return self.has_bodies and any((rows["front"] != rows["back"]).any() for rows in self.layers)

    @property
    def media_rows(self) -> int:
        """Rows of the ledger for what media absorb, behind those of the surfaces."""
        return len(self.media) if self.has_media else 0

    @property
    def absorbing_media(self) -> list[int]:
        """The rows of `media` that absorb."""
        if not self.has_media:
            return []
        absorbs = (self.media["sigma_a"] > 0) | (
            (self.media["mfp"] < math.inf) & (self.media["survival"] < 1)
        )
        absorbs[[row["medium"] for row in (*self.grids, *self.thinning_grids) if row["absorbs"]]] = True
        return np.flatnonzero(absorbs).tolist()

    @property
    def counts_reflections(self) -> bool:
        return "reflections" in self.filters

    @property
    def has_mixtures(self) -> bool:
        return bool((self.surfaces["parts"] > 1).any())

    @property
    def chooses(self) -> bool:
        """Whether what acts depends on the side or on chance."""
        return self.has_mixtures or bool((self.surfaces["back"] != 0).any())

    @property
    def transmits(self) -> bool:
        """Whether a share passes diffusely or straight."""
        return bool((self.optics["through"] > 0).any())

    @property
    def has_optics(self) -> bool:
        """Whether lanes must know indices, roughness or what passes."""
        return self.transmits or bool({layout.DIELECTRIC, layout.GLOSSY} & self.materials)

    @property
    def has_quadrics(self) -> bool:
        return bool((self.curved_sheets["is_curved"] != 0).any())

    @property
    def has_rims(self) -> bool:
        return bool((self.rims["form"] != 0).any())

    @property
    def has_thermal_walls(self) -> bool:
        return self.has_speeds and bool((self.surfaces["quantiles"] != 0).any())

    @property
    def draws_again(self) -> bool:
        return self.has_mixtures or self.has_thermal_walls or layout.GLOSSY in self.materials

    @property
    def is_curved(self) -> bool:
        return bool((self.sheets["curvature"] != 0).any())

    @property
    def acts(self) -> bool:
        return len(self.surfaces) > 1

    @property
    def passes_meters(self) -> bool:
        """Whether rays go on through meters to other sheets, or through a mesh and on through it."""
        meters = [name for name, *_ in self.members if name.startswith(("cover", "bound"))]
        return bool(meters) and (len(self.sheets) > 2 or bool({"cover_mesh", "cover_quadric"} & set(meters)))

    @property
    def materials(self) -> set[int]:
        return set(self.surfaces["material"].tolist())

    @property
    def absorbs(self) -> bool:
        return bool((self.surfaces["albedo"] < 1).any())

    @property
    def reflects(self) -> bool:
        return bool((self.surfaces["albedo"][1:] > 0).any())

    @property
    def has_roulette(self) -> bool:
        """Whether a particle can go on at a fraction of its weight."""
        is_grey = bool(((self.surfaces["albedo"] > 0) & (self.surfaces["albedo"] < 1)).any())
        return (is_grey or ((self.lessens or self.forces) and self.reflects)) and not self.splits

    @property
    def splits(self) -> bool:
        return self.scatters and self.tracking.splitting is not None

    @property
    def forces(self) -> bool:
        return self.scatters and self.tracking.forced

    @property
    def plays_roulette(self) -> bool:
        return self.has_roulette or self.has_roulette_in_flight or self.splits or self.forces

    @property
    def draws(self) -> bool:
        """Whether crossings need random numbers."""
        is_chancy = bool({layout.DIFFUSE, layout.DIELECTRIC} & self.materials)
        return self.has_roulette or self.draws_again or is_chancy or self.transmits

    @property
    def rows(self) -> int:
        """Rows of sums: the meters' arrivals, their departures, both as expected, phase space, volumes, points."""
        return (
            2 * self.half * (2 if self.expects else 1)
            + self.volume_rows
            + self.point_rows
            + self.cell_rows
            + sum(1 + int(row["a_cells"] * max(1, row["b_cells"])) for row in self.phase_spaces)
        )

    @property
    def unit(self) -> float:
        """What all histories of a run stand for at the weight 1: [J] or particles with a clock, else [W] or [s^-1]."""
        return math.fsum(emitter.bound for emitter in self.emitters)
