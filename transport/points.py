"""Point detectors: the fluence rate in one place, by what every event would send straight there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from transport.fields import VectorField
from transport.sides import AnyDetector
from transport.validation import refuse, scene_object, settle_name, settle_vector

if TYPE_CHECKING:
    pass


@scene_object
class PointDetector(AnyDetector):
    """The fluence rate at `position` [m]: what would reach it, in the mean, from each event of each history.

    From births, diffuse walls and scattering rays go straight to the point: what each brings is the chance
    per area to be sent there, times exp(-optical depth) on the way; what stops light stops it (next-event
    estimation).  So it sees what no flight ever reaches: behind shields, through ducts, far away.

    Scored at collisions, 1/r^2 would make the variance infinite in a medium that scatters about the point:
    the error would fall as N^(-1/3).  Here it is finite.  What the medium about the point scatters last comes
    by a detour from each event, to a place drawn with a density as 1/(a^2 b^2), a and b its distances from
    event and point: scores go as 1/r (Kalos 1963; Steinberg and Kalos 1971).  What others scatter is told
    from the flights through them, at a place drawn equiangularly about the point (Kulla and Fajardo 2012):
    scores go as 1/D, D the distance of the flight's line.  Measured in a fog of albedo 0.9, a mean free path
    from a point source: relative errors of 3.5 %, 1.2 % and 0.38 % with 10^3, 10^4 and 10^5 particles, and z
    of spread 1.  A medium that scatters sharply forwards makes it noisy (11 % instead of 1.2 % at g = 0.8,
    36 % at 0.9, and twice what its error says): the result warns where a few scores carry the error.  A Source
    that fills a ball or a box near the point is sampled along lines through that.

    Close to a diffuse wall, to a diffuse emitter or to a thick medium (against their extent) errors grow, and a
    short run claims too little: half of what is there comes from about as far as the point is off, and of a wall at a
    hundred-thousandth of its width all of that is missing, for no history comes so close to the foot.  The result warns
    where a single one there would matter; move the point away or take a VolumeDetector.  Behind what absorbs, where
    weights are small, that warning may be needless.  In a wide Beam through a scattering medium about the
    point the variance grows as the logarithm of N.  Beams send nothing straight to a point: in a wide beam
    only what has been scattered or reflected counts, on a pencil beam points are refused.  Mirrors, lenses, Dielectric and Glossy surfaces
    are refused, for no straight line leads through them; so are points on a Black or Diffuse surface, on what
    emits and in a point source (on a Transparent surface they may lie), sources with an `aim` and scenes with a
    duration.
    """

    position: VectorField
    name: str

    def __post_init__(self) -> None:
        settle_vector(self, "position")
        settle_name(self)
        if self.name is None:
            refuse(self, "name must be given, got None; write name='there'")

    def check_clock(self, duration: float | None) -> None:
        """Refuse a clock: when a ray would arrive is not known."""
        if duration is not None:
            cure = "leave duration out, or count by a small VolumeDetector"
            refuse(self, f"a scene with a PointDetector must be steady, got duration={duration!r}; {cure}")
