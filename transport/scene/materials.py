"""Materials: how a surface acts on arriving particles; equal on both sides except for TwoSided."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from transport.geometry.flat import Disk, Rectangle
from transport.geometry.shape import Cloud, Point, Shape
from transport.scene.media import Grid, Medium, Vacuum
from transport.scene.phase_functions import Phase, is_phase
from transport.scene.speeds import SpeedDistribution
from transport.validation import (
    Converted,
    as_float,
    check_type,
    coerce_fraction,
    coerce_name,
    coerce_positive,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)

# ---- Base class of materials: what the rest of the program asks of any material.


class Shares(NamedTuple):
    """Shares of the incident light by what happens to it; upper bounds where they depend on the angle."""

    absorbed: float = 0.0
    diffuse: float = 0.0  # reflected by the cosine law
    diffuse_through: float = 0.0  # transmitted by the cosine law
    specular: float = 0.0  # reflected into the direction of a mirror, or into a narrow lobe around it
    glossy: float = 0.0  # reflected into a lobe around that direction wide enough for next-event rays
    refracted: float = 0.0  # transmitted into another direction
    straight: float = 0.0  # transmitted straight on

    @property
    def transmitted(self) -> float:
        """Share that arrives at the other side."""
        return self.diffuse_through + self.refracted + self.straight

    @property
    def redirected(self) -> float:
        """Share that leaves in another direction."""
        return self.diffuse + self.diffuse_through + self.specular + self.glossy + self.refracted


class MaterialRow(NamedTuple):
    """What the engine is told about an elementary material; `compile.surfaces` scales the lengths."""

    interaction: str = "transparent"  # how a direction is sampled: one of compile.layout.INTERACTIONS
    albedo: float = 1.0  # share that goes on
    albedo_law: str | None = None  # by the direction: the engine's passes `look_up_<law>`, `reflect_by_<law>`
    focal_length: float = math.inf  # [m]
    # Optical columns:
    through: float = 0.0  # transmitted share of what goes on
    inside: float = 0.0  # refractive indices of a boundary of media
    outside: float = 0.0
    ratio: float = 1.0  # index inside over index outside
    excess: float = 0.0  # (ratio - 1)(ratio + 1)
    roughness: float = 0.0
    loss: float = 0.0  # of a metal: imaginary part of the square of its index, whose real part is excess + 1


OPTICAL_COLUMNS = MaterialRow._fields[MaterialRow._fields.index("through") :]  # of compile.layout.OPTICS


class Material:
    """Base class of materials; not instantiated directly.

    An elementary material states its `shares` and its `row`, and where it differs from the attributes here.
    The compiler, the checks, the estimators and the diagnostics ask no material for its type.
    """

    acts = True  # on particles; else they cross it as if it were not there
    bounds_media = False  # whether its sides lie in media of given refractive indices
    is_one_sided = True  # whether it can be the material of one side alone
    is_reciprocal = True  # whether light may take each path backwards, with the same share
    is_for_light = False  # whether its law is one of light, not of particles
    speed: float | SpeedDistribution | None = None  # with which particles leave; None: they keep theirs

    @property
    def elements(self) -> tuple["Material", ...]:
        """Elementary materials on both sides; itself if it is elementary."""
        return (self,)

    @property
    def weighted_parts(self) -> tuple[tuple["Material", float], ...]:
        """The parts of a mixture with their shares; else itself, with the share 1."""
        return ((self, 1.0),)

    @property
    def sides(self) -> tuple["Material", "Material"]:
        """Materials of the front and of the back."""
        return self, self

    @property
    def shares(self) -> Shares:
        """Shares of the incident light, of a mixture the mean ones; a TwoSided has those of its `sides`."""
        raise NotImplementedError

    def row(self) -> MaterialRow:
        """Return what the engine is told about an elementary material."""
        raise NotImplementedError

    @property
    def boundary(self) -> "Dielectric | None":
        """The boundary of two media among the elementary materials, if there is one."""
        return next((part for part in self.elements if part.bounds_media), None)

    @property
    def absorbs(self) -> bool:
        """Whether some light is absorbed."""
        return any(side.shares.absorbed > 0 for side in self.sides)

    @property
    def is_transmissive(self) -> bool:
        """Whether some light is transmitted, from at least one side."""
        return any(side.shares.transmitted > 0 for side in self.sides)

    @property
    def redirects(self) -> bool:
        """Whether light may leave in another direction than that of its arrival."""
        return any(side.shares.redirected > 0 for side in self.sides)

    @property
    def is_specular(self) -> bool:
        """Whether light leaves in directions that no shadow ray can sample.

        It does from mirrors, glass, lenses and gloss of a roughness below MIN_RAY_ROUGHNESS, and from a
        mixture of Transparent and another material. Rays find such light only in scenes of flat mirrors
        (compile/images.py).
        """
        return any(
            max(side.shares.specular, side.shares.refracted, side.shares.straight * self.acts) > 0
            for side in self.sides
        )

    @property
    def is_clear(self) -> bool:
        """Whether no light is absorbed, scattered or mirrored but by Fresnel's law."""
        return all(max(part.shares.refracted, part.shares.straight) == 1 for part in self.elements)

    @property
    def max_diffuse_share(self) -> float:
        """Largest share of a particle's weight that leaves by the cosine law."""
        return max(part.shares.diffuse + part.shares.diffuse_through for part in self.elements)

    def brightened(self, least: float) -> tuple["Material", float]:
        """Return a material that sends on at least a share, and what this one sends on relative to it."""
        return self, 1.0


