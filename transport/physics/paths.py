"""Free paths as optical depths."""

from transport.physics.device import device
from transport.physics.elementary import expm1_negative, log1p, log_positive


@device
def free_depth(u):
    """Return the optical depth of a free path (exponential law), from a uniform of 52 bits.

    Depths are those of the middles of 2^52 equal cells of probability: never 0 and never above 37.
    """
    return -log_positive((1.0 - 2.0**-53) - u)


@device
def depth_before(tau, depth):
    """Return a depth below tau by the truncated exponential law, and minus the probability of such a path.

    depth: a free depth, mapped by inversion: -ln(1 - c (1 - e^-tau)), where c = 1 - e^-depth is uniform.
    """
    less_share, less_chance = expm1_negative(-tau), expm1_negative(-depth)
    return -log1p(-less_chance * less_share), less_share


# ---- Russian roulette: a light weight becomes 0 or the wanted weight, with unchanged mean.
#
# Kahn and Harris 1951, Estimation of particle transmission by random sampling, NBS Applied Mathematics Series
# 12, 27.


@device
def survived(weight, wanted, u):
    """Return the weight after survival with probability weight/wanted, decided by u, and a fresh uniform.

    The uniform is u rescaled for survivors, 0 otherwise.
    """
    chance = weight / wanted
    lives, fresh = u < chance, u / chance
    return wanted if lives else 0.0, fresh if lives & (fresh < 1.0) else 0.0
