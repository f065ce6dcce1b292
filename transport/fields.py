"""Types of fields that accept more than they store.

A list, an array or a single object becomes a tuple of floats or parts. `Converted[Given, Kept]` tells a type
checker what the constructor accepts and what the attribute is. The checker sees a descriptor; at run time the
type is that of the attribute, or a third one: the type in the JSON file of a scene.
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
        """A field that accepts Given and stores Kept."""

        def __get__(self, instance: object, owner: Any = None) -> Kept: ...
        def __set__(self, instance: object, value: Given) -> None: ...

    class ConvertedAs(Converted[Given, Kept], Generic[Given, Kept, Written]):
        """A field that accepts Given, stores Kept and is Written to the JSON file of a scene."""

else:

    class Converted:
        """A field whose type at run time is the last one listed."""

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