def coerce_fractions(material: Material, reflected: str, transmitted: str) -> None:
    """Convert both fields to floats in [0, 1]; raise SceneError if their sum exceeds 1."""
    coerce_fraction(material, reflected, transmitted)
    one, other = getattr(material, reflected), getattr(material, transmitted)
    if one + other > 1:
        got = f"{one} + {other} = {one + other}"
        refuse(material, f"{reflected} + {transmitted} must not be above 1, got {got}; lower one of them")


# ---- Optical materials: smooth dielectric boundary, rough mirror and ideal thin lens.


@scene_object
class Dielectric(Material):
    """A smooth boundary between two clear media: refraction and Fresnel reflection.

    The normal of the shape points to the outside: inside is the interior of a closed shape, or the back of a
    flat one. For watts only. A scene with a duration must also name a medium, such as
    `inside=Medium(index=1.5)`, because light is slower in it.

    Parameters
    ----------
    index_inside : float, optional
        Refractive index inside, positive and finite [default: both indices are those of the media on the two
        sides, which the scene finds].
    index_outside : float, default 1
        Refractive index outside, positive and finite.

    Raises
    ------
    SceneError
        If an index is not positive and finite.

    Notes
    -----
    Light is refracted by Snell's law (1621), or reflected with the probability of Fresnel's formulas
    (1823) for unpolarised light; beyond the critical angle it is always reflected. Nothing is absorbed, and
    L/n^2 is equal on both sides.

    Examples
    --------
    >>> import transport as tp
    >>> glass = tp.Dielectric(1.5)
    >>> glass.index_outside
    1.0
    >>> lamp = tp.Source(tp.Point(position=(0, 0, 2)), tp.Isotropic(power=1.0))
    >>> water = tp.Medium(index=1.33, absorption=0.1)
    >>> ball = tp.Surface(tp.Sphere(radius=1.0), tp.Dielectric(), "ball", inside=water)
    >>> tp.Scene(lamp, ball).surface("ball").material
    Dielectric(index_inside=1.33, index_outside=1.0)
    """

    index_inside: float | None = None
    index_outside: float = 1.0

    bounds_media, is_one_sided, is_for_light = True, False, True
    shares = Shares(specular=1.0, refracted=1.0)

    def __post_init__(self) -> None:
        if self.index_inside is None:
            if self.index_outside != 1:
                refuse(self, "index_inside missing; give both indices, or none")
            return
        coerce_positive(self, "index_inside", "index_outside")

    def row(self) -> MaterialRow:
        inside, outside = self.index_inside, self.index_outside
        excess = (inside - outside) * (inside + outside) / outside / outside
        return MaterialRow(
            "dielectric", inside=inside, outside=outside, ratio=inside / outside, excess=excess
        )


