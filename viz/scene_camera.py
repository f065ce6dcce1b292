"""Where a picture of a scene is taken from: what was measured turned towards the camera and not hidden, long things from
the side."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from transport.geometry.mesh import Mesh
from transport.geometry.shape import Shape
from transport.geometry.solid import Box
from transport.viz.facets import TURN, Facets, facets_of
from transport.viz.scene_frame import Frame
from transport.viz.scene_parts import BACK, FRONT, NOWHERE, Part

LONG = 1.8  # so many times higher than wide: laid on its side
VIEW_ANGLE = 28.0  # degrees, from top to bottom
MARGIN = 1.16  # round what is shown
WIDTH = 0.84  # of the window, beside bars
STANCES = tuple((turn, rise) for rise in (22.0, 35.0, 10.0, 55.0, -18.0) for turn in range(-165, 181, 15))
USUAL = (-62.0, 22.0)  # degrees of azimuth and elevation, where nothing speaks for others
MEASURED, HIDDEN, BROAD, HABIT, LIT = 1.0, 0.8, 0.6, 0.45, 0.3  # how much each wish weighs
OBLIQUE = 0.5  # more than this share of an area need not be turned to the camera
PROBES = 30  # places on what was measured that are asked whether they can be seen
COARSE = TURN / 16
MOST_TRIANGLES = 3000  # of a mesh that may hide something as it is; of others their bounds


class View(NamedTuple):
    """A camera: its place, what it looks at [m], and what is up."""

    position: np.ndarray
    focus: np.ndarray
    up: np.ndarray


def view_of(parts: list[Part], frame: Frame, aspect: float) -> View:
    """The best of a number of views; aspect: width over height of the window."""
    poles = _poles(frame)
    ways = np.array([_way(poles, *stance) for stance in STANCES])
    broad = np.array([_silhouette(frame, way) for way in ways])
    scores = BROAD * np.minimum(broad / broad.max(), OBLIQUE) + HABIT * ways @ _way(poles, *USUAL)
    coarse = [replace(part, facets=_coarse(part)) for part in parts]
    painted = [part for part in coarse if part.paint is not None and (part.paint.values > 0).any()]
    painted = painted or [
        part for part in coarse if part.kind == "detector" and part.side and len(part.facets.faces)
    ]
    if painted:
        scores += MEASURED * np.minimum(_shown(painted, ways), OBLIQUE) / OBLIQUE
        scores -= HIDDEN * _hidden(painted, coarse, ways)
    lit = [part for part in coarse if part.kind == "source" and part.what.emission.has_side and part.side]
    lit = [part for part in lit if len(part.facets.faces)]
    if lit:
        scores += LIT * _shown(lit, ways)
    way = ways[int(np.argmax(scores))]
    return View(frame.middle + way * _distance(coarse, frame, way, poles[2], aspect), frame.middle, poles[2])


def _poles(frame: Frame) -> np.ndarray:
    """(to the right, away from the usual camera's side, up) of the picture: z is up but where that is by far the longest."""
    x, y, z = np.eye(3)
    size = frame.high - frame.low
    if size[2] > LONG * max(size[0], size[1]):
        return np.array([z, x, y])
    return np.array([x, y, z]) if size[0] >= 0.6 * size[1] else np.array([y, -x, z])


def _way(poles: np.ndarray, turn: float, rise: float) -> np.ndarray:
    """Unit vector from what is shown to the camera; angles in degrees."""
    turn, rise = np.radians([turn, rise])
    return np.cos(rise) * (np.cos(turn) * poles[0] + np.sin(turn) * poles[1]) + np.sin(rise) * poles[2]


def _silhouette(frame: Frame, way: np.ndarray) -> float:
    """Area of the frame's box seen along the way [m^2]."""
    x, y, z = frame.high - frame.low
    return float(np.abs(way) @ np.array([y * z, x * z, x * y]))


def _coarse(part: Part) -> Facets:
    """A few facets of the same shape: bins do not matter here."""
    shape = part.shape
    if isinstance(shape, Mesh) and shape.triangles > MOST_TRIANGLES:
        low, high = (np.array(corner) for corner in shape.bounds)
        size = np.maximum(high - low, 1e-6 * shape.extent)
        shape = Box(center=(low + high) / 2, size=size)
    found = facets_of(shape, None, part.frame.bounds, step=COARSE)
    if found.faces.shape[1] == 3:
        return found
    halves = np.concatenate([found.faces[:, [0, 1, 2]], found.faces[:, [0, 2, 3]]])
    return found._replace(faces=halves, bins=np.tile(found.bins, 2))


def _shown(painted: list[Part], ways: np.ndarray) -> np.ndarray:
    """Of each way the share of what was measured that is turned towards the camera, foreshortened."""
    seen, total = np.zeros(len(ways)), 0.0
    for part in painted:
        areas = part.facets.vector_areas * (-1.0 if part.side == BACK else 1.0)
        towards = areas @ ways.T
        # a transparent meter's map is seen from behind as well
        other = 0.0 if part.kind == "surface" else 0.3
        seen += np.where(towards > 0, towards, -other * towards).sum(axis=0)
        total += np.linalg.norm(areas, axis=1).sum()
    return seen / total if total else seen


def _hidden(painted: list[Part], parts: list[Part], ways: np.ndarray) -> np.ndarray:
    """Of each way the share of probes on what was measured that something stands before."""
    places, owners = _probes(painted)
    hidden = np.zeros((len(ways), len(places)))
    for part in parts:
        weight = _density(part)
        if weight == 0:
            continue
        others = np.array([owner is not part.shape for owner in owners])
        if others.any():
            found = _crossed(part, places[others], ways)
            hidden[:, others] = np.maximum(hidden[:, others], weight * found)
    return hidden.mean(axis=1)


def _probes(painted: list[Part]) -> tuple[np.ndarray, list[Shape]]:
    """Places [m] spread evenly over the areas that were measured, and the shape of each."""
    centres = np.concatenate([part.facets.centres for part in painted])
    areas = np.concatenate([np.linalg.norm(part.facets.vector_areas, axis=1) for part in painted])
    owners = np.repeat(np.arange(len(painted)), [len(part.facets.faces) for part in painted])
    shares = (np.arange(PROBES) + 0.5) / PROBES * areas.sum()
    chosen = np.minimum(np.searchsorted(np.cumsum(areas), shares), len(areas) - 1)
    return centres[chosen], [painted[k].shape for k in owners[chosen]]


def _density(part: Part) -> float:
    """How much of what is behind it a part hides."""
    if part.seen_from == NOWHERE or len(part.facets.faces) == 0:
        return 0.0
    if part.kind == "surface":
        return 0.0 if part.is_clear else 1.0
    return {
        "medium": 0.4,
        "cells": 1.0,
        "source": 0.2,
        "detector": 0.0 if part.paint is None else 1.0 if part.has_bins else 0.3,
    }[part.kind]


def _crossed(part: Part, places: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Of each way and place, whether a shown facet lies before it (Moeller and Trumbore 1997)."""
    a, b, c = (part.facets.points[part.facets.faces[:, k]] for k in range(3))
    one, other = b - a, c - a
    normal = np.cross(one, other)
    found = np.zeros((len(ways), len(places)), dtype=bool)
    gap = 1e-3 * part.frame.size
    for k, way in enumerate(ways):
        facing = normal @ way
        is_shown = {FRONT: facing > 0, BACK: facing < 0}.get(part.seen_from, facing != 0)
        chosen = np.flatnonzero(is_shown)
        if len(chosen) == 0:
            continue
        from_corner = places[:, None, :] - a[chosen]
        cross = np.cross(from_corner, way)
        u = -(cross * other[chosen]).sum(-1) / facing[chosen]
        v = (cross * one[chosen]).sum(-1) / facing[chosen]
        ahead = -(from_corner * normal[chosen]).sum(-1) / facing[chosen]
        found[k] = ((u >= 0) & (v >= 0) & (u + v <= 1) & (ahead > gap)).any(axis=1)
    return found


def _distance(parts: list[Part], frame: Frame, way: np.ndarray, up: np.ndarray, aspect: float) -> float:
    """How far the camera must be for all that is shown to be in the picture [m]."""
    right = np.cross(up, way)
    right /= np.linalg.norm(right)
    above = np.cross(way, right)
    every = [part.facets.points for part in parts if len(part.facets.points)]
    corners = np.array(np.meshgrid(*zip(*frame.bounds, strict=True))).reshape(3, -1).T
    is_endless = any(part.shape.is_infinite for part in parts)
    places = np.concatenate([*every, corners] if is_endless or not every else every)
    places = np.clip(places, *frame.bounds) - frame.middle
    half = np.tan(np.radians(VIEW_ANGLE / 2)) / MARGIN
    needed = np.maximum(np.abs(places @ above), np.abs(places @ right) / (aspect * WIDTH)) / half
    return float(max((needed + places @ way).max(), 0.2 * frame.size / half))
