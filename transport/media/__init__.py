"""Participating media: coefficients and phase functions of the space between surfaces."""

from transport.media.base import Phase
from transport.media.grid import Grid
from transport.media.medium import Medium, Vacuum
from transport.media.phases import HenyeyGreenstein, Rayleigh, Tabulated

__all__ = ["Grid", "HenyeyGreenstein", "Medium", "Phase", "Rayleigh", "Tabulated", "Vacuum"]
