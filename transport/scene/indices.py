"""Indices of a `Dielectric()` without any: those of the media on the two sides of its surface."""

from __future__ import annotations

from dataclasses import replace
from typing import NoReturn

import numpy as np

from transport.scene.bodies import media_at
from transport.scene.materials import AnyMedium, Dielectric, Surface
from transport.scene.media import Vacuum, canonical_medium
from transport.scene.parts import SceneParts, surface_name
from transport.validation import SceneError, join_names, short_repr

PLACES = 16  # on each piece of a surface
OFFSET = 1e-7  # of a piece's size: distance from the surface
STRIDES = 2.0 ** -(np.arange(1, 3) / 3)  # of a sequence that fills the unit square evenly (Kronecker)


def with_indices(parts: SceneParts) -> tuple[Surface, ...]:
    """Return the surfaces of a scene, in which each Dielectric has its indices.

    Raises SceneError where a surface without them has several media on one side.
    """
    return tuple(
        replace(surface, material=Dielectric(*_indices(parts, number))) if lacks_indices(surface) else surface
        for number, surface in enumerate(parts.surfaces)
    )


def lacks_indices(surface: Surface) -> bool:
    """Return whether a surface has a Dielectric without indices."""
    return surface.material.boundary is not None and surface.material.boundary.index_inside is None


def _indices(parts: SceneParts, number: int) -> tuple[float, float]:
    """Return the indices behind a surface and before it."""
    surface, found = parts.surfaces[number], []
    if surface.material != Dielectric():
        kind = type(surface.material).__name__
        cure = "write Dielectric(index inside, index outside) in it"
        raise SceneError(
            f"Scene: {surface_name(parts, number)}: a {kind} must not hold a Dielectric without indices,"
            f" got {short_repr(surface.material)}; {cure}"
        )
    for side, named in ((-1.0, surface.back), (1.0, surface.front)):
        if named is not None:
            found.append(canonical_medium(named).index)
            continue
        media = _media_beside(parts, surface, side)
        indices = {medium.index for medium in media}
        if len(indices) > 1:
            texts = join_names([short_repr(medium) for medium in media], 3)
            _refuse(parts, number, f"{texts} on one side; write Dielectric(index inside, index outside)")
        found.append(indices.pop())
    if found[0] == found[1]:
        has_medium = any(side not in (None, Vacuum()) for side in (surface.back, surface.front))
        cure = "name its medium, inside=Medium(index=1.5), or write Dielectric(1.5)"
        cure = "give its medium an index, such as index=1.5" if has_medium else cure
        _refuse(parts, number, f"{found[0]:g} on both sides; {cure}")
    return found[0], found[1]


def _refuse(parts: SceneParts, number: int, got: str) -> NoReturn:
    must = "Dielectric() takes its indices from the media beside it"
    raise SceneError(f"Scene: {surface_name(parts, number)}: {must}, got {got}")


def _media_beside(parts: SceneParts, surface: Surface, side: float) -> list[AnyMedium]:
    """Return the media at places just off one side of a surface, each once."""
    found: dict[AnyMedium, None] = {}
    for piece in surface.shape.pieces():
        if piece.is_infinite:
            places, normals = np.array([piece.middle]), np.array([piece.normal])
            size = 1.0
        else:
            u = np.modf(np.arange(1, PLACES + 1)[:, None] * STRIDES)[0]
            (places, normals), size = piece.sample_area(u), piece.extent
        found |= dict.fromkeys(media_at(parts, places + side * OFFSET * size * np.asarray(normals)))
    return list(found)
