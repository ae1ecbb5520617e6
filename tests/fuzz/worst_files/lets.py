"""Worst cases of lets, and of calls of other systems in them."""

from worst_files.case import EQUATIONS, HEAD, case, computed, cut, file_case, inputs_of, names, repeated, repetitions

RULES = "if x is low then y is small\nif x is high then y is large\n"
CALLED = "system called\ninput x in [0, 1]\n  terms low high\noutput k in [0, 1]\n  terms small large\n"
CALLED += RULES.replace("y is", "k is")

repetitions(
    {
        "lets-without-use": ("let a@ = x\n", HEAD, RULES),
        "lets-of-one-name": ("let a = x + @\n", HEAD, RULES),
        "lets-of-unknown-names": ("let a@ = xx@ + 1\n", HEAD, RULES),
        "lets-with-terms": ("let a@ in [0, 1] = x\n  terms low high\n", HEAD, RULES),
        "lets-without-a-value": ("let a@ = \n", HEAD, RULES),
        "a-let-of-many-operands": ("x + ", HEAD, RULES, "let a = "),
        "outputs-that-are-formulas": ("output a@ in [0, 1] = x + @\n", HEAD, RULES),
    }
)


def chained(size, first, step, use):
    """Yield a system with lets that name the one before, as many as allowed, and what uses them."""
    yield HEAD + RULES + first
    count = int(EQUATIONS * size)
    yield from (step.replace("@", str(k)).replace("#", str(k - 1)) for k in range(1, count))
    yield use.replace("@", str(count - 1))


@case
def a_chain_of_lets(size):
    yield from chained(size, "let a0 = x\n", "let a@ = a# + 1\n", "output z in [0, 1] = a@\n")


@case
def a_chain_of_lets_with_calls(size):
    yield from chained(size, "let a0 = x\n", "let a@ = sin(a#)\n", "output z in [-1, 1] = a@\n")


@case
def a_chain_of_lets_backwards(size):
    count = int(EQUATIONS * size)
    yield HEAD + RULES + "output z in [0, 1] = a0\n"
    yield from (f"let a{k} = a{k + 1} + 1\n" for k in range(count))
    yield f"let a{count} = x\n"


@case
def a_circle_of_lets(size):
    count = int(EQUATIONS * size)
    yield HEAD + RULES
    yield from (f"let a{k} = a{(k + 1) % count} + 1\n" for k in range(count))


@case
def lets_that_double(size):
    yield from chained(size, "let a0 = x\n", "let a@ = a# * a#\n", "output z in [0, 1] = a@\n")


@case
def a_few_lets_that_double(size):
    yield HEAD + RULES + "let a0 = x\n"
    yield from (f"let a{k} = a{k - 1} * a{k - 1}\n" for k in range(1, 60))
    yield "output z in [0, 1] = a59\nrequire z <= 1\n"


@case
def lets_that_name_all_before(size):
    count = int(2000 * size)
    yield HEAD + RULES + "let a0 = x\n"
    for k in range(1, count):
        yield f"let a{k} = max({', '.join(f'a{j}' for j in range(max(0, k - 40), k))})\n"
    yield f"output z in [0, 1] = a{count - 1}\n"


@case
def deep_lets(size):
    yield from computed(size, 90, "let a@ = " + "(x + " * 90 + "1" + ")" * 90 + "\n", HEAD + RULES)


@case
def deep_lets_with_percentages(size):
    yield from computed(size, 90, "let a@ = " + "(x + " * 90 + "50%" + ")" * 90 + "\n", HEAD + RULES)


@case
def long_lets(size):
    yield from computed(size, 90, "let a@ = " + " + ".join(["x * 1"] * 45) + "\n", HEAD + RULES)


@case
def many_uses_of_one_let(size):
    count = int(4000 * size)
    yield inputs_of(1) + "let s in [0, 1] = " + "sin(" * 80 + "x0" + ")" * 80 + "\n  terms N Z P\n"
    yield "defuzzifier weighted_average\noutput y in [0, 1] else 0\n"
    yield from (f"if s is {'NZP'[k % 3]} and x0 is a then y is function({k} * s)\n" for k in range(count))


@case
def many_uses_of_a_chain_of_lets(size):
    count = int(90 * size)
    yield HEAD.replace("else 0\n", "else 0 defuzzifier weighted_average\n") + "let a0 = x\n"
    yield from (f"let a{k} = a{k - 1} + sin(a{k - 1})\n" for k in range(1, max(2, count)))
    yield from (
        f"if x is low then y is function({' + '.join(f'a{j}' for j in range(max(2, count)))} + {k})\n"
        for k in range(int(900 * size))
    )


