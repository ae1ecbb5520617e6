"""Worst cases of functions of a file, as calls and as kinds of terms."""

from worst_files.case import EQUATIONS, HEAD, SUGENO, TERMS, case, computed, file_case, names, repetitions

RULES = "if x is low then y is small\nif x is high then y is large\n"

repetitions(
    {
        "functions-without-use": ("function f@(x) = x + @\n", HEAD, RULES),
        "functions-of-one-name": ("function f(x) = x + @\n", HEAD, RULES),
        "functions-of-unknown-names": ("function f@(x) = xx@ + 1\n", HEAD, RULES),
        "a-function-with-many-parameters": (", a@", HEAD, RULES, "function f(x"),
        "terms-of-an-unknown-function": ("  t@ = hmup(1, 2)\n", "function hump(x, a, b) = x + a + b\n", HEAD),
    }
)


@case
def functions_in_a_chain(size):
    count = int(EQUATIONS * size)
    yield HEAD + RULES + "function f0(x) = x\n"
    yield from (f"function f{k}(x) = f{k - 1}(x) + 1\n" for k in range(1, count))
    yield f"output z in [0, 1] = f{count - 1}(x)\n"


@case
def a_function_of_many_parameters(size):
    parameters = names(max(2, 40_000 * size))
    yield f"{HEAD}{RULES}function f({', '.join(parameters)}) = t0 + t1\n"
    yield f"let a = f({', '.join(['x'] * len(parameters))})\noutput z in [0, 2] = a\n"


@case
def functions_in_a_circle(size):
    count = int(EQUATIONS * size)
    yield HEAD + RULES
    yield from (f"function f{k}(x) = f{(k + 1) % count}(x) + 1\n" for k in range(count))
    yield "output z in [0, 1] = f0(x)\n"


@case
def functions_that_double(size):
    yield HEAD + RULES + "function f0(x) = x\n"
    yield from (f"function f{k}(x) = f{k - 1}(x) + f{k - 1}(x / 2)\n" for k in range(1, 40))
    yield "let a = f39(x)\noutput z in [0, 1] = a\n"


@case
def functions_whose_argument_doubles(size):
    yield HEAD + RULES + "function f(x) = x + x\n"
    yield "let a = " + "f(" * 60 + "x" + ")" * 60 + "\noutput z in [0, 1] = a\n"


@case
def calls_of_functions(size):
    yield from computed(size, 5, "let a@ = f(x, @) + f(x, 1)\n", f"function f(x, a) = a * x + 1\n{HEAD}{RULES}")


@case
def calls_of_functions_in_use(size):
    count = int(2000 * size)
    yield f"function f(x, a) = {' + '.join(['sin(a * x)'] * 20)}\n{HEAD}{RULES}let a0 = x\n"
    yield from (f"let a{k} = f(a{k - 1}, {k})\n" for k in range(1, count))
    yield f"output z in [0, 1] = a{count - 1}\n"


@case
def functions_as_kinds_of_terms(size):
    terms = "".join(f"  f{k} = hump({k}, 2)\n" for k in range(int(TERMS * size)))
    rules = "".join(f"if x is f{k} then y is small\n" for k in range(int(TERMS * size)))
    hump = f"function hump(x, c, w) = {' + '.join(['((x - c) / w)^2'] * 20)}\n"
    yield f"{hump}input x in [0, 1]\n{terms}{SUGENO}{rules}".replace(" else 0", "")


@case
def functions_as_kinds_of_terms_of_many_inputs(size):
    yield "function hump(x, c, w) = 1 / (1 + ((x - c) / w)^2)\n"
    for k in range(int(900 * size)):
        yield f"input a{k} in [0, 1]\n" + "".join(f"  f{j} = hump({j}, {k + 1})\n" for j in range(20))
    yield HEAD + RULES


@case
def functions_as_kinds_of_output_terms(size):
    count = max(1, int(200 * size))
    terms = "".join(f"  f{k} = hump({k / count}, 0.1)\n" for k in range(count))
    rules = "".join(f"if x is low then y is f{k}\n" for k in range(count))
    yield "function hump(x, c, w) = exp(-((x - c) / w)^2)\ndefuzzifier centroid(resolution=1000)\n"
    yield f"{HEAD.split('  terms small')[0]}{terms}{rules}".replace(" else 0", "")


@file_case
def functions_of_all_systems(size):
    yield from computed(0.3 * size, 4, "function g@(x, a) = a * x + sin(x) - 1\n", "")
    yield from (f"system s{k}\n{HEAD}{RULES}let a = g1(x, 2)\n" for k in range(max(2, int(190 * size))))
