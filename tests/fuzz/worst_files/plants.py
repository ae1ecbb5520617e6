"""Worst cases of plants: states, derivatives, dead time, plants of one line."""

from worst_files.case import EQUATIONS, HEAD, computed, cut, file_case, files_case, repeated, repetitions

TOP = "plant worst\ninput u in [-1, 1]\noutput y = u\n"

repetitions(
    {
        "plant-states": ("state s@ = 0\nder s@ = u\n", TOP),
        "plant-states-without-derivatives": ("state s@ = 0\n", TOP),
        "plant-derivatives-without-states": ("der s@ = 0\n", TOP),
        "plant-lets-of-unknown-names": ("let a@ = uu@ + 1\n", TOP),
        "plant-outputs": ("output a@ = u\n", TOP),
        "plant-statements-of-controllers": ("every 5 ms\nlet a@ = previous(u)\n", TOP),
        "plant-delays": ("output a@ = delay(u, @ ms)\n", TOP),
        "plants-of-one-line": ("plant p@ = tf(num=[1], den=[1, 2, 1])\n",),
        "plants-of-one-line-that-are-not-proper": ("plant p@ = tf(num=[1, 2, 1], den=[1, 1])\n",),
        "plants-of-one-name": ("plant p = tf(num=[1], den=[1, 2, 1])\n",),
        "plants-in-python-that-are-missing": ('plant p@ = python("gone@.py")\n',),
        "a-transfer-function-that-is-open": ("1, ", "plant p = tf(num=[1], den=["),
    },
    head="",
)


@file_case
def plant_lets_in_a_chain(size):
    count = int(EQUATIONS * size)
    yield TOP + "let a0 = u\n"
    yield from (f"let a{k} = a{k - 1} + 1\n" for k in range(1, count))
    yield f"output z = a{count - 1}\n"


@file_case
def plant_lets_that_double(size):
    count = int(EQUATIONS * size)
    yield TOP + "let a0 = u\n"
    yield from (f"let a{k} = a{k - 1} * a{k - 1}\n" for k in range(1, count))
    yield f"output z = a{count - 1}\n"


@file_case
def plant_lets_in_a_circle(size):
    count = int(EQUATIONS * size)
    yield TOP
    yield from (f"let a{k} = a{(k + 1) % count} + 1\n" for k in range(count))


@file_case
def plant_states_that_read_all(size):
    count = max(2, int(150 * size))
    yield TOP
    terms = " + ".join(f"s{j}" for j in range(min(90, count)))
    yield from (f"state s{k} = 0\nder s{k} = u - {k} * ({terms})\n" for k in range(count))


@file_case
def plant_calls_of_systems(size):
    yield "system fuzzy\n" + HEAD + "if x is low then y is small\nif x is high then y is large\n" + TOP
    yield from (f"output v{k} = fuzzy(u * {k})\n" for k in range(int(900 * size)))


@file_case
def a_plant_of_a_long_expression(size):
    yield from computed(size, 90, "output a@ = " + " + ".join(["u * 1"] * 45) + "\n", TOP)


def numbers(count):
    return ", ".join(str(k % 9 + 1) for k in range(max(2, count)))


@file_case
def a_transfer_function_of_high_order(size):
    count = int(300 * size)
    yield f"plant p = tf(num=[{numbers(count)}], den=[{numbers(count + 1)}])\n"


@file_case
def a_transfer_function_of_very_high_order(size):
    yield f"plant p = tf(num=[1], den=[{numbers(int(300_000 * size))}])\n"


@file_case
def transfer_functions_of_high_order(size):
    yield from repeated(f"plant p@ = tf(num=[{numbers(40)}], den=[{numbers(41)}])\n")


@file_case
def zeros_and_poles_of_high_order(size):
    count = max(2, int(300 * size))
    roots = ", ".join(f"-{k + 1}" for k in range(count))
    yield f"plant p = zpk(zeros=[{roots}], poles=[{roots}], gain=1)\n"


@file_case
def zeros_and_poles_of_very_high_order(size):
    roots = ", ".join(["pair(-1, 2)"] * max(2, int(40_000 * size)))
    yield f"plant p = zpk(zeros=[{roots}], poles=[{roots}], gain=1)\n"


def matrices(order):
    row = f"[{', '.join(['-1'] * order)}]"
    return f"ss(A=[{', '.join([row] * order)}], B=[{', '.join(['1'] * order)}], C=[{', '.join(['1'] * order)}])"


@file_case
def matrices_of_high_order(size):
    yield f"plant p = {matrices(max(2, int(90 * size)))}\n"


@file_case
def matrices_of_very_high_order(size):
    yield f"plant p = {matrices(max(2, int(500 * size)))}\n"


@file_case
def matrices_that_do_not_fit(size):
    order = max(2, int(90 * size))
    yield from repeated(f"plant p@ = {matrices(order).replace('B=[1, ', 'B=[')}\n")


@files_case
def a_plant_in_python_of_many_states(size):
    count = int(30_000 * size)
    lines = f"inputs = ('u',)\nstates = {{{', '.join(f'{chr(39)}x{k}{chr(39)}: 0.0' for k in range(count))}}}\n"
    lines += "outputs = ('y',)\ndef derivatives(t, x, u):\n    return x\ndef output(t, x, u):\n    return x[:1]\n"
    return {"plant.fz": 'plant p = python("cart.py")\n', "cart.py": lines}


@files_case
def plants_in_python_of_one_file(size):
    lines = "inputs = ('u',)\nstates = {'x': 0.0}\noutputs = ('y',)\n"
    lines += "def derivatives(t, x, u):\n    return x\ndef output(t, x, u):\n    return x\n"
    lines += cut(repeated("a@ = 1\n"), 0.9 * size)
    return {"plant.fz": cut(repeated('plant p@ = python("cart.py")\n'), 0.1 * size), "cart.py": lines}
