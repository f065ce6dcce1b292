"""Objects to refuse wrong ones with, and what a refusal must say."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import pytest

import transport as tp

DISK, BALL, CUBE = tp.Disk(radius=1), tp.Sphere(radius=2), tp.Box(size=(1, 2, 3))
LAMP = tp.Source(DISK, tp.Lambertian(power=1))
WALL = tp.Surface(DISK, tp.Black(), name="floor")


def meter(**how):
    return tp.Detector(DISK, name="lid", **how)


def assert_refused(make: Callable[[], object], words: str | Iterable[str]) -> str:
    """Return the message, and fail unless the call is refused with all these words: object, parameter, value, cure.

    A text is the message itself; " ... " in it stands for whatever the message says there.
    """
    with pytest.raises(tp.SceneError) as caught:
        make()
    message, place = str(caught.value), 0
    if isinstance(words, str):
        for part in words.split(" ... "):
            assert part in message[place:], message
            place = message.index(part, place) + len(part)
    assert isinstance(words, str) or [word for word in words if word not in message] == [], message
    assert len(message) < 600, message
    return message
