"""Files at the limits that docs/reference states: each of a size below its limit, at it or above it."""

import math
from dataclasses import dataclass

HEAD = "input x in [0, 1]\n  terms low high\noutput y in [0, 1] else 0\n  terms small large\n"
SYSTEM = "system s\n" + HEAD + "if x is low then y is small\n"
CONTROLLER = "controller law\ninput e in [-1, 1]\nevery 10 ms\noutput u in [-9, 9] = clamp(e, -1, 1)\n"
PLANT = "plant tank\ninput u\nstate h in [-9, 9] = 0\nder h = u - h\noutput y = h\n"
LOOP = "loop closed\nblock c = law(1 - p.y)\nblock p = tank(c.u)\n"
RUN = "run 1 s step 10 ms\nmeasure m = maximum(abs(p.y))\n"


@dataclass(frozen=True)
class Limit:
    """The largest size of something, and a function from a size to the text of a file, or to several files."""

    most: int
    files: object
    #: The part of the limit that files may exceed it by before they are refused: what is counted is not exact.
    exact: bool = True
    #: What `check` says of the limit, if it is not the number.
    said: str = ""

    def made(self, part):
        """Return files of a part of the limit; above 1 just above it, below 1 at most as large."""
        if part > 1:
            size = self.most + 1 if self.exact else math.ceil(1.03 * self.most) + 1
        else:
            size = max(2, int((1 if self.exact or part < 1 else 0.97) * part * self.most))
        files = self.files(size)
        return {"limit.fz": files} if isinstance(files, str) else files


LIMITS = {}


def limit(most, exact=True, said=""):
    def register(function):
        LIMITS[function.__name__.replace("_", " ")] = Limit(most, function, exact, said)
        return function

    return register


def lines(count, line, first=0):
    """Return numbered lines; '@' is the number and '#' the one before it."""
    return "".join(line.replace("@", str(k)).replace("#", str(k - 1)) for k in range(first, first + count))


