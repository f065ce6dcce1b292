"""Refuse surfaces so thin that rounding would distort them.

An acting surface reaches over its edges by the rounding of what lands there, so that closed boxes do not leak
(pieces.slack_of).
For a flat surface of aspect ratio 1e8 that is 1e-7 of its width; for 1e14 it would be one half, unnoticed.
Light along a thin fibre meets its sides at an angle of radius over length, which magnifies the rounding of a
position along the fibre. Once that reaches the fibre's length, light may be in or out of the glass by chance.
"""

from __future__ import annotations

import math

from transport.compile.pieces import slack_of
from transport.compile.space import Space
from transport.materials import Dielectric
from transport.shapes import Cone, Cylinder, Disk, Paraboloid, Rectangle, Shape, Triangle
from transport.sheets import Member, Sheet
from transport.validation import refuse

WIDENED = 2.0**-11  # of the width on each side: a flux that is 0.1 % off


def check_slivers(sheets: list[Sheet], space: Space) -> None:
    """Raise SceneError for a surface too narrow for its position.

    Faces of a box bound one another and need no check.
    """
    for sheet in sheets:
        for member in sheet.members:
            if member.surface is not None and member.whole in (None, member.shape):
                _check(member, space)


def _check(member: Member, space: Space) -> None:
    if isinstance(member.shape, Cylinder | Cone | Paraboloid) and isinstance(
        member.surface.material, Dielectric
    ):
        _check_fibre(member, space)
    width, slack = _width(member.shape), slack_of(member, space) * space.size
    if slack > WIDENED * width:
        cure = "make it wider, cut it into shorter ones, or bring far objects nearer"
        must = f"a flat surface here must be wider than {slack / WIDENED:.2g} m because of rounding"
        refuse(member.surface, f"{must}, got {width:.3g} m; {cure}")


def _check_fibre(member: Member, space: Space) -> None:
    """Refuse a dielectric tube so thin that rounding along it reaches its length."""
    profile, length = member.shape.profile, member.shape.extent
    radius = max(map(profile.radius_at, (profile.low, profile.high)))
    least = math.sqrt(slack_of(member, space) * space.size * length)
    if radius < least:
        cure = "make it thicker or shorter, or bring far objects nearer"
        must = f"glass {length:.3g} m long must have a radius above {least:.2g} m here because of rounding"
        refuse(member.surface, f"{must}, got {radius:.3g} m; {cure}")


def _width(shape: Shape) -> float:
    """Return the least width of a flat shape [m]; infinite for other shapes."""
    match shape:
        case Rectangle(width=width, height=height):
            return min(width, height)
        case Disk(radius=radius, inner_radius=inner):
            return radius - inner
        case Triangle(vertices=(a, b, c)):
            return 2 * shape.area / max(math.dist(a, b), math.dist(b, c), math.dist(c, a))
    return math.inf
