"""Diagnostics: what a run may have missed, found by reading its sums and its scene."""
