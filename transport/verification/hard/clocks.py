"""Clocks: simultaneous events, durations shorter than a flight, times of 1e17 s."""

from __future__ import annotations

import numpy as np

import transport as tp
from transport.verification.hard.cases import CaseResult, case

UP = tp.Gas(number=1.0, speed=1.0, direction=(0, 0, 1))
LAMP, FLASH = tp.Isotropic(power=1.0, speed=1.0), tp.Isotropic(energy=1.0, speed=1.0)
SPEED_OF_LIGHT = 299792458.0  # m/s
LONG_TIME = 1e17  # s


def _run(scene: tp.Scene, particles: int = 1000) -> tp.Result:
    return tp.simulate(scene, particles, seed=1, progress=False)


def _lamp_in_a_ball(
    radius: float, duration: float, emission: tp.Isotropic, pulse: tp.Instant | None = None, times=None
) -> tp.Scene:
    """A lamp at the center of a detecting sphere, which all its particles reach simultaneously."""
    ball = tp.Detector(tp.Sphere(radius=radius), "ball", side="inside", times=times)
    return tp.Scene(tp.Source(tp.Point(), emission, pulse=pulse), detectors=ball, duration=duration)


# ---- simultaneous events ----


@case(
    "an arrival at 0.7 s, in bins of 0.1 s: what is in the bin that begins then",
    naive="bin int(0.7 / 0.1), which is 6",
)
def on_the_edge_of_a_bin() -> CaseResult:
    """0.7 / 0.1 rounds to 6.999999999999999. An arrival at an edge belongs to the bin above it."""
    wall = tp.Detector(tp.Disk(center=(0, 0, 0.7), normal=(0, 0, -1), radius=1.0), "wall", times=10)
    counts = _run(tp.Scene(tp.Source(tp.Point(), UP), detectors=wall, duration=1.0))["wall"].counts.value
    naive = np.bincount([int(0.7 / 0.1)] * 1000, minlength=10)
    return CaseResult(float(counts[7]), 1000.0, float(naive[7]), within=0.0)


@case(
    "the velocity at the instant of a reflection",
    naive="the snapshot precedes the reflection: the velocity is still upwards",
)
def snapshot_and_reflection() -> CaseResult:
    """A snapshot shows a particle after all events of its instant, in whatever order they are computed."""
    mirror = tp.Surface(tp.Plane(center=(0, 0, 1)), tp.Mirror())
    scene = tp.Scene(
        tp.Source(tp.Point(), UP), mirror, tp.Snapshot(1.0, particles=1000, name="then"), duration=2.0
    )
    return CaseResult(float(_run(scene)["then"].velocities[:, 2].mean()), -1.0, naive=1.0)


@case("two meters and a wall in one plane, met at once: crossings counted", naive="one event per instant")
def three_at_once() -> CaseResult:
    """Each of the three scores every particle. An event loop that takes the nearest surface drops the
    others at the same distance.
    """
    plane = tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0)
    small = tp.Rectangle(center=(0, 0, 1), width=0.3, height=0.3)
    detectors = [tp.Detector("wall"), tp.Detector(plane, "one"), tp.Detector(small, "two", side="back")]
    scene = tp.Scene(
        tp.Source(tp.Point(), UP), tp.Surface(plane, tp.Black(), "wall"), detectors, duration=2.0
    )
    result = _run(scene)
    found = sum(result[name].counts.value for name in ("wall", "one", "two"))
    return CaseResult(float(found), 3000.0, naive=1000.0, within=0.0)


# ---- short durations ----


@case("the energy that has come 1 m far in a quarter of the time that it takes", naive="power times duration")
def shorter_than_a_flight() -> CaseResult:
    """Nothing has arrived; all energy is in flight."""
    result = _run(_lamp_in_a_ball(1.0, 0.25, LAMP))
    return CaseResult(result["ball"].energy_in.value, 0.0, naive=0.25)


@case("the same in five quarters of that time", naive="power times duration")
def first_light() -> CaseResult:
    """Only the energy emitted in the first quarter has arrived; a steady-state result would be five
    times too large.
    """
    found = _run(_lamp_in_a_ball(1.0, 1.25, LAMP), 20_000)["ball"].energy_in
    return CaseResult(found, 0.25, naive=1.25)


@case(
    "a flight of 1 s in a duration of 1e-300 s: what is in flight",
    naive="division by the step's fraction 1e-300 / 1, which counts as 0",
)
def hardly_any_time() -> CaseResult:
    """Times are in units of the duration and lengths in units of the scene: the arrival after 1e300
    durations is a finite number.
    """
    ledger = _run(_lamp_in_a_ball(1.0, 1e-300, FLASH)).ledger
    return CaseResult(ledger["in_flight"].value, 1.0)


# ---- long times ----


@case("a watt for three billion years: the mean flux", naive="a clock in whole nanoseconds, 64 bits")
def long_time() -> CaseResult:
    """1e17 s are 1e26 ns, beyond 2^63: a 64-bit nanosecond clock overflows more than a million times.
    The engine's times are in units of the duration.
    """
    found = _run(_lamp_in_a_ball(1.0, LONG_TIME, tp.Isotropic(power=1.0)))["ball"].flux_in
    wrapped = (int(LONG_TIME * 1e9) + 2**63) % 2**64 - 2**63
    return CaseResult(found.value, 1.0, naive=wrapped / 1e9 / LONG_TIME)


@case(
    "light on its way for 1e17 s: what arrives within 0.2 % of its time",
    naive="times in float32, lengths in metres squared",
)
def across_the_universe() -> CaseResult:
    """3e25 m and 1e17 s: squared lengths exceed the range of float32."""
    radius, times = (
        0.5 * LONG_TIME * SPEED_OF_LIGHT,
        tuple(share * LONG_TIME for share in (0.0, 0.499, 0.501)),
    )
    ball = _lamp_in_a_ball(radius, LONG_TIME, tp.Isotropic(energy=1.0), tp.Instant(), times)
    with np.errstate(over="ignore", invalid="ignore"):
        naive = np.float32(radius) ** 2 / np.float32(radius) ** 2
    return CaseResult(_run(ball)["ball"].energy_in[1].value, 1.0, float(naive))


@case("a nanosecond's flight at the age of 1e17 s", naive="t + dt is t: the particle never arrives")
def late_and_short() -> CaseResult:
    """The clock's resolution is 16 s at that age. Flights are ordered by their lengths and end although
    the clock does not advance.
    """
    scene = _lamp_in_a_ball(
        1e-9, 2 * LONG_TIME, FLASH, tp.Instant(LONG_TIME), times=(0.0, LONG_TIME, 2 * LONG_TIME)
    )
    return CaseResult(_run(scene)["ball"].energy_in[1].value, 1.0)
