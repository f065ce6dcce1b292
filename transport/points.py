"""Point detectors: the fluence rate at a point, by next-event estimation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from transport.bodies.solids import magnitude
from transport.emissions import Beam, Isotropic, Lambertian
from transport.fields import VectorField
from transport.materials import Black, Diffuse, Transparent, simple_parts
from transport.materials.surface import titled
from transport.shapes import Point
from transport.shapes.base import ROUNDING
from transport.shapes.distances import least_distance
from transport.sides import AnyDetector
from transport.validation import refuse, scene_object, settle_name, settle_vector, shown
from transport.vectors import Vector, dot

if TYPE_CHECKING:
    from transport.materials import Surface
    from transport.scene import Scene
    from transport.sources import Source

SEEN_BY = (Black, Diffuse)  # materials that block a ray and whose emergent radiance is known
CLOSE = 64 * ROUNDING  # distance relative to the coordinates at which a point is on a surface


@scene_object
class PointDetector(AnyDetector):
    """Fluence rate at a point, by next-event estimation.

    Rays go from each emission, diffuse reflection and scattering straight to the point. Each scores the
    probability per area of being sent there, times exp(-optical depth); opaque surfaces block it. The point
    therefore needs no particle to reach it: it may lie behind shields, in ducts, or far away.

    Parameters
    ----------
    position : vector
        Position [m]. It must not lie on a Black or Diffuse surface, on an emitting surface, at a point
        source or on a pencil beam. On a Transparent surface it may lie.
    name : str
        Key in the result; required.

    Raises
    ------
    SceneError
        If the scene has a duration; if it has Mirror, ThinLens, Dielectric or Glossy surfaces, through
        which no straight line leads; if a source has an `aim` or is not Isotropic, Lambertian or Beam; if
        the position is not allowed.

    Notes
    -----
    Scored at collisions, the factor 1/r^2 would make the variance infinite in a medium that scatters about
    the point, and the error would fall as N^(-1/3). Two samplings keep it finite:

    - The last scattering in the medium about the point is sampled once more per event, at a place drawn with
      a density proportional to 1/(a^2 b^2), where a and b are its distances from the event and from the
      point. Scores go as 1/r (Kalos 1963; Steinberg and Kalos 1971).
    - Scattering in other media is estimated from the flights through them, at a place drawn equiangularly
      about the point (Kulla and Fajardo 2012). Scores go as 1/D, where D is the distance of
      the flight's line.

    In a medium of albedo 0.9, one mean free path from a point source, the relative errors with 10^3, 10^4 and
    10^5 particles are 3.5 %, 1.2 % and 0.38 %, and z has a standard deviation of 1. A Source that fills a
    ball or a box near the point is sampled along lines through the point.

    Known limits:

    - A medium that scatters sharply forward makes the estimate noisy: 11 % instead of 1.2 % at g = 0.8; 36 %
      at g = 0.9, twice its reported standard error. The result warns if a few scores carry the error.
    - Close to a diffuse wall, to a diffuse emitter or to a thick medium (compared with their extent) errors
      grow, and a short run reports too little: half of the value comes from about as far as the point's
      distance, and at a hundred-thousandth of the wall's width all of that is missing, because no history
      comes so close to the foot point. The result warns if one such history would matter. Move the point
      away, or use a VolumeDetector. Behind absorbers, where weights are small, this warning may be needless.
    - In a wide Beam through a medium that scatters about the point the variance grows as log N.
    - A Beam sends nothing straight to a point: in a wide beam only scattered and reflected light counts.

    Examples
    --------
    >>> import transport as tp
    >>> point = tp.PointDetector((0, 0, 1), name="here")
    >>> point.position
    (0.0, 0.0, 1.0)
    """

    position: VectorField
    name: str

    def __post_init__(self) -> None:
        settle_vector(self, "position")
        settle_name(self)
        if self.name is None:
            refuse(self, "name must be given, got None; write name='there'")

    def check_clock(self, duration: float | None) -> None:
        """Raise SceneError if the scene has a duration: the arrival time of a ray is not known."""
        if duration is not None:
            cure = "leave out duration, or use a small VolumeDetector"
            refuse(self, f"a scene with a PointDetector must be steady, got duration={duration!r}; {cure}")


def check_points(scene: Scene) -> None:
    """Check that the point detectors of a scene can be estimated.

    Raises
    ------
    SceneError
        If a surface, a source or a position is not allowed.
    """
    for detector in scene.points:
        for surface in scene.surfaces:
            _check_surface(scene, detector, surface)
        for source in scene.sources:
            _check_source(scene, detector, source)


def _check_surface(scene: Scene, detector: PointDetector, surface: Surface) -> None:
    if isinstance(surface.material, Transparent):
        return
    title = titled(surface, scene.surfaces.index(surface))
    for part in simple_parts(surface.material):
        if not isinstance(part, SEEN_BY):
            must = "needs surfaces that are Black, Diffuse or Transparent throughout"
            cure = "use a small VolumeDetector instead"
            refuse(detector, f"{must}, got {part!r} of {title}; {cure}")
    if _lies_on(detector, surface.shape):
        cure = f"use Detector({surface.name or 'its name'!r}), or move the point off it"
        refuse(detector, f"position must not lie on {title}, got {shown(detector.position)}; {cure}")


def _check_source(scene: Scene, detector: PointDetector, source: Source) -> None:
    emission, shape = source.emission, scene.shape_of(source)
    if not isinstance(emission, Isotropic | Lambertian | Beam):
        got = type(emission).__name__
        refuse(detector, f"needs Isotropic, Lambertian or Beam emission, got {got}; use a VolumeDetector")
    if source.aim is not None:
        cure = "leave out aim: every emission already sends a ray to the point"
        refuse(
            detector,
            f"needs sources without an aim, got aim={shown(source.aim)}; {cure}",
        )
    is_point = isinstance(shape, Point)
    if isinstance(emission, Isotropic) and is_point and detector.position == shape.position:
        refuse(
            detector,
            f"position must differ from that of a point source, got {shown(detector.position)}; move it",
        )
    if isinstance(emission, Beam) and is_point and _lies_on_ray(detector, shape.position, emission.direction):
        cure = "move it off, or use a small VolumeDetector"
        refuse(
            detector,
            "position must not lie on a pencil beam, where the fluence rate is infinite,"
            f" got {shown(detector.position)}; {cure}",
        )
    if isinstance(emission, Lambertian) and _lies_on(detector, shape):
        cure = "move the point off it"
        refuse(detector, f"position must not lie on a source, got {shown(detector.position)}; {cure}")


def _lies_on_ray(detector: PointDetector, origin: Vector, direction: Vector) -> bool:
    way = [p - q for p, q in zip(detector.position, origin, strict=True)]
    ahead = dot(way, direction)
    aside = math.hypot(*(w - ahead * u for w, u in zip(way, direction, strict=True)))
    return ahead >= 0 and aside <= CLOSE * sum(map(abs, (*origin, *detector.position)))


def _lies_on(detector: PointDetector, shape) -> bool:
    size = magnitude(shape) + sum(map(abs, detector.position))
    return least_distance(shape, detector.position) <= CLOSE * size
