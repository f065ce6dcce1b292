"""Where a picture of a scene is taken from: paint turned towards the camera and not hidden, long things from the side."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from transport.geometry.mesh import Mesh
from transport.viz.facets import TURN, Facets, box_facets, facets_of
from transport.viz.scene_parts import BACK, FRONT, NOWHERE, Frame, Part

LONG = 1.8  # ratio of height to width above which a scene is laid on its side
VIEW_ANGLE = 28.0  # [degrees] from top to bottom
MARGIN = 1.16  # around what is shown
WIDTH = 0.84  # of the window, beside colour bars
DIRECTIONS = [(azimuth, elevation) for elevation in (22, 35, 10, 55, -18) for azimuth in range(-165, 181, 15)]
USUAL = (-62.0, 22.0)  # azimuth and elevation [degrees] if nothing favours others
PAINTED, HIDDEN, BROAD, HABIT, LIT = 1.0, 0.8, 0.6, 0.45, 0.3  # weights of the criteria
OBLIQUE = 0.5  # share of an area that is enough to be turned to the camera
PROBES = 30  # places on the paint that are tested for visibility
COARSE = TURN / 16  # step of an angle
MAX_TRIANGLES = 3000  # a mesh of more is replaced by its bounding box


class View(NamedTuple):
    """A camera: its place, what it looks at [m], and the upward direction."""

    position: np.ndarray
    focus: np.ndarray
    up: np.ndarray


def view_of(parts: list[Part], frame: Frame, aspect: float) -> View:
    """Return the best of a number of views; `aspect`: width over height of the window."""
    axes = _axes(frame)
    ways = np.array([_direction(axes, *angles) for angles in DIRECTIONS])
    x, y, z = frame.high - frame.low
    silhouettes = np.abs(ways) @ np.array([y * z, x * z, x * y])
    scores = BROAD * np.minimum(silhouettes / silhouettes.max(), OBLIQUE)
    scores += HABIT * ways @ _direction(axes, *USUAL)
    coarse = [replace(part, facets=coarse_facets(part)) for part in parts]
    flat = [part for part in coarse if part.side and len(part.facets.faces)]
    painted = [part for part in coarse if part.paint is not None and (part.paint.values > 0).any()]
    painted = painted or [part for part in flat if part.kind == "detector"]
    if painted:
        scores += PAINTED * np.minimum(_turned_share(painted, ways), OBLIQUE) / OBLIQUE
        scores -= HIDDEN * _hidden_share(painted, coarse, ways)
    lit = [part for part in flat if part.kind == "source" and part.what.emission.has_side]
    if lit:
        scores += LIT * _turned_share(lit, ways)
    way = ways[int(np.argmax(scores))]
    return View(frame.middle + way * _distance(coarse, frame, way, axes[2], aspect), frame.middle, axes[2])


def _axes(frame: Frame) -> np.ndarray:
    """Directions to the right, away from the usual camera, and up; z is up unless the scene is by far longest in z."""
    x, y, z = np.eye(3)
    size = frame.high - frame.low
    if size[2] > LONG * max(size[0], size[1]):
        return np.array([z, x, y])
    return np.array([x, y, z]) if size[0] >= 0.6 * size[1] else np.array([y, -x, z])


def _direction(axes: np.ndarray, azimuth: float, elevation: float) -> np.ndarray:
    """Unit vector from the scene to the camera; angles in degrees."""
    turn, rise = np.radians([azimuth, elevation])
    return np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)]) @ axes


def coarse_facets(part: Part) -> Facets:
    """Few triangles of the same shape; bins do not matter here."""
    if isinstance(part.shape, Mesh) and part.shape.triangles > MAX_TRIANGLES:
        found = box_facets(part.shape.bounds)
    else:
        found = facets_of(part.shape, None, part.frame.bounds, step=COARSE)
    return Facets(found.points, found.triangles, np.zeros(len(found.triangles), dtype=int))


def _turned_share(painted: list[Part], ways: np.ndarray) -> np.ndarray:
    """Share of the painted area that is turned towards the camera, foreshortened, for each way."""
    seen, total = np.zeros(len(ways)), 0.0
    for part in painted:
        areas = part.facets.vector_areas * (-1.0 if part.side == BACK else 1.0)
        towards = areas @ ways.T
        behind = (
            0.0 if part.kind == "surface" else 0.3
        )  # a transparent detector's map is seen from behind as well
        seen += np.where(towards > 0, towards, -behind * towards).sum(axis=0)
        total += np.linalg.norm(areas, axis=1).sum()
    return seen / total if total else seen


def _hidden_share(painted: list[Part], parts: list[Part], ways: np.ndarray) -> np.ndarray:
    """Share of probes on the paint that are hidden by other shapes, for each way."""
    # Spread the probes evenly over the painted area.
    centres = np.concatenate([part.facets.centres for part in painted])
    areas = np.concatenate([np.linalg.norm(part.facets.vector_areas, axis=1) for part in painted])
    owners = np.repeat(np.arange(len(painted)), [len(part.facets.faces) for part in painted])
    shares = (np.arange(PROBES) + 0.5) / PROBES * areas.sum()
    chosen = np.minimum(np.searchsorted(np.cumsum(areas), shares), len(areas) - 1)
    hidden = np.zeros((len(ways), len(chosen)))
    for part in parts:
        opacity = _hiding(part)
        others = np.array([painted[owner].shape is not part.shape for owner in owners[chosen]])
        if opacity > 0 and others.any():
            found = opacity * hides(part, centres[chosen[others]], ways)
            hidden[:, others] = np.maximum(hidden[:, others], found)
    return hidden.mean(axis=1)


def _hiding(part: Part) -> float:
    """How much a part hides of what is behind it."""
    if part.seen_from == NOWHERE or len(part.facets.faces) == 0:
        return 0.0
    paint = 0.0 if part.paint is None else 1.0 if part.has_bins else 0.3
    wall = 0.0 if part.is_clear else 1.0
    return {"surface": wall, "medium": 0.4, "cells": 1.0, "source": 0.2, "detector": paint}[part.kind]


def hides(part: Part, places: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Whether a visible triangle lies before a place, by way and place (Moeller and Trumbore 1997)."""
    a, b, c = (part.facets.points[part.facets.faces[:, k]] for k in range(3))
    one, other = b - a, c - a
    normal = np.cross(one, other)
    found = np.zeros((len(ways), len(places)), dtype=bool)
    for k, way in enumerate(ways):
        facing = normal @ way
        chosen = np.flatnonzero({FRONT: facing > 0, BACK: facing < 0}.get(part.seen_from, facing != 0))
        from_corner = places[:, None, :] - a[chosen]
        cross = np.cross(from_corner, way)
        u = -(cross * other[chosen]).sum(-1) / facing[chosen]
        v = (cross * one[chosen]).sum(-1) / facing[chosen]
        ahead = -(from_corner * normal[chosen]).sum(-1) / facing[chosen]
        found[k] = ((u >= 0) & (v >= 0) & (u + v <= 1) & (ahead > 1e-3 * part.frame.size)).any(axis=1)
    return found


def _distance(parts: list[Part], frame: Frame, way: np.ndarray, up: np.ndarray, aspect: float) -> float:
    """Distance of a camera that sees all that is shown [m]."""
    right = np.cross(up, way)
    right /= np.linalg.norm(right)
    above = np.cross(way, right)
    places = [part.facets.points for part in parts]
    if any(part.shape.is_infinite for part in parts) or not sum(map(len, places)):
        places.append(box_facets(frame.bounds).points)
    places = np.clip(np.concatenate(places), *frame.bounds) - frame.middle
    half = np.tan(np.radians(VIEW_ANGLE / 2)) / MARGIN
    needed = np.maximum(np.abs(places @ above), np.abs(places @ right) / (aspect * WIDTH)) / half
    return float(max((needed + places @ way).max(), 0.2 * frame.size / half))
