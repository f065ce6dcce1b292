"""Bundles of particles, passes over their lanes, programs of passes, and the driver that runs them."""

from transport.engine.families import FAMILIES

globals().update(FAMILIES)  # files of passes, each read when a scene first calls for one of its own
