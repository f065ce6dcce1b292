"""Point detectors: the fluence rate at a point, by next-event estimation."""

from __future__ import annotations

from transport.scene.sides import AnyDetector
from transport.validation import VectorField, coerce_name, coerce_vector, refuse, scene_object


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
    - A Beam sends nothing straight to a point: in a wide beam only scattered and reflected light counts. With
      estimator="backward" its direct light counts too.

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
        coerce_vector(self, "position")
        coerce_name(self)
        if self.name is None:
            refuse(self, "name must be given, got None; write name='there'")

    def check_clock(self, duration: float | None) -> None:
        """Raise SceneError if the scene has a duration: the arrival time of a ray is not known."""
        if duration is not None:
            cure = "leave out duration, or use a small VolumeDetector"
            refuse(self, f"a scene with a PointDetector must be steady, got duration={duration!r}; {cure}")
