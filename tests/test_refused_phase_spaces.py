"""Phase spaces and snapshots that cannot be are refused when made, with object, parameter and value named."""

import math

import pytest

from tests.refusals import BALL, EDGES, LAMP, WALL, assert_refused, cloud, meter
from transport.scene.phase_space import PhaseSpace, Snapshot
from transport.scene.scene import Scene

REFUSALS = {
    # phase spaces and snapshots
    "phase space of nothing": (
        lambda: PhaseSpace(time=1),
        ["PhaseSpace 'phase_space': one or two of x, y, z, vx, vy, vz, speed, mu", "none", "x=edges"],
    ),
    "phase space of three": (
        lambda: PhaseSpace(x=EDGES, vx=EDGES, mu=4, time=1),
        ["PhaseSpace 'phase_space': one or two of", "got x, vx, mu", "per pair"],
    ),
    "phase space by place": (lambda: PhaseSpace(EDGES), ["PhaseSpace", "keywords only", "time=..."]),
    "phase space without time": (lambda: PhaseSpace(x=EDGES), ["PhaseSpace", "time missing"]),
    "x count": (lambda: cloud(x=8), ["PhaseSpace 'cloud': x", "edges", "got 8", "linspace"]),
    "x order": (lambda: cloud(x=(0, 2, 1)), ["PhaseSpace 'cloud': x", "increasing", "(0, 2, 1)"]),
    "x twice the same": (lambda: cloud(x=(0, 0)), ["PhaseSpace 'cloud': x", "increasing", "(0, 0)"]),
    "vx infinite": (lambda: cloud(vx=(-math.inf, 0)), ["PhaseSpace 'cloud': vx", "finite", "-inf"]),
    "speed below 0": (lambda: cloud(speed=(-1, 1)), ["PhaseSpace 'cloud': speed", "0 or above", "(-1, 1)"]),
    "cosine beyond 1": (lambda: cloud(mu=(0, 1.1)), ["PhaseSpace 'cloud': mu", "[-1.0, 1.0]", "1.1"]),
    "cosines none": (lambda: cloud(mu=0), ["PhaseSpace 'cloud': mu", "got 0"]),
    "bins in phase space": (
        lambda: cloud(x=range(10_001), vx=range(10_001)),
        ["PhaseSpace 'cloud': x x vx", "10000000", "got 100000000"],
    ),
    "time before 0": (lambda: PhaseSpace(x=EDGES, time=-1), ["PhaseSpace", "time", "0 or later", "got -1"]),
    "time nan": (lambda: PhaseSpace(x=EDGES, time=math.nan), ["PhaseSpace", "time", "nan"]),
    "time text": (lambda: PhaseSpace(x=EDGES, time="1"), ["PhaseSpace", "time", "'1'"]),
    "times none": (lambda: PhaseSpace(x=EDGES, time=()), ["PhaseSpace", "time", "got ()"]),
    "times falling": (lambda: PhaseSpace(x=EDGES, time=(1, 1)), ["PhaseSpace", "increasing", "(1, 1)"]),
    "within": (lambda: cloud(x=EDGES, within=BALL), ["PhaseSpace 'cloud': within", "Box", "Sphere("]),
    "moments of phase space": (lambda: cloud(x=EDGES, moments=1), ["PhaseSpace 'cloud': moments", "got 1"]),
    "nameless phase space": (lambda: PhaseSpace(x=EDGES, time=1, name=None), ["PhaseSpace", "name", "None"]),
    "name with a dot of a snapshot": (lambda: Snapshot(1, name="a.b"), ["Snapshot 'a.b'", "'a_b'"]),
    "snapshot of a series": (
        lambda: Snapshot((1, 2)),
        ["Snapshot 'snapshot': time", "(1, 2)", "one Snapshot per time"],
    ),
    "snapshot before 0": (lambda: Snapshot(-1), ["Snapshot 'snapshot': time", "got -1"]),
    "snapshot without an end": (lambda: Snapshot(math.inf), ["Snapshot 'snapshot': time", "inf"]),
    "snapshot of none": (lambda: Snapshot(1, particles=0), ["Snapshot 'snapshot': particles", "got 0"]),
    "snapshot of half": (lambda: Snapshot(1, particles=0.5), ["particles", "whole", "got 0.5"]),
    "snapshot of too many": (lambda: Snapshot(1, particles=10**9), ["particles", "10000000", "1000000000"]),
    "look without a clock": (
        lambda: Scene(LAMP, detectors=Snapshot(1)),
        ["Snapshot 'snapshot': time needs a clock", "got 1.0", "Scene(..., duration=...)"],
    ),
    "look after the end": (
        lambda: Scene(LAMP, detectors=cloud(x=EDGES, time=(1, 3)), duration=2),
        ["PhaseSpace 'cloud': time", "duration of 2.0 s", "got 3.0", "earlier time"],
    ),
    "looks' names": (
        lambda: Scene(LAMP, (), [Snapshot(1), Snapshot(2)], duration=2),
        ["Scene: name", "unique", "2 Snapshots 'snapshot'", "name="],
    ),
    "names of unlike looks": (
        lambda: Scene(LAMP, (), [meter(), Snapshot(1, name="lid")], duration=2),
        ["Scene: name", "unique", "1 Detector and 1 Snapshot 'lid'"],
    ),
    "look named as a surface": (
        lambda: Scene(LAMP, WALL, Snapshot(1, name="floor"), duration=2),
        ["Snapshot 'floor': name", "surface", "rename"],
    ),
}


@pytest.mark.parametrize(("make", "words"), REFUSALS.values(), ids=REFUSALS)
def test_a_wrong_phase_space_is_refused_with_object_parameter_value_and_cure(make, words):
    assert_refused(make, words)
