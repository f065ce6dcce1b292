"""Bins of directions as polar angles and azimuths, what an ideal run would find in each, and curves along polar angle.

>>> L = result["sky"].radiance  # doctest: +SKIP
>>> bins = direction_bins(L)  # doctest: +SKIP
>>> plot_curves(polar_curves({"at 1 m": L}, {"at 1 m": law}), xlabel=POLAR_ANGLE, means=True)  # doctest: +SKIP
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from transport import EstimateArray
from transport.statistics.axes import POLAR_AXES, axis_words
from transport.viz.curves import FINE, Series

Radiance = Callable[[np.ndarray, np.ndarray], np.ndarray]  # of theta and phi [rad]

POLAR_ANGLE = f"{axis_words('theta')}  [°]"
SPREAD = 0.6  # of a bin, over which the points of several curves stand side by side
POLAR, AZIMUTHAL = 512, 32  # points a bin for its mean: a jump inside the bin is met to 1/512 of its height


@dataclass(frozen=True, eq=False)
class DirectionBins:
    """Radiance in (n, m) bins of a hemisphere: theta (n + 1) and phi (m + 1) are increasing edges [rad]."""

    theta: np.ndarray
    phi: np.ndarray
    value: np.ndarray
    error: np.ndarray
    unscored: np.ndarray
    doubtful: np.ndarray
    unit: object

    @property
    def angles(self) -> np.ndarray:
        """The polar angle that halves each bin's projected solid angle [rad], (n,)."""
        squares = np.sin(self.theta) ** 2
        return np.arcsin(np.sqrt((squares[1:] + squares[:-1]) / 2))

    @property
    def is_round(self) -> bool:
        """Whether one bin holds the full turn, so that there is no azimuth to tell."""
        return len(self.phi) == 2 and math.isclose(self.phi[1] - self.phi[0], 2 * math.pi)

    def column(self, azimuth: float) -> int | None:
        """Which bin holds this azimuth [rad], or None where none does."""
        turned = self.phi[0] + np.mod(azimuth - self.phi[0] + 1e-12, 2 * math.pi)
        place = int(np.searchsorted(self.phi, turned, side="right")) - 1
        return place if place < len(self.phi) - 1 else None

    def expected(self, exact: Radiance, column: int) -> np.ndarray:
        """Means of an exact radiance over the bins of one azimuth, weighted with cos(theta) d omega, (n,)."""
        squares = np.sin(self.theta) ** 2
        share = (np.arange(POLAR) + 0.5) / POLAR
        theta = np.arcsin(np.sqrt(squares[:-1, None] + np.diff(squares)[:, None] * share))
        low, high = self.phi[column : column + 2]
        phi = low + (high - low) * (np.arange(AZIMUTHAL) + 0.5) / AZIMUTHAL
        theta, phi = np.broadcast_arrays(theta[:, :, None], phi)
        return np.broadcast_to(exact(theta, phi), theta.shape).mean(axis=(1, 2))


def direction_bins(radiance: EstimateArray) -> DirectionBins:
    """The bins of an estimate with the axes mu or theta, and phi where there is one.

    Raises ValueError for other axes, and for directions beyond the horizon of a hemisphere.
    """
    polar = next((name for name in POLAR_AXES if name in radiance.dims), None)
    if polar is None or not set(radiance.dims) <= {polar, "phi"}:
        cure = "of other axes take one bin, such as radiance[3]"
        raise ValueError(
            f"A radiance by direction has the axes mu or theta, and phi; got {radiance.dims}; {cure}"
        )
    theta = radiance.coords[polar]
    if polar == "mu":
        theta = np.arccos(theta)
    if theta.max() > math.pi / 2 + 1e-9:
        cure = f"take the bins of one, such as radiance[..., :{np.count_nonzero(theta < 1.5707)}]"
        raise ValueError(
            f"A map shows one hemisphere, theta up to 90°; got {np.degrees(theta.max()):.4g}°; {cure}"
        )
    phi = radiance.coords.get("phi", np.array([0.0, 2 * math.pi]))
    upwards = slice(None, None, 1 if theta[0] < theta[-1] else -1)

    def arranged(array: np.ndarray) -> np.ndarray:
        array = array if "phi" in radiance.dims else array[:, None]
        return (array.T if radiance.dims[0] == "phi" else array)[upwards]

    fields = (radiance.value, radiance.error, radiance.reason == "no score", radiance.is_doubtful)
    return DirectionBins(theta[upwards], phi, *map(arranged, fields), radiance.unit)


def polar_curves(
    seen: Mapping[str, EstimateArray], exact: Mapping[str, Callable[[np.ndarray], np.ndarray]] | None = None
) -> dict[str, Series]:
    """Radiance at several places along polar angle [deg], side by side within each bin so that none hides another.

    Parameters
    ----------
    seen : mapping of str to EstimateArray
        Radiance with the axis mu or theta, and phi of one bin at most.
    exact : mapping of str to callable, optional
        The exact radiance of some of them, a function of an array theta [rad]; it may jump.

    Returns
    -------
    dict of str to Series

    Raises
    ------
    ValueError
        For several bins of azimuth, and for an exact radiance that belongs to none of them.
    """
    exact = exact or {}
    if strangers := exact.keys() - seen.keys():
        raise ValueError(f"polar_curves: exact names {sorted(strangers)}; the curves are {list(seen)}")
    found = {}
    for rank, (label, radiance) in enumerate(seen.items()):
        if len(radiance.coords.get("phi", ())) > 2:
            raise ValueError("polar_curves: each curve must have one bin of phi; take one by radiance[:, i]")
        law = exact.get(label)
        aside = SPREAD * ((rank + 0.5) / len(seen) - 0.5)
        found[label] = polar_series(radiance, law and (lambda theta, phi, law=law: law(theta)), aside=aside)
    return found


def polar_series(
    radiance: EstimateArray, exact: Radiance | None = None, column: int = 0, sign: int = 1, aside: float = 0.0
) -> Series:
    """The bins of one azimuth along polar angle [deg], each point at the angle that halves its projected solid angle.

    column: of bins of azimuth;  sign: -1 for angles to the left;  aside: shift of the points as a share of their bins.
    """
    bins = direction_bins(radiance)
    if "phi" in radiance.dims:
        radiance = radiance[tuple(column if name == "phi" else slice(None) for name in radiance.dims)]
    as_given = slice(None, None, -1 if "mu" in radiance.dims else 1)
    places = bins.angles + aside * np.diff(bins.theta)
    curve = means = None
    if exact is not None:
        low, high = bins.theta[[0, -1]]
        theta = np.union1d(np.linspace(low, high, FINE), np.geomspace(max(low, 1e-4 * high), high, FINE))
        phi = np.full(theta.shape, bins.phi[column : column + 2].mean())
        curve = sign * np.degrees(theta), np.broadcast_to(exact(theta, phi), theta.shape)
        means = bins.expected(exact, column)[as_given]
    x, places = (sign * np.degrees(angles)[as_given] for angles in (bins.theta, places))
    return Series(x, radiance, curve, means, places)
