"""Types of fields that take more than they keep: a list, an array or a single object becomes a tuple of floats or parts.

`Converted[Given, Kept]` tells a type checker what the constructor takes and what the attribute is.  The checker sees a
descriptor; at run time there is none, and the type is that of what is kept, or a third one: what a file of a scene holds
(written/schema.py reads it).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from transport.vectors import Vector

Part = TypeVar("Part")
Bins = int | tuple[float, ...]  # a number of equal bins, or edges

if TYPE_CHECKING:
    from typing import Generic

    Given = TypeVar("Given", contravariant=True)
    Kept = TypeVar("Kept", covariant=True)
    Written = TypeVar("Written")

    class Converted(Generic[Given, Kept]):
        """A field that takes what is Given and keeps it as Kept."""

        def __get__(self, instance: object, owner: Any = None) -> Kept: ...
        def __set__(self, instance: object, value: Given) -> None: ...

    class ConvertedAs(Converted[Given, Kept], Generic[Given, Kept, Written]):
        """The same, where a file of a scene holds what is Written."""

else:

    class Converted:
        """A field whose type at run time is the last one named."""

        def __class_getitem__(cls, types: tuple[object, ...]) -> object:
            return types[-1]

    ConvertedAs = Converted


VectorField = Converted[Iterable[float], Vector]
OptionalVector = Converted[Iterable[float] | None, Vector | None]
Lengths = ConvertedAs[Iterable[float] | float, Vector, Vector | float]  # one for all axes, or three
Numbers = Converted[Iterable[float], tuple[float, ...]]
OptionalNumbers = Converted[Iterable[float] | None, tuple[float, ...] | None]
BinsField = Converted[int | Iterable[float], Bins]
OptionalBins = Converted[int | Iterable[float] | None, Bins | None]
ArrayField = Converted[ArrayLike, np.ndarray]
Parts = Converted[Iterable[Part] | Part, tuple[Part, ...]]
