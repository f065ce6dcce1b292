"""Batches done by the workers of a Dask cluster: bit for bit those of one process, whoever does them, however often."""
