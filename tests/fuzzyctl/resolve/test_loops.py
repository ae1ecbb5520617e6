"""Mistakes in loops: each with its code, its message, its location and its repair."""

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import look_through
from fuzzyctl.model.loop import MEASURES, SIGNALS
from tests.fuzzyctl.resolve.mistakes import errors_in, require_one

BLOCKS = """controller law
input r unit "m"
input y unit "m"
param k in [0, 10] = 2
output v unit "V" = k * (r - y)

plant tank
input v unit "V"
state h = 0
der h = v - h
output y unit "m" = h
output through = h + v
"""
LINES = "loop l\nblock law = law(r=r, y=tank.y)\nblock tank = tank(law.v)\nlet r = steps(0: 1)\n"
RUN = "run 1 s step 10 ms\n"

#: What is added to a loop, and the one mistake in it: code, message, location, part of the repair.
MISTAKES = {
    "let a = zz": ("FZ202", "no name 'zz'", "zz", ""),
    "let a = tank": ("FZ214", "'tank' has several outputs", "tank", "tank.y, tank.through"),
    "let a = law": ("FZ214", "'law' is a block, not a value", "law", "law.v"),
    "let a = tank.h": ("FZ202", "no name 'tank.h'", "tank.h", "did you mean 'tank.y'"),
    "let t = 1": ("FZ201", "'t' is a word of loops and cannot name a let", "t", "rename it"),
    "block b = tank()": ("FZ303", "'tank' lacks a value for: v", "tank", ""),
    "block b = tank(1, 2)": ("FZ303", "'tank' takes 1 input, not 2", "tank(1, 2", ""),
    "block b = tnak(1)": ("FZ202", "no controller or plant 'tnak'", "tnak(1", "did you mean 'tank'?"),
    "block b = furnace(1)": ("FZ202", "no controller or plant 'furnace'", "furnace(1", "'use' a file"),
    "block b = tank(w=1)": ("FZ202", "'tank' has no input or param 'w'", "w=1", ""),
    "block b = law(1, 2, k=11)": ("FZ302", "param 'k' of 'law' is 11, outside of [0, 10]", "11", ""),
    "block b = law(1, 2, k=r)": ("FZ202", "no param 'r'", "r", "'r' is a let, which may change while it runs"),
    "let z = 2\nblock b = law(1, 2, k=1/z)": ("FZ202", "no param 'z'", "z", "write 'param z = 2' in place of it"),
    "block b = 3": ("FZ214", "expected a call of a controller or plant", "3", "the form is: block b ="),
    "block b = tf(num=[1], den=[1, 1])": (
        "FZ214",
        "'tf' makes a plant, which is a block of its own",
        "tf(",
        "write above the loop: plant NAME = tf(",
    ),
    "block b = l()": ("FZ202", "no controller or plant 'l'", "l", "did you mean 'law'?"),
    "let a = law(1, 2)": ("FZ214", "'law' is a controller, which has a state of its own", "law(1, 2", "block NAME ="),
    "let a = tf(num=[1], den=[1])": ("FZ214", "'tf' belongs to plants of one line", "tf(", "above the loop"),
    "let a = previous(r)": ("FZ214", "'previous' belongs to controllers", "previous(r", "put it into a controller"),
    "let a = delay(r, 1 s)": ("FZ214", "'delay' belongs to controllers", "delay(r, 1 s", "plant lag = tf("),
    "let a = overshoot(tank.y, r)": (
        "FZ214",
        "'overshoot' is a measure, which only 'measure' lines may call",
        "overshoot(",
        "measure NAME = overshoot(y, reference)",
    ),
    "measure m = noise(1)": (
        "FZ214",
        "'noise' is a signal of time, which only 'let' and 'block' lines may call",
        "noise(1",
        "'let'",
    ),
    "measure m1 = 1 + m2\nmeasure m2 = 2 * m1": ("FZ220", "measure 'm1' depends on itself", "m1", "from signals"),
    "measure m1 = final(tank.y) - m1": ("FZ220", "measure 'm1' depends on itself", "m1", "from signals"),
    "measure m = tank.y": ("FZ202", "no measure or param 'tank.y'", "tank.y", "such as: maximum(tank.y)"),
    "measure m = iae(tank.y)": ("FZ303", "wrong arguments of 'iae'", "iae(tank.y", "the form is: iae(y, reference)"),
    "measure m = settling(tank.y, r, band=tank.y)": ("FZ202", "no param 'tank.y'", "tank.y", ""),
    "measure m = settling(tank.y, r, bnd=2 %)": ("FZ303", "wrong arguments of 'settling'", "settling(", "band=2 %"),
    "measure m = settling(tank.y, r, band=0)": (
        "FZ302",
        "'band' of 'settling' is 0: expected a positive number",
        "0",
        "the form is",
    ),
    "measure m = mean(tank.y, begin=2, end=1)": (
        "FZ304",
        "'end' of 'mean' is 1, not above 'begin', 2",
        "1",
        "smaller one first",
    ),
    "measure m = iae(tank.y, noise(1))": (
        "FZ214",
        "'noise' is a signal of time, which only 'let' and 'block' lines may call",
        "noise(1",
        "'let'",
    ),
    "measure m = iae(mean(tank.y), r)": (
        "FZ214",
        "'mean' is a measure, which only 'measure' lines may call",
        "mean(",
        "measure NAME = mean(x)",
    ),
    "measure m = setling(tank.y, r)": (
        "FZ202",
        "no function or system 'setling'",
        "setling(",
        "did you mean 'settling'",
    ),
    "let a = stesp(0: 1)": ("FZ202", "no function or system 'stesp'", "stesp(", "did you mean 'steps'"),
    "function f(a) = a * noise(1)\nlet b = f(r)": (
        "FZ214",
        "'noise' is a signal of time, which only 'let' and 'block' lines may call",
        "noise(1",
        "'let'",
    ),
    "require tank.y < 1": (
        "FZ202",
        "no measure or param 'tank.y'",
        "tank.y",
        "such as: maximum(tank.y), in a 'measure' line",
    ),
    "require iae(tank.y, r) < 1": (
        "FZ214",
        "'iae' is a measure, which only 'measure' lines may call",
        "iae(tank.y, r",
        "measure NAME = iae(y, reference)",
    ),
    "measure m = final(tank.y)\nrequire m": ("FZ307", "expected a condition, found a number", "m", "compare it"),
    "measure m = final(tank.y)\nrequire m < 1 when m > 2": (
        "FZ214",
        "'when' belongs to systems and controllers",
        "m > 2",
        "into the claim",
    ),
    "let a = steps(1, 2)": ("FZ303", "'steps' takes pairs of a time and a value", "1", "steps(0: 1.0"),
    "let a = steps()": ("FZ303", "'steps' takes pairs of a time and a value", "steps", "steps(0: 1.0"),
    "let a = steps(2 s: 1, 1 s: 0)": (
        "FZ305",
        "the times of 'steps' do not ascend: 1 s follows 2 s",
        "1 s",
        "in order",
    ),
    "let a = steps(0: tank.y)": ("FZ202", "no param 'tank.y'", "tank.y", ""),
    "let a = pulse(2 s, 1 s)": ("FZ304", "'end' of 'pulse' is 1, not above 'begin', 2", "1 s", "smaller one first"),
    "let a = pulse(2 s)": ("FZ303", "wrong arguments of 'pulse'", "pulse(", "the form is: pulse(begin, end)"),
    "let a = ramp(1, 1)": ("FZ304", "'end' of 'ramp' is 1, not above 'begin', 1", "1", "give 'end' a value above 1"),
    "measure m = final(tank.y, end=0 s)": (
        "FZ304",
        "'end' of 'final' is 0, not above 'begin', 0",
        "0 s",
        "give 'end' a value above 0",
    ),
    "let a = b\nlet b = a": (
        "FZ220",
        "algebraic loop: 'a' depends on itself within one sample",
        "a",
        "compute one of them from the outputs of blocks or the time",
    ),
    "block t = tank(1)\nlet a = t.y": ("FZ201", "'t' is a word of loops and cannot name a block", "t", "rename it"),
    "let total = 1": ("FZ201", "'total' is a word of the language and cannot name a let", "total", "rename it"),
    "let a = if r > 0 then 1 else 2": ("FZ102", "unexpected 'r'", "r", "where(CONDITION, VALUE, OTHER_VALUE)"),
    "let a = sine(0)": ("FZ302", "'frequency' of 'sine' is 0: expected a positive number", "0", "sine(frequency"),
    "let a = noise(sigma=-1)": ("FZ302", "'sigma' of 'noise' is -1: expected 0 or more", "-1", "noise(sigma"),
    "let a = noise(1, seed=1.5)": ("FZ302", "'seed' of 'noise' is 1.5: expected a whole number", "1.5", ""),
    'let a = csv("d.csv", column="y")': ("FZ218", "a text that is no file can use no files", '"d.csv"', ""),
    'let a = csv(3, column="a")': ("FZ303", "expected a text for 'file'", "3", 'csv("file.csv"'),
    "let a = r + 1 +": ("FZ102", "the line ends too early", "+", ""),
    "let a = 1/0": ("FZ307", "division by zero", "1/0", "give the divisor a value other than 0"),
    "block c = law(1/0, 2)": ("FZ307", "division by zero", "1/0", "give the divisor a value other than 0"),
    "let a = steps(0: 1/0)": ("FZ307", "division by zero", "1/0", "give the divisor a value other than 0"),
    "measure m = log(-1) * final(tank.y)": (
        "FZ307",
        "an argument lies outside the function's domain",
        "log(-1",
        "log those above 0",
    ),
    RUN: ("FZ215", "'run' is given twice", "run 1 s step 10 ms", "remove one"),
    "input u": ("FZ101", "'input' belongs to a controller, not to a loop", "input", "let NAME = steps(0: 1.0)"),
    "output u = r": ("FZ101", "'output' belongs to a controller, not to a loop", "output", "let NAME = EXPRESSION"),
    "state s = 0": ("FZ101", "'state' belongs to a controller, not to a loop", "state", "add that as a block"),
    "every 5 ms": ("FZ101", "'every' belongs to a controller, not to a loop", "every", "run 50 s step 10 ms"),
    "measrue m = 1": ("FZ101", "unexpected 'measrue': did you mean 'measure'?", "measrue", "measure m = 1"),
}

