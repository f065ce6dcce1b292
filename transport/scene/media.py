"""Participating media: coefficients and phase functions of the space between surfaces."""

from __future__ import annotations

import math
from dataclasses import field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from transport.geometry.solid import Box
from transport.scene.phase_functions import Phase, coerce_array, coerce_phase, digest_of
from transport.statistics.chunked import MIN_FREE, available_memory, size_text
from transport.validation import (
    ConvertedAs,
    as_float,
    check_type,
    coerce_nonnegative,
    coerce_positive,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)

# ---- Homogeneous media and vacuum.


def _isotropic() -> Phase:
    from transport.scene.emissions import Isotropic  # deferred: emissions import phases

    return Isotropic()


@scene_object
class Medium:
    """A homogeneous medium that absorbs, scatters, refracts and emits.

    Media are compared by value.

    Parameters
    ----------
    absorption : float, default 0
        Absorption coefficient [m^-1], zero or positive.
    scattering : float, default 0
        Scattering coefficient [m^-1], zero or positive.
    phase : phase function, default Isotropic()
        Isotropic(), HenyeyGreenstein, Rayleigh, Tabulated, or a Mixture of them.
    index : float, default 1
        Refractive index. A Dielectric boundary must agree with it; with a clock it divides the speed of
        light.
    emission : float, default 0
        Emitted power per volume and solid angle [W m^-3 sr^-1], isotropic.
    name : str, optional
        Name in the energy balance [default: that of the surface that holds it].

    Raises
    ------
    SceneError
        If a coefficient is negative or not finite.

    Examples
    --------
    >>> import transport as tp
    >>> fog = tp.Medium(absorption=0.1, scattering=0.9, phase=tp.HenyeyGreenstein(0.75))
    >>> fog.extinction, fog.albedo
    (1.0, 0.9)
    """

    absorption: float = 0.0
    scattering: float = 0.0
    phase: Phase = field(default_factory=_isotropic)
    index: float = 1.0
    emission: float = 0.0
    name: str | None = None

    def __post_init__(self) -> None:
        coerce_nonnegative(self, "absorption", "scattering", "emission")
        coerce_positive(self, "index")
        if self.name is not None and not (isinstance(self.name, str) and self.name):
            refuse(self, f'name must be text, such as "fog", got {short_repr(self.name)}')
        set_fields(self, phase=coerce_phase(self, self.phase))
        if not math.isfinite(self.extinction):
            refuse(self, f"absorption + scattering must be finite, got {self.extinction}; lower one of them")

    def __repr__(self) -> str:
        return f"""Medium({
            ", ".join(
                nondefault_arguments(self, "absorption", "scattering", "phase", "index", "emission", "name")
            )
        })"""

    @property
    def extinction(self) -> float:
        """Extinction coefficient, absorption + scattering.

        Returns
        -------
        float
            Coefficient [m^-1].
        """
        return self.absorption + self.scattering

    @property
    def albedo(self) -> float:
        """Single-scattering albedo, scattering / extinction; 0 without scattering.

        Returns
        -------
        float
        """
        return self.scattering / self.extinction if self.scattering else 0.0


@scene_object
class Vacuum:
    """Vacuum: no absorption, scattering or emission, refractive index 1.

    The space of a scene is vacuum unless a medium is given.

    Examples
    --------
    >>> import transport as tp
    >>> tp.Vacuum().extinction
    0.0
    """

    absorption = scattering = extinction = albedo = emission = 0.0
    index = 1.0

    @property
    def phase(self) -> Phase:
        """Isotropic(); vacuum scatters nothing.

        Returns
        -------
        Isotropic
        """
        return _isotropic()


def nondefault_arguments(medium: object, *names: str) -> list[str]:
    """Return the arguments of a medium as source text, without those at their defaults."""
    plain = {"absorption": 0.0, "scattering": 0.0, "phase": _isotropic(), "index": 1.0, "emission": 0.0}
    plain["name"] = None
    return [f"{name}={getattr(medium, name)!r}" for name in names if getattr(medium, name) != plain[name]]


def canonical_medium(medium):
    """Return the canonical form of a medium, equal for all that act alike.

    Without scattering it has no phase function; without any effect it is Vacuum().
    """
    if not isinstance(medium, Medium):
        return medium
    if replace(medium, name=None, phase=Medium().phase) == Medium():
        return Vacuum()
    return replace(medium, phase=Medium().phase) if medium.scattering == 0 else medium


# ---- A medium of voxels: coefficients that vary from voxel to voxel of a box.

# Making a grid and compiling its scene take 34 bytes per voxel besides one given array, 42 besides two, and a
# run then holds 17 or 33, with the copy in the arena of its plan: measured at 200^3.
BYTES_PER_VOXEL = 48


