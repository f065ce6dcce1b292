"""What all materials share, and how shares of what arrives are checked."""

from transport.validation import refuse, settle_fraction


class Material:
    """What all materials share; not made itself."""


def settle_shares(material: Material, reflected: str, transmitted: str) -> None:
    """Both fields are in [0, 1] and so is their sum."""
    settle_fraction(material, reflected, transmitted)
    one, other = getattr(material, reflected), getattr(material, transmitted)
    if one + other > 1:
        got = f"{one} + {other} = {one + other}"
        refuse(material, f"{reflected} + {transmitted} must not be above 1, got {got}; lower one of them")
