"""Passes: the steps of a particle as loops over lanes. A module is loaded when a scene first needs one of its passes."""

from transport.engine.registry import MODULES

globals().update(MODULES)
