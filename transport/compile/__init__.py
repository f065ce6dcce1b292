"""From a scene to a plan: tables in scene lengths for just the steps that it calls for.  No Numba here."""

from transport.compile.compiler import compile_scene

__all__ = ["compile_scene"]
