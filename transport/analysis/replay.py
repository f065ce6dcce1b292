"""A loop that calls a pass again and again on recorded bundles, to time it."""

import numpy as np
from numba import njit

from transport.engine.bundle import HEADER_WORDS, PITCH, call_pass, view
from transport.engine.cache import cached_kernels

with cached_kernels():

    @njit(cache=True, nogil=True, error_model="numpy")
    def replay_pass(entry, table, handles, spans, states, rows, repeats):
        """Restore bundles to their states and call a pass on each; entry 0 only restores.

        `spans` holds the first and live lane of each bundle, `states` the bundles as int64, shape (bundles,
        words), `rows` the columns of `states` at which the lane fields changed by the pass begin.  Returns
        the number of lanes left by the last call.
        """
        live = 0
        for _ in range(repeats):
            for s in range(len(handles)):
                words = view(handles[s], states.shape[1], np.int64)
                for k in range(HEADER_WORDS):
                    words[k] = states[s, k]
                for row in rows:
                    field, state = words[row : row + PITCH], states[s, row : row + PITCH]
                    for k in range(PITCH):
                        field[k] = state[k]
                if entry != 0:
                    live = call_pass(entry, handles[s], table, spans[s, 0], spans[s, 1])
        return live
