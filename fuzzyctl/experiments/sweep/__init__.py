"""Sweeps: many runs of one scenario with varied values."""
