"""Compile a scene into a plan: tables in scene lengths for the steps that the scene needs. No Numba here."""

from transport.compile.compiler import compile_scene

__all__ = ["compile_scene"]