METALLIC_INDICES = 1e-3, 1e6  # bounds of |n + ik|, between which the reflectance is exact to rounding


@scene_object
class Conductor(Material):
    """A smooth metal: reflects like a mirror, with Fresnel's reflectance, and absorbs the rest.

    Opaque, and equal on both sides. For watts only.

    Parameters
    ----------
    n : float
        Real part of the refractive index n + ik relative to the medium in front, positive.
    k : float
        Imaginary part, positive: the amplitude falls by exp(-2 pi k) within a wavelength of the medium
        in front. For k = 0 use Dielectric.

    Raises
    ------
    SceneError
        If n or k is not positive, or if the magnitude of n + ik is not from 1e-3 to 1e6.

    Notes
    -----
    Reflectance for unpolarised light by Fresnel's formulas (1823) with a complex index (Born and Wolf 1999,
    Principles of Optics, section 14.2). At normal incidence ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2). Behind
    glass of index m, divide n and k of the metal by m.

    Examples
    --------
    >>> import transport as tp
    >>> silver = tp.Conductor(n=0.055, k=3.6)  # about that of silver in green light
    >>> print(f"{silver.reflectance(1.0):.3f}")
    0.984
    """

    n: float
    k: float

    is_for_light = True
    shares = Shares(absorbed=1.0, specular=1.0)

    def __post_init__(self) -> None:
        if as_float(self.k) == 0:
            refuse(self, "k must be positive, got 0; for a clear medium use Dielectric")
        coerce_positive(self, "n", "k")
        least, most = METALLIC_INDICES
        if not least <= math.hypot(self.n, self.k) <= most:
            got = f"n = {self.n:g}, k = {self.k:g}; for a perfect mirror use Mirror()"
            refuse(self, f"|n + ik| must be from {least:g} to {most:g}, got {got}")

    def reflectance(self, mu: ArrayLike) -> np.ndarray | float:
        """Return the reflectance for unpolarised light.

        Parameters
        ----------
        mu : float or array
            Cosine of the angle of incidence, in [0, 1].

        Returns
        -------
        float or array
            Reflected fraction, of the shape of mu.

        Raises
        ------
        SceneError
            If a cosine is not in [0, 1].
        """
        mu = np.asarray(mu, float)
        if not ((mu >= 0) & (mu <= 1)).all():
            refuse(self, f"mu must be a cosine in [0, 1], got {short_repr(mu)}; write np.cos(angle)")
        index = complex(self.n, self.k)
        root = np.sqrt(index * index - (1 - mu) * (1 + mu))
        across = abs((mu - root) / (mu + root)) ** 2
        along = abs((index * index * mu - root) / (index * index * mu + root)) ** 2
        return (0.5 * (across + along))[()]

    def row(self) -> MaterialRow:
        excess, loss = (self.n - 1) * (self.n + 1) - self.k * self.k, 2 * self.n * self.k
        # The law sets the albedo at each crossing; 0.5 says that there is absorption and reflection.
        return MaterialRow("mirror", 0.5, albedo_law="metal", excess=excess, loss=loss)


