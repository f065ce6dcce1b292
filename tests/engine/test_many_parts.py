"""How many materials a scene may have, and detectors on one sheet: parts of words set the limits (compile/layout.py)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import transport as tp
from transport.compile import layout
from transport.engine import program
from transport.engine.bodies import lane_pass
from transport.physics.directions import select
from transport.scene.materials import Material, MaterialRow, Shares

LAMP = tp.Source(tp.Disk(radius=0.01), tp.Beam(direction=(0, 0, 1), power=1.0))


@dataclass(frozen=True)
class Retroreflector(Material):
    """Sends light back along its path."""

    reflectance: float

    @property
    def shares(self) -> Shares:
        return Shares(1 - self.reflectance, specular=self.reflectance)

    def row(self) -> MaterialRow:
        return MaterialRow("retroreflector", albedo=self.reflectance)


def test_a_ninth_material_is_one_more_entry(monkeypatch):
    """A pencil beam on a tilted disk returns to where it came from; there were eight codes."""
    code = max(8, len(layout.INTERACTIONS))
    names = (*layout.INTERACTIONS, *["unused"] * (code - len(layout.INTERACTIONS)), "retroreflector")
    monkeypatch.setattr(layout, "INTERACTIONS", names)

    @lane_pass(layout.NO_TABLE)
    def retroreflect(lane, table):
        here = lane.material == 8
        lane.ux, lane.uy, lane.uz = select(here, -lane.ux, -lane.uy, -lane.uz, lane.ux, lane.uy, lane.uz)
        lane.mu = -lane.mu if here else lane.mu
        lane.event += 1 if here else 0

    monkeypatch.setitem(program.NEW_DIRECTIONS, code, lambda: [retroreflect])
    tilted = tp.Disk(center=(0, 0, 1), normal=(np.sin(0.5), 0, -np.cos(0.5)), radius=0.2)
    meter = tp.Detector(tp.Disk(center=(0, 0, 0.5), radius=0.02), name="meter")
    scene = tp.Scene(
        LAMP, tp.Surface(tilted, Retroreflector(0.8), name="mirror"), [meter, tp.Detector("mirror")]
    )
    result = tp.simulate(scene, particles=1000, seed=1, threads=1, batches=4, progress=False)
    assert code == 8
    assert result["meter"].flux_out.value == pytest.approx(1, abs=1e-12)
    assert result["meter"].flux_in.value == pytest.approx(0.8, abs=1e-12)
    assert result["mirror"].flux_out.value == pytest.approx(0.8, abs=1e-12)


def test_sixty_detectors_share_a_sheet_and_no_more():
    def scene(count):
        looks = [
            tp.Detector(tp.Disk(center=(0, 0, 1), radius=0.02 + 0.01 * k), name=f"m{k}") for k in range(count)
        ]
        return tp.Scene(LAMP, (), looks)

    result = tp.simulate(scene(60), particles=200, seed=1, threads=1, batches=2, progress=False)
    assert [result[f"m{k}"].flux_out.value for k in (0, 30, 59)] == pytest.approx([1, 1, 1], abs=1e-12)
    with pytest.raises(tp.SceneError, match="at most 60 detectors"):
        tp.simulate(scene(61), particles=200, seed=1, progress=False)
