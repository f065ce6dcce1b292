"""Bit casts and conversions between float64 and int64, and bit reversal, with plain Python twins.

The twins are for NUMBA_DISABLE_JIT=1.
"""

import llvmlite.binding as llvm
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


# ---- Conversions of nonnegative numbers below 2^52. A CPU without AVX-512DQ has no instruction that converts
# a vector of them, and LLVM would take the lanes apart; adding 2^52 moves the integer into the last bits.
# Both ways give the same digits.

CONVERTS_VECTORS = llvm.get_host_cpu_features().get("avx512dq", False)
SHIFT_BITS, SHIFT = 0x4330000000000000, 4503599627370496.0  # 2^52


def _whole_plain(x):
    """Twin of `_whole` in plain Python."""
    return int(x)


def _real_plain(whole):
    """Twin of `_real` in plain Python."""
    return float(whole)


@intrinsic
def _whole(typing_context, x):
    """Return the integer part of a number in [0, 2^52)."""

    def codegen(context, builder, signature, args):
        integer, real = ir.IntType(64), ir.DoubleType()
        if CONVERTS_VECTORS:
            return builder.fptosi(args[0], integer)
        kind = ir.FunctionType(real, [real])
        name = "llvm.floor.f64"
        floor = builder.module.globals.get(name) or ir.Function(builder.module, kind, name)
        shifted = builder.fadd(builder.call(floor, [args[0]]), real(SHIFT))
        return builder.xor(builder.bitcast(shifted, integer), integer(SHIFT_BITS))

    return types.int64(types.float64), codegen


@intrinsic
def _real(typing_context, whole):
    """Return an integer in [0, 2^52) as a float64."""

    def codegen(context, builder, signature, args):
        integer, real = ir.IntType(64), ir.DoubleType()
        if CONVERTS_VECTORS:
            return builder.sitofp(args[0], real)
        shifted = builder.bitcast(builder.or_(args[0], integer(SHIFT_BITS)), real)
        return builder.fsub(shifted, real(SHIFT))

    return types.float64(types.int64), codegen


whole = _whole_plain if config.DISABLE_JIT else _whole
real = _real_plain if config.DISABLE_JIT else _real
bits_of = _bits_of_plain if config.DISABLE_JIT else _bits_of
float_of = _float_of_plain if config.DISABLE_JIT else _float_of
reversed_bits = _reversed_plain if config.DISABLE_JIT else _reversed
