"""What two surfaces exchange, by counting: the view factor, and the étendue of the beam that joins them."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from transport.bodies.solids import contains
from transport.detectors import Detector
from transport.emissions import Lambertian
from transport.materials import Black, Surface
from transport.results import Result
from transport.results.estimates import Estimate
from transport.scene import Scene
from transport.shapes import Box, Cloud, FlatShape, Point, Shape, Sphere
from transport.sheets import are_on_one_support
from transport.sides import IS_BACK
from transport.simulate import simulate
from transport.sources import Source
from transport.validation import SceneError, shown, suggestion

NEAR = 1.0  # radii of the ball about a target, from whose middle on directions are aimed at it


def view_factor(
    a: Shape,
    b: Shape,
    blockers: Iterable[Shape] | Shape = (),
    particles: int = 1_000_000,
    seed: int = 0,
    side_a: str = "front",
    side_b: str = "front",
) -> Estimate:
    """View factor from a to b: the share of what leaves a diffusely that reaches b, an Estimate [1].

    side_a, side_b: the side that emits and the one that receives; a ball's front is its outside, so that what
    looks outwards at a sphere round it needs side_b="back".  a and b may be the same shape, which then sees
    itself.  All is black, on both sides, `blockers` as well as a and b: what meets anything else first does
    not arrive.

    Particles start on the smaller of the two areas, whose share is the larger one, and A_a F_ab = A_b F_ba
    gives the factor asked for; they are aimed at the other one where that is far away.  It is exact, without
    an error, where a flat side cannot see b at all.  For a single smooth factor with nothing in between this
    is not the method of choice: closed forms (transport.theory.view_factors and its neighbours) or quadrature
    give ten digits in milliseconds, where counting needs a hundred times the particles for one more.  Its
    worth is obstacles, meshes and shapes without a formula, and an error bar.  Calls with the same `seed` share their
    random numbers: give each its own where you add factors up, lest their errors be correlated.  Raises SceneError for what has
    no area, for shapes that overlap, and for the outside of a ball or box round the other shape, which it cannot see.
    """
    scene = view_factor_scene(a, b, blockers, side_a, side_b, "view_factor")
    return counted_view_factor(simulate(scene, particles=particles, seed=seed))


def etendue(
    a: Shape,
    b: Shape,
    blockers: Iterable[Shape] | Shape = (),
    particles: int = 1_000_000,
    seed: int = 0,
    side_a: str = "front",
    side_b: str = "front",
) -> Estimate:
    """Étendue of the beam that joins two apertures, ∬ cosθ dω dA, an Estimate [m^2 sr]; refractive index 1.

    It is pi A_a F_ab = pi A_b F_ba, all rays that lead from one to the other and meet nothing in between;
    parameters, method and errors as for `view_factor`.
    """
    scene = view_factor_scene(a, b, blockers, side_a, side_b, "etendue")
    share = counted_view_factor(simulate(scene, particles=particles, seed=seed))
    return _times(share, math.pi * a.area, "m^2 sr")


def view_factor_scene(
    a: Shape,
    b: Shape,
    blockers: Iterable[Shape] | Shape = (),
    side_a: str = "front",
    side_b: str = "front",
    caller: str = "view_factor_scene",
) -> Scene:
    """Black surfaces "a", "b" and "blockers[0]" ..., a source of 1 W on one of the first two, a detector on
    the other.

    Where a is b there is one surface "a".  Raises SceneError for what `view_factor` refuses.
    """
    for name, shape in (("a", a), ("b", b)):
        _check_shape(caller, name, shape)
    for name, side in (("side_a", side_a), ("side_b", side_b)):
        if side not in IS_BACK:
            raise SceneError(
                f"{caller}: {name} must be 'front' or 'back', got {shown(side)}; {suggestion(side, IS_BACK)}"
            )
    surfaces = {"a": Surface(a, Black(), name="a")}
    if b != a:
        surfaces["b"] = Surface(b, Black(), name="b")
    for place, blocker in enumerate(_as_shapes(caller, blockers)):
        name = f"blockers[{place}]"
        surfaces[name] = Surface(blocker, Black(), name=name)
    start, end = _way(a, b)
    sides, shapes = {"a": side_a, "b": side_b}, {"a": a, "b": b}
    aim = shapes[end] if _is_far(shapes[start], shapes[end]) else None
    place, looked_at = (name if name in surfaces else "a" for name in (start, end))
    source = Source(place, Lambertian(power=1.0), aim=aim, side=sides[start])
    scene = Scene(source, surfaces.values(), Detector(looked_at, "arrived", side=sides[end]))
    _check_sight(caller, a, b, side_a, "side_a", "b lies inside a")
    _check_sight(caller, b, a, side_b, "side_b", "a lies inside b")
    return scene


def counted_view_factor(result: Result) -> Estimate:
    """View factor from "a" to "b" [1] out of a run of a `view_factor_scene`."""
    shapes = {surface.name: surface.shape for surface in result.scene.surfaces}
    a, b = shapes["a"], shapes.get("b", shapes["a"])
    share = result["arrived"].flux_in / result.ledger["emitted"]
    if (
        share.value == 0
        and isinstance(a, FlatShape)
        and isinstance(b, FlatShape)
        and are_on_one_support(a, b)
    ):
        return Estimate(share.values, result.run, "1", exact=True)
    start, _ = _way(a, b)
    return share if start == "a" else _times(share, b.area / a.area, "1")


def _way(a: Shape, b: Shape) -> tuple[str, str]:
    """Where particles start, and where they go: from the smaller area to the larger one."""
    return ("a", "b") if a.area <= b.area else ("b", "a")


def _is_far(start: Shape, target: Shape) -> bool:
    """Whether aiming is allowed and pays: the ball about the target lies well beside the start's middle."""
    if not math.isfinite(target.area) or start == target:
        return False
    if isinstance(start, FlatShape) and isinstance(target, FlatShape) and are_on_one_support(start, target):
        return False
    apart = math.dist(start.middle, target.middle)
    touches_ball = not isinstance(target, FlatShape | Sphere) and apart < start.extent + target.extent
    return apart >= NEAR * target.extent and not touches_ball


