"""The intermediate language: programs of assignments, and their primitives."""
