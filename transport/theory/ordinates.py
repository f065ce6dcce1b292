"""Discrete ordinates: reflection and transmission of a plane layer.

The layer has any depth, albedo, phase function and index. The azimuthal mean of the radiance obeys,
with p(mu, mu') = sum_l (2 l + 1) chi_l P_l(mu) P_l(mu') from the Legendre moments chi_l of the phase
function,

    mu dI/dtau = -I + (a/2) int_-1^1 p(mu, mu') I(mu') dmu'

(Chandrasekhar 1960, ch. 1 and 6). The integral uses Gauss's rule on panels of each hemisphere. The
panels become narrower towards grazing, where I varies as mu log mu and exp(-tau/mu), and are as narrow
as the phase function requires. The depth is treated by doubling (transport/theory/ordinates.py). Beams
are additional ordinates of weight 0; their unscattered part is kept apart from I. The quadrature's
error in sum_j w_j p_ij = 2, about 1e-9, is added to forward scattering, so that energy is conserved.

If the layer has an index n above that of its surroundings, both faces reflect by Fresnel's law, with
light unpolarised at each crossing. The ordinates are then Gauss's in the cosine outside, in which
Fresnel's formulas are analytic, plus panels beyond the critical angle. With u upward and d downward
radiance inside the faces, and r the faces' reflectance, d = s + r (R d + T u) and u = r (T d + R u): u
is eliminated first, so that nothing cancels. Outside, L = (1 - r) u/n^2.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from transport.statistics.quadrature import legendre_nodes
from transport.theory import fresnel

# ---- Adding and doubling: reflection and transmission of a plane layer, built up from a very thin one.
#
# Light is averaged over azimuth and given at ordinates of cosine mu with weights w; I is its mean
# radiance over azimuth. A layer is two symmetric kernels R and T, and the direct transmission
# e = exp(-tau/mu):
#
#     reflected I_i = sum_j R_ij w_j mu_j I_j,    transmitted I_i = e_i I_i + sum_j T_ij w_j mu_j I_j.
#
# An ordinate of weight 0 receives light but contributes none to integrals: a beam of flux E at mu_j gives
# the radiance R_ij E/2 pi. Two equal layers on top of each other are, with w for w mu,
#
#     S = (1 - Q)^-1 Q,  Q = R w R,    D = T + S e + S w T,  U = R e + R w D,
#     R' = R + e U + T w U,    T' = e D + T e + T w D
#
# (van de Hulst 1963; Hansen and Travis 1974, Space Sci. Rev. 16, 527): sums of positive terms, so that
# nothing cancels at a depth of 1e-12 or of 1e4. The first layer, of depth `start`, obeys
# out - in = start/mu (a P - 1) (in + out)/2, P the mean over directions: it conserves energy exactly, is
# accurate to (start/mu)^2/12, and has the direct part (2 mu - start)/(2 mu + start).

MAX_START_DEPTH = 0.1  # depth over mu of the first layer, at the quadrature's lowest cosine
MAX_START_DEPTH_OF_BEAM = 2e-6  # the same for a beam, whose direct part is then accurate to 1e-12
MIN_TRANSMISSION = 1e-20  # transmitted share below which a layer counts as semi-infinite
MAX_DOUBLINGS = 200  # largest number of doublings


class Layer(NamedTuple):
    """Kernels of a layer and its direct transmission.

    Parameters
    ----------
    reflection : ndarray
        Reflection kernel R, shape (n, n) [1].
    transmission : ndarray
        Kernel T of diffuse transmission, shape (n, n) [1].
    direct : ndarray
        Direct transmission of each ordinate, shape (n,) [1].
    """

    reflection: np.ndarray
    transmission: np.ndarray
    direct: np.ndarray


def layer(
    depth: float,
    albedo: float,
    forward: np.ndarray,
    backward: np.ndarray,
    mu: np.ndarray,
    weight: np.ndarray,
) -> Layer:
    """Return the kernels of a homogeneous layer.

    Parameters
    ----------
    depth : float
        Optical depth, above 0; math.inf for a half space of albedo below 1 [1].
    albedo : float
        Single-scattering albedo, 0 to 1 [1].
    forward : ndarray
        Phase function between ordinates of one hemisphere, mean 1 over the sphere, shape (n, n) [1].
    backward : ndarray
        Phase function between ordinates of opposite hemispheres, shape (n, n) [1].
    mu : ndarray
        Cosines of the ordinates, shape (n,) [1].
    weight : ndarray
        Quadrature weights, 0 for beams, shape (n,) [1].

    Returns
    -------
    Layer
        Kernels of the layer.

    Raises
    ------
    ValueError
        If the layer is semi-infinite and the albedo is 1.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.ordinates import layer
    >>> one = np.ones((1, 1))
    >>> print(layer(1.0, 1.0, one, one, np.array([0.5]), np.array([1.0])).direct.round(4))
    [0.1352]
    """
    if math.isinf(depth):
        return _semi_infinite(_start_depth(mu, weight), albedo, forward, backward, mu, weight)
    *_, last = layers(depth, albedo, forward, backward, mu, weight)
    return last


def layers(
    depth: float, albedo: float, forward: np.ndarray, backward: np.ndarray, mu: np.ndarray, weight: np.ndarray
) -> Iterator[Layer]:
    """Yield the layers of depth/2^k, ..., depth/2 and depth, as doubling computes them.

    Parameters
    ----------
    depth : float
        Optical depth of the layer, above 0 [1].
    albedo : float
        Single-scattering albedo, 0 to 1 [1].
    forward : ndarray
        Phase function between ordinates of one hemisphere, mean 1 over the sphere, shape (n, n) [1].
    backward : ndarray
        Phase function between ordinates of opposite hemispheres, shape (n, n) [1].
    mu : ndarray
        Cosines of the ordinates, shape (n,) [1].
    weight : ndarray
        Quadrature weights, 0 for beams, shape (n,) [1].

    Returns
    -------
    iterator of Layer
        Layers in increasing depth; the last has the depth `depth`.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.ordinates import layers
    >>> one = np.ones((1, 1))
    >>> len(list(layers(1.0, 1.0, one, one, np.array([0.5]), np.array([1.0]))))
    6
    """
    times = max(0, math.ceil(math.log2(depth / _start_depth(mu, weight))))
    start = math.ldexp(depth, -times)
    one = thin_layer(start, albedo, forward, backward, mu, weight)
    yield one
    for k in range(times):
        with np.errstate(under="ignore"):
            one = doubled(one, mu * weight, direct(start, k + 1, mu))
        yield one


def _start_depth(mu: np.ndarray, weight: np.ndarray) -> float:
    """Largest permitted optical depth of the first layer."""
    return min(
        MAX_START_DEPTH * mu[weight > 0].min(),
        MAX_START_DEPTH_OF_BEAM * mu[weight == 0].min(initial=math.inf),
    )


def thin_layer(
    depth: float, albedo: float, forward: np.ndarray, backward: np.ndarray, mu: np.ndarray, weight: np.ndarray
) -> Layer:
    """Return the kernels of a layer so thin that its source is the mean of the entering and leaving light.

    Parameters
    ----------
    depth : float
        Optical depth of the layer, above 0 [1].
    albedo : float
        Single-scattering albedo, 0 to 1 [1].
    forward : ndarray
        Phase function between ordinates of one hemisphere, mean 1 over the sphere, shape (n, n) [1].
    backward : ndarray
        Phase function between ordinates of opposite hemispheres, shape (n, n) [1].
    mu : ndarray
        Cosines of the ordinates, shape (n,) [1].
    weight : ndarray
        Quadrature weights, 0 for beams, shape (n,) [1].

    Returns
    -------
    Layer
        Kernels, computed without cancellation.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.ordinates import thin_layer
    >>> one = np.ones((1, 1))
    >>> print(thin_layer(0.01, 1.0, one, one, np.array([0.5]), np.array([1.0])).direct.round(4))
    [0.9802]
    """
    n, reach = len(mu), 2 * mu + depth
    phase, reaches = np.block([[forward, backward], [backward, forward]]), np.tile(reach, 2)[:, None]
    again = (albedo * depth / 2) * phase * np.tile(weight, 2) / reaches
    once = (2 * albedo * depth) * phase[:, :n] / reaches / reach
    kernels = np.linalg.solve(np.eye(2 * n) - again, once)
    return Layer(kernels[n:], kernels[:n], direct(depth, 0, mu))


def direct(start: float, times: int, mu: np.ndarray) -> np.ndarray:
    """Direct transmission after a number of doublings of the first layer.

    Parameters
    ----------
    start : float
        Optical depth of the first layer [1].
    times : int
        Number of doublings.
    mu : ndarray
        Cosines of the ordinates, shape (n,) [1].

    Returns
    -------
    ndarray
        Direct transmission, shape (n,) [1].

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.ordinates import direct
    >>> print(direct(0.01, 3, np.array([0.5])).round(4))
    [0.8521]
    """
    return np.exp(-np.ldexp(np.arctanh(start / (2 * mu)), times + 1))


def doubled(one: Layer, flux: np.ndarray, straight: np.ndarray) -> Layer:
    """Return the kernels of a layer on top of an equal one.

    Parameters
    ----------
    one : Layer
        The single layer.
    flux : ndarray
        w mu of the ordinates, shape (n,) [1].
    straight : ndarray
        Direct transmission of both layers together, shape (n,) [1].

    Returns
    -------
    Layer
        Kernels of the double layer.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.ordinates import doubled, thin_layer
    >>> one = thin_layer(0.01, 1.0, *[np.ones((1, 1))] * 2, np.array([0.5]), np.array([1.0]))
    >>> print(doubled(one, np.array([0.5]), one.direct**2).direct.round(4))
    [0.9608]
    """
    r, t, e = one
    between = (r * flux) @ r
    echo = np.linalg.solve(np.eye(len(e)) - between * flux, between)
    down = t + echo * e + (echo * flux) @ t
    up = r * e + (r * flux) @ down
    through = t * flux
    return Layer(r + e[:, None] * up + through @ up, e[:, None] * down + t * e + through @ down, straight)


def _semi_infinite(thin, albedo, forward, backward, mu, weight) -> Layer:
    """Double a layer until it transmits less than MIN_TRANSMISSION."""
    one, flux = thin_layer(thin, albedo, forward, backward, mu, weight), mu * weight
    with np.errstate(under="ignore"):
        for k in range(MAX_DOUBLINGS):
            one = doubled(one, flux, direct(thin, k + 1, mu))
            if 2 * flux @ (one.transmission @ flux) + flux @ one.direct < MIN_TRANSMISSION:
                return one
    raise ValueError(f"layer: a semi-infinite medium needs an albedo below 1, got {albedo!r}")


# ---- Reflection and transmission by discrete ordinates.

NODES = 12  # nodes per panel
GRAZING = 1e-5  # mu near which the lowest panel ends
SHRINK, FINE = 0.5, 0.01  # ratio of a panel to the next above it, down to this mu; below it the ratio squared
NEGLIGIBLE_MOMENT = 1e-8  # Legendre moments below this are not resolved
WIDTH_FACTOR = 1.2  # panel width [rad] times degree of the last moment to resolve, over NODES
MAX_WIDTH = 0.5  # rad, largest width of a panel
LAST_MOMENT = 1e-14  # moment at which the Henyey-Greenstein series ends
ISOTROPIC, RAYLEIGH = (1.0,), (1.0, 0.0, 0.1)


def henyey_greenstein(g: float) -> tuple[float, ...]:
    """Legendre moments g^l of the phase function of Henyey and Greenstein (1941).

    Parameters
    ----------
    g : float
        Mean cosine of scattering, from -0.99 to 0.99 [1].

    Returns
    -------
    tuple of float
        Moments down to 1e-14 [1].

    Raises
    ------
    ValueError
        If abs(g) exceeds 0.99.

    Examples
    --------
    >>> from transport.theory.ordinates import henyey_greenstein
    >>> henyey_greenstein(0.5)[:3]
    (1.0, 0.5, 0.25)
    """
    if not abs(g) <= 0.99:
        raise ValueError(
            f"henyey_greenstein: g must be between -0.99 and 0.99 for discrete ordinates, got {g}"
        )
    count = 1 if g == 0 else 1 + math.ceil(math.log(LAST_MOMENT) / math.log(abs(g)))
    return tuple(float(g) ** degree for degree in range(count))


def moments_of(mu: np.ndarray, density: np.ndarray, count: int) -> tuple[float, ...]:
    """Legendre moments of a tabulated phase function.

    Parameters
    ----------
    mu : ndarray
        Cosines of the table, increasing from -1 to 1, shape (n,) [1].
    density : ndarray
        Density at these cosines, linear between them, in any unit, shape (n,).
    count : int
        Number of moments.

    Returns
    -------
    tuple of float
        Moments, the first of them 1 [1].

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.ordinates import moments_of
    >>> [round(each, 4) for each in moments_of(np.array([-1.0, 1.0]), np.array([0.0, 1.0]), 3)]
    [1.0, 0.3333, 0.0]
    """
    x, w = legendre_nodes(math.ceil((count + 3) / 2))
    half, middle = np.diff(mu)[:, None] / 2, (np.asarray(mu)[1:] + np.asarray(mu)[:-1])[:, None] / 2
    places, weights = (middle + half * x).ravel(), (half * w).ravel()
    found = (weights * np.interp(places, mu, density)) @ legendre.legvander(places, count - 1)
    return tuple(float(each) for each in found / found[0])


@dataclass(frozen=True, eq=False)
class Light:
    """Light that leaves a layer, as shares of the incident flux.

    Parameters
    ----------
    reflected_diffuse : float
        Reflected share that was scattered [1].
    transmitted_diffuse : float
        Transmitted share that was scattered [1].
    unscattered_back : float
        Share that the faces reflect without scattering [1].
    unscattered_on : float
        Share that passes without scattering [1].
    mu0 : float or None
        Cosine of incidence outside, in (0, 1]; None: Lambertian light [1].
    index : float
        Index of the layer over that of its surroundings, at least 1 [1].
    edges : ndarray
        Edges of the panels in the cosine outside, shape (panels + 1,) [1].
    up : ndarray
        Scattered upward radiance inside the upper face per incident irradiance, azimuthal mean at the
        panels' nodes, shape (panels, nodes) [sr^-1].
    down : ndarray
        Scattered downward radiance inside the lower face, same form [sr^-1].
    up_straight : ndarray
        Unscattered part of the upward radiance for Lambertian light, same form [sr^-1].
    down_straight : ndarray
        Unscattered part of the downward radiance for Lambertian light, same form [sr^-1].
    """

    reflected_diffuse: float
    transmitted_diffuse: float
    unscattered_back: float
    unscattered_on: float
    mu0: float | None
    index: float
    edges: np.ndarray  # edges of the panels in the cosine outside
    up: np.ndarray
    down: np.ndarray
    up_straight: np.ndarray
    down_straight: np.ndarray

    @property
    def reflected(self) -> float:
        """Reflected share, unscattered or scattered [1]."""
        return self.reflected_diffuse + self.unscattered_back

    @property
    def transmitted(self) -> float:
        """Transmitted share, unscattered or scattered [1]."""
        return self.transmitted_diffuse + self.unscattered_on

    @property
    def absorbed(self) -> float:
        """Absorbed share [1]."""
        return 1 - self.reflected - self.transmitted

    def reflected_radiance(self, mu: np.ndarray) -> np.ndarray:
        """Return the reflected scattered radiance per incident irradiance.

        Parameters
        ----------
        mu : ndarray
            Cosines outside [1].

        Returns
        -------
        ndarray
            Azimuthal mean, shape of `mu` [sr^-1].
        """
        return self._radiance(self.up, mu)

    def transmitted_radiance(self, mu: np.ndarray) -> np.ndarray:
        """Return the transmitted scattered radiance per incident irradiance.

        Parameters
        ----------
        mu : ndarray
            Cosines outside [1].

        Returns
        -------
        ndarray
            Azimuthal mean, shape of `mu` [sr^-1].
        """
        return self._radiance(self.down, mu)

    def reflected_in(self, edges: np.ndarray, straight: bool = False) -> np.ndarray:
        """Return the shares reflected into bins of cosine after scattering.

        Parameters
        ----------
        edges : ndarray
            Edges of the bins of cosine, increasing in [0, 1], shape (bins + 1,) [1].
        straight : bool, default False
            Whether to include, for Lambertian light, the share that the faces reflect without
            scattering.

        Returns
        -------
        ndarray
            Shares of the incident flux, shape (bins,) [1].

        Raises
        ------
        ValueError
            If the edges do not increase within 0 to 1.
        """
        if not straight:
            return self._shares(self.up, edges)
        return self._shares(self.up + self.up_straight, edges) + self._specular_in(edges)

    def transmitted_in(self, edges: np.ndarray, straight: bool = False) -> np.ndarray:
        """Return the shares transmitted into bins of cosine after scattering.

        Parameters
        ----------
        edges : ndarray
            Edges of the bins of cosine, increasing in [0, 1], shape (bins + 1,) [1].
        straight : bool, default False
            Whether to include, for Lambertian light, the unscattered share.

        Returns
        -------
        ndarray
            Shares of the incident flux, shape (bins,) [1].

        Raises
        ------
        ValueError
            If the edges do not increase within 0 to 1.
        """
        return self._shares(self.down + self.down_straight if straight else self.down, edges)

    def _specular_in(self, edges: np.ndarray) -> np.ndarray:
        """2 int r mu dmu over each bin: Lambertian light that the upper face reflects outside."""
        if self.mu0 is not None or self.index == 1:
            return np.zeros(len(edges) - 1)
        cuts = np.union1d(edges, np.linspace(edges[0], edges[-1], 9))
        mu, weight = gauss(cuts)
        parts = (2 * weight * mu * fresnel.reflectance(mu, self.index)).reshape(-1, NODES).sum(axis=1)
        return np.add.reduceat(parts, np.searchsorted(cuts, edges[:-1]))

    def _radiance(self, values: np.ndarray, mu: np.ndarray) -> np.ndarray:
        """Radiance outside, by the polynomial of each panel and the face's transmittance over n^2."""
        mu = np.asarray(mu, dtype=float)
        panel = np.clip(np.searchsorted(self.edges, mu, side="right") - 1, 0, len(self.edges) - 2)
        low, high = self.edges[panel], self.edges[panel + 1]
        series = (values @ _legendre_transform().T)[panel]
        terms = legendre.legvander((2 * mu - low - high) / (high - low), NODES - 1)
        through = fresnel.transmittance(mu, self.index) / self.index**2
        return through * (series * terms.reshape(series.shape)).sum(axis=-1)

    def _shares(self, values: np.ndarray, edges: np.ndarray) -> np.ndarray:
        """2 pi int L mu dmu over each bin, panel by panel."""
        edges = np.asarray(edges, dtype=float)
        if edges.ndim != 1 or not (np.diff(edges) > 0).all() or edges[0] < 0 or edges[-1] > 1:
            raise ValueError(f"Light: edges must increase within 0 to 1, got {edges}")
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
    """Light that leaves an infinite plane layer between two equal media; the result is cached.

    Parameters
    ----------
    depth : float
        Optical depth of the layer, above 0; math.inf for a half space of albedo below 1 [1].
    albedo : float
        Single-scattering albedo, from 0 to 1 [1].
    moments : tuple of float, default ISOTROPIC
        Legendre moments of the phase function, from 1 on [1].
    mu0 : float or None, default 1.0
        Cosine of incidence outside, in (0, 1]; None: Lambertian light [1].
    index : float, default 1.0
        Index of the layer over that of its surroundings, at least 1 [1].

    Returns
    -------
    Light
        Shares and radiances of the reflected and transmitted light.

    Raises
    ------
    ValueError
        If an argument is out of range.

    Notes
    -----
    Good to 1e-7 or better for abs(g) up to 0.9 (against other methods in the tests).

    Examples
    --------
    >>> from transport.theory.ordinates import slab
    >>> print(f"{slab(0.1, 0.9).reflected:.4g}")
    0.0421
    """
    _check(depth, albedo, moments, mu0, index)
    edges, outside, mu, weight = _ordinates(moments, mu0, index)
    one = layer(depth, albedo, *_phase(moments, mu, weight), mu, weight)
    return _light_of_layer(one, edges, outside, mu, weight, mu0, index)


