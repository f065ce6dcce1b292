"""Rays through the passes of one volume detector, and their ways told from exact crossings (fractions)."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
from numba import config

import transport as tp
from tests.sampling import PASS
from transport.compile.compiler import compile_scene
from transport.engine.bundle import LANES, empty_bundle
from transport.engine.driver import compile_program
from transport.engine.program import build_program

BOX, BALL = tp.Box(size=(1.0, 0.5, 0.25)), tp.Sphere(radius=0.5)
LAMP = tp.Source(tp.Sphere(radius=1.0), tp.Lambertian(power=1.0), side="back")
EMPTY, FOG = tp.Medium(scattering=1.0), tp.Medium(absorption=1.0, scattering=1.0)
WAY_UNITS = np.array([2.0**-32, 2.0**-63])


class Rays:
    """Lanes that fly from `start` to `distance`, through the passes of a scene with one volume."""

    def __init__(self, detector, medium=EMPTY):
        about = tp.Surface(tp.Sphere(radius=3.0), tp.Transparent(), inside=medium)
        scene = tp.Scene(LAMP, about, detector)
        self.machine = compile_program(
            build_program(compile_scene(scene, tp.Tracking(absorption="weighted")))
        )
        self.plan = self.machine.program.plan
        self.volume = self.plan.volumes[0]

    def walk(self, origins, flights, starts=0.0, ends=math.inf, weights=1.0, waits=False, sigma_a=0.0):
        """Sums by cell of all rays: weight times way [m], number of ways, absorbed weight."""
        bundle, count, size = empty_bundle(), len(origins), self.plan.space.size
        assert count <= LANES
        tallies = np.zeros((self.plan.rows, 4), np.int64)
        bundle["tallies"] = tallies.ctypes.data
        lanes = bundle[0]
        for name, column in zip("xyz", (np.asarray(origins, float) - self.plan.space.origin).T, strict=True):
            lanes[name][:count] = column / size
        for name, column in zip(("ux", "uy", "uz"), np.asarray(flights, float).T, strict=True):
            lanes[name][:count] = column
        values = {
            "start": starts / size,
            "distance": np.asarray(ends) / size,
            "weight": weights,
            "flies": not waits,
        }
        values |= {"sigma_a": sigma_a * size, "mfp": math.inf, "survival": 1.0}
        for name, value in values.items():
            lanes[name][:count] = value
        self.bundle = bundle
        for lane_pass, table in self.machine.program.steps:
            if lane_pass.function.__module__.endswith(("volumes", "volume_cells")):
                entry, handle, table = _ready(lane_pass, bundle, table)
                entry(handle, table, 0, count)
        row, cells = self.volume.row, self.volume.detector.volumes(self.volume.shape).size
        track = tallies[int(row["first"]) :][:cells]
        kept = tallies[int(row["kept"]) :][:cells, :2] @ WAY_UNITS if row["kept"] else np.zeros(cells)
        return track[:, :2] @ WAY_UNITS * self.volume.unit, track[:, 2], kept


def _ready(lane_pass, bundle, table):
    """A pass as it is called, by addresses or without compilation."""
    if config.DISABLE_JIT:
        return lane_pass.function, bundle.view(np.recarray)[0], table.reshape(1).view(np.recarray)[0]
    return PASS(lane_pass.entry), bundle.ctypes.data, table.ctypes.data


def exact_ways(origin, flight, start, end, edges):
    """Ways [m] through the voxels between edges along x, y, z: between all crossings in fractions."""
    o, u = [list(map(Fraction, map(float, vector))) for vector in (origin, flight)]
    cuts = {Fraction(start), Fraction(end)}
    for axis in range(3):
        if u[axis] != 0:
            cuts |= {(Fraction(e) - o[axis]) / u[axis] for e in edges[axis]}
    cuts = sorted(t for t in cuts if start <= t <= end)
    ways = np.zeros([len(e) - 1 for e in edges])
    for a, b in pairwise(cuts):
        place = [o[axis] + (a + b) / 2 * u[axis] for axis in range(3)]
        cell = [np.searchsorted(e, float(x), side="right") - 1 for e, x in zip(edges, place, strict=True)]
        cell = [len(e) - 2 if x == e[-1] else c for c, e, x in zip(cell, edges, place, strict=True)]
        if all(0 <= c < len(e) - 1 for c, e in zip(cell, edges, strict=True)):
            ways[tuple(cell)] += float(b - a)
    return ways


def random_rays(count, seed):
    """Rays to places in the middle of both shapes, some in planes across x, some along z."""
    rng = np.random.default_rng(seed)
    origins = rng.uniform(-0.8, 0.8, (count, 3))
    flights = rng.uniform(-0.12, 0.12, (count, 3)) - origins
    origins[: count // 8, 0], flights[: count // 8, 0] = rng.uniform(-0.4, 0.4, count // 8), 0.0
    origins[: count // 16, 1], flights[: count // 16, 1] = rng.uniform(-0.2, 0.2, count // 16), 0.0
    flights /= np.linalg.norm(flights, axis=1)[:, None]
    return origins, flights, rng.uniform(0.0, 0.5, count), rng.uniform(0.5, 2.0, count)
