"""What the guides on media and surfaces, docstrings and messages say of layers, glass, points and events, done."""

from __future__ import annotations

import math

import numpy as np
import pytest

import transport as tp
from tests.run.test_simulate import LAMP, refusal, run
from transport.cli.docs import GUIDES
from transport.scene.bodies import MAX_BODIES

SAID = " ".join(
    " ".join((GUIDES / name).read_text(encoding="utf-8").split()) for name in ("media.md", "surfaces.md")
)


@pytest.mark.parametrize("is_empty_below", [True, False])
def test_layers_of_unlike_index_end_in_a_vacuum_that_is_named(is_empty_below):
    """As the guide says it: what lies below the last plane is inside of the first one's body."""
    media = [None, *(tp.Medium(absorption=1.0, index=index) for index in (1.5, 1.37, 1.44))]
    media.append(tp.Vacuum() if is_empty_below else None)
    indices = [1, 1.5, 1.37, 1.44, 1]
    planes = [
        tp.Surface(
            tp.Plane(center=(0, 0, -z)),
            tp.Dielectric(indices[z + 1], indices[z]),
            front=media[z],
            back=media[z + 1],
        )
        for z in range(4)
    ]
    beam = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
    assert "below the last one say `back=Vacuum()`" in SAID
    if is_empty_below:
        assert run(tp.Scene(beam, planes)).ledger["lost"].value == 0
    else:
        assert "write back=Vacuum()" in refusal(lambda: tp.Scene(beam, planes))


def test_the_guide_tells_the_most_bodies_and_what_to_do_with_more():
    assert f"At most {MAX_BODIES} bodies" in SAID
    layers = [
        tp.Surface(tp.Slab(center=(0, 0, -z), thickness=1), tp.Transparent(), inside=tp.Medium(0.1 * z))
        for z in range(1, MAX_BODIES + 2)
    ]
    assert f"at most {MAX_BODIES} bodies" in refusal(lambda: tp.Scene(LAMP, layers))
    grid = tp.Grid(box=tp.Box(size=(1e4, 1e4, 63)), absorption=np.linspace(1e-3, 1e-2, 63)[None, None])
    beam = tp.Source(tp.Point(position=(3, 2, 40)), tp.Beam((0, 0, -1), power=1.0))
    through = run(tp.Scene(beam, tp.Surface(grid.box, tp.Transparent(), inside=grid))).ledger["escaped"]
    assert through.value == pytest.approx(math.exp(-63 * 5.5e-3), rel=1e-9)


def test_glass_with_a_clock_needs_its_medium():
    """Two metres of index 1.5 on four of way: all that comes straight through arrives at 5 m / c."""
    assert "With a clock a `Dielectric` needs its medium" in SAID
    slab, glass = tp.Slab(center=(0, 0, -1), thickness=2.0), tp.Dielectric(1.5)
    flash = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), energy=1.0), pulse=tp.Instant(0.0))
    metre = 1 / 299792458.0  # [s]
    times = [0, 4.99 * metre, 5.01 * metre, 8 * metre]
    meter = tp.Detector(tp.Plane(center=(0, 0, -3)), "meter", times=times)

    def scene(inside):
        return tp.Scene(flash, tp.Surface(slab, glass, inside=inside), meter, duration=8 * metre)

    assert "name its medium, inside=Medium(index=1.5)" in refusal(lambda: scene(None))
    early, due, _ = run(scene(tp.Medium(index=1.5)), particles=3200)["meter"].energy_in.value
    assert early == 0 and due == pytest.approx(0.96**2, abs=0.02)


def test_a_point_may_lie_on_what_is_transparent():
    """exp(-k r) / (4 pi r^2) at the face of a ball of fog, exactly; on a black ball it is refused."""
    ball = tp.Sphere(radius=1.0)
    there = tp.PointDetector((0, 0, 1), "there")
    fog = tp.Surface(ball, tp.Transparent(), inside=tp.Medium(absorption=0.5))
    seen = run(tp.Scene(LAMP, fog, there))["there"].fluence_rate
    assert seen.value == pytest.approx(math.exp(-0.5) / (4 * math.pi), rel=1e-12)
    assert "position must not lie on" in refusal(lambda: tp.Scene(LAMP, tp.Surface(ball, tp.Black()), there))
    assert "On a Transparent surface it may lie" in " ".join(tp.PointDetector.__doc__.split())


def test_events_are_scatterings_too():
    slab = tp.Slab(center=(0, 0, -0.5), thickness=1.0)
    beam = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
    below = tp.Plane(center=(0, 0, -2))
    fog = tp.Surface(slab, tp.Transparent(), inside=tp.Medium(scattering=1.0, absorption=0.1))
    parts = {"straight": 0, "once": 1, "more": (2, math.inf)}
    meters = [tp.Detector(below, name, events=events) for name, events in parts.items()]
    result = run(tp.Scene(beam, fog, [*meters, tp.Detector(below, "all")]), particles=3200)
    fluxes = [result[name].flux_in.value for name in parts]
    assert fluxes[0] == pytest.approx(math.exp(-1.1), rel=0.1) and min(fluxes) > 0.05
    assert sum(fluxes) == pytest.approx(result["all"].flux_in.value, rel=1e-12)
    assert "scatterings" in refusal(lambda: tp.Detector(below, "m", events=-1))
    assert "scattered" in tp.Detector.__doc__
