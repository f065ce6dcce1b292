"""Analytic solutions of transport theory as plain functions of floats, each with its source."""

from transport.theory import emitters, enclosures, gas, solid_angles, sun, view_factors

__all__ = ["emitters", "enclosures", "gas", "solid_angles", "sun", "view_factors"]
