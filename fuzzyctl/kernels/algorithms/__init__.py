"""Algorithms that evaluate a plan, and the choice among them."""
