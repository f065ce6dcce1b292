"""Packed words of a lane, read by name: its hit, and its `sheet` (bits: compile/layout.py)."""

from transport.compile import layout
from transport.physics.device import device


@device
def sheet_of(hit):
    """Return the sheet of a hit."""
    return hit >> layout.SHEET_SHIFT


@device
def surface_of(hit):
    """Return the row of the acting surface; 0: none."""
    return (hit >> layout.SURFACE_SHIFT) & layout.SURFACE_MASK


@device
def material_of(hit):
    """Return the code of the acting surface's material."""
    return (hit >> layout.MATERIAL_SHIFT) & layout.MATERIAL_MASK


@device
def is_covered(hit, layer):
    """Return whether the detector or boundary in this layer of the sheet covers the point."""
    return ((hit >> layer) & 1) != 0


@device
def standing_sheet(places):
    """Return the sheet that a ray began on. places: the lane's `sheet` word."""
    return places & layout.STANDING_SHEET_MASK


@device
def passed_sheet(places):
    """Return the sheet of the detector that a ray passed last; 0: none."""
    return places >> layout.PASSED_SHIFT
