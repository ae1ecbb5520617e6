"""Checks of a system that need no proof."""
