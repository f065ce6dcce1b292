"""Regions of media: which bodies a scene's surfaces bound, what is where, and whether that can be."""
