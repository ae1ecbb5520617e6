"""Compilation: model to plan, plan to program, and a program printed by a backend."""
