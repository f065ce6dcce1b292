"""From integer sums to estimates.

Batches, replicates, quantities with errors and units, the result of a run.
"""
