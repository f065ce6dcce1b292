"""Compilation time, machine code and bytes per lane of each kind of scene (`transport bench --cold`)."""

from collections.abc import Callable

from transport.cli.bench.benchmarks import (
    disks_scene,
    glass_ball_scene,
    mesh_box_scene,
    slab_scene,
    thermal_box_scene,
)
from transport.cli.effects.compile_times import CompileTime, compile_times_in, library_copy
from transport.cli.effects.costs import Footprint, footprint_of
from transport.cli.effects.prices import base_room, with_addition
from transport.cli.effects.treatment import Treatment, treatment_of


def _room_with(name: str) -> Callable[[], Treatment]:
    return lambda: with_addition(name, base_room())


SCENES: dict[str, Callable[[], Treatment]] = {
    "coaxial disks, one flight": disks_scene,
    "closed box of diffuse walls": base_room,
    "... with clock, speeds, thermal walls": thermal_box_scene,
    "glass ball": glass_ball_scene,
    "mesh": mesh_box_scene,
    "slab of fog": slab_scene,
    "box of voxels in a room": _room_with("... of 8 x 8 x 8 voxels"),
    "point detector in fog": _room_with("... a point detector"),
    "camera, backward histories": _room_with("... a camera of 16 x 16 pixels"),
}


def compile_times() -> dict[str, tuple[CompileTime, CompileTime, Footprint]]:
    """Return for each kind of scene the start with an empty cache, the next start, and the footprint."""
    found = {}
    for name, make in SCENES.items():
        kind = treatment_of(make())
        with library_copy() as folder:
            first, second = compile_times_in(folder, [kind, kind])
        found[name] = first, second, footprint_of(kind.program)
    return found


def compile_time_rows(starts: dict[str, tuple[CompileTime, CompileTime, Footprint]]) -> list[dict]:
    """Return rows {name, value, unit, ratio} with sizes for JSON; ratio is second start / first start."""
    return [
        {"name": f"cold start, {name}", "value": first.seconds, "unit": "s"}
        | {"ratio": second.seconds / first.seconds}
        | {"passes": first.passes, "driver": first.driver, "bytes": first.bytes}
        | {"touched": footprint.touched, "carried": footprint.carried, "used": footprint.used}
        for name, (first, second, footprint) in starts.items()
    ]