def _check_shape(caller: str, name: str, shape: object) -> None:
    must = f"{caller}: {name} must be a shape with an area, such as Disk(radius=...)"
    if not isinstance(shape, Shape) or isinstance(shape, Point | Cloud):
        raise SceneError(f"{must}, got {shown(shape)}")
    if not math.isfinite(shape.area) and name == "a":
        raise SceneError(
            f"{must}, and of finite area, got {shown(shape)}; exchange a and b, A_a F_ab = A_b F_ba"
        )


def _check_sight(caller: str, shell: Shape, other: Shape, side: str, name: str, why: str) -> None:
    """Refuse the outside of a ball or box about the other shape: what they exchange is nothing, and surely not meant."""
    is_round = isinstance(shell, Sphere | Box) and shell.is_closed and shell != other
    if not IS_BACK[side] and is_round and contains(shell, other):
        raise SceneError(
            f"{caller}: {name} must be 'back' where {why}, got {shown(side)}, its outside; write {name}='back'"
        )


def _as_shapes(caller: str, blockers: object) -> tuple[Shape, ...]:
    shapes = (blockers,) if isinstance(blockers, Shape) else blockers
    if not isinstance(shapes, Iterable) or isinstance(shapes, str):
        raise SceneError(f"{caller}: blockers must be shapes, got {shown(blockers)}")
    shapes = tuple(shapes)
    for place, shape in enumerate(shapes):
        _check_shape(caller, f"blockers[{place}]", shape)
    return shapes


def _times(share: Estimate, factor: float, unit: str) -> Estimate:
    """The share times a known number, with its unit; an exact one stays exact."""
    return share * Estimate(np.full(len(share.run), factor), share.run, unit, exact=True)
