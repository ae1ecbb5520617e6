"""Controllers, plants and loops of a file: what they may contain, and how large they may be."""

import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import look_through
from tests.commands import runner

HEAD = "controller c\ninput x\n"
PLANT = "plant p\ninput x\n"
RULE = """system rule
input e in [-1, 1]
  terms N P
output u in [-1, 1]
  terms N P
table u = e
  N P
| N P
"""


def found_in(text):
    return look_through(SourceText("c.fz", text)).diagnostics


def large(count):
    doubling = "".join(f"function f{k}(x) = f{k - 1}(x) * f{k - 1}(x + 1)\n" for k in range(1, count))
    nested = "".join(f"function f{k}(x) = {'(' * 40}f{k - 1}(x){'*2)' * 40}\n" for k in range(1, count))
    inside = "".join(
        f"controller c{k}\ninput x\nblock a = c{k - 1}(x)\nblock b = c{k - 1}(x)\noutput y = a.y + b.y\n"
        for k in range(1, count)
    )
    first = "function f0(x) = x + 1\n"
    return {
        "functions that double": (first + doubling + HEAD + f"output y = f{count - 1}(x)\n", "FZ112"),
        "functions that nest": (first + nested + HEAD + f"output y = f{count - 1}(x)\n", "FZ106"),
        "functions of plants that double": (first + doubling + PLANT + f"output y = f{count - 1}(x)\n", "FZ112"),
        "functions of plants that nest": (first + nested + PLANT + f"output y = f{count - 1}(x)\n", "FZ106"),
        "functions of loops that double": (
            first + doubling + PLANT + f"output y = x\nloop l\nblock b = p(f{count - 1}(t))\nrun 1 s\n",
            "FZ112",
        ),
        "delays in a row": (HEAD + f"output y = {'delay(' * (count // 3)}x{', 10000)' * (count // 3)}\n", "FZ112"),
        "controllers that double": ("controller c0\ninput x\noutput y = previous(x)\n" + inside, "FZ112"),
    }


class TestSize:
    @pytest.mark.parametrize("kind", large(2))
    def test_what_grows_without_bounds_is_a_mistake(self, kind):
        text, code = large(40)[kind]
        assert code in [d.code for d in found_in(text)]

    def test_a_long_chain_of_equations_is_no_mistake(self):
        chain = "".join(f"let a{k} = a{k + 1} + 1\n" for k in range(2000))
        assert found_in(HEAD + chain + "let a2000 = x\noutput y = a0\n") == []


class TestNames:
    @pytest.mark.parametrize("first", ["controller c\ninput x\noutput y = x\n", RULE.replace("rule", "c")])
    @pytest.mark.parametrize(
        "second", ["controller c\ninput x\noutput y = 2 * x\n", "plant c = tf(num=[1], den=[1, 1])\n"]
    )
    def test_two_blocks_of_one_name_are_reported(self, first, second):
        (found,) = [d for d in found_in(first + second) if d.severity == "error"]
        assert (found.code, found.message) == ("FZ201", "there is a block 'c' already")


#: Lines of a controller that call what has another name, and what they were to call.
MISSPELT = {
    "let a = rlue(x)": ("rule", ("systems: distant, rule",)),
    "let a = distnat(x)": ("distant", ("systems: distant, rule",)),
    "block a = innr(x)": ("inner", ("controllers: inner",)),
    "let a = zzzzzz(x)": ("", ("systems: distant, rule",)),
    "block a = rlue(x)": ("", ("controllers: inner",)),
    "block a = outer(x)": ("", ()),  # it is the block itself, which a message of its own is about
}


