"""Compilation of device functions: inlined into the pass that calls them, so that the lane loop vectorises.

LLVM inlines them. Numba could too, but then it infers each function's types anew at every call: all passes
took 93 s of CPU to compile instead of 61 s, those that draw Sobol points two to three times as long, and ran
no faster.

Products and sums. Where an expression adds to a product, or subtracts one, product and sum are one operation
with one rounding (a fused multiply-add): in a*b + c*d the second product is fused. This is decided by the
source, expression by expression, and not by LLVM, whose choice would depend on what is inlined where. So the
bits of a result do not depend on how passes are grouped and compiled.
"""

import operator

from llvmlite import ir as llvm
from numba import config, njit, types
from numba.core import ir
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.typed_passes import NopythonRewrites
from numba.extending import intrinsic


def _fused(negates_product: bool, negates_sum: bool):
    """Return the intrinsic ±a·b ± c with one rounding."""

    @intrinsic
    def fused(typing_context, a, b, c):
        def codegen(context, builder, signature, args):
            a, b, c = args
            a, c = builder.fneg(a) if negates_product else a, builder.fneg(c) if negates_sum else c
            double = llvm.DoubleType()
            kind = llvm.FunctionType(double, [double] * 3)
            name = "llvm.fma.f64"
            found = builder.module.globals.get(name) or llvm.Function(builder.module, kind, name)
            return builder.call(found, [a, b, c])

        return types.float64(types.float64, types.float64, types.float64), codegen

    return fused


# a·b + c, a·b - c, c - a·b
PLUS, MINUS, FROM = _fused(False, False), _fused(False, True), _fused(True, False)


@register_pass(mutates_CFG=False, analysis_only=False)
class FuseMultiplyAdds(FunctionPass):
    """Replace a sum or difference with a product of the same expression by a fused multiply-add."""

    _name = "fuse_multiply_adds"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state) -> bool:
        """Rewrite the typed function; return that it has changed."""
        self.state, before = state, state.func_ir
        for block in before.blocks.values():
            products, statements = {}, []
            for statement in block.body:
                value = getattr(statement, "value", None)
                if isinstance(statement, ir.Assign) and self._is_of_floats(value):
                    if value.fn is operator.mul and statement.target.name.startswith("$"):
                        products[statement.target.name] = value
                    statements += self._fuse(statement, value, products)
                statements.append(statement)
            block.body = statements
        return True

    def _is_of_floats(self, value: object) -> bool:
        """Return whether this is an operation on two float64."""
        if not (isinstance(value, ir.Expr) and value.op in ("binop", "inplace_binop")):
            return False
        return all(self.state.typemap[part.name] == types.float64 for part in (value.lhs, value.rhs))

    def _fuse(self, statement: ir.Assign, value: ir.Expr, products: dict) -> list[ir.Assign]:
        """Let the statement call the fused operation; return what loads it."""
        left, right = products.get(value.lhs.name), products.get(value.rhs.name)
        fn = value.immutable_fn if value.op == "inplace_binop" else value.fn
        if fn not in (operator.add, operator.sub) or not (left or right):
            return []
        product, term = (right, value.lhs) if right else (left, value.rhs)
        function = PLUS if fn is operator.add else FROM if right else MINUS
        scope, loc = statement.target.scope, statement.loc
        name = scope.redefine("$fused", loc)
        state, float64 = self.state, types.float64
        state.typemap[name.name] = state.typingctx.resolve_value_type(function)
        call = ir.Expr.call(name, (product.lhs, product.rhs, term), (), loc)
        state.calltypes[call] = state.typingctx.resolve_function_type(
            state.typemap[name.name], (float64,) * 3, {}
        )
        statement.value = call
        return [ir.Assign(ir.Global("fused", function, loc), name, loc)]


class FusingCompiler(CompilerBase):
    """Numba's compiler with explicit fused multiply-adds."""

    def define_pipelines(self):
        """Return the usual passes, and this one after type inference."""
        manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.add_pass_after(FuseMultiplyAdds, NopythonRewrites)
        manager.finalize()
        return [manager]


# Never nnan or ninf: they make isfinite(nan) true, which breaks every guard against NaN.
ARITHMETIC = {"error_model": "numpy", "fastmath": {"nsz"}, "pipeline_class": FusingCompiler}

# For passes whose rounding must be the same wherever it occurs, and the functions that they call.
EXACT = {"error_model": "numpy", "fastmath": False}

device = njit(forceinline=True, **ARITHMETIC)
exact_device = njit(forceinline=True, **EXACT)


# ---- A choice without a branch.


def _choose_plain(condition, first, second):
    """Twin of `_choose` in plain Python."""
    return first if condition else second


@intrinsic
def _choose(typing_context, condition, first, second):
    """Return the first number if the condition holds, else the second; both are computed.

    LLVM may turn branches of `first if condition else second` that store what they loaded into loops without
    vectors, or into masked stores (see engine/bodies.py).
    """
    kind = typing_context.unify_types(first, second)

    def codegen(context, builder, signature, args):
        first, second = (
            context.cast(builder, value, given, kind)
            for value, given in zip(args[1:], signature.args[1:], strict=True)
        )
        return builder.select(args[0], first, second)

    return kind(types.boolean, kind, kind), codegen


choose = _choose_plain if config.DISABLE_JIT else _choose
