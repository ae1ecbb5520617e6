"""Controllers, plants and loops of a file: what they may contain, and how large they may be."""

import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import look_through

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
        loop = fuzzyctl.load_loop(tmp_path / "loop.fz")
        assert ([c.name for c in loop.controllers], [p.name for p in loop.plants]) == (["law"], ["lag"])
        assert fuzzyctl.load_plant(tmp_path / "lag.fz").name == "lag"
        with pytest.raises(DiagnosticError, match="holds no plant"):
            fuzzyctl.load_plant(tmp_path / "law.fz")
        with pytest.raises(DiagnosticError, match="holds no loop 'k'"):
            fuzzyctl.load_loop(tmp_path / "loop.fz", "k")

    def test_a_file_uses_the_controllers_and_systems_of_another(self, tmp_path):
        (tmp_path / "parts.fz").write_text(RULE + HEAD + "output y = 2 * rule(x)\n", encoding="utf-8")
        text = 'use "parts.fz"\ncontroller top\ninput x\nblock a = c(x)\noutput z = a.y + rule(x)\n'
        (tmp_path / "top.fz").write_text(text, encoding="utf-8")
        step = fuzzyctl.compile(fuzzyctl.load_controller(tmp_path / "top.fz"), "python")
        assert step(1.0, step.start(), dt=1.0)[0] == 3 * fuzzyctl.load(tmp_path / "parts.fz")(e=1.0)

    def test_one_of_several_is_named(self, tmp_path):
        (tmp_path / "two.fz").write_text(HEAD + "output y = x\n" + HEAD.replace("c\n", "d\n", 1) + "output y = x\n")
        assert fuzzyctl.load_controller(tmp_path / "two.fz", "d").name == "d"
        for name, message in ((None, "several controllers"), ("e", "no controller 'e'")):
            with pytest.raises(DiagnosticError, match=message):
                fuzzyctl.load_controller(tmp_path / "two.fz", name)

    def test_a_file_of_controllers_holds_no_system(self, tmp_path):
        (tmp_path / "one.fz").write_text(HEAD + "output y = x\n", encoding="utf-8")
        with pytest.raises(DiagnosticError, match="holds no system"):
            fuzzyctl.load(tmp_path / "one.fz")

    def test_a_file_of_systems_holds_no_controller(self, tmp_path):
        (tmp_path / "one.fz").write_text(RULE, encoding="utf-8")
        with pytest.raises(DiagnosticError, match="holds no controller"):
            fuzzyctl.load_controller(tmp_path / "one.fz")
