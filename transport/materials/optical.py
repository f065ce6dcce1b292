"""Optical materials: smooth dielectric boundary, rough mirror and ideal thin lens."""

import math

from transport.materials.base import Material
from transport.validation import (
    as_float,
    refuse,
    scene_object,
    settle_fraction,
    settle_positive,
    shown,
    store,
)


@scene_object
class Dielectric(Material):
    """A smooth boundary between two clear media: refraction and Fresnel reflection.

    The normal of the shape points to the outside: inside is the interior of a closed shape, or the back of a
    flat one. For watts only. A scene with a duration must also name a medium, such as
    `inside=Medium(index=1.5)`, because light is slower in it.

    Parameters
    ----------
    index_inside : float
        Refractive index inside, positive and finite.
    index_outside : float, default 1
        Refractive index outside, positive and finite.

    Raises
    ------
    SceneError
        If an index is not positive and finite.

    Notes
    ----- Light is refracted by Snell's law (1621), or reflected with the probability of Fresnel's formulas
    (1823) for unpolarised light; beyond the critical angle it is always reflected. Nothing is absorbed, and
    L/n^2 is equal on both sides.

    Examples
    --------
    >>> import transport as tp
    >>> glass = tp.Dielectric(1.5)
    >>> glass.index_outside
    1.0
    """

    index_inside: float
    index_outside: float = 1.0

    def __post_init__(self) -> None:
        settle_positive(self, "index_inside", "index_outside")


@scene_object
class Glossy(Material):
    """A rough mirror of microfacets (GGX); opaque, with the same albedo at every angle of incidence.

    Parameters
    ----------
    roughness : float
        alpha of the distribution of normals, in (0, 1]: about the tangent of the typical slope of the
        facets. For a smooth surface use Mirror.
    albedo : float, default 1
        Reflected fraction, in [0, 1].

    Raises
    ------
    SceneError
        If roughness or albedo is out of range.

    Notes
    ----- Distribution of normals by Trowbridge and Reitz (1975), "GGX", with Smith's height-correlated
    shadowing (Heitz 2014, JCGT 3(2), 48, eq. 99). With E(mu) the fraction that single reflection returns, and
    E_mean its mean::

        f = albedo [D G2 / (4 mu_i mu_o) + (1 - E(mu_i)) (1 - E(mu_o)) / (pi (1 - E_mean))]   [sr^-1]

    The second term stands for multiple reflection (Kulla and Conty 2017). f is reciprocal.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Glossy(0.2, albedo=0.9)
    Glossy(roughness=0.2, albedo=0.9)
    """

    roughness: float
    albedo: float = 1.0

    def __post_init__(self) -> None:
        number = as_float(self.roughness)
        if number is None or not 0 < number <= 1:
            cure = "for a smooth surface use Mirror(reflectance)"
            refuse(self, f"roughness must be above 0 and at most 1, got {shown(self.roughness)}; {cure}")
        store(self, roughness=number)
        settle_fraction(self, "albedo")


@scene_object
class ThinLens(Material):
    """An ideal thin lens, on a Disk or Rectangle.

    For watts only; light passes it in no time.

    Parameters
    ----------
    focal_length : float
        Focal length f [m], finite and not 0; negative for a diverging lens.

    Raises
    ------
    SceneError
        If the focal length is 0 or not finite, or if the shape is neither Disk nor Rectangle.

    Notes
    ----- The direction cosines p in the plane of the lens change by -x/f, where x is the position relative to
    the centre, equally from either side. The Jacobian is 1, so that radiance and etendue are conserved
    exactly: Abbe's sine condition (1873), E = pi L sin^2(theta') behind an aplanatic lens. No flat lens
    conserves etendue and also focuses sharply: light along the axis at x crosses the axis at f sqrt(1 -
    (x/f)^2), so that images are sharp only for x much smaller than f and for small angles. A ray whose `|p|`
    would reach 1 returns along its path, so that nothing is lost.

    Examples
    --------
    >>> import transport as tp
    >>> lens = tp.Surface(tp.Disk(radius=0.02), tp.ThinLens(focal_length=0.1), name="lens")
    """

    focal_length: float

    def __post_init__(self) -> None:
        value = self.focal_length
        number = as_float(value)
        if number is None or not math.isfinite(number) or number == 0:
            cure = "for a flat pane use Transparent()"
            refuse(self, f"focal_length must be a finite number, not zero, got {shown(value)}; {cure}")
        store(self, focal_length=number)
