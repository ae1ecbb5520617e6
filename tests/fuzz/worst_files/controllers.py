"""Worst cases of controllers: states, lets, operators with state, instances, systems inside, claims."""

from worst_files.case import EQUATIONS, HEAD, computed, cut, file_case, names, repeated, repetitions

TOP = "controller worst\ninput e in [-1, 1]\nevery 10 ms\noutput u = e\n"
SYSTEM = "system fuzzy\n" + HEAD.replace(" else 0", "") + "if x is low then y is small\nif x is high then y is large\n"

repetitions(
    {
        "controller-lets": ("let a@ = e + @\n", TOP),
        "controller-lets-of-unknown-names": ("let a@ = ee@ + 1\n", TOP),
        "controller-lets-of-reserved-names": ("let and = e + @\n", TOP),
        "controller-lets-of-one-name": ("let a = e + @\n", TOP),
        "controller-params": ("param p@ in [0, 1e9] = @\n", TOP),
        "controller-inputs": ("input a@ in [0, 1]\n", TOP),
        "controller-outputs": ("output a@ in [-1, 1] = e\n", TOP),
        "controller-states": ("state s@ in [-1, 1] = 0\nnext s@ = clamp(e, -1, 1)\n", TOP),
        "controller-states-without-next": ("state s@ in [-1, 1] = 0\n", TOP),
        "controller-states-that-grow": ("state s@ = 0\nnext s@ = s@ + e\n", TOP),
        "controller-previous": ("let a@ = previous(e)\n", TOP),
        "controller-integrals": ("let a@ = integral(e, hold=a@ > 1)\noutput b@ = a@\n", TOP),
        "controller-claims": ("require u <= 1 + @\n", TOP),
        "controller-claims-that-are-refuted": ("require u <= 0.5\n", TOP),
        "controller-statements-of-plants": ("der s@ = 1\n", TOP),
        "controller-every-lines": ("every 5 ms\n", TOP),
        "controller-blocks-of-unknown-names": ("block b@ = wrost(e)\n", TOP),
        "controllers-of-one-file": ("controller c@\ninput e\noutput u = e\n",),
        "controllers-of-one-name": ("controller c\ninput e\noutput u = e\n",),
        "controllers-in-a-long-chain": ("controller c@\ninput e\nblock b = c0(e)\noutput u = b.u\n",),
    },
    head="",
)


def linked(size, count, piece, ends):
    """Yield a controller of numbered pieces; each may name the one before it as '#'."""
    many = max(2, int(count * size))
    yield TOP + "let a0 = e\n"
    yield from (piece.replace("@", str(k)).replace("#", str(k - 1)) for k in range(1, many))
    yield ends.replace("@", str(many - 1))


@file_case
def controller_lets_in_a_chain(size):
    yield from linked(size, EQUATIONS, "let a@ = a# + 1\n", "output v = a@\n")


@file_case
def controller_lets_in_a_chain_with_a_claim(size):
    yield from linked(size, 5000, "let a@ = sin(a#)\n", "output v in [-1, 1] = a@\n")


@file_case
def controller_lets_that_double(size):
    yield from linked(size, EQUATIONS, "let a@ = a# * a#\n", "output v in [-1, 1] = a@\n")


@file_case
def controller_lets_in_a_circle(size):
    count = int(EQUATIONS * size)
    yield TOP
    yield from (f"let a{k} = a{(k + 1) % count} + 1\n" for k in range(count))


@file_case
def controller_operators_in_a_chain(size):
    yield from linked(size, 4000, "let a@ = lowpass(a#, 0.1)\n", "output v in [-1, 1] = a@\n")


@file_case
def controller_operators_in_an_expression(size):
    yield TOP
    for k in range(int(100 * size)):
        yield f"output a{k} = " + "previous(" * 60 + "e" + ")" * 60 + "\n"


@file_case
def controller_states_that_read_each_other(size):
    count = int(2000 * size)
    yield TOP
    for k in range(count):
        yield f"state s{k} in [-1, 1] = 0\nnext s{k} = clamp(0.5 * s{(k + 1) % count} + 0.5 * e, -1, 1)\n"


@file_case
def controller_states_that_read_all(size):
    count = max(2, int(80 * size))
    yield TOP
    for k in range(count):
        terms = " + ".join(f"0.01 * s{j}" for j in range(count))
        yield f"state s{k} in [-1, 1] = 0\nnext s{k} = clamp({terms}, -1, 1)\n"


@file_case
def a_controller_function_of_many_parameters(size):
    yield TOP + f"function f({', '.join(f'y{k}' for k in range(int(90_000 * size)))}) = 1\n"


@file_case
def a_controller_instance_with_many_arguments(size):
    given = ", ".join(f"a{k}=1" for k in range(int(48_000 * size)))
    yield f"controller inner\ninput e\noutput u = e\n{TOP}block b = inner({given})\n"


@file_case
def controller_instances_taken_for_values(size):
    yield "controller inner\ninput e\noutput u = e\n" + TOP
    yield from (f"block b{k} = inner(e)\nlet a{k} = b{k} + 1\n" for k in range(int(4900 * size)))


@file_case
def a_controller_with_a_long_delay(size):
    yield TOP + f"output v in [-1, 1] = delay(e, {max(1, int(10_000 * size))})\n"


@file_case
def a_controller_with_long_delays(size):
    yield TOP
    yield from (
        f"output v{k} in [-1, 1] = delay(e * {k}, {max(1, int(10_000 * size))})\n" for k in range(int(99 * size))
    )


