"""Fields of models, for tests that make one anew from the parts of another."""

from dataclasses import fields


def names_of(kind):
    """Return the names of the arguments of a class of models."""
    return [f.name for f in fields(kind)]
