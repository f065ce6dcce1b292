"""Raw addresses: call a pass by address, view memory as an array, add to a row; with plain Python twins for
NUMBA_DISABLE_JIT=1.

The owner of an address keeps its memory alive: program.Program its tables, driver.run_batch its sums.
"""

import ctypes

import numpy as np
from llvmlite import ir
from numba import carray, config, njit, types
from numba.extending import intrinsic


@intrinsic
def _pointer(typing_context, address):
    """Convert an address (int64) to a void pointer."""

    def codegen(context, builder, signature, args):
        return builder.inttoptr(args[0], ir.IntType(8).as_pointer())

    return types.voidptr(types.int64), codegen


@intrinsic
def _call_pass(typing_context, entry, bundle, table, first, live):
    """Call the compiled pass at address `entry` as (bundle, table, first, live); returns the number of live
    lanes.
    """

    def codegen(context, builder, signature, args):
        pointer, integer = ir.IntType(8).as_pointer(), ir.IntType(64)
        function = ir.FunctionType(integer, [pointer, pointer, integer, integer]).as_pointer()
        bundle, table = (builder.inttoptr(a, pointer) for a in args[1:3])
        return builder.call(builder.inttoptr(args[0], function), [bundle, table, args[3], args[4]])

    return types.int64(types.int64, types.int64, types.int64, types.int64, types.int64), codegen


@intrinsic
def _add_to_row(typing_context, address, first, second, third, fourth):
    """Add four int64 words to the row of four at `address`, by one 32-byte load, addition and store."""

    def codegen(context, builder, signature, args):
        row = ir.VectorType(ir.IntType(64), 4)
        added = ir.Constant(row, ir.Undefined)
        for i, word in enumerate(args[1:]):
            added = builder.insert_element(added, word, ir.IntType(32)(i))
        pointer = builder.inttoptr(args[0], row.as_pointer())
        builder.store(builder.add(builder.load(pointer, align=8), added), pointer, align=8)
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64, types.int64, types.int64), codegen


def _add_to_row_plain(address, *words):
    """Twin of `_add_to_row` in plain Python."""
    row = _view_plain(address, 4, np.int64)
    row += np.array(words, np.int64)


@njit(inline="always")
def _view(address, count, dtype):
    """View `count` items of `dtype` at `address` as an array, without a copy."""
    return carray(_pointer(address), (count,), dtype)


def _view_plain(address, count, dtype):
    """Twin of `_view` in plain Python; records become a recarray."""
    memory = (ctypes.c_char * (int(count) * np.dtype(dtype).itemsize)).from_address(int(address))
    return np.frombuffer(memory, dtype).view(np.recarray if np.dtype(dtype).names else np.ndarray)


def _call_pass_plain(entry, bundle, table, first, live):
    """Twin of `_call_pass` in plain Python: `entry` is the Python function itself."""
    return entry(bundle, table, first, live)


view = _view_plain if config.DISABLE_JIT else _view
call_pass = _call_pass_plain if config.DISABLE_JIT else _call_pass
add_to_row = _add_to_row_plain if config.DISABLE_JIT else _add_to_row
