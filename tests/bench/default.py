"""What a run in a second comes to by default, beside counting what arrives: an LED over a desk, in a room.

    python -m tests.bench.default [--seconds 1] [--repeats 5]

Medians of the relative error, of the seconds that the call took in all (pilots too), and the ways that the pilots chose.
"""

import time
from collections import Counter
from statistics import median

import typer

import transport as tp

ROOM, TOP = (5.0, 4.0, 2.7), 0.75  # m; the height of the desk


def led_over_a_desk() -> tp.Scene:
    """A diode of 5 mm, 0.6 m over a desk, and a sensor of 1 cm on the desk, beside the axis."""
    diode = tp.Disk(center=(0, 0, TOP + 0.6), normal=(0, 0, -1), radius=2.5e-3)
    sensor = tp.Disk(center=(0.2, 0.1, TOP), radius=5e-3)
    return tp.Scene(
        sources=tp.Source(diode, tp.Lambertian(power=1.0)),
        surfaces=[
            tp.Surface(tp.Box(center=(0, 0, ROOM[2] / 2), size=ROOM), tp.Diffuse(0.6), "walls"),
            tp.Surface(tp.Rectangle(center=(0, 0, TOP), width=1.6, height=0.8), tp.Diffuse(0.4), "desk"),
        ],
        detectors=tp.Detector(sensor, "sensor"),
    )


def main(seconds: float = 1.0, repeats: int = 5) -> None:
    """Print a row of runs that count what arrives, and one of default runs."""
    scene, limits = led_over_a_desk(), {"seconds": seconds, "progress": False}
    for how in ({"estimator": "analog"}, {}):
        tp.simulate(scene, **limits, **how)  # compiles
        errors, took, ways = [], [], Counter()
        for seed in range(repeats):
            begun = time.perf_counter()
            result = tp.simulate(scene, **limits, **how, seed=seed)
            took.append(time.perf_counter() - begun)
            errors.append(result["sensor"].irradiance.relative_error)
            ways[result.plan.method.title] += 1
        told = ", ".join(f"{way} {count}" for way, count in ways.items())
        print(
            f"{how.get('estimator', 'default'):8} relative error {100 * median(errors):.2g} %, {median(took):.2f} s: {told}"
        )


if __name__ == "__main__":
    typer.run(main)
