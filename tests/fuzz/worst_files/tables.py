"""Worst cases of rule tables and CSV files."""

import random

from worst_files.case import HEAD, SUGENO, TERMS, case, cut, files_case, names, repeated, repetitions

repetitions(
    {
        "a-table-with-many-rows": ("low | small large\n", HEAD, "table y = x x x\n  low high\n"),
        "a-table-with-one-long-row": (" small", HEAD, "table y = x\n  low high\n  |"),
        "a-table-with-a-long-header": (" low", HEAD, "table y = x\n "),
        "tables": ("table y = x\n  low high\n  | small large\n", HEAD),
        "tables-under-a-condition": (
            "with x is low and x is not high\ntable y = x\n  low high\n  | small large\n",
            HEAD,
        ),
        "tables-without-a-header": ("table y = x\n", HEAD),
    }
)


def table(rows, columns, cell="small", ends="\n"):
    yield f"table y = x x z\n  {' '.join(columns)}\n"
    for row in rows:
        yield f"{row} | {' '.join([cell] * len(columns))}{ends}"


@case
def a_large_table(size):
    known = names(141 * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\ninput z in [0, 1]\n  terms {' '.join(known)}\n"
    yield HEAD.split("\n", 2)[2].replace(" else 0", "")
    yield from table(known, known)


@case
def a_large_table_of_terms(size):
    rng = random.Random(1)
    known = names(141 * size)
    peaks = names(TERMS * size, "s")
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\ninput z in [0, 1]\n  terms {' '.join(known)}\n"
    yield f"output y in [0, 1]\n  terms {' '.join(peaks)}\n"
    yield f"table y = x x z\n  {' '.join(known)}\n"
    for row in known:
        yield f"{row} | {' '.join(rng.choice(peaks) for _ in known)}\n"


@case
def a_table_that_is_too_large(size):
    known = names(TERMS * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\ninput z in [0, 1]\n  terms {' '.join(known)}\n"
    yield HEAD.split("\n", 2)[2].replace(" else 0", "")
    yield from table(known, known, "1")


@case
def a_table_of_unknown_cells(size):
    known = names(141 * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\ninput z in [0, 1]\n  terms {' '.join(known)}\n"
    yield f"output y in [0, 1]\n  terms {' '.join(names(TERMS * size, 'peak'))}\n"
    yield from table(known, known, "paek1")


@case
def a_table_of_broken_cells(size):
    known = names(141 * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\ninput z in [0, 1]\n  terms {' '.join(known)}\n{SUGENO}"
    yield from table(known, known, "1+")


@case
def a_table_of_numbers(size):
    known = names(141 * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\ninput z in [0, 1]\n  terms {' '.join(known)}\n{SUGENO}"
    yield from table(known, known, "0.25")


@case
def a_table_of_weights(size):
    known = names(141 * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\ninput z in [0, 1]\n  terms {' '.join(known)}\n{SUGENO}"
    yield from table(known, known, "large*(1/2)")


@case
def a_table_of_functions(size):
    known = names(141 * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\ninput z in [0, 1]\n  terms {' '.join(known)}\n{SUGENO}"
    yield from table(known, known, "linear(1,2,3)")


@files_case
def tables_from_one_csv_file(size):
    text = "system worst\n" + HEAD + cut(repeated('table y = x x x from "large.csv"\n'), 0.9 * size)
    return {"tables.fz": text, "large.csv": cut(repeated("low,small\n", "a,low\n"), size)}


@files_case
def tables_from_one_large_csv_file(size):
    text = "system worst\n" + HEAD + cut(repeated('table y = x from "large.csv"\n'), 0.9 * size)
    return {"tables.fz": text, "large.csv": cut(repeated(",small", "a,low,high\n"), size)}
