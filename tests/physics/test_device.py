"""Sums of products are rounded as the source says: fused within an expression, and nowhere else, however functions are inlined."""

from __future__ import annotations

from fractions import Fraction

import pytest
from numba import config, njit

from transport.physics.device import ARITHMETIC, EXACT, device

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="plain Python rounds every product")
A, B, C, D = 8.4, 3.16, 7.95, 6.22  # of which all sums below are rounded otherwise if fused


@device
def product(a, b):
    return a * b


def plus(a, b, c, d):
    return a * b + c


def added_first(a, b, c, d):
    return c + a * b


def minus(a, b, c, d):
    return a * b - c


def subtracted(a, b, c, d):
    return c - a * b


def in_place(a, b, c, d):
    c -= a * b
    return c


def of_two_products(a, b, c, d):
    return a * b + c * d


def named(a, b, c, d):
    w = a * b
    return w + c


def of_a_function(a, b, c, d):
    return product(a, b) + c


def exact(value: Fraction) -> float:
    return value.numerator / value.denominator  # correctly rounded


FUSED = {
    plus: exact(Fraction(A) * Fraction(B) + Fraction(C)),
    added_first: exact(Fraction(A) * Fraction(B) + Fraction(C)),
    minus: exact(Fraction(A) * Fraction(B) - Fraction(C)),
    subtracted: exact(Fraction(C) - Fraction(A) * Fraction(B)),
    in_place: exact(Fraction(C) - Fraction(A) * Fraction(B)),
    of_two_products: exact(Fraction(A * B) + Fraction(C) * Fraction(D)),
}


@pytest.mark.parametrize("function", FUSED, ids=lambda function: function.__name__)
def test_a_product_within_an_expression_is_fused(function):
    assert njit(**ARITHMETIC)(function)(A, B, C, D) == FUSED[function] != function(A, B, C, D)


@pytest.mark.parametrize("function", [named, of_a_function], ids=lambda function: function.__name__)
def test_no_other_product_is_fused(function):
    """As LLVM would where it may, after inlining."""
    assert njit(**ARITHMETIC)(function)(A, B, C, D) == A * B + C != FUSED[plus]


@pytest.mark.parametrize("function", [plus, minus, subtracted], ids=lambda function: function.__name__)
def test_exact_passes_fuse_nothing(function):
    assert njit(**EXACT)(function)(A, B, C, D) == function(A, B, C, D)


def test_integers_are_left_alone():
    assert njit(**ARITHMETIC)(plus)(2, 3, 4, 5) == 10
