"""Worst cases of names, terms and variables."""

from itertools import islice

from worst_files.case import BYTES, HEAD, NAME, OUTPUTS, SUGENO, TERMS, VARIABLES, case, names, repeated


@case
def names_in_one_terms_line(size):
    yield from repeated(" n@", "input a in [0, 1]\n  terms")


@case
def names_in_one_terms_line_with_peaks(size):
    yield "input a in [0, 1]\n  terms"
    for k in range(BYTES):
        yield f" n{k}@{k}"


@case
def names_in_one_terms_line_given_twice(size):
    yield from repeated(" n", "input a in [0, 1]\n  terms")


@case
def singletons_in_one_terms_line(size):
    yield from repeated(" n@=@", "output a in [0, 1]\n  terms")


@case
def term_lines(size):
    yield from repeated("  n@ = triangle(0, 0.5, 1)\n", "input a in [0, 1]\n")


@case
def term_lines_of_an_unknown_kind(size):
    yield from repeated("  n@ = triangel(0, 0.5, 1)\n", "input a in [0, 1]\n")


@case
def thousands_of_inputs(size):
    yield from repeated("input a@ in [0, 1]\n  terms a b\n", HEAD, "if x is low then y is small\n")


@case
def inputs_of_a_thousand_terms(size):
    yield from repeated("input a@ in [0, 1]\n  terms " + " ".join(names(TERMS * size)) + "\n", HEAD)


@case
def inputs_of_a_thousand_terms_in_one_rule(size):
    heads = "".join(f"input a{k} in [0, 1]\n  terms {' '.join(names(TERMS * size))}\n" for k in range(90))
    yield heads + SUGENO + "if " + " and ".join(f"a{k} is t{k}" for k in range(90)) + " then y is small\n"


@case
def inputs_of_the_same_name(size):
    yield from repeated("input a in [0, 1]\n  terms a b\n", HEAD)


@case
def thousands_of_outputs(size):
    yield from repeated("output a@ in [0, 1] else 0\n  terms a b\n", HEAD, "if x is low then y is small\n")


@case
def as_many_variables_as_allowed(size):
    inputs, many = int((VARIABLES - OUTPUTS) * size), " ".join(names(100))
    yield "".join(f"input a{k} in [0, 1]\n  terms {many}\n" for k in range(inputs))
    yield "".join(f"output y{k} in [0, 1] else 0\n  terms a b\n" for k in range(int(OUTPUTS * size)))
    yield "if a0 is t1 then y0 is a\n"


@case
def inputs_of_the_same_name_as_many_as_allowed(size):
    yield from islice(repeated("input a in [0, 1]\n  terms a b\n", HEAD), int((VARIABLES - 1) * size))


@case
def long_names(size):
    yield from repeated(f"param {'n' * (NAME - 6)}@ = 1\n", HEAD)


@case
def long_unknown_names(size):
    yield from repeated(f"param {'n' * (NAME - 6)}@ = {'m' * (NAME - 6)}@\n", HEAD)


@case
def names_that_are_too_long(size):
    yield from repeated(f"param {'n' * NAME}@ = 1\n", HEAD)


@case
def unknown_terms_in_rules(size):
    known = " ".join(names(TERMS * size, "term"))
    yield from repeated(
        "if x is trem@ then y is small\n", f"input x in [0, 1]\n  terms {known}\noutput y in [0, 1]\n  terms small\n"
    )


@case
def unknown_inputs_in_rules(size):
    yield from repeated("if xx@ is low then y is small\n", HEAD)


@case
def unknown_inputs_among_many(size):
    inputs = "".join(f"input input_{k} in [0, 1]\n  terms a b\n" for k in range(int(0.99 * VARIABLES * size)))
    yield from repeated("if inptu_@ is a then y is small\n", HEAD, inputs)


@case
def unknown_params(size):
    yield from repeated("param p@ = q@ + r@\n", HEAD)


@case
def unknown_functions(size):
    yield from repeated("param p@ = sinn(1) + cosh(@)\n", HEAD)


@case
def unknown_settings(size):
    yield from repeated("defuzzifier centriod\n", HEAD)