@file_case
def a_controller_with_a_delay_that_is_too_long(size):
    yield TOP + "output v in [-1, 1] = delay(e, 1e300)\n"


@file_case
def controllers_in_controllers(size):
    count = max(2, int(19 * size))
    yield from (
        f"controller c{k}\ninput e\nblock b = c{k + 1}(e)\noutput u = b.u + previous(e)\n" for k in range(count)
    )
    yield f"controller c{count}\ninput e\noutput u = e\n"


@file_case
def controllers_in_controllers_twice(size):
    count = max(2, int(19 * size))
    for k in range(count):
        yield f"controller c{k}\ninput e\nblock a = c{k + 1}(e)\nblock b = c{k + 1}(-e)\noutput u = a.u + b.u\n"
    yield f"controller c{count}\ninput e\noutput u = e + previous(e)\n"


@file_case
def controllers_in_controllers_deeper_than_allowed(size):
    count = max(2, int(2000 * size))
    yield from (f"controller c{k}\ninput e\nblock b = c{k + 1}(e)\noutput u = b.u\n" for k in range(count))
    yield f"controller c{count}\ninput e\noutput u = e\n"


@file_case
def controllers_in_a_circle(size):
    count = max(2, int(2000 * size))
    for k in range(count):
        yield f"controller c{k}\ninput e\nblock b = c{(k + 1) % count}(e)\noutput u = b.u\n"


@file_case
def controller_instances(size):
    yield "controller inner\ninput e\noutput u = e + previous(e)\n" + TOP
    yield from (f"block b{k} = inner(e * {k})\n" for k in range(int(4000 * size)))


@file_case
def controller_instances_in_a_chain(size):
    count = max(2, int(2000 * size))
    yield "controller inner\ninput e\noutput u = lowpass(e, 0.1)\n" + TOP + "block b0 = inner(e)\n"
    yield from (f"block b{k} = inner(b{k - 1}.u)\n" for k in range(1, count))
    yield f"output v in [-1, 1] = b{count - 1}.u\n"


@file_case
def controller_calls_of_systems(size):
    yield SYSTEM + TOP
    yield from (f"let a{k} = fuzzy(e * {k})\noutput v{k} in [0, 1] = a{k}\n" for k in range(int(900 * size)))


@file_case
def controller_calls_of_systems_in_a_chain(size):
    count = max(2, int(400 * size))
    yield SYSTEM + TOP + "let a0 = e\n"
    yield from (f"let a{k} = fuzzy(a{k - 1})\n" for k in range(1, count))
    yield f"output v in [0, 1] = a{count - 1}\n"


@file_case
def controller_calls_of_a_large_system(size):
    known = names(max(2, 100 * size))
    rows = cut(f"{row} | {' '.join(known)}\n" for row in known)
    yield f"system large\ninput x, z in [-1, 1]\n  terms {' '.join(known)}\noutput k in [-1, 1] terms of x\n"
    yield f"table k = x x z\n  {' '.join(known)}\n{rows}{TOP}"
    yield from (f"output v{k} in [-1, 1] = large(e, e * {k})\n" for k in range(int(10 * size) + 1))


@file_case
def controller_calls_of_a_system_with_state(size):
    known = names(max(2, 90 * size))
    rows = cut(f"{row} | {' '.join(known)}\n" for row in known)
    yield f"system adaptive\ndefuzzifier weighted_average\ninput x, z in [-1, 1]\n  terms {' '.join(known)}\n"
    yield f"output k in [-1, 1] adaptive rate x\n  terms {' '.join(f'{n}={i / 100}' for i, n in enumerate(known))}\n"
    yield f"table k = x x z\n  {' '.join(known)}\n{rows}{TOP}output v in [-1, 1] = adaptive(e, -e)\n"


@file_case
def controller_claims_that_are_hard(size):
    head = TOP + "let a = lowpass(e, 0.1)\nlet b = integral(sin(a) - 0.1)\noutput v = clamp(a * b, -1, 1)\n"
    yield from computed(size, 4, "require v - v^2 + sin(@ * v) * a <= 1.25\n", head)


@file_case
def controller_claims_that_are_long(size):
    yield from computed(size, 90, f"require {' + '.join(['u'] * 90)} <= @ + 100\n", TOP)


@file_case
def controller_claims_about_systems(size):
    head = SYSTEM + TOP + "output v in [0, 1] = fuzzy(abs(e))\n"
    yield from computed(size, 2, "require v * u <= 1 + @\n", head)


@file_case
def controller_conditions(size):
    condition = " and ".join(f"e > {k} / 90" for k in range(40))
    yield from computed(size, 120, f"output a@ = where({condition}, 1, 0)\n", TOP)


@file_case
def controller_units(size):
    unit = " ".join(["m"] * 300)
    yield from repeated(f'param p@ = 1 unit "{unit}"\nlet a@ = p@ + previous(p@)\n', TOP)


@file_case
def controllers_of_all_parts_as_allowed(size):
    """Yield a function that expands to as many parts as a controller may have."""
    yield f"function f(x) = {' + '.join(['sin(x)'] * 90)}\n{TOP}"
    yield from (f"output v{k} = f(e + {k})\n" for k in range(int(180 * size)))


@file_case
def controllers_of_more_parts_than_allowed(size):
    yield f"function f(x) = {' + '.join(['sin(x)'] * 90)}\n{TOP}"
    yield from (f"output v{k} = f(f(e + {k}))\n" for k in range(int(1800 * size)))
