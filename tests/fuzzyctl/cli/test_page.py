"""Pages compute what kernels compute, and nothing of a file becomes markup or script."""

import base64
import hashlib
import html.parser
import itertools
import json
import math
import random
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from fuzzyctl import Controller, NoRuleFiresError, compile, load, loads, why
from tests import sizes
from tests.commands import runner
from tests.shipped import LAWS, SYSTEMS

RULES = SYSTEMS[0].parent
LARGEST = 300_000
run = runner("page")

HOSTILE = """system bad "</script><script>alert(1)</script> <!-- & <b>"
source "'><img src=x onerror=alert(1)> \u202e evil"
defuzzifier center_average
input a "'><img src=x onerror=alert(2)>" in [0, 1] unit "</script>"
  terms lo hi
output u "<svg onload=alert(3)>" in [-1, 1] unit "\u2066%"
  p = constant(-1)
  q = constant(1)
if a is lo then u is p
if a is hi then u is q
"""

MIXED = """system mixed "Numbers, functions, sets, integrals, weights, hedges, what is held and what adapts"
allow FZ208
defuzzifier weighted_average
input x in [0, 10]
  low  = triangle(-inf, 0, 10)
  high = triangle(0, 10, inf)
input y in [-1, 1] extrapolate
  N = gaussian(-1, 0.7)
  P = gaussian(1, 0.7)
let both = x * y
output u in [0, 9] else hold
  flat = constant(4)
  tilt = function(both + 1)
output v in [0, 1] else error defuzzifier centroid(resolution=100) implication product
  a = triangle(0, 0.2, 0.4)
  b = triangle(0.5, 0.7, 0.9)
output k in [-3, 3] adaptive rate x else 0
  one = constant(-1)
  two = constant(1)
output w in [0, 1] else 0 defuzzifier centroid
  c = gaussian(0.2, 0.3)
  d = bell(0.8, 0.2, 2)
if x is very low and y is N then u is flat, v is a, k is one, w is c weight 0.5
if x is high and not y is N then u is tilt, v is b, k is two, w is d
"""


class Tags(html.parser.HTMLParser):
    """The tags of a page, and the texts of its scripts."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.scripts, self.policy, self.inside = [], [], "", None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        own = dict(attributes)
        self.tags.append(tag)
        self.inside = own if tag in ("script", "style") else None
        if own.get("http-equiv") == "Content-Security-Policy":
            self.policy = own["content"]

    def handle_data(self, data):
        if self.inside is not None:
            self.scripts.append((self.inside.get("id", ""), data))
            self.inside = None


def written(path, *arguments, code=0):
    """Return the tags of the page that is written, and its facts."""
    done = run(*arguments, "-o", path)
    assert done.exit_code == code, done.output
    assert path.stat().st_size <= LARGEST
    return read(path)


def read(path):
    """Return the tags and the facts of a page."""
    tags = Tags(path.read_text(encoding="utf-8"))
    return tags, json.loads(next(s for name, s in tags.scripts if name == "facts"))


def computed(folder, tags, asked):
    """Return what node computes by an expression over `kernels`."""
    script = next(s for _, s in tags.scripts if s.startswith('"use strict";\nvar kernels'))
    (folder / "main.js").write_text(f"{script}\nconsole.log(JSON.stringify({asked}));\n", encoding="utf-8")
    done = subprocess.run(["node", "main.js"], capture_output=True, text=True, check=False, cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


def points(system, count):
    """Return points within and beyond the ranges, their corners, always the same."""
    drawn = random.Random(7)
    ends = [(system.number(i.lower), system.number(i.upper)) for i in system.inputs]
    return [[a + (b - a) * drawn.uniform(-0.1, 1.1) for a, b in ends] for _ in range(count)]


def beside(found, expected, scale):
    return all(math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12 * scale) for a, b in zip(found, expected, strict=True))


LOOPS = [p for p in sorted((RULES / "loops").glob("*.fz")) if "\nsystem " in p.read_text(encoding="utf-8")]
SOURCES = [*SYSTEMS, *LOOPS]


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
@pytest.mark.parametrize("path", SOURCES, ids=lambda p: p.stem)
def test_a_page_computes_what_the_kernel_and_the_trace_compute(path, tmp_path):
    system = load(path)
    asked = points(system, 40)
    # Runs of loops take longer than all the rest.
    tags, facts = written(tmp_path / "x.html", path, "--block", system.name)
    kernel = compile(system, backend="python")
    (section,) = facts["sections"]
    start = ", kernels[0].start()" * section["state"]
    call = f"[kernels[0].evaluate(...p{start}), kernels[0].activity(...p{start})]"
    own = f"{json.dumps(asked)}.map((p) => {call})"
    state = [kernel.start()] if section["state"] else []
    for point, (output, activity) in zip(asked, computed(tmp_path, tags, own), strict=True):
        outputs = output if isinstance(output, list) else [output]
        expected = kernel(*point, *state)
        scale = max(abs(e) for o in section["outputs"] for e in (o["lower"], o["upper"]))
        assert beside(outputs, expected if isinstance(expected, tuple) else [expected], scale)
        found = why(system, dict(zip([i.name for i in system.inputs], point, strict=True)))
        degrees = [d for own in found.degrees.values() for d in own.values()]
        assert beside(sorted(activity[: section["degrees"]]), sorted(degrees), 1.0)
        acting = {r.number - 1: r.activation for r in found.rules}
        rules = len(section["rules"])
        own = activity[section["degrees"] : section["degrees"] + rules]
        assert beside(own, [acting.get(k, 0.0) for k in range(rules)], 1.0)
        for rule in found.rules:
            effects = [
                activity[section["degrees"] + rules + c["effect"]]
                for c in section["rules"][rule.number - 1]["consequents"]
            ]
            assert beside(effects, [c.effective_activation for c in rule.contributions], 1.0)


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
def test_functions_states_hedges_and_refusals_are_computed(tmp_path):
    system, file = loads(MIXED), tmp_path / "mixed.fz"
    file.write_text(MIXED, encoding="utf-8")
    tags, facts = written(tmp_path / "x.html", file)
    (section,) = facts["sections"]
    assert section["state"] is True
    asked = points(system, 40)
    own = f"""{json.dumps(asked)}.map((p) => {{
        const k = kernels[0], own = k.start();
        const functions = [k.sets.map((f) => f(0.3)), k.implications.map((f) => f(0.5, 0.25))];
        const rest = [k.activity(...p, own), k.values(...p), ...functions];
        try {{ return [k.evaluate(...p, own), ...rest]; }} catch (error) {{ return [error.output, ...rest]; }}
    }})"""
    kernel = compile(system, backend="python")
    for point, (output, activity, values, sets, implied) in zip(asked, computed(tmp_path, tags, own), strict=True):
        assert implied == [0.125, 0.25]
        assert [len(s) for s in sets] == [3, 2, 0, 0, 2, 0, 2]
        x = min(max(point[0], 0.0), 10.0)
        assert beside(values, [x * point[1] + 1], 1.0)
        given = dict(zip(("x", "y"), point, strict=True))
        if isinstance(output, str):
            with pytest.raises(NoRuleFiresError, match=output):
                kernel(*point, list(kernel.start()))
            continue
        assert beside(output, kernel(*point, list(kernel.start())), 10.0)
        found = why(system, given)
        for rule in found.rules:
            parts = section["rules"][rule.number - 1]["consequents"]
            effects = [activity[section["degrees"] + 2 + c["effect"]] for c in parts]
            assert beside(effects, [c.effective_activation for c in rule.contributions], 1.0)


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
@pytest.mark.parametrize(
    "path", [p for p in LAWS if p.stem != "one_channel"], ids=lambda p: p.stem
)  # takes long to prove
def test_steps_of_a_controller_are_those_of_the_kernel(path, tmp_path):
    tags, facts = written(tmp_path / "x.html", path)
    controller = load(path, block=Controller)
    (section,) = facts["sections"]
    names = [i["name"] for i in section["inputs"]]
    asked = [
        [0.01 * (k + 1) * (n + 1) for n in range(len(names))] + [0.005] * (section["period"] is None) for k in range(10)
    ]
    start = "kernels[0].start()" if section["state"] else "null"
    own = f"((s) => {json.dumps(asked)}.map((p) => kernels[0].step(...(s === null ? [] : [s]), ...p)))({start})"
    step = compile(controller, backend="python")
    state = step.start()
    for given, output in zip(asked, computed(tmp_path, tags, own), strict=True):
        inputs = given[: len(names)]
        expected, state = step(*inputs, state, **({} if section["period"] else {"dt": 0.005}))
        pairs = zip(*[v if isinstance(v, list | tuple) else [v] for v in (output, expected)], strict=True)
        assert all(math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12) for a, b in pairs)


def test_nothing_of_a_file_becomes_markup_and_only_hashed_scripts_run(tmp_path):
    file = tmp_path / "bad.fz"
    file.write_text(HOSTILE, encoding="utf-8")
    tags, facts = written(tmp_path / "bad.html", file)
    assert sorted(set(tags.tags)) == ["body", "head", "html", "main", "meta", "noscript", "script", "style", "title"]
    assert tags.tags.count("script") == 3
    hashes = [
        base64.b64encode(hashlib.sha256(s.encode()).digest()).decode() for name, s in tags.scripts if name != "facts"
    ]
    assert len(hashes) == 3
    assert all(f"'sha256-{h}'" in tags.policy for h in hashes)
    assert tags.policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "unsafe" not in tags.policy
    assert facts["sections"][0]["title"] == "</script><script>alert(1)</script> <!-- & <b>"
    text = (tmp_path / "bad.html").read_text(encoding="utf-8")
    assert not re.search("[\u202a-\u202e\u2066-\u2069\u2028\u2029]", text)
    assert "innerHTML" not in text
    assert not re.search(r"""(src|href)=["']?(https?:)?//|fetch\(|import\(|XMLHttpRequest""", text)


