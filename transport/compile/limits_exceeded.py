"""Errors of runs that are stopped before their exact sums overflow, with the cure for each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from transport.scene.parts import join_surface_names
from transport.validation import SceneError

if TYPE_CHECKING:
    from transport.compile.plan import Plan

MANY_CROSSINGS_PER_HISTORY = 10_000  # mean crossings per history beyond which smaller batches do not help


class OverrunError(SceneError, OverflowError):
    """Error of a run that would never end or overflow its exact sums; the message gives cause and cure."""


def too_many_copies_error(plan: Plan, copies: int, histories: int) -> OverrunError:
    """Error for splitting that makes ever more copies of `histories` started histories."""
    return OverrunError(
        f"Splitting: gain must suit the scene, got {plan.tracking.splitting.gain:g}, which made {copies}"
        f" copies of {histories} histories, {copies / histories:.2g} of each; lower it:"
        " about 1 / transmission is best"
    )


def full_bank_error(plan: Plan, room: int) -> OverrunError:
    """Error for a full bank of waiting copies."""
    splitting = plan.tracking.splitting
    if splitting is None:
        return OverrunError(
            f"Tracking: forced made more than {room} waiting copies; leave it out: it is for a few thin media"
        )
    return OverrunError(
        f"Splitting: gain must suit the scene, got {splitting.gain:g}, which made more than {room} waiting"
        " copies; lower it: about 1 / transmission is best"
    )


def too_many_crossings_error(plan: Plan, crossings: int, started: int) -> OverrunError:
    """Error for a batch of which `started` histories had started when it was stopped."""
    each = crossings / max(started, 1)
    if each < MANY_CROSSINGS_PER_HISTORY:
        cure = "pass more batches"
    elif plan.splits:
        cure = f"lower the gain of the Splitting, got {plan.tracking.splitting.gain:g}, or pass more batches"
    elif plan.absorbs or plan.absorbing_media:
        cure = "let surfaces around the light absorb more, give the scene a duration, or pass more batches"
    else:
        cure = (
            "nothing in the scene absorbs, and light trapped by total internal reflection or mirrors is"
            " traced forever: let a surface or a medium absorb a little, or give the scene a duration"
        )
    return OverrunError(
        f"simulate: a batch made {crossings} crossings, {each:.2g} for each of its {started} started"
        f" histories, more than its exact sums hold; {cure}"
    )


def endless_particles_error(plan: Plan, surfaces: list[int], particles: int) -> OverrunError:
    """Error for a batch with endless particles; surfaces: indices of those that they met last."""
    where = join_surface_names(plan.scene, surfaces)
    these = f"{particles} particles do" if particles > 1 else "1 particle does"
    return OverrunError(
        f"simulate: {these} not end: after millions of crossings or collisions"
        f"{f', the last at {where},' * bool(where)} none was absorbed or has escaped."
        " Let a surface or a medium there absorb a little, or give the scene a duration"
    )


def too_many_scores_error(histories: int) -> OverrunError:
    """Error for a batch that overflows its volume or point detectors."""
    return OverrunError(
        f"simulate: a batch of {histories} histories scored more than the exact sums of volume and point"
        " detectors hold; pass more batches"
    )
