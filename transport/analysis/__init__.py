"""Analyses made of runs: cost of accuracy, view factors, solid angles, paths of particles."""
