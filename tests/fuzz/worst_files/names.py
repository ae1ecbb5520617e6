"""Worst cases of names, terms and variables."""

from itertools import islice

from worst_files.case import BYTES, HEAD, NAME, OUTPUTS, SUGENO, TERMS, VARIABLES, case, names, repeated, repetitions

repetitions(
    {
        "names-in-one-terms-line": (" n@", "input a in [0, 1]\n  terms"),
        "names-in-one-terms-line-given-twice": (" n", "input a in [0, 1]\n  terms"),
        "singletons-in-one-terms-line": (" n@=@", "output a in [0, 1]\n  terms"),
        "term-lines": ("  n@ = triangle(0, 0.5, 1)\n", "input a in [0, 1]\n"),
        "term-lines-of-an-unknown-kind": ("  n@ = triangel(0, 0.5, 1)\n", "input a in [0, 1]\n"),
        "thousands-of-inputs": ("input a@ in [0, 1]\n  terms a b\n", HEAD, "if x is low then y is small\n"),
        "inputs-of-the-same-name": ("input a in [0, 1]\n  terms a b\n", HEAD),
        "thousands-of-outputs": ("output a@ in [0, 1] else 0\n  terms a b\n", HEAD, "if x is low then y is small\n"),
        "long-names": (f"param {'n' * (NAME - 6)}@ = 1\n", HEAD),
        "long-unknown-names": (f"param {'n' * (NAME - 6)}@ = {'m' * (NAME - 6)}@\n", HEAD),
        "names-that-are-too-long": (f"param {'n' * NAME}@ = 1\n", HEAD),
        "unknown-inputs-in-rules": ("if xx@ is low then y is small\n", HEAD),
        "unknown-params": ("param p@ = q@ + r@\n", HEAD),
        "unknown-functions": ("param p@ = sinn(1) + cosh(@)\n", HEAD),
        "unknown-settings": ("defuzzifier centriod\n", HEAD),
    }
)


@case
def names_in_one_terms_line_with_peaks(size):
    yield "input a in [0, 1]\n  terms"
    for k in range(BYTES):
        yield f" n{k}@{k}"


@case
def inputs_of_a_thousand_terms(size):
    yield from repeated("input a@ in [0, 1]\n  terms " + " ".join(names(TERMS * size)) + "\n", HEAD)


@case
def inputs_of_a_thousand_terms_in_one_rule(size):
    heads = "".join(f"input a{k} in [0, 1]\n  terms {' '.join(names(TERMS * size))}\n" for k in range(24))
    yield heads + SUGENO + "if " + " and ".join(f"a{k} is t{k}" for k in range(24)) + " then y is small\n"


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
def unknown_terms_in_rules(size):
    known = " ".join(names(TERMS * size, "term"))
    yield from repeated(
        "if x is trem@ then y is small\n", f"input x in [0, 1]\n  terms {known}\noutput y in [0, 1]\n  terms small\n"
    )


@case
def unknown_inputs_among_many(size):
    inputs = "".join(f"input input_{k} in [0, 1]\n  terms a b\n" for k in range(int(0.99 * VARIABLES * size)))
    yield from repeated("if inptu_@ is a then y is small\n", HEAD, inputs)
