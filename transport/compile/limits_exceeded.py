"""Runs that are stopped before their exact sums could leave their range, and what to do about each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from transport.materials.surface import titled
from transport.validation import SceneError, listed

if TYPE_CHECKING:
    from transport.compile.plan import Plan

LONG = 10_000  # crossings of a history in the mean, beyond which smaller batches are no cure


class OverrunError(SceneError, OverflowError):
    """A run that would never end, or would leave the range of its exact sums; the message says why, and the cure."""


def too_many_copies(plan: Plan, copies: int, histories: int) -> OverrunError:
    """Of a run whose splitting makes ever more copies of `histories` that have set out."""
    return OverrunError(
        f"Splitting: gain must suit the scene, got {plan.tracking.splitting.gain:g}, which made {copies} copies of"
        f" {histories} histories, {copies / histories:.2g} of each; lower it: about 1 / transmission is best"
    )


def too_many_waiting(plan: Plan, room: int) -> OverrunError:
    """Of a bank with no room left."""
    splitting = plan.tracking.splitting
    if splitting is None:
        return OverrunError(
            f"Tracking: forced has made more than {room} copies that wait for their turn; leave it out: it is for a"
            " few thin media"
        )
    return OverrunError(
        f"Splitting: gain must suit the scene, got {splitting.gain:g}, which made more than {room} copies that wait for"
        " their turn; lower it: about 1 / transmission is best"
    )


def too_many_crossings(plan: Plan, crossings: int, started: int) -> OverrunError:
    """Of a batch of which so many histories had set out when it was stopped."""
    each = crossings / max(started, 1)
    if each < LONG:
        cure = "ask for more batches"
    elif plan.splits:
        cure = (
            f"lower the gain of the Splitting, got {plan.tracking.splitting.gain:g}, or ask for more batches"
        )
    elif plan.absorbs or plan.absorbing_media:
        cure = "let what shuts it in absorb more, give the scene a duration, or ask for more batches"
    else:
        cure = (
            "nothing in the scene absorbs, and light that total reflection or mirrors keep is followed for ever: let a"
            " surface or a medium absorb a little, or give the scene a duration"
        )
    return OverrunError(
        f"simulate: a batch made {crossings} crossings, {each:.2g} of each of the {started} histories that had set out,"
        f" more than its exact sums hold; {cure}"
    )


def endless(plan: Plan, surfaces: list[int], particles: int) -> OverrunError:
    """Of a batch in which particles go on for ever; surfaces: the numbers of those that they met last."""
    where = listed([titled(plan.scene.surfaces[number], number) for number in surfaces])
    these = f"{particles} particles do" if particles > 1 else "1 particle does"
    return OverrunError(
        f"simulate: {these} not end: after millions of crossings or collisions{f', the last at {where},' * bool(where)} none"
        " was absorbed or has escaped. Let a surface or a medium there absorb a little, or give the scene a duration"
    )


def too_many_scores(histories: int) -> OverrunError:
    """Of a batch whose volume or point detectors are full."""
    return OverrunError(
        f"simulate: a batch of {histories} histories scored more than the exact sums of volume and point detectors"
        " hold; ask for more batches"
    )
