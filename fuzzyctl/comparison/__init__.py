"""Comparison of two systems: changes, largest differences, and the settings that explain them."""
