"""Rule files that are as large, as long and as deep as the limits allow: the worst cases of each stage of a check.

Each case is a function from a size to files. The size is 1 for files at the limits of docs/reference/language.md; less
makes the same files smaller.
"""

import random
from collections.abc import Callable, Iterator
from itertools import chain, islice

#: Largest size of a file in bytes, and the other limits of docs/reference/language.md.
BYTES = 1 << 20
TERMS, OUTPUTS, RULES, FILES, NAME, OPERATORS, VARIABLES = 1000, 200, 20_000, 64, 200, 100_000, 2000

#: By name a worst case: from a size to the contents of files, the first of which is checked.
CASES: dict[str, Callable[[float], dict[str, str]]] = {}

HEAD = """input x in [0, 1]
  terms low high
output y in [0, 1] else 0
  terms small large
"""
FLL = """Engine: worst
InputVariable: x
  enabled: true
  range: 0.000 1.000
  lock-range: false
  term: low Discrete {}
OutputVariable: y
  enabled: true
  range: 0.000 1.000
  lock-range: false
  aggregation: Maximum
  defuzzifier: Centroid 100
  default: 0.0
  lock-previous: false
  term: small Triangle 0.000 0.500 1.000
RuleBlock: rules
  enabled: true
  conjunction: Minimum
  disjunction: Maximum
  implication: Minimum
  activation: General
  rule: if x is low then y is small
"""
SUGENO = """defuzzifier weighted_average
output y in [0, 1] else 0
  terms small=0 large=1
"""


def case(make):
    """Register a function that yields the pieces of one file, up to the largest size of a file."""
    name = make.__name__.replace("_", "-")
    head = () if "systems" in name else ("system worst\n",)
    CASES[name] = lambda size: {f"{name}.fz": cut(chain(head, make(size)), size)}
    return make


def files_case(make):
    """Register a function that returns several files."""
    CASES[make.__name__.replace("_", "-")] = make
    return make


def cut(pieces: Iterator[str], size: float = 1.0) -> str:
    """Join pieces as long as they fit into a file."""
    found, left = [], int(BYTES * size)
    for piece in pieces:
        left -= len(piece.encode())
        if left < 0:
            break
        found.append(piece)
    return "".join(found)


def repeated(piece, *parts):
    """Yield a beginning, and pieces numbered from 0 for ever."""
    yield from parts
    k = 0
    while True:
        yield piece.replace("@", str(k))
        k += 1


