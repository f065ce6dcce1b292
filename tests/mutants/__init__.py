"""Planted faults, by subject, and the tests that are to catch them."""

from tests.mutants import (
    of_combinations,
    of_counting,
    of_course,
    of_estimates,
    of_flights,
    of_physics,
    of_theory,
)

FAULTS = (
    *of_physics.FAULTS,
    *of_flights.FAULTS,
    *of_counting.FAULTS,
    *of_estimates.FAULTS,
    *of_theory.FAULTS,
    *of_combinations.FAULTS,
    *of_course.FAULTS,
)
