"""Validation of input: objects check their fields when made and raise SceneError.

A user object is a frozen, hashable dataclass made by `scene_object`. Its `__post_init__` calls the `coerce_*`
functions below: each reads fields, raises SceneError for invalid values and stores the others in plain form
(floats and tuples of floats), so that lists, NumPy arrays and integers make equal objects.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
import inspect
import math
import reprlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import InitVar
from numbers import Integral, Real
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar, cast, dataclass_transform

import numpy as np
from numpy.typing import ArrayLike

from transport.vectors import Vector, unit_vector

_SYNONYMS: dict[str, tuple[str, ...]] = {  # names of other programs and books, by the names here
    "absorption": ("mu_a", "mua", "sigma_a", "absorption_coefficient", "kappa"),
    "scattering": ("mu_s", "mus", "sigma_s", "scattering_coefficient"),
    "phase": ("g", "anisotropy", "phase_function"),
    "index": ("n", "ior", "refractive_index", "eta"),
    "index_inside": ("n", "ior", "int_ior", "refractive_index", "index", "eta"),
    "index_outside": ("ext_ior",),
    "albedo": ("reflectance", "reflectivity", "rho", "color", "colour"),
    "reflectance": ("albedo", "reflectivity", "rho"),
    "roughness": ("alpha",),
    "position": ("center", "origin", "location"),
    "center": ("position", "origin", "centre", "location"),
    "radius": ("diameter", "r"),
    "normal": ("direction", "facing"),
    "power": ("flux", "watts"),
    "pixels": ("resolution", "film_size"),
    "field_of_view": ("fov",),
    "particles": ("spp", "samples", "photons", "n_photons", "histories", "nps", "n_particles", "rays"),
    "error": ("relative_error", "rtol", "tolerance", "err", "stderr", "std", "sigma", "sd", "sem"),
    "value": ("val", "nominal_value"),
    "unit": ("units",),
    "seconds": ("time", "timeout"),
    "threads": ("workers", "n_jobs", "processes"),
    "exitance": ("radiosity", "radiant_exitance", "emittance", "emissive_power"),
    "irradiance": ("illuminance", "incident_flux", "flux_density"),
    "radiance": ("luminance", "brightness", "specific_intensity"),
    "fluence": ("exposure", "radiant_exposure", "dose"),
    "fluence_rate": ("exposure", "scalar_flux", "actinic_flux", "fluence", "dose"),
    "flux_in": ("power", "luminous_flux", "current", "power_in"),
    "ThinLens": ("Lens",),
    "Box": ("Cube", "Cuboid"),
    "Sphere": ("Ball",),
    "Rectangle": ("Square", "Quad", "Patch"),
    "Disk": ("Circle", "Disc"),
    "Diffuse": ("Lambert", "Matte"),
    "Dielectric": ("Glass",),
    "Conductor": ("Metal",),
    "Glossy": ("Rough", "Microfacet", "GGX"),
    "Detector": ("Sensor", "Tally", "Meter", "Receiver"),
    "Source": ("Light", "Lamp", "Emitter"),
    "Point": ("PointLight", "PointSource"),
    "Beam": ("Sun", "Collimated", "Laser", "DirectionalLight"),
    "Surface": ("Object", "Wall"),
    "simulate": ("run", "render", "trace"),
    "km": ("kilometer", "kilometre", "kilometers", "kilometres"),
    "cm": ("centimeter", "centimetre", "centimeters", "centimetres", "inch", "inches"),
    "mm": ("millimeter", "millimetre", "millimeters", "millimetres"),
    "um": ("micrometer", "micrometre", "micrometers", "micrometres", "micron", "microns"),
    "nm": ("nanometer", "nanometre", "nanometers", "nanometres", "angstrom"),
    "us": ("microsecond", "microseconds"),
    "ns": ("nanosecond", "nanoseconds", "ps", "picosecond", "picoseconds"),
    "deg": ("degree", "degrees"),
    "arcmin": ("arcminute", "arcminutes"),
    "arcsec": ("arcsecond", "arcseconds"),
    "mrad": ("milliradian", "milliradians"),
    "au": ("AU", "astronomical_unit"),
}
_SI_UNITS = {
    "m",
    "meter",
    "metre",
    "s",
    "second",
    "W",
    "watt",
    "J",
    "joule",
    "rad",
    "radian",
    "sr",
    "kg",
    "K",
}
_REMARKS = {
    "diameter": " (half of it)",
    "g": " (phase=tp.HenyeyGreenstein(g))",
    "anisotropy": " (phase=tp.HenyeyGreenstein(g))",
    "inch": " (2.54 of it)",
    "inches": " (2.54 of it)",
    "angstrom": " (a tenth of it)",
    "ps": " (a thousandth of it)",
    "picosecond": " (a thousandth of it)",
    "picoseconds": " (a thousandth of it)",
}
MANY_NAMES = 16  # that a message does not list

SIMULATE_PARAMETERS = {  # parameters of `simulate`, not of Scene
    "particles", "error", "seconds", "seed", "batches", "threads", "estimator", "sampling", "tracking",
    "progress", "cluster", "resume", "checkpoint", "every", "part", "guide",
}  # fmt: skip

MASKED_VALUES_HINT = "write .filled(0), or another number"  # hint for masked values

_short = reprlib.Repr()
_short.maxstring = _short.maxother = 80
_short.maxlevel = 3


class SceneError(ValueError):
    """Error raised for invalid input; the message names object, parameter, value and cure.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Disk(radius=-1)
    Traceback (most recent call last):
        ...
    transport.validation.SceneError: Disk: radius must be positive and finite, got -1
    """


SCENE_OBJECTS: dict[str, type] = {}  # the package's own scene objects by name; what files can hold


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field,))
def scene_object(cls: type | None = None, *, kw_only: bool = False) -> Any:
    """Make a frozen dataclass that raises SceneError for invalid, missing and unknown parameters."""
    if cls is None:
        return functools.partial(scene_object, kw_only=kw_only)
    made = dataclasses.dataclass(frozen=True, kw_only=kw_only)(cls)
    init, fields = made.__init__, parameters_of(made)

    @functools.wraps(init)
    def checked_init(self, *values, **named):
        _check_parameters(made, fields, values, named)
        init(self, *values, **named)

    made.__init__ = checked_init
    if made.__module__.startswith("transport."):
        SCENE_OBJECTS[made.__name__] = made
    return made


def parameters_of(cls: type) -> list[dataclasses.Field]:
    """Return the parameters of a dataclass, including those that are no fields (InitVar)."""
    _, *names = inspect.signature(cls.__init__).parameters
    return [cls.__dataclass_fields__[name] for name in names]


def _check_parameters(cls: type, fields: list[dataclasses.Field], values: tuple, named: dict) -> None:
    title, names = _object_title(cls, named.get("name")), [field.name for field in fields]
    call = getattr(cls, "written", cls.__name__)
    # Check the names of keyword arguments.
    for name, value in named.items():
        if name not in names:
            is_for_run = name in SIMULATE_PARAMETERS and cls.__name__ == "Scene"
            cure = f"write simulate(scene, {name}=...)" if is_for_run else name_hint(name, names)
            raise SceneError(f"{title}: unknown parameter {name}={short_repr(value)}; {cure}")
    # Check the number of positional arguments.
    by_place = [field.name for field in fields if not field.kw_only]
    if len(values) > len(by_place):
        got = short_repr(values[len(by_place)])
        if len(by_place) == len(names):
            cure = ", ".join(f"{name}=..." for name in names)
            raise SceneError(
                f"{title} takes no more than {len(names)} parameters, got {got}; write {call}({cure})"
            )
        limit = f"only {' and '.join(by_place)} without a keyword" if by_place else "keywords only"
        keywords = [name for name in names if name not in by_place]
        required = [f.name for f in fields if f.name in keywords and _is_required(f)]
        cure = f"write {call}({', '.join(f'{name}=...' for name in required or keywords[:1])})"
        raise SceneError(f"{title} takes {limit}: {cure}, got {got} (keywords: {', '.join(keywords)})")
    # Check for parameters given twice, and for missing ones.
    for name in by_place[: len(values)]:
        if name in named:
            raise SceneError(
                f"{title}: {name} is given twice, by position and as {short_repr(named[name])}; drop one"
            )
    given = {*by_place[: len(values)], *named}
    missing = [f.name for f in fields if f.name not in given and _is_required(f)]
    if missing:
        cure = ", ".join(f"{name}=..." for name in missing)
        raise SceneError(f"{title}: {' and '.join(missing)} missing; write {call}({cure})")


def _is_required(field: dataclasses.Field) -> bool:
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def _object_title(cls: type, name: object) -> str:
    return f"{cls.__name__} {name!r}" if isinstance(name, str) and name else cls.__name__


def refuse(subject: object, problem: str) -> NoReturn:
    """Raise the SceneError "Detector 'lid': problem"."""
    raise SceneError(f"{_object_title(type(subject), getattr(subject, 'name', None))}: {problem}")


def short_repr(value: object) -> str:
    """Return a short text of a value for a message: NumPy numbers as plain ones, long ones cut."""
    if is_masked(value):
        return f"{_short.repr(value.tolist())} with masked values ({MASKED_VALUES_HINT})"
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    return _short.repr(value)


def degrees_hint(angle: float | None) -> str:
    """Return a hint, as the end of a message, if an angle [rad] is probably in degrees; else ""."""
    return (
        f"; angles are in radians: write {angle:g} * tp.deg" if angle is not None and 1 < angle <= 360 else ""
    )


def is_masked(value: object) -> bool:
    """Return whether an array has masked values, as from files with gaps; these are no numbers."""
    return isinstance(value, np.ma.MaskedArray) and bool(np.ma.getmaskarray(value).any())


def join_names(names: list[str], most: int = 6) -> str:
    """Return names as "a, b and c"; beyond `most` names, the number of the rest."""
    if len(names) > most:
        names = [*names[:most], f"{len(names) - most} more"]
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


EXTRAS = {  # optional packages: the extra that installs each
    "matplotlib": "plot",
    "pyvista": "viz",
    "vtkmodules": "viz",
    "xarray": "files",
    "pandas": "files",
    "h5netcdf": "files",
    "distributed": "cluster",
    "sphinx": "docs",
}


def pip_install(extra: str) -> str:
    """Return the command that installs an extra; it runs in the clone, as the package is in no index."""
    return f"pip install '.[{extra}]' in the clone"


def missing_package(error: ImportError) -> str | None:
    """Return which optional package is not installed, and the cure; None for any other import."""
    package = (error.name or "").partition(".")[0]
    return f"{package} is not installed; {pip_install(EXTRAS[package])}" if package in EXTRAS else None


@contextmanager
def optional_packages(subject: str) -> Iterator[None]:
    """Raise SceneError, with the command that installs it, where an optional package is missing."""
    try:
        yield
    except ImportError as error:
        if (lack := missing_package(error)) is None:
            raise
        raise SceneError(f"{subject}: {lack}") from None


def name_hint(word: object, names: Iterable[str]) -> str:
    """Return a hint for an unknown name: a synonym, the closest valid one, or the names if they are few."""
    names, word = list(names), str(word)
    meant = next((here for here, others in _SYNONYMS.items() if here in names and word in others), None)
    if meant is not None:
        return f"did you mean {meant!r}{_REMARKS.get(word, '')}?"
    if "speed_of_light" in names and {word, word.removesuffix("s")} & _SI_UNITS:
        return "numbers are in SI units: leave this factor out"
    lower = {name.lower(): name for name in names}
    for near in difflib.get_close_matches(word.lower(), lower, n=3, cutoff=0.6):
        is_alike = difflib.SequenceMatcher(None, word.lower(), near).ratio() >= 0.75
        if is_alike or (near[:1] == word[:1].lower() and min(len(near), len(word)) > 2):
            return f"did you mean {lower[near]!r}?"
    if len(names) > MANY_NAMES:
        return f"there are {len(names)} names, such as {', '.join(map(repr, names[:3]))}"
    return f"choose from {', '.join(map(repr, names))}" if names else "there is nothing to choose from"


class NamedEntries(dict[str, Any]):
    """A dict by name that raises SceneError, with the closest name, for an unknown one."""

    def __init__(self, problem: str, entries: Mapping[str, Any] = MappingProxyType({})) -> None:
        super().__init__(entries)
        self.problem = problem

    def __missing__(self, name: object) -> NoReturn:
        raise SceneError(f"{self.problem} {name!r}; {name_hint(name, self)}")

    def __reduce__(self) -> tuple[type, tuple[str, dict[str, Any]]]:
        return type(self), (self.problem, dict(self))


F = TypeVar("F", bound=Callable[..., Any])


def checked_keywords(function: F) -> F:
    """Make a function raise SceneError, with a suggestion, for a keyword that it does not know."""
    parameters = inspect.signature(function).parameters.values()
    names = [each.name for each in parameters if each.kind is not each.VAR_POSITIONAL]

    @functools.wraps(function)
    def checked(*values: object, **named: object) -> object:
        for name, value in named.items():
            if name not in names:
                hint = name_hint(name, names) if names else "it takes no keywords"
                raise SceneError(f"{function.__name__}: unknown parameter {name}={short_repr(value)}; {hint}")
        return function(*values, **named)

    return cast(F, checked)


def set_fields(subject: object, **values: object) -> None:
    """Set fields of a frozen object while it is made."""
    for name, value in values.items():
        object.__setattr__(subject, name, value)


def as_float(value: object) -> float | None:
    """Return a real number as a float (infinity on overflow); None for bool, text, complex and others."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Real):
        return None
    try:
        return float(value) + 0.0  # -0.0 becomes 0.0
    except OverflowError:
        return math.inf


