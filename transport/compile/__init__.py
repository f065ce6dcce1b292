"""Compile a scene into a plan: tables in scene lengths for the steps that the scene needs. No Numba here."""