@limit(1 << 20)
def bytes_of_a_file(n):
    return SYSTEM + "# " + "Ω" * ((n - len(SYSTEM) - 2) // 2) + "#" * ((n - len(SYSTEM)) % 2)


@limit(64)
def used_files(n):
    used = {f"u{k}.fz": f"function f{k}(x) = x + {k}\n" for k in range(n)}
    return {"limit.fz": "".join(f'use "{name}"\n' for name in used) + SYSTEM + "let z = f0(x)\n", **used}


@limit(1 << 20)
def characters_of_used_files(n):
    first = n // 2
    return {
        "limit.fz": 'use "a.fz"\nuse "b.fz"\n' + SYSTEM,
        "a.fz": "#" * first,
        "b.fz": "#" * (n - first),
    }


@limit(200)
def systems(n):
    return lines(n, SYSTEM.replace("system s", "system s@"))


@limit(20_000, exact=False)
def shared_statements(n):
    return lines(math.ceil(n / 200), "param p@ = 1\n") + systems(200)


@limit(100, exact=False)
def nesting(n):
    return f"param p = {'(' * n}1{')' * n}\n{SYSTEM}"


@limit(100, exact=False)
def nesting_of_a_controller(n):
    return f"{CONTROLLER}output v = {'sin(' * n}e{')' * n}\n{PLANT}{LOOP}{RUN}"


@limit(200)
def letters_of_a_name(n):
    name = "Ω" * n
    controller = CONTROLLER.replace("(e,", f"({name},").replace("output u", f"let {name} = e\noutput u")
    return controller + PLANT + LOOP + RUN


@limit(80_000)
def operators(n):
    rows, rest = divmod(n, 80)
    text = lines(rows, f"param p@ = {' + '.join(['1'] * 81)}\n")
    return text + f"param q = {' + '.join(['1'] * (rest + 1))}\n{SYSTEM}"


@limit(2000)
def lets_of_a_system(n):
    return SYSTEM + lines(n - 2, "let a@ = x + @\n")


@limit(10_000)
def lines_of_a_controller(n):
    return CONTROLLER + "let a0 = e\n" + lines(n - 6, "let a@ = a# + 1\n", 1) + f"output v in [-1, 1] = a{n - 6}\n"


@limit(10_000, exact=False)
def lines_of_a_loop(n):
    text = CONTROLLER + PLANT + LOOP + RUN
    return text + lines(n - text.count("\n") + 2, "let a@ = p.y + @\n")


@limit(10_000, exact=False)
def lines_of_a_plant(n):
    own = max(n - (CONTROLLER + PLANT + LOOP + RUN).count("\n") + 3, 4) // 2
    states = lines(own, "state s@ = 0\nder s@ = u - s@\n")
    return CONTROLLER + PLANT + states + LOOP + RUN


@limit(80_000, exact=False)
def words_of_steps(n):
    points = ", ".join(f"0.0{k:05d} s: {k % 7}" for k in range(max(2, n // 3)))
    return CONTROLLER + PLANT + f"{LOOP}let r = steps({points})\n{RUN}"


@limit(1000)
def terms(n):
    names = " ".join(f"t{k}" for k in range(n))
    return SYSTEM.replace("low high", names).replace("low", "t0") + lines(n - 1, "if x is t@ then y is large\n", 1)


@limit(20_000)
def terms_that_variables_share(n):
    count, per = (math.ceil(n / 100), 100) if n >= 100 else (1, n)
    names = ", ".join(f"x{k}" for k in range(count + 1))
    rules = lines(count + 1, "if x@ is t0 then y is small\n")
    text = f"system s\ninput {names} in [0, 1]\n  terms {' '.join(f't{k}' for k in range(per))}\n"
    return text + HEAD.partition("high\n")[2] + rules


@limit(200)
def outputs(n):
    then = ", ".join(f"y{k} is small" for k in range(n))
    return (
        f"system s\n{HEAD.partition('output')[0]}"
        + lines(n, "output y@ in [0, 1] else 0\n  terms small large\n")
        + (f"if x is low then {then}\n")
    )


@limit(2000)
def inputs_and_outputs(n):
    ends = "output y in [0, 1] else 0\n  terms small large\n" + lines(n - 1, "if x@ is a then y is small\n")
    return "system s\n" + lines(n - 1, "input x@ in [0, 1]\n  terms a b\n") + ends


@limit(20_000)
def rules(n):
    count = max(math.isqrt(n), 2)
    names = " ".join(f"t{k}" for k in range(count))
    text = f"system s\ninput x, z in [0, 1]\n  terms {names}\n{HEAD.partition('high' + chr(10))[2]}"
    # Cells of a table, as rules written out have more words than a file may hold.
    table = f"table y = x x z\n  {names}\n" + lines(count, f"t@ | {'small ' * count}\n")
    return text + table + lines(max(n - count * count, 0), "if x is t0 then y is small\n")


@limit(20_000, exact=False)
def cells_of_a_table(n):
    names = [f"t{k}" for k in range(max(2, math.isqrt(n)))]
    rows = "".join(f"  {row} | {' '.join(names)}\n" for row in names)
    text = f"system s\ninput x, z in [0, 1]\n  terms {' '.join(names)}\noutput y in [0, 1] terms of x\n"
    return f"{text}table y = x x z\n  {' '.join(names)}\n{rows}"


@limit(100_000, exact=False)
def parts_of_own_hedges(n):
    count = max(2, n // 179)
    text = f"system s\nhedge h(x) = {' * '.join(['x'] * 90)}\ninput x in [0, 1]\n"
    text += f"  terms {' '.join(f't{k}' for k in range(count))}\n{HEAD.partition('high' + chr(10))[2]}"
    return text + lines(count, "if x is h t@ then y is small\n")


@limit(1_000_000)
def samples_of_a_centroid(n):
    return SYSTEM.replace("system s\n", f"system s\ndefuzzifier centroid(resolution={n})\n")


@limit(200)
def systems_called(n):
    return f"{SYSTEM}system top\n{HEAD}if x is low then y is small\n" + lines(n, "let a@ = s.y(x)\n")


@limit(20_000, exact=False)
def rules_of_systems_called(n):
    called = SYSTEM + lines(min(n, 199), "if x is low then y is small weight 0.@\n")
    return called + f"system top\n{HEAD}if x is low then y is small\n" + lines(max(1, n // 200), "let a@ = s.y(x)\n")


@limit(1_000_000)
def count_of_an_activation(n):
    return SYSTEM.replace("system s\n", f"system s\nactivation first(count={n})\n")


@limit(2_000, exact=False)
def parts_of_functions_of_a_system(n):
    each = max(1, n // 50)
    return f"function f(x) = {' + '.join(['x'] * 25)}\n{SYSTEM}let a = {' + '.join(['f(x)'] * min(each, 90))}\n"


@limit(5_000, exact=False)
def operations_of_a_claim(n):
    count = max(1, n // 90)
    lets = lines(count, f"let a@ = {' + '.join(['x'] * 45)}\n")
    claim = " + ".join(f"a{k}" for k in range(count))
    return SYSTEM + lets + f"require y <= 1 + {claim}\n"


@limit(50_000, exact=False)
def parts_of_a_controller(n):
    return f"function f(x) = {' + '.join(['sin(x)'] * 80)}\n{CONTROLLER}" + lines(
        max(1, n // 246), "output v@ = f(e + @)\n"
    )


@limit(100_000, exact=False)
def parts_of_a_file(n):
    outputs = lines(max(1, n // 4 // 246), "output v@ = f(e + @)\n")
    return f"function f(x) = {' + '.join(['sin(x)'] * 80)}\n" + "".join(
        CONTROLLER.replace("law", f"law{k}") + outputs for k in range(5 if n > 100_000 else 4)
    )


@limit(200, exact=False)
def nesting_of_functions(n):
    functions = "function f0(x) = x\n" + lines(n // 2, "function f@(x) = f#(x) + 1\n", 1)
    return functions + CONTROLLER + f"output v = f{n // 2 - 2}(e)\n" + PLANT + LOOP + RUN


@limit(20)
def controllers_inside_controllers(n):
    chain = "controller c1\ninput e\noutput u = e + previous(e)\n"
    chain += lines(n, "controller c@\ninput e\nblock b = c#(e)\noutput u = b.u\n", 2)
    return chain + CONTROLLER.replace("law", "top") + PLANT


@limit(100_000)
def samples_of_delays(n):
    rest = n % 10
    return (
        CONTROLLER
        + lines(10, f"output v@ in [-1, 1] = delay(e * @, {n // 10})\n")
        + (f"output w in [-1, 1] = delay(e, {rest})\n" if rest else "")
    )


@limit(10_000)
def samples_of_a_delay(n):
    return CONTROLLER + f"output v in [-1, 1] = delay(e, {n})\n" + PLANT + LOOP + RUN


@limit(10_000_000)
def samples_of_a_run(n):
    return CONTROLLER + PLANT + LOOP + f"run {n} ms step 1 ms\n"


@limit(10_000_000, exact=False)
def samples_of_a_run_without_a_step(n):
    return CONTROLLER.replace("10 ms", "1 ms") + PLANT + LOOP + f"run {n} ms\n"


@limit(100_000_000, exact=False)
def numbers_of_a_run(n):
    return CONTROLLER + PLANT + LOOP + lines(94, "let a@ = p.y + @\n") + f"run {n // 99} ms step 1 ms\n"


@limit(10_000, exact=False)
def steps_of_a_dead_time(n):
    plant = f"plant tank = tf(num=[1], den=[1, 1], delay={1 / n!r} s)\n"
    return CONTROLLER.replace("10 ms", "1 s") + plant + LOOP + "run 9 s step 1 s\n"


@limit(20_000_000, exact=False)
def steps_of_dead_times(n):
    plant = "plant tank = tf(num=[1], den=[1, 1], delay=0.001 s)\n"
    return CONTROLLER.replace("10 ms", "1 s") + plant + LOOP + f"run {n // 1000} s step 1 s\n"


@limit(20_000_000, exact=False)
def numbers_of_dead_times(n):
    return CONTROLLER + f"plant tank = tf(num=[1], den=[1, 1], delay={n / 400!r} s)\n" + LOOP + RUN


@limit(1000)
def guarantees_of_a_system(n):
    return SYSTEM + lines(n, "require y <= 1 + @\n")


@limit(25_000)
def terms_of_a_system(n):
    counts = [min(1000, max(n - 4, 0) - first) for first in range(0, max(n - 4, 0), 1000)]
    names = [" ".join(f"t{i}" for i in range(count)) for count in counts]
    return SYSTEM + "".join(f"input x{k} in [0, 1]\n  terms {own}\n" for k, own in enumerate(names))
