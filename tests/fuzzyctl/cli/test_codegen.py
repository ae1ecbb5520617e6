"""What `fuzzyctl codegen` writes; transcripts/codegen.txt holds what it prints."""

import hashlib
import importlib.util
import itertools
import json
import resource
import shutil
import subprocess
import zipfile
from html import unescape

import pytest

import fuzzyctl
from tests.commands import runner
from tests.shipped import SYSTEMS

AIS = next(path for path in SYSTEMS if path.stem == "ais_reaction")
run = runner("codegen")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


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
def test_large_tables_of_rules_that_can_act_are_left_out_if_memory_is_small(folder, inputs, target, wanted, expected):
    (folder / "many.fz").write_text(many(inputs), encoding="utf-8")
    data = json.loads(run("many.fz", "--target", target, "--algorithm", wanted, "--format", "json").stdout)
    assert data["algorithm"] == expected
    head = (folder / data["files"][0]).read_text(encoding="utf-8")[:2000]
    assert ("would take" in head) == (expected == "rules")


def test_the_hash_is_that_of_the_file(folder):
    run(AIS, "--target", "st")
    assert hashlib.sha256(AIS.read_bytes()).hexdigest() in (folder / "ais_reaction.st").read_text(encoding="utf-8")


@pytest.mark.parametrize("existing", [True, False])
def test_a_full_disk_leaves_the_old_files_or_no_new_folder(folder, existing):
    words = (AIS, "--target", "c", "-o", "a/b")
    assert not existing or run(*words).exit_code == 0
    before = {p: p.read_bytes() for p in folder.rglob("*.*")}
    room = len(before[folder / "a" / "b" / "ais_reaction.h"]) if existing else 0
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    # Room for the header, and for nothing else.
    resource.setrlimit(resource.RLIMIT_FSIZE, (room + 300, limits[1]))
    try:
        result = run(*words, "--float", "float")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert (result.exit_code, "the file cannot be written: File too large" in result.stderr) == (1, True)
    assert {p: p.read_bytes() for p in folder.rglob("*.*")} == before
    assert existing or not (folder / "a").exists()


PENDULUM = """plant p "Pendulum"
param k in (0, 9] = 2
input v
state x = 0.3
state w = -1.7
let pull = k * sin(3 * x)
der x = w - 0.37 * x * x
der w = pull - 0.11 * w + v + 0.1 * sin(t)
output y = x + 0.01 * pull
loop l
block p = p(0.7)
run 1 s step 125 ms
"""


class TestPlants:
    """A compiled plant steps as a loop does."""

    def written(self, folder, *words):
        (folder / "p.fz").write_text(PENDULUM)
        result = run("p.fz", "--block", "p", "--step", "0.125", *words)
        assert result.exit_code == 0, result.output

    def test_python_is_the_loop(self, folder):
        self.written(folder, "--target", "python", "--substeps", "3")
        spec = importlib.util.spec_from_file_location("p", folder / "p.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        done = fuzzyctl.simulate(fuzzyctl.load("p.fz", block="l"), backend="python", substeps=3)
        state = module.start()
        for expected in done["p.y"]:
            y, state = module.step(0.7, state)
            assert y == pytest.approx(expected, rel=1e-13)

    @pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
    def test_c_passes_its_self_test(self, folder):
        self.written(folder, "--target", "c", "--free", "k")
        subprocess.run(["cc", "-O1", "-o", "selftest", "p.c", "p_selftest.c", "-lm"], check=True)
        assert "0 failures" in subprocess.run(["./selftest"], check=True, capture_output=True, text=True).stdout


class TestFmu:
    """Without a compiler an FMU holds its source alone, which is fast."""

    @pytest.fixture(autouse=True)
    def _without_a_compiler(self, folder, monkeypatch):
        monkeypatch.setenv("PATH", str(folder))
        monkeypatch.delenv("CC", raising=False)

    def test_it_holds_its_source_and_its_description(self):
        assert run("tipper", "--target", "fmu").exit_code == 0
        with zipfile.ZipFile("tipper.fmu") as archive:
            assert sorted(archive.namelist()) == [
                "documentation/index.html",
                "modelDescription.xml",
                "sources/buildDescription.xml",
                "sources/fmi3.c",
                "sources/fmu_core.h",
                "sources/fmu_model.h",
                "sources/tipper.c",
                "sources/tipper.h",
            ]
            assert 'modelName="tipper"' in archive.read("modelDescription.xml").decode()

    def test_a_refuted_claim_is_in_its_documentation(self, folder):
        (folder / "c.fz").write_text("controller law\ninput e in [0, 1]\noutput u = 2 * e\nevery 1 s\nrequire u <= 1\n")
        assert run("c.fz", "--target", "fmu", "-q", "--unproved").exit_code == 0
        with zipfile.ZipFile("law.fmu") as archive:
            page = unescape(archive.read("documentation/index.html").decode())
        assert "refuted: u <= 1 (at e = " in page

    def test_only_params_that_are_named_are_free(self):
        assert run("water_tank", "--target", "fmu", "--block", "tank", "--free", "A", "-q").exit_code == 0
        with zipfile.ZipFile("tank.fmu") as archive:
            text = archive.read("modelDescription.xml").decode()
        assert 'name="A" valueReference="3" causality="parameter" variability="tunable"' in text
        assert 'name="b" valueReference="6" causality="local" variability="constant"' in text

    @pytest.mark.parametrize(("most", "optimised"), [(500_000, True), (100, False)])
    def test_a_large_source_is_compiled_without_optimisation(self, folder, monkeypatch, most, optimised):
        monkeypatch.setattr("fuzzyctl.codegen.fmu.archive._OPTIMISED", most)
        echo = folder / "compiler"
        echo.write_text('#!/bin/sh\necho "$@" >&2\nexit 1\n', encoding="utf-8")
        echo.chmod(0o755)
        monkeypatch.setenv("CC", str(echo))
        options = run("tipper", "--target", "fmu").stderr.split()
        assert ("-O0" not in options) == optimised
        assert "-ffp-contract=off" in options
