"""Defuzzifiers as programs."""