def test_a_page_of_a_file_with_a_loop_holds_its_blocks_and_its_run(tmp_path):
    _, facts = written(tmp_path / "x.html", RULES / "loops" / "water_tank.fz", "--set", "law.GU=6")
    assert [(s["kind"], s["name"]) for s in facts["sections"]] == [
        ("system", "surface"),
        ("controller", "fuzzy_pi"),
        ("loop", "fill"),
    ]
    loop = facts["sections"][-1]
    assert ["law.GU", "6"] in loop["facts"]
    assert (loop["t"][0], loop["t"][-1]) == (0.0, 60.0)
    assert {len(p["values"]) for p in loop["panels"]} == {len(loop["t"])}
    assert [p["name"] for p in loop["panels"]] == ["tank.y", "law.valve", "leak"]
    assert loop["panels"][0]["reference"]["values"][0] == 1.0
    assert [v[0] for v in loop["verdicts"]] == ["met", "met"]
    controller = facts["sections"][1]
    assert controller["bounds"] == [["valve", "from 0 to 10 V"]]
    assert controller["verdicts"] == [["proved", "valve in [0, 10]", "for reference, level up to 1e30 in magnitude"]]


def test_a_signal_of_period_two_does_not_look_constant(tmp_path):
    file = tmp_path / "c.fz"
    file.write_text(
        "controller toggle\noutput u in [-1, 1] = clamp(-previous(u, 1), -1, 1)\nevery 1 s\n\n"
        "loop chatter\nblock own = toggle()\nrun 2000 s\n", encoding="utf-8",
    )  # fmt: skip
    _, facts = written(tmp_path / "x.html", file)
    (panel,) = facts["sections"][-1]["panels"]
    times, peaks = panel["peaks"]
    assert len({*panel["values"][:-1]}) == 1
    assert {*panel["values"], *peaks} == {-1.0, 1.0}
    assert times == [t + 1.0 for t in facts["sections"][-1]["t"][:-1]]


def test_the_time_of_a_run_has_the_inputs_of_controllers_and_systems(tmp_path):
    _, facts = written(tmp_path / "x.html", RULES / "loops" / "water_tank.fz")
    loop = facts["sections"][-1]
    (law, system) = loop["inputs"]
    assert (law["block"], system["block"]) == ("fuzzy_pi", "surface")
    assert law["call"] == system["call"] == "law"
    reference, level = law["values"]
    error, change = system["values"]
    assert [len(v) for v in (reference, level, error, change)] == [len(loop["t"])] * 4
    assert error == pytest.approx([2 * (r - x) for r, x in zip(reference, level, strict=True)], abs=1e-4)
    assert (change[0], len(set(change)) > 50) == (0.0, True)


