"""Worst cases of loops: blocks, signals with many points, measures, requirements."""

from worst_files.case import EQUATIONS, computed, cut, file_case, files_case, names, repeated, repetitions

BLOCKS = """controller law
input e in [-1, 1]
output u = e + integral(0.1 * e)
every 10 ms
plant tank
input u
state h in [-9, 9] = 0
der h = u - h
output y = h
"""
TOP = BLOCKS + "loop worst\nblock c = law(1 - p.y)\nblock p = tank(c.u)\nrun 1 s step 10 ms\n"

repetitions(
    {
        "loop-lets": ("let a@ = p.y + @\n", TOP),
        "loop-lets-of-unknown-names": ("let a@ = q@.y + 1\n", TOP),
        "loop-measures": ("measure m@ = iae(p.y, 1)\n", TOP),
        "loop-measures-of-unknown-kinds": ("measure m@ = aie(p.y, 1)\n", TOP),
        "loop-requirements": ("require m <= 1 + @\n", TOP, "measure m = iae(p.y, 1)\n"),
        "loop-requirements-of-unknown-measures-among-many": ("measure m@ = iae(p.y, 1)\nrequire q@ <= 1\n", TOP),
        "loop-requirements-of-unknown-measures": ("require mm@ <= 1\n", TOP),
        "loop-noises": ("let a@ = noise(0.1, seed=@)\n", TOP),
        "loop-blocks": ("block b@ = law(1)\n", TOP),
        "loop-blocks-of-unknown-names": ("block b@ = lwa(1)\n", TOP),
        "loop-run-lines": ("run 1 s step 10 ms\n", TOP),
        "loops-of-one-file": ("loop l@\nblock c = law(1 - p.y)\nblock p = tank(c.u)\nrun 1 s\n", BLOCKS),
        "loops-of-one-name": ("loop l\nblock c = law(1 - p.y)\nblock p = tank(c.u)\nrun 1 s\n", BLOCKS),
        "loop-tables-that-are-missing": ('let a@ = csv("gone@.csv", column="y")\n', TOP),
    },
    head="",
)


@file_case
def a_loop_with_steps_of_many_points(size):
    points = ", ".join(f"{k} ms: {k}" for k in range(int(30_000 * size)))
    yield TOP + f"let a = steps({points})\n"


@file_case
def loop_steps_of_some_points(size):
    points = ", ".join(f"{k} ms: {k}" for k in range(90))
    yield from repeated(f"let a@ = steps({points})\n", TOP)


@file_case
def a_loop_with_steps_out_of_order(size):
    points = ", ".join(f"{-k} ms: {k}" for k in range(int(30_000 * size)))
    yield TOP + f"let a = steps({points})\n"


@file_case
def loop_lets_in_a_chain(size):
    count = int(EQUATIONS * size)
    yield TOP + "let a0 = p.y\n"
    yield from (f"let a{k} = a{k - 1} + 1\n" for k in range(1, count))
    yield f"measure m = iae(a{count - 1}, 1)\n"


@file_case
def loop_lets_that_double(size):
    count = int(EQUATIONS * size)
    yield TOP + "let a0 = p.y\n"
    yield from (f"let a{k} = a{k - 1} * a{k - 1}\n" for k in range(1, count))
    yield f"measure m = iae(a{count - 1}, 1)\n"


@file_case
def loop_blocks_in_a_chain(size):
    count = max(2, int(1500 * size))
    yield TOP + "block b0 = tank(c.u)\n"
    yield from (f"block b{k} = tank(b{k - 1}.y)\n" for k in range(1, count))


@file_case
def loop_blocks_in_an_algebraic_loop(size):
    count = max(2, int(1500 * size))
    yield TOP
    yield from (f"block b{k} = law(b{(k + 1) % count}.u)\n" for k in range(count))


@file_case
def loop_blocks_of_a_large_plant(size):
    order = max(2, int(40 * size))
    row = f"[{', '.join(['-1'] * order)}]"
    ones = ", ".join(["1"] * order)
    yield f"plant large = ss(A=[{', '.join([row] * order)}], B=[{ones}], C=[{ones}])\n{TOP}"
    yield from (f"block b{k} = large(c.u)\n" for k in range(int(9 * size) + 1))


@file_case
def loop_blocks_with_long_dead_times(size):
    yield f"plant slow = tf(num=[1], den=[1, 1], delay=1e6 s)\n{TOP}"
    yield from (f"block b{k} = slow(c.u)\n" for k in range(int(900 * size)))


@file_case
def loop_measures_in_a_chain(size):
    count = int(EQUATIONS * size)
    yield TOP + "measure m0 = iae(p.y, 1)\n"
    yield from (f"measure m{k} = m{k - 1} + 1\n" for k in range(1, count))


@file_case
def loop_measures_that_are_long(size):
    yield from computed(size, 40, "measure m@ = " + " + ".join(["iae(p.y, 1)"] * 41) + "\n", TOP)


@file_case
def loop_requirements_that_are_long(size):
    head = TOP + "measure m = iae(p.y, 1)\n"
    yield from computed(size, 90, f"require {' + '.join(['m'] * 90)} <= @ + 100\n", head)


@file_case
def a_loop_of_more_samples_than_allowed(size):
    yield TOP.replace("run 1 s step 10 ms", "run 1e9 s step 1e-9 s")


@files_case
def loop_tables(size):
    columns = names(90, "c")
    rows = (f"{k}," + ",".join(["0.5"] * 90) + "\n" for k in range(1 << 20))
    text = TOP + "".join(f'let a{k} = csv("large.csv", column="c{k}")\n' for k in range(max(1, int(90 * size))))
    return {"loop.fz": text, "large.csv": "t," + ",".join(columns) + "\n" + cut(rows, 0.99 * size)}


@files_case
def loop_used_files(size):
    blocks = {f"u{k}.fz": cut(repeated(f"controller c{k}_@\ninput e\noutput u = e\n"), size) for k in range(60)}
    return {"loop.fz": "".join(f'use "{file}"\n' for file in blocks) + TOP, **blocks}
