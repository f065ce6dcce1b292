"""Discrete ordinates: what a plane layer of any depth, albedo, phase function and index sends back and on.

The azimuthal mean of the radiance obeys, with p(mu, mu') = sum_l (2 l + 1) chi_l P_l(mu) P_l(mu') from the
Legendre moments chi_l of the phase function,

    mu dI/dtau = -I + (a/2) int_-1^1 p(mu, mu') I(mu') dmu'

(Chandrasekhar 1960, ch. 1 and 6).  Here the integral is Gauss's on panels of each hemisphere, which become
narrower towards grazing, where I has mu log mu and exp(-tau/mu), and as narrow as the phase function is; the
depth is dealt with by doubling (transport/theory/doubling.py).  Beams are ordinates of their own, of weight
0; their unscattered part is apart from I.  What the quadrature lacks of sum_j w_j p_ij = 2, about 1e-9, is
given to forward scattering, so that books close.

Where the layer has an index n above that around it, both faces reflect by Fresnel's law, light being
unpolarised at each crossing.  Ordinates are then Gauss's in the cosine outside, in which Fresnel's formulas
are analytic, and on panels beyond the critical angle.  With u up and d down within the faces, and r what
these reflect, d = s + r (R d + T u) and u = r (T d + R u): u is eliminated first, so that nothing cancels.
Outside, L = (1 - r) u/n^2.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from transport.theory import fresnel
from transport.theory.doubling import Layer, layer, layers
from transport.theory.nodes import legendre_nodes

NODES = 12  # of a panel
GRAZING = 1e-5  # mu, next to which the lowest panel ends
SHRINK, FINE = 0.5, 0.01  # each panel over the next above it, down to this mu; below it the square of that
FADED = 1e-8  # Legendre moments below this need not be resolved
TURNS = 1.2  # panel width [rad] times degree of the last moment to resolve, over NODES
WIDEST = 0.5  # rad, a panel
LAST = 1e-14  # moment, below which the Henyey-Greenstein series ends
ISOTROPIC, RAYLEIGH = (1.0,), (1.0, 0.0, 0.1)


def henyey_greenstein(g: float) -> tuple[float, ...]:
    """Legendre moments g^l of the phase function of Henyey and Greenstein (1941) [1]; |g| at most 0.99."""
    if not abs(g) <= 0.99:
        raise ValueError(
            f"henyey_greenstein: g must be between -0.99 and 0.99 for discrete ordinates, got {g}"
        )
    count = 1 if g == 0 else 1 + math.ceil(math.log(LAST) / math.log(abs(g)))
    return tuple(float(g) ** degree for degree in range(count))


def moments_of(mu: np.ndarray, density: np.ndarray, count: int) -> tuple[float, ...]:
    """Legendre moments of a phase function that is linear between cosines mu, from -1 to 1 [1]."""
    x, w = legendre_nodes(math.ceil((count + 3) / 2))
    half, middle = np.diff(mu)[:, None] / 2, (np.asarray(mu)[1:] + np.asarray(mu)[:-1])[:, None] / 2
    places, weights = (middle + half * x).ravel(), (half * w).ravel()
    found = (weights * np.interp(places, mu, density)) @ legendre.legvander(places, count - 1)
    return tuple(float(each) for each in found / found[0])


@dataclass(frozen=True, eq=False)
class Light:
    """What leaves a layer, as shares of the incident flux [1].

    reflected_diffuse, transmitted_diffuse: what was scattered.  unscattered_back, unscattered_on: what was
    not: mirrored by the faces, and passed straight.  up, down: scattered radiance within the faces per
    incident irradiance [sr^-1], its azimuthal mean, at the nodes of the panels (panels, nodes); up_straight,
    down_straight: that of Lambertian light that was not scattered.
    """

    reflected_diffuse: float
    transmitted_diffuse: float
    unscattered_back: float
    unscattered_on: float
    mu0: float | None
    index: float
    edges: np.ndarray  # of the panels, in the cosine outside
    up: np.ndarray
    down: np.ndarray
    up_straight: np.ndarray
    down_straight: np.ndarray

    @property
    def reflected(self) -> float:
        """Share that comes back, mirrored or scattered [1]."""
        return self.reflected_diffuse + self.unscattered_back

    @property
    def transmitted(self) -> float:
        """Share that passes, straight or scattered [1]."""
        return self.transmitted_diffuse + self.unscattered_on

    @property
    def absorbed(self) -> float:
        """Share that stays in the layer [1]."""
        return 1 - self.reflected - self.transmitted

    def reflected_radiance(self, mu: np.ndarray) -> np.ndarray:
        """Radiance that returns at these cosines after scattering, per irradiance [sr^-1]: azimuthal mean."""
        return self._radiance(self.up, mu)

    def transmitted_radiance(self, mu: np.ndarray) -> np.ndarray:
        """Radiance that passes at these cosines after scattering, per incident irradiance [sr^-1]."""
        return self._radiance(self.down, mu)

    def reflected_in(self, edges: np.ndarray, straight: bool = False) -> np.ndarray:
        """Shares that return in bins of cosine after scattering, (bins,) [1].

        straight: of Lambertian light, also what the faces mirror.
        """
        if not straight:
            return self._shares(self.up, edges)
        return self._shares(self.up + self.up_straight, edges) + self._mirrored_in(edges)

    def transmitted_in(self, edges: np.ndarray, straight: bool = False) -> np.ndarray:
        """Shares that pass in bins of cosine after scattering, (bins,) [1].

        straight: of Lambertian light, also what passes unscattered.
        """
        return self._shares(self.down + self.down_straight if straight else self.down, edges)

    def _mirrored_in(self, edges: np.ndarray) -> np.ndarray:
        """2 int r mu dmu over each bin: what the upper face mirrors outside of Lambertian light."""
        if self.mu0 is not None or self.index == 1:
            return np.zeros(len(edges) - 1)
        cuts = np.union1d(edges, np.linspace(edges[0], edges[-1], 9))
        mu, weight = gauss(cuts)
        parts = (2 * weight * mu * fresnel.reflectance(mu, self.index)).reshape(-1, NODES).sum(axis=1)
        return np.add.reduceat(parts, np.searchsorted(cuts, edges[:-1]))

    def _radiance(self, values: np.ndarray, mu: np.ndarray) -> np.ndarray:
        """Outside: what the face lets through of the polynomial through the nodes of each panel."""
        mu = np.asarray(mu, dtype=float)
        panel = np.clip(np.searchsorted(self.edges, mu, side="right") - 1, 0, len(self.edges) - 2)
        low, high = self.edges[panel], self.edges[panel + 1]
        series = (values @ _to_coefficients().T)[panel]
        terms = legendre.legvander((2 * mu - low - high) / (high - low), NODES - 1)
        through = fresnel.transmittance(mu, self.index) / self.index**2
        return through * (series * terms.reshape(series.shape)).sum(axis=-1)

    def _shares(self, values: np.ndarray, edges: np.ndarray) -> np.ndarray:
        """2 pi int L mu dmu over each bin, panel by panel."""
        edges = np.asarray(edges, dtype=float)
        if edges.ndim != 1 or not (np.diff(edges) > 0).all() or edges[0] < 0 or edges[-1] > 1:
            raise ValueError(f"Light: edges must rise within 0 to 1, got {edges}")
        cuts = np.union1d(edges, self.edges[(self.edges > edges[0]) & (self.edges < edges[-1])])
        x, w = legendre_nodes(NODES)
        half, middle = np.diff(cuts)[:, None] / 2, (cuts[1:] + cuts[:-1])[:, None] / 2
        mu = middle + half * x
        parts = 2 * math.pi * ((self._radiance(values, mu) * mu) @ w) * half[:, 0]
        return np.add.reduceat(parts, np.searchsorted(cuts, edges[:-1]))


@lru_cache(maxsize=128)
def slab(
    depth: float,
    albedo: float,
    moments: Sequence[float] = ISOTROPIC,
    mu0: float | None = 1.0,
    index: float = 1.0,
) -> Light:
    """A layer of that optical depth, unbounded sideways, with the same surroundings on both sides.

    depth: above 0; math.inf for a half space of albedo below 1.  albedo: from 0 to 1.  moments: Legendre
    moments of the phase function as a tuple, from 1 on.  mu0: cosine of incidence outside, in (0, 1]; None:
    Lambertian.  index: of the layer over that around it, 1 or more.  Good to 1e-7 and better for |g| up to
    0.9 (against other methods in the tests).
    """
    _check(depth, albedo, moments, mu0, index)
    edges, outside, mu, weight = _ordinates(moments, mu0, index)
    one = layer(depth, albedo, *_phase(moments, mu, weight), mu, weight)
    return _lit(one, edges, outside, mu, weight, mu0, index)


def halved_slabs(
    depth: float,
    times: int,
    albedo: float,
    moments: Sequence[float] = ISOTROPIC,
    mu0: float | None = 1.0,
    index: float = 1.0,
) -> list[Light]:
    """Layers of depth/2^times, ..., depth/2 and depth at the cost of the last; otherwise as `slab`."""
    _check(depth, albedo, moments, mu0, index)
    edges, outside, mu, weight = _ordinates(moments, mu0, index)
    found = deque(layers(depth, albedo, *_phase(moments, mu, weight), mu, weight), maxlen=times + 1)
    return [_lit(one, edges, outside, mu, weight, mu0, index) for one in found]


def half_space(
    albedo: float, moments: Sequence[float] = ISOTROPIC, mu0: float | None = 1.0, index: float = 1.0
) -> Light:
    """A medium that fills all behind a plane, as `slab` without end.  albedo: below 1; of 1 all returns."""
    return slab(math.inf, albedo, moments, mu0, index)


def _check(depth, albedo, moments, mu0, index) -> None:
    if not depth > 0:
        raise ValueError(f"slab: optical depth must be above 0, got {depth}")
    if not 0 <= albedo <= 1 or (albedo == 1 and math.isinf(depth)):
        raise ValueError(f"slab: albedo must be from 0 to 1, below 1 in a half space, got {albedo}")
    if not moments or moments[0] != 1 or not all(abs(each) <= 1 for each in moments):
        raise ValueError(f"slab: moments must begin with 1 and be from -1 to 1, got {moments}")
    if mu0 is not None and not 0 < mu0 <= 1:
        raise ValueError(f"slab: mu0 must be above 0 and at most 1, or None for Lambertian light, got {mu0}")
    if not 1 <= index < math.inf:
        raise ValueError(f"slab: index must be 1 or more, of the layer over that around it, got {index}")


def _ordinates(moments: Sequence[float], mu0: float | None, index: float) -> tuple[np.ndarray, ...]:
    """Panels' edges and nodes in the cosine outside; cosines within and weights of all, a beam's the last."""
    last = max((degree for degree, each in enumerate(moments) if abs(each) > FADED), default=0)
    width = min(WIDEST, TURNS * NODES / max(last, 1))
    if index == 1:
        edges = graded_edges(1.0, width)
        outside, weight = gauss(edges)
        mu = outside
    else:
        critical = math.sqrt((index - 1) * (index + 1)) / index
        # An angle outside is at least `index` times as wide as the angle within.
        edges = np.sin(np.linspace(0, math.pi / 2, 1 + math.ceil(math.pi / 2 / min(width * index, WIDEST))))
        outside, widths = gauss(edges)
        trapped, weight = gauss(graded_edges(critical, width))
        mu = np.sqrt(critical**2 + (outside / index) ** 2)
        mu, weight = np.append(mu, trapped), np.append(widths * outside / (index**2 * mu), weight)
    beam = [] if mu0 is None else [math.sqrt(1 - (1 - mu0) * (1 + mu0) / index**2)]
    return edges, outside, np.append(mu, beam), np.append(weight, np.zeros(len(beam)))


def graded_edges(top: float, width: float) -> np.ndarray:
    """Edges of panels from 0 to the cosine `top`: of equal angle at most `width`, and shrinking towards 0."""
    low = min(0.5 * top, width)
    turns = np.linspace(
        math.acos(low), math.acos(top), 1 + math.ceil((math.acos(low) - math.acos(top)) / width)
    )
    shrinking = []
    while low > GRAZING:
        low *= SHRINK if low > FINE else SHRINK**2
        shrinking.append(low)
    return np.concatenate([[0], shrinking[::-1], np.cos(turns)])


def gauss(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gauss's nodes and weights of all panels with these edges."""
    x, w = legendre_nodes(NODES)
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    return (middle + half * x).ravel(), (half * w).ravel()


