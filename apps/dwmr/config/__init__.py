"""Layers of settings: scenario files, overrides of the command line, and the location of each key."""
