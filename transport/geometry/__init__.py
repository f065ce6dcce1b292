"""Shapes of sources, surfaces and detectors. Lengths are in metres; all parameters are keyword-only.

Every shape has `area` [m^2] (except Point and Cloud), `bounds` (lower and upper corner), `extent` (radius of
a sphere around `middle` that holds the shape), `is_closed` and `is_infinite`. Shapes with an axis or a normal
have a `frame`.
"""
