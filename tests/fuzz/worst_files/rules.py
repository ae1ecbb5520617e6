"""Worst cases of rules, and inputs and outputs of rules."""

import random

from worst_files.case import HEAD, OUTPUTS, RULES, SUGENO, TERMS, VARIABLES, case, inputs_of, names, repeated


def one_rule(count, otherwise=" else 0", terms="a b"):
    output = SUGENO.replace(" else 0", otherwise)
    return (
        inputs_of(count, terms)
        + output
        + "if "
        + " and ".join(f"x{k} is a" for k in range(count))
        + " then y is small\n"
    )


@case
def one_rule_over_20_inputs(size):
    yield one_rule(int(20 * size))


@case
def one_rule_over_20_inputs_without_else(size):
    yield one_rule(int(20 * size), "")


@case
def one_rule_over_300_inputs(size):
    yield one_rule(int(300 * size))


@case
def one_rule_over_300_inputs_without_else(size):
    yield one_rule(int(300 * size), "")


@case
def one_rule_over_90_inputs_without_else(size):
    yield one_rule(int(90 * size), "")


@case
def one_rule_over_thousands_of_inputs(size):
    yield one_rule(int(0.99 * VARIABLES * size), "")


@case
def one_rule_over_nested_inputs(size):
    count = int(300 * size)
    antecedent = " and ".join(
        "(" + " and ".join(f"x{k} is a" for k in range(start, min(start + 60, count))) + ")"
        for start in range(0, count, 60)
    )
    yield inputs_of(count) + SUGENO.replace(" else 0", "") + f"if {antecedent} then y is small\n"


@case
def rules_over_some_of_20_inputs(size):
    rng = random.Random(1)
    yield inputs_of(20, "a b c") + SUGENO.replace(" else 0", "")
    for _ in range(int(RULES * size)):
        chosen = rng.sample(range(20), 4)
        yield "if " + " and ".join(f"x{k} is {rng.choice('abc')}" for k in chosen) + " then y is small\n"


@case
def rules_over_some_of_6_inputs(size):
    rng = random.Random(1)
    yield inputs_of(6, "a b c d e f g") + HEAD.split("\n", 2)[2].replace(" else 0", "")
    for _ in range(int(RULES * size)):
        yield "if " + " and ".join(f"x{k} is {rng.choice('abcdefg')}" for k in range(6)) + " then y is small\n"


@case
def many_rules_of_one_input(size):
    known = names(TERMS * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\n{HEAD.split(chr(10), 2)[2]}"
    for k in range(int(RULES * size)):
        yield f"if x is {known[k % len(known)]} then y is small\n"


@case
def the_same_rule(size):
    yield HEAD
    for _ in range(int(RULES * size)):
        yield "if x is low then y is small\n"


@case
def more_rules_than_allowed(size):
    yield from repeated("if x is low then y is small\n", HEAD)


@case
def rules_with_terms_of_one_input(size):
    rng = random.Random(1)
    known = names(TERMS * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\n{SUGENO}"
    for _ in range(int(RULES * size)):
        yield "if " + " and ".join(f"x is not {t}" for t in rng.sample(known, 3)) + " then y is small\n"


@case
def rules_of_long_alternatives(size):
    known = names(TERMS * size)
    rng = random.Random(1)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\n{HEAD.split(chr(10), 2)[2]}"
    for _ in range(int(800 * size)):
        yield "if " + " or ".join(f"x is {t}" for t in rng.choices(known, k=90)) + " then y is small\n"


@case
def rules_for_many_outputs(size):
    yield "input x in [0, 1]\n  terms low high\n"
    outputs = int(OUTPUTS * size)
    yield "".join(f"output y{k} in [0, 1]\n  terms small large\n" for k in range(outputs))
    yield from repeated("if x is low then " + ", ".join(f"y{k} is small" for k in range(outputs)) + "\n")


@case
def a_rule_of_many_consequents(size):
    yield HEAD + "if x is low then y is small"
    yield from (f", y{k} is small" for k in range(int(60_000 * size)))


@case
def rules_for_many_outputs_of_ten_inputs(size):
    rng = random.Random(1)
    outputs = int(OUTPUTS * size)
    yield inputs_of(10, "a b c")
    yield "".join(f"output y{k} in [0, 1]\n  terms small large\n" for k in range(outputs))
    for k in range(int(RULES * size)):
        chosen = rng.sample(range(10), 3)
        yield "if " + " and ".join(f"x{i} is {rng.choice('abc')}" for i in chosen) + f" then y{k % outputs} is small\n"


@case
def outputs_in_a_chain(size):
    outputs = int(OUTPUTS * size)
    yield "input x in [0, 1]\n  terms low high\n"
    yield "".join(f"output y{k} in [0, 1]\n  terms low high\n" for k in range(outputs))
    yield "if x is low then y0 is low\nif x is high then y0 is high\n"
    for k in range(1, outputs):
        yield f"if y{k - 1} is low then y{k} is low\nif y{k - 1} is high then y{k} is high\n"


@case
def outputs_in_a_circle(size):
    outputs = int(OUTPUTS * size)
    yield "input x in [0, 1]\n  terms low high\n"
    yield "".join(f"output y{k} in [0, 1]\n  terms low high\n" for k in range(outputs))
    for k in range(outputs):
        for j in range(min(90, outputs)):
            yield f"if y{j} is low then y{k} is low\n"


@case
def weights_to_compute(size):
    yield HEAD
    for k in range(int(RULES * size)):
        yield f"if x is low then y is small weight (1 / (1 + {k}))\n"


@case
def blocks_of_rules(size):
    yield HEAD
    for k in range(int(RULES * size)):
        yield f"rules b{k} activation highest(count=1)\nif x is low then y is small\n"


@case
def rules_under_an_activation(size):
    yield HEAD + "activation highest(count=5)\n"
    for _ in range(int(RULES * size)):
        yield "if x is low then y is small\n"


@case
def dead_rules(size):
    yield "input x in [0, 1]\n  low = triangle(2, 3, 4)\n  high = triangle(0, 1, 2)\n" + SUGENO
    for k in range(int(RULES * size)):
        yield f"if x is low and x is high then y is small weight (1 / {k + 1})\n"


@case
def dead_rules_of_many_cells(size):
    yield inputs_of(5, " ".join(names(12))) + SUGENO
    for k in range(int(RULES * size)):
        yield f"if x0 is t{k % 5} and x0 is t{k % 5 + 6} and x1 is t2 and x1 is t{k % 7} and x2 is t3 then y is small\n"


@case
def sets_that_cover_each_other(size):
    yield inputs_of(12, "a b c") + HEAD.split("\n", 2)[2]
    yield "".join(f"output z{k} in [0, 1] else 0\n  terms small large\n" for k in range(66))
    rng = random.Random(1)
    for k in range(int(RULES * size)):
        few = rng.sample(range(12), 3)
        yield "if " + " and ".join(f"x{i} is {rng.choice('abc')}" for i in few) + f" then z{k % 66} is small\n"