#: The lines of `run`, with the one mistake in each.
RUNS = {
    "": ("FZ212", "loop 'l' has no 'run' line", "l", "add: run 50 s step 10 ms"),
    "run 0 s": ("FZ302", "the duration is 0 s, not positive", "0 s", "run 50 s"),
    "run -1 s": ("FZ302", "the duration is -1 s, not positive", "-1 s", "run 50 s"),
    "run inf": ("FZ302", "the duration is inf s, not finite", "inf", "run 50 s"),
    "run 1 s step 0": ("FZ302", "the step is 0 s, not positive", "0", "step 10 ms"),
    "run 1 s step 2 s": ("FZ302", "the step is 2 s, longer than the run of 1 s", "2 s", "shorten the step"),
    "run 1 h step 1 us": (
        "FZ302",
        "the run has 3,600,000,000 samples, more than 10,000,000",
        "1 us",
        "lengthen the step",
    ),
    "run tank.y": ("FZ202", "no param 'tank.y'", "tank.y", ""),
    "run 1/0": ("FZ307", "division by zero", "1/0", ""),
    "run 10 ms 1 s": ("FZ102", "unexpected '1 s'", "1 s", "run 50 s step 10 ms"),
}

#: Loops around blocks, and the chain of names where they are algebraic.
AROUND = {
    "block a = law(r=1, y=b.through)\nblock b = tank(a.v)": "a.v → a.y → b.through → b.v",
    "block a = law(r=1, y=m)\nblock b = tank(a.v)\nlet m = 2 * b.through": "a.v → a.y → m → b.through → b.v",
    "block c = tank(1)\nlet a = b\nlet b = a": "a → b",
    "block a = law(r=1, y=b.y)\nblock b = tank(a.v)": "",
    "block a = law(r=1, y=a.v)": "a.v → a.y",
    "block b = tank(b.y * 2)": "",
}


