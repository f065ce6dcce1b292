"""Bundles of particles, passes over their lanes, programs of passes, and the driver that runs them."""

from transport.engine.families import FAMILIES

globals().update(FAMILIES)  # modules of passes, each loaded when a scene first needs one of its passes