def halved_slabs(
    depth: float,
    times: int,
    albedo: float,
    moments: Sequence[float] = ISOTROPIC,
    mu0: float | None = 1.0,
    index: float = 1.0,
) -> list[Light]:
    """Light that leaves layers of depth/2^times, ..., depth/2 and depth, at the cost of the last.

    Parameters
    ----------
    depth : float
        Optical depth of the layer, above 0; math.inf for a half space of albedo below 1 [1].
    times : int
        Number of halvings.
    albedo : float
        Single-scattering albedo, from 0 to 1 [1].
    moments : tuple of float, default ISOTROPIC
        Legendre moments of the phase function, from 1 on [1].
    mu0 : float or None, default 1.0
        Cosine of incidence outside, in (0, 1]; None: Lambertian light [1].
    index : float, default 1.0
        Index of the layer over that of its surroundings, at least 1 [1].

    Returns
    -------
    list[Light]
        One Light per depth, in increasing depth.

    Raises
    ------
    ValueError
        If an argument is out of range.

    Examples
    --------
    >>> from transport.theory.ordinates import halved_slabs
    >>> [f"{light.reflected:.4g}" for light in halved_slabs(1e-3, 1, 0.9, mu0=None)]
    ['0.0004489', '0.0008961']
    """
    _check(depth, albedo, moments, mu0, index)
    edges, outside, mu, weight = _ordinates(moments, mu0, index)
    found = deque(layers(depth, albedo, *_phase(moments, mu, weight), mu, weight), maxlen=times + 1)
    return [_light_of_layer(one, edges, outside, mu, weight, mu0, index) for one in found]


