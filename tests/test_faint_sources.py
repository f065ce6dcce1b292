"""A source so faint that hardly a history is born on it is named; what was never scored is not said to be well known."""

from __future__ import annotations

import transport as tp


def lamps(power: float) -> tp.Scene:
    """A lamp of 1 W, and one of `power` beside a meter of its own, behind a black screen."""
    screen = tp.Surface(tp.Plane(), tp.Black())
    meters = [
        tp.Detector(tp.Disk(center=(0, 0, z), normal=(0, 0, -z), radius=0.5), name)
        for z, name in ((1, "up"), (-1, "down"))
    ]
    sources = [
        tp.Source(tp.Point(position=(0, 0, z)), tp.Isotropic(power=p)) for z, p in ((0.5, 1.0), (-0.5, power))
    ]
    return tp.Scene(sources, screen, meters)


def told(power: float, **options) -> tuple[list[str], str]:
    result = tp.simulate(lamps(power), 20_000, seed=1, progress=False, **options)
    return [warning for warning in result.warnings if "of the total power" in warning], result.report()


def test_a_faint_lamp_is_named():
    (warning,), _ = told(1e-20)
    assert warning.startswith("sources[1] has 1e-20 of the total power and so about 2e-16 of 20000 histories")
    assert told(1e-20, estimator="expected")[0]


def test_lamps_with_histories_of_their_own_are_not():
    found, report = told(1e-2)
    assert not found
    assert "no finding against them" in report


def test_one_lamp_alone_is_never_faint():
    ball = tp.Detector(tp.Sphere(radius=1.0), "ball")
    alone = tp.Scene(tp.Source(tp.Point(), tp.Isotropic(power=1e-300)), (), ball)
    result = tp.simulate(alone, 2, seed=1, progress=False)
    assert not any("of the total power" in warning for warning in result.warnings)
