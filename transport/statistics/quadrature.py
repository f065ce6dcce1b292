"""Gauss-Legendre nodes and weights, computed once per number of nodes."""

from functools import cache

import numpy as np


@cache
def legendre_nodes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights on (-1, 1); the result is cached.

    Parameters
    ----------
    count : int
        Number of nodes n.

    Returns
    -------
    tuple of ndarray
        Nodes and weights, shape (n,) each, read-only; exact for polynomials of degree below 2 n.

    Examples
    --------
    >>> from transport.statistics.quadrature import legendre_nodes
    >>> print(legendre_nodes(2)[0].round(4))
    [-0.5774  0.5774]
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights
