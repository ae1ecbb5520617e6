"""Worst cases of systems of one file."""

from worst_files.case import HEAD, cut, file_case, names, repeated, repetitions
from worst_files.tables import table

repetitions(
    {
        "small-systems": (f"system s@\n{HEAD}if x is low then y is small\n",),
        "systems-of-shared-variables": ("system s@\nif x is low then y is small\n", HEAD),
        "empty-systems": ("system s@\n", HEAD),
        "systems-of-one-name": (f"system s\n{HEAD}if x is low then y is small\n",),
        "systems-with-claims-about-each-other": (f"system s@\n{HEAD}if x is low then y is small\nrequire y == s0.y\n",),
    }
)


@file_case
def systems_that_share_much(size):
    shared = cut(repeated("param p@ = @\ninput i@ in [0, 1]\n  terms a b c d e f g\n", HEAD), 0.5 * size)
    yield from repeated("system s@\nif x is low then y is small\n", shared)


@file_case
def systems_that_share_a_table(size):
    known = names(100 * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\ninput z in [0, 1]\n  terms {' '.join(known)}\n"
    yield HEAD.split("\n", 2)[2].replace(" else 0", "")
    yield from table(known, known)
    yield from repeated("system s@\n")


@file_case
def systems_in_a_chain_of_claims(size):
    k = 0
    while True:
        yield f"system s{k}\n{HEAD}if x is low then y is small\nrequire y == s{k + 1}.y\n"
        k += 1
