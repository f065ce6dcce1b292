"""How every device function is compiled: inlined into the pass that calls it, so that the lane loop vectorises."""

from numba import njit

# Never nnan or ninf: they make isfinite(nan) true and so break every guard.
ARITHMETIC = {"error_model": "numpy", "fastmath": {"contract", "nsz"}}

EXACT = {
    "error_model": "numpy",
    "fastmath": False,
}  # for passes whose roundings must be alike wherever they occur

device = njit(inline="always", **ARITHMETIC)
