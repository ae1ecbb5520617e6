"""Sweeps over loops: many runs with varied params, noise and controllers."""
