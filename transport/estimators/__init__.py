"""Estimators of the same quantities, and the choice among them."""
