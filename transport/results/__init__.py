"""From integer sums to estimates.

Batches, replicates, quantities with errors and units, the result of a run.
"""

from transport.results.result import QUANTITIES, Cost, Ledger, Result

__all__ = ["QUANTITIES", "Cost", "Ledger", "Result"]
