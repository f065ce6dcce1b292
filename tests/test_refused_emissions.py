"""Speeds and emissions that cannot be are refused when made, with object, parameter and value named."""

import math

import pytest

from tests.refusals import DRIFTING, SIGNED, WARM, assert_refused
from transport.scene.emissions import Beam, Effusive, Gas, Isotropic, Lambertian
from transport.scene.speeds import InverseCDF, Maxwellian, SpeedTable

REFUSALS = {
    # emissions
    "no amount": (lambda: Lambertian(), ["Lambertian", "exactly one of radiance, exitance, power", "none"]),
    "two amounts": (
        lambda: Isotropic(power=1, intensity=2),
        ["Isotropic", "exactly one", "power=1, intensity=2"],
    ),
    "zero radiance": (lambda: Lambertian(radiance=0), ["Lambertian: radiance", "positive", "got 0"]),
    "power": (lambda: Beam((0, 0, 1), power=-5), ["Beam: power", "positive", "-5"]),
    "direction": (lambda: Beam((0, 0, 0), power=5), ["Beam: direction", "not all zero", "(0, 0, 0)"]),
    "speed": (lambda: Isotropic(power=1, speed=0), ["Isotropic: speed", "positive", "got 0"]),
    "density": (lambda: Gas(-1, 500), ["Gas: density", "positive", "-1"]),
    "gas speed": (lambda: Gas(1, math.inf), ["Gas: speed", "finite", "inf"]),
    "gas direction": (lambda: Gas(1, 1, direction=(0, 0)), ["Gas: direction", "(0, 0)"]),
    # emissions
    "gas without speed": (lambda: Gas(1e20), ["Gas: speed missing", "Gas(speed=...)"]),
    "effusive without speed": (lambda: Effusive(number=1), ["Effusive: speed missing"]),
    "gas of nothing": (lambda: Gas(speed=1), ["Gas", "exactly one of density, number", "none"]),
    "gas twice": (lambda: Gas(1, 500, number=2), ["Gas", "exactly one", "density=1, number=2"]),
    "effusive twice": (lambda: Effusive(1, 5, exitance=2), ["exactly one of density, exitance, number"]),
    "effusive at rest": (lambda: Effusive(1, 0), ["Effusive: speed", "positive", "got 0"]),
    "effusive backwards": (lambda: Effusive(1, SIGNED), ["Effusive: speed", "negative", "SpeedTable"]),
    "gas backwards": (lambda: Gas(1, SIGNED), ["Gas: speed", "negative", "direction=..."]),
    "gas of negative speed": (lambda: Gas(1, -5), ["Gas: speed", "zero or positive", "-5"]),
    "gas of text": (lambda: Gas(1, "fast"), ["Gas: speed", "'fast'"]),
    "drift along": (lambda: Gas(1, DRIFTING, direction=(0, 0, 1)), ["Gas: direction", "drift", "Maxwellian"]),
    "two masses": (lambda: Gas(1, WARM, mass=1), ["Gas: mass", "4.65e-26", "got 1", "leave it out"]),
    "mass": (lambda: Effusive(1, 5, mass=0), ["Effusive: mass", "positive", "got 0"]),
    "light of many speeds": (
        lambda: Lambertian(power=1, speed=WARM),
        ["Lambertian: speed", "Maxwellian", "Effusive"],
    ),
    "beam of many speeds": (
        lambda: Beam((0, 0, 1), power=1, speed=SIGNED),
        ["Beam: speed", "SpeedTable", "Gas"],
    ),
    "energy and power": (
        lambda: Lambertian(power=1, energy=2),
        ["Lambertian", "exactly one", "power=1, energy=2"],
    ),
    "energy": (lambda: Isotropic(energy=-1), ["Isotropic: energy", "positive", "-1"]),
    # speeds
    "maxwellian of nothing": (
        lambda: Maxwellian(),
        ["Maxwellian", "temperature and mass, or sigma", "neither"],
    ),
    "maxwellian without mass": (
        lambda: Maxwellian(temperature=300),
        ["Maxwellian: mass", "300.0", "write mass="],
    ),
    "maxwellian cold": (
        lambda: Maxwellian(temperature=0, mass=1),
        ["Maxwellian: temperature", "positive", "got 0"],
    ),
    "maxwellian mass": (lambda: Maxwellian(sigma=1, mass=-1), ["Maxwellian: mass", "-1"]),
    "maxwellian sigma": (lambda: Maxwellian(sigma=math.nan), ["Maxwellian: sigma", "nan"]),
    "maxwellian drift": (lambda: Maxwellian(sigma=1, drift=(1, 2)), ["Maxwellian: drift", "(1, 2)"]),
    "maxwellian twice": (
        lambda: Maxwellian(temperature=300, mass=1e-26, sigma=5),
        ["Maxwellian: sigma", "643.5", "got 5", "leave it out"],
    ),
    "maxwellian too fast": (lambda: Maxwellian(sigma=1e308), ["Maxwellian", "sigma=1e+308", "unit"]),
    "maxwellian by place": (lambda: Maxwellian(300), ["Maxwellian", "keywords only", "300"]),
    "rate of a drift": (lambda: WARM.one_way_flux(1e5), ["Maxwellian: drift", "30 sigma", "100000 m/s"]),
    "quantile of a drift": (lambda: WARM.normal_quantile(0.5, -1e5), ["30 sigma", "-100000 m/s"]),
    "table's speeds": (
        lambda: SpeedTable((0, 1, 1), (1, 1, 1)),
        ["SpeedTable: speeds", "increasing", "1.0 after 1.0"],
    ),
    "table's speed": (lambda: SpeedTable((1,), (1,)), ["SpeedTable: speeds", "two finite numbers", "(1,)"]),
    "table's density": (
        lambda: SpeedTable((0, 1), (1, -1)),
        ["SpeedTable: density", "zero or positive", "-1.0"],
    ),
    "table's zeros": (
        lambda: SpeedTable((0, 1), (0, 0)),
        ["SpeedTable: density", "not all zero", "(0.0, 0.0)"],
    ),
    "table's lengths": (
        lambda: SpeedTable((0, 1), (1, 2, 3)),
        ["SpeedTable: density", "as many", "2, got 3"],
    ),
    "table's infinity": (lambda: SpeedTable((0, math.inf), (1, 1)), ["SpeedTable: speeds", "inf"]),
    "table's range": (
        lambda: SpeedTable((-1e308, 1e308), (1, 1)),
        ["SpeedTable: speeds", "finite range", "1e+308"],
    ),
    "quantile no function": (lambda: InverseCDF(3), ["InverseCDF: quantile", "function", "got 3"]),
    "quantile of one u": (
        lambda: InverseCDF(math.sqrt),
        ["InverseCDF: quantile", "array", "TypeError", "NumPy"],
    ),
    "quantile with if": (
        lambda: InverseCDF(lambda u: 1 if u < 0.5 else 2),
        ["InverseCDF: quantile", "ValueError"],
    ),
    "quantile constant": (lambda: InverseCDF(lambda u: 3.0), ["InverseCDF: quantile", "shape ()", "NumPy"]),
    "quantile complex": (lambda: InverseCDF(lambda u: u + 1j), ["InverseCDF: quantile", "complex128"]),
    "quantile infinite": (
        lambda: InverseCDF(lambda u: 1 / u),
        ["InverseCDF: quantile", "inf at u = 0.0", "2**-54"],
    ),
    "quantile falls": (lambda: InverseCDF(lambda u: 1 - u), ["InverseCDF: quantile", "not fall", "u = "]),
    "quantile zero": (lambda: InverseCDF(lambda u: 0 * u), ["InverseCDF: quantile", "Gas(speed=0)"]),
}


@pytest.mark.parametrize(("make", "words"), REFUSALS.values(), ids=REFUSALS)
def test_a_wrong_emission_is_refused_with_object_parameter_value_and_cure(make, words):
    assert_refused(make, words)