MIN_RAY_ROUGHNESS = 1e-3  # of gloss that next-event rays are sent from; a narrower lobe hardly meets a ray


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
    -----
    Distribution of normals by Trowbridge and Reitz (1975), "GGX", with Smith's height-correlated
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
            is_too_rough = number is not None and number > 1
            cure = "for a diffuse surface use Diffuse" if is_too_rough else "for a smooth surface use Mirror"
            refuse(self, f"roughness must be above 0 and at most 1, got {short_repr(self.roughness)}; {cure}")
        set_fields(self, roughness=number)
        coerce_fraction(self, "albedo")

    @property
    def shares(self) -> Shares:
        if self.roughness < MIN_RAY_ROUGHNESS:
            return Shares(absorbed=1 - self.albedo, specular=self.albedo)
        return Shares(absorbed=1 - self.albedo, glossy=self.albedo)

    def row(self) -> MaterialRow:
        return MaterialRow("glossy", self.albedo, roughness=self.roughness)

    def brightened(self, least: float) -> tuple[Material, float]:
        if self.albedo >= least:
            return self, 1.0
        return replace(self, albedo=least), self.albedo / least


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
    -----
    The direction cosines p in the plane of the lens change by -x/f, where x is the position relative to
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

    is_one_sided, is_reciprocal, is_for_light = False, False, True
    shares = Shares(refracted=1.0)

    def __post_init__(self) -> None:
        value = self.focal_length
        number = as_float(value)
        if number is None or not math.isfinite(number) or number == 0:
            cure = "for a flat pane use Transparent()"
            refuse(self, f"focal_length must be a finite number, not zero, got {short_repr(value)}; {cure}")
        set_fields(self, focal_length=number)

    def row(self) -> MaterialRow:
        return MaterialRow("lens", focal_length=self.focal_length)


# ---- Plain materials: black, diffuse, mirror and transparent.

BLACK_ROW = MaterialRow("black", albedo=0.0)


@scene_object
class Black(Material):
    """A surface that absorbs everything.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Surface(tp.Disk(radius=1.0), tp.Black(), name="floor").material
    Black()
    """

    shares = Shares(absorbed=1.0)

    def row(self) -> MaterialRow:
        return BLACK_ROW


@scene_object
class Diffuse(Material):
    """A Lambertian surface: reflects and transmits diffusely, absorbs the rest.

    Parameters
    ----------
    albedo : float
        Reflected fraction, in [0, 1].
    transmission : float, default 0
        Transmitted fraction, in [0, 1], which leaves the other side diffusely; albedo + transmission <= 1.
    speed : float or SpeedDistribution, default None
        Keyword only. None: particles keep their speed. Otherwise thermal re-emission: particles leave
        either side with this speed [m/s], or with speeds drawn from the distribution, weighted by the
        speed, as from a gas behind the surface. Not for watts.

    Raises
    ------
    SceneError
        If a fraction is out of range, or if speeds drift or are negative.

    Notes
    -----
    f = albedo/pi on the side of arrival and transmission/pi on the other [sr^-1] (Lambert 1760); reciprocal.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Diffuse(0.8).albedo
    0.8
    >>> wall = tp.Diffuse(1.0, speed=tp.Maxwellian(temperature=300, mass=4.65e-26))
    """

    albedo: float
    transmission: float = 0.0
    speed: float | SpeedDistribution | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        coerce_fractions(self, "albedo", "transmission")
        if not isinstance(self.speed, SpeedDistribution):
            if self.speed is not None:
                coerce_positive(self, "speed")
        elif self.speed.has_drift:
            refuse(
                self,
                f"speed must be that of a gas at rest, got {short_repr(self.speed)}; leave out the drift",
            )
        elif self.speed.is_signed:
            refuse(
                self, f"speed must not be negative, got {short_repr(self.speed)}; write speeds from 0 upwards"
            )

    @property
    def shares(self) -> Shares:
        left = self.albedo + self.transmission
        return Shares(1 - left, diffuse=self.albedo, diffuse_through=self.transmission)

    def row(self) -> MaterialRow:
        left = self.albedo + self.transmission
        return MaterialRow("diffuse", left, through=self.transmission / left) if left else BLACK_ROW


@scene_object
class Mirror(Material):
    """An ideal mirror: reflects specularly, transmits straight on, absorbs the rest.

    Parameters
    ----------
    reflectance : float, default 1
        Reflected fraction, in [0, 1], the same at every angle.
    transmission : float, default 0
        Fraction that continues in a straight line, in [0, 1]; reflectance + transmission <= 1.

    Raises
    ------
    SceneError
        If a fraction is out of range.

    Examples
    --------
    >>> import transport as tp
    >>> beam_splitter = tp.Mirror(reflectance=0.5, transmission=0.5)
    """

    reflectance: float = 1.0
    transmission: float = 0.0

    def __post_init__(self) -> None:
        coerce_fractions(self, "reflectance", "transmission")

    @property
    def shares(self) -> Shares:
        left = self.reflectance + self.transmission
        return Shares(1 - left, specular=self.reflectance, straight=self.transmission)

    def row(self) -> MaterialRow:
        left = self.reflectance + self.transmission
        return MaterialRow("mirror", left, through=self.transmission / left) if left else BLACK_ROW

    def brightened(self, least: float) -> tuple[Material, float]:
        share = (self.reflectance + self.transmission) / least
        if share >= 1:
            return self, 1.0
        return Mirror(self.reflectance / share, self.transmission / share), share


