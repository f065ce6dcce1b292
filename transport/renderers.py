"""Functions of higher layers that objects of lower layers call by name, to save or to display an object.

A package may import only packages below it.  `Estimate._repr_html_` needs a function of `io`, which is above:
it finds the function here, by its own type and a verb.  The table is filled when `transport` is imported
(`transport/__init__.py`) with names of functions, and a function's module is loaded at its first use.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module

_FUNCTIONS: dict[tuple[str, str], str] = {}


def register(verb: str, functions: Mapping[str, str]) -> None:
    """Enter functions of one verb, such as "html".

    Parameters
    ----------
    verb : str
        What is done with the object.
    functions : mapping of str to str
        "module:function" by the name of the object's class; a class inherits those of its bases.
    """
    _FUNCTIONS.update({(name, verb): function for name, function in functions.items()})


def function_for(kind: type, verb: str) -> Callable:
    """Return the function that does this with objects of a type.

    Raises
    ------
    LookupError
        If neither the type nor one of its bases has such a function.
    """
    for base in kind.__mro__:
        if (base.__name__, verb) in _FUNCTIONS:
            module, _, name = _FUNCTIONS[base.__name__, verb].partition(":")
            return getattr(import_module(module), name)
    raise LookupError(f"no function is registered for {kind.__name__} and {verb!r}")
