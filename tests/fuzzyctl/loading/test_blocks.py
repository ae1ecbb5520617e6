"""Controllers, plants and loops of a file: what they may contain, and how large they may be."""

import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError
from fuzzyctl.testing import check_text, run_command

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
    return check_text(text)[1]


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
    @pytest.mark.parametrize(
        "kind", [pytest.param(k, marks=[pytest.mark.long] if k.startswith("controllers") else []) for k in large(2)]
    )
    def test_what_grows_without_bounds_is_a_mistake(self, kind):
        text, code = large(40)[kind]
        assert code in [d.code for d in found_in(text)]

    def test_a_long_chain_of_equations_is_no_mistake(self):
        chain = "".join(f"let a{k} = a{k + 1} + 1\n" for k in range(2000))
        assert found_in(HEAD + chain + "let a2000 = x\noutput y = a0\n") == []


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


def test_the_repairs_delete_no_unused_name(tmp_path):
    text = "plant cart\nparam mass = 2\ninput force\nstate v = 0\nder v = force\noutput y = v\n"
    assert [d.code for d in found_in(text)] == ["FZ216"]
    done = run_command("check", "-", "--fix", stdin=text)
    assert (done.exit_code, done.output.startswith(text)) == (0, True)
