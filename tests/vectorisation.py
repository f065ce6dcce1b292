"""Whether a pass works on four or eight lanes at a time, by its machine code."""

import platform
import re

import llvmlite.binding as llvm
from numba import cfunc, from_dtype, types

from transport.engine.bundle import Bundle


def assembly(lane_pass):
    """Machine code as text; what was loaded from the cache has none and is compiled once more."""
    compiled = lane_pass.compiled
    if compiled.cache_hits:
        signature = types.int64(from_dtype(Bundle), from_dtype(lane_pass.table), types.uint64, types.uint64)
        compiled = cfunc(signature, **lane_pass.arithmetic)(lane_pass.function)
    return compiled._library.get_asm_str()


def innermost_loops(text):
    """Instructions between a jump back and its target, for loops that hold no other."""
    labels, jumps, instructions = {}, [], []
    for line in (line.split("#")[0].strip() for line in text.splitlines()):
        if line.endswith(":"):
            labels[line[:-1]] = len(instructions)
        elif line and not line.startswith("."):
            jump = re.match(r"j\w+\s+(\S+)", line)
            if jump and jump[1] in labels:
                jumps.append((labels[jump[1]], len(instructions)))
            instructions.append(line)
    inner = [a for a in jumps if not any(a != b and a[0] <= b[0] and b[1] <= a[1] for b in jumps)]
    return [instructions[first : last + 1] for first, last in inner]


def wide(loop):
    """Instructions on registers of four or eight lanes."""
    return sum("%ymm" in line or "%zmm" in line for line in loop)


def scalar(loop):
    """Arithmetic on one number at a time."""
    arithmetic = re.compile(r"v(?!mov)\w+sd\b|vcvtt?sd2\w+|vcvtsi2sd\w*")
    return sum(bool(arithmetic.match(line)) and not wide([line]) for line in loop)


def is_vectorised(text, scalar_share):
    """Whether one loop does the work in wide registers; the loop over the last lanes may be scalar.

    Without a loop the pass is a plain fill, for which LLVM calls memset.
    """
    loops = innermost_loops(text)
    if not loops:
        return True
    rest = max(map(scalar, loops), default=0)
    return any(
        wide(loop) > 0 and scalar(loop) <= scalar_share * wide(loop) and 2 * wide(loop) >= rest
        for loop in loops
    )


def has_fused(text):
    """Whether a product and a sum are rounded together anywhere."""
    return re.search(r"\bvfn?m(add|sub)", text) is not None


def host_has(feature):
    return platform.machine() in ("x86_64", "AMD64") and llvm.get_host_cpu_features().get(feature, False)
