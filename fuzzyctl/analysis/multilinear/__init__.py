"""Exact analysis of systems that interpolate multilinearly, in rational arithmetic."""