class TestMisspeltCalls:
    @pytest.mark.parametrize("line", MISSPELT)
    def test_the_name_that_was_meant_is_suggested(self, line, tmp_path):
        (tmp_path / "distant.fz").write_text(RULE.replace("system rule", "system distant"), encoding="utf-8")
        text = 'use "distant.fz"\n' + RULE + HEAD.replace(" c", " inner") + "output y = x\n"
        text += HEAD.replace(" c", " outer") + line + "\noutput y = x\n"
        meant, facts = MISSPELT[line]
        found = look_through(SourceText(str(tmp_path / "a.fz"), text), folder=tmp_path).diagnostics
        (mistake,) = [d for d in found if d.severity == "error"]
        assert tuple(f for f in mistake.facts if not f.startswith("functions")) == facts or not facts
        assert (f"did you mean '{meant}'?" in (mistake.help or "")) == bool(meant)
        assert (mistake.fix.replacements[0].text if mistake.fix is not None else "") == meant


class TestFiles:
    def test_a_loop_uses_the_controllers_and_plants_of_other_files(self, tmp_path):
        (tmp_path / "law.fz").write_text("controller law\ninput e\noutput v = e\n", encoding="utf-8")
        (tmp_path / "lag.fz").write_text("plant lag = tf(num=[1], den=[1, 1])\n", encoding="utf-8")
        text = 'use "law.fz"\nuse "lag.fz"\nloop l\nblock a = law(1 - b.y)\nblock b = lag(a.v)\nrun 1 s step 1 ms\n'
        (tmp_path / "loop.fz").write_text(text, encoding="utf-8")
        loop = fuzzyctl.load(tmp_path / "loop.fz", block=fuzzyctl.Loop)
        assert ([c.name for c in loop.controllers], [p.name for p in loop.plants]) == (["law"], ["lag"])
        assert fuzzyctl.load(tmp_path / "lag.fz", block=fuzzyctl.Plant).name == "lag"
        with pytest.raises(DiagnosticError, match="holds no plant"):
            fuzzyctl.load(tmp_path / "law.fz", block=fuzzyctl.Plant)
        with pytest.raises(DiagnosticError, match="holds no block 'k'"):
            fuzzyctl.load(tmp_path / "loop.fz", block="k")

    def test_a_file_uses_the_controllers_and_systems_of_another(self, tmp_path):
        (tmp_path / "parts.fz").write_text(RULE + HEAD + "output y = 2 * rule(x)\n", encoding="utf-8")
        text = 'use "parts.fz"\ncontroller top\ninput x\nblock a = c(x)\noutput z = a.y + rule(x)\n'
        (tmp_path / "top.fz").write_text(text, encoding="utf-8")
        step = fuzzyctl.compile(fuzzyctl.load(tmp_path / "top.fz", block=fuzzyctl.Controller), "python")
        assert step(1.0, step.start(), dt=1.0)[0] == 3 * fuzzyctl.load(tmp_path / "parts.fz")(e=1.0)

    def test_one_of_several_is_named(self, tmp_path):
        (tmp_path / "two.fz").write_text(HEAD + "output y = x\n" + HEAD.replace("c\n", "d\n", 1) + "output y = x\n")
        assert fuzzyctl.load(tmp_path / "two.fz", block="d").name == "d"
        for name, message in ((None, "several controllers"), ("e", "no block 'e'")):
            with pytest.raises(DiagnosticError, match=message):
                fuzzyctl.load(tmp_path / "two.fz", block=name)

    def test_the_only_block_or_the_only_system_needs_no_name(self, tmp_path):
        (tmp_path / "one.fz").write_text(HEAD + "output y = x\n", encoding="utf-8")
        assert fuzzyctl.load(tmp_path / "one.fz").kind == "controller"
        assert fuzzyctl.loads(HEAD + "output y = x\n" + RULE).kind == "system"
        assert fuzzyctl.loads(HEAD + "output y = x\n" + RULE, block="c").kind == "controller"

    def test_a_file_of_systems_holds_no_controller(self, tmp_path):
        (tmp_path / "one.fz").write_text(RULE, encoding="utf-8")
        with pytest.raises(DiagnosticError, match="holds no controller"):
            fuzzyctl.load(tmp_path / "one.fz", block=fuzzyctl.Controller)


