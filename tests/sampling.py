"""Samplers against their densities: one chi-square over cells of direction, and one for reciprocity.

Directions are unit vectors (draws, 3) in the frame of the surface, its normal +z; densities are functions of
mu = z and the azimuth phi from +x, per solid angle [sr^-1], over the whole sphere.  What a material does is
asked from the engine's own passes, with its own random numbers, by `met_by`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pytest
from numba import config
from scipy.special import chdtrc

import transport as tp
from tests.agreement import assert_follows
from tests.driven import PASS
from transport.compile.compiler import compile_scene
from transport.engine.bundle import LANES, empty_bundle
from transport.engine.driver import Sums
from transport.engine.program import build_program
from transport.theory import microfacets

ACTS = (
    "draw_second_block", "choose_material", "look_up_surface", "look_up_optics", "absorb", "draw_uniforms", "sample_transmission",
    "reflect_diffusely", "reflect_specularly", "transmit", "refract", "reflect_glossily", "scatter_into_lobe", "deflect_by_lens",
)  # fmt: skip
NODES, WEIGHTS = np.polynomial.legendre.leggauss(10)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2  # on [0, 1]
EXACT = 1e-13  # how far [1] a direction may be from that of a beam

Density = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Cells(NamedTuple):
    """Cells of direction: edges of mu in [-1, 1], of which one is 0, and of phi in [0, 2 pi]."""

    mu: np.ndarray
    phi: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.mu) - 1, len(self.phi) - 1

    def number(self, directions: np.ndarray) -> np.ndarray:
        """The cell that each direction is in."""
        phi = np.mod(np.arctan2(directions[:, 1], directions[:, 0]), 2 * math.pi)
        places = zip((self.mu, self.phi), (directions[:, 2], phi), self.shape, strict=True)
        rows = [np.clip(np.searchsorted(e, x, side="right") - 1, 0, n - 1) for e, x, n in places]
        return np.ravel_multi_index(rows, self.shape)


def even_cells(mu: int = 8, phi: int = 8) -> Cells:
    """Cells of one size, so many in mu on each side."""
    return Cells(np.linspace(-1, 1, 2 * mu + 1), np.linspace(0, 2 * math.pi, phi + 1))


def cells_about(mu: float, phi: float, width: float) -> Cells:
    """Cells that crowd about a direction, the smallest a quarter of `width` [rad] wide."""
    steps = width * np.array([0.25, 0.6, 1.2, 3, 8, 25])
    sine = max(math.sqrt((1 - mu) * (1 + mu)), width)
    elevation = math.asin(mu) + np.concatenate([-steps, [0], steps])
    edges = np.sin(np.clip(elevation, -math.pi / 2, math.pi / 2))
    turns = np.clip(np.concatenate([phi - steps / sine, [phi], phi + steps / sine]), 0, 2 * math.pi)
    return Cells(
        np.unique(np.r_[edges, np.linspace(-1, 1, 9)]), np.unique(np.r_[turns, 0, math.pi, 2 * math.pi])
    )


def cell_probabilities(pdf: Density, cells: Cells) -> np.ndarray:
    """Integrals of a density over cells [1], Gauss-Legendre in cells that are quartered until nothing changes."""
    (low_mu, low_phi), (high_mu, high_phi) = (
        [x.ravel() for x in np.meshgrid(cells.mu[part], cells.phi[part], indexing="ij")]
        for part in (slice(None, -1), slice(1, None))
    )
    home, total = np.arange(len(low_mu)), np.zeros(len(low_mu))
    for _ in range(12):
        whole = _integrals(pdf, low_mu, high_mu, low_phi, high_phi)
        mu, phi = (low_mu + high_mu) / 2, (low_phi + high_phi) / 2
        lows = [np.concatenate(part) for part in ((low_mu, low_mu, mu, mu), (low_phi, phi, low_phi, phi))]
        highs = [
            np.concatenate(part) for part in ((mu, mu, high_mu, high_mu), (phi, high_phi, phi, high_phi))
        ]
        quarters = _integrals(pdf, lows[0], highs[0], lows[1], highs[1]).reshape(4, -1)
        wrong = np.abs(quarters.sum(axis=0) - whole) > 1e-12
        np.add.at(total, home[~wrong], quarters.sum(axis=0)[~wrong])
        (low_mu, low_phi), (high_mu, high_phi) = (
            [x[np.tile(wrong, 4)] for x in pair] for pair in (lows, highs)
        )
        home = np.tile(home[wrong], 4)
        if not len(home):
            return total
    raise ValueError(
        f"The density is not smooth enough in {len(np.unique(home))} cells; put edges at its kinks"
    )


def assert_samples(
    directions: np.ndarray,
    pdf: Density,
    cells: Cells,
    beams: Sequence[tuple[np.ndarray, float]] = (),
    false_alarm: float = 1e-6,
) -> None:
    """Fail unless draws follow a density over cells of direction, and single directions their probabilities.

    beams: (direction, probability) of what leaves in one direction only.  Density and beams must add up to 1:
    what is lost or too much raises ValueError.
    """
    counts, probabilities, left = [], [], directions
    for beam, probability in beams:
        is_in = np.linalg.norm(left - np.asarray(beam), axis=1) <= EXACT
        counts.append(np.count_nonzero(is_in))
        probabilities.append(probability)
        left = left[~is_in]
    counts = np.concatenate([counts, np.bincount(cells.number(left), minlength=math.prod(cells.shape))])
    probabilities = np.concatenate([probabilities, cell_probabilities(pdf, cells)])
    if np.count_nonzero(probabilities) == 1 and math.isclose(probabilities.sum(), 1, rel_tol=1e-9):
        assert counts[probabilities == 0].sum() == 0, (
            f"{counts[probabilities == 0].sum()} draws not in the beam"
        )
        return
    assert_follows(counts, probabilities, false_alarm)


def assert_reciprocal(into: np.ndarray, out: np.ndarray, cells: Cells, false_alarm: float = 1e-6) -> None:
    """Fail unless light in equilibrium goes as often from one cell of direction to another as back again.

    into, out: directions of flight before and after, those before as in equilibrium (cosine law, as many from
    each side as its index squared).  Each pair of counts is binomial of a half; chi-square over pairs with 20
    draws or more.
    """
    count = math.prod(cells.shape)
    joint = np.bincount(cells.number(-into) * count + cells.number(out), minlength=count * count)
    joint = joint.reshape(count, count).astype(float)
    one, other = joint[np.triu_indices(count, 1)], joint.T[np.triu_indices(count, 1)]
    enough = one + other >= 20
    assert enough.sum() >= 3, "too few draws between unlike cells"
    square = ((one - other)[enough] ** 2 / (one + other)[enough]).sum()
    probability = chdtrc(enough.sum(), square)
    assert probability >= false_alarm, (
        f"chi-square {square:.1f} of {enough.sum()} pairs of cells: probability {probability:.2g}, limit {false_alarm:.2g}"
    )


def rejects(*judgement, judge: Callable = assert_samples) -> bool:
    """Whether draws do not pass for those of another density."""
    with pytest.raises((AssertionError, ValueError)) as caught:
        judge(*judgement)
    return caught.type is AssertionError


def lambert(front: float = 1.0, back: float = 0.0) -> Density:
    """The cosine law, so much of it on each side."""
    return lambda mu, phi: np.where(mu > 0, front, back) * np.abs(mu) / math.pi


def glossy(mu_in: float, roughness: float, side: float = 1.0) -> Density:
    """The density of what `Glossy` sends back of light that comes from azimuth 0."""
    return lambda mu, phi: np.where(
        side * mu > 0, microfacets.brdf(mu_in, np.abs(mu), phi, roughness) * np.abs(mu), 0.0
    )


def met_by(material, into: np.ndarray, seed: int = 1, normal=(0.3, -0.5, 0.8), place=(0.0, 0.0)):
    """Directions (draws, 3) in which a surface's passes send on what arrives, and its weights, 1 before.

    into: directions of flight in its frame, towards the front where z < 0;  place: (u, v) [m] on it.
    """
    shape = tp.Disk(center=(0.2, 0.1, -0.3), normal=normal, radius=2.0)
    lamp = tp.Source(tp.Point(position=(1, 2, 3)), tp.Isotropic(power=1))
    plan = compile_scene(tp.Scene([lamp], [tp.Surface(shape, material)]))
    program = build_program(plan)
    steps = [
        (p.entry if config.DISABLE_JIT else PASS(p.entry), at) for p, at in program.steps if p.name in ACTS
    ]
    frame, bundle = np.array(shape.frame), empty_bundle()
    where = plan.space.place(tuple(np.array(shape.center) + np.array(place) @ frame[:2]))
    sums = Sums(plan, len(into))
    sums.enter(bundle)
    bundle["seed_low"], bundle["batch"] = seed, 0
    for name, value in zip(("x", "y", "z", "nx", "ny", "nz"), (*where, *frame[2]), strict=True):
        bundle[name] = value
    (hit,) = (row["hit"] for _, row, _ in plan.members)
    lanes = {name: bundle[name][0] for name in ("ux", "uy", "uz", "mu", "weight", "history", "event", "hit")}
    handle = bundle.view(np.recarray)[0] if config.DISABLE_JIT else bundle.ctypes.data
    world, found = into @ frame, np.empty((5, len(into)))
    for first in range(0, len(into), LANES):
        live = min(LANES, len(into) - first)
        arriving = (
            *world[first : first + live].T,
            into[first : first + live, 2],
            1.0,
            np.arange(first, first + live),
            0,
            hit,
        )
        for lane, values in zip(lanes.values(), arriving, strict=True):
            lane[:live] = values
        for step, offset in steps:
            step(handle, offset, 0, live)
        for row, lane in zip(found, lanes.values(), strict=False):
            row[first : first + live] = lane[:live]
    out, (mu, weights) = found[:3].T, found[3:]
    np.testing.assert_allclose(mu, out @ frame[2], atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(out, axis=1), 1, rtol=1e-15)
    return out @ frame.T, weights


def cosine_law(count: int, seed: int, side: float = -1.0) -> np.ndarray:
    """Directions of flight in equilibrium, towards the front (side -1) or towards the back (+1)."""
    u, turn = np.random.default_rng(seed).random((2, count))
    sine = np.sqrt(u)
    x, y = sine * np.cos(2 * math.pi * turn), sine * np.sin(2 * math.pi * turn)
    return np.stack([x, y, side * np.sqrt(1 - u)], axis=1)


def _integrals(pdf: Density, low_mu, high_mu, low_phi, high_phi) -> np.ndarray:
    mu = low_mu[:, None, None] + (high_mu - low_mu)[:, None, None] * NODES[:, None]
    phi = low_phi[:, None, None] + (high_phi - low_phi)[:, None, None] * NODES
    values = pdf(*np.broadcast_arrays(mu, phi))
    return (high_mu - low_mu) * (high_phi - low_phi) * ((values @ WEIGHTS) @ WEIGHTS)
