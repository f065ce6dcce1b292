"""How far a flight goes before it collides, as an optical depth; and what is random about the collision at its end."""

from transport.physics.device import device
from transport.physics.elementary import expm1_negative, log1p, log_positive
from transport.physics.streams import LOW32, PATH, event_words, short_uniform, uniform


@device
def free_flight(history, batch, event, seed_low, seed_high):
    """The depth of a free path by the exponential law, and from the same random block two numbers (52 and 32 bits) for later.

    Of 2^52 equal cells of probability the middles: no depth is 0, none above 37.
    """
    w0, w1, w2, w3 = event_words(history, batch, event, PATH, seed_low, seed_high)
    depth = -log_positive((1.0 - 2.0**-53) - uniform(w0, w1))
    return depth, uniform(w2, (w1 << 20) & LOW32), short_uniform(w3)


@device
def depth_before(tau, depth):
    """A free depth turned into one below tau, by the exponential law cut off there; and minus the share of paths so short.

    Inversion: -ln(1 - c (1 - e^-tau)), where c = 1 - e^-depth is uniform.
    """
    less_share, less_chance = expm1_negative(-tau), expm1_negative(-depth)
    return -log1p(-less_chance * less_share), less_share
