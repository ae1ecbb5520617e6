"""Simulation of loops: controllers and plants as one compiled run, and what it is judged by."""
