"""How every device function is compiled: inlined into the pass that calls it, so that the lane loop vectorises.

LLVM does that.  Numba could as well, but then infers each function's types anew wherever it is called: all passes took
93 s of CPU to compile instead of 61 s, those that draw Sobol points two to three times as long, and ran no faster.
"""

from numba import njit

# Never nnan or ninf: they make isfinite(nan) true and so break every guard.
ARITHMETIC = {"error_model": "numpy", "fastmath": {"contract", "nsz"}}

EXACT = {
    "error_model": "numpy",
    "fastmath": False,
}  # for passes whose roundings must be alike wherever they occur, and what they call

device = njit(forceinline=True, **ARITHMETIC)
exact_device = njit(forceinline=True, **EXACT)
