"""Bit casts between float64 and int64, and bit reversal, with plain Python twins for NUMBA_DISABLE_JIT=1."""

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.extending import intrinsic


def _bits_of_plain(x):
    """Twin of `_bits_of` in plain Python."""
    return int(np.float64(x).view(np.int64))


def _float_of_plain(bits):
    """Twin of `_float_of` in plain Python."""
    return float(np.int64(bits).view(np.float64))


def _reversed_plain(word):
    """Twin of `_reversed` in plain Python."""
    return np.uint64(int(f"{int(word):064b}"[::-1], 2))


@intrinsic
def _bits_of(typing_context, x):
    """Return the bits of a float64 as int64."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), codegen


@intrinsic
def _float_of(typing_context, bits):
    """Return the float64 with these bits (int64)."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.int64), codegen


@intrinsic
def _reversed(typing_context, word):
    """Return a uint64 with its bits in reverse order.

    A byte shuffle where the CPU has one, so it vectorises.
    """

    def codegen(context, builder, signature, args):
        return builder.bitreverse(args[0])

    return types.uint64(types.uint64), codegen


bits_of = _bits_of_plain if config.DISABLE_JIT else _bits_of
float_of = _float_of_plain if config.DISABLE_JIT else _float_of
reversed_bits = _reversed_plain if config.DISABLE_JIT else _reversed
