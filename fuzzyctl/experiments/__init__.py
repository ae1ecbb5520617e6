"""Experiments: settings in layers, sweeps, comparison of results, of whatever can be run from settings."""