def computed(size, operators, piece, head):
    """Yield a beginning, and pieces of some operators each, until a file may have no more."""
    yield from islice(repeated(piece, head), 1 + int(OPERATORS * size) // operators)


def names(count, prefix="t"):
    return [f"{prefix}{k}" for k in range(int(count))]


# --- lines ---------------------------------------------------------------------------------------------------------


@case
def blank_lines(size):
    yield from repeated("\n", HEAD)


@case
def blank_lines_in_a_parenthesis(size):
    yield from repeated("\n", HEAD, "if (x is low")


@case
def spaces_in_a_line(size):
    yield from repeated(" ", HEAD, "if x is low")


@case
def spaces_before_each_line(size):
    yield from repeated(" " * 1000 + "\n" + " " * 1000 + "@\n", HEAD)


@case
def open_parentheses(size):
    yield from repeated("(", HEAD, "if ")


@case
def an_open_parenthesis_on_each_line(size):
    yield from repeated("a@ (\n", HEAD)


@case
def statements_with_an_open_parenthesis(size):
    yield from repeated("param p@ = (1\n", HEAD)


@case
def quotes(size):
    yield from repeated('"', HEAD, "source ")


@case
def unclosed_quotes(size):
    yield from repeated('source "a\n', HEAD)


@case
def comments(size):
    yield from repeated("# comment @\n", HEAD)


@case
def unknown_lines(size):
    yield from repeated("nonsense @\n", HEAD)


@case
def unknown_keywords(size):
    yield from repeated("imput a@ in [0, 1]\n  terms a b\n", HEAD)


@case
def one_line_of_words(size):
    yield from repeated("word@ ", HEAD)


@case
def one_line_of_one_word(size):
    yield from repeated("w", HEAD)


@case
def one_line_of_digits(size):
    yield from repeated("1", HEAD, "param p = ")


@case
def one_line_of_signs(size):
    yield from repeated("-", HEAD, "param p = ")


@case
def sources(size):
    yield from repeated('source "a book @"\n', HEAD, "if x is low then y is small\n")


@case
def a_long_source(size):
    yield from repeated("a book @ ", HEAD, "if x is low then y is small\n", 'source "')


@case
def rows_without_a_table(size):
    yield from repeated("low | small\n", HEAD)


@case
def rows_without_a_bar(size):
    yield from repeated("low small large\n", HEAD, "table y = x\n  low high\n")


@case
def allow_lines(size):
    yield from repeated('allow FZ2@ FZ208 "because"\n', HEAD, "if x is low then y is small\n")


@case
def combining_marks(size):
    yield from repeated("á̧̧", HEAD, "param ")


# --- names ---------------------------------------------------------------------------------------------------------


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


# --- params and expressions -------------------------------------------------------------------------------------------


@case
def a_chain_of_params(size):
    yield HEAD + "param p0 = 1\n"
    for k in range(1, 1 << 20):
        yield f"param p{k} = p{k - 1} + 1\n"


@case
def a_chain_of_params_backwards(size):
    yield HEAD + "require y <= p0\n"
    for k in range(1 << 20):
        yield f"param p{k} = p{k + 1} + 1\n"


@case
def a_circle_of_params(size):
    count = int(40_000 * size)
    yield HEAD
    for k in range(count):
        yield f"param p{k} = p{(k + 1) % count} + 1\n"


@case
def params_that_double(size):
    yield HEAD + "param p0 = 1\n"
    for k in range(1, 1 << 20):
        yield f"param p{k} = p{k - 1} + p{k - 1}\n"


@case
def params_that_name_all_before(size):
    yield HEAD + "param p0 = 1\n"
    for k in range(1, 1 << 20):
        yield f"param p{k} = max({', '.join(f'p{j}' for j in range(max(0, k - 90), k))})\n"


@case
def params_of_the_same_name(size):
    yield from repeated("param p = @\n", HEAD)


@case
def params_without_use(size):
    yield from repeated("param p@ = @\n", HEAD, "if x is low then y is small\n")


@case
def a_long_sum(size):
    yield from repeated("1 + ", HEAD, "param p = ")


@case
def a_long_function(size):
    yield from repeated("1, ", HEAD, "param p = max(")


@case
def a_function_of_many_arguments(size):
    yield HEAD + "param p = max(" + cut(repeated("1, "), 0.99 * size) + "1)\n"


@case
def long_sums(size):
    yield from computed(size, 89, "param p@ = " + " + ".join(["1"] * 90) + "\n", HEAD)


@case
def long_sums_of_products(size):
    yield from computed(size, 121, "param p@ = " + "+".join(["1*1"] * 61) + "\n", HEAD)


@case
def deep_sums(size):
    yield from computed(size, 90, "param p@ = " + "(1 + " * 90 + "1" + ")" * 90 + "\n", HEAD)


@case
def deep_signs(size):
    yield from computed(size, 90, "param p@ = " + "-" * 90 + "1\n", HEAD)


@case
def deep_powers(size):
    yield from computed(size, 90, "param p@ = " + "2^" * 90 + "1\n", HEAD)


@case
def more_operators_than_allowed(size):
    yield from repeated("param p@ = " + "2^" * 90 + "1\n", HEAD)


@case
def powers_of_powers(size):
    yield from computed(size, 3, "param p@ = 9^9^9^9\n", HEAD)


@case
def long_numbers(size):
    yield from repeated("param p@ = " + "9" * 5000 + "e-4999\n", HEAD)


@case
def functions_as_terms(size):
    terms = "".join(f"  f{k} = function({' + '.join(['x^2'] * 40)} - {k})\n" for k in range(int(TERMS * size)))
    rules = "".join(f"if x is f{k} then y is small\n" for k in range(int(TERMS * size)))
    yield f"input x in [0, 1]\n{terms}{SUGENO}{rules}".replace(" else 0", "")


@case
def own_hedges(size):
    yield from repeated("hedge h@(x) = x^@\n", HEAD, "if x is low then y is small\n")


def hedged_consequents(size, hedge):
    """Yield a system whose consequents have own hedges, each a different one."""
    count = max(1, int(1000 * size))
    hedges = "".join(f"hedge h{k}(x) = {hedge.replace('@', str(k + 1))}\n" for k in range(count))
    terms = "".join(f"  a{k} = gaussian({(k + 1) / (count + 1)}, 0.1)\n" for k in range(count))
    rules = "".join(f"if x is r then y is h{k} a{k}\n" for k in range(count))
    head = "input x in [0, 1]\n  r = ramp(0, 1)\noutput y in [0, 1] else 0\n"
    yield f"{hedges}{head}{terms}{rules}"


@case
def own_hedges_of_consequents(size):
    yield from hedged_consequents(size, "abs(x - @ / 1001)")


@case
def own_hedges_that_turn_often(size):
    yield from hedged_consequents(size, "abs(sin(400 * x)) + exp(-((x - 0.5) / 1e-9)^2) * @")


@case
def own_hedges_that_turn_without_end(size):
    yield from hedged_consequents(size, "sin(@ / x)")


@case
def a_hedge_that_turns_often_in_a_row(size):
    head = "hedge h(x) = sin(290 * x)^2\ninput x in [0, 1]\n  r = ramp(0, 1)\noutput y in [0, 1] else 0\n"
    yield f"{head}  a = gaussian(0.3, 0.1)\nif x is r then y is {'h ' * max(1, int(20 * size))}a\n"


@case
def a_long_hedge_that_turns_often(size):
    yield from hedged_consequents(0.001, f"abs(sin(400 * x)) * ({' + '.join(['x'] * max(1, int(60 * size)))})")


@case
def own_hedges_in_a_row(size):
    heads = "".join(f"hedge h{k}(x) = {' * '.join(['x'] * 80)}\n" for k in range(100))
    rule = "if x is " + " ".join(names(90, "h")) + " low then y is small\n"
    yield from repeated(rule, HEAD.replace(" else 0", ""), heads)


@case
def hedges_in_a_row(size):
    yield from repeated("if x is " + "very " * 90 + "low then y is small\n", HEAD)


@case
def too_many_hedges_in_a_row(size):
    yield from repeated("very ", HEAD, "if x is ")


# --- rules ------------------------------------------------------------------------------------------------------------


def inputs_of(count, terms="a b"):
    return "".join(f"input x{k} in [0, 1]\n  terms {terms}\n" for k in range(count))


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


# --- tables -----------------------------------------------------------------------------------------------------------


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


@case
def a_table_with_many_rows(size):
    yield from repeated("low | small large\n", HEAD, "table y = x x x\n  low high\n")


@case
def a_table_with_one_long_row(size):
    yield from repeated(" small", HEAD, "table y = x\n  low high\n  |")


@case
def a_table_with_a_long_header(size):
    yield from repeated(" low", HEAD, "table y = x\n ")


@case
def tables(size):
    yield from repeated("table y = x\n  low high\n  | small large\n", HEAD)


@case
def tables_under_a_condition(size):
    yield from repeated("with x is low and x is not high\ntable y = x\n  low high\n  | small large\n", HEAD)


@case
def tables_without_a_header(size):
    yield from repeated("table y = x\n", HEAD)


@files_case
def tables_from_one_csv_file(size):
    text = "system worst\n" + HEAD + cut(repeated('table y = x x x from "large.csv"\n'), 0.9 * size)
    return {"tables.fz": text, "large.csv": cut(repeated("low,small\n", "a,low\n"), size)}


@files_case
def tables_from_one_large_csv_file(size):
    text = "system worst\n" + HEAD + cut(repeated('table y = x from "large.csv"\n'), 0.9 * size)
    return {"tables.fz": text, "large.csv": cut(repeated(",small", "a,low,high\n"), size)}


@files_case
def used_files(size):
    count = max(2, int(FILES * size))
    found = {
        "use.fz": "system worst\n"
        + HEAD
        + "".join(f'use "u{k}.fz"\n' for k in range(count))
        + "if x is low then y is small\n"
    }
    for k in range(count):
        found[f"u{k}.fz"] = cut(repeated(f"param p{k}_@ = @ + 1\n"), size)
    return found


@files_case
def used_files_of_inputs(size):
    count = max(2, int(FILES * size))
    found = {
        "use.fz": "system worst\n"
        + HEAD
        + "".join(f'use "u{k}.fz"\n' for k in range(count))
        + "if x is low then y is small\n"
    }
    for k in range(count):
        found[f"u{k}.fz"] = cut(repeated(f"input i{k}_@ in [0, 1]\n  terms a b c d e f g h i j k\n"), size)
    return found


@files_case
def used_files_of_mistakes(size):
    count = max(2, int(FILES * size))
    found = {
        "use.fz": "system worst\n"
        + HEAD
        + "".join(f'use "u{k}.fz"\n' for k in range(count))
        + "if x is low then y is small\n"
    }
    for k in range(count):
        found[f"u{k}.fz"] = cut(repeated("nonsense @\n"), size)
    return found


@files_case
def used_files_that_are_missing(size):
    return {"use.fz": "system worst\n" + HEAD + cut(repeated('use "gone@.fz"\n'), 0.9 * size)}


@files_case
def used_systems(size):
    count = max(2, int(FILES * size))
    uses = "".join(f'use "u{k}.fz"\n' for k in range(count))
    found = {"use.fz": "system worst\n" + HEAD + uses + "if x is low then y is small\nrequire y == nowhere.y\n"}
    for k in range(count):
        found[f"u{k}.fz"] = cut(repeated(f"system s{k}_@\n{HEAD}if x is low then y is small\n"), size)
    return found


@files_case
def a_discrete_term(size):
    points = " ".join(f"{k / 20000:.6g} {k % 2}" for k in range(int(20_000 * size)))
    return {"discrete.fll": FLL.format(points)}


# --- systems ----------------------------------------------------------------------------------------------------------


@case
def small_systems(size):
    yield from repeated(f"system s@\n{HEAD}if x is low then y is small\n")


@case
def systems_of_shared_variables(size):
    yield from repeated("system s@\nif x is low then y is small\n", HEAD)


@case
def systems_that_share_much(size):
    shared = cut(repeated("param p@ = @\ninput i@ in [0, 1]\n  terms a b c d e f g\n", HEAD), 0.5 * size)
    yield from repeated("system s@\nif x is low then y is small\n", shared)


@case
def systems_that_share_a_table(size):
    known = names(100 * size)
    yield f"input x in [0, 1]\n  terms {' '.join(known)}\ninput z in [0, 1]\n  terms {' '.join(known)}\n"
    yield HEAD.split("\n", 2)[2].replace(" else 0", "")
    yield from table(known, known)
    yield from repeated("system s@\n")


@case
def empty_systems(size):
    yield from repeated("system s@\n", HEAD)


@case
def systems_of_one_name(size):
    yield from repeated(f"system s\n{HEAD}if x is low then y is small\n")


@case
def systems_with_claims_about_each_other(size):
    yield from repeated(f"system s@\n{HEAD}if x is low then y is small\nrequire y == s0.y\n")


@case
def systems_in_a_chain_of_claims(size):
    k = 0
    while True:
        yield f"system s{k}\n{HEAD}if x is low then y is small\nrequire y == s{k + 1}.y\n"
        k += 1


# --- claims -----------------------------------------------------------------------------------------------------------

SMALL = HEAD.replace(" else 0", "") + "if x is low then y is small\nif x is high then y is large\n"
SQUARE = inputs_of(2, "a b c d e f g") + "output y in [0, 1]\n  terms small large\n"
SQUARE += "table y = x0 x x1\n  a b c d e f g\n" + "".join(f"{t} | {'small large ' * 3}small\n" for t in "abcdefg")


@case
def claims_that_hold(size):
    yield from repeated("require y <= 1 + @\n", SMALL)


@case
def claims_that_are_refuted(size):
    yield from repeated("require y <= 0.5 + 0 * @\n", SMALL)


@case
def claims_that_are_hard(size):
    yield from computed(size, 4, "require y - y^2 + sin(@ * y) <= 1.25\n", SQUARE)


@case
def claims_about_slopes(size):
    yield from repeated("require lipschitz(y, x0) <= 100 + @\n", SQUARE)


@case
def claims_about_slopes_that_are_refuted(size):
    yield from repeated("require increasing(y, x0)\n", SQUARE)


@case
def claims_of_totality(size):
    yield from repeated("require total(y) >= 0.1\n", SQUARE)


@case
def claims_that_are_long(size):
    yield from computed(size, 90, f"require {' + '.join(['y'] * 90)} <= @ + 100\n", SMALL)


@case
def claims_with_conditions(size):
    yield from repeated("require y <= 1 when " + " and ".join(["x >= 0"] * 40) + "\n", SMALL)


@case
def claims_at_other_points(size):
    yield from computed(size, 39, "require " + " + ".join(f"y(x + {k}, 0)" for k in range(20)) + " <= 1\n", SMALL)


@case
def claims_about_unknown_names(size):
    yield from repeated("require yy@ <= 1\n", SMALL)


@case
def claims_of_unlike_units(size):
    yield from repeated(
        "require y <= x\n",
        SMALL.replace("input x in [0, 1]", 'input x in [0, 1] unit "m"').replace(
            "output y in [0, 1]", 'output y in [0, 1] unit "s"'
        ),
    )


# --- units ------------------------------------------------------------------------------------------------------------


@case
def a_long_unit(size):
    yield from repeated("m^2 s per ", HEAD.replace("y in [0, 1]", 'y in [0, 1] unit "m"'), 'param p = 1 unit "')


@case
def long_units(size):
    unit = " ".join(["m"] * 300)
    yield from repeated(
        f'param p@ = 1 unit "{unit}"\nrequire y <= p@\n', SMALL.replace("y in [0, 1]", f'y in [0, 1] unit "{unit}"')
    )


@case
def a_claim_in_a_long_unit(size):
    unit = cut(repeated("m "), 0.4 * size)
    text = SMALL.replace("y in [0, 1]", f'y in [0, 1] unit "{unit}"')
    yield text + f'param p = 1 unit "{unit}"\nrequire y <= p\n'


# --- sets -------------------------------------------------------------------------------------------------------------


@case
def a_long_piecewise(size):
    yield "input x in [0, 1]\n  low = piecewise(0, 0"
    body = "".join(f", {k / 60000:.6g}, {k % 2}" for k in range(1, int(60_000 * size)))
    yield body + ")\n  high = triangle(0, 1, 2)\n" + HEAD.split("\n", 2)[2] + "if x is low then y is small\n"


@case
def a_long_piecewise_output(size):
    yield "input x in [0, 1]\n  terms low high\noutput y in [0, 1]\n  small = piecewise(0, 0"
    body = "".join(f", {k / 60000:.6g}, {k % 2}" for k in range(1, int(60_000 * size)))
    yield body + ")\n  large = triangle(0, 1, 2)\nif x is low then y is small\nif x is high then y is large\n"


@case
def many_long_piecewise(size):
    points = "".join(f", {k / 600:.6g}, {k % 2}" for k in range(1, int(600 * size)))
    terms = "".join(f"  s{k} = piecewise(0, 0{points})\n" for k in range(int(150 * size)))
    rules = "".join(f"if x is low then y is s{k}\n" for k in range(int(150 * size)))
    yield "input x in [0, 1]\n  terms low high\noutput y in [0, 1]\n" + terms + rules


@case
def many_gaussians(size):
    terms = "".join(f"  s{k} = gaussian({k / 1000}, 0.01)\n" for k in range(int(TERMS * size)))
    rules = "".join(f"if x is low then y is s{k}\n" for k in range(int(TERMS * size)))
    yield "input x in [0, 1]\n  terms low high\noutput y in [0, 1]\n" + terms + rules


@case
def gaussians_as_inputs(size):
    terms = "".join(f"  s{k} = gaussian({k / 1000}, 0.0001)\n" for k in range(int(TERMS * size)))
    yield f"input x in [0, 1]\n{terms}input z in [0, 1]\n{terms}output y in [0, 1]\n  terms small large\n"
    for k in range(int(TERMS * size)):
        yield f"if x is s{k} and z is s{k} then y is small\n"


@case
def gaussians_of_six_inputs(size):
    terms = "".join(f"  s{k} = gaussian({k / 5}, 0.0001)\n" for k in range(6))
    yield "".join(f"input x{k} in [0, 1]\n{terms}" for k in range(6)) + "output y in [0, 1]\n  terms small large\n"
    rng = random.Random(1)
    for _ in range(int(5000 * size)):
        yield "if " + " and ".join(f"x{i} is s{rng.randrange(6)}" for i in range(6)) + " then y is small\n"


@case
def a_million_samples(size):
    yield f"defuzzifier centroid(resolution={int(1_000_000 * size)})\n" + SMALL


@case
def a_million_samples_of_many_terms(size):
    terms = "".join(f"  s{k} = gaussian({k / 1000}, 0.01)\n" for k in range(int(TERMS * size)))
    rules = "".join(f"if x is low then y is s{k}\n" for k in range(int(TERMS * size)))
    yield f"defuzzifier centroid(resolution={int(1_000_000 * size)})\n"
    yield "input x in [0, 1]\n  terms low high\noutput y in [0, 1]\n" + terms + rules


@case
def a_million_samples_of_many_outputs(size):
    outputs = int(OUTPUTS * size)
    yield f"defuzzifier centroid(resolution={int(1_000_000 * size)})\ninput x in [0, 1]\n  terms low high\n"
    yield "".join(f"output y{k} in [0, 1] else 0\n  terms small large\n" for k in range(outputs))
    for t in ("low", "high"):
        yield f"if x is {t} then " + ", ".join(f"y{k} is large" for k in range(outputs)) + "\n"


@case
def a_thousand_samples_of_many_outputs(size):
    outputs = int(OUTPUTS * size)
    known = " ".join(names(100))
    yield f"defuzzifier centroid(resolution=1000)\ninput x in [0, 1]\n  terms {known}\n"
    yield "".join(f"output y{k} in [0, 1]\n  terms {known}\n" for k in range(outputs))
    for t in range(100):
        for k in range(outputs):
            yield f"if x is t{t} then y{k} is t{t}\n"


@case
def inputs_that_jump(size):
    terms = "".join(f"  s{k} = rectangle({k / 100}, {(k + 1) / 100})\n" for k in range(100))
    yield "".join(f"input x{k} in [0, 1]\n{terms}" for k in range(3)) + HEAD.split("\n", 2)[2]
    rng = random.Random(1)
    for _ in range(int(RULES * size)):
        yield "if " + " and ".join(f"x{i} is s{rng.randrange(100)}" for i in range(3)) + " then y is small\n"


@case
def outputs_that_jump(size):
    outputs = int(OUTPUTS * size)
    terms = "".join(f"  s{k} = rectangle({k / 100}, {(k + 1) / 100})\n" for k in range(100))
    yield "".join(f"input x{k} in [0, 1]\n{terms}" for k in range(3))
    yield "".join(f"output y{k} in [0, 1] else 0\n  terms small large\n" for k in range(outputs))
    rng = random.Random(1)
    for k in range(int(RULES * size)):
        antecedent = " and ".join(f"x{i} is s{rng.randrange(100)}" for i in range(3))
        yield f"if {antecedent} then y{k % outputs} is small\n"


@case
def norms_that_are_not_strict(size):
    yield "and bounded_difference\n" + inputs_of(6, "a b c d e") + SUGENO.replace(" else 0", "")
    rng = random.Random(1)
    for _ in range(int(RULES * size)):
        yield "if " + " and ".join(f"x{i} is {rng.choice('abcde')}" for i in range(6)) + " then y is small\n"


@case
def outputs_of_norms_that_are_not_strict(size):
    outputs = int(OUTPUTS * size)
    yield "and bounded_difference\ndefuzzifier weighted_average\n" + inputs_of(4, "a b c")
    yield "".join(f"output y{k} in [0, 1]\n  terms small=0 large=1\n" for k in range(outputs))
    rng = random.Random(1)
    for k in range(int(RULES * size)):
        yield (
            "if " + " and ".join(f"x{i} is {rng.choice('abc')}" for i in range(4)) + f" then y{k % outputs} is small\n"
        )