def is_whole_number(value: object) -> bool:
    """Return whether a value is an integer (bool excluded)."""
    return isinstance(value, Integral) and not isinstance(value, (bool, np.bool_))


def as_floats(value: object) -> tuple[float, ...] | None:
    """Return a sequence of finite real numbers as a tuple of floats; None for anything else."""
    if isinstance(value, (str, bytes, dict, set, frozenset)) or not isinstance(value, Iterable):
        return None
    if isinstance(value, np.ndarray) and value.ndim != 1:
        return None
    numbers = tuple(as_float(item) for item in value)
    return numbers if all(number is not None and math.isfinite(number) for number in numbers) else None


def coerce_positive(subject: object, *names: str) -> None:
    """Convert each field to a positive finite float."""
    _coerce_numbers(subject, names, "positive and finite", lambda number: 0 < number < math.inf)


def coerce_nonnegative(subject: object, *names: str) -> None:
    """Convert each field to a finite float, zero or above."""
    _coerce_numbers(subject, names, "zero or positive, and finite", lambda number: 0 <= number < math.inf)


def coerce_fraction(subject: object, *names: str) -> None:
    """Convert each field to a float in [0, 1]."""
    _coerce_numbers(
        subject, names, "in [0, 1]", lambda number: 0 <= number <= 1, "; a fraction, where 1 means all"
    )


