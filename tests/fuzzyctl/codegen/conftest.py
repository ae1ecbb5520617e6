"""Systems of all kinds, each small, and what compiles and runs the generated text."""

import json
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from fuzzyctl import loads
from fuzzyctl.codegen import files
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.testing import run_command
from tests import shipped

RULES = Path(__file__).resolve().parents[3] / "rules"

#: Warnings are errors, and what C leaves undefined stops the program.
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wdouble-promotion"]
SANITIZED = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
#: The same without addresses, for code that differs in its numbers only from code whose addresses are watched.
UNDEFINED = ["-O1", "-fsanitize=undefined", "-fno-sanitize-recover=all"]

BASE = """
system {name}
{settings}
input x in [0, 10]
  low  = triangle(-inf, 1, 4)
  mid  = gaussian(5, 1.2)
  high = trapezoid(6, 8, 9, inf)
input y in [-1, 1]
  down = triangle(-inf, -0.6, 0.4)
  up   = triangle(-0.5, 0.5, inf)
{outputs}
{rules}
"""

MAMDANI = """output u in [-5, 20]{otherwise}
  a = triangle(-5, 0, 5)
  b = trapezoid(2, 6, 8, 12)
  c = triangle(9, 15, 20)"""
CONSTANTS = """output u in [-5, 20]{otherwise}
  a = constant(-4)
  b = constant(0.25)
  c = constant(19)"""
THREE = "if x is low or y is up then u is a\nif x is mid then u is b weight 0.7\nif x is high and y is down then u is c"
GAPS = "if x is low and y is down then u is a\nif x is high and y is down then u is c"


def text(name, settings="", outputs=MAMDANI, rules=THREE, otherwise=" else -1"):
    return BASE.format(name=name, settings=settings, outputs=outputs.format(otherwise=otherwise), rules=rules)


def averaged(name, settings="", **more):
    return text(name, f"{settings}\ndefuzzifier weighted_average", outputs=CONSTANTS, **more)


ACTIVE = """
system active
and min
defuzzifier weighted_average
input e in [-1, 1]
  N = triangle(-inf, -1, 0)
  S = trapezoid(-1, 0, 0.25, 0.5)
  P = triangle(0.5, 1, inf)
input de in [-2, 2]
  terms N Z P
output u in [-3, 3] else 0.5
  a = linear(0.5, -0.25, 1)
  b = constant(-2)
table u = e x de
     N  Z  P
  N | a  b  .
  S | b  a  b
  P | b  b  a
"""

