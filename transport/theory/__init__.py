"""The analytic limits of transport theory, as plain functions of floats with their sources."""

from transport.theory import emitters, enclosures, gas, solid_angles, sun, view_factors

__all__ = ["emitters", "enclosures", "gas", "solid_angles", "sun", "view_factors"]