def _coerce_numbers(subject, names, must, is_right, cure="") -> None:
    for name in names:
        value = getattr(subject, name)
        number = as_float(value)
        if number is None:
            refuse(subject, f"{name} must be a number, {must}, got {short_repr(value)}")
        if not is_right(number):
            refuse(subject, f"{name} must be {must}, got {short_repr(value)}{cure}")
        set_fields(subject, **{name: number})


def coerce_vector(subject: object, *names: str) -> None:
    """Convert each field to a tuple of three finite floats."""
    for name in names:
        value = getattr(subject, name)
        vector = as_floats(value)
        if vector is None or len(vector) != 3:
            refuse(subject, f"{name} must be three finite numbers, got {short_repr(value)}")
        set_fields(subject, **{name: vector})


def coerce_direction(subject: object, *names: str) -> None:
    """Convert each field, a vector of any length except 0, to a unit vector."""
    for name in names:
        value = getattr(subject, name)
        vector = as_floats(value)
        if vector is None or len(vector) != 3 or not any(vector):
            refuse(subject, f"{name} must be three finite numbers, not all zero, got {short_repr(value)}")
        set_fields(subject, **{name: unit_vector(vector)})


def coerce_name(subject: object) -> None:
    """Convert the field `name` to a non-empty text without ".", or None."""
    name = subject.name
    if name is not None and (not isinstance(name, str) or not name.strip()):
        refuse(subject, f"name must be a text and not empty, got {short_repr(name)}")
    if name is not None and "." in name:
        cure = f"write name={name.replace('.', '_')!r}"
        refuse(
            subject, f"name must not contain '.', as in 'detector.flux_in', got {short_repr(name)}; {cure}"
        )
    set_fields(subject, name=None if name is None else str(name))


