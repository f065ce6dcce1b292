"""View factors and étendues of two surfaces by Monte Carlo."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable

import numpy as np

from transport.geometry.relations import are_on_one_support, encloses, is_behind
from transport.geometry.shape import Shape
from transport.geometry.solid import Sphere
from transport.results.result import Result
from transport.scene.detectors import Detector
from transport.scene.emissions import Lambertian
from transport.scene.materials import Black, Surface
from transport.scene.scene import Scene
from transport.scene.sides import IS_BACK, OTHER_SIDE
from transport.scene.sources import Source
from transport.simulate import simulate
from transport.statistics.estimates import Estimate
from transport.validation import SceneError, checked_keywords, short_repr

# Aim at a target if its centre is at least this many bounding radii away from the start's.
MIN_AIM_DISTANCE = 1.0


@checked_keywords
def view_factor(
    a: Shape,
    b: Shape,
    blockers: Iterable[Shape] | Shape = (),
    particles: int = 1_000_000,
    seed: int = 0,
    side_a: str = "front",
    side_b: str = "front",
) -> Estimate:
    """Estimate the view factor from a to b: the share of the flux that leaves a diffusely and reaches b.

    Parameters
    ----------
    a : Shape
        Emitting shape, of finite area.
    b : Shape
        Receiving shape; may be `a`, which then sees itself.
    blockers : Shape or iterable of Shape, default ()
        Black obstacles.
    particles : int, default 1_000_000
        Number of particles.
    seed : int, default 0
        Seed. Pass different seeds for factors that you add: equal seeds share random numbers, so that their
        errors are correlated.
    side_a : str, default "front"
        Emitting side of `a`: "front" or "back"; of a closed shape also "outside" (its front) or "inside".
    side_b : str, default "front"
        Receiving side of `b`; "inside" for a sphere around `a`.

    Returns
    -------
    Estimate
        View factor F_ab [1].

    Warns
    -----
    UserWarning
        If a side faces away from the other shape, so that the view factor is 0.

    Raises
    ------
    SceneError
        If a shape has no area, shapes overlap, or the emitting or receiving side is the outside of a sphere
        or box around the other shape, which it cannot see.

    Notes
    -----
    All surfaces are black on both sides, so that a ray ends at the first surface it hits. Particles start on
    the smaller of the two areas, and reciprocity A_a F_ab = A_b F_ba gives the requested factor. They are
    aimed at the other shape if it is far away. The result is exact, without an error, if two flat shapes lie
    in one plane.

    For an unobstructed pair with a closed form use the formula (`transport.theory.view_factors`) or
    quadrature: they give ten digits in milliseconds, where Monte Carlo needs a hundred times the particles
    per digit. This function is for obstacles, meshes and shapes without a formula, and it gives an error.

    Examples
    --------
    >>> import transport as tp
    >>> a = tp.Disk(radius=1.0)
    >>> b = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0)
    >>> tp.view_factor(a, b, particles=10_000)
    <Estimate (0.3824 ± 0.0021), 32 batches>
    """
    scene = view_factor_scene(a, b, blockers, side_a, side_b, "view_factor")
    _warn_if_facing_away("view_factor", a, b, side_a, side_b)
    return view_factor_from_run(simulate(scene, particles=particles, seed=seed))


@checked_keywords
def etendue(
    a: Shape,
    b: Shape,
    blockers: Iterable[Shape] | Shape = (),
    particles: int = 1_000_000,
    seed: int = 0,
    side_a: str = "front",
    side_b: str = "front",
) -> Estimate:
    """Estimate the étendue of the beam that joins two apertures, ∬ cosθ dω dA, at refractive index 1.

    Parameters
    ----------
    a : Shape
        Emitting shape, of finite area.
    b : Shape
        Receiving shape; may be `a`, which then sees itself.
    blockers : Shape or iterable of Shape, default ()
        Black obstacles.
    particles : int, default 1_000_000
        Number of particles.
    seed : int, default 0
        Seed. Pass different seeds for factors that you add: equal seeds share random numbers, so that their
        errors are correlated.
    side_a : str, default "front"
        Emitting side of `a`: "front" or "back"; of a closed shape also "outside" (its front) or "inside".
    side_b : str, default "front"
        Receiving side of `b`; "inside" for a sphere around `a`.

    Returns
    -------
    Estimate
        Étendue [m^2 sr].

    Raises
    ------
    SceneError
        As for `view_factor`.

    Notes
    -----
    The étendue is pi A_a F_ab = pi A_b F_ba: all rays from one aperture to the other that hit nothing in
    between. Method and errors are those of `view_factor`.

    Examples
    --------
    >>> import transport as tp
    >>> a = tp.Disk(radius=1.0)
    >>> b = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0)
    >>> tp.etendue(a, b, particles=10_000)
    <Estimate (3.774 ± 0.021) m^2 sr, 32 batches>
    """
    scene = view_factor_scene(a, b, blockers, side_a, side_b, "etendue")
    _warn_if_facing_away("etendue", a, b, side_a, side_b)
    share = view_factor_from_run(simulate(scene, particles=particles, seed=seed))
    return _scaled(share, math.pi * a.area, "m^2 sr")


def view_factor_scene(
    a: Shape,
    b: Shape,
    blockers: Iterable[Shape] | Shape = (),
    side_a: str = "front",
    side_b: str = "front",
    caller: str = "view_factor_scene",
) -> Scene:
    """Scene with black surfaces, a source of 1 W on one of a and b, and a detector on the other.

    The surfaces are named "a", "b" and "blockers[0]" ...

    If a is b there is one surface "a". Raises SceneError like `view_factor`.
    """
    for name, shape in (("a", a), ("b", b)):
        _check_shape(caller, name, shape)
    for name, side, shape in (("side_a", side_a, a), ("side_b", side_b, b)):
        if side not in IS_BACK or (side in ("outside", "inside") and not shape.is_closed):
            known = "'front', 'back', 'outside' or 'inside'" if shape.is_closed else "'front' or 'back'"
            where = f"{known} on a {type(shape).__name__}"
            raise SceneError(f"{caller}: {name} must be {where}, got {short_repr(side)}")
    # Make all shapes black; if b is a, one surface serves as both.
    surfaces = {"a": Surface(a, Black(), name="a")}
    if b != a:
        surfaces["b"] = Surface(b, Black(), name="b")
    for place, blocker in enumerate(_as_shapes(caller, blockers)):
        name = f"blockers[{place}]"
        surfaces[name] = Surface(blocker, Black(), name=name)
    # Emit from the smaller area, aimed if the other is far, and detect on the larger one.
    start, end = _start_and_target(a, b)
    sides, shapes = {"a": side_a, "b": side_b}, {"a": a, "b": b}
    aim = shapes[end] if _is_far(shapes[start], shapes[end]) else None
    place, looked_at = (name if name in surfaces else "a" for name in (start, end))
    source = Source(place, Lambertian(power=1.0), aim=aim, side=sides[start])
    scene = Scene(source, surfaces.values(), Detector(looked_at, "arrived", side=sides[end]))
    _check_facing(caller, a, b, side_a, "side_a", "b lies inside a")
    _check_facing(caller, b, a, side_b, "side_b", "a lies inside b")
    return scene


def view_factor_from_run(result: Result) -> Estimate:
    """View factor from "a" to "b" [1] from a run of a `view_factor_scene`."""
    shapes = {surface.name: surface.shape for surface in result.scene.surfaces}
    a, b = shapes["a"], shapes.get("b", shapes["a"])
    share = result["arrived"].flux_in / result.ledger["emitted"]
    if share.value == 0 and a.is_flat and b.is_flat and are_on_one_support(a, b):
        return Estimate(share.values, result.run, "1", exact=True)
    start, _ = _start_and_target(a, b)
    return share if start == "a" else _scaled(share, b.area / a.area, "1")


def _start_and_target(a: Shape, b: Shape) -> tuple[str, str]:
    """Names of the shapes where particles start and end: from the smaller area to the larger one."""
    return ("a", "b") if a.area <= b.area else ("b", "a")


def _is_far(start: Shape, target: Shape) -> bool:
    """Return whether aiming is possible and pays: the target lies well away from the start's middle."""
    if not math.isfinite(target.area) or start == target:
        return False
    if start.is_flat and target.is_flat and are_on_one_support(start, target):
        return False
    apart = math.dist(start.middle, target.middle)
    touches_ball = not (target.is_flat or isinstance(target, Sphere)) and apart < start.extent + target.extent
    return apart >= MIN_AIM_DISTANCE * target.extent and not touches_ball