CART = """plant cart
param mass = 2
param friction = 0.5
input force
state x = 0
state v = 0
let drag = friction * v
der x = v
der v = (force - drag) / mass
output y = x
"""
PI = """controller c
param limit = 2
param T = 10 ms
param low = -1
input e in [low, 1]
state i = 0
state sum in [-5, 5] = 0
let u = i + e
let near = abs(e) < 0.5
next i = i + dt * e
next sum = clamp(sum + e, -5, 5)
output y = u
every T
require y <= 1e9 when near
"""
LOOP = """loop l
param size = 1
param length = 5
let wanted = steps(0: size)
block a = cart(wanted)
measure error = rms(wanted - a.y)
run length step 10 ms
"""


class TestUnreadNames:
    def unread(self, text):
        """Return the codes and names of the warnings of a text, which has no mistakes."""
        diagnostics = found_in(text)
        assert {d.severity for d in diagnostics} <= {"warning"}
        return {(d.code, d.span.text) for d in diagnostics}

    @pytest.mark.parametrize("text", [CART, PI.replace("param limit = 2\n", ""), CART + LOOP])
    def test_names_with_an_effect_give_no_warning(self, text):
        assert self.unread(text) == set()

    @pytest.mark.parametrize(
        ("text", "old", "new", "names"),
        [
            (CART, " / mass", "", "mass"),
            (CART, " - drag", "", "friction drag"),
            (CART, "(force - drag)", "(1 - drag)", "force"),
            (CART, "y = x", "y = v", "x"),
            (CART, "friction * v", "friction * v + 0 * x", ""),
            (PI, "u = i + e", "u = e", "limit i"),
            (PI, " when near", "", "limit near"),
            (PI, "sum in [-5, 5]", "sum", "limit sum"),
            (PI, "every T", "every 10 ms", "limit T"),
            (PI, "e in [low, 1]", "e in [-1, 1]", "limit low"),
            (PI, "y <= 1e9", "y <= limit", ""),
            (CART + LOOP, "steps(0: size)", "steps(0: 1)", "size"),
            (CART + LOOP, "run length", "run 5 s", "length"),
            (CART + LOOP, "cart(wanted)", "cart(2, mass=size)", ""),
            (CART + LOOP, "run length", "let gust = pulse(1 s, 2 s)\nrun length", "gust"),
        ],
    )
    def test_names_without_an_effect_are_warned_of(self, text, old, new, names):
        assert old in text
        expected = {("FZ211" if name == "force" else "FZ216", name) for name in names.split()}
        assert self.unread(text.replace(old, new)) == expected

    def test_a_chain_of_unused_lets_names_its_reader(self):
        diagnostics = found_in(CART.replace(" - drag", ""))
        assert [d.facts for d in diagnostics] == [("read only by 'drag', without effect on an output",), ()]

    def test_parameters_of_functions_are_other_names(self):
        text = "param k = 1\nfunction double(k) = 2 * k\noutput y = double(x)\n"
        assert self.unread(HEAD + text) == {("FZ216", "k")}

    def test_outputs_of_a_system_are_read_through_their_let(self):
        assert self.unread(RULE + HEAD + "let r = rule(x)\noutput y = r\n") == set()

    def test_states_of_transfer_functions_are_not_written(self):
        assert self.unread("plant p = zpk(zeros=[-1], poles=[-1, -2], gain=1)\n") == set()

    def test_params_that_blocks_share_need_not_be_used_by_each(self):
        assert self.unread("param k = 1\n" + CART + PI.replace("limit", "k").replace("param k = 2\n", "")) == set()

    def test_a_mistake_hides_the_warnings(self):
        assert [d.code for d in found_in(CART.replace(" / mass", " / mas"))] == ["FZ202"]
        assert "FZ216" not in [d.code for d in found_in(CART.replace(" / mass", " / "))]

    def test_the_repairs_delete_no_name(self, tmp_path):
        path = tmp_path / "cart.fz"
        path.write_text(CART.replace(" / mass", ""), encoding="utf-8")
        assert runner("check")(path, "--fix").exit_code == 0
        assert path.read_text(encoding="utf-8") == CART.replace(" / mass", "")
