"""Fuzzy inference as a program: activation, implication, aggregation and defuzzification."""
