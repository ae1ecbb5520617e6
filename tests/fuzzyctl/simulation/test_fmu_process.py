"""Loops with FMUs run in a process of their own: native code that crashes, exits or hangs ends in a diagnostic."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from fuzzyctl import DiagnosticError, Experiment, simulate
from fuzzyctl.interop.gymnasium import environment
from fuzzyctl.interop.plants import python_plant, with_plant
from tests.fuzzyctl.codegen.fmu.fmus import changed, write_fmu

PLANT = "plant p\ninput u\nstate x = 0\nder x = u - x\noutput y in [-10, 10] = x\n"
LOOP = """
controller law
input y in [-10, 10]
output u in [-5, 5] = 1 - y
every 20 ms
loop l
block law = law(p.y)
block p = p(law.u)
measure last = final(p.y)
run 1 s step 20 ms
"""
#: Native code by what it does.
CRASHES = {
    "segv": "volatile int *nowhere = (volatile int *)8; *nowhere = 1;",
    "abort": "abort();",
    "exit": "exit(0);",
    "overflow": "deep(0);",
    "hang": 'fclose(fopen("hung", "w")); for (;;) { usleep(1000); }',
}
HEAD = """#include <stdlib.h>
#include <stdio.h>
#include <unistd.h>
static int deep(volatile char *last) { volatile char a[4096]; a[0] = last ? *last : 0; return deep(a) + a[0]; }
"""
#: The text of `fmi3.c` before which it is put.
PLACES = {
    "instantiate": ('    static const char call[] = "fmi3InstantiateCoSimulation";\n', "{}"),
    "initialize": ('    static const char call[] = "fmi3EnterInitializationMode";\n', "{}"),
    "step": (
        '    static const char call[] = "fmi3DoStep";\n',
        "if (((fmu_Instance *)instance)->now.time > 0.25) {{ {} }}",
    ),
    "free": ("    free(instance);\n", "{}"),
}


@pytest.fixture(scope="module")
def fmu_of(tmp_path_factory):
    """Return the FMU of a plant whose native code does something at a place, each made once."""
    pytest.importorskip("fmpy")
    folder = tmp_path_factory.mktemp("fmus")
    plain = write_fmu(PLANT, folder / "plain.fmu").read_bytes()
    made = {("", ""): plain}

    def build(place="", code=""):
        def hostile(name, content):
            text = content.decode() if name == "sources/fmi3.c" else ""
            if not text:
                return content
            if place == "load":
                text = f"{text}\n__attribute__((constructor)) static void hostile(void) {{ {code} }}\n"
            else:
                before, form = PLACES[place]
                text = text.replace(before, f"{form.format(code)}\n{before}")
            return f"{HEAD}{text}".encode()

        if (place, code) not in made:
            (folder / "own.fmu").write_bytes(plain)
            made[place, code] = changed(folder / "own.fmu", hostile, compile_again=True).read_bytes()
        return made[place, code]

    return build


@pytest.fixture
def fmu_loop(loop, tmp_path, fmu_of):
    def load(place="", what="", text=LOOP):
        (tmp_path / "p.fmu").write_bytes(fmu_of(place, CRASHES.get(what, what)))
        return loop(f'plant p = fmu("p.fmu")\n{text}')

    return load


@pytest.mark.parametrize(
    ("place", "what", "call", "how", "samples"),
    [
        ("load", "segv", "begin at t = 0 s", "it was ended by SIGSEGV: Segmentation fault", 0),
        ("instantiate", "abort", "begin at t = 0 s", "it was ended by SIGABRT: Aborted", 0),
        ("initialize", "exit", "begin at t = 0 s", "it ended its process with exit code 0", 0),
        ("step", "overflow", "make a step at t = 0.26 s", "it was ended by SIGSEGV: Segmentation fault", 14),
        ("step", "abort", "make a step at t = 0.26 s", "it was ended by SIGABRT: Aborted", 14),
        ("free", "segv", "be freed at t = 1 s", "it was ended by SIGSEGV: Segmentation fault", 51),
    ],
)
def test_a_crash_of_native_code_is_a_diagnostic(fmu_loop, place, what, call, how, samples):
    run = Experiment(fmu_loop(place, what)).run()
    assert run.stopped.code == "FZ713"
    assert run.stopped.message == f"FMU 'p' crashed when it had to {call}"
    assert run.stopped.facts[0] == how
    assert run.stopped.facts[-1].startswith("it is block 'p', ")
    assert run.stopped.span.text == "p"
    assert len(run) == samples
    y, u = run["p.y"], run["law.u"]
    assert y[1:] == pytest.approx(u[:-1] + (y[:-1] - u[:-1]) * np.exp(-0.02), rel=1e-9)


def test_the_last_messages_of_the_fmu_are_facts(fmu_loop):
    code = '{ fmu_Instance *own = instance; fmu_fail(own, "own", "the tank is empty"); abort(); }'
    run = Experiment(fmu_loop("step", code)).run()
    assert run.stopped.facts[1] == "it says: own: the tank is empty"


def test_after_a_crash_the_next_run_begins_anew(fmu_loop, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code = 'if (access("flag", F_OK)) { fclose(fopen("flag", "w")); abort(); }'
    experiment = Experiment(fmu_loop("step", code))
    first, second = experiment.run(), experiment.run()
    assert (first.stopped.code, len(first)) == ("FZ713", 14)
    assert second.stopped is None


def test_a_crash_of_the_second_run_of_simulate_is_reported(fmu_loop, tmp_path, monkeypatch):
    """It has half the step, for the states of the other plant."""
    monkeypatch.chdir(tmp_path)
    code = 'if (access("flag", F_OK)) { fclose(fopen("flag", "w")); } else { abort(); }'
    text = LOOP.replace("block law", "block q = q(0)\nblock law")
    run = simulate(fmu_loop("instantiate", code, f"plant q\ninput u\nstate x = 1\nder x = u - x\noutput y = x\n{text}"))
    assert (run.stopped.code, len(run)) == ("FZ713", 51)


class TestInterrupts:
    """Ctrl-C reaches `fuzzyctl simulate` alone, or its process group as in a terminal."""

    def begun(self, fmu_loop, tmp_path, **options):
        fmu_loop("step", "hang")
        command = [sys.executable, "-m", "fuzzyctl", "simulate", "loop.fz", "-o", "out", "--format", "json"]
        process = subprocess.Popen(command, cwd=tmp_path, stdout=-1, stderr=-1, text=True, process_group=0, **options)
        while not (tmp_path / "hung").exists():
            assert process.poll() is None
            time.sleep(0.02)
        return process, int(ps("-o", "pid=", "--ppid", str(process.pid))[0])

    @pytest.mark.parametrize("kill", [os.kill, os.killpg])
    def test_end_native_code_that_hangs_and_keep_what_is_done(self, fmu_loop, tmp_path, kill):
        process, child = self.begun(fmu_loop, tmp_path)
        kill(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=60)
        assert (process.returncode, err) == (1, "")
        (found,) = json.loads(out)["diagnostics"]
        assert (found["code"], found["message"]) == ("FZ707", "the run was interrupted at t = 0.26 s")
        assert len((tmp_path / "out" / "data.csv").read_text().splitlines()) == 1 + 13
        assert gone(child)

    def test_a_process_that_is_killed_leaves_none_behind(self, fmu_loop, tmp_path):
        process, child = self.begun(fmu_loop, tmp_path, env=os.environ | {"TMPDIR": str(tmp_path)})
        process.kill()
        process.communicate(timeout=60)
        assert gone(child)
        assert not list(tmp_path.glob("fuzzyctl-*"))

    def test_a_program_that_ends_without_cleaning_up_leaves_no_files(self, fmu_loop, tmp_path):
        fmu_loop()
        script = "import os, fuzzyctl\nrun = fuzzyctl.Experiment(fuzzyctl.load('loop.fz', block='l')).run()\n"
        script += f"print(len(os.listdir({str(tmp_path / 'own')!r})), run.stopped, flush=True)\nos._exit(0)"
        (tmp_path / "own").mkdir()
        environ = os.environ | {"TMPDIR": str(tmp_path / "own")}
        found = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environ, stdout=-1, check=True)
        assert found.stdout == b"1 None\n"
        ends = time.monotonic() + 20
        while list((tmp_path / "own").iterdir()) and time.monotonic() < ends:
            time.sleep(0.05)
        assert not list((tmp_path / "own").iterdir())


def gone(process):
    ends = time.monotonic() + 20
    while ps("-o", "stat=", "-p", str(process)) and time.monotonic() < ends:
        time.sleep(0.05)
    return not ps("-o", "stat=", "-p", str(process))


def ps(*options):
    return subprocess.run(["ps", "-ww", *options], capture_output=True, text=True, check=False).stdout.splitlines()


def own_processes():
    return [line for line in ps("-o", "args=", "--ppid", str(os.getpid())) if "fmu_process" in line]


class TestProcesses:
    def test_one_serves_all_runs_of_a_loop_and_then_the_next_loop(self, fmu_loop):
        loop, processes, before = fmu_loop(), set(), set(own_processes())
        for _ in range(3):
            experiment = Experiment(loop)
            for _ in range(2):
                experiment.run()
                processes.add(experiment._kernel._process.own.pid)
        del experiment
        assert len(processes) == 1
        assert len({*own_processes()} - before) <= 1

    def test_one_that_cannot_be_started_is_a_diagnostic(self, fmu_loop, monkeypatch):
        monkeypatch.setattr(sys, "executable", "/nowhere/python")
        monkeypatch.setattr("fuzzyctl.simulation.fmu_process._idle", [])
        with pytest.raises(DiagnosticError, match=r"\[FZ713\]: the process for FMUs cannot be started"):
            Experiment(fmu_loop()).run()

    def test_loops_side_by_side_have_their_own(self, fmu_loop):
        loop = fmu_loop()
        first, second = Experiment(loop), Experiment(loop)
        expected = first.run().record
        assert np.array_equal(second.run().record, expected)
        assert np.array_equal(first.run().record, expected)
        assert first._kernel._process is not second._kernel._process
        first._kernel._process.end()  # as if it had crashed between two runs
        assert np.array_equal(first.run().record, expected)

    def test_a_loop_without_fmus_starts_none(self, loop):
        before = own_processes()
        code = "import sys, fuzzyctl\nfuzzyctl.simulate(fuzzyctl.load('water_tank', block='fill'))\n"
        code += "print([m for m in sys.modules if 'fmu_process' in m])"
        found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        assert found.stdout == "[]\n"
        assert own_processes() == before

    def test_functions_of_the_caller_stay_with_the_caller(self, fmu_loop):
        seen = []
        plant = python_plant(
            "q",
            ["u"],
            {"x": 1.0},
            ["y"],
            derivative=lambda t, x, u: (u[0] - x[0],),
            output=lambda t, x: seen.append(t) or x,
        )
        text = LOOP.replace("block law", "block q = q(0)\nblock law")
        loop = fmu_loop(text=f"plant q\ninput u\nstate x = 1\nder x = u - x\noutput y = x\n{text}")
        before = own_processes()
        Experiment(with_plant(loop, "q", plant)).run()
        assert seen
        assert own_processes() == before

    def test_a_plant_in_python_runs_beside_the_fmu(self, fmu_loop, tmp_path):
        code = 'import os\ninputs = ("u",)\nstates = {"x": 0.0}\noutputs = ("y",)\n\ndef derivative(t, x, u):\n'
        code += "    return (1 / 0,) if t > 0.5 else (0,)\n\ndef output(t, x):\n    return (os.getpid(),)\n"
        (tmp_path / "q.py").write_text(code)
        text = LOOP.replace("block law", "block q = q(0)\nblock law")
        run = Experiment(fmu_loop(text=f'plant q = python("q.py")\n{text}')).run()
        assert run["q.y"][0] != os.getpid()
        assert run.stopped.code == "FZ704"
        assert run.stopped.facts[0].endswith("q.py:7: division by zero")
        assert run.stopped.span.text == "q"


def test_an_episode_of_gymnasium_ends_where_its_fmu_crashes(fmu_loop):
    def episode(loop):
        env = environment(loop, "law", reward=lambda s: 0.0)
        rows, ended = [env.reset(seed=1)[0]], False
        while not ended:
            found, _, terminated, truncated, info = env.step([0.5])
            rows.append(found)
            ended = terminated or truncated
        return np.array(rows), info.get("stopped")

    whole, stopped = episode(fmu_loop())
    assert (len(whole), stopped) == (51, None)
    assert whole[1:, 0] == pytest.approx(0.5 - 0.5 * np.exp(-0.02 * np.arange(1, 51)), abs=1e-9)
    rows, stopped = episode(fmu_loop("step", "abort"))
    assert stopped == "FMU 'p' crashed when it had to make a step at t = 0.26 s"
    assert np.array_equal(rows[:14], whole[:14])


def test_scripts_need_no_guard_and_pass_on_their_path(fmu_loop, tmp_path):
    fmu_loop()
    (tmp_path / "aside").mkdir()
    (tmp_path / "aside" / "fmpy.py").write_text("raise ImportError('another one')\n")
    script = (
        "import sys, fuzzyctl\nsys.path.insert(0, 'aside')\nfuzzyctl.simulate(fuzzyctl.load('loop.fz', block='l'))\n"
    )
    (tmp_path / "script.py").write_text(script)
    found = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "FMUs are run by FMPy, which is not installed" in found.stderr
    assert "= another one" in found.stderr
