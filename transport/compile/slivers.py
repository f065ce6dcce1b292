"""Slivers: flat surfaces so narrow that what bears rounding at their edges would widen them.

What acts reaches over its edges by the rounding of what arrives there, so that closed boxes do not leak (pieces.slack_of).
Of a sliver of aspect 1e8 that is 1e-7 of its width; of one of 1e14 it would be a half, and nothing would tell.
Light along a thin fibre meets its sides at angles of radius over length: what rounding leaves of a place is as much farther along
it, and once that is as long as the fibre, light no longer knows whether it is in the glass.
"""

from __future__ import annotations

import math

from transport.compile.pieces import slack_of
from transport.compile.space import Space
from transport.materials import Dielectric
from transport.shapes import Cone, Cylinder, Disk, Paraboloid, Rectangle, Shape, Triangle
from transport.sheets import Member, Sheet
from transport.validation import refuse

WIDENED = 2.0**-11  # of the width, on each side: a flux that is a thousandth off


def check_slivers(sheets: list[Sheet], space: Space) -> None:
    """Raise SceneError for a surface that is too narrow for where it lies; a box's faces are bounded by one another."""
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
        cure = "make it wider, cut it into shorter ones, or bring what is far away nearer"
        must = f"a flat surface here must be wider than {slack / WIDENED:.2g} m, which rounding leaves of it"
        refuse(member.surface, f"{must}, got {width:.3g} m; {cure}")


def _check_fibre(member: Member, space: Space) -> None:
    profile, length = member.shape.profile, member.shape.extent
    radius = max(map(profile.radius_at, (profile.low, profile.high)))
    least = math.sqrt(slack_of(member, space) * space.size * length)
    if radius < least:
        cure = "make it thicker, cut its length, or bring what is far away nearer"
        must = (
            f"glass {length:.3g} m long must be thicker than {least:.2g} m here, which rounding leaves of it"
        )
        refuse(member.surface, f"{must}, got a radius of {radius:.3g} m; {cure}")


def _width(shape: Shape) -> float:
    """The least width of a flat shape [m]; infinite for all others."""
    match shape:
        case Rectangle(width=width, height=height):
            return min(width, height)
        case Disk(radius=radius, inner_radius=inner):
            return radius - inner
        case Triangle(vertices=(a, b, c)):
            return 2 * shape.area / max(math.dist(a, b), math.dist(b, c), math.dist(c, a))
    return math.inf