@scene_object
class Transparent(Material):
    """A surface that transmits everything unchanged; for detectors, sources and bodies of a medium.

    Examples
    --------
    >>> import transport as tp
    >>> fog = tp.Surface(tp.Box(size=1.0), tp.Transparent(), inside=tp.Medium(scattering=0.5))
    """

    acts = False
    shares = Shares(straight=1.0)

    def row(self) -> MaterialRow:
        return MaterialRow()


# ---- Combined materials: mixtures (also of phase functions), and one material per side.

SHARE_TOLERANCE = 1e-9  # tolerance of the sum of shares


@scene_object
class Mixture(Material, Phase):
    """A random mixture: each particle interacts with one of the parts, chosen with its share as probability.

    The parts are either all materials (of a surface) or all phase functions (of a medium).

    Parameters
    ----------
    parts : mapping of part to float
        {material: share} or {phase function: share}; shares in [0, 1] that add up to 1. No Mixture or
        TwoSided within. Stored as (part, share) pairs in an order that is independent of the input,
        without those of share 0.

    Raises
    ------
    SceneError
        If shares do not add up to 1, if parts are equal or of both kinds, or if parts that transmit light
        disagree about the refractive indices on the two sides.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Mixture({tp.Mirror(0.9): 0.25, tp.Black(): 0.75})
    Mixture(parts=((Black(), 0.75), (Mirror(reflectance=0.9, transmission=0.0), 0.25)))
    >>> tp.Mixture({tp.HenyeyGreenstein(0.8): 0.5, tp.Rayleigh(): 0.5}).g
    0.4
    """

    parts: Converted[
        Mapping[Any, float] | Iterable[tuple[Material | Phase, float]],
        tuple[tuple[Material | Phase, float], ...],
    ]

    def __post_init__(self) -> None:
        set_fields(self, parts=tuple(sorted(self._checked_parts(), key=lambda part: _sort_key(part[0]))))
        self._check_indices()

    @property
    def elements(self) -> tuple[Material, ...]:
        return tuple(part for part, _ in self.parts)

    @property
    def shares(self) -> Shares:
        columns = zip(*((share * each for each in part.shares) for part, share in self.parts), strict=True)
        return Shares(*map(sum, columns))

    @property
    def is_phase(self) -> bool:
        """Whether the parts are phase functions, not materials.

        Returns
        -------
        bool
        """
        return is_phase(self.parts[0][0])

    @property
    def g(self) -> float:
        """Mean cosine of the scattering angle, for a mixture of phase functions.

        Returns
        -------
        float

        Raises
        ------
        SceneError
            If the parts are materials.
        """
        self._check_is_phase("g")
        return math.fsum(share * part.g for part, share in self.parts)

    def density(self, mu: np.ndarray | float) -> np.ndarray | float:
        """Return the phase function at cosines mu of the scattering angle.

        Parameters
        ----------
        mu : float or array
            Cosines of the scattering angle, in [-1, 1].

        Returns
        -------
        float or array
            Density per solid angle [sr^-1], of the shape of mu.

        Raises
        ------
        SceneError
            If the parts are materials.
        """
        self._check_is_phase("density(mu)")
        return sum(share * part.density(mu) for part, share in self.parts)

    @property
    def max_density(self) -> float:
        """Sum of the greatest densities of the parts [sr^-1], for a mixture of phase functions."""
        return sum(share * part.max_density for part, share in self.parts)

    @property
    def weighted_parts(self) -> tuple[tuple[Any, float], ...]:
        return self.parts

    def _check_is_phase(self, what: str) -> None:
        if not self.is_phase:
            refuse(self, f"{what} needs phase functions, got materials: {short_repr(self.parts)}; mix phases")

    def _checked_parts(self) -> list[tuple[Material, float]]:
        pairs = list(self.parts.items()) if isinstance(self.parts, Mapping) else self.parts
        if not _are_pairs(pairs):
            cure = "write {Mirror(): 0.5, ...}"
            refuse(self, f"parts must be materials with their shares, got {short_repr(self.parts)}; {cure}")
        for material, share in pairs:
            self._check_part(material, share)
        phases = [is_phase(part) for part, _ in pairs]
        if any(phases) and not all(phases):
            refuse(self, f"parts must be all materials or all phase functions, got {short_repr(pairs)}")
        if len({material for material, _ in pairs}) < len(pairs):
            refuse(self, f"parts must differ from one another, got {short_repr(pairs)}; add up their shares")
        total = math.fsum(share for _, share in pairs)
        if not abs(total - 1) <= SHARE_TOLERANCE:
            cure = "divide them by their sum" if any(phases) else "add Black() for the rest"
            refuse(self, f"shares must add up to 1, got {total} from {short_repr(pairs)}; {cure}")
        return [(material, as_float(share)) for material, share in pairs if share > 0]

    def _check_part(self, material: object, share: object) -> None:
        if isinstance(material, Mixture):
            refuse(
                self, f"parts must not contain another Mixture, got {short_repr(material)}; list its parts"
            )
        if isinstance(material, TwoSided):
            cure = "write TwoSided(front=Mixture(...), back=Mixture(...))"
            refuse(self, f"parts must not contain a TwoSided, got {short_repr(material)}; {cure}")
        if not isinstance(material, Material) and not is_phase(material):
            must = "parts must be materials such as Mirror(), or phase functions such as Rayleigh()"
            refuse(self, f"{must}, got {short_repr(material)}")
        if as_float(share) is None or not 0 <= share <= 1:
            refuse(self, f"the share of {material} must be in [0, 1], got {short_repr(share)}")

    def _check_indices(self) -> None:
        """Raise SceneError if parts that transmit light lead into different media."""
        glass = None if self.is_phase else self.boundary
        for part in self.elements if glass else ():
            leads_elsewhere = part.bounds_media or glass.index_inside != glass.index_outside
            if part != glass and part.is_transmissive and leads_elsewhere:
                cure = "give them the same indices, or leave one out"
                refuse(self, f"parts must lead into the same media, got {glass} and {part}; {cure}")