TEXTS = {
    "active": ACTIVE,
    "exact": text("exact"),
    "scaled": text("scaled", "implication product\naggregation max"),
    "summed": text("summed", "implication product\naggregation sum"),
    "clipped_sum": text("clipped_sum", "implication min\naggregation sum"),
    "sampled": text(
        "sampled",
        "defuzzifier centroid(resolution=37)",
        outputs=MAMDANI.replace("triangle(9, 15, 20)", "gaussian(14, 2)"),
    ),
    "takagi": text(
        "takagi",
        "and product\ndefuzzifier weighted_average",
        outputs="output u in [-50, 50]{otherwise}\n  a = linear(1, -2, 0.5)\n  b = function(x * y + 2 / (x - 5))\n"
        "  c = function(max(sqrt(x), abs(y)) - x^1.5)",
    ),
    "summing": text("summing", "defuzzifier weighted_sum", outputs=CONSTANTS),
    "tsukamoto": text(
        "tsukamoto",
        "and product\ndefuzzifier tsukamoto",
        outputs="output u in [0, 9]{otherwise}\n  a = ramp(0, 9)\n  b = ramp(8, 1)\n  c = sigmoid(4, 1.5)",
    ),
    "hedged": averaged("hedged", rules="if x is very low then u is a\nif y is somewhat up or x is not mid then u is c"),
    "norms": averaged("norms", "and hamacher_product\nor einstein_sum"),
    "drastic": averaged("drastic", "and drastic_product\nor drastic_sum"),
    "chained": averaged(
        "chained",
        rules=THREE + "\nif u is near and y is up then v is on\nif u is far then v is off",
    )
    .replace(
        "if x is low or",
        "output v in [0, 1] else nan defuzzifier centroid\n  on = triangle(0.5, 1, 1.5)\n"
        "  off = triangle(-1, 0, 0.25)\nif x is low or",
    )
    .replace("  a = constant(-4)", "  near = triangle(-inf, -4, 6)\n  far = triangle(0, 8, 20)\n  a = constant(-4)"),
    "refusing": averaged("refusing", rules=GAPS, otherwise=" else error"),
    "silent": averaged("silent", rules=GAPS, otherwise=" else nan"),
    "holding": averaged("holding", rules=GAPS, otherwise=" else hold(3)"),
    "middle": text("middle", rules=GAPS, otherwise=" else midpoint"),
    "open": averaged("open").replace("[0, 10]", "[0, 10] extrapolate"),
    "adaptive": text(
        "adaptive",
        "and product\ndefuzzifier weighted_average",
        outputs="output u in [-3, 3] adaptive rate 2 * x - 30 * y{otherwise}\n  a = constant(-2)\n  b = constant(0)\n"
        "  c = constant(3)",
    ),
    "greek": averaged("σύστημα")
    .replace("input x", "input double")
    .replace("input y", "input σ")
    .replace(" x is", " double is")
    .replace(" y is", " σ is")
    .replace("output u", "output Σ")
    .replace(" u is", " Σ is"),
}
ACTIVATIONS = {
    "first": "first(count=2)",
    "last": "last(count=1)",
    "highest": "highest(count=1)",
    "lowest": "lowest(count=2)",
    "proportional": "proportional",
    "threshold": "threshold(> 0.3)",
}
TEXTS |= {k: averaged(k, f"activation {a}", otherwise=" else 0.5") for k, a in ACTIVATIONS.items()}


ALL = [*TEXTS, *(p.stem for p in shipped.SYSTEMS)]


#: One of each family; before a release, all.
SOME = (
    *("active", "adaptive", "chained", "exact", "fcafsmc", "first", "greek", "holding", "refusing"),
    *("sampled", "takagi", "tipper", "tsukamoto"),
)


def pytest_generate_tests(metafunc):
    """Run a test that takes a `kind` for systems of all kinds, one that takes `some_kind` for some in the test line."""
    if "kind" in metafunc.fixturenames:
        metafunc.parametrize("kind", ALL)
    if "some_kind" in metafunc.fixturenames:
        kinds = [k if k in SOME else pytest.param(k, marks=pytest.mark.long) for k in ALL]
        metafunc.parametrize("some_kind", kinds)


@dataclass(frozen=True)
class Written:
    """The result of `fuzzyctl codegen`: its report, the text of each file by name, its messages."""

    code: int
    data: dict
    files: dict
    errors: str


@cache
def _written(text, target, options):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "own.fz").write_text(text, encoding="utf-8")
        given = ("own.fz", "--target", target, "-o", "out", "--format", "json", *options)
        run = run_command("codegen", *given, folder=folder)
        data = json.loads(run.output) if run.exit_code == 0 else {}
        texts = {Path(p).name: (folder / p).read_text(encoding="utf-8") for p in data.get("files", ())}
    return Written(run.exit_code, data, texts, f"{run.output}{run.errors}")


def written(text, target="c", *options):
    """Write a text, or one of the systems by name, with `fuzzyctl codegen`; once for all tests."""
    return _written(text_of(text), target, options)


def text_of(name):
    """Return the text of one of the systems by name; any other text as it is."""
    if "\n" in name:
        return name
    return TEXTS[name] if name in TEXTS else (RULES / f"{name}.fz").read_text(encoding="utf-8")


