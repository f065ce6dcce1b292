"""Materials made of others: a mixture by shares, of phase functions as well, and another one on each side."""

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

ROUNDING = 1e-9  # of the sum of shares


@scene_object
class Mixture(Material, Phase):
    """Each particle that arrives meets one of the materials, with the probability of its share.

    parts: {material: share, ...}, shares that add up to 1, of any materials but Mixture and TwoSided; kept as
    (material, share) pairs in an order that does not depend on how they were written, without those of share
    0. All that lets light through must agree on the indices of refraction on both sides.

    Or {phase function: share, ...}, a phase function itself: each scattering is by one of them.
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
        """Whether its parts are phase functions, not materials."""
        return is_phase(self.parts[0][0])

    @property
    def g(self) -> float:
        """Mean cosine of the scattering angle, of a mixture of phase functions."""
        self._check_is_phase("g")
        return math.fsum(share * part.g for part, share in self.parts)

    def density(self, mu: np.ndarray | float) -> np.ndarray | float:
        """Density [sr^-1] at cosines mu of the scattering angle, of a mixture of phase functions."""
        self._check_is_phase("density(mu)")
        return sum(share * part.density(mu) for part, share in self.parts)

    def _check_is_phase(self, what: str) -> None:
        if not self.is_phase:
            refuse(self, f"{what} is of phase functions, got materials: {shown(self.parts)}; mix phases")

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
            refuse(self, f"parts must differ from one another, got {shown(pairs)}; add their shares up")
        total = math.fsum(share for _, share in pairs)
        if not abs(total - 1) <= ROUNDING:
            cure = "divide them by their sum" if any(phases) else "add Black() for what is missing"
            refuse(self, f"shares must add up to 1, got {total} from {shown(pairs)}; {cure}")
        return [(material, as_float(share)) for material, share in pairs if share > 0]

    def _check_part(self, material: object, share: object) -> None:
        if isinstance(material, Mixture):
            refuse(self, f"parts must not hold another Mixture, got {shown(material)}; write its parts out")
        if isinstance(material, TwoSided):
            cure = "write TwoSided(front=Mixture(...), back=Mixture(...))"
            refuse(self, f"parts must not hold a TwoSided, got {shown(material)}; {cure}")
        if not isinstance(material, Material) and not is_phase(material):
            must = "parts must be materials such as Mirror(), or phase functions such as Rayleigh()"
            refuse(self, f"{must}, got {shown(material)}")
        if as_float(share) is None or not 0 <= share <= 1:
            refuse(self, f"the share of {material} must be in [0, 1], got {shown(share)}")

    def _check_indices(self) -> None:
        """Refuse parts between which light would be in two media at once."""
        glass = [part for part, _ in self.parts if isinstance(part, Dielectric)]
        for part, _ in self.parts:
            if glass and part != glass[0] and lets_through(part) and not _agree(part, glass[0]):
                cure = "give them the same indices, or leave one out"
                refuse(self, f"parts must not lead into unlike media, got {glass[0]} and {part}; {cure}")


@scene_object
class TwoSided(Material):
    """Another material on each side: `front`, where the normal points, and `back`, by the side of arrival.

    Any materials but TwoSided, Dielectric and ThinLens, which are not made of two sides.  Radiance is in
    equilibrium where both sides let the same share through.
    """

    front: Material
    back: Material

    def __post_init__(self) -> None:
        for side in ("front", "back"):
            check_material(self, side)
            self._check_side(side, getattr(self, side))

    def _check_side(self, side: str, material: Material) -> None:
        if isinstance(material, TwoSided):
            cure = "write the material of that side alone"
            refuse(self, f"{side} must not be another TwoSided, got {shown(material)}; {cure}")
        for part in simple_parts(material):
            if isinstance(part, (Dielectric, ThinLens)):
                kind = type(part).__name__
                cure = f"a {kind} acts on both sides: make it the surface's material"
                refuse(self, f"{side} must not be or hold a {kind}, got {shown(part)}; {cure}")


def check_material(subject: object, name: str) -> None:
    """The field is a material, and no mixture of phase functions."""
    check_type(subject, name, Material, "a material such as Diffuse(0.5), made with its brackets")
    value = getattr(subject, name)
    if is_phase(value):
        refuse(subject, f"{name} must be a material, got {shown(value)}; phase functions belong to a Medium")


def simple_parts(material: Material) -> tuple[Material, ...]:
    """The materials of which one is made, on either side; itself where it is made of no others."""
    if isinstance(material, Mixture):
        return tuple(part for part, _ in material.parts)
    if isinstance(material, TwoSided):
        return simple_parts(material.front) + simple_parts(material.back)
    return (material,)


def lets_through(material: Material) -> bool:
    """Whether light that arrives at one of the sides may go on beyond the surface."""
    return any(_passes(part) for part in simple_parts(material))


def is_specular(material: Material) -> bool:
    """Whether light leaves a material into directions that no ray can be aimed along: mirrors, glass, gloss and lenses."""
    parts = list(simple_parts(material))
    # no ray passes it
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
    """Whether what passes the one is in the same media as what passes the other."""
    if isinstance(part, Dielectric):
        return part == glass
    return glass.index_inside == glass.index_outside


def _order(part: Material | Phase) -> tuple[str, bytes]:
    """What parts are put in order by: their words, and what tells tables from one another."""
    return repr(part), getattr(part, "digest", b"")


def _are_pairs(pairs: object) -> bool:
    return isinstance(pairs, (tuple, list)) and all(
        isinstance(pair, tuple) and len(pair) == 2 for pair in pairs
    )