def half_space(
    albedo: float, moments: Sequence[float] = ISOTROPIC, mu0: float | None = 1.0, index: float = 1.0
) -> Light:
    """Light that leaves a medium that fills the half space below a plane.

    Parameters
    ----------
    albedo : float
        Single-scattering albedo, below 1 [1]; for an albedo of 1 all light returns.
    moments : tuple of float, default ISOTROPIC
        Legendre moments of the phase function, from 1 on [1].
    mu0 : float or None, default 1.0
        Cosine of incidence outside, in (0, 1]; None: Lambertian light [1].
    index : float, default 1.0
        Index of the layer over that of its surroundings, at least 1 [1].

    Returns
    -------
    Light
        Shares and radiances of the reflected light.

    Raises
    ------
    ValueError
        If an argument is out of range.

    Examples
    --------
    >>> from transport.theory.ordinates import half_space
    >>> print(f"{half_space(0.5, mu0=None).reflected:.4g}")
    0.1465
    """
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
        raise ValueError(f"slab: index must be 1 or more, relative to the surroundings, got {index}")


def _ordinates(moments: Sequence[float], mu0: float | None, index: float) -> tuple[np.ndarray, ...]:
    """Panel edges and nodes in the cosine outside; cosines inside and weights of all ordinates."""
    last = max((degree for degree, each in enumerate(moments) if abs(each) > NEGLIGIBLE_MOMENT), default=0)
    width = min(MAX_WIDTH, WIDTH_FACTOR * NODES / max(last, 1))
    if index == 1:
        edges = graded_edges(1.0, width)
        outside, weight = gauss(edges)
        mu = outside
    else:
        critical = math.sqrt((index - 1) * (index + 1)) / index
        # An angle outside is at least `index` times as wide as the angle within.
        edges = np.sin(
            np.linspace(0, math.pi / 2, 1 + math.ceil(math.pi / 2 / min(width * index, MAX_WIDTH)))
        )
        outside, widths = gauss(edges)
        trapped, weight = gauss(graded_edges(critical, width))
        mu = np.sqrt(critical**2 + (outside / index) ** 2)
        mu, weight = np.append(mu, trapped), np.append(widths * outside / (index**2 * mu), weight)
    beam = [] if mu0 is None else [math.sqrt(1 - (1 - mu0) * (1 + mu0) / index**2)]
    return edges, outside, np.append(mu, beam), np.append(weight, np.zeros(len(beam)))