def check_one_of(subject: object, name: str, choices: Iterable[str]) -> None:
    """Raise SceneError if the field is not one of these texts."""
    value, choices = getattr(subject, name), list(choices)
    if not isinstance(value, str) or value not in choices:
        valid = " or ".join(map(repr, choices))
        refuse(subject, f"{name} must be {valid}, got {short_repr(value)}; {name_hint(value, choices)}")


def check_type(subject: object, name: str, types: type | tuple[type, ...], must: str) -> None:
    """Raise SceneError if the field is not an instance of the types, which `must` describes."""
    value = getattr(subject, name)
    if not isinstance(value, types):
        refuse(subject, f"{name} must be {must}, got {short_repr(value)}")


# ---- Types of fields that accept more than they store.
#
# A list, an array or a single object becomes a tuple of floats or parts. `Converted[Given, Kept]` tells a
# type checker what the constructor accepts and what the attribute is. The checker sees a descriptor; at run
# time the type is that of the attribute, or a third one: the type in the JSON file of a scene.

Part = TypeVar("Part")
Bins = int | tuple[float, ...]  # a number of equal bins, or edges

if TYPE_CHECKING:
    from typing import Generic

    Given = TypeVar("Given", contravariant=True)
    Kept = TypeVar("Kept", covariant=True)
    Written = TypeVar("Written")

    class Converted(Generic[Given, Kept]):
        """A field that accepts Given and stores Kept."""

        def __get__(self, instance: object, owner: Any = None) -> Kept: ...
        def __set__(self, instance: object, value: Given) -> None: ...

    class ConvertedAs(Converted[Given, Kept], Generic[Given, Kept, Written]):
        """A field that accepts Given, stores Kept and is Written to the JSON file of a scene."""

    BinsParameter = InitVar[int | Iterable[float] | None]
else:

    class Converted:
        """A field whose type at run time is the last one listed."""

        def __class_getitem__(cls, types: tuple[object, ...]) -> object:
            return types[-1]

    ConvertedAs = Converted
    BinsParameter = InitVar[Bins | None]  # a parameter that is no field


VectorField = Converted[Iterable[float], Vector]
OptionalVectorField = Converted[Iterable[float] | None, Vector | None]
LengthsField = ConvertedAs[Iterable[float] | float, Vector, Vector | float]  # one for all axes, or three
NumbersField = Converted[Iterable[float], tuple[float, ...]]
OptionalNumbersField = Converted[Iterable[float] | None, tuple[float, ...] | None]
BinsField = Converted[int | Iterable[float], Bins]
OptionalBinsField = Converted[int | Iterable[float] | None, Bins | None]
ArrayField = Converted[ArrayLike, np.ndarray]
PartsField = Converted[Iterable[Part] | Part, tuple[Part, ...]]
