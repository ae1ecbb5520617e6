import itertools
import json
import os
from pathlib import Path

import pytest
from click.testing import CliRunner

from fuzzyctl.cli.main import main
from fuzzyctl.shipped import rules_folder

RULES = Path(__file__).resolve().parents[3] / "rules"
AIS = RULES / "ais_reaction.fz"


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(main, ["codegen", *map(str, arguments)])


def names(folder):
    return sorted(p.name for p in folder.iterdir())


def many(inputs):
    """Return the text of a system of so many inputs with four terms each, joined by the minimum."""
    names = "abcd"[:inputs]
    lines = ["system many", "and min", "defuzzifier weighted_average", "output u in [0, 1]"]
    lines += [f"  c{k} = constant({k / 10})" for k in range(4 * inputs)]
    for name in names:
        lines += [f"input {name} in [0, 3]", "  terms t0 t1 t2 t3"]
    for terms in itertools.product(range(4), repeat=inputs):
        condition = " and ".join(f"{name} is t{k}" for name, k in zip(names, terms, strict=True))
        lines.append(f"if {condition} then u is c{sum(terms)}")
    return "\n".join(lines)


class TestCodegen:
    @pytest.mark.parametrize(
        ("target", "files"),
        [
            ("c", ["ais_reaction.c", "ais_reaction.h", "ais_reaction_selftest.c"]),
            ("st", ["ais_reaction.st"]),
            ("python", ["ais_reaction.py"]),
        ],
    )
    def test_writes_the_files_of_its_target_and_no_others(self, run, tmp_path, target, files):
        result = run(AIS, "--target", target, "-o", "a/b")
        assert result.exit_code == 0, result.output
        assert names(tmp_path / "a" / "b") == files
        assert result.output.splitlines() == [f"wrote a/b/{f}" for f in sorted(files, key=lambda f: (f[-1] != "h", f))]

    def test_prints_what_it_wrote_as_json(self, run):
        data = json.loads(run(AIS, "--target", "c", "--fixed", "Q3.12", "--format", "json").stdout)
        assert data["files"] == ["ais_reaction.h", "ais_reaction.c", "ais_reaction_selftest.c"]
        assert 0 < data["errors"]["f"] < 2.0**-12
        assert data["algorithm"] == "interpolation"

    @pytest.mark.parametrize(
        ("inputs", "target", "wanted", "expected"),
        [
            (4, "c", "auto", "rules"),
            (4, "st", "auto", "rules"),
            (4, "c", "active", "active"),
            (4, "python", "auto", "active"),
            (3, "c", "auto", "active"),
        ],
    )
    def test_large_tables_of_rules_that_can_act_are_left_out_where_memory_is_small(
        self, run, tmp_path, inputs, target, wanted, expected
    ):
        (tmp_path / "many.fz").write_text(many(inputs), encoding="utf-8")
        data = json.loads(run("many.fz", "--target", target, "--algorithm", wanted, "--format", "json").stdout)
        assert data["algorithm"] == expected
        head = (tmp_path / data["files"][0]).read_text(encoding="utf-8")[:2000]
        assert ("would take" in head) == (expected == "rules")

    def test_the_hash_is_that_of_the_file(self, run, tmp_path):
        import hashlib

        run(AIS, "--target", "st")
        digest = hashlib.sha256(AIS.read_bytes()).hexdigest()
        assert digest in (tmp_path / "ais_reaction.st").read_text(encoding="utf-8")

    def test_params_are_set_and_said(self, run, tmp_path):
        assert run(AIS, "--target", "python", "--set", "k_s=1.1").exit_code == 0
        text = (tmp_path / "ais_reaction.py").read_text(encoding="utf-8")
        assert "# Param set: k_s = 1.1" in text
        assert "0.09" in text

    def test_one_system_of_several_is_written(self, run, tmp_path):
        (tmp_path / "two.fz").write_text(
            "\n".join(
                f"system {n}\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms a b\noutput u in [0, 1]\n"
                "  p = constant(0)\n  q = constant(1)\nif x is a then u is p\nif x is b then u is q\n"
                for n in ("first", "second")
            )
        )
        assert run("two.fz", "--target", "st").exit_code == 1
        assert run("two.fz", "--target", "st", "--system", "second").exit_code == 0
        assert (tmp_path / "second.st").exists()

    def test_the_algorithm_can_be_forced(self, run, tmp_path):
        assert run(AIS, "--target", "c", "--algorithm", "rules").exit_code == 0
        assert "T2[" not in (tmp_path / "ais_reaction.c").read_text(encoding="utf-8")
        assert run(RULES / "tipper.fz", "--target", "c", "--algorithm", "interpolation").exit_code == 1


class TestMistakes:
    @pytest.mark.parametrize(
        ("arguments", "code"),
        [
            ([], 2),
            (["--target", "rust"], 2),
            (["--target", "c", "--fixed", "3.12"], 2),
            (["--target", "st", "--fixed", "Q3.12"], 2),
            (["--target", "c", "--fixed", "Q3.12", "--float", "float"], 2),
            (["--target", "python", "--float", "float"], 2),
            (["--target", "c", "--table", "1"], 2),
            (["--target", "c", "--fixed", "Q0.15"], 1),
            (["--target", "c", "--table", "300"], 1),
            (["--target", "c", "--set", "nope=1"], 1),
            (["--target", "c", "--system", "nope"], 1),
        ],
    )
    def test_write_nothing_and_show_no_traceback(self, run, tmp_path, arguments, code):
        result = run(AIS, *arguments)
        assert result.exit_code == code
        assert result.output
        assert "Traceback" not in result.output
        assert names(tmp_path) == []

    def test_a_system_that_does_not_pass_check_is_refused(self, run, tmp_path):
        (tmp_path / "gap.fz").write_text(
            "system gap\ndefuzzifier weighted_average\ninput x in [0, 9]\n  a = triangle(0, 1, 2)\noutput u in [0, 1]\n"
            "  p = constant(0)\nif x is a then u is p\n"
        )
        result = run("gap.fz", "--target", "c")
        assert result.exit_code == 1
        assert "error[FZ" in result.output
        assert names(tmp_path) == ["gap.fz"]

    def test_a_folder_that_cannot_be_made_is_a_diagnostic(self, run, tmp_path):
        (tmp_path / "taken").write_text("")
        result = run(AIS, "--target", "c", "-o", "taken")
        assert result.exit_code == 1
        assert "error[FZ005]" in result.output

    def test_a_folder_in_the_place_of_a_file_leaves_the_others_alone(self, run, tmp_path):
        os.mkdir(tmp_path / "ais_reaction_selftest.c")
        result = run(AIS, "--target", "c")
        assert result.exit_code == 1
        assert "error[FZ005]" in result.output
        assert names(tmp_path) == ["ais_reaction_selftest.c"]

    def test_a_file_that_does_not_exist_is_named(self, run):
        assert "FZ001" in run("none.fz", "--target", "c").output


def test_a_system_whose_name_is_too_long_for_a_file_is_told_so(tmp_path):
    path = tmp_path / "long.fz"
    text = (rules_folder() / "ais_reaction.fz").read_text(encoding="utf-8")
    path.write_text(text.replace("system ais_reaction", f"system {'a' * 199}"), encoding="utf-8")
    result = CliRunner().invoke(main, ["codegen", str(path), "--target", "c", "-o", str(tmp_path / "out")])
    assert result.exit_code == 1
    assert "give the system a shorter name" in result.stderr
