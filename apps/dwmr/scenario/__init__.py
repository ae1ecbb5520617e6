"""Scenarios: their model, file format and checks."""
