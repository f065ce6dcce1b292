"""Bundles of particles, passes over their lanes, programs of passes, and the driver that runs them."""
