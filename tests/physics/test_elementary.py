"""Our own log, exp, sin, cos and atan against mpmath: errors in units of the last place (ulp) of the exact value.

The limits were measured (in brackets) over dense and hard points and rounded up; a series one term short or a
constant wrong in its last digits goes beyond them by orders.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from transport.physics.elementary import (
    EXP_LEAST,
    atan_unit,
    azimuth_turn,
    cos_sin_turn,
    exp_negative,
    expm1_negative,
    log1p,
    log_positive,
    sin_quarter,
)

PRECISION = 130  # bits of the exact values
SMALLEST_NORMAL, LARGEST = 2.0**-1022, np.finfo(float).max
ONE_BELOW, ONE_ABOVE = 1 - 2.0**-53, 1 + 2.0**-52
SIN_ULP = 3.0  # 2.3
AZIMUTH_ULP = 4.0  # 2.6 in the first quarter
AZIMUTH_ABSOLUTE = 2.0**-52  # 1.1 x 2^-53 in the others, beside a turn of 1
MANY = {"deadline": None, "derandomize": True}

some_floats = {"allow_nan": False, "allow_infinity": False}
log_of, log1p_of, exp_of, expm1_of, sin_of, atan_of, azimuth_of = (
    np.vectorize(function, otypes=[float])
    for function in (log_positive, log1p, exp_negative, expm1_negative, sin_quarter, atan_unit, azimuth_turn)
)
cos_sin_of = np.vectorize(cos_sin_turn, otypes=[float, float])


def in_ulp(values, exact) -> float:
    """Largest error in units of the last place of the exact value; infinite where 0 is missed."""

    def of(value, exact):
        if exact == 0:
            return 0.0 if value == 0 else math.inf
        return float(abs(mp.mpf(float(value)) - exact)) / math.ulp(float(exact))

    return max(of(value, e) for value, e in zip(np.ravel(values), exact, strict=True))


def exactly(function, points):
    with mp.workprec(PRECISION):
        return [function(mp.mpf(float(x))) for x in points]


def sine(turn):
    return mp.sinpi(2 * turn)


def cosine(turn):
    return mp.cospi(2 * turn)


def towards(point, side, decades=16, count=60):
    """Points on one side of a point, closer and closer."""
    return point + side * 10.0 ** np.linspace(-decades, -1, count)


def grid_turns(count, seed):
    """Turns as `uniform` and `short_uniform` draw them: multiples of 2^-52 and of 2^-33, in [0, 1)."""
    rng = np.random.default_rng(seed)
    fine, coarse = (
        rng.integers(0, 1 << 52, count) * 2.0**-52,
        (rng.integers(0, 1 << 32, count) + 0.5) * 2.0**-32,
    )
    quarters = np.arange(4) / 4
    near = [q + k * 2.0**-52 for q in quarters for k in (0, 1, 2, 3, 1000)]
    near += [q - k * 2.0**-52 for q in (*quarters[1:], 1.0) for k in (1, 2, 3, 1000)]
    return np.concatenate((fine, coarse, near))


def depths(seed):
    """Non-positive exponents of all magnitudes, many beside the seams at half multiples of ln 2."""
    rng = np.random.default_rng(seed)
    seams = np.outer(-math.log(2) * (np.arange(20) + 0.5), 1 + np.arange(-3, 4) * 2.0**-52).ravel()
    decades = -(10 ** np.concatenate((rng.uniform(-300, -2, 400), rng.uniform(-18, 2.85, 1500))))
    return np.concatenate((rng.uniform(-3, 0, 1500), decades, seams, [0.0, -0.0, -0.5, -1.0, -64.0]))


def points_of(name):
    """Dense and hard points of a function's range."""
    rng = np.random.default_rng(1)
    match name:
        case "log":
            near = np.concatenate(
                (towards(1, -1), towards(1, 1, 15), math.sqrt(0.5) + np.arange(-30, 31) * 2.0**-53)
            )
            powers = np.ldexp(1.0, np.arange(-1022, 1024, 31))
            hard = [SMALLEST_NORMAL, ONE_BELOW, ONE_ABOVE, 1.0, 2.0**-33, 2.0**-52, LARGEST]
            return np.concatenate(
                (rng.uniform(0, 2, 1500), 10 ** rng.uniform(-307.6, 308, 1500), near, powers, hard)
            )
        case "log1p":
            little = 10 ** rng.uniform(-300, -0.5, 1000)
            hard = [0.0, -0.5, 1.0, 2.0**-53, -(2.0**-53), -ONE_BELOW, LARGEST, 1e16, 2.0**53 + 1]
            return np.concatenate(
                (little, -little, rng.uniform(-1, 4, 1000), 10 ** rng.uniform(0, 300, 300), hard)
            )
        case "exp":
            return np.concatenate((depths(seed=21), [EXP_LEAST, EXP_LEAST + 2.0**-43, -700.1]))
        case "expm1":
            return depths(seed=22)
        case "sin":
            tiny = 10.0 ** np.linspace(-300, -2, 100)
            return np.concatenate(
                (np.linspace(0, 0.25, 2001), rng.uniform(0, 0.25, 1000), tiny, 0.25 - tiny[80:])
            )
        case "atan":
            seam = math.sqrt(2) - 1 + np.arange(-200, 201) * 2.0**-30
            hard = [0.0, 1.0, ONE_BELOW, 5e-324, SMALLEST_NORMAL, 2.0**-52]
            return np.concatenate(
                (rng.uniform(0, 1, 2000), 10 ** rng.uniform(-300, 0, 500), seam, towards(1, -1), hard)
            )


