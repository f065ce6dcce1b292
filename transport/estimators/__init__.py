"""Ways to estimate the same numbers, and the choice among them."""
