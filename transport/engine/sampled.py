"""Passes that draw from nets instead of random words: the same loops, which call other words by the same names.

A pass is a function with globals.  Its twin has the same code and other globals, where `random_words` and `event_words`
are those of physics/sobol.py, and device functions that call them are twins as well.  So no loop is written twice, none
asks how it draws, and a program of random numbers holds nothing of this.  A twin's name tells Numba's cache, and a reader,
which it is; it runs as plain Python too.
"""

import dis
from dataclasses import replace
from functools import cache
from types import FunctionType

from transport.engine.passes import Pass
from transport.engine.registry import Step
from transport.physics.device import device
from transport.physics.sobol import net_event_words, sobol_words, stratified_words
from transport.physics.streams import event_words, random_words

WORDS = {
    "sobol": {random_words: sobol_words, event_words: net_event_words},
    "stratified": {random_words: stratified_words, event_words: net_event_words},
}


def sampled_steps(steps: list[Step], sampling: str) -> list[Step]:
    """The same steps, with draws as a sampling makes them."""
    return [(sampled(lane_pass, sampling), table) for lane_pass, table in steps]


@cache
def sampled(lane_pass: Pass, sampling: str) -> Pass:
    """The twin of a pass; the pass itself where it draws nothing."""
    drawing = _drawing(lane_pass.function, sampling)
    return replace(lane_pass, function=_twin(lane_pass.function, drawing, sampling)) if drawing else lane_pass


@cache
def _twin_of_device(function, sampling: str):
    """What a loop calls instead of this; None where it may stay."""
    if function in WORDS[sampling]:
        return WORDS[sampling][function]
    python = getattr(function, "py_func", function)
    if not isinstance(python, FunctionType) or not python.__module__.startswith("transport."):
        return None
    drawing = _drawing(python, sampling)
    return device(_twin(python, drawing, sampling)) if drawing else None


def _drawing(function: FunctionType, sampling: str) -> dict[str, object]:
    """Of the globals that a function's code loads, those that draw, with what they shall be."""
    names = {step.argval for step in dis.get_instructions(function) if step.opname == "LOAD_GLOBAL"}
    known = {name: function.__globals__.get(name) for name in sorted(names)}
    twins = {name: _twin_of_device(value, sampling) for name, value in known.items() if callable(value)}
    return {name: twin for name, twin in twins.items() if twin is not None}


def _twin(function: FunctionType, drawing: dict[str, object], sampling: str) -> FunctionType:
    """The function among other globals, under a name of its own."""
    twin = FunctionType(
        function.__code__, function.__globals__ | drawing, f"{function.__name__} by {sampling}"
    )
    twin.__qualname__, twin.__doc__ = twin.__name__, function.__doc__
    return twin
