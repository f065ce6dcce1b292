"""Twins of passes: the same code with Sobol, stratified or guided words in place of random words.

A pass is made of functions with globals. Its twin has the same code and other globals, in which what draws a
block (`random_words`, `begin_block` and others of physics/streams.py) draws the words of physics/sobol.py,
and device functions that call it are twins too. So no loop exists twice, none tests how it samples, and a
pseudo-random program contains nothing of this. The twin's name distinguishes it in Numba's cache and for
readers; it runs as plain Python too.
"""

import copyreg
from dataclasses import replace
from functools import cache
from types import CellType, FunctionType

from transport.engine.bodies import called_by
from transport.engine.passes import guides
from transport.engine.registry import PASSES, Pass, Step
from transport.engine.words import birth_block, words_in_block, words_of_block
from transport.physics.device import device
from transport.physics.sobol import net_event_words, sobol_words, stratified_words
from transport.physics.streams import (
    DIRECTION,
    POSITION,
    begin_block,
    begin_event_block,
    end_block,
    event_words,
    packed,
    random_words,
    unpacked,
)


def _whole_block(words):
    """Return the twin of `begin_block`: it returns whole words, which need no end."""

    @device
    def begin_whole_block(history, batch, event, purpose, seed_low, seed_high):
        w0, w1, w2, w3 = words(history, batch, event, purpose, seed_low, seed_high)
        return packed(w0, w1, w2, w3)

    return begin_whole_block


@device
def end_whole_block(first, second, seed_low, seed_high):
    """Return the words of a whole block."""
    return unpacked(first, second)


def twins_of_words(at_birth, later):
    """Return {function that draws: its twin}."""
    begun = {begin_block: _whole_block(at_birth), begin_event_block: _whole_block(later)}
    return {random_words: at_birth, event_words: later, end_block: end_whole_block} | begun


WORDS = {
    "sobol": twins_of_words(sobol_words, net_event_words),
    "stratified": twins_of_words(stratified_words, net_event_words),
}


GUIDED = "guide"


@cache
def _guided_words():
    """Return the twins of what draws the numbers of a birth: they take those of its guide."""
    blocks = {POSITION: guides.place_block, DIRECTION: guides.direction_block}
    return {birth_block(purpose): block for purpose, block in blocks.items()} | {
        words_of_block: words_in_block
    }


def quasi_random_steps(steps: list[Step], sampling: str) -> list[Step]:
    """Return the same steps with draws by this sampling."""
    return [(quasi_random_twin(lane_pass, sampling), table) for lane_pass, table in steps]


@cache
def quasi_random_twin(lane_pass: Pass, sampling: str) -> Pass:
    """Return the twin of a pass; the pass itself if it draws nothing."""
    drawing = _drawing(lane_pass.function, sampling)
    if not drawing:
        return lane_pass
    options = {name: getattr(lane_pass, name) for name in ("before", "when", "sums", "alone")}
    twins = {name: _twin_of_device(option, sampling) or option for name, option in options.items()}
    return replace(lane_pass, function=_twin(lane_pass.function, drawing, sampling), **twins)


def pass_by_name(name: str) -> Pass:
    """Return the pass, or twin of a pass, of this name."""
    name, _, sampling = name.partition(" by ")
    return quasi_random_twin(PASSES[name], sampling) if sampling else PASSES[name]


copyreg.pickle(Pass, lambda lane_pass: (pass_by_name, (lane_pass.name,)))


@cache
def _twin_of_device(function, sampling: str):
    """Return the function that a twin calls instead of this one; None if it needs no replacement."""
    words = _guided_words() if sampling == GUIDED else WORDS[sampling]
    if function in words:
        return words[function]
    python = getattr(function, "py_func", function)
    if not isinstance(python, FunctionType) or not python.__module__.startswith("transport."):
        return None
    drawing = _drawing(python, sampling)
    return device(_twin(python, drawing, sampling)) if drawing else None


def _drawing(function: FunctionType, sampling: str) -> dict[str, object]:
    """Return {name: replacement} of what a function calls that draws."""
    called = {name: value for name, value in called_by(function).items() if callable(value)}
    twins = {name: _twin_of_device(value, sampling) for name, value in called.items()}
    return {name: twin for name, twin in twins.items() if twin is not None}


def _twin(function: FunctionType, drawing: dict[str, object], sampling: str) -> FunctionType:
    """Return the function that calls other ones, under its own name."""
    name, code = f"{function.__name__} by {sampling}", function.__code__
    cells = zip(code.co_freevars, function.__closure__ or (), strict=True)
    closure = tuple(CellType(drawing[of]) if of in drawing else cell for of, cell in cells) or None
    twin = FunctionType(code, function.__globals__ | drawing, name, closure=closure)
    twin.__qualname__, twin.__doc__ = twin.__name__, function.__doc__
    return twin
