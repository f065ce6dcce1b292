"""A medium of voxels: coefficients that change from cell to cell of a box."""

from __future__ import annotations

import math
from dataclasses import field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from transport.fields import ConvertedAs
from transport.free_memory import ALWAYS, memory_left, size_text
from transport.media.base import Phase, digest_of, settled_array, settled_phase
from transport.media.medium import _isotropic, told
from transport.shapes import Box
from transport.validation import (
    as_float,
    check_type,
    refuse,
    scene_object,
    settle_nonnegative,
    settle_positive,
    shown,
    store,
)

# Making a grid and compiling its scene take 34 bytes per voxel beside an array given, 42 beside two: measured at 200^3.
BYTES_PER_VOXEL = 48


@scene_object(kw_only=True)
class Grid:
    """Voxels that fill `box`, an axis-parallel Box, evenly: used as Surface(grid.box, Transparent(), inside=grid).

    absorption, scattering: (nx, ny, nz) coefficients [m^-1], constant within each voxel, the first at the lower
    corner; one of both may be left out or be a number, which takes no memory.  The arrays are copied and kept
    read-only: a run takes up to 48 bytes per voxel, and more voxels than fit into memory are refused.  phase, index
    and emission [W m^-3 sr^-1] are the same in all voxels.
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
    digest: bytes = field(init=False, repr=False)  # of the arrays' bytes: what equality and hash go by

    def __post_init__(self) -> None:
        check_type(self, "box", Box, "a Box, as Box(size=(1, 1, 1))")
        self._check_memory()
        given = {name: self._settled(name) for name in ("absorption", "scattering")}
        shapes = [array.shape for array in given.values() if array.ndim == 3]
        if not shapes:
            cure = "write Medium(...) for the same everywhere"
            refuse(self, f"absorption or scattering must be an array (nx, ny, nz), got numbers only; {cure}")
        if shapes[0] != shapes[-1]:
            refuse(self, f"absorption and scattering must have one shape, got {shapes[0]} and {shapes[1]}")
        arrays = {name: np.broadcast_to(_thinned(array), shapes[0]) for name, array in given.items()}
        store(self, **arrays, shape=shapes[0], digest=digest_of(*arrays.values()))
        self._freeze()
        with np.errstate(over="ignore"):
            highest = float(self.extinction.max())
        if not math.isfinite(highest):
            refuse(self, f"absorption + scattering must be finite, got {highest}; lower one of them")
        store(self, phase=settled_phase(self, self.phase))
        settle_positive(self, "index")
        if as_float(self.emission) is None and np.ndim(self.emission):
            cure = "give one number, or a Medium with an emission to each part"
            refuse(self, f"emission must be one number for all voxels, got {shown(self.emission)}; {cure}")
        settle_nonnegative(self, "emission")

    def __repr__(self) -> str:
        words = [f"box={self.box!r}", f"shape={self.shape}", *told(self, "phase", "index", "emission")]
        return f"Grid({', '.join(words)})"

    @property
    def extinction(self) -> np.ndarray:
        """absorption + scattering [m^-1] of each voxel; made anew each time."""
        return self.absorption + self.scattering

    @property
    def albedo(self) -> np.ndarray:
        """scattering / extinction of each voxel, 0 where nothing happens; made anew each time."""
        extinction = self.extinction
        return np.divide(self.scattering, extinction, out=np.zeros(self.shape), where=extinction > 0)

    def _check_memory(self) -> None:
        """Refuse arrays of more voxels than there is memory for, before they are copied."""
        shapes = [getattr(value, "shape", ()) for value in (self.absorption, self.scattering)]
        shapes = [
            s for s in shapes if isinstance(s, tuple) and len(s) == 3 and all(isinstance(n, int) for n in s)
        ]
        shape = max(shapes, key=math.prod, default=())
        need = BYTES_PER_VOXEL * math.prod(shape) if shapes else 0
        left = memory_left() if need > ALWAYS else None
        if left is not None and need > left:
            figures = f"{size_text(need)}, and {size_text(left)} of memory are left"
            cure = "use fewer voxels, or Medium(...) where all are alike"
            refuse(self, f"voxels must fit into memory, got shape {shape}, which takes {figures}; {cure}")

    def _settled(self, name: str) -> np.ndarray:
        value = getattr(self, name)
        number = 0.0 if value is None else as_float(value)
        if number is None:
            return settled_array(self, name, value, 3)
        if not 0 <= number < math.inf:
            refuse(self, f"{name} must be zero or positive, and finite, got {shown(value)}")
        return np.array(number)

    def _freeze(self) -> None:
        for array in (self.absorption, self.scattering):
            if array.flags.writeable:
                array.flags.writeable = False

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._freeze()


def _thinned(array: np.ndarray) -> np.ndarray:
    """One number instead of an array of the same ones."""
    return array if array.ndim == 3 and (array != array[0, 0, 0]).any() else np.array(array.flat[0])