def azimuthal_phase(moments: Sequence[float], mu: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means over azimuth of the phase function, of mean 1 over the sphere, between cosines of one hemisphere
    and of both.

    (n, n) each: p(mu_i, mu_j) and p(mu_i, -mu_j) [1].
    """
    degrees = np.arange(len(moments))
    terms = legendre.legvander(mu, len(moments) - 1)
    scaled = terms * ((2 * degrees + 1) * np.asarray(moments))
    return scaled @ terms.T, (scaled * (-1.0) ** degrees) @ terms.T


def _phase(moments: Sequence[float], mu: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same between ordinates, so that by the quadrature too all that is scattered goes somewhere."""
    forward, backward = azimuthal_phase(moments, mu)
    seen = weight > 0
    held = (forward + backward) @ weight
    forward[seen, seen] += (2 - held[seen]) / weight[seen]
    for beam in np.flatnonzero(~seen):
        for phase in (forward, backward):
            phase[beam] *= 2 / held[beam]
            phase[:, beam] *= 2 / held[beam]
    return forward, backward


def _lit(
    one: Layer, edges: np.ndarray, outside: np.ndarray, mu, weight, mu0: float | None, index: float
) -> Light:
    """Light on the layer between its faces."""
    flux, e, out = mu * weight, one.direct, len(outside)
    r = np.ones(len(mu))
    r[:out] = fresnel.reflectance(outside, index)
    if mu0 is not None:
        r[-1] = fresnel.reflectance(mu0, index)
    leaving = np.where(np.arange(len(mu)) < out, (1 - r) * flux, 0) * 2 * math.pi
    once = 1 / ((1 - r * e) * (1 + r * e))  # what passes straight, to and fro between the faces
    if mu0 is None:
        down = np.where(np.arange(len(mu)) < out, (1 - r) * index**2 / math.pi, 0) * once
        beams, shares = flux * down, leaving * e * down
        back, on = fresnel.diffuse_reflectance(index) + shares @ (r * e), shares.sum()
    else:
        down = np.zeros(len(mu))
        beams = np.append(down[:-1], (1 - r[-1]) * once[-1] / (2 * math.pi))
        on = 2 * math.pi * (1 - r[-1]) * e[-1] * beams[-1]
        back = r[-1] + on * r[-1] * e[-1]
    up_scattered, down_scattered = _between(one, r, flux, beams, r * e * beams)
    straight = (e * r * e * down, e * down)
    return Light(
        float(leaving @ up_scattered),
        float(leaving @ down_scattered),
        float(back),
        float(on),
        mu0,
        index,
        edges,
        *(each[:out].reshape(-1, NODES) for each in (up_scattered, down_scattered, *straight)),
    )


def _between(
    one: Layer, r: np.ndarray, flux: np.ndarray, beams_down: np.ndarray, beams_up: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Scattered light within the upper face, upwards, and within the lower one, downwards, of unscattered
    beams.

    beams_down, beams_up: their flux over 2 pi by ordinate, at the upper face and at the lower one.
    """
    up = one.reflection @ beams_down + one.transmission @ beams_up
    down = one.transmission @ beams_down + one.reflection @ beams_up
    if not r.any():
        return up, down
    back, on = one.reflection * flux, one.transmission * flux + np.diag(one.direct)
    unit = np.eye(len(r))
    solved = np.linalg.solve(unit - r[:, None] * back, r[:, None] * np.column_stack([on, down]))
    lower, alone = (
        solved[:, :-1],
        solved[:, -1],
    )  # what goes up from the lower face: of what comes down, and else
    falling = np.linalg.solve(unit - r[:, None] * (back + on @ lower), r * (up + on @ alone))
    rising = lower @ falling + alone
    return up + back @ falling + on @ rising, down + on @ falling + back @ rising


@lru_cache(maxsize=1)
def _to_coefficients() -> np.ndarray:
    """From values at Gauss's nodes to coefficients of Legendre polynomials."""
    x, w = legendre_nodes(NODES)
    return (legendre.legvander(x, NODES - 1) * w[:, None]).T * (np.arange(NODES) + 0.5)[:, None]
