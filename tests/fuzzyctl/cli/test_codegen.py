import itertools
import json
import os
import resource
from html import unescape
from pathlib import Path
from zipfile import ZipFile

import pytest

from fuzzyctl.support.shipped import rules_folder
from tests.commands import runner

RULES = Path(__file__).resolve().parents[3] / "rules"
AIS = RULES / "ais_reaction.fz"


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return runner("codegen")


def names(folder):
    return sorted(p.name for p in folder.iterdir())


def many(inputs):
    """Return the text of a system with a number of inputs, four terms each, joined by the minimum."""
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
            ("javascript", ["ais_reaction.mjs", "ais_reaction.test.mjs"]),
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
            (4, "javascript", "auto", "active"),
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
        assert run(AIS, "--target", "python", "--set", "k_s=0.5").exit_code == 0
        text = (tmp_path / "ais_reaction.py").read_text(encoding="utf-8")
        assert "# Param set: k_s = 0.5" in text
        assert "0.198" in text

    def test_one_system_of_several_is_written(self, run, tmp_path):
        (tmp_path / "two.fz").write_text(
            "\n".join(
                f"system {n}\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms a b\noutput u in [0, 1]\n"
                "  p = constant(0)\n  q = constant(1)\nif x is a then u is p\nif x is b then u is q\n"
                for n in ("first", "second")
            )
        )
        assert run("two.fz", "--target", "st").exit_code == 2
        assert run("two.fz", "--target", "st", "--block", "second").exit_code == 0
        assert (tmp_path / "second.st").exists()

    def test_the_algorithm_can_be_forced(self, run, tmp_path):
        assert run(AIS, "--target", "c", "--algorithm", "rules").exit_code == 0
        assert "T2[" not in (tmp_path / "ais_reaction.c").read_text(encoding="utf-8")
        assert run(RULES / "tipper.fz", "--target", "c", "--algorithm", "interpolation").exit_code == 1


CONTROLLERS = """system surface
and product
defuzzifier weighted_average
input e in [-1, 1]
  terms N P
output u in [-1, 1] else {otherwise}
  a = constant({low})
  b = constant(1)
if e is N then u is a
if e is P then u is b
require u >= -1

controller first "The first"
input r
param K in (0, 10] = 2
state s in [0, 1] = 0.5 * K / 2
next s = clamp(s + r, 0, 1)
output y = surface(K * r) + s
every 10 ms

controller second
block inner = first(0.5, K=1)
output y = inner.y
every 10 ms
"""


