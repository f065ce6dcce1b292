"""Lower point detectors: positions, sums, rays to them, and densities of phase functions.

The score of a point detector is not bounded. It is added to one of POINT_ROWS rows by its exponent, four
octaves per row, scaled to between 1/16 and 1. So no sum overflows or loses digits, and the rows give the
distribution of scores.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.compile.layout import POINT_MIDDLE, POINT_OCTAVES, POINT_ROWS
from transport.compile.rows import Rows
from transport.compile.shapes import pass_name
from transport.geometry.solid import Box, Sphere
from transport.scene.bodies import body_bits_at
from transport.scene.media import Medium
from transport.scene.phase_functions import Tabulated
from transport.validation import SceneError, refuse, short_repr
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.compile.plan import Emitter, Plan

# Value of a sum of 1 in each row.
SCALES = np.ldexp(1.0, POINT_OCTAVES * (np.arange(POINT_ROWS) - POINT_MIDDLE + 1))
# [extents] Within this distance of a volume source's center, lines are sampled from the point instead.
NEAR_EXTENTS = 1.5


MAX_POINTS = 255  # values of a target's number in the random number counter
DETOURS = "connect_by_detour", "connect_along_beam"  # passes of rays that are scattered once more

RayPass = tuple[str, np.ndarray]  # name of a pass, and its row


@dataclass(frozen=True)
class Rays:
    """Rays from events of one kind to one detector."""

    connect: tuple[RayPass, ...]  # passes that sample a point on the detector and connect the event to it
    contribution: np.ndarray  # row of layout.CONTRIBUTION
    leg: int  # mark of these rays (layout.STRAIGHT_LEG)
    peak: float = 0.0  # [sr^-1] greatest density of directions after such events
    # passes between contribution and listing: they set the density at glossy walls, or drop rays
    densities: tuple[RayPass, ...] = ()


@dataclass(frozen=True)
class PointPlan:
    """A point that rays end at, ready to run: its row of layout.POINT, and the rays of each kind of event.

    It is a point detector or, in a backward run, a source (compile/lamps.py).
    """

    row: np.ndarray
    first: int  # first row of its sums
    births: list[list[Rays]]  # by emitter: direct, and scattered once more in the medium around the point
    walls: list[Rays]  # the same
    collisions: list[Rays]  # in the medium around the point: scattered once more
    flights: list[Rays]  # in other media: direct


def lower_points(plan: Plan) -> None:
    """Give each PointDetector its rows of sums, and fill its table."""
    if len(plan.scene.points) > MAX_POINTS:
        raise SceneError(f"Scene: at most {MAX_POINTS} PointDetectors, got {len(plan.scene.points)}")
    for number, detector in enumerate(plan.scene.points):
        rows = plan.add_rows(detector.name, Rows(plan.rows, (), (), POINT_ROWS))
        plan.points.append(point_plan(plan, detector, detector.position, number, rows.first))


def point_plan(
    plan: Plan, user: object, position: Vector, number: int, first: int, scale: float = 1.0
) -> PointPlan:
    """Return a point ready to run, with sums from row `first` on that are multiplied by `scale`.

    user: the point detector or the source there, which a message names.
    """
    refuse_births_on_boundaries(plan, user)
    scatterers, medium = _scatterers(plan), _medium_row_at(plan, position)
    medium = medium if medium in scatterers else -1
    by_flights = bool(scatterers - {medium})
    if by_flights and plan.tracking.forced:
        must = "is not supported with Tracking(forced=True) where other media than the one around it scatter"
        refuse(user, f"{must}; omit forced=True")
    place = layout.vector_columns("", plan.space.place(position))
    row = layout.row(layout.POINT, **place, number=number, medium=medium)

    def rays(name: str, row: np.ndarray = row, **density: float) -> Rays:
        contribution = layout.row(layout.CONTRIBUTION, first=first, scale=scale, **density)
        leg = layout.FIRST_LEG - number if name in DETOURS else layout.STRAIGHT_LEG
        return Rays(((name, row),), contribution, leg)

    births = [
        [rays(*way, **density) for *way, density in _births(plan, emitter, position, row)]
        for emitter in plan.emitters
    ]
    detours = [rays("connect_by_detour")] if medium >= 0 else []
    walls = [rays("connect_to_point"), *detours] if layout.DIFFUSE in plan.materials else []
    flights = [rays("connect_to_flight")] if by_flights else []
    return PointPlan(row, first, births, walls, detours, flights)


def refuse_births_on_boundaries(plan: Plan, user: object) -> None:
    """Raise SceneError where histories start on the boundary of a body, as rays would not know their side."""
    on_boundary = (emitter.shape for emitter in plan.emitters if emitter.beside)
    if (shape := next(on_boundary, None)) is not None:
        refuse(
            user,
            f"no ray connects it to a point on the boundary of a body, {short_repr(shape)}; move that off",
        )


def _scatterers(plan: Plan) -> set[int]:
    """Return the rows of media that scatter."""
    return set(np.flatnonzero(plan.media["phase"] != 0).tolist()) if scatters_anywhere(plan) else set()


def _medium_row_at(plan: Plan, position: Vector) -> int:
    """Return the row of the medium around a point."""
    bits = int(body_bits_at(plan.scene, np.array([position]))[0])
    return (bits & -bits).bit_length()


def _births(plan: Plan, emitter: Emitter, position: Vector, row: np.ndarray) -> Iterator[tuple]:
    """Yield pass, row and density of directions of the rays from births to a point.

    Direct ones, and where the medium around the point scatters those that are scattered once before it.
    """
    shape, emission = emitter.shape, emitter.source.emission
    is_near = math.dist(position, shape.middle) < NEAR_EXTENTS * shape.extent
    density, even = emitter.ray_densities, {"isotropic": 1.0}
    if emission.fills_volume and is_near and isinstance(shape, Box | Sphere):
        yield f"connect_through_{pass_name(shape)}", _glow_row(plan, shape, row), even
    elif density:
        yield "connect_to_point", row, density
    if row["medium"] >= 0:
        yield ("connect_by_detour", row, density) if density else ("connect_along_beam", row, even)


def _glow_row(plan: Plan, shape: Box | Sphere, row: np.ndarray) -> np.ndarray:
    """Return the row of a uniformly emitting volume, sampled along lines through the point of a row."""
    size = plan.space.size
    halves = [side / 2 for side in shape.size] if isinstance(shape, Box) else [shape.radius] * 3
    values = {name: row[name] for name in ("x", "y", "z", "number")}
    values |= {f"h{x}": half / size for x, half in zip("xyz", halves, strict=True)}
    values |= layout.center_columns(plan.space.place(shape.middle)) | {"scale": size**3 / shape.volume}
    return layout.row(layout.POINT_GLOW, **values)


def phase_densities(plan: Plan) -> list[RayPass]:
    """Return the pass that adds the density of each phase function, or part of one, and its row."""
    found = []
    for phase, number in plan.phase_numbers.items():
        for part, share in phase.weighted_parts:
            values = {"g": part.parameter, "share": share, "number": number}
            if isinstance(part, Tabulated):
                cosines, densities = (np.ascontiguousarray(array) for array in (part.mu, part.values))
                values |= {"cosines": plan.arena.place(cosines), "values": plan.arena.place(densities)}
                values |= {"cells": len(cosines) - 1}
            found.append((f"add_{part.law}_pdf", layout.row(layout.POINT_PHASE, **values)))
    return found


def scatters_anywhere(plan: Plan) -> bool:
    """Return whether any medium scatters, homogeneous or made of voxels."""
    return plan.scatters and bool(plan.phase_numbers)


def attenuates_anywhere(plan: Plan) -> bool:
    """Return whether any homogeneous medium attenuates."""
    return any(isinstance(medium, Medium) and medium.extinction > 0 for medium in plan.distinct_media)
