"""Base class of phase functions, and immutable arrays that are compared by content."""

from __future__ import annotations

import hashlib
import math

import numpy as np

from transport.validation import UNMASK, is_masked, refuse, shown


class Phase:
    """Base class of phase functions; not instantiated directly.

    A phase function is a density of directions over the cosine mu of the scattering angle: `density(mu)`
    [sr^-1] integrates to 1 over the sphere, and `g` is the mean cosine.
    """

    is_phase = True  # False for an Isotropic with an amount, which is an emission only
    g: float  # mean cosine of the scattering angle

    def density(self, mu: np.ndarray | float) -> np.ndarray | float:
        """Return the phase function at cosines mu of the scattering angle.

        Parameters
        ----------
        mu : float or array
            Cosines of the scattering angle, from -1 (backward) to 1 (forward).

        Returns
        -------
        float or array
            Density per solid angle [sr^-1], of the shape of mu.
        """
        raise NotImplementedError


def is_phase(value: object) -> bool:
    """Return whether a value is a phase function."""
    return isinstance(value, Phase) and value.is_phase


def settled_phase(subject: object, value: object) -> Phase:
    """Return the phase function of a medium; raise SceneError for anything else."""
    if is_phase(value):
        return value
    if isinstance(value, type) and issubclass(value, Phase):
        refuse(subject, f"phase must be an instance, got the class {value.__name__}; write phase=...(...)")
    if isinstance(value, Phase):
        kind = type(value).__name__
        cure = "leave its amount out" if kind == "Isotropic" else "mix phases, not materials"
        refuse(subject, f"phase must be a phase function, got {shown(value)}; {cure}")
    refuse(subject, f"phase must be one such as HenyeyGreenstein(g=0.9) or Isotropic(), got {shown(value)}")


def settled_array(subject: object, name: str, value: object, dims: int) -> np.ndarray:
    """Return a read-only copy of an array with `dims` dimensions.

    Raises SceneError if a value is negative, not finite or masked.
    """
    # Check type and shape.
    if is_masked(value):
        got = f"{np.ma.count_masked(value)} of {value.size} values masked"
        refuse(subject, f"{name} must have all its values, got {got}; {UNMASK}")
    try:
        given = np.asarray(value)
    except (ValueError, TypeError):
        given = None
    if given is None or given.dtype.kind not in "iuf":
        refuse(subject, f"{name} must be an array of numbers, got {shown(value)}")
    if given.ndim != dims:
        refuse(subject, f"{name} must have {dims} dimension{'s' * (dims > 1)}, got shape {given.shape}")
    if given.size == 0:
        refuse(subject, f"{name} must not be empty, got shape {given.shape}")
    # Copy, and name the first invalid value.
    array = np.array(given, dtype=np.float64, order="C")
    wrong = ~((array >= 0) & (array < math.inf))
    if wrong.any():
        place = tuple(int(k) for k in np.argwhere(wrong)[0])
        where = place if dims > 1 else place[0]
        refuse(subject, f"{name} must be zero or positive, and finite, got {array[place]} at {where}")
    array += 0.0  # -0.0 becomes 0.0
    array.flags.writeable = False
    return array


def digest_of(*arrays: np.ndarray) -> bytes:
    """Return a digest of 16 bytes of the contents of arrays, used for equality and hash."""
    code = hashlib.blake2b(digest_size=16)
    for array in arrays:
        code.update(repr((array.shape, any(array.strides))).encode())
        code.update(array if any(array.strides) else array.flat[0].tobytes())
    return code.digest()