@scene_object(kw_only=True)
class Grid:
    """A medium of voxels that fill an axis-parallel box.

    Use it as `Surface(grid.box, Transparent(), inside=grid)`. All parameters are keywords.

    Parameters
    ----------
    box : Box
        Box that the voxels fill evenly.
    absorption, scattering : float or array (nx, ny, nz), default 0
        Coefficients [m^-1], zero or positive, constant in each voxel; the first voxel is at the lower
        corner. At least one is an array; a number takes no memory.
    phase : phase function, default Isotropic()
        Phase function of all voxels.
    index : float, default 1
        Refractive index of all voxels.
    emission : float, default 0
        Emitted power per volume and solid angle [W m^-3 sr^-1] of all voxels.

    Raises
    ------
    SceneError
        If the arrays are invalid or differ in shape, or if the voxels do not fit into memory.

    Notes
    -----
    Arrays are copied and read-only. `shape` is (nx, ny, nz). A run takes up to 48 bytes per voxel.

    Examples
    --------
    >>> import numpy as np
    >>> import transport as tp
    >>> grid = tp.Grid(box=tp.Box(size=1.0), absorption=np.ones((2, 2, 4)), scattering=3.0)
    >>> grid.shape
    (2, 2, 4)
    >>> float(grid.albedo[0, 0, 0])
    0.75
    """

    box: Box
    absorption: ConvertedAs[ArrayLike, np.ndarray, np.ndarray | float] = field(
        default=0.0, compare=False, repr=False
    )
    scattering: ConvertedAs[ArrayLike, np.ndarray, np.ndarray | float] = field(
        default=0.0, compare=False, repr=False
    )
    phase: Phase = field(default_factory=_isotropic)
    index: float = 1.0
    emission: float = 0.0
    shape: tuple[int, int, int] = field(init=False, compare=False)
    digest: bytes = field(init=False, repr=False)  # of the arrays, for equality and hash

    def __post_init__(self) -> None:
        check_type(self, "box", Box, "a Box, such as Box(size=(1, 1, 1))")
        self._check_memory()
        # Convert coefficients to arrays of equal shape; constant ones are broadcast from one number.
        given = {name: self._settled(name) for name in ("absorption", "scattering")}
        shapes = [array.shape for array in given.values() if array.ndim == 3]
        if not shapes:
            cure = "use Medium(...) for a homogeneous medium"
            refuse(self, f"absorption or scattering must be an array (nx, ny, nz), got numbers only; {cure}")
        if shapes[0] != shapes[-1]:
            refuse(self, f"absorption and scattering must have one shape, got {shapes[0]} and {shapes[1]}")
        arrays = {
            name: np.broadcast_to(_collapse_constant(array), shapes[0]) for name, array in given.items()
        }
        set_fields(self, **arrays, shape=shapes[0], digest=digest_of(*arrays.values()))
        self._freeze()
        # Check that coefficients add up to finite numbers.
        with np.errstate(over="ignore"):
            highest = float(self.extinction.max())
        if not math.isfinite(highest):
            refuse(self, f"absorption + scattering must be finite, got {highest}; lower one of them")
        # Check what is the same in all voxels.
        set_fields(self, phase=coerce_phase(self, self.phase))
        coerce_positive(self, "index")
        if as_float(self.emission) is None and np.ndim(self.emission):
            cure = "give one number, or use one Medium with an emission per part"
            refuse(
                self, f"emission must be one number for all voxels, got {short_repr(self.emission)}; {cure}"
            )
        coerce_nonnegative(self, "emission")

    def __repr__(self) -> str:
        words = [
            f"box={self.box!r}",
            f"shape={self.shape}",
            *nondefault_arguments(self, "phase", "index", "emission"),
        ]
        return f"Grid({', '.join(words)})"

    @property
    def extinction(self) -> np.ndarray:
        """Extinction coefficient of each voxel, absorption + scattering; a new array at each call.

        Returns
        -------
        array (nx, ny, nz)
            Coefficients [m^-1].
        """
        return self.absorption + self.scattering

    @property
    def albedo(self) -> np.ndarray:
        """Single-scattering albedo of each voxel, 0 without extinction; a new array at each call.

        Returns
        -------
        array (nx, ny, nz)
        """
        extinction = self.extinction
        return np.divide(self.scattering, extinction, out=np.zeros(self.shape), where=extinction > 0)

    def _check_memory(self) -> None:
        """Raise SceneError, before arrays are copied, if the voxels do not fit into memory."""
        shapes = [getattr(value, "shape", ()) for value in (self.absorption, self.scattering)]
        shapes = [
            s for s in shapes if isinstance(s, tuple) and len(s) == 3 and all(isinstance(n, int) for n in s)
        ]
        shape = max(shapes, key=math.prod, default=())
        need = BYTES_PER_VOXEL * math.prod(shape) if shapes else 0
        left = available_memory() if need > MIN_FREE else None
        if left is not None and need > left:
            figures = f"{size_text(need)}, and {size_text(left)} of memory are left"
            cure = "use fewer voxels, or Medium(...) for a homogeneous medium"
            refuse(self, f"voxels must fit into memory, got shape {shape}, which takes {figures}; {cure}")

    def _settled(self, name: str) -> np.ndarray:
        value = getattr(self, name)
        number = 0.0 if value is None else as_float(value)
        if number is None:
            return coerce_array(self, name, value, 3)
        if not 0 <= number < math.inf:
            refuse(self, f"{name} must be zero or positive, and finite, got {short_repr(value)}")
        return np.array(number)

    def _freeze(self) -> None:
        for array in (self.absorption, self.scattering):
            if array.flags.writeable:
                array.flags.writeable = False

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._freeze()


def _collapse_constant(array: np.ndarray) -> np.ndarray:
    """Return a constant array as a single number, others unchanged."""
    return array if array.ndim == 3 and (array != array[0, 0, 0]).any() else np.array(array.flat[0])