class TestMistakes:
    @pytest.mark.parametrize("text", MISTAKES)
    def test_each_is_reported_alone_with_its_repair(self, text):
        require_one(BLOCKS + LINES + RUN + text + "\n", MISTAKES[text])

    @pytest.mark.parametrize("text", RUNS)
    def test_the_duration_is_checked(self, text):
        require_one(BLOCKS + LINES + text + "\n", RUNS[text])

    def test_a_loop_without_blocks_is_incomplete(self):
        require_one("loop l\n" + RUN, ("FZ212", "loop 'l' has no blocks", "l", "add a controller and a plant"))

    def test_all_are_found_at_once(self):
        text = BLOCKS + LINES + "let a = zz\nmeasure m = iae(tank.y)\nrequire m\nrun 0 s\nlet b = noise(-1)\nfoo\n"
        assert sorted(code for code, _, _ in errors_in(text)) == [
            "FZ101", "FZ202", "FZ302", "FZ302", "FZ303", "FZ307",
        ]  # fmt: skip

    def test_known_functions_are_listed_in_the_same_order_in_every_process(self):
        text = SourceText("c.fz", BLOCKS + LINES + RUN + "let a = step(0: 1)")
        (error,) = [d for d in look_through(text).diagnostics if d.severity == "error"]
        names = ", ".join(dict.fromkeys([*SIGNALS, *MEASURES]))
        assert error.facts[0].endswith(f"where, {names}")

    def test_a_mistake_inside_a_block_is_reported_once(self):
        text = BLOCKS.replace("der h = v - h", "der h = q") + LINES + RUN
        assert [message for _, message, _ in errors_in(text)] == ["no name 'q'"]

    def test_connected_units_are_compared(self):
        wrong = LINES.replace("tank(law.v)", "tank(tank.y)")
        message = "'tank.y' is measured in m, 'tank' takes V"
        require_one(BLOCKS + wrong + RUN, ("FZ312", message, "tank.y", "one unit"))

    def test_units_are_known_through_names(self):
        wrong = LINES.replace("tank(law.v)", "tank(v=level)") + "let level = clamp(tank.y, 0, 1)\n"
        message = "'level' is measured in m, 'tank' takes V"
        require_one(BLOCKS + wrong + RUN, ("FZ312", message, "level", "one unit"))


