"""Point detectors: the fluence rate in one place, by asking at every event what would come straight from there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from transport.emissions import Beam, Isotropic, Lambertian
from transport.materials import Black, Diffuse, Transparent, simple_parts
from transport.shapes import Point
from transport.shapes.base import ROUNDING
from transport.shapes.distances import least_distance
from transport.solids import magnitude
from transport.validation import refuse, scene_object, settle_name, settle_vector, shown
from transport.vectors import Vector

if TYPE_CHECKING:
    from transport.materials import Surface
    from transport.scene import Scene
    from transport.sources import Source

SEEN_BY = (Black, Diffuse)  # materials that a straight line ends at, and what leaves them is known
CLOSE = 64 * ROUNDING  # of the size of numbers: on a surface


@scene_object
class PointDetector:
    """The fluence rate at `position` [m]: what would reach it, in the mean, from every event of every history.

    From each birth, diffuse reflection and flight through a scattering medium a ray goes straight to the point: its weight is
    the chance per area to be sent there, times exp(-optical depth) on the way; what stops light stops it (next-event
    estimation; Kalos 1963).  So it sees what no flight ever reaches: behind shields, through ducts, far away.

    On each flight the place of scattering is drawn equiangularly about the point (Kulla and Fajardo 2012): 1/r^2 becomes 1/D,
    D the least distance of the flight's line from the point.  In a scattering medium that holds the point scores still have a
    tail, of density s^-3: the mean is exact, the variance grows with the logarithm of the number of scores, the error falls
    as N^(-1/2) but for a logarithm (N^(-1/3) for scores at collisions), and single flights that pass very close can stand
    out.  The result warns where a few scores carry it.  A point in vacuum or in what only absorbs has no such tail.
    A Source that fills a ball or a box about the point is sampled along lines through it.

    Beams send nothing straight to a point: on the beam itself only what has been scattered or reflected counts.
    Mirrors, lenses, Dielectric and Glossy surfaces are refused, for no straight line leads through them; so are points
    on surfaces, sources with an `aim` and scenes with a duration.
    """

    position: Vector
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


def check_points(scene: Scene) -> None:
    """Refuse scenes that point detectors cannot see into.  Raises SceneError."""
    for detector in scene.points:
        for surface in scene.surfaces:
            _check_surface(scene, detector, surface)
        for source in scene.sources:
            _check_source(scene, detector, source)


def _check_surface(scene: Scene, detector: PointDetector, surface: Surface) -> None:
    if isinstance(surface.material, Transparent):
        return
    title = f"Surface {surface.name!r}" if surface.name else f"surfaces[{scene.surfaces.index(surface)}]"
    for part in simple_parts(surface.material):
        if not isinstance(part, SEEN_BY):
            must = "cannot see by surfaces that are not Black, Diffuse or Transparent throughout"
            cure = "count by a small VolumeDetector instead"
            refuse(detector, f"{must}, got {part!r} of {title}; {cure}")
    if _lies_on(detector, surface.shape):
        cure = f"meter it: Detector({surface.name or 'its name'!r}), or move the point off it"
        refuse(detector, f"position must not lie on {title}, got {shown(detector.position)}; {cure}")


def _check_source(scene: Scene, detector: PointDetector, source: Source) -> None:
    emission, shape = source.emission, scene.shape_of(source)
    if not isinstance(emission, Isotropic | Lambertian | Beam):
        got = type(emission).__name__
        refuse(detector, f"sees Isotropic, Lambertian and Beam emission, got {got}; count by a VolumeDetector")
    if source.aim is not None:
        cure = "leave aim out: the point is seen from every birth as it is"
        refuse(detector, f"needs sources that emit into all their directions, got aim={shown(source.aim)}; {cure}")
    is_point = isinstance(shape, Point)
    if isinstance(emission, Isotropic) and is_point and detector.position == shape.position:
        refuse(detector, f"position must not be that of a point source, got {shown(detector.position)}; move it")
    if isinstance(emission, Lambertian) and _lies_on(detector, shape):
        cure = "move the point off it"
        refuse(detector, f"position must not lie on a source, got {shown(detector.position)}; {cure}")


def _lies_on(detector: PointDetector, shape) -> bool:
    size = magnitude(shape) + sum(map(abs, detector.position))
    return least_distance(shape, detector.position) <= CLOSE * size
