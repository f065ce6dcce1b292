"""Estimates from integer sums.

Batches, replicates, quantities with errors and units, the result of a run.
"""