@case
def as_many_lets_with_terms_as_allowed(size):
    count, known = int(1800 * size), names(10)
    yield HEAD
    yield from (f"let a{k} in [0, 1] = x * {k}\n  terms {' '.join(known)}\n" for k in range(count))
    yield from (f"if a{k % count} is {known[k % 10]} then y is small\n" for k in range(int(18_000 * size)))


@case
def one_rule_over_lets(size):
    count = max(2, int(300 * size))
    yield HEAD.replace(" else 0", "")
    yield from (f"let a{k} in [0, 1] = x * {k}\n  terms low high\n" for k in range(count))
    nested = " and ".join(
        "(" + " and ".join(f"a{k} is low" for k in range(start, min(start + 60, count))) + ")"
        for start in range(0, count, 60)
    )
    yield f"if {nested} then y is small\n"


@case
def claims_about_outputs_of_lets(size):
    head = inputs_of(2, "a b c") + "let s in [-1, 1] = sin(9 * x0) * cos(7 * x1)\n  terms N Z P\n"
    head += "output y in [0, 1]\n  terms small large\nif s is N then y is small\notherwise y is large\n"
    yield from computed(size, 4, "require y - y^2 + sin(@ * y) <= 1.25\n", head)


@case
def rates_of_lets(size):
    yield HEAD.replace("else 0\n", "else 0 adaptive rate a999\n").replace("terms small large", "terms small=0 large=1")
    yield "defuzzifier weighted_average\nlet a0 = x\n"
    yield from (f"let a{k} = a{k - 1} + sin(x * {k})\n" for k in range(1, 1000))
    yield RULES


@file_case
def calls_of_other_systems(size):
    yield CALLED + "system caller\n" + HEAD + RULES
    yield from (f"let a{k} = called.k(x * {k})\n" for k in range(int(2000 * size)))
    yield "output z in [0, 1] = a0\n"


@file_case
def calls_of_other_systems_in_use(size):
    count = max(2, int(2000 * size))
    yield CALLED + "system caller\n" + HEAD + RULES
    yield from (f"let a{k} = called.k(x * {k})\n" for k in range(count))
    yield f"output z in [0, 1] = max({', '.join(f'a{k}' for k in range(min(count, 4000)))})\n"


@file_case
def systems_that_call_each_other_in_a_chain(size):
    count = max(2, int(190 * size))
    for k in range(count):
        call = f"let c = s{k + 1}.y(x)\noutput z in [0, 1] = c\n" if k + 1 < count else ""
        yield f"system s{k}\n{HEAD}{RULES}{call}"


@file_case
def systems_that_call_each_other_twice(size):
    count = max(2, int(190 * size))
    for k in range(count):
        call = f"let c = s{k + 1}.y(s{k + 1}.y(x))\noutput z in [0, 1] = c\n" if k + 1 < count else ""
        yield f"system s{k}\n{HEAD}{RULES}{call}".replace("y in [0, 1] else 0", "y in [0, 1]")


@file_case
def systems_whose_called_output_doubles(size):
    """Yield systems that call the next one twice, so that the number of calls doubles."""
    count = max(2, int(40 * size))
    for k in range(count):
        call = f"let c = s{k + 1}.z(x) + s{k + 1}.z(x / 2)\n" if k + 1 < count else "let c = x\n"
        yield f"system s{k}\n{HEAD}{RULES}{call}output z in [0, 1] = c\n"


@file_case
def systems_that_call_in_a_circle(size):
    count = max(2, int(190 * size))
    for k in range(count):
        yield f"system s{k}\n{HEAD}{RULES}let c = s{(k + 1) % count}.z(x)\noutput z in [0, 1] = c\n"


@file_case
def calls_of_a_large_system(size):
    known = names(max(2, 100 * size))
    rows = cut(f"{row} | {' '.join(known)}\n" for row in known)
    yield f"system called\ninput x in [0, 1]\n  terms {' '.join(known)}\ninput z in [0, 1] terms of x\n"
    yield f"output k in [0, 1] terms of x\ntable k = x x z\n  {' '.join(known)}\n{rows}"
    yield "system caller\n" + HEAD + RULES
    yield from (f"let a{k} = called.k(x, x * {k})\noutput z{k} in [0, 1] = a{k}\n" for k in range(int(150 * size)))


@file_case
def calls_of_unknown_systems(size):
    yield CALLED + "system caller\n" + HEAD + RULES
    yield from repeated("let a@ = caled.k(x)\nlet b@ = called.j(x)\nlet c@ = called.k(x, 1)\n")