class TestController:
    @pytest.fixture
    def file(self, tmp_path):
        text = CONTROLLERS.format(otherwise=0, low=-1)
        (tmp_path / "two.fz").write_text(text, encoding="utf-8")
        (tmp_path / "one.fz").write_text(text[: text.index("controller second")], encoding="utf-8")
        (tmp_path / "refuted.fz").write_text(
            text.replace("constant(-1)", "constant(-2)").replace("[-1, 1] else", "[-3, 1] else"), encoding="utf-8"
        )
        return "one.fz"

    @pytest.mark.parametrize(
        ("target", "files"),
        [
            ("c", ["first.h", "first.c", "first_selftest.c"]),
            ("st", ["first.st"]),
            ("python", ["first.py"]),
            ("javascript", ["first.mjs", "first.test.mjs"]),
        ],
    )
    def test_is_what_a_file_with_one_is_written_as(self, run, file, target, files):
        result = run(file, "--target", target)
        assert result.exit_code == 0, result.output
        assert result.output.splitlines() == [f"wrote {name}" for name in files]

    def test_is_chosen_by_name_as_systems_are(self, run, file, tmp_path):
        assert run("two.fz", "--target", "st", "--block", "second").exit_code == 0
        assert run("two.fz", "--target", "st", "--block", "surface").exit_code == 0
        assert {"second.st", "surface.st"} <= set(names(tmp_path))

    @pytest.mark.parametrize(
        ("options", "message", "facts"),
        [
            ([], "the file holds several controllers, and none is chosen", "controllers: first, second"),
            (
                ["--block", "fist"],
                "the file holds no system, controller or plant 'fist'",
                "systems, controllers or plants: surface, first, second",
            ),
        ],
    )
    def test_that_is_not_chosen_is_asked_for(self, run, file, options, message, facts):
        result = run("two.fz", "--target", "c", *options)
        assert result.exit_code == 2
        assert f"error[FZ502]: {message}" in result.output
        assert facts in result.output

    def test_prints_what_it_wrote_as_json(self, run, file):
        data = json.loads(run(file, "--target", "c", "--format", "json").stdout)
        assert data == {
            "controller": "first",
            "target": "c",
            "algorithms": {"surface": "interpolation"},
            "files": ["first.h", "first.c", "first_selftest.c"],
            "errors": {},
            "guarantees": {"s in [0, 1]": "proved"},
        }

    def test_takes_params_an_algorithm_a_profile_and_single_precision(self, run, file, tmp_path):
        options = ["--set", "K=1.5", "--algorithm", "rules", "--as", "fuzzylite_6", "--float", "float"]
        result = run(file, "--target", "c", *options)
        assert result.exit_code == 0, result.output
        header = (tmp_path / "first.h").read_text(encoding="utf-8")
        assert "// Param set: K = 1.5" in header
        assert "// Calls surface: rules; it was asked for" in header
        assert "float first_step(first_state *state, float r);" in header
        assert "s = 0.375F" in (tmp_path / "first.c").read_text(encoding="utf-8")

    def test_takes_params_of_the_blocks_inside(self, run, tmp_path):
        inner = "controller inner\nparam k = 2\ninput x in [0, 1]\noutput y = k * x\nevery 1 s\n"
        outer = "controller outer\ninput x in [0, 1]\nblock part = inner(x)\noutput y = part.y\nevery 1 s\n"
        (tmp_path / "two.fz").write_text(inner + outer, encoding="utf-8")
        result = run("two.fz", "--target", "c", "--block", "outer", "--set", "part.k=0.375")
        assert result.exit_code == 0, result.output
        assert "0.375" in (tmp_path / "outer.c").read_text(encoding="utf-8")

    @pytest.mark.parametrize(
        ("setting", "message"),
        [
            ("K=0", "param 'K' is 0, outside of (0, 10]"),
            ("K=5", "the start of state 's' is 1.25, outside of [0, 1]"),
            ("k=1", "no param 'k'"),
            ("K=x", "param 'K' is not a number: 'x'"),
        ],
    )
    def test_params_that_it_cannot_take_are_refused(self, run, file, tmp_path, setting, message):
        result = run(file, "--target", "c", "--set", setting)
        assert result.exit_code == (1 if setting in ("K=0", "K=5") else 2)
        assert message in result.output
        assert not (tmp_path / "first.c").exists()

    def test_has_no_lookup_table(self, run, file):
        result = run(file, "--target", "c", "--table", "9")
        assert result.exit_code == 2
        assert "'first' is a controller, whose steps no table holds; name a system with --block" in result.output
        assert run(file, "--target", "c", "--table", "9", "--block", "surface").exit_code == 0

    def test_fixed_point_is_refused_where_no_error_is_bounded(self, run, file, tmp_path):
        path = tmp_path / file
        path.write_text(path.read_text().replace("clamp(s + r, 0, 1)", "s + r"))
        result = run(file, "--target", "c", "--fixed", "Q3.12", "--unproved")
        assert result.exit_code == 1
        assert "error[FZ410]: " in result.output
        assert not list(tmp_path.glob("*.c"))
        assert run(file, "--target", "c", "--fixed", "Q3.12", "--block", "surface").exit_code == 0

    def test_fixed_point_is_proved_where_errors_fade(self, run, tmp_path):
        text = "controller lag\ninput x in [-2, 2]\noutput u in [-2, 2] = lowpass(x, 0.2)\nevery 10 ms\n"
        (tmp_path / "lag.fz").write_text(text, encoding="utf-8")
        result = run(tmp_path / "lag.fz", "--target", "c", "--fixed", "Q3.12")
        assert result.exit_code == 0
        assert "proved: u is off by 0.000123 at most" in result.output
        for more in (["--free", "x"], ["--float", "float"], ["--algorithm", "rules"], ["--table", "9"]):
            assert run(tmp_path / "lag.fz", "--target", "c", "--fixed", "Q3.12", *more).exit_code == 2

    def test_takes_free_numbers(self, run, file, tmp_path):
        assert run(file, "--target", "c", "--free", "surface.e.P.peak").exit_code == 0
        assert "first_params" in (tmp_path / "first.h").read_text(encoding="utf-8")

    def test_free_numbers_of_systems_and_unknown_ones_are_refused(self, run, file):
        result = run(file, "--target", "c", "--free", "K")
        assert (result.exit_code, "the start of a state depends on a free number" in result.output) == (1, True)
        result = run(file, "--target", "c", "--free", "k")
        assert (result.exit_code, "k" in result.output) == (2, True)
        result = run(file, "--target", "c", "--block", "surface", "--free", "K")
        assert (result.exit_code, "only controllers take numbers" in result.output) == (2, True)

    def test_is_not_written_where_a_guarantee_of_its_systems_is_refuted(self, run, file, tmp_path):
        result = run("refuted.fz", "--target", "c", "--block", "first")
        assert result.exit_code == 1
        assert "the guarantee 'u >= -1' does not hold" in result.output
        assert names(tmp_path) == ["one.fz", "refuted.fz", "two.fz"]

    @pytest.mark.parametrize("target", ["c", "st", "python", "javascript", "fmu"])
    def test_whose_guarantee_is_refuted_is_written_if_it_may_be_unproved(self, run, tmp_path, target):
        (tmp_path / "c.fz").write_text("controller c\ninput e in [0, 1]\noutput u = 2 * e\nevery 1 s\nrequire u <= 1\n")
        result = run("c.fz", "--target", target, "-q")
        assert result.exit_code == 1
        assert "c.fz:5:1: error[FZ402]: the guarantee 'u <= 1' does not hold" in result.output
        assert "or write it all the same with --unproved" in result.output
        assert names(tmp_path) == ["c.fz"]
        result = run("c.fz", "--target", target, "-q", "--unproved")
        assert (result.exit_code, "the guarantee 'u <= 1' does not hold" in result.output) == (0, True)
        path = tmp_path / result.stdout.split()[1]
        page = ZipFile(path).read("documentation/index.html") if target == "fmu" else path.read_bytes()
        assert "refuted: u <= 1 (at e = " in unescape(page.decode())

    def test_is_not_written_where_the_file_has_errors(self, run, file, tmp_path):
        (tmp_path / "one.fz").write_text(
            CONTROLLERS.format(otherwise=0, low=-1).replace("next s = clamp(s + r, 0, 1)\n", "")
        )
        result = run(file, "--target", "c")
        assert result.exit_code == 1
        assert "state 's' has no 'next' line" in result.output
        assert names(tmp_path) == ["one.fz", "refuted.fz", "two.fz"]

    def test_an_algorithm_that_a_system_does_not_allow_is_refused(self, run, file, tmp_path):
        curved = (tmp_path / file).read_text().replace("  terms N P\n", "  N = gaussian(-1, 1)\n  P = gaussian(1, 1)\n")
        (tmp_path / file).write_text(curved)
        result = run(file, "--target", "c", "--algorithm", "interpolation")
        assert result.exit_code == 1
        assert "the system does not interpolate" in result.output


