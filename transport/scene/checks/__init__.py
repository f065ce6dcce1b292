"""Checks that the parts of a scene go together."""
