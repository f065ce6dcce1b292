"""Free flights of many lanes, their random numbers bit by bit, and numbers at the ends of their range."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import ndtri

from tests.driven import Lanes
from transport.compile import layout
from transport.engine.passes import collisions, variance_reduction
from transport.physics import paths

FALSE_ALARM = 1e-6
ROUNDS = 800  # of LANES draws
PATH_BITS, COLLISION_BITS, TURN_BITS = 44, 44, 32  # of the uniforms that are told apart here
WORDS = {"all zeros": 0, "all ones": 0xFFFFFFFF}
LAST = 1 - 2.0**-52
LAST = 1 - 2.0**-52


def flights(rounds=ROUNDS, fly=collisions.sample_free_path, **fields):
    """Paths [mean free paths], u0 and u1 of many flights, one after the other of each lane."""
    lanes = Lanes(**fields)
    found = []
    for _ in range(rounds):
        lanes["distance"], lanes["hit"] = 0.0, 0
        lanes.run(fly)
        path = lanes["distance"] - lanes["start"] - 2 * layout.COLLISION_CLEARANCE
        found.append((path / lanes["mfp"], lanes["u0"], lanes["u1"]))
    return np.concatenate(np.transpose(found, (1, 2, 0)).reshape(3, 1, -1))


def worst(z):
    """How many times the limit of the largest of many normal scores is reached."""
    return np.abs(z).max() / -ndtri(FALSE_ALARM / z.size / 2)


def bits_of(u, count):
    """The upper bits of uniforms, (draws, count) of +1 and -1."""
    words = np.floor(u * 2.0**count).astype(np.int64)
    return (2 * ((words[:, None] >> np.arange(count)) & 1) - 1).astype(np.float32)


def coins(path, u0, u1):
    """Scores of every bit as a fair coin, and of every two bits of unlike numbers as independent ones."""
    parts = [bits_of(-np.expm1(-path), PATH_BITS), bits_of(u0, COLLISION_BITS), bits_of(u1, TURN_BITS)]
    n = math.sqrt(len(path))
    alone = np.concatenate([part.sum(axis=0, dtype=float) / n for part in parts[1:]])
    pairs = [(a.T @ b).ravel() / n for k, a in enumerate(parts) for b in parts[k + 1 :]]
    return alone, np.concatenate(pairs)


def draw_only(word, monkeypatch):
    """Let free paths be made of this word alone, in plain Python."""
    monkeypatch.setattr(paths, "event_words", lambda *_: (np.uint64(word),) * 4)
    plain = getattr(paths.free_flight, "py_func", paths.free_flight)
    for module in (collisions, variance_reduction):
        monkeypatch.setattr(module, "free_flight", plain)
