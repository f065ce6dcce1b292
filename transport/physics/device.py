"""Compilation of device functions: inlined into the pass that calls them, so that the lane loop vectorises.

LLVM inlines them. Numba could too, but then it infers each function's types anew at every call: all passes
took 93 s of CPU to compile instead of 61 s, those that draw Sobol points two to three times as long, and ran
no faster.
"""

from numba import njit

# Never nnan or ninf: they make isfinite(nan) true, which breaks every guard against NaN.
ARITHMETIC = {"error_model": "numpy", "fastmath": {"contract", "nsz"}}

# For passes whose rounding must be the same wherever it occurs, and the functions that they call.
EXACT = {"error_model": "numpy", "fastmath": False}

device = njit(forceinline=True, **ARITHMETIC)
exact_device = njit(forceinline=True, **EXACT)
