"""Drawn controllers, plants and loops: each is read back as it was from the text that it is written as."""

import re

from hypothesis import given
from hypothesis import strategies as st

import fuzzyctl
from fuzzyctl.testing import check_text
from tests.layout import laid_out
from tests.properties.running import quick
from tests.properties.test_controllers import RULE, controllers

#: Forms of equations of plants over values a and b.
FORMS = (
    "{a} + 0.5 * {b}",
    "-({a} - {b}) ^ 2",
    "{a} / (1 + abs({b}))",
    "where({a} > {b} and not ({b} < 0.5 or {a} == 1), {b}, -{a})",
    "clamp({a}, -1, abs({b}))",
    "rule({a}, {b})",
    "rule(d={a}, e=0.5)",
    "twice({a}) - {b}",
    "delay({a}, 0.2 s)",
    "delay({b}, k, start=-1e-3)",
    "k + sin({a} * t)",
    "where(near and not {b} in (0, 1], {a}, near)",
)
RANGES = ("", " in [-inf, inf]", " in (k - 2, 1e3)", " in [-5, inf)")
EXTRAS = ("", ' unit "m/s"')
#: Plants of one line.
LINEAR = (
    "tf(num=[{n}], den=[1, {d}, 2])",
    "tf(num=[{n}, 1], den=[k, {d}, 0], delay=0.1 s)",
    "zpk(zeros=[-{d}, pair(-1, {d})], poles=[pair(-{d}, 1), -{d}, -{d}], gain={n})",
    "ss(A=[[0, 1], [-{d}, -3]], B=[[0, 1], [1, k]], C=[1, 0], D=[{n}, 0])",
)
SIGNALS = (
    "steps(0: 1, 0.5 s: -k)",
    "pulse(0.1 s, 0.2 s) * 2",
    "ramp(0, 0.5, high=k)",
    "sine(2, phase=pi / 2)",
    "noise(0.1, seed=3)",
    "sin(t)",
)
MEASURES = (
    "overshoot(p.y, r)",
    "settling(p.y, r, band=5 %, begin=0.1 s)",
    "iae(p.y, r + 1) / k",
    "maximum(abs(p.y)) - minimum(p.y)",
)


@st.composite
def plants(draw):
    """Draw the text of a plant with the system that it may call; the order of its lines is drawn, too."""
    if draw(st.booleans()):
        numbers = {"n": draw(st.sampled_from(["1", "2.5", "0.1 + k"])), "d": draw(st.sampled_from(["3", "1e-3", "k"]))}
        return f"plant drawn = {draw(st.sampled_from(LINEAR)).format(**numbers)}\nparam k = 2\n"
    extra = draw(st.sampled_from(RANGES)) + draw(st.sampled_from(EXTRAS))
    lines = [
        'input u "force"',
        f"state x{extra} = 0.5",
        "param k in [0, 1] = 0.5",
        "let near = u > x",
        "der x = 2 * (u - x)",
    ]
    names = ["u", "x"]
    for number in range(draw(st.integers(1, 6))):
        a, b = draw(st.sampled_from(names)), draw(st.sampled_from(names))
        lines.append(f"let v{number} = {draw(st.sampled_from(FORMS)).format(a=a, b=b)}")
        names.append(f"v{number}")
    lines.append(f'output y "place"{draw(st.sampled_from(EXTRAS))} = {names[-1]} + x')
    lines = draw(st.permutations(lines))
    return f'function twice(a) = a + a\n{RULE}plant drawn "Title"\nsource "here"\n' + "\n".join(lines) + "\n"


@st.composite
def loops(draw):
    """Draw the text of a loop around a plant and a controller."""
    lines = ["block law = law(r - p.y, k=k)", "block p = lag(law.v + d)", "param k in [0, 10] = 2", "run 1 s"]
    lines += [f"let {name} = {draw(st.sampled_from(SIGNALS))}" for name in "rd"]
    lines += [f"measure m{i} = {draw(st.sampled_from(MEASURES))}" for i in range(draw(st.integers(0, 3)))]
    if any("m0" in line for line in lines):
        lines += ["measure small = m0 <= 2 and m0 > k", "require small or m0 in [0, k] within 1e-6"]
    lines = draw(st.permutations(lines))
    head = "controller law\ninput e\nparam k in [0, 10] = 1\noutput v = k * e\nplant lag = tf(num=[1], den=[1, 1])\n"
    return head + "loop drawn\n" + "\n".join(lines) + "\n"


def block_of(text):
    blocks, found = check_text(text, guarantees=False)
    assert [d.message for d in found if d.severity == "error"] == []
    return blocks[-1]


@given(st.one_of(controllers(), plants(), loops()))
@quick(150)
def test_a_block_is_read_back_as_it_was(text):
    block = block_of(text)
    written = fuzzyctl.dumps(block)
    assert block_of(written) == block
    assert fuzzyctl.dumps(block_of(written)) == written


#: What a word of a text is replaced by.
WORDS = (
    *"plant loop controller state der next block measure run t inf tf steps noise delay iae".split(),
    *"( ) [ ] , : = 0 -1 1e400 #".split(),
    "\n",
)


@given(st.one_of(controllers(), plants(), loops()), st.randoms(use_true_random=False))
@quick(100)
def test_a_text_with_wrong_words_is_read_whole_or_reported(text, random):
    words = re.findall(r"\w+|\s|[^\w\s]", text)
    for _ in range(random.randint(1, 3)):
        words[random.randrange(len(words))] = random.choice(("", *WORDS))
    text = "".join(words)
    blocks, found = check_text(text, guarantees=False)
    heads = re.findall(r"^\s*(?:controller|plant|loop)\b(?!\s*[=|])", text, flags=re.MULTILINE)
    wrong = any(d.severity == "error" for d in found)
    assert wrong or sum(b.kind != "system" for b in blocks) == len(heads)


@given(st.one_of(controllers(), plants(), loops()))
@quick(50)
def test_layout_changes_no_meaning_and_is_kept(text):
    laid = laid_out(text)
    assert laid_out(laid) == laid
    assert block_of(laid) == block_of(text)
