"""Experiments with exact values, and hard cases that naive formulas get wrong."""
