"""Bit casts between float64 and int64, with plain twins for NUMBA_DISABLE_JIT=1."""

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.extending import intrinsic


def _bits_of_plain(x):
    return int(np.float64(x).view(np.int64))


def _float_of_plain(bits):
    return float(np.int64(bits).view(np.float64))


@intrinsic
def _bits_of(typing_context, x):
    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), codegen


@intrinsic
def _float_of(typing_context, bits):
    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.int64), codegen


bits_of = _bits_of_plain if config.DISABLE_JIT else _bits_of
float_of = _float_of_plain if config.DISABLE_JIT else _float_of
