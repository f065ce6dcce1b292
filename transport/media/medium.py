"""Homogeneous media and vacuum."""

from __future__ import annotations

import math
from dataclasses import field

from transport.media.base import Phase, settled_phase
from transport.validation import refuse, scene_object, settle_nonnegative, settle_positive, store


def _isotropic() -> Phase:
    from transport.emissions import Isotropic  # deferred: emissions import phases

    return Isotropic()


@scene_object
class Medium:
    """A homogeneous medium that absorbs, scatters, refracts and emits.

    Media are compared by value.

    Parameters
    ----------
    absorption : float, default 0
        Absorption coefficient [m^-1], zero or positive.
    scattering : float, default 0
        Scattering coefficient [m^-1], zero or positive.
    phase : phase function, default Isotropic()
        Isotropic(), HenyeyGreenstein, Rayleigh, Tabulated, or a Mixture of them.
    index : float, default 1
        Refractive index. A Dielectric boundary must agree with it; with a clock it divides the speed of
        light.
    emission : float, default 0
        Emitted power per volume and solid angle [W m^-3 sr^-1], isotropic.

    Raises
    ------
    SceneError
        If a coefficient is negative or not finite.

    Examples
    --------
    >>> import transport as tp
    >>> fog = tp.Medium(absorption=0.1, scattering=0.9, phase=tp.HenyeyGreenstein(0.75))
    >>> fog.extinction, fog.albedo
    (1.0, 0.9)
    """

    absorption: float = 0.0
    scattering: float = 0.0
    phase: Phase = field(default_factory=_isotropic)
    index: float = 1.0
    emission: float = 0.0

    def __post_init__(self) -> None:
        settle_nonnegative(self, "absorption", "scattering", "emission")
        settle_positive(self, "index")
        store(self, phase=settled_phase(self, self.phase))
        if not math.isfinite(self.extinction):
            refuse(self, f"absorption + scattering must be finite, got {self.extinction}; lower one of them")

    def __repr__(self) -> str:
        return f"Medium({', '.join(told(self, 'absorption', 'scattering', 'phase', 'index', 'emission'))})"

    @property
    def extinction(self) -> float:
        """Extinction coefficient, absorption + scattering.

        Returns
        -------
        float
            Coefficient [m^-1].
        """
        return self.absorption + self.scattering

    @property
    def albedo(self) -> float:
        """Single-scattering albedo, scattering / extinction; 0 without scattering.

        Returns
        -------
        float
        """
        return self.scattering / self.extinction if self.scattering else 0.0


@scene_object
class Vacuum:
    """Vacuum: no absorption, scattering or emission, refractive index 1.

    The space of a scene is vacuum unless a medium is given.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Vacuum().extinction
    0.0
    """

    absorption = scattering = extinction = albedo = emission = 0.0
    index = 1.0

    @property
    def phase(self) -> Phase:
        """Isotropic(); vacuum scatters nothing.

        Returns
        -------
        Isotropic
        """
        return _isotropic()


def told(medium: object, *names: str) -> list[str]:
    """Return the arguments of a medium as source text, without those at their defaults."""
    plain = {"absorption": 0.0, "scattering": 0.0, "phase": _isotropic(), "index": 1.0, "emission": 0.0}
    return [f"{name}={getattr(medium, name)!r}" for name in names if getattr(medium, name) != plain[name]]


def plain(medium):
    """Return the canonical form of a medium, equal for all that act alike.

    Without scattering it has no phase function; without any effect it is Vacuum().
    """
    if not isinstance(medium, Medium):
        return medium
    if medium == Medium() or (medium.scattering == 0 and medium == Medium(phase=medium.phase)):
        return Vacuum()
    if medium.scattering == 0:
        return Medium(absorption=medium.absorption, index=medium.index, emission=medium.emission)
    return medium
