"""Materials: how a surface acts on arriving particles; equal on both sides except for TwoSided."""

from transport.materials.base import Material
from transport.materials.combined import Mixture, TwoSided, is_specular, lets_through, simple_parts
from transport.materials.optical import Dielectric, Glossy, ThinLens
from transport.materials.plain import Black, Diffuse, Mirror, Transparent
from transport.materials.surface import Surface

__all__ = [
    "Black", "Dielectric", "Diffuse", "Glossy", "Material", "Mirror", "Mixture", "Surface", "ThinLens",
    "Transparent", "TwoSided", "is_specular", "lets_through", "simple_parts",
]  # fmt: skip
