"""Lengths, powers and speeds at the ends of what floating-point numbers hold: right, or refused with the reason."""

import numpy as np
import pytest

import transport as tp
from tests.agreement import assert_agrees


def disks(length=1.0, radiance=1.0):
    meter = tp.Disk(center=(0, 0, 2 * length), normal=(0, 0, -1), radius=0.5 * length)
    lamp = tp.Source(tp.Disk(radius=length), tp.Lambertian(radiance=radiance), aim=meter)
    return tp.Scene(sources=[lamp], detectors=[tp.Detector(meter, name="meter")])


@pytest.mark.parametrize("length", [1e-120, 1e-12, 1e12, 1e120])
def test_irradiance_does_not_know_the_unit_of_length(length):
    one, other = (
        tp.simulate(disks(x), particles=10_000, seed=1)["meter"].irradiance.value for x in (1.0, length)
    )
    np.testing.assert_allclose(one, other, rtol=1e-12)


@pytest.mark.parametrize("power", [1e-290, 1e290])
def test_irradiance_scales_with_power(power):
    one, other = (
        tp.simulate(disks(1.0, x), particles=10_000, seed=1)["meter"].irradiance.value for x in (1.0, power)
    )
    np.testing.assert_allclose(one, other / power, rtol=1e-12)


def test_what_leaves_the_range_is_refused():
    with pytest.raises(tp.SceneError, match="size must be between"):
        tp.simulate(disks(1e145), particles=10)
    far = tp.Disk(center=(0, 0, 1.0), normal=(0, 0, -1), radius=1e-130)
    lamp = tp.Source(tp.Disk(radius=0.1), tp.Lambertian(radiance=1.0), aim=far)
    with pytest.raises(tp.SceneError, match="aim must subtend more than"):
        tp.simulate(tp.Scene(sources=[lamp]), particles=10)
    strong = tp.Source(tp.Point(), tp.Isotropic(power=1.5e308))
    with pytest.raises(tp.SceneError, match="power of all sources together"):
        tp.simulate(tp.Scene(sources=[strong, strong]), particles=10)
    with pytest.raises(tp.SceneError, match="power of all sources together"):
        tp.simulate(disks(1.0, 5e-324), particles=10)
    fast = tp.Source(tp.Point(), tp.Isotropic(power=1.0, speed=1e300))
    with pytest.raises(tp.SceneError, match="speed must cross"):
        tp.simulate(tp.Scene(sources=[fast], duration=1e100), particles=10)


def test_an_aim_whose_weights_have_a_heavy_tail_is_warned_of():
    """A kilometre of ceiling over a millimetre: the births that matter are never drawn, and the error looks small."""
    meter = tp.Disk(center=(0, 0, -0.01), normal=(0, 0, 1), radius=1e-3)
    ceiling = tp.Rectangle(normal=(0, 0, -1), width=1000.0, height=1000.0)
    lamp = tp.Source(ceiling, tp.Lambertian(radiance=1.0), aim=meter)
    result = tp.simulate(
        tp.Scene(sources=[lamp], detectors=[tp.Detector(meter, name="meter")]), particles=50_000
    )
    assert any("doubtful" in warning for warning in result.warnings)
    assert not tp.simulate(disks(), particles=50_000).warnings


@pytest.mark.parametrize("height", [0.5, 0.5 - 1e-15, 0.5 + 1e-15, 0.2])
def test_a_box_aimed_at_from_the_plane_of_its_face(height):
    """Directions within the face's plane are of measure zero: drawn, but never counted."""
    box = tp.Box(size=1.0)
    point = tp.Point(position=(2, 0, height))
    runs = [
        tp.simulate(
            tp.Scene(
                sources=[tp.Source(point, tp.Isotropic(power=1.0), aim=aim)],
                detectors=[tp.Detector(box, name="box")],
            ),
            particles=n,
            seed=1,
        )["box"].flux_in
        for aim, n in ((box, 200_000), (None, 2_000_000))
    ]
    assert abs(runs[0].value - runs[1].value) < 4.5 * np.hypot(runs[0].error, runs[1].error)


@pytest.mark.parametrize(
    "bins", [{"mu": (0, 0.25, 0.5, 1)}, {"theta": 4}, {"mu": 4}, {"mu": (-1, -0.3, 0.2, 1), "frame": "world"}]
)
@pytest.mark.parametrize("phi", [(0, 1), (1, 2, 4), 3])
def test_radiance_in_a_furnace_is_the_same_in_any_bins(bins, phi):
    """Partial edges on both axes of direction: what is outside of one must not come back by the other."""
    wall = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="inside")
    meter = tp.Detector(
        tp.Disk(radius=0.5, normal=(1, 0, 2)), name="meter", directions=tp.Directions(phi=phi, **bins)
    )
    radiance = tp.simulate(tp.Scene(sources=[wall], detectors=[meter]), particles=400_000, seed=1)[
        "meter"
    ].radiance
    for value in radiance.value.flat:
        assert np.isnan(value) or value > 0
    seen = np.isfinite(radiance.error) & (radiance.value > 0)
    assert (np.abs(radiance.value[seen] - 1) < 5 * radiance.error[seen]).all()


@pytest.mark.parametrize("frame", ["local", "world"])
def test_a_sector_across_azimuth_zero_is_its_two_halves(frame):
    """The same crossings, whether the sector is cut at 0 or begins below it."""
    wall = tp.Source(tp.Sphere(radius=2.0), tp.Lambertian(radiance=1.0), side="inside")
    disk = tp.Disk(radius=0.5, normal=(1, 0, 2))
    edges = {"whole": (-0.7, 0.5), "below": (2 * np.pi - 0.7, 2 * np.pi), "above": (0, 0.5)}
    detectors = [
        tp.Detector(disk, name=n, directions=tp.Directions(phi=e, frame=frame)) for n, e in edges.items()
    ]
    result = tp.simulate(tp.Scene(sources=[wall], detectors=detectors), particles=100_000, seed=1)
    counts = {name: result[name].counts.value.sum() for name in edges}
    assert counts["whole"] == counts["below"] + counts["above"] > 100


def test_a_source_meters_its_whole_power_wherever_the_origin_lies():
    """A source of a picometre beside smaller shapes a metre away: nothing is lost at its rim by rounding."""
    disk = tp.Disk(radius=1e-12, center=(0.3, 0.2, 0.1))
    crumb = tp.Detector(tp.Disk(radius=1e-13, center=(-1, 0, 0)), name="crumb")
    source = tp.Source(disk, tp.Lambertian(power=1.0))
    result = tp.simulate(
        tp.Scene(sources=[source], detectors=[tp.Detector(disk, name="own"), crumb]), particles=1_000_000
    )
    np.testing.assert_allclose(result["own"].flux_out.value, 1.0, rtol=1e-14)


def test_fluence_of_a_steady_grazing_beam_is_not_rounded_away():
    """Every crossing has the same cosine and a weight far below the largest: rounding must not lean one way."""
    tilt = np.radians(89.9)
    meter = tp.Disk(center=(0, 0, 1), normal=(np.sin(tilt), 0, np.cos(tilt)), radius=1e-9)
    lamp = tp.Source(
        tp.Disk(radius=1e-9, normal=(np.sin(tilt), 0, np.cos(tilt))), tp.Lambertian(radiance=1.0), aim=meter
    )
    reading = tp.simulate(
        tp.Scene(sources=[lamp], detectors=[tp.Detector(meter, name="m")]), particles=100_000
    )["m"]
    assert_agrees(reading.fluence_rate, reading.exitance.value / np.cos(tilt), 1e-5)