#: A system whose guarantee holds, but takes subdivision.
OPEN = """system gaussians
input x in [0, 10]
  low  = gaussian(0, 3)
  high = gaussian(10, 3)
output u in [0, 1]
  a = triangle(0, 0.2, 0.4)
  b = triangle(0.6, 0.8, 1)
if x is low then u is a
if x is high then u is b
require u <= 0.97
"""


class TestGuarantees:
    @pytest.mark.parametrize("target", ["c", "st", "python", "javascript"])
    def test_that_are_proved_stand_at_the_head(self, run, tmp_path, target):
        result = run(AIS, "--target", target)
        assert (result.exit_code, result.stderr) == (0, "")
        first = result.output.splitlines()[0].removeprefix("wrote ")
        head = (tmp_path / first).read_text(encoding="utf-8").split("sigma)")[0]
        assert "  proved: k_h_min - k_s * f >= G_min within 1e-12" in head

    @pytest.mark.parametrize(("option", "in_file"), [(True, False), (False, True)])
    def test_that_are_refuted_are_refused_as_check_does(self, run, tmp_path, option, in_file):
        file = tmp_path / "own.fz"
        text = AIS.read_text(encoding="utf-8")
        assert "param k_s     = 0.55" in text
        file.write_text(text.replace("param k_s     = 0.55", "param k_s = 1 ") if in_file else text, encoding="utf-8")
        result = run(file, "--target", "c", *(["--set", "k_s=1"] if option else []))
        assert result.exit_code == 1
        assert "own.fz:47:1: error[FZ402]: the guarantee 'k_h_min - k_s * f >= G_min" in result.stderr
        assert "at sigma = 0, dsigma = 0: k_h_min - k_s * f = -0.08" in result.stderr
        assert names(tmp_path) == ["own.fz"]

    @pytest.mark.parametrize("target", ["c", "st", "python", "javascript", "fmu"])
    def test_that_are_refuted_are_written_with_their_point_if_they_may_be_unproved(self, run, tmp_path, target):
        result = run(AIS, "--target", target, "--set", "k_s=1", "--unproved")
        assert result.exit_code == 0
        assert "error[FZ402]: the guarantee 'k_h_min - k_s * f >= G_min" in result.stderr
        if target != "fmu":
            text = (tmp_path / result.stdout.split()[1]).read_text(encoding="utf-8")
            comment = " ".join(line.strip(" /#(*") for line in text.splitlines())
            assert "refuted: k_h_min - k_s * f >= G_min within 1e-12 (at sigma = 0, dsigma = 0: k_h_min" in comment

    def test_are_those_of_the_profile_that_is_asked_for(self, run, tmp_path):
        # The centroid is 1/30; of MATLAB's 101 samples it is 0.03.
        (tmp_path / "own.fz").write_text(
            "system own\ninput x in [0, 1]\n  all = trapezoid(-inf, -1, 2, inf)\noutput u in [0, 1]\n"
            "  a = triangle(0, 0, 0.1)\nif x is all then u is a\nrequire u >= 0.032\n",
            encoding="utf-8",
        )
        result = run("own.fz", "--target", "st", "--as", "matlab")
        assert result.exit_code == 1
        assert "own.fz:7:1: error[FZ402]" in result.stderr
        assert names(tmp_path) == ["own.fz"]
        assert run("own.fz", "--target", "st").exit_code == 0

    def test_that_quick_methods_leave_open_are_said(self, run, tmp_path):
        (tmp_path / "open.fz").write_text(OPEN, encoding="utf-8")
        result = run("open.fz", "--target", "c")
        assert result.exit_code == 0
        assert "open.fz:10:1: warning[FZ402]: the guarantee 'u <= 0.97' is undecided" in result.stderr
        assert "  undecided: u <= 0.97 (it takes" in (tmp_path / "gaussians.h").read_text(encoding="utf-8")
        data = json.loads(run("open.fz", "--target", "c", "--format", "json").stdout)
        assert data["guarantees"] == {"u <= 0.97": "undecided"}

    def test_are_proved_once(self, run, monkeypatch):
        from fuzzyctl.analysis.prove import Prover

        seen = []
        verdict = Prover.verdict
        monkeypatch.setattr(Prover, "verdict", lambda self, g: seen.append(g) or verdict(self, g))
        assert run(AIS, "--target", "c").exit_code == 0
        assert len(seen) == 3

    def test_warnings_that_the_file_denies_are_refused_as_check_does(self, run, tmp_path):
        text = OPEN.replace("system gaussians", "deny FZ403\nsystem gaussians") + "if x is low then u is a weight 0\n"
        (tmp_path / "open.fz").write_text(text, encoding="utf-8")
        assert runner()("check", "open.fz").exit_code == 1
        result = run("open.fz", "--target", "c")
        assert result.exit_code == 1
        assert "error[FZ403]" in result.stderr
        assert names(tmp_path) == ["open.fz"]