TWICE = """system shape
input a in [-1, 1]
  terms lo hi
output u in [-1, 1]
  terms lo hi
if a is lo then u is lo
if a is hi then u is hi

controller twice
input e unit "m"
input f in [0, inf)
state kept "what is kept" in [0, 1] unit "m" = 0
next kept = clamp(kept + e, 0, 1)
let slow = lowpass(e,
  0.1 s)
output u unit "m" = shape(slow) + shape(2 * f) + kept
output rest in [0, 3] = delay(e, 5) * 0
every 10 ms

plant lag
input u
state x = 1
der x = -x - u
output y = x

loop closed
block law = twice(e = body.y, f = 0.25)
block body = lag(u = law.u)
measure never unit "s" = rise_time(body.y, 5)
run 1 s
"""


def test_each_call_of_a_system_is_shown_and_states_are_named_as_they_are_written(tmp_path):
    file = tmp_path / "calls.fz"
    file.write_text(TWICE, encoding="utf-8")
    _, facts = written(tmp_path / "x.html", file)
    assert facts["title"] == "calls"
    _, controller, loop = facts["sections"]
    assert [(c["block"], c["call"]) for c in loop["inputs"]] == [
        ("twice", "law"), ("shape", "law"), ("shape", "law, call 2"),
    ]  # fmt: skip
    assert set(loop["inputs"][2]["values"][0]) == {0.5}
    assert loop["measures"] == [["never", "infinite"]]
    assert [(i["lower"], i["upper"]) for i in controller["inputs"]] == [(None, None), (0.0, None)]
    assert [(o["lower"], o["upper"]) for o in controller["outputs"]] == [(None, None), (0.0, 3.0)]
    assert set(controller["states"].values()) == {
        "what is kept [m]", "lowpass(e, 0.1 s), filtered", "delay(e, 5)", "whether a step was made",
    }  # fmt: skip


ADAPTING = """system gain
defuzzifier weighted_average
input e in [-1, 1]
  terms low high
output F in [-2, 2] adaptive rate e
  terms N=0 P=0
if e is low then F is N
if e is high then F is P

system held
allow FZ208
input e in [-1, 1]
  terms low high
output H in [-1, 1] else hold
  terms N P
if e is very low then H is N

controller inner
input e in [-1, 1]
output v = gain(
  e / 2)
every 1 s

controller c
input e in [-1, 1]
let push = gain(e)
block one = inner(e)
output u = push + one.v + held(e)
every 1 s
"""


def test_what_a_call_of_a_system_keeps_is_named_in_words(tmp_path):
    file = tmp_path / "c.fz"
    file.write_text(ADAPTING, encoding="utf-8")
    _, facts = written(tmp_path / "x.html", file)
    assert sorted(facts["sections"][-1]["states"].values()) == [
        "held(e), last value of H",
        *(f"one.v = gain(e / 2), adaptive consequent {k} of F" for k in (1, 2)),
        *(f"push = gain(e), adaptive consequent {k} of F" for k in (1, 2)),
    ]


def test_of_a_controller_is_shown_what_is_refuted_and_what_has_no_bound(tmp_path):
    file = tmp_path / "c.fz"
    file.write_text(
        "controller c\ninput e in [0, 1]\nstate s in [0, 1] unit \"m\" = 0\nstate t = 0\nnext s = s + e\n"
        "next t = t - e\noutput u = t\nevery 1 s\nrequire s >= 0\n", encoding="utf-8",
    )  # fmt: skip
    _, facts = written(tmp_path / "x.html", file, code=1)
    (section,) = facts["sections"]
    assert section["bounds"][0][1].startswith("at most")
    verdicts = {claim: (word, note) for word, claim, note, *_ in section["verdicts"]}
    assert verdicts["s in [0, 1]"][0] == "refuted"
    assert "reached from the start" in verdicts["s in [0, 1]"][1]


