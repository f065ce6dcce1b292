"""The plan of a scene: tables in scene lengths for just the steps that it calls for, and what it calls for."""

import math
from dataclasses import dataclass, field

import numpy as np

from transport import layout
from transport.emitters import Emitter
from transport.scene import Scene
from transport.shapes import Shape
from transport.space import Space


@dataclass
class Plan:
    """All that the engine needs to know of a scene."""

    scene: Scene
    space: Space
    emitters: list[Emitter]
    members: list[tuple[str, np.ndarray, Shape]] = field(
        default_factory=list
    )  # ("meet_disk", its row, its shape)
    crossings: list[np.ndarray] = field(default_factory=list)  # surfaces that cut or touch one another inside
    sheets: np.ndarray = None
    surfaces: np.ndarray = None
    walls: np.ndarray = None
    layers: list[np.ndarray] = field(default_factory=list)
    meters: np.ndarray = None
    bases: dict[str, int] = field(default_factory=dict)  # first row of each detector
    half: int = 1  # rows from a detector's arrivals to its departures
    owners: list[int] = field(
        default_factory=list
    )  # index in scene.surfaces of each row of `surfaces` after the first
    axes: set[str] = field(default_factory=set)  # of "cosine", "azimuth", "place": the finer bins called for
    edges: list[np.ndarray] = field(default_factory=list)  # kept alive: the meters' rows hold their addresses

    @property
    def has_clock(self) -> bool:
        return self.scene.duration is not None

    @property
    def is_curved(self) -> bool:
        return bool((self.sheets["curvature"] != 0).any())

    @property
    def acts(self) -> bool:
        return len(self.surfaces) > 1

    @property
    def has_walls(self) -> bool:
        return any(name == "meet_rectangle" for name, *_ in self.members)

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
        return bool(((self.surfaces["albedo"] > 0) & (self.surfaces["albedo"] < 1)).any())

    @property
    def draws(self) -> bool:
        """Whether crossings need random numbers."""
        return self.has_roulette or layout.DIFFUSE in self.materials

    @property
    def rows(self) -> int:
        return 2 * self.half

    @property
    def unit(self) -> float:
        """What all histories of a run stand for at the weight 1: [W], or particles."""
        return math.fsum(emitter.bound for emitter in self.emitters)