def _warn_if_facing_away(caller: str, a: Shape, b: Shape, side_a: str, side_b: str) -> None:
    """Warn where a side of a flat shape faces away from all of the other, unless both lie in one plane."""
    if a.is_flat and b.is_flat and are_on_one_support(a, b):
        return
    for name, shape, side, other in (("a", a, side_a, b), ("b", b, side_b, a)):
        if is_behind(other, shape, side):
            away = "all of b" if name == "a" else "all of a"
            cure = f'reverse its normal, or write side_{name}="{OTHER_SIDE[side]}"'
            text = f"{caller}: the {side} of {name} faces away from {away}, so that the result is 0; {cure}"
            warnings.warn(text, UserWarning, stacklevel=4)  # the caller of the checked function
            return


def _check_shape(caller: str, name: str, shape: object) -> None:
    """Raise if a shape has no area, or an infinite one for a."""
    must = f"{caller}: {name} must be a shape with an area, such as Disk(radius=...)"
    if not isinstance(shape, Shape) or not shape.has_area:
        cure = "; pass its shape, surface.shape" if isinstance(shape, Surface) else ""
        raise SceneError(f"{must}, got {short_repr(shape)}{cure}")
    if not math.isfinite(shape.area) and name == "a":
        raise SceneError(
            f"{must}, and of finite area, got {short_repr(shape)}; exchange a and b: A_a F_ab = A_b F_ba"
        )


def _check_facing(caller: str, shell: Shape, other: Shape, side: str, name: str, why: str) -> None:
    """Refuse the outside of a sphere or box around the other shape: a mistake, the view factor is 0."""
    is_round = shell.is_convex and not shell.is_infinite and shell != other
    if not IS_BACK[side] and is_round and encloses(shell, other):
        raise SceneError(
            f"{caller}: {name} must be 'back' where {why}, got {short_repr(side)}, its outside;"
            f" write {name}='back'"
        )


def _as_shapes(caller: str, blockers: object) -> tuple[Shape, ...]:
    """The blockers as a tuple of shapes."""
    shapes = (blockers,) if isinstance(blockers, Shape | Surface) else blockers
    if not isinstance(shapes, Iterable) or isinstance(shapes, str):
        raise SceneError(f"{caller}: blockers must be shapes, got {short_repr(blockers)}")
    shapes = tuple(shapes)
    for place, shape in enumerate(shapes):
        _check_shape(caller, f"blockers[{place}]", shape)
    return shapes


def _scaled(share: Estimate, factor: float, unit: str) -> Estimate:
    """Share times a known number, with its unit; an exact share stays exact."""
    return share * Estimate(np.full(len(share.run), factor), share.run, unit, exact=True)
