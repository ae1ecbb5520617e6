"""The plan: a system without names and expressions, flat and hashable."""
