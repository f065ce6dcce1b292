"""Random numbers: known answers, independent neighbours, no repeated number, and the extreme draws."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

import transport as tp
from transport.verification.hard.cases import CaseResult, case

SEEDS = 60
HISTORIES = 200_000


@lru_cache(maxsize=1)
def _rays() -> np.ndarray:
    """One component of the directions of HISTORIES particles, in the order of their histories."""
    source = tp.Source(tp.Point(), tp.Gas(number=1.0, speed=1.0))
    scene = tp.Scene(source, detectors=tp.Snapshot(1.0, particles=HISTORIES, name="all"), duration=1.0)
    return tp.simulate(scene, HISTORIES, seed=1, progress=False)["all"].velocities[:, 2]


def _z_of_half_flux(seed: int) -> float:
    """z of a flux whose exact value is 1/2."""
    scene = tp.Scene(
        tp.Source(tp.Point(), tp.Isotropic(power=1.0)),
        detectors=tp.Detector(tp.Plane(center=(0, 0, -1)), "low"),
    )
    return tp.simulate(scene, 640, seed=seed, threads=1, progress=False)["low"].flux_in.z(0.5)


def _correlation(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.corrcoef(one, other)[0, 1])


@case(
    "the generator's first word for a counter and key of ones",
    naive="products of 32-bit words truncated to 32 bits",
)
def known_answer() -> CaseResult:
    """Philox4x32-10 uses the upper half of each product: Random123 gives 0x408f276d (Salmon et al. 2011)."""
    from transport.physics.streams import random_words

    ones = np.uint64(0xFFFFFFFF)
    return CaseResult(
        float(random_words(ones, ones, ones, ones, ones, ones)[0]),
        float(0x408F276D),
        float(_philox_truncated()),
        within=0.0,
    )


def _philox_truncated() -> int:
    """The same rounds without the upper halves."""
    word, key = 0xFFFFFFFF, [0xFFFFFFFF, 0xFFFFFFFF]
    c = [word] * 4
    for _ in range(10):
        c = [c[1] ^ key[0], 0xCD9E8D57 * c[2] & word, c[3] ^ key[1], 0xD2511F53 * c[0] & word]
        key = [(key[0] + 0x9E3779B9) & word, (key[1] + 0xBB67AE85) & word]
    return c[0]


@case(
    "200 000 histories: how many set out in directions of their own",
    naive="a random 32-bit seed per history",
)
def no_history_twice() -> CaseResult:
    """Of 200 000 seeds drawn with replacement about five repeat (a birthday problem), and their
    histories with them.
    """
    seeds = np.random.default_rng(1).integers(0, 1 << 32, HISTORIES)
    return CaseResult(
        float(len(np.unique(_rays()))), HISTORIES, naive=float(len(np.unique(seeds))), within=0.0
    )


@case(
    "the correlation of each history with the next",
    naive="a linear generator (multiplier 69069) with consecutive seeds",
)
def neighbouring_histories() -> CaseResult:
    """The first number of a linear generator is linear in its seed: neighbours are born side by side."""
    rays, seeds = _rays(), np.arange(HISTORIES, dtype=np.int64)
    first = (69069 * seeds + 1) % 2**32 / 2**32
    return CaseResult(
        _correlation(rays[1:], rays[:-1]),
        0.0,
        _correlation(first[1:], first[:-1]),
        within=5 / math.sqrt(HISTORIES),
    )


@case(
    "the correlation of the z of neighbouring seeds",
    naive="history h of seed s uses the random numbers of s + h",
)
def neighbouring_seeds() -> CaseResult:
    """Runs with seeds 1, 2, 3 then share all histories but one: a repetition with the next seed adds no
    information.
    """
    z = np.array([_z_of_half_flux(seed) for seed in range(SEEDS)])
    draws = np.random.default_rng(1).random(SEEDS + 640)
    naive = np.array([draws[seed : seed + 640].mean() for seed in range(SEEDS)])
    within = 5 / math.sqrt(SEEDS)
    return CaseResult(_correlation(z[1:], z[:-1]), 0.0, _correlation(naive[1:], naive[:-1]), within)


@case("the longest free path that a draw can give, in mean free paths", naive="-ln u for u = 0")
def longest_flight() -> CaseResult:
    """Uniform numbers are multiples of 2^-52 below 1; 0 is one of them, and its logarithm is infinite."""
    from transport.engine.passes.voxels import BELOW_ONE
    from transport.physics.elementary import log_positive
    from transport.physics.streams import uniform

    ones = np.uint64(0xFFFFFFFF)
    with np.errstate(divide="ignore"):
        naive = -np.log(np.float64(uniform(np.uint64(0), np.uint64(0))))
    return CaseResult(-log_positive(BELOW_ONE - uniform(ones, ones)), 53 * math.log(2), float(naive))