@pytest.mark.parametrize(
    ("name", "function", "exact", "limit"),
    [
        ("log", log_of, mp.log, 1.5),  # 0.89
        ("log1p", log1p_of, mp.log1p, 1.5),  # 1.0
        ("exp", exp_of, mp.exp, 1.5),  # 0.94
        ("expm1", expm1_of, mp.expm1, 1.5),  # 1.06
        ("sin", sin_of, sine, SIN_ULP),
        ("atan", atan_of, mp.atan, 3.0),  # 2.4
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_functions_are_good_to_the_last_places(name, function, exact, limit):
    points = points_of(name)
    assert in_ulp(function(points), exactly(exact, points)) <= limit


def test_special_values_are_exact():
    """Beyond the normal numbers an exponential is 0, and NaN stays NaN."""
    assert log_of(1.0) == 0
    assert (exp_of([0.0, -0.0]) == 1.0).all() and exp_of(EXP_LEAST) >= SMALLEST_NORMAL
    assert (
        exp_of([np.nextafter(EXP_LEAST, -math.inf), -745.0, -746.0, -1e9, -1e308, -math.inf]) == 0.0
    ).all()
    assert (expm1_of([-38.0, -1e9, -1e308, -math.inf]) == -1.0).all()
    assert math.isnan(exp_negative(math.nan)) and math.isnan(expm1_negative(math.nan))
    points = points_of("sin")
    assert (sin_of(-points) == -sin_of(points)).all()


def test_a_series_one_term_short_would_be_seen():
    """It misses the quarter turn by 6e-12, 27 000 ulp."""
    points = points_of("sin")
    x = points * 2 * np.pi
    short = sum((-1) ** k * x ** (2 * k + 1) / math.factorial(2 * k + 1) for k in range(8))
    assert in_ulp(short, exactly(sine, points)) > 1000 * SIN_ULP


def test_a_forced_path_through_a_thin_medium_keeps_its_digits():
    """-ln(1 - u (1 - exp(-tau))) of tau = 1e-9, 1e-300, 30: of 1 - exp(-tau) by subtraction 8 digits would be left."""
    u = np.linspace(0.01, 0.99, 99)
    for tau in (1e-300, 1e-9, 1e-3, 1.0, 30.0):
        found = -log1p_of(u * expm1_of(np.full_like(u, -tau)))
        exact = exactly(lambda x, t=tau: -mp.log1p(x * mp.expm1(-mp.mpf(t))), u)
        assert max(abs(f / e - 1) for f, e in zip(found, exact, strict=True)) <= 64 * 2.0**-52


def test_cosine_and_sine_of_drawn_turns_are_good_to_a_few_places():
    """Of all turns that a draw can give, relative to the exact values: 0 is 0 and quarter turns are exact."""
    turns = grid_turns(1000, seed=3)
    c, s = cos_sin_of(turns)
    assert in_ulp(c, exactly(cosine, turns)) <= SIN_ULP
    assert in_ulp(s, exactly(sine, turns)) <= SIN_ULP
    assert np.abs(c * c + s * s - 1).max() <= 12 * 2.0**-53
    c, s = cos_sin_of(np.array([0, 0.25, 0.5, 0.75]))
    assert np.abs(c - [1, 0, -1, 0]).max() <= 2.0**-52
    assert np.abs(s - [0, 1, 0, -1]).max() <= 2.0**-52


@settings(max_examples=50, **MANY)
@given(st.floats(0, 1, exclude_max=True, **some_floats))
@example(5e-324)
@example(ONE_BELOW)
@example(0.25 - 2.0**-54)
@example(0.5 - 2.0**-54)
def test_cosine_and_sine_of_any_turn_are_good_absolutely(turn):
    """A turn finer than 2^-53 is rounded to it: 2 pi 2^-53 of error beside the polynomial's own."""
    c, s = cos_sin_of(np.array([turn]))
    limit = (SIN_ULP + 2 * math.pi) * 2.0**-53
    assert abs(mp.mpf(float(c[0])) - exactly(cosine, [turn])[0]) <= limit
    assert abs(mp.mpf(float(s[0])) - exactly(sine, [turn])[0]) <= limit


def azimuth_error(x, y):
    """Error [turns] of the azimuth, the shorter way round, and the exact azimuth."""
    with mp.workprec(PRECISION):
        exact = (mp.atan2(mp.mpf(y), mp.mpf(x)) / (2 * mp.pi)) % 1
        error = mp.mpf(float(azimuth_of(np.array([x]), np.array([y]))[0])) - exact
        return abs(float(error - mp.nint(error))), float(exact)


AZIMUTHS = [
    (0, 0, 0), (-0.0, 0.0, 0), (0.0, -0.0, 0), (1, 0, 0), (0, 1, 0.25), (-1, 0, 0.5), (0, -1, 0.75),
    (1, 1, 0.125), (-1, 1, 0.375), (-1, -1, 0.625), (1, -1, 0.875), (5e-324, 5e-324, 0.125),
    (-1e308, -1e308, 0.625), (1e308, 1e-308, 0), (1e-308, -1e308, 0.75), (-1, 5e-324, 0.5),
    (-1, -5e-324, 0.5), (1, -5e-324, 0), (1, -1e-18, 0), (0.0, 5e-324, 0.25),
]  # fmt: skip


def test_azimuths_of_axes_diagonals_and_extremes():
    x, y, turn = np.transpose(AZIMUTHS)
    np.testing.assert_allclose(azimuth_of(x, y), turn, rtol=0, atol=1e-16)


@settings(max_examples=100, **MANY)
@given(st.floats(**some_floats), st.floats(**some_floats))
@example(1.0, -1e-17)
@example(1.0, -1e-16)
@example(-1.0, 1e-17)
@example(2.3666509394114356e-277, 4.1535685386806697e-281)
def test_azimuth_of_any_components_lies_in_the_turn(x, y):
    """Good to a few places in the first quarter, absolutely in the others; never 1."""
    turn = azimuth_of(np.array([x]), np.array([y]))[0]
    assert 0 <= turn < 1
    if x == y == 0:
        return
    error, exact = azimuth_error(x, y)
    assert error <= AZIMUTH_ABSOLUTE
    # A ratio below the normal numbers has fewer digits.
    if 1e-290 < exact < 0.25:
        assert error <= AZIMUTH_ULP * math.ulp(exact)


def test_azimuth_is_good_over_all_directions_and_magnitudes():
    rng = np.random.default_rng(5)
    radius, angle = 10 ** rng.uniform(-250, 250, 1000), rng.uniform(0, 2 * np.pi, 1000)
    signs = rng.choice([-1, 1], (2, 1000))
    x, y = np.concatenate(
        (radius * (np.cos(angle), np.sin(angle)), 10 ** rng.uniform(-9, 9, (2, 1000)) * signs), axis=1
    )
    errors = [azimuth_error(*pair) for pair in zip(x, y, strict=True)]
    assert max(error for error, _ in errors) <= AZIMUTH_ABSOLUTE
    assert max(error / math.ulp(exact) for error, exact in errors if exact < 0.25) <= AZIMUTH_ULP
