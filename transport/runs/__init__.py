"""A run: when it looks, when it stops, on which threads, what it tells meanwhile."""