def graded_edges(top: float, width: float) -> np.ndarray:
    """Edges of panels from 0 to the cosine `top`: of equal angle, and shrinking towards 0.

    Parameters
    ----------
    top : float
        Largest cosine [1].
    width : float
        Largest width of a panel [rad].

    Returns
    -------
    ndarray
        Edges, increasing, shape (panels + 1,) [1].

    Examples
    --------
    >>> from transport.theory.ordinates import graded_edges
    >>> len(graded_edges(1.0, 0.5))
    16
    """
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
    """Gauss-Legendre nodes and weights of all panels between edges.

    Parameters
    ----------
    edges : ndarray
        Edges of the panels, increasing, shape (panels + 1,).

    Returns
    -------
    tuple of ndarray
        Nodes and weights, shape (panels NODES,) each.

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.ordinates import gauss
    >>> print(f"{gauss(np.array([0.0, 0.5, 1.0]))[1].sum():.4g}")
    1
    """
    x, w = legendre_nodes(NODES)
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    return (middle + half * x).ravel(), (half * w).ravel()


def azimuthal_phase(moments: Sequence[float], mu: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Azimuthal means of the phase function, normalised to a mean of 1 over the sphere.

    Parameters
    ----------
    moments : tuple of float
        Legendre moments of the phase function, from 1 on [1].
    mu : ndarray
        Cosines, shape (n,) [1].

    Returns
    -------
    tuple of ndarray
        Matrices p(mu_i, mu_j) and p(mu_i, -mu_j), shape (n, n) each [1].

    Examples
    --------
    >>> import numpy as np
    >>> from transport.theory.ordinates import azimuthal_phase
    >>> print(azimuthal_phase((1.0, 0.5), np.array([1.0]))[0].round(4))
    [[2.5]]
    """
    degrees = np.arange(len(moments))
    terms = legendre.legvander(mu, len(moments) - 1)
    scaled = terms * ((2 * degrees + 1) * np.asarray(moments))
    return scaled @ terms.T, (scaled * (-1.0) ** degrees) @ terms.T


def _phase(moments: Sequence[float], mu: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Azimuthal phase function between ordinates, corrected so that the quadrature conserves energy."""
    forward, backward = azimuthal_phase(moments, mu)
    seen = weight > 0
    held = (forward + backward) @ weight
    forward[seen, seen] += (2 - held[seen]) / weight[seen]
    for beam in np.flatnonzero(~seen):
        for phase in (forward, backward):
            phase[beam] *= 2 / held[beam]
            phase[:, beam] *= 2 / held[beam]
    return forward, backward


def _light_of_layer(
    one: Layer, edges: np.ndarray, outside: np.ndarray, mu, weight, mu0: float | None, index: float
) -> Light:
    """Light of a layer between its faces."""
    flux, e, out = mu * weight, one.direct, len(outside)
    r = np.ones(len(mu))
    r[:out] = fresnel.reflectance(outside, index)
    if mu0 is not None:
        r[-1] = fresnel.reflectance(mu0, index)
    leaving = np.where(np.arange(len(mu)) < out, (1 - r) * flux, 0) * 2 * math.pi
    once = 1 / ((1 - r * e) * (1 + r * e))  # unscattered light, reflected between the faces
    if mu0 is None:
        down = np.where(np.arange(len(mu)) < out, (1 - r) * index**2 / math.pi, 0) * once
        beams, shares = flux * down, leaving * e * down
        back, on = fresnel.diffuse_reflectance(index) + shares @ (r * e), shares.sum()
    else:
        down = np.zeros(len(mu))
        beams = np.append(down[:-1], (1 - r[-1]) * once[-1] / (2 * math.pi))
        on = 2 * math.pi * (1 - r[-1]) * e[-1] * beams[-1]
        back = r[-1] + on * r[-1] * e[-1]
    up_scattered, down_scattered = _between_faces(one, r, flux, beams, r * e * beams)
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


def _between_faces(
    one: Layer, r: np.ndarray, flux: np.ndarray, beams_down: np.ndarray, beams_up: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Scattered light of unscattered beams: upward inside the upper face, downward inside the lower face.

    beams_down, beams_up: flux of the beams over 2 pi by ordinate, at the upper and at the lower face.
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
    )  # upward light at the lower face: per downward light at the upper face, and the rest
    falling = np.linalg.solve(unit - r[:, None] * (back + on @ lower), r * (up + on @ alone))
    rising = lower @ falling + alone
    return up + back @ falling + on @ rising, down + on @ falling + back @ rising


@lru_cache(maxsize=1)
def _legendre_transform() -> np.ndarray:
    """Matrix from values at Gauss's nodes to Legendre coefficients."""
    x, w = legendre_nodes(NODES)
    return (legendre.legvander(x, NODES - 1) * w[:, None]).T * (np.arange(NODES) + 0.5)[:, None]
