"""Russian roulette: a light weight becomes 0 or the wanted weight, with unchanged mean.

Kahn and Harris 1951, Estimation of particle transmission by random sampling, NBS Applied Mathematics Series
12, 27.
"""

from transport.physics.device import device


@device
def survived(weight, wanted, u):
    """Return the weight after survival with probability weight/wanted, decided by u, and a fresh uniform.

    The uniform is u rescaled for survivors, 0 otherwise.
    """
    chance = weight / wanted
    lives, fresh = u < chance, u / chance
    return wanted if lives else 0.0, fresh if lives & (fresh < 1.0) else 0.0