def test_tables_bounds_verdicts_and_diagnostics_are_shown(tmp_path):
    _, facts = written(tmp_path / "x.html", RULES / "ais_reaction.fz", "--set", "k_s=0.5")
    (section,) = facts["sections"]
    (table,) = section["tables"]
    assert [[c["rule"] for c in row] for row in table["cells"]] == [[5 * r + c for c in range(5)] for r in range(5)]
    assert (table["rows"], table["columns"]) == ("sigma", "dsigma")
    assert ["k_s", "0.5"] in section["facts"]
    assert section["bounds"] == [["f", "from -1 to 0.18"]]
    assert [v[0] for v in section["verdicts"]] == ["proved", "proved", "proved"]
    assert facts["diagnostics"] == []
    file = tmp_path / "unused.fz"
    file.write_text("system s\ninput x in [0, 1]\n  terms a b c\noutput u in [0, 1] else 0\n  terms p q\n"
                    "if x is a then u is p\nif x is b then u is q\n", encoding="utf-8")  # fmt: skip
    _, facts = written(tmp_path / "x.html", file)
    assert "FZ208" in [d["code"] for d in facts["diagnostics"]]


FILES = [p for folder in (RULES, Path(__file__).parents[3] / "apps" / "gallery") for p in sorted(folder.rglob("*.fz"))]
#: Kinds and names of the blocks of each file, read from their headers: files are formatted, and checks take seconds.
HEADERS = {p: re.findall(r"^(system|controller|loop) (\w+)", p.read_text("utf-8"), re.MULTILINE) for p in FILES}
#: Systems and controllers of shipped files.
SHIPPED = sizes.some([(p, name) for p in FILES for kind, name in HEADERS[p] if kind != "loop"], 4)
#: Shipped files with loops.
WITH_LOOPS = sizes.some([p for p in FILES if "loop" in dict(HEADERS[p])], 4)
#: What a page computes at a point: outputs of a system, or of one step of a controller.
AT_POINT = """((section, point, kernel) => {
    const values = section.inputs.map((i) => point[i.name] ?? 0.5);
    const state = kernel.start === null ? null : kernel.start();
    for (const [name, value] of Object.entries(point).map(([n, v]) => [section.members?.[n] ?? n, v])) {
        if (state !== null && name in state) state[name] = value;
    }
    const rest = state === null ? [] : [state], time = section.period === null ? [point.dt ?? 0.01] : [];
    return kernel.step ? kernel.step(...rest, ...values, ...time) : kernel.evaluate(...values, ...rest);
})"""


def first_outputs(block, count=20):
    """Return the first output of a block at drawn points, a controller's at its first step."""
    if not isinstance(block, Controller):
        kernel = compile(block, backend="python")
        state = [kernel.start()] if kernel.plan.initial_state else []
        found = [kernel(*point, *state) for point in points(block, count)]
    else:
        step, drawn = compile(block, backend="python"), random.Random(3)
        time = {} if step.period else {"dt": 0.01}
        found = [step(*(drawn.uniform(-1, 1) for _ in block.inputs), step.start(), **time)[0] for _ in range(count)]
    return [own[0] if isinstance(own, tuple) else own for own in found]


@pytest.mark.parametrize(("path", "name"), SHIPPED, ids=lambda x: getattr(x, "stem", x))
def test_the_page_of_a_block_with_a_false_claim_is_written_and_its_point_is_the_witness(path, name, tmp_path):
    block = load(path, block=name)
    output = (block.results if isinstance(block, Controller) else block.outputs)[0].name
    values = [v for v in first_outputs(block) if math.isfinite(v)]
    limit = (min(values) + max(values)) / 2 - (min(values) == max(values))
    text = path.read_text(encoding="utf-8")
    begin = re.search(rf"^(system|controller) {name}\b", text, flags=re.MULTILINE).end()
    end = re.compile(r"^(system|controller|plant|loop)\b|\Z", flags=re.MULTILINE).search(text, begin).start()
    folder = shutil.copytree(path.parent, tmp_path / "files", ignore=lambda *_: ["loops"])
    claim = f"{output} <= {limit!r}"
    (folder / path.name).write_text(f"{text[:end]}\nrequire {claim}\n\n{text[end:]}", encoding="utf-8")

    done = run(folder / path.name, "--block", name, "-o", tmp_path / "x.html")
    assert done.exit_code == 1, done.output
    assert f"error[FZ402]: the guarantee '{claim}' does not hold" in done.output
    tags, facts = read(tmp_path / "x.html")
    (section,) = facts["sections"]
    (point,) = [row[3] for row in section["verdicts"] if row[0] == "refuted"]
    if shutil.which("node"):
        own = computed(tmp_path, tags, f"{AT_POINT}({json.dumps(section)}, {json.dumps(point)}, kernels[0])")
        assert (own[0] if isinstance(own, list) else own) > limit


