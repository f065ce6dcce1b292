"""Faults planted one at a time, to see that the suite's tests catch them: python -m tests.mutants."""
