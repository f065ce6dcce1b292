"""Packed words of a lane, read by name: `covered` and `sheet` (bits: compile/layout.py)."""

from transport.compile import layout
from transport.physics.device import device


@device
def is_covered(covered, layer):
    """Return whether the detector or boundary in this layer of the sheet covers the point."""
    return ((covered >> layer) & 1) != 0


@device
def standing_sheet(places):
    """Return the sheet that a ray began on. places: the lane's `sheet` word."""
    return places & layout.STANDING_SHEET_MASK


@device
def passed_sheet(places):
    """Return the sheet of the detector that a ray passed last; 0: none."""
    return places >> layout.PASSED_SHIFT