@scene_object
class TwoSided(Material):
    """A different material on each side; the side of arrival decides.

    Parameters
    ----------
    front : Material
        Material of the side that the normal points to.
    back : Material
        Material of the other side.

    Raises
    ------
    SceneError
        If a side is a TwoSided, or contains a Dielectric or ThinLens, which act on both sides.

    Notes
    -----
    Radiance is in equilibrium only if both sides transmit the same fraction.

    Examples
    --------
    >>> import transport as tp
    >>> tp.TwoSided(front=tp.Mirror(), back=tp.Black())
    TwoSided(front=Mirror(reflectance=1.0, transmission=0.0), back=Black())
    """

    front: Material
    back: Material

    def __post_init__(self) -> None:
        for side in ("front", "back"):
            check_material(self, side)
            self._check_side(side, getattr(self, side))

    @property
    def sides(self) -> tuple[Material, Material]:
        return self.front, self.back

    @property
    def elements(self) -> tuple[Material, ...]:
        return self.front.elements + self.back.elements

    def _check_side(self, side: str, material: Material) -> None:
        if isinstance(material, TwoSided):
            cure = "use the material of that side only"
            refuse(self, f"{side} must not be another TwoSided, got {short_repr(material)}; {cure}")
        for part in material.elements:
            if not part.is_one_sided:
                kind = type(part).__name__
                cure = f"a {kind} acts on both sides: make it the surface's material"
                refuse(self, f"{side} must not be or contain a {kind}, got {short_repr(part)}; {cure}")


