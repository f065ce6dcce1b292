"""Stages of a particle's life: which passes a scene needs at birth, in flight, at surfaces, and in which order."""
