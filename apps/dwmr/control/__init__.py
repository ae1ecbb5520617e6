"""Sliding variables, fuzzy gains and control laws: everything between posture error and velocity command."""
