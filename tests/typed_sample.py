"""What users write, as tests/test_types.py shows it to a type checker: objects of every kind, a run, its readings.

The objects are made as well; the functions are never called.
"""

from pathlib import Path

import numpy as np

import transport as tp

# Shapes: tuples, lists and arrays are vectors.
up = np.array([0.0, 0.0, 1.0])
shapes = [
    tp.Rectangle(width=2, height=1, normal=up, hole=tp.Disk(radius=0.1)),
    tp.Disk(center=[0, 0, 1], normal=(0, 0, -1), radius=0.5, inner_radius=np.sqrt(0.01)),
    tp.Triangle(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)]),
    tp.Sphere(radius=1.0, axis=up, mu_min=0.5),
    tp.Box(size=2.0),
    tp.Box(size=(1, 2, 3)),
    tp.Cylinder(radius=1, height=2),
    tp.Cone(radius=1, top_radius=0.5, height=2),
    tp.Paraboloid(focal_length=1, radius=1),
    tp.Slab(thickness=1 * tp.mm),
    tp.Plane(),
    tp.Mesh(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces=np.array([[0, 1, 2]])),
    tp.Mesh.sphere(center=up, radius=1).moved([0, 0, 1]).scaled(tp.mm),
]
corner: float = shapes[0].bounds[0][0] + tp.Box(size=1).size[2]

# Materials and media.
paint = tp.Mixture({tp.Mirror(0.5): 0.3, tp.Diffuse(0.8, transmission=0.1): 0.7})
sided = tp.TwoSided(front=tp.Glossy(0.3), back=tp.Black())
fog = tp.Medium(absorption=0.1, scattering=0.9, phase=tp.HenyeyGreenstein(0.75))
mie = tp.Tabulated(mu=np.linspace(-1, 1, 5), density=[1, 1, 2, 4, 8])
mixed = tp.Medium(0.0, 1.0, phase=tp.Mixture({mie: 0.5, tp.Rayleigh(): 0.5}))
voxels = tp.Grid(box=tp.Box(size=1), absorption=np.eye(2)[:, :, None], scattering=0.5, phase=tp.Isotropic())
surfaces = [
    tp.Surface(tp.Sphere(radius=0.1, center=up), tp.Dielectric(1.5), "ball", inside=tp.Medium(index=1.5)),
    tp.Surface(voxels.box, tp.Transparent(), "cloud", inside=voxels, outside=tp.Vacuum()),
    *(tp.Surface(face, paint, f"wall {name}") for name, face in tp.Box(size=6).faces().items()),
]

# Sources, and detectors of several kinds in one list.
meter = tp.Disk(center=(0, 0, 2), normal=(0, 0, -1), radius=0.1)
lamp = tp.Source(tp.Disk(center=-2 * up, radius=0.5), tp.Lambertian(power=0.1), aim=meter, side="front")
rays = tp.Source(tp.Point(position=[0, 0, 1]), tp.Beam(up, energy=1.0), pulse=tp.GaussianPulse(9, 1))
gas = tp.Source(tp.Cloud(sigma=(1.0, 0, 0)), tp.Gas(number=1e6, speed=tp.Maxwellian(sigma=1, drift=up)))
table = tp.Effusive(density=1e20, speed=tp.SpeedTable(np.arange(3), [0, 1, 0]))
fast = tp.Effusive(density=1e20, speed=tp.InverseCDF(lambda u: 100.0 + u))
sphere = tp.Directions.sphere(mu=8, phi=16)
steady = [
    tp.Detector(meter, name="meter", directions=tp.Directions(mu=np.linspace(0, 1, 5)), via="cloud"),
    tp.Detector("ball", "patch", positions=tp.Positions(u=[0.5, 1.0], v=4), events=(1, 3), via=["cloud"]),
    tp.VolumeDetector("cloud", name="inside", cells=(2, 2, 1), directions=sphere),
    tp.Camera(name="view", position=(0, -2, 1), look_at=np.zeros(3), pixels=(64, 48)),
    tp.EnvironmentMap(name="map", position=2 * up, theta=16),
    tp.PointDetector((0, 0, 3), "point"),
]
timed = [
    tp.Detector(meter, "spot", directions=tp.Directions.cone(-up, 5 * tp.deg), times=4, speeds=(1, 2)),
    tp.PhaseSpace(x=np.linspace(-1, 1, 9), vx=(0, 1, 2), time=[0, 0.1], moments=True),
    tp.Snapshot(0.1, particles=1000),
]
room = tp.Scene([lamp], surfaces, steady[:-1])
foggy = tp.Scene(sources=(source for source in room.sources), surfaces=surfaces[-1], medium=fog)
clocked = tp.Scene(gas, detectors=timed, duration=0.4)
again = tp.Scene.from_json(room.to_json())


