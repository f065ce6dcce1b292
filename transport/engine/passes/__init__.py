"""Passes: the steps of a particle, by subject. A module is loaded when first needed."""

from transport.engine.registry import MODULES

globals().update(MODULES)
