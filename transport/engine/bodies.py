"""Passes: each physical step written once, for one particle, without a loop.

    @lane_pass(layout.ROULETTE_LAW, sums=to_ledger(layout.ROULETTE))
    def play_roulette(lane, table):
        ...
        return high, low

A body reads and writes fields of its lane by name (`lane.weight`), and reads its table (`table.threshold`)
and what is constant in a batch (`lane.seed_low`). An array that the table refers to lies at an offset in the
arena of the plan: `view(lane.arena + table.rows, table.count, layout.SHEET)`. What all particles add to is
declared apart: the body returns integers (`tally.limbs` of a weight), and the function `sums` adds their
totals; engine/tally.py has the common ones. Only a loop that is not vectorised anyway may add to a word of
COUNTERS in its body. A body that few lanes need says which (`when`). A long chain of operations is cut in two
bodies (`before`), each with a loop of its own: a processor works at several lanes at once only as far as the
chain of each is short.

`Pass.compiled` makes the form for a bundle: a loop over the lanes [first, live) as a C callback, compiled
when a program first needs it and cached on disk by itself, so that a new kind of scene compiles only its new
passes. A step that concerns lanes as such, as compaction does, is a `bundle_pass`, which has the loop itself.
With NUMBA_DISABLE_JIT=1 all run as plain Python.
"""

import dis
import itertools
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from types import FunctionType

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numba import cfunc, config, njit, types, uint64
from numba.core import cgutils
from numba.core.errors import NumbaError
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    lower_setattr_generic,
    models,
    register_model,
)

from transport.compile.layout import PARTS
from transport.engine.bundle import (
    CARRIED,
    CARRIED_WORDS,
    HEADER,
    HEADER_WORDS,
    PITCH,
    SCRATCH,
    Bundle,
    view,
)
from transport.engine.cache import cached_kernels
from transport.physics.device import ARITHMETIC, device

LANE_FIELDS = tuple(name for name, _ in CARRIED + SCRATCH)
# words of the header that change while a pass runs; the others are loaded once per loop
COUNTERS = (
    *("scored", "record_count", "flight_count", "crossings", "collisions", "killed"),
    *("banked", "bank_overflow", "flying", "waiting", "rays_cast", "rays_taken"),
)


# LLVM 22 stores a choice between a new value and the loaded one under a mask. Without AVX-512 some processors
# run that in microcode (AMD Zen 3). There, all that is stored is combined with a word of the header that is
# 0, which LLVM does not know.
MASKS_STORES = llvm.get_host_cpu_features().get("avx512f", False)

# ---- Lanes and tables as values of compiled code: an address, whose attributes are fields.
#
# The table and the header are copied to memory of the loop's own, which LLVM keeps in registers: it could not
# know that the stores into lanes leave them alone.

INTEGERS = int, np.integer, np.bool_  # what plain bodies return
NUMBA_TYPES = {"f8": types.float64, "i8": types.int64}


class LaneType(types.Type):
    """One lane of a bundle: the bundle's address and the lane's number."""

    def __init__(self) -> None:
        super().__init__("Lane")

    def field(self, name: str):
        """Return offset [bytes] and type of a field, and whether it is constant; None where there is none."""
        if name in PARTS:
            return self.field(PARTS[name][0])
        if name not in Bundle.fields:
            return None
        kind, offset = Bundle.fields[name][:2]
        return offset, NUMBA_TYPES[kind.base.str[1:]], name in HEADER and name not in COUNTERS


class TableType(types.Type):
    """A record of constants at an address."""

    def __init__(self, dtype: np.dtype) -> None:
        self.dtype = dtype
        super().__init__(f"Table({dtype.descr})")

    def field(self, name: str):
        """Return offset [bytes] and type of a field, and that it is constant; None where there is none."""
        if name not in self.dtype.fields:
            return None
        kind, offset = self.dtype.fields[name][:2]
        return offset, TableType(kind) if kind.names else NUMBA_TYPES[kind.str[1:]], True


@register_model(LaneType)
class _LaneModel(models.StructModel):
    def __init__(self, manager, lane) -> None:
        super().__init__(
            manager, lane, [("bundle", types.voidptr), ("header", types.voidptr), ("number", types.uint64)]
        )


@register_model(TableType)
class _TableModel(models.StructModel):
    def __init__(self, manager, table) -> None:
        super().__init__(manager, table, [("address", types.voidptr)])