def check_material(subject: object, name: str) -> None:
    """Raise SceneError if the field is not a material, or is a mixture of phase functions."""
    check_type(subject, name, Material, "an instance of a material, such as Diffuse(0.5)")
    value = getattr(subject, name)
    if is_phase(value):
        refuse(
            subject, f"{name} must be a material, got {short_repr(value)}; phase functions belong to a Medium"
        )


def _sort_key(part: Material | Phase) -> tuple[str, bytes]:
    """Return the sort key of a part: its repr, and the digest that distinguishes tables."""
    return repr(part), getattr(part, "digest", b"")


def _are_pairs(pairs: object) -> bool:
    return isinstance(pairs, (tuple, list)) and all(
        isinstance(pair, tuple) and len(pair) == 2 for pair in pairs
    )


# ---- A surface: a shape with a material and the media on its sides.

AnyMedium = Medium | Grid | Vacuum


@scene_object
class Surface:
    """A surface: a shape with a material, a name and the media on its two sides.

    Parameters
    ----------
    shape : Shape
        Shape with an area (not a Point or Cloud).
    material : Material
        How the surface acts on particles.
    name : str, default None
        Name by which sources and detectors refer to the surface.
    front, back : Medium, Grid or Vacuum, default None
        Medium on the side that the normal points to, and on the other side. None: the medium that
        surrounds the surface there. `Vacuum()` means vacuum.
    outside, inside : Medium, Grid or Vacuum, default None
        Synonyms of `front` and `back`; both names can be read.

    Raises
    ------
    SceneError
        If the shape has no area, if the material is none or does not fit the shape, or if a side has two
        different media.

    Examples
    --------
    >>> import transport as tp
    >>> fog = tp.Medium(absorption=0.1, scattering=0.9)
    >>> cloud = tp.Surface(tp.Sphere(radius=1.0), tp.Transparent(), "cloud", inside=fog)
    >>> cloud.back == fog
    True
    """

    shape: Shape
    material: Material
    name: str | None = None
    front: AnyMedium | None = None
    back: AnyMedium | None = None
    outside: AnyMedium | None = field(default=None, repr=False)
    inside: AnyMedium | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        coerce_name(self)
        check_type(self, "shape", Shape, "a shape such as Disk(radius=...)")
        kind = type(self.shape).__name__
        if isinstance(self.shape, (Point, Cloud)):
            refuse(self, f"shape must have an area, got {self.shape}; a {kind} is for sources only")
        check_material(self, "material")
        has_lens = any(isinstance(part, ThinLens) for part in self.material.elements)
        if has_lens and not isinstance(self.shape, (Disk, Rectangle)):
            refuse(self, f"a ThinLens must be on a Disk or a Rectangle, got a {kind}; put it on one of these")
        self._coerce_side("front", "outside")
        self._coerce_side("back", "inside")

    def _coerce_side(self, side: str, alias: str) -> None:
        """Store the medium of a side under both of its names."""
        for name in (side, alias):
            value = getattr(self, name)
            if value is not None:
                coerce_medium(self, name, value)
        one, other = getattr(self, side), getattr(self, alias)
        if one is not None and other is not None and one != other:
            cure = f"{alias} is a synonym of {side}: leave one of them out"
            refuse(
                self,
                f"{side} and {alias} must not differ, got {short_repr(one)} and {short_repr(other)}; {cure}",
            )
        medium = other if one is None else one
        set_fields(self, **{side: medium, alias: medium})


def coerce_medium(subject: object, name: str, value: object) -> AnyMedium:
    """Return the medium of a field; raise SceneError for anything else."""
    if isinstance(value, type) and issubclass(value, AnyMedium):
        refuse(
            subject,
            f"{name} must be an instance, got the class {value.__name__}; write {value.__name__}(...)",
        )
    if not isinstance(value, AnyMedium):
        must = "a medium such as Medium(absorption=...) or Vacuum()"
        refuse(subject, f"{name} must be {must}, got {short_repr(value)}")
    return value