@dataclass
class Built:
    """A compiled self-test: what it printed, and whether it was content."""

    code: int
    output: str


def run_c(texts, folder, flags=(), change=None):
    """Compile C files with their self-test, strictly, and run that."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    for name, content in texts.items():
        (folder / name).write_text(change(name, content) if change else content, encoding="utf-8")
    sources = [str(folder / name) for name in texts if name.endswith(".c")]
    subprocess.run(["gcc", *STRICT, *flags, *sources, "-o", str(folder / "test"), "-lm"], check=True)
    run = subprocess.run([str(folder / "test")], capture_output=True, text=True, check=False)
    return Built(run.returncode, run.stdout + run.stderr)


#: A function of a self-test and the C that it tests, in one file.
_PART = '#define main selftest_{k}\n#include "{k}/{name}.c"\n#include "{k}/{name}_selftest.c"\n'


def c_selftests(generated, folder, flags=()):
    """Compile the self-tests of blocks with different names into one program; require that each agrees."""
    parts = {}
    for k, texts in enumerate(generated):
        (folder / f"{k}").mkdir()
        for name, content in texts.items():
            (folder / f"{k}" / name).write_text(content, encoding="utf-8")
        parts[f"{k}.c"] = _PART.format(k=k, name=next(n for n in texts if n.endswith(".h"))[:-2])
    declared = "".join(f"int selftest_{k}(void);\n" for k in range(len(parts)))
    calls = " | ".join(f"selftest_{k}()" for k in range(len(parts)))
    built = run_c({"main.c": f"{declared}int main(void)\n{{\n    return {calls};\n}}\n", **parts}, folder, flags)
    assert built.code == 0, built.output
    assert built.output.count(" 0 failures") == len(parts)
    return built.output


@pytest.fixture
def compiled(tmp_path):
    """Write a unit as C, compile it with its self-test, run that."""
    return lambda unit, flags=(), change=None: run_c(files.generate(unit, "c").files, tmp_path, flags, change)


@pytest.fixture
def node():
    """Skip a test where JavaScript does not run."""
    if shutil.which("node") is None:
        pytest.skip("node is not installed")


@pytest.fixture
def gcc():
    """Skip a test where there is no compiler."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")


#: Runs self-tests, each in a folder of its own, in one process.
SELFTESTS = """import { readdirSync } from "node:fs";
for (const folder of readdirSync(".", { withFileTypes: true }).filter((entry) => entry.isDirectory())) {
    const [test] = readdirSync(folder.name).filter((name) => name.endsWith(".test.mjs"));
    await import("./" + folder.name + "/" + test);
}
"""


def run_selftests(generated, folder):
    """Write files of several units, run all their self-tests, and return what came of it."""
    for k, texts in enumerate(generated):
        (folder / f"{k}").mkdir()
        for name, content in texts.items():
            (folder / f"{k}" / name).write_text(content, encoding="utf-8")
    (folder / "main.mjs").write_text(SELFTESTS, encoding="utf-8")
    run = subprocess.run(["node", "main.mjs"], capture_output=True, text=True, check=False, cwd=folder)
    return Built(run.returncode, run.stdout + run.stderr)


def prepared(text, block=None, **options):
    """Prepare a text, or one of the systems by name."""
    own = text_of(text)
    return prepare(block or loads(own), own, **options)


#: One of the systems by name, or a text, prepared once for all tests.
unit_of = cache(prepared)


_of_unit, _EXPECTED = files.expected_of, {}


def expected_of(unit):
    """Return the expected values of a self-test, computed once for this very unit: its tests take them repeatedly."""
    if id(unit) not in _EXPECTED:
        _EXPECTED[id(unit)] = (unit, _of_unit(unit))  # the unit, too, so that no other gets its id
    return _EXPECTED[id(unit)][1]


@pytest.fixture(autouse=True, scope="session")
def _expected_once():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(files, "expected_of", expected_of)
        yield
