"""Worst cases of short forms: shared lines and terms, groups, 'unless', 'otherwise', labels, 'scale', hedged cells."""

from worst_files.case import (
    HEAD,
    OUTPUTS,
    RULES,
    SUGENO,
    TERMS,
    VARIABLES,
    case,
    inputs_of,
    names,
    repeated,
    repetitions,
)
from worst_files.tables import table

ONE = "if x is low then y is small\n"

repetitions(
    {
        "terms-of-one-variable": ("input a@ in [0, 1] terms of x\n", HEAD, ONE),
        "terms-of-unknown-variables": ("input a@ in [0, 1] terms of xx@\n", HEAD, ONE),
        "inputs-on-one-line": (", a@", HEAD, ONE, "input a"),
        "inputs-on-one-line-with-labels": (', a@ "label @"', HEAD, ONE, "input a"),
        "inputs-of-one-name-on-one-line": (", a", HEAD, ONE, "input a"),
        "conditions-behind-unless": ("if x is low unless x is high then y is small\n", HEAD),
        "otherwise-lines": ("otherwise y is small\n", HEAD, ONE),
        "a-group-of-many-terms": (" or low", HEAD, "if x is (low"),
        "groups-in-groups": ("(", HEAD, "if x is "),
        "any-term": ("if x is any then y is small\n", HEAD),
        "scaled-tables": ("table y = x scale @\n  0 1\n  | 0 1\n", "defuzzifier weighted_average\n", HEAD),
        "labels-that-are-no-terms": ("table y = x\n  0 7@\n  | 0 1\n", HEAD),
        "consequents-in-parentheses": ("if x is low then (y is small,\n y is large)\n", HEAD),
        "consequents-in-one-parenthesis": ("y is small, ", HEAD, "if x is low then ("),
    }
)


def shared(size, prefix, more=""):
    """Return as many inputs on one line as allowed, which share as many terms as allowed."""
    count = max(2, int(90 * size))
    line = ", ".join(f"{prefix}{k}" for k in range(count))
    return f"input {line} in [0, 1]{more}\n  terms {' '.join(names(min(TERMS, 20_000 // count - 1)))}\n"


@case
def inputs_on_one_line_with_terms_as_many_as_allowed(size):
    yield shared(size, "a") + HEAD + ONE


@case
def inputs_on_one_line_as_many_as_allowed(size):
    line = ", ".join(f"a{k}" for k in range(max(2, int((VARIABLES - 2) * size))))
    yield f"input {line} in [0, 1]\n  terms a b\n{HEAD}{ONE}"


@case
def outputs_on_one_line_as_many_as_allowed(size):
    line = ", ".join(f"z{k}" for k in range(max(2, int((OUTPUTS - 2) * size))))
    yield f"output {line} in [0, 1] else 0\n  terms a b\n{HEAD}{ONE}"
    yield from (f"if x is low then z{k} is a\n" for k in range(max(2, int((OUTPUTS - 2) * size))))


@case
def terms_of_each_other_in_a_chain(size):
    count = int(900 * size)
    yield f"input a0 in [0, 1]\n  terms {' '.join(names(20))}\n"
    yield from (f"input a{k} in [0, 1] terms of a{k - 1}\n" for k in range(1, count))
    yield HEAD + ONE


@case
def terms_of_each_other_in_a_circle(size):
    count = max(2, int((VARIABLES - 2) * size))
    yield from (f"input a{k} in [0, 1] terms of a{(k + 1) % count}\n" for k in range(count))
    yield HEAD + ONE


@case
def terms_of_a_variable_with_a_thousand(size):
    yield f"input a in [0, 1]\n  terms {' '.join(names(TERMS * size))}\n"
    yield from (f"input a{k} in [0, 1] terms of a\n" for k in range(19))
    yield HEAD + ONE