class TestProfile:
    @pytest.mark.parametrize("target", ["c", "st", "python", "javascript"])
    def test_stands_at_the_head_whoever_names_it(self, run, tmp_path, target):
        (tmp_path / "own.fz").write_text(OPEN.replace("\ninput", "\nsemantics octave\ninput"), encoding="utf-8")
        lines = []
        for arguments in ((AIS,), (AIS, "--as", "matlab"), ("own.fz",)):
            data = json.loads(run(*arguments, "--target", target, "--format", "json").stdout)
            text = (tmp_path / data["files"][0]).read_text(encoding="utf-8")
            lines.append(next(line for line in text.splitlines() if "Semantics profile: " in line))
        assert [line.rstrip(" *)").rpartition(" ")[2] for line in lines] == ["exact", "matlab", "octave"]


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
            (["--target", "javascript", "--float", "float"], 2),
            (["--target", "javascript", "--fixed", "Q3.12"], 2),
            (["--target", "c", "--table", "1"], 2),
            (["--target", "c", "--fixed", "Q15.0", "--table", "3"], 1),
            (["--target", "c", "--fixed", "Q0.15", "--algorithm", "rules"], 1),
            (["--target", "c", "--table", "300"], 1),
            (["--target", "c", "--set", "nope=1"], 2),
            (["--target", "c", "--block", "nope"], 2),
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

    @pytest.mark.parametrize(
        ("value", "target", "place", "reason"),
        [
            ("fmod(x, 0.3)", "st", "4:31", "Structured Text has no standard function for 'fmod'"),
            ("x ^ 1.5", "c", "", ""),
        ],
    )
    def test_what_a_target_cannot_express_has_a_location(self, run, tmp_path, value, target, place, reason):
        text = f"system s\n\ninput x in [0, 1]\noutput u in [-1, 1] = 0 * x + {value}\n"
        (tmp_path / "f.fz").write_text(text, encoding="utf-8")
        result = run("f.fz", "--target", target)
        assert result.exit_code == (1 if reason else 0)
        assert (f"f.fz:{place}: error[FZ608]: 's' cannot be written in Structured Text" in result.output) == bool(
            reason
        )
        assert reason in result.output

    def test_an_integral_is_refused_in_c_with_its_location(self, run, tmp_path):
        (tmp_path / "curved.fz").write_text(
            "system curved\ninput x in [0, 1]\n  a = triangle(-inf, 0, 1)\n  b = triangle(0, 1, inf)\n"
            "output u in [0, 1]\n  p = gaussian(0, 0.2)\n  q = gaussian(1, 0.2)\n"
            "if x is a then u is p\nif x is b then u is q\n"
        )
        result = run("curved.fz", "--target", "c")
        assert result.exit_code == 1
        assert "curved.fz:1:8: error[FZ608]: 'curved' cannot be written in C" in result.output
        assert names(tmp_path) == ["curved.fz"]

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

    def test_a_full_disk_leaves_the_old_set(self, run, tmp_path):
        assert run(AIS, "--target", "c").exit_code == 0
        before = {p.name: p.read_text(encoding="utf-8") for p in tmp_path.iterdir()}
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        # Room for the header, and for nothing else.
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(before["ais_reaction.h"].encode()) + 300, limits[1]))
        try:
            result = run(AIS, "--target", "c", "--float", "float")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert result.exit_code == 1
        assert "ais_reaction.c: error[FZ005]: the file cannot be written: File too large" in result.stderr
        assert {p.name: p.read_text(encoding="utf-8") for p in tmp_path.iterdir()} == before

    def test_a_full_disk_leaves_no_new_folder(self, run, tmp_path):
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (300, limits[1]))
        try:
            result = run(AIS, "--target", "c", "-o", "new/build")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert (result.exit_code, "File too large" in result.stderr) == (1, True)
        assert names(tmp_path) == []

    def test_a_file_that_does_not_exist_is_named(self, run):
        assert "FZ001" in run("none.fz", "--target", "c").output


def test_a_system_whose_name_is_too_long_for_a_file_is_reported(tmp_path):
    path = tmp_path / "long.fz"
    text = (rules_folder() / "ais_reaction.fz").read_text(encoding="utf-8")
    path.write_text(text.replace("system ais_reaction", f"system {'a' * 199}"), encoding="utf-8")
    result = runner("codegen")(path, "--target", "c", "-o", tmp_path / "out")
    assert result.exit_code == 1
    assert "give the system a shorter name" in result.stderr
