"""Stages of a particle's life: the passes that a scene needs at birth, in flight and at surfaces."""
