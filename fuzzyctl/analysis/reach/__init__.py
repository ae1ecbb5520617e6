"""Reachable sets of loops."""
