"""Simulation of loops: controllers and plants as one compiled run, its measures and its requirements."""
