"""Dask executor: workers of a cluster compute batches, bit for bit as one process does."""
