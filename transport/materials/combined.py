"""Combined materials: mixtures (also of phase functions), and one material per side."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from transport.fields import Converted
from transport.materials.base import Material
from transport.materials.optical import Dielectric, Glossy, ThinLens
from transport.materials.plain import Black, Diffuse, Mirror, Transparent
from transport.media import Phase
from transport.media.base import is_phase
from transport.validation import as_float, check_type, refuse, scene_object, shown, store

ROUNDING = 1e-9  # tolerance of the sum of shares


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
        store(self, parts=tuple(sorted(self._checked(), key=lambda part: _order(part[0]))))
        self._check_indices()

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

    def _check_is_phase(self, what: str) -> None:
        if not self.is_phase:
            refuse(self, f"{what} needs phase functions, got materials: {shown(self.parts)}; mix phases")

    def _checked(self) -> list[tuple[Material, float]]:
        pairs = list(self.parts.items()) if isinstance(self.parts, Mapping) else self.parts
        if not _are_pairs(pairs):
            cure = "write {Mirror(): 0.5, ...}"
            refuse(self, f"parts must be materials with their shares, got {shown(self.parts)}; {cure}")
        for material, share in pairs:
            self._check_part(material, share)
        phases = [is_phase(part) for part, _ in pairs]
        if any(phases) and not all(phases):
            refuse(self, f"parts must be all materials or all phase functions, got {shown(pairs)}")
        if len({material for material, _ in pairs}) < len(pairs):
            refuse(self, f"parts must differ from one another, got {shown(pairs)}; add up their shares")
        total = math.fsum(share for _, share in pairs)
        if not abs(total - 1) <= ROUNDING:
            cure = "divide them by their sum" if any(phases) else "add Black() for the rest"
            refuse(self, f"shares must add up to 1, got {total} from {shown(pairs)}; {cure}")
        return [(material, as_float(share)) for material, share in pairs if share > 0]

    def _check_part(self, material: object, share: object) -> None:
        if isinstance(material, Mixture):
            refuse(self, f"parts must not contain another Mixture, got {shown(material)}; list its parts")
        if isinstance(material, TwoSided):
            cure = "write TwoSided(front=Mixture(...), back=Mixture(...))"
            refuse(self, f"parts must not contain a TwoSided, got {shown(material)}; {cure}")
        if not isinstance(material, Material) and not is_phase(material):
            must = "parts must be materials such as Mirror(), or phase functions such as Rayleigh()"
            refuse(self, f"{must}, got {shown(material)}")
        if as_float(share) is None or not 0 <= share <= 1:
            refuse(self, f"the share of {material} must be in [0, 1], got {shown(share)}")

    def _check_indices(self) -> None:
        """Raise SceneError if parts that transmit light lead into different media."""
        glass = [part for part, _ in self.parts if isinstance(part, Dielectric)]
        for part, _ in self.parts:
            if glass and part != glass[0] and lets_through(part) and not _agree(part, glass[0]):
                cure = "give them the same indices, or leave one out"
                refuse(self, f"parts must lead into the same media, got {glass[0]} and {part}; {cure}")


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

    def _check_side(self, side: str, material: Material) -> None:
        if isinstance(material, TwoSided):
            cure = "use the material of that side only"
            refuse(self, f"{side} must not be another TwoSided, got {shown(material)}; {cure}")
        for part in simple_parts(material):
            if isinstance(part, (Dielectric, ThinLens)):
                kind = type(part).__name__
                cure = f"a {kind} acts on both sides: make it the surface's material"
                refuse(self, f"{side} must not be or contain a {kind}, got {shown(part)}; {cure}")


def check_material(subject: object, name: str) -> None:
    """Raise SceneError if the field is not a material, or is a mixture of phase functions."""
    check_type(subject, name, Material, "an instance of a material, such as Diffuse(0.5)")
    value = getattr(subject, name)
    if is_phase(value):
        refuse(subject, f"{name} must be a material, got {shown(value)}; phase functions belong to a Medium")


def simple_parts(material: Material) -> tuple[Material, ...]:
    """Return the elementary materials of a material, on both sides; itself if it is elementary."""
    if isinstance(material, Mixture):
        return tuple(part for part, _ in material.parts)
    if isinstance(material, TwoSided):
        return simple_parts(material.front) + simple_parts(material.back)
    return (material,)


def lets_through(material: Material) -> bool:
    """Return whether a material transmits light from at least one side."""
    return any(_passes(part) for part in simple_parts(material))


def is_specular(material: Material) -> bool:
    """Return whether light leaves a material in directions that no shadow ray can sample.

    True for mirrors, glass, gloss and lenses.
    """
    parts = list(simple_parts(material))
    # Shadow rays cannot pass a mixture of Transparent and another material.
    is_sieve = any(isinstance(part, Transparent) for part in parts) and len(set(map(type, parts))) > 1
    return is_sieve or any(_is_specular(part) for part in parts)


def _is_specular(part: Material) -> bool:
    if isinstance(part, Mirror):
        return part.reflectance > 0 or part.transmission > 0
    if isinstance(part, Glossy):
        return part.albedo > 0
    return not isinstance(part, (Black, Diffuse, Transparent))


def _passes(part: Material) -> bool:
    if isinstance(part, (Diffuse, Mirror)):
        return part.transmission > 0
    return isinstance(part, (Dielectric, ThinLens, Transparent))


def _agree(part: Material, glass: Dielectric) -> bool:
    """Return whether both parts lead into the same media."""
    if isinstance(part, Dielectric):
        return part == glass
    return glass.index_inside == glass.index_outside


def _order(part: Material | Phase) -> tuple[str, bytes]:
    """Return the sort key of a part: its repr, and the digest that distinguishes tables."""
    return repr(part), getattr(part, "digest", b"")


def _are_pairs(pairs: object) -> bool:
    return isinstance(pairs, (tuple, list)) and all(
        isinstance(pair, tuple) and len(pair) == 2 for pair in pairs
    )
