"""Speeds in a scene: which occur, and whether particles must carry a speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from transport.scene.parts import has_emission
from transport.units import speed_of_light

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts
    from transport.scene.speeds import SpeedDistribution


def scene_speeds(scene: SceneParts) -> set[float | SpeedDistribution]:
    """Return the speeds of a scene.

    Returns
    -------
    set of float or SpeedDistribution
        Speeds [m/s] and distributions with which particles are emitted or leave walls.
    """
    emitted = {source.emission.speed for source in scene.sources}
    if has_emission(scene):
        emitted.add(speed_of_light)
    return emitted | {
        part.speed
        for surface in scene.surfaces
        for part in surface.material.elements
        if part.speed is not None
    }


def needs_particle_speeds(scene: SceneParts) -> bool:
    """Return whether particles must carry a speed.

    They must if speeds differ in a scene with a clock, or if a detector observes speeds.
    """
    differ = has_several_speeds(scene_speeds(scene))
    looked_at = any(detector.speeds is not None or detector.moments for detector in scene.meters)
    return (differ and scene.duration is not None) or looked_at or bool(scene.phase_spaces or scene.snapshots)


def has_several_speeds(speeds: set[float | SpeedDistribution]) -> bool:
    """Return whether there is more than one speed."""
    return len(speeds) > 1 or not all(isinstance(speed, float) for speed in speeds)


def max_speed(speed: float | SpeedDistribution) -> float:
    """Return an upper bound [m/s] of a speed or distribution."""
    return speed if isinstance(speed, float) else speed.fastest


def missing_mass_message(scene: SceneParts) -> tuple[str, str]:
    """Return what a quantity that needs the mass lacks, and the cure, as two parts of a message."""
    if scene.measured_in == "watts":
        return "particles of one mass, got energies in watts", "emit a Gas or Effusive"
    masses = {getattr(source.emission, "mass", None) for source in scene.sources}
    if len(masses) > 1:
        got = ", ".join("none" if mass is None else f"{mass} kg" for mass in masses)
        return f"particles of one mass, got {got}", "simulate each species in a scene of its own"
    return "particles of known mass, got none", "write mass=... in kg in the source's emission"


def scene_mass(scene: SceneParts) -> float | None:
    """Return the mass [kg] of a particle if it is known and the same for all, else None."""
    masses = {getattr(source.emission, "mass", None) for source in scene.sources}
    return masses.pop() if len(masses) == 1 else None