@pytest.mark.parametrize("path", WITH_LOOPS, ids=lambda p: p.stem)
def test_the_page_of_loops_with_unmet_requirements_is_written_and_says_so(path, tmp_path):
    folder = shutil.copytree(path.parent, tmp_path / "files", ignore=lambda *_: ["loops"])
    text = re.sub(r"(?m)^require (always|stable).*$", "", path.read_text(encoding="utf-8"))  # proofs are not asked for
    text = re.sub(r"(?m)^measure (\w+).*$", r"\g<0>\nrequire \1 < 0 and \1 > 0", text)
    (folder / path.name).write_text(text, encoding="utf-8")
    for loop in (load(folder / path.name, block=name) for kind, name in HEADERS[path] if kind == "loop"):
        done = run(folder / path.name, "--block", loop.name, "-o", tmp_path / "x.html")
        assert done.exit_code == 1, done.output
        (section,) = read(tmp_path / "x.html")[1]["sections"]
        broken = [claim for word, claim, _ in section["verdicts"] if word == "not met"]
        assert broken == [f"{m.name} < 0 and {m.name} > 0" for m in loop.measures]
        assert all(f"the run does not meet the requirement '{claim}'" in done.output for claim in broken)


def test_no_other_claim_is_begun_when_the_time_of_a_page_is_spent(tmp_path, monkeypatch):
    file, seen = tmp_path / "a.fz", []
    rules = "if x is lo then u is a\nif x is hi then u is b\n"
    sets = "  lo = gaussian(0, 3)\n  hi = gaussian(10, 3)\noutput u in [0, 1]\n  a = triangle(0, 0.2, 0.4)\n"
    text = f"system a\ninput x in [0, 10]\n{sets}  b = triangle(0.6, 0.8, 1)\n{rules}"
    file.write_text(text + "require u <= 0.97\n", encoding="utf-8")
    for step in (0.0, 10.0):
        monkeypatch.setattr("fuzzyctl.analysis.work.clock.now", itertools.count(step=step).__next__)
        seen.append(written(tmp_path / "x.html", file, code=3 if step else 0)[1]["sections"][0]["verdicts"][0][0])
    assert seen == ["proved", "undecided"]


FAMILY = """
plant tank
state h = 1
der h = -h
output level = h
loop l
block tank = tank()
for tank.h in [0.5, 1.5]
run 2 s step 10 ms
measure highest = maximum(tank.level)
require highest <= 1
require always tank.level <= 1.6
require always tank.level <= 1.55
require always tank.level <= 1.4
"""


def test_the_page_of_a_family_shows_what_is_proved_of_all_members_and_their_bounds(tmp_path):
    (tmp_path / "a.fz").write_text(FAMILY, encoding="utf-8")
    done = run(tmp_path / "a.fz", "-o", tmp_path / "x.html")
    assert done.exit_code == 1
    assert "the guarantee 'always tank.level <= 1.4' does not hold" in done.output
    _, facts = read(tmp_path / "x.html")
    (loop,) = facts["sections"]
    words = [(word, claim) for word, claim, _ in loop["verdicts"]]
    claims = ["always tank.level <= 1.6", "always tank.level <= 1.55", "always tank.level <= 1.4"]
    assert words == [("met", "highest <= 1"), *zip(("proved", "proved", "refuted"), claims, strict=True)]
    (panel,) = loop["panels"]
    tube = panel["tube"]
    assert len(tube["t"]) == len(tube["low"]) + 1 == len(tube["high"]) + 1 <= 201
    assert (tube["t"][0], tube["t"][-1]) == (0.0, 2.0)
    assert 1.5 <= max(tube["high"]) <= 1.53
    assert panel["y"][1] > max(tube["high"])
    assert all(low <= v <= high for v, low, high in zip(panel["values"], tube["low"], tube["high"], strict=False))
