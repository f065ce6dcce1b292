"""Base class of materials, and the check of reflected and transmitted fractions."""

from transport.validation import refuse, settle_fraction


class Material:
    """Base class of materials; not instantiated directly."""


def settle_shares(material: Material, reflected: str, transmitted: str) -> None:
    """Convert both fields to floats in [0, 1]; raise SceneError if their sum exceeds 1."""
    settle_fraction(material, reflected, transmitted)
    one, other = getattr(material, reflected), getattr(material, transmitted)
    if one + other > 1:
        got = f"{one} + {other} = {one + other}"
        refuse(material, f"{reflected} + {transmitted} must not be above 1, got {got}; lower one of them")
