"""Geometry, arrays and compilation: used by all other packages, and importing none of them."""
