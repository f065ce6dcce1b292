"""Optical materials: a smooth boundary of two media, a rough mirror, and an ideal lens."""

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
    """A smooth boundary between two clear media of refractive indices `index_inside` and `index_outside`.

    Inside is where the shape's normal does not point: the inside of a closed shape, the back of a flat
    one.  Light is reflected or refracted (Snell 1621) with the probabilities of Fresnel's formulas (1823) for
    unpolarised light; beyond the critical angle all is reflected.  Nothing is absorbed, L/n^2 is the same on
    both sides.

    Indices are positive and finite.  For watts and scenes without a `duration`: the speed of light in a medium
    comes with media.
    """

    index_inside: float
    index_outside: float = 1.0

    def __post_init__(self) -> None:
        settle_positive(self, "index_inside", "index_outside")


@scene_object
class Glossy(Material):
    """A rough mirror of microfacets; opaque, and its `albedo` in [0, 1] is the same at every angle of incidence.

    roughness: alpha of the distribution of normals of Trowbridge and Reitz (1975), "GGX", in (0, 1]: about
    the tangent of the facets' typical slope; a smooth one is a Mirror.  With Smith's height-correlated
    shadowing (Heitz 2014, JCGT 3(2), 48, eq. 99), E(mu) the share that single reflection returns and E_mean
    its mean,

        f = albedo [D G2 / (4 mu_i mu_o) + (1 - E(mu_i)) (1 - E(mu_o)) / (pi (1 - E_mean))]   [sr^-1]

    whose second part stands for light that is reflected more than once (Kulla and Conty 2017).  Reciprocal.
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
    """An ideal lens of `focal_length` [m] on a Disk or Rectangle; negative: a diverging one.

    The direction cosines p in the plane of the lens change by -x/f, x being the place from its center, on
    either side alike.  The Jacobian of that is 1, so that radiance and etendue are conserved exactly: Abbe's
    sine condition (1873), E = pi L sin^2(theta') behind an aplanatic lens.  No flat lens does that and focuses
    sharply: light along the axis at x from it meets the axis at f sqrt(1 - (x/f)^2), so that images are sharp
    for x much smaller than f and for small angles only.  A ray whose |p| would reach
    1 is sent back along itself: nothing is lost.  For watts; it takes no time.
    """

    focal_length: float

    def __post_init__(self) -> None:
        value = self.focal_length
        number = as_float(value)
        if number is None or not math.isfinite(number) or number == 0:
            cure = "for a flat pane use Transparent()"
            refuse(self, f"focal_length must be a finite number, not zero, got {shown(value)}; {cure}")
        store(self, focal_length=number)
