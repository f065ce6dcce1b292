"""log, exp, sin and cos as own polynomials: calls of libm would keep a lane loop from being vectorised.

Coefficients of the logarithm and the arc tangent: Cephes (Moshier 1989); of the exponential and the sine:
fitted by Remez's algorithm in 50 digits. Errors against mpmath: tests/physics/test_elementary.py.
"""

from numba import int64, uint64

from transport.physics.bits import bits_of, float_of, real
from transport.physics.device import device

TWO_PI = 6.283185307179586
MANTISSA, HALF_EXPONENT = 0x000FFFFFFFFFFFFF, 0x3FE0000000000000
SHIFT = 6755399441055744.0  # 1.5 x 2^52: adding it rounds to an integer, in the last bits
EXP_LEAST = -708.3964185322641  # ln 2^-1022, the logarithm of the least normal number


@device
def log_positive(x):
    """Return the natural logarithm of a positive normal number."""
    # Split x into 2^e and a mantissa in [sqrt(1/2), sqrt(2)).
    bits = bits_of(x)
    m = float_of((bits & MANTISSA) | HALF_EXPONENT)
    low = m < 0.7071067811865476
    m = m + m if low else m
    e = real(int64(uint64(bits) >> uint64(52))) - (1023.0 if low else 1022.0)
    # Rational approximation of the logarithm of the mantissa.
    y = m - 1.0
    z = y * y
    p = 1.01875663804580931796e-4 * y + 4.97494994976747001425e-1
    p = ((p * y + 4.70579119878881725854) * y + 1.44989225341610930846e1) * y + 1.79368678507819816313e1
    p = p * y + 7.70838733755885391666
    q = ((y + 1.12873587189167450590e1) * y + 4.52279145837532221105e1) * y + 8.29875266912776603211e1
    q = (q * y + 7.11544750618563894466e1) * y + 2.31251620126765340583e1
    r = y * z * p / q - e * 2.121944400546905827679e-4 - 0.5 * z
    return y + r + e * 0.693359375


@device
def exp_parts(x):
    """Return 2^n and exp(r) - 1, where x = n ln 2 + r and |r| <= ln 2 / 2, for x in [EXP_LEAST, 709]."""
    t = x * 1.4426950408889634 + SHIFT
    n = t - SHIFT
    r = (x - n * 0.693145751953125) - n * 1.42860682030941723212e-6
    p = 2.7557585933588668e-6 + r * (2.7630216748270738e-7 + r * 2.5000152871892357e-8)
    p = 1.3888888943525845e-3 + r * (1.9841269507298097e-4 + r * (2.4801493195968517e-5 + r * p))
    p = 0.16666666666666414 + r * (4.1666666666530611e-2 + r * (8.333333333493984e-3 + r * p))
    return float_of(((bits_of(t) + 1023) & 0x7FF) << 52), r + r * r * (0.50000000000000106 + r * p)


@device
def exp_negative(x):
    """Return exp(x) for x <= 0 (valid up to 709).

    0 below -708.396, the logarithm of the least normal number.
    """
    scale, e = exp_parts(EXP_LEAST if x < EXP_LEAST else x)
    return 0.0 if x < EXP_LEAST else scale + scale * e


@device
def expm1_negative(x):
    """Return exp(x) - 1 for x <= 0 (valid up to 709), without cancellation near 0."""
    scale, e = exp_parts(-64.0 if x < -64.0 else x)
    return scale * e + (scale - 1.0)


@device
def log1p(x):
    """Return ln(1 + x) for x > -1, without cancellation near 0."""
    w = 1.0 + x
    return log_positive(w) + (x - (w - 1.0)) / w


@device
def sin_quarter(turn):
    """Return sin(2 pi turn) for turn in [-1/4, 1/4].

    Odd polynomial of least relative error (Remez), 3e-19 before rounding.
    """
    z = turn * turn
    p = 3.8199270504789338 + z * (-0.71772358015544982 + z * 0.10085633077354056)
    p = 81.605249276073406 + z * (
        -76.705859752798497 + z * (42.058693923785236 + z * (-15.09464162050996 + z * p))
    )
    return turn * (6.2831853071795865 + z * (-41.341702240399756 + z * p))


@device
def cos_sin_turn(turn):
    """Return cos and sin of 2 pi turn, for turn in [0, 1)."""
    c = -sin_quarter(0.25 - abs(turn - 0.5))
    v = turn - 0.25 if turn >= 0.25 else turn + 0.75
    return c, -sin_quarter(0.25 - abs(v - 0.5))


@device
def atan_unit(x):
    """Return atan(x) for x in [0, 1].

    Reduced to |x| <= tan(pi/8), rational approximation of Cephes atan.c.
    """
    far = x > 0.4142135623730950488
    y = (x - 1.0) / (x + 1.0) if far else x
    z = y * y
    p = -8.750608600031904122785e-1 * z - 1.615753718733365076637e1
    p = ((p * z - 7.500855792314704667340e1) * z - 1.228866684490136173410e2) * z - 6.485021904942025371773e1
    q = ((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2
    q = (q * z + 4.853903996359136964868e2) * z + 1.945506571482613964425e2
    a = y + y * z * p / q
    return a + 0.7853981633974483 if far else a


@device
def azimuth_turn(x, y):
    """Return the angle of (x, y) from the x axis as a fraction of a turn, in [0, 1); 0 for (0, 0)."""
    ax, ay = abs(x), abs(y)
    large, small = max(ax, ay), min(ax, ay)
    a = atan_unit(small / large if large > 0.0 else 0.0)
    a = 1.5707963267948966 - a if ay > ax else a
    a = 3.141592653589793 - a if x < 0.0 else a
    turn = a / TWO_PI
    turn = 1.0 - turn if (y < 0.0) & (turn > 0.0) else turn
    return turn if turn < 1.0 else 0.0
