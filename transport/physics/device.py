"""How every device function is compiled: inlined into the pass that calls it, so that the lane loop vectorises."""

from numba import njit

# Never nnan or ninf: they make isfinite(nan) true and so break every guard.
ARITHMETIC = {"error_model": "numpy", "fastmath": {"contract", "nsz"}}

device = njit(inline="always", **ARITHMETIC)