@case
def groups_of_many_terms(size):
    known = names(TERMS * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\n{SUGENO}"
    for k in range(int(1500 * size)):
        yield f"if x is ({' or '.join(known[(k + j) % len(known)] for j in range(90))}) then y is small\n"


@case
def groups_of_many_terms_of_many_inputs(size):
    group = "(" + " or ".join(names(90)) + ")"
    yield inputs_of(9, " ".join(names(100))) + SUGENO.replace(" else 0", "")
    rule = " and ".join(f"x{k} is {group}" for k in range(9))
    for _ in range(int(300 * size)):
        yield f"if {rule} then y is small\n"


@case
def groups_that_are_not(size):
    known = names(90)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\n{SUGENO}"
    for _ in range(int(900 * size)):
        yield f"if x is not ({' or '.join('very ' + t for t in known)}) then y is small\n"


@case
def deep_groups(size):
    for k in range(int(2000 * size)):
        yield (HEAD if not k else "") + "if " + "(" * 40 + "x is (low or not high)" + ")" * 40 + " then y is small\n"


@case
def rules_with_any_term(size):
    yield inputs_of(40, "a b c") + SUGENO.replace(" else 0", "")
    condition = " and ".join(f"x{k} is any" for k in range(1, 40))
    for k in range(int(1500 * size)):
        yield f"if x0 is {'abc'[k % 3]} and {condition} then y is small\n"


@case
def rules_with_unless(size):
    yield inputs_of(10, "a b c") + SUGENO.replace(" else 0", "")
    exception = " or ".join(f"x{k} is c" for k in range(1, 10))
    for k in range(int(5000 * size)):
        yield f"if x0 is {'abc'[k % 3]} unless {exception} then y is small\n"


@case
def otherwise_of_many_rules(size):
    yield inputs_of(4, " ".join(names(11))) + SUGENO.replace(" else 0", "")
    for k in range(int(0.99 * RULES * size)):
        yield f"if x0 is t{k % 11} and x1 is t{k // 11 % 11} and x2 is t{k // 121 % 11} then y is small\n"
    yield "otherwise y is large\n"


@case
def otherwise_of_many_outputs(size):
    outputs = max(2, int(OUTPUTS * size))
    yield inputs_of(4, " ".join(names(7)))
    yield "".join(f"output y{k} in [0, 1]\n  terms small large\n" for k in range(outputs))
    for k in range(int(12_000 * size)):
        yield f"if x0 is t{k % 7} and x1 is t{k // 7 % 7} then y{k % outputs} is small\n"
    yield from (f"otherwise y{k} is large\n" for k in range(outputs))


@case
def otherwise_of_many_blocks(size):
    for k in range(int(2000 * size)):
        head = "" if k else HEAD.replace(" else 0", "")
        yield f"{head}rules b{k} and product\n{ONE}otherwise y is large\n"


@case
def otherwise_of_a_table(size):
    known = names(max(2, 140 * size))
    yield f"input x, z in [0, 1]\n  terms {' '.join(known)}\n{SUGENO.replace(' else 0', '')}"
    yield from table(known[:-1], known, "small")
    yield f"{known[-1]} | {' '.join(['.'] * len(known))}\notherwise y is large\n"


@case
def a_table_of_hedged_cells(size):
    known = names(141 * size)
    yield f"input x, z in [0, 1]\n  terms {' '.join(known)}\n" + HEAD.split("\n", 2)[2].replace(" else 0", "")
    yield from table(known, known, "[not very small]")


@case
def a_table_of_hedged_cells_with_weights(size):
    known = names(141 * size)
    yield f"input x, z in [0, 1]\n  terms {' '.join(known)}\n" + HEAD.split("\n", 2)[2].replace(" else 0", "")
    yield from table(known, known, "[very small]*0.5")


@case
def a_table_with_numbers_as_labels(size):
    count = int(141 * size)
    labels = [str(k - count // 2) for k in range(count)]
    yield f"input x, z in [0, 1]\n  terms {' '.join(names(count))}\nparam g = 2\n{SUGENO.replace(' else 0', '')}"
    yield from (p.replace("x x z", "x x z scale 0.5*g") for p in table(labels, labels, "0.25"))


@case
def slices_with_groups(size):
    known = names(12)
    yield f"input x, z, w in [0, 1]\n  terms {' '.join(known)}\n{SUGENO.replace(' else 0', '')}"
    for k in range(int(130 * size)):
        yield f"with w is ({known[k % 12]} or {known[(k + 1) % 12]})\n"
        yield from table(known, known, "small")


@case
def rules_of_unknown_terms_in_groups(size):
    yield from repeated("if x is (lo@ or hihg@ or low) unless x is nothing@ then y is small\n", HEAD)
