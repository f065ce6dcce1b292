"""The same scene in another unit of length and of power: what each parameter is multiplied by, and each quantity."""

from __future__ import annotations

import dataclasses

import numpy as np

from transport.scene.phase_functions import Phase
from transport.statistics.any_estimate import AnyEstimate

# Powers of the factors of length and of power.  Light keeps its speed, so that times go as lengths.
POWERS = {
    **dict.fromkeys(
        ("center", "position", "radius", "inner_radius", "top_radius", "width", "height"), (1, 0)
    ),
    **dict.fromkeys(("size", "thickness", "focal_length", "vertices", "sigma", "start", "end"), (1, 0)),
    **dict.fromkeys(("duration", "time", "stop"), (1, 0)),
    **dict.fromkeys(("absorption", "scattering"), (-1, 0)),
    **dict.fromkeys(("power", "intensity", "number"), (0, 1)),
    **dict.fromkeys(("radiance", "irradiance"), (-2, 1)),
    **dict.fromkeys(("emission", "density"), (-3, 1)),
    "exitance": (-2, 1),
    "energy": (1, 1),
    ("Effusive", "exitance"): (-3, 1),  # a number over area and time
    ("Maxwellian", "sigma"): (0, 0),  # a speed
    "look_at": (1, 0),
    **{("PhaseSpace", axis): (1, 0) for axis in "xyz"},
}
OF_SYMBOLS = {"m": 1, "s": 1}
WITHOUT_AMOUNT = ("counts", "mean_", "variance_", "temperature")  # what does not grow with what is emitted


def scaled(value: object, length: float, power: float) -> object:
    """A part of a scene, with all that has a unit multiplied."""
    if isinstance(value, tuple):
        return tuple(scaled(each, length, power) for each in value)
    if not dataclasses.is_dataclass(value) or (isinstance(value, Phase) and getattr(value, "is_phase", True)):
        return value
    given = {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.init}
    return dataclasses.replace(value, **scaled_parameters(type(value).__name__, given, length, power))


def scaled_parameters(kind: str, given: dict[str, object], length: float, power: float) -> dict[str, object]:
    """Parameters of an object of that kind by their names, with all that has a unit multiplied."""
    found = {}
    for name, value in given.items():
        powers = POWERS.get((kind, name)) or POWERS.get(name)
        if value is None or not powers or dataclasses.is_dataclass(value):
            found[name] = scaled(value, length, power)
        else:
            found[name] = _multiplied(value, length ** powers[0] * power ** powers[1])
    return found


def _multiplied(given: object, factor: float) -> object:
    if isinstance(given, tuple):
        return tuple(_multiplied(each, factor) for each in given)
    if isinstance(given, str):
        return given
    return np.multiply(given, factor) if isinstance(given, np.ndarray) else given * factor


def factor_of(name: str, quantity: AnyEstimate, length: float, power: float, is_light: bool) -> float:
    """By what a quantity of that name should have grown."""
    powers = dict(quantity.unit.powers)
    grows = sum(float(powers.get(symbol, 0)) * by for symbol, by in OF_SYMBOLS.items())
    of_energy = 1 if is_light else 0  # a power over a time; a mass and its speed keep their energy
    grows += float(powers.get("J", 0)) * of_energy + float(powers.get("Pa", 0)) * (of_energy - 3)
    return length**grows * (1.0 if name.startswith(WITHOUT_AMOUNT) else power)
