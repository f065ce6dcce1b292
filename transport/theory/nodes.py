"""The nodes and weights of Gauss and Legendre, found once for each number of them."""

from functools import cache

import numpy as np


@cache
def legendre_nodes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes in (-1, 1) and weights, each (count,), exact for polynomials of degrees below 2 count; not to be written to."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights
