"""Conversions between whole and real numbers: the same digits on processors with and without an instruction for vectors of them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import config, njit

from transport.physics import bits

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="plain Python has int and float")
LARGEST = 2**52 - 1
WHOLES = [0, 1, 2, 2**31 - 1, 2**32, 2**51 + 1, LARGEST]
REALS = [
    0.0,
    5e-324,
    2.0**-60,
    0.5,
    1 - 2.0**-53,
    1.0,
    1.5,
    np.nextafter(2.0, 0),
    2.0**32 - 2.0**-20,
    2.0**51 + 0.5,
    float(LARGEST),
]


def to_whole(x):
    return bits.whole(x)


def to_real(whole):
    return bits.real(whole)


@pytest.mark.parametrize("converts", [True, False], ids=["by an instruction", "by adding 2^52"])
def test_conversions_are_those_of_python(converts, monkeypatch):
    monkeypatch.setattr(bits, "CONVERTS_VECTORS", converts)
    whole, real = njit(to_whole), njit(to_real)
    drawn = np.random.default_rng(1).random(1000) * 2.0 ** np.random.default_rng(2).integers(-40, 52, 1000)
    for x in (*REALS, *drawn.tolist()):
        assert whole(x) == int(x)
    for number in (*WHOLES, *np.random.default_rng(3).integers(0, LARGEST, 1000).tolist()):
        assert real(number) == float(number)