def run() -> tp.Result:
    split = tp.Tracking(splitting=tp.Splitting(start=up, end=[0, 0, -1], gain=1e3))
    result = tp.simulate(room, error={"meter.irradiance": 1e-3}, seconds=60, estimator="auto", tracking=split)
    more = tp.simulate(room, particles=10**6, resume="run.nc", checkpoint=Path("run.nc"), part=(1, 2))
    result = tp.merge(result, more, tp.load("run.nc"))
    result.save("whole.nc")
    print(result.report(), result.warnings, result.particles, result.cost.seconds, result.scene.duration)
    return result


def read(result: tp.Result) -> None:
    """Whether a quantity is one estimate or an array of them depends on the bins."""
    reading = result["meter"]
    irradiance: tp.Estimate = reading.irradiance
    radiance: tp.EstimateArray = reading.radiance
    value: float = reading.irradiance.value
    error: float = reading.radiance[-1].error
    relative: float = irradiance.relative_error + radiance[0].relative_error
    low, high = irradiance.interval(0.99)
    print(low < 18.4 < high, abs(irradiance.z(18.4)) < 3, value > 0, relative + error)
    share: tp.Estimate = reading.flux_in / result.ledger["emitted"]
    lost = result.ledger["emitted"] - result.ledger["absorbed"] - result.ledger.absorbed_by["ball"]
    scaled: tp.EstimateArray = 2 * radiance / irradiance - 1.0 / (irradiance / radiance)
    widths = np.diff(radiance.coords["mu"])
    power: tp.Estimate = (radiance * widths).sum("mu")
    weighted: tp.EstimateArray = widths * radiance
    print(scaled.dims, weighted.shape, power.z(1.0), lost.value, lost.unit, share.relative_error)
    print(f"{reading.flux_in:.3f} {reading.exitance} {float(irradiance)}", *reading.radiance[1:3])
    for each in radiance:
        print(each.value, each.reason)
    mean: float = radiance.to_xarray()["value"].mean().item()
    peak: float = np.max(radiance.value[radiance.value > radiance.error])
    print(mean, peak, np.asarray(radiance).shape)


def read_others(result: tp.Result) -> None:
    print(result["view"].image() + result["view"].errors(), result["inside"].volumes.sum())
    print(result["inside"].absorbed_power.sum() / result.ledger["emitted"])
    print([temperature.value for temperature in result["phase_space"].temperature[1]])
    print(result["snapshot"].positions[:, 0] * result["snapshot"].weights)
    print({name: part.radiance for name, part in result["view"].by_source.items()})
    print(tp.tracks(room, particles=100).ends(10.0), tp.cost_of_accuracy(room, "meter.flux_in").cheapest)
    best: int = tp.bins_against_noise(result["meter"].radiance, "mu").best()
    factor = tp.view_factor(tp.Disk(radius=1), tp.Sphere(center=(0, 0, 3), radius=1), blockers=shapes[:1])
    angle: tp.Estimate = tp.solid_angle(tp.Box(size=1), (0, 0, 3)) + tp.solid_angle(tp.Box(size=1), 2 * up)
    print(best, factor.value, angle.value)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    rows = {name: result[name].flux_in for name in ("meter", "patch")}
    rows["lost"] = result.ledger["lost"]
    return rows
