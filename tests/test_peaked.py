"""Sharply forward scattering before what looks by rays: wrong answers of tiny claimed error are flagged, right ones are not."""

import pytest

import transport as tp

LAMP = tp.Source(tp.Disk(radius=0.3, center=(0, 0, -1)), tp.Lambertian(power=1.0))
METER = tp.Detector(tp.Disk(center=(0, 0, 0.4), normal=(0, 0, -1), radius=1e-2), "eye")
POINT = tp.PointDetector((0, 0, 0.4), "eye")
SAID = "of the forward direction hardly sampled"
RIGHT = 0.1525  # W m^-2, g = 0.9999: by estimator="backward", 100 000 histories, ± 0.0021


def fog(g, look):
    medium = tp.Medium(scattering=1.0, absorption=1e-3, phase=tp.HenyeyGreenstein(g))
    return tp.Scene(LAMP, tp.Surface(tp.Box(size=2.5), tp.Transparent(), inside=medium), look)


@pytest.mark.parametrize("g", [0.999, 0.9999])
@pytest.mark.parametrize("look", [METER, POINT], ids=["small meter", "point"])
def test_light_that_has_not_come_is_told(look, g):
    estimator = "expected" if look is METER else None
    result = tp.simulate(fog(g, look), 20_000, seed=1, estimator=estimator)
    found = result["eye"].irradiance if look is METER else result["eye"].fluence_rate
    assert found.value < 0.4 * RIGHT and found.relative_error < 0.05  # four times too low, and sure of it
    assert any(SAID in finding.what for finding in found.findings if finding.severity == "doubtful")
    assert result.warnings and found.verdict == "doubtful"


@pytest.mark.parametrize("g", [-0.9, 0.0, 0.5, 0.9])
@pytest.mark.parametrize("look", [METER, POINT], ids=["small meter", "point"])
def test_it_is_silent_where_scattering_is_gentle(look, g):
    estimator = "expected" if look is METER else None
    for seed in range(5):
        result = tp.simulate(fog(g, look), 20_000, seed=seed, estimator=estimator)
        assert not any(SAID in warning for warning in result.warnings)


def test_it_is_silent_once_such_light_has_come():
    result = tp.simulate(fog(0.9999, METER), 500_000, seed=1, estimator="expected")
    flux = result["eye"].irradiance
    assert abs(flux.value - RIGHT) < 4 * flux.error
    assert not any(SAID in warning for warning in result.warnings)
