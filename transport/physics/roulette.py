"""Russian roulette: a weight that is not worth its time becomes 0, or the weight that it should be, with the right mean.

Kahn and Harris 1951, Estimation of particle transmission by random sampling, NBS Applied Mathematics Series 12, 27.
"""

from transport.physics.device import device


@device
def survived(weight, wanted, u):
    """The weight after a game of chance weight/wanted, decided by u; and a number that is as good as new where it lives."""
    chance = weight / wanted
    lives, fresh = u < chance, u / chance
    return wanted if lives else 0.0, fresh if lives & (fresh < 1.0) else 0.0
