"""Analytic solutions of transport theory as plain functions of floats, each with its source."""

from transport.theory import effusion as gas
from transport.theory import emitters, enclosures, solid_angles, view_factors
from transport.theory import emitters as sun

__all__ = ["emitters", "enclosures", "gas", "solid_angles", "sun", "view_factors"]