class TestAlgebraicLoops:
    @pytest.mark.parametrize("text", AROUND)
    def test_only_outputs_that_follow_their_input_at_once_close_one(self, text):
        found = errors_in(BLOCKS + "loop l\n" + text + "\n" + RUN)
        assert [code for code, _, _ in found] == (["FZ220"] if AROUND[text] else [])

    def test_its_members_are_named(self):
        for text, chain in AROUND.items():
            found = look_through(SourceText("c.fz", BLOCKS + "loop l\n" + text + "\n" + RUN)).diagnostics
            members = {n for d in found for n in d.facts[0].split(" → ") if d.code == "FZ220"}
            assert members == set(chain.split(" → ")) - {""}

    def test_operators_with_memory_and_dead_time_break_one(self):
        controller = "controller law\ninput y\noutput v = previous(y)\n"
        plant = "plant tank = tf(num=[1, 2], den=[1, 3])\n"
        loop = "loop l\nblock a = law(b.y)\nblock b = tank(a.v)\n" + RUN
        assert errors_in(controller + plant + loop) == []
        direct = controller.replace("previous(y)", "y")
        assert [code for code, _, _ in errors_in(direct + plant + loop)] == ["FZ220"]
        assert errors_in(direct + plant.replace("])", "], delay=1 s)").replace("2], delay=1 s)", "2]", 1) + loop) == []


def test_every_signal_and_measure_has_a_form_that_can_be_read():
    lines = "".join(f"let a{k} = {s.form}\n" for k, s in enumerate(SIGNALS.values()) if "csv" not in s.form)
    renamed = {"begin": "1", "end": "2", "sigma": "0.1", "frequency": "2"}
    for name, value in renamed.items():
        lines = (
            lines.replace(f"({name}", f"({value}").replace(f" {name},", f" {value},").replace(f" {name})", f" {value})")
        )
    names = "let y = tank.y\nlet reference = r\nlet x = r\nlet u = law.v\n"
    measures = "".join(f"measure m{k} = {m.form}\n" for k, m in enumerate(MEASURES.values()))
    assert errors_in(BLOCKS + LINES + names + lines + measures + RUN) == []
