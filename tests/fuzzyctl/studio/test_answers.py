"""The studio's worker answers with its own arrays what the program answers with numpy; browsers count in UTF-16."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from fuzzyctl import compile, load
from fuzzyctl.studio.answers import METHODS, answer
from tests.commands import runner
from tests.shipped import SYSTEMS

RULES = SYSTEMS[0].parent
MAX_BYTES = 1 << 20
#: A system with transcendental terms, a controller with used files, a loop.
FILES = ("tipper.fz", "fcafsmc_law.fz", "loops/water_tank.fz")
#: A mistake each.
MISTAKES = sorted((Path(__file__).parents[2] / "golden" / "diagnostics").glob("*.fz"))
#: Files of other tools, one of each format.
SAMPLES = Path(__file__).parents[1] / "formats"
FOREIGN = [SAMPLES / n for n in ("samples/tipper.fis", "samples/old.fll", "fcl/standard.fcl", "fml/mamdani.fml")]
TARGETS = ("c", "javascript", "python", "st")
#: What Pyodide does not have beside the studio.
ABSENT = "numpy scipy matplotlib numba pydantic pygls lsprotocol rich click pygments".split()

#: Answers requests with these packages out of reach, and evaluates a kernel in Python.
WITHOUT = f"""
import json, sys
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {ABSENT!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name.split(".")[0])
sys.meta_path.insert(0, Absent())
from fuzzyctl.studio.arrays import install
install()
from fuzzyctl import compile, load
from fuzzyctl.studio.answers import answer
found = [answer(json.dumps(request)) for request in json.load(sys.stdin)]
kernel = compile(load({str(RULES / "tipper.fz")!r}), backend="python")
print(json.dumps([found, kernel(7.0, 8.0).hex()]))
"""


def ask(method, text, file="/files/a.fz", **more):
    return json.loads(answer(json.dumps({"method": method, "file": str(file), "text": text, **more})))


def requests():
    for name in FILES:
        path = RULES / name
        text = path.read_text()
        common = {"file": str(path), "text": text, "offset": text.index(" = ") - 1, "nonce": "a1-b2", "block": 0}
        yield from (
            {"method": m, **common}
            for m in METHODS
            if m not in ("export", "convert", "page" if path.stem != "tipper" else "")
        )
        yield from ({"method": "export", "target": target, **common} for target in TARGETS)
    yield from ({"method": "convert", "file": str(path), "text": path.read_text()} for path in FOREIGN)
    yield from ({"method": "check", "file": str(path), "text": path.read_text()} for path in MISTAKES)


def test_answers_without_numpy_are_those_with_it():
    asked = list(requests())
    done = subprocess.run([sys.executable, "-c", WITHOUT], input=json.dumps(asked), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found, number = json.loads(done.stdout)
    for request, own in zip(asked, found, strict=True):
        assert "refused" not in json.loads(own), (request["method"], request["file"])
        assert own == answer(json.dumps(request)), (request["method"], request["file"])
    assert number == compile(load(RULES / "tipper.fz"), backend="python")(7.0, 8.0).hex()


def test_a_diagnostic_says_what_other_places_explain():
    (path,) = (p for p in MISTAKES if p.stem == "FZ401")
    found = ask("check", path.read_text())["diagnostics"]
    assert "the cell of row 'N', column 'L' is empty (line 18)" in found[0]["facts"]


def test_places_are_in_units_of_utf_16():
    text = "# 𝑥 é\nsystem s\ninput x in [0, 1]\n  terms lo hi\noutput y in [0, 1]\n  terms p q\n"
    text += "if x is lop then y is p\n"
    found = next(d for d in ask("check", text)["diagnostics"] if d["code"] == "FZ203")
    place = text.index("lop") + 1  # the letter before takes two units
    assert (found["from"], found["to"], found["line"]) == (place, place + 3, 7)
    assert {"from": place, "to": place + 3, "text": "lo"} in found["fix"]
    done = ask("complete", text, offset=place)
    assert {"lo", "hi"} <= {i["label"] for i in done["items"]}
    assert done["from"] == place


def test_changes_at_a_place_are_repairs_of_its_line_and_what_can_be_written():
    text = (RULES / "tipper.fz").read_text().replace("then tip is cheap", "then tip is chaep")
    repair, *_ = ask("actions", text, offset=text.index("chaep"))["actions"]
    (edit,) = repair["edits"]
    assert text[edit["from"] : edit["to"]] == "chaep"
    assert edit["text"] == "cheap"
    titles = [a["title"] for a in ask("actions", text, offset=text.index("output tip"))["actions"]]
    assert "add 'else midpoint', the output where no rule fires" in titles
    assert repair["title"] not in titles


def test_proofs_by_subdivision_follow_the_picture():
    text = (RULES / "tipper.fz").read_text() + "require tip >= 3\n"
    (section,) = ask("picture", text)["facts"]["sections"]
    assert [v[0] for v in section["verdicts"]] == ["proved", "undecided"]
    assert section["verdicts"][1][2] == "it takes subdivision, which is under way"
    assert [v[0] for v in ask("proofs", text, block=0)["verdicts"]] == ["proved", "proved"]
    assert "which is under way" not in ask("page", text)["html"]


def test_a_claim_that_takes_longer_is_said_to_be_the_program_s(monkeypatch):
    monkeypatch.setattr("fuzzyctl.studio.answers.CLAIM_SECONDS", 0.0001)
    text = (RULES / "tipper.fz").read_text() + "require increasing(tip, service)\n"
    (*_, [verdict, _, reason]) = ask("proofs", text, block=0)["verdicts"]
    assert verdict == "undecided"
    assert reason.endswith("; 'fuzzyctl prove' takes more time")


def test_claims_of_controllers_and_their_bounds():
    text = (RULES / "ackermann.fz").read_text()
    (section,) = ask("picture", text, RULES / "ackermann.fz")["facts"]["sections"]
    assert section["verdicts"] == []
    found = ask("proofs", text, RULES / "ackermann.fz", block=0)
    assert [v[0] for v in found["verdicts"]] == ["proved"] * 3
    assert ["v_c", "from 0 to 2 m/s"] in found["bounds"]


def test_loops_are_run_or_say_why_not(tmp_path):
    text = (RULES / "loops" / "pendulum.fz").read_text()
    (run,) = ask("runs", text)["sections"]
    assert run["kind"] == "loop"
    assert run["panels"][0]["values"]
    assert run["note"] == ""
    assert len(run["measures"]) > 1
    assert {v[0] for v in run["verdicts"]} == {"met"}
    assert ask("picture", text)["loops"] == [run["name"]]
    assert run["title"] in ask("page", text)["html"]
    (noisy,) = ask("runs", (RULES / "loops" / "water_tank.fz").read_text())["sections"]
    assert "another generator" in noisy["note"]
    (tmp_path / "b.csv").write_text("t,v\n0,1\n9,1\n")
    table = "plant p\ninput u\nstate x = 0\nder x = u\noutput y = x\nloop l\nblock b = p(r)\n"
    table += 'let r = csv("b.csv", column="v")\nrun 1 s step 0.1 s\n'
    (tabled,) = ask("runs", table, tmp_path / "a.fz")["sections"]
    assert tabled["t"][-1] == 1.0
    large = table.replace("run 1 s", "run 1e6 s")
    (refused,) = ask("runs", large, tmp_path / "a.fz")["sections"]
    assert "more than 3e+07; 'fuzzyctl simulate' runs it" in refused["refused"]
    assert ask("runs", "loop l\n")["refused"] == "error[FZ212]: loop 'l' has no 'run' line, and 1 more mistake"


@pytest.mark.parametrize("offset", [-5, 0, 3, 10_000])
def test_any_offset_has_an_answer(offset):
    for method in ("complete", "hover", "actions"):
        assert "refused" not in ask(method, "# 𝑥\n", offset=offset)


def test_a_text_with_errors_has_no_picture_and_no_files():
    text = (RULES / "tipper.fz").read_text().replace("good", "gud", 1)
    assert any(d["severity"] == "error" for d in ask("check", text)["diagnostics"])
    assert "has no term 'good'" in ask("page", text)["refused"]
    assert "has no term 'good'" in ask("export", text, target="c")["refused"]


def test_what_is_not_installed_is_refused_by_name(monkeypatch):
    def lacks(*_):
        raise ModuleNotFoundError("No module named 'numpy'", name="numpy")

    monkeypatch.setitem(METHODS, "check", lacks)
    assert "this takes numpy" in ask("check", "system a\n")["refused"]


def test_empty_and_too_large_texts_are_refused():
    plant = "plant p\ninput u\nstate x = 0\nder x = u\noutput y = x\n"
    assert "no system" in ask("page", plant)["refused"]
    assert "no system" in ask("export", plant, target="c")["refused"]
    assert "no statement" in ask("page", "")["refused"]
    assert f"more than {MAX_BYTES}" in ask("check", " " * (MAX_BYTES + 1))["refused"]


def test_a_mistake_in_a_used_file_names_it(tmp_path):
    (tmp_path / "b.fz").write_text("system b\nnonsense\n")
    found = ask("check", 'use "b.fz"\n', tmp_path / "a.fz")["diagnostics"]
    assert any("b.fz:2" in d["place"] and d["line"] == 0 for d in found)


def test_hovers_show_a_term():
    text = (RULES / "tipper.fz").read_text()
    found = ask("hover", text, offset=text.index("gaussian(5") - 9)
    assert "data:image/svg+xml" in found["markdown"]


def test_a_page_has_the_title_that_the_command_gives_it(tmp_path):
    one = (RULES / "tipper.fz").read_text(encoding="utf-8")
    file, page = tmp_path / "two.fz", tmp_path / "x.html"
    for text, title in ((one, "Tip for service and food"), (one + one.replace("system tipper", "system other"), "two")):
        assert ask("picture", text, file)["facts"]["title"] == title
        file.write_text(text, encoding="utf-8")
        done = runner("page")(file, "-o", page)
        assert done.exit_code == 0, done.output
        assert f"<title>{title}</title>" in page.read_text(encoding="utf-8")
        assert f"<title>{title}</title>" in ask("page", text, file)["html"]


def test_a_hostile_title_stays_text():
    text = (RULES / "tipper.fz").read_text()
    line = next(x for x in text.splitlines() if x.startswith("system tipper"))
    hostile = text.replace(line, 'system tipper "</script><img src=x onerror=alert(1)>"')
    assert "<img src=x" not in ask("page", hostile)["html"]
    assert "<img src=x" not in ask("picture", hostile)["script"]


def test_a_picture_is_what_the_page_shows():
    text = (RULES / "tipper.fz").read_text()
    page, picture, frame = ask("page", text)["html"], ask("picture", text), ask("frame", "", nonce="a1-b2")["html"]
    assert f"<script>{picture['script']}</script>" in page
    shown = re.search(r'id="facts">(.*?)</script>', page)
    assert json.loads(shown[1]) == picture["facts"]
    assert "'nonce-a1-b2'" in frame
    assert "nonce" not in re.search(r'content="(default-src.*?)"', page)[1]


def test_a_claim_that_does_not_hold_stops_nothing_and_has_its_point():
    text = (RULES / "tipper.fz").read_text().replace("bounded(tip, 0, 30)", "bounded(tip, 0, 20)")
    (one,) = ask("check", text)["diagnostics"]
    assert (one["stops"], one["block"], set(one["point"])) == (False, "tipper", {"service", "food"})
    (section,) = ask("picture", text)["facts"]["sections"]
    assert section["verdicts"][0][3] == one["point"]
    assert "refuted: bounded(tip, 0, 20) (at service" in ask("export", text, target="c")["files"]["tipper.h"]
    assert "does not hold" in ask("page", text)["html"]


def test_a_claim_that_subdivision_refutes_adds_a_diagnostic_of_its_block():
    claim = "tip <= 15 when service >= 4.77 and service <= 4.78 and food >= 7.01 and food <= 7.1"
    text = (RULES / "tipper.fz").read_text() + f"require {claim}\n"
    assert ask("check", text)["diagnostics"] == []
    found = ask("proofs", text, block=0)
    assert [word for word, *_ in found["verdicts"]] == ["proved", "refuted"]
    (one,) = found["diagnostics"]
    assert (one["line"], one["stops"], one["block"]) == (34, False, "tipper")


def test_files_of_other_tools_are_opened_as_convert_writes_them(tmp_path):
    for path in FOREIGN:
        found = ask("convert", path.read_text(), f"/files/{path.name}")
        done = runner("convert")(path, tmp_path / found["name"])
        assert done.exit_code == 0, done.output
        assert found["text"] == (tmp_path / found["name"]).read_text(encoding="utf-8")
    assert any("'brake - MAMDANI' is not a name here; it is called 'brake_MAMDANI'" in note for note in found["notes"])
    assert ask("convert", "<a", "/files/a.fml")["refused"] == "error[FZ601]: the XML is broken: unclosed token"
