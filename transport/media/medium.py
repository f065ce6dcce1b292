"""Homogeneous media, and none at all."""

from __future__ import annotations

import math
from dataclasses import field

from transport.media.base import Phase, settled_phase
from transport.validation import refuse, scene_object, settle_nonnegative, settle_positive, store


def _isotropic() -> Phase:
    from transport.emissions import Isotropic  # emissions are phases as well

    return Isotropic()


@scene_object
class Medium:
    """What fills space evenly: it absorbs, scatters by `phase`, bends light by its `index`, and glows.

    absorption, scattering: coefficients [m^-1];  index: of refraction, which a boundary of a Dielectric must agree with
    and which divides the speed of light where a clock runs;  emission: radiant power per volume and solid angle
    [W m^-3 sr^-1], the same in all directions.  Media are compared by value.
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
        """absorption + scattering [m^-1]."""
        return self.absorption + self.scattering

    @property
    def albedo(self) -> float:
        """scattering / extinction; 0 where nothing happens."""
        return self.scattering / self.extinction if self.scattering else 0.0


@scene_object
class Vacuum:
    """Nothing: what fills a scene where no medium is named."""

    absorption = scattering = extinction = albedo = emission = 0.0
    index = 1.0

    @property
    def phase(self) -> Phase:
        """Isotropic(): nothing is scattered."""
        return _isotropic()


def told(medium: object, *names: str) -> list[str]:
    """Parameters of a medium, as they are written; those left out where they are none."""
    plain = {"absorption": 0.0, "scattering": 0.0, "phase": _isotropic(), "index": 1.0, "emission": 0.0}
    return [f"{name}={getattr(medium, name)!r}" for name in names if getattr(medium, name) != plain[name]]


def plain(medium):
    """The medium as all that act alike are written: no phase where nothing scatters, Vacuum where nothing happens."""
    if not isinstance(medium, Medium):
        return medium
    if medium == Medium() or (medium.scattering == 0 and medium == Medium(phase=medium.phase)):
        return Vacuum()
    if medium.scattering == 0:
        return Medium(absorption=medium.absorption, index=medium.index, emission=medium.emission)
    return medium
