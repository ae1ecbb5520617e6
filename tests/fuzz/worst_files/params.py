"""Worst cases of params, expressions and own hedges."""

from worst_files.case import HEAD, SUGENO, TERMS, case, computed, cut, names, repeated, repetitions

repetitions(
    {
        "params-of-the-same-name": ("param p = @\n", HEAD),
        "params-without-use": ("param p@ = @\n", HEAD, "if x is low then y is small\n"),
        "a-long-sum": ("1 + ", HEAD, "param p = "),
        "a-long-function": ("1, ", HEAD, "param p = max("),
        "more-operators-than-allowed": ("param p@ = " + "2^" * 90 + "1\n", HEAD),
        "long-numbers": ("param p@ = " + "9" * 5000 + "e-4999\n", HEAD),
        "own-hedges": ("hedge h@(x) = x^@\n", HEAD, "if x is low then y is small\n"),
        "hedges-in-a-row": ("if x is " + "very " * 90 + "low then y is small\n", HEAD),
        "too-many-hedges-in-a-row": ("very ", HEAD, "if x is "),
    }
)


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
def powers_of_powers(size):
    yield from computed(size, 3, "param p@ = 9^9^9^9\n", HEAD)


@case
def functions_as_terms(size):
    terms = "".join(f"  f{k} = function({' + '.join(['x^2'] * 40)} - {k})\n" for k in range(int(TERMS * size)))
    rules = "".join(f"if x is f{k} then y is small\n" for k in range(int(TERMS * size)))
    yield f"input x in [0, 1]\n{terms}{SUGENO}{rules}".replace(" else 0", "")


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
