"""Russian roulette at walls and at collisions: light histories are killed or restored to weight, unbiased.

A weight is light relative to the history's birth weight, or to the one wanted by importance, so the unit of
power does not matter. The ledger takes the weight killed less the weight gained: expectation 0.
"""

from transport.compile.layout import IMPORTANCE, ROULETTE, ROULETTE_LAW
from transport.engine.importances import wanted_at
from transport.engine.ledger import enter
from transport.engine.passes import lane_pass
from transport.engine.sums import limbs
from transport.physics.device import device
from transport.physics.roulette import survived
from transport.physics.streams import WEIGH, event_words, uniform

LIGHT = 0.5  # share of the wanted weight, where importance gives one


@device
def played(is_light, weight, wanted, u):
    """Return (weight, uniform, high limb, low limb) after Russian roulette, played only if is_light.

    The uniform is a fresh one in place of u, the limbs are those of the loss.
    """
    left, fresh = survived(weight, wanted, u)
    new = left if is_light else weight
    high, low = limbs(weight)
    new_high, new_low = limbs(new)
    return new, fresh if is_light else u, high - new_high, low - new_low


@lane_pass(ROULETTE_LAW)
def play_roulette(b, table, first, live):
    """Play Russian roulette at walls, below a share `threshold` of the birth weight.

    Survivors have share `level`.

    Fields: reads `birth`, `hit`, `u2`; updates `weight`.
    """
    total_high, total_low, threshold, level = 0, 0, table.threshold, table.level
    for k in range(first, live):
        w, birth = b.weight[k], b.birth[k]
        is_light = (w < threshold * birth) & (w > 0.0) & (b.hit[k] != 0)
        b.weight[k], _, high, low = played(is_light, w, level * birth, b.u2[k])
        total_high += high
        total_low += low
    enter(b, ROULETTE, total_high, total_low)
    return live


@lane_pass(IMPORTANCE)
def play_roulette_by_importance(b, table, first, live):
    """Play Russian roulette at walls, below half the weight wanted there, which survivors have.

    Fields: reads `x, y, z`, `birth`, `history`, `event`, `hit`; updates `weight`.
    """
    total_high, total_low = 0, 0
    seed_low, seed_high, batch = b.seed_low, b.seed_high, b.batch
    cx, cy, cz, kx, ky, kz, most = table.cx, table.cy, table.cz, table.kx, table.ky, table.kz, table.most
    for k in range(first, live):
        w0, w1, _, _ = event_words(b.history[k], batch, b.event[k], WEIGH, seed_low, seed_high)
        w, wanted = b.weight[k], wanted_at(b.x[k], b.y[k], b.z[k], b.birth[k], cx, cy, cz, kx, ky, kz, most)
        is_light = (w < LIGHT * wanted) & (w > 0.0) & (b.hit[k] != 0)
        b.weight[k], _, high, low = played(is_light, w, wanted, uniform(w0, w1))
        total_high += high
        total_low += low
    enter(b, ROULETTE, total_high, total_low)
    return live


@lane_pass(ROULETTE_LAW)
def play_roulette_in_flight(b, table, first, live):
    """Play Russian roulette at collisions, below a share `threshold` of the birth weight.

    Fields: reads `birth`; updates `weight`, `u0`, `collides`.
    """
    total_high, total_low, threshold, level = 0, 0, table.threshold, table.level
    for k in range(first, live):
        w, birth = b.weight[k], b.birth[k]
        is_light = (b.collides[k] != 0) & (w < threshold * birth)
        new, b.u0[k], high, low = played(is_light, w, level * birth, b.u0[k])
        b.weight[k] = new
        b.collides[k] = 0 if new == 0.0 else b.collides[k]
        total_high += high
        total_low += low
    enter(b, ROULETTE, total_high, total_low)
    return live
