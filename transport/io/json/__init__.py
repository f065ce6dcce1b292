"""Scenes as JSON: exact bit for bit, writable by hand, and runnable without Python code."""