@infer_getattr
class _LaneFields(AttributeTemplate):
    key = LaneType

    def generic_resolve(self, owner, name):
        if name == "number":
            return types.uint64
        found = owner.field(name)
        return found and found[1]


@infer_getattr
class _TableFields(AttributeTemplate):
    key = TableType

    def generic_resolve(self, owner, name):
        found = owner.field(name)
        return found and found[1]


def _pointer(context, builder, address, offset, kind):
    """Return a pointer of a type, so many bytes after an address."""
    place = builder.gep(address, [ir.Constant(ir.IntType(64), offset)], inbounds=True)
    return builder.bitcast(place, context.get_data_type(kind).as_pointer())


def _copied(builder, address, size):
    """Copy so many bytes to memory of the function's own; return its address."""
    memory = cgutils.alloca_once(builder, ir.IntType(64), size=ir.IntType(64)(size // 8))
    memory = builder.bitcast(memory, address.type)
    cgutils.raw_memcpy(builder, memory, address, ir.IntType(64)(size), 1, align=8)
    return memory


def _lane_pointer(context, builder, owner, value, name):
    """Return a pointer to a field of a lane, or to a word of the header."""
    offset, kind, is_constant = owner.field(name)
    lane = cgutils.create_struct_proxy(owner)(context, builder, value)
    pointer = _pointer(context, builder, lane.header if is_constant else lane.bundle, offset, kind)
    return pointer if name in HEADER else builder.gep(pointer, [lane.number], inbounds=True)


@lower_getattr_generic(LaneType)
def _get_lane_field(context, builder, owner, value, name):
    if name == "number":
        return cgutils.create_struct_proxy(owner)(context, builder, value).number
    word = builder.load(_lane_pointer(context, builder, owner, value, name))
    if name not in PARTS:
        return word
    _, shift, length = PARTS[name]
    return builder.and_(builder.lshr(word, word.type(shift)), word.type((1 << length) - 1))


@lower_setattr_generic(LaneType)
def _set_lane_field(context, builder, signature, arguments, name):
    owner, given = signature.args
    _, kind, is_constant = owner.field(name)
    if is_constant:
        raise TypeError(f"{name} is constant in a batch; a word that counts stands in COUNTERS")
    value = context.cast(builder, arguments[1], given, kind)
    pointer = _lane_pointer(context, builder, owner, arguments[0], name)
    if name in PARTS:
        _, shift, length = PARTS[name]
        others = builder.and_(builder.load(pointer), value.type(~(((1 << length) - 1) << shift)))
        value = builder.or_(others, builder.shl(value, value.type(shift)))
    if not MASKS_STORES:
        word, zero = ir.IntType(64), _get_lane_field(context, builder, owner, arguments[0], "zero")
        value = builder.bitcast(builder.xor(builder.bitcast(value, word), zero), value.type)
    builder.store(value, pointer)


@lower_getattr_generic(TableType)
def _get_table_field(context, builder, owner, value, name):
    offset, kind, _ = owner.field(name)
    address = cgutils.create_struct_proxy(owner)(context, builder, value).address
    if isinstance(kind, TableType):
        inner = cgutils.create_struct_proxy(kind)(context, builder)
        inner.address = builder.gep(address, [ir.Constant(ir.IntType(64), offset)], inbounds=True)
        return inner._getvalue()
    return builder.load(_pointer(context, builder, address, offset, kind))


@intrinsic
def lanes_of(typing_context, bundle):
    """Return lane 0 of the bundle at an address."""

    def codegen(context, builder, signature, args):
        lane = cgutils.create_struct_proxy(signature.return_type)(context, builder)
        lane.bundle, lane.header = args[0], _copied(builder, args[0], 8 * HEADER_WORDS)
        lane.number = ir.IntType(64)(0)
        return lane._getvalue()

    return LaneType()(types.voidptr), codegen


@intrinsic
def _lane_at(typing_context, lanes, number):
    """Return another lane of the same bundle."""

    def codegen(context, builder, signature, args):
        lane = cgutils.create_struct_proxy(signature.return_type)(context, builder, args[0])
        lane.number = args[1]
        return lane._getvalue()

    return LaneType()(lanes, types.uint64), codegen


@intrinsic
def table_at(typing_context, lanes, offset, dtype):
    """Return the table of a record type at an offset in the arena."""
    kind = TableType(dtype.dtype.dtype)

    def codegen(context, builder, signature, args):
        arena = builder.load(_lane_pointer(context, builder, lanes, args[0], "arena"))
        address = builder.inttoptr(builder.add(arena, args[1]), ir.IntType(8).as_pointer())
        table = cgutils.create_struct_proxy(kind)(context, builder)
        table.address = _copied(builder, address, kind.dtype.itemsize)
        return table._getvalue()

    return kind(lanes, types.int64, dtype), codegen


def _numbered(kind):
    """Return intrinsics that read and write a carried field by its number in CARRIED, as this type."""

    def pointer(context, builder, lane, number):
        parts = cgutils.create_struct_proxy(LaneType())(context, builder, lane)
        words = _pointer(context, builder, parts.bundle, 8 * CARRIED_WORDS, kind)
        first = builder.mul(number, ir.Constant(ir.IntType(64), PITCH))
        return builder.gep(words, [builder.add(first, parts.number)], inbounds=True)

    @intrinsic
    def read(typing_context, lane, number):
        def codegen(context, builder, signature, args):
            return builder.load(pointer(context, builder, *args))

        return kind(lane, types.int64), codegen

    @intrinsic
    def write(typing_context, lane, number, value):
        def codegen(context, builder, signature, args):
            builder.store(args[2], pointer(context, builder, *args[:2]))
            return context.get_dummy_value()

        return types.void(lane, types.int64, kind), codegen

    return read, write


def _own_memory(count):
    """Return a function that returns the address of `count` words of its caller's own."""

    @intrinsic
    def own_memory(typing_context):
        def codegen(context, builder, signature, args):
            memory = cgutils.alloca_once(builder, ir.IntType(64), size=ir.IntType(64)(count))
            return builder.ptrtoint(memory, ir.IntType(64))

        return types.int64(), codegen

    return own_memory


@intrinsic
def added(typing_context, totals, amounts):
    """Return the sums of two tuples of integers, term by term.

    One integer stands for a tuple of one, None for an empty tuple.
    """
    many = isinstance(amounts, types.BaseTuple)
    terms = tuple(amounts) if many else () if amounts == types.none else (amounts,)
    _check_amounts(len(totals), terms, [isinstance(term, types.Integer | types.Boolean) for term in terms])
    result = types.UniTuple(types.int64, len(totals))

    def codegen(context, builder, signature, args):
        before = cgutils.unpack_tuple(builder, args[0], len(totals))
        given = cgutils.unpack_tuple(builder, args[1], len(terms)) if many else [args[1]] * len(terms)
        added = [
            builder.add(total, context.cast(builder, term, kind, types.int64))
            for total, term, kind in zip(before, given, terms, strict=True)
        ]
        return context.make_tuple(builder, result, added)

    return result(totals, amounts), codegen


def _check_amounts(count: int, amounts, are_integers) -> None:
    """Raise TypeError unless a body returned as many integers as its sums take."""
    if len(amounts) != count:
        cure = "return one integer for each argument of `sums`"
        raise TypeError(f"the body returns {len(amounts)} amounts, its sums take {count}: {cure}")
    for amount, is_integer in zip(amounts, are_integers, strict=True):
        if not is_integer:
            raise TypeError(f"the body returns {amount}, not an integer: return `limbs` of a weight")


class PlainLane:
    """A lane in plain Python (NUMBA_DISABLE_JIT=1)."""

    def __init__(self, bundle, number: int) -> None:
        vars(self).update(_bundle=bundle, _number=number)

    def __getattr__(self, name: str):
        if name == "number":
            return vars(self)["_number"]
        if name in PARTS:
            word, shift, length = PARTS[name]
            return (getattr(self, word) >> shift) & ((1 << length) - 1)
        value = getattr(vars(self)["_bundle"], name)
        return value if name in HEADER else value[vars(self)["_number"]]

    def __setattr__(self, name: str, value) -> None:
        bundle = vars(self)["_bundle"]
        if name in PARTS:
            word, shift, length = PARTS[name]
            others = getattr(self, word) & ~(((1 << length) - 1) << shift)
            name, value = word, others | (int(value) << shift)
        if name in HEADER:
            if name not in COUNTERS:
                raise TypeError(f"{name} is constant in a batch; a word that counts stands in COUNTERS")
            setattr(bundle, name, value)
        else:
            getattr(bundle, name)[vars(self)["_number"]] = value


def _plain_numbered(kind):
    """Twin of `_numbered`: kind is a type of NumPy."""

    def words(lane, number):
        return getattr(vars(lane)["_bundle"], LANE_FIELDS[number]).view(kind)

    def read(lane, number):
        return words(lane, number)[vars(lane)["_number"]]

    def write(lane, number, value):
        words(lane, number)[vars(lane)["_number"]] = value

    return read, write


def _plain_own_memory(count):
    """Twin of `_own_memory`: a thread keeps its last arrays until their users have returned."""
    kept = threading.local()

    def own_memory():
        kept.arrays = getattr(kept, "arrays", [])[-8:] + [np.zeros(count, np.int64)]
        return kept.arrays[-1].ctypes.data

    return own_memory


def _plain_lane_at(lanes, number):
    """Twin of `_lane_at`."""
    return PlainLane(vars(lanes)["_bundle"], int(number))


lane_at = _plain_lane_at if config.DISABLE_JIT else _lane_at
own_memory = _plain_own_memory if config.DISABLE_JIT else _own_memory
if config.DISABLE_JIT:
    lane_word, set_lane_word = _plain_numbered(np.int64)
    lane_value, set_lane_value = _plain_numbered(np.float64)
else:
    lane_word, set_lane_word = _numbered(types.int64)
    lane_value, set_lane_value = _numbered(types.float64)


# ---- The form for a bundle: a loop over lanes. A pass runs a copy of one of these functions, with globals of
# its own.


@device
def no_sums(lane, table):
    """Add nothing."""


@device
def nothing(lane, table):
    """Do nothing before a body."""


def body(lane, table):
    """Stand for the body of a pass."""


before, when, sums, other = nothing, None, no_sums, None
NONE, TABLE = (), np.dtype([("unused", "f8")])


def _over_lanes(bundle, offset, first, live):
    """Run the body for every lane, after another body for every lane, and add what it returns."""
    lanes, total = lanes_of(bundle), NONE
    table = table_at(lanes, offset, TABLE)
    for k in range(first, live):
        before(lane_at(lanes, k), table)
    for k in range(first, live):
        total = added(total, body(lane_at(lanes, k), table))
    sums(lane_at(lanes, first), table, *total)
    return live


def _over_listed_lanes(bundle, offset, first, live):
    """Run the body for the lanes that need it, listed without a branch; often none does, or all do."""
    lanes, total = lanes_of(bundle), NONE
    table = table_at(lanes, offset, TABLE)
    needed = uint64(0)
    for k in range(first, live):
        needed += uint64(1) if when(lane_at(lanes, k), table) else uint64(0)
    if needed > 0:
        n = uint64(0)
        if needed == live - first:
            for k in range(first, live):
                lane_at(lanes, k - first).listed = k
        else:
            for k in range(first, live):
                lane_at(lanes, n).listed = k
                n += uint64(1) if when(lane_at(lanes, k), table) else uint64(0)
        for j in range(needed):
            k = uint64(lane_at(lanes, j).listed)
            total = added(total, body(lane_at(lanes, k), table))
        sums(lane_at(lanes, first), table, *total)
    return live


def _over_lanes_unless(bundle, offset, first, live):
    """Run the body for every lane, or another for every lane if any lane needs that one, which is rare."""
    lanes, needed = lanes_of(bundle), False
    table = table_at(lanes, offset, TABLE)
    for k in range(first, live):
        needed |= when(lane_at(lanes, k), table)
    if needed:
        for k in range(first, live):
            other(lane_at(lanes, k), table)
    else:
        for k in range(first, live):
            added(NONE, body(lane_at(lanes, k), table))  # refuses amounts, which nothing would add
    return live


def _over_bundle(bundle, offset, first, live):
    """Run a pass that has the loop itself."""
    lanes = lanes_of(bundle)
    return body(lanes, table_at(lanes, offset, TABLE), first, live)


# ---- A pass.

SIGNATURE = types.int64(types.voidptr, types.int64, types.uint64, types.uint64)


@dataclass(frozen=True)
class Pass:
    """A step of a particle: a body, the record type of its table, and its floating-point options.

    sums: adds the totals of what the body returns, (lane, table, *totals). before: a body that runs first, in
    a loop of its own. when: which lanes need the body, (lane, table) -> bool. unless: which lanes need
    another pass instead, which does the same for the others, and that pass. is_loop: the function is a loop
    over a bundle, (lanes, table, first, live) -> live; alone: its form for one lane.
    """

    function: Callable
    table: np.dtype
    arithmetic: dict = field(default_factory=lambda: ARITHMETIC, compare=False)
    sums: Callable = no_sums
    before: Callable = nothing
    when: Callable | None = None
    unless: tuple | None = None
    is_loop: bool = False
    alone: Callable | None = None

    def __post_init__(self) -> None:
        # What a loop would pass over in silence is refused, and what Numba could not name.
        called = {option: getattr(self, option) for option in ("sums", "before", "when")}
        for option, function in (called | {"unless": self.unless and self.unless[0]}).items():
            if not _is_compiled(function):
                raise TypeError(f"pass {self.name}: decorate the function in `{option}` with @device")
        sums, before = self.sums is not no_sums, self.before is not nothing
        if before and (self.when or self.unless or self.is_loop):
            raise TypeError(f"pass {self.name}: `before` goes with a body for every lane; leave the rest out")
        if self.unless and (sums or self.when):
            raise TypeError(f"pass {self.name}: `unless` takes no `sums` and no `when`; leave them out")
        if self.unless and not (isinstance(self.unless[1], Pass) and self.unless[1].is_body_alone):
            raise TypeError(f"pass {self.name}: the second in `unless` must be a pass, and without options")

    @property
    def is_body_alone(self) -> bool:
        """Whether the pass is its body for every lane, and nothing else."""
        options = self.when, self.unless, self.is_loop, self.sums is not no_sums, self.before is not nothing
        return not any(options)

    @property
    def name(self) -> str:
        """Name of the function."""
        return self.function.__name__

    @property
    def amount_count(self) -> int:
        """Number of integers that the body returns, for its sums."""
        return _plain(self.sums).__code__.co_argcount - 2

    @cached_property
    def fields(self) -> tuple[str, ...]:
        """Names of the lane fields that the pass uses, itself or in functions that it gives the lane to."""
        return tuple(name for name in LANE_FIELDS if name in {*self.reads, *self.writes})

    @cached_property
    def reads(self) -> tuple[str, ...]:
        """Names of those that it reads."""
        return self._named("LOAD_ATTR")

    @cached_property
    def writes(self) -> tuple[str, ...]:
        """Names of those that it writes; not those that it only adds to (`+=`)."""
        return self._named("STORE_ATTR")

    def _named(self, use: str) -> tuple[str, ...]:
        """Return the lane fields that bytecode uses by this instruction."""
        parts = [self.function, self.before, self.sums] + [self.when] * (self.when is not None)
        if self.unless is not None:
            parts += [self.unless[0], self.unless[1].function]
        named = set().union(*(_attributes(_plain(part), use) for part in parts))
        named |= {"listed"} if self.when is not None else set()
        return tuple(name for name in LANE_FIELDS if name in named)

    @cached_property
    def inlined(self):
        """The body as a compiled function, inlined where it is called."""
        return njit(forceinline=True, **self.arithmetic)(self.function)

    @cached_property
    def loop(self) -> FunctionType:
        """The loop over a bundle as a Python function, under the name of the pass."""
        loop, when, other = _over_bundle if self.is_loop else _over_lanes, self.when, None
        if self.when is not None:
            loop = _over_listed_lanes
        elif self.unless is not None:
            loop, when, other = _over_lanes_unless, self.unless[0], self.unless[1].inlined
        own = {"body": self.inlined, "before": self.before, "sums": self.sums, "when": when, "other": other}
        own |= {"NONE": (0,) * self.amount_count, "TABLE": self.table}
        # Under the file, line and name of the body it is kept on disk and named in messages: all of it stands
        # on one line.
        at = self.function.__code__
        code = loop.__code__.replace(
            co_filename=at.co_filename, co_firstlineno=at.co_firstlineno, co_linetable=b""
        )
        function = FunctionType(code, loop.__globals__ | own, self.name)
        function.__qualname__, function.__doc__ = self.function.__qualname__, self.function.__doc__
        function.__module__ = self.function.__module__
        return function

    @cached_property
    def compiled(self):
        """The C callback, compiled now or loaded from disk."""
        try:
            with cached_kernels():
                return cfunc(SIGNATURE, cache=True, **self.arithmetic)(self.loop)
        except (NumbaError, TypeError) as error:
            error.add_note(f"This was the pass {self.name}, {self.function.__module__}.")
            raise

    @property
    def entry(self):
        """Address of the callback for the driver, or a Python function of this name without compilation."""
        if not config.DISABLE_JIT:
            return self.compiled.address

        def run(bundle, offset, first, live):
            table = view(bundle.arena + offset, 1, self.table)[0]
            return self.run_plainly(bundle, table, first, live)

        run.__name__ = self.name
        return run

    def run_plainly(self, bundle, table, first: int, live: int) -> int:
        """Run the pass as plain Python on records; return the number of live lanes."""
        if self.is_loop:
            return self.function(PlainLane(bundle, 0), table, first, live)
        lanes = [PlainLane(bundle, number) for number in range(first, live)]
        if self.unless is not None and any(_plain(self.unless[0])(lane, table) for lane in lanes):
            return self.unless[1].run_plainly(bundle, table, first, live)
        if self.when is not None:
            lanes = [lane for lane in lanes if _plain(self.when)(lane, table)]
        for lane in lanes:
            _plain(self.before)(lane, table)
        totals = [0] * self.amount_count
        for lane in lanes:
            amounts = self.function(lane, table)
            terms = amounts if isinstance(amounts, tuple) else () if amounts is None else (amounts,)
            _check_amounts(len(totals), terms, [isinstance(term, INTEGERS) for term in terms])
            totals = [total + int(term) for total, term in zip(totals, terms, strict=True)]
        if lanes:
            self.sums(bundle, table, *totals)
        return live


LANES_IN_CODE = frozenset({"lane", "lanes", "walk"})  # names of variables that are lanes
LISTS = "listed", "movers"  # fields that hold a list of lanes


def _plain(function: Callable) -> Callable:
    """Return the Python function of a compiled one."""
    return getattr(function, "py_func", function)


def _is_compiled(function: Callable | None) -> bool:
    """Return whether a pass can call a function, in the loop that is compiled."""
    return function is None or config.DISABLE_JIT or hasattr(function, "py_func")


def called_by(function: FunctionType) -> dict[str, object]:
    """Return what a function may call, by name: globals and what it closes over."""
    names = {step.argval for step in dis.get_instructions(function) if step.opname == "LOAD_GLOBAL"}
    space, closed = function.__globals__, function.__code__.co_freevars
    called = {name: space[name] for name in sorted(names & space.keys())}
    cells = zip(closed, function.__closure__ or (), strict=True)
    return called | {name: cell.cell_contents for name, cell in cells}


def _takes_lane(code) -> bool:
    """Return whether a function has a lane among its arguments."""
    return not LANES_IN_CODE.isdisjoint(code.co_varnames[: code.co_argcount])


def _last_loaded(step: dis.Instruction) -> object:
    """Return what an instruction loads last: newer versions of Python load two variables by one."""
    return step.argval[-1] if isinstance(step.argval, tuple) else step.argval


def _attributes(function: FunctionType, use: str) -> set[str]:
    """Return the attributes of lanes that a function, and those that it calls, use by this instruction."""
    steps = [step for step in dis.get_instructions(function) if step.opname != "COPY"]
    named = {
        after.argval
        for before, after in itertools.pairwise(steps)
        if after.opname == use and _last_loaded(before) in LANES_IN_CODE
    }
    named |= {PARTS[name][0] for name in named & set(PARTS)}
    named |= {step.argval for step in steps if step.argval in LISTS}
    for called in map(_plain, called_by(function).values()):
        if isinstance(called, FunctionType) and _takes_lane(called.__code__):
            named |= _attributes(called, use)
    return named


def lane_pass(
    table: np.dtype,
    arithmetic: dict = ARITHMETIC,
    sums: Callable = no_sums,
    before: Callable = nothing,
    when: Callable | None = None,
    unless: tuple[Callable, Pass] | None = None,
):
    """Return a decorator that makes a body, (lane, table), a pass whose table has this record type."""
    if not isinstance(table, np.dtype):
        raise TypeError("lane_pass takes the record type of a table: write @lane_pass(layout.NO_TABLE)")
    return lambda function: Pass(function, table, arithmetic, sums, before, when, unless)


def bundle_pass(table: np.dtype, arithmetic: dict = ARITHMETIC, alone: Callable | None = None):
    """Return a decorator that makes a loop over a bundle a pass: (lanes, table, first, live) -> live."""
    return lambda function: Pass(function, table, arithmetic, is_loop=True, alone=alone)
