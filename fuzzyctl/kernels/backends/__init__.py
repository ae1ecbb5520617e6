"""Backends: a program printed and compiled for Python, numpy or numba."""
