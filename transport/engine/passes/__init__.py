"""Passes: the steps of a particle as loops over lanes. A module is loaded when first needed."""

from transport.engine.registry import MODULES

globals().update(MODULES)
