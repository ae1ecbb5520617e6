"""Controls of the comparison with the oracles: each breaks a translation once, and must be found.

    python -m tests.oracles.controls

Works on a copy of the project in a temporary folder; prints each control with the first file that finds it. Exit code 1
for one that is not found.
"""

import random
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
FORMATS = "fuzzyctl/formats"

#: Format, module, what is replaced, by what.
CONTROLS = [
    ("fll", "fll/reader.py", "if variable.locked and variable.is_bounded", "if variable.is_bounded"),
    ("fll", "fll/reader.py", "is_free = not variable.locked or", "is_free = variable.locked or"),
    ("fll", "fll/reader.py", 'self._flag(block, True, "enabled")', "True"),
    ("fll", "fll/reader.py", "return Hold(start=start) if", "return start if"),
    ("fll", "fll/reader.py", "6 if version is None and old", "7 if version is None and old"),
    ("fll", "fll/reader.py", "keep=any(b.name for _, b in blocks)", "keep=False"),
    ("fll", "fll/reader.py", "if implication is None and _implied(block)", "if False and _implied(block)"),
    ("fll", "fll/methods.py", "threshold=last if most == 2 else None", "threshold=Number(0.0) if most == 2 else None"),
    ("fll", "fll/methods.py", 'type or "Automatic"', '"Automatic"'),
    ("fll", "fll/terms.py", "height = values[count] if", "height = values[-2] if"),
    ("fll", "fll/terms.py", "values = (*values, ZERO)", "values = (ZERO, *values)"),
    (
        "fll",
        "fll/rules.py",
        '"or": Operator(1, run=True), "and": Operator(2',
        '"or": Operator(2, run=True), "and": Operator(1',
    ),
    ("fll", "fll/rules.py", "if variable.text in self.disabled:", "if False:"),
    ("fll", "common/translation.py", "if value.resolution is not None:", "if False:"),
    ("fll", "common/blocks.py", "and not any(b.activation.compares for b in blocks)", ""),
    ("fll", "common/ranges.py", "low, high = (low, low + 1.0) if", "low, high = (low, low + 2.0) if"),
    ("fis", "fis/reader.py", "if version is not None and version < 6:", "if False:"),
    ("fis", "fis/reader.py", "None if is_common else defuzzifier", "None"),
    ("fis", "fis/rules.py", "value.is_signed() and value != 0", "False"),
    ("fis", "fis/rules.py", "self._power(10 * fraction, span)", "self._power(9 * fraction, span)"),
    ("fis", "fis/rules.py", 'hedges = ("any",) if rule.connective == "and"', 'hedges = ("any",) if True'),
    ("fis", "fis/shapes.py", '"trapmf": TERM_WORDS["Trapezoid"],', ""),
    ("fis", "fis/dialects.py", "if name is None and dialect ==", "if name is None and None =="),
    ("fcl", "fcl/reader.py", 'if self._dialect.name == "jfuzzylogic":  # from', "if False:  # from"),
    ("fcl", "fcl/reader.py", '"places"} if is_merged', '"places"} if False'),
    ("fcl", "fcl/variables.py", 'clamped=block.has("LOCK", "RANGE")', "clamped=False"),
    ("fcl", "fcl/scope.py", 'if text == "NSUM" and', "if False and"),
    ("fcl", "fcl/reader.py", "return (norm, pairs[norm]) if", "return (norm, 'max') if"),
    ("fcl", "fcl/variables.py", "is_needed = variable.clamped or", "is_needed ="),
    ("fcl", "fcl/variables.py", "kinds if keyword ==", "kinds if keyword !="),
    ("fcl", "fcl/parser.py", "return sx.Negation(self.span(token), operand)", "return operand"),
    ("fcl", "fcl/words.py", '"COA BIS"', '"BIS"'),
    ("fcl", "fcl/words.py", '"nilpotent_minimum": "NIPMIN NMIN"', '"nilpotent_minimum": "NMIN NMIN"'),
    ("fis", "fll/terms.py", 'if word.kind == "constant" and place.is_input and self.fuzzylite', "if False"),
    (
        "fml",
        "fml/shapes.py",
        '"rightLinearShape": _linear(falls=False)',
        '"rightLinearShape": _linear(falls=True)',
    ),
    ("fml", "fml/shapes.py", "if p[0] >= p[1] else (", "if p[0] > 2 * p[1] else ("),
    ("fml", "fml/shapes.py", '"pishape": Shape("pi_shape", 2, _pi_of_width),', ""),
    ("fml", "fml/shapes.py", "(min(ends[0], center), center) if", "(-math.inf, center) if"),
    ("fml", "fml/reader.py", "(*values[1:], values[0])", "values"),
    (
        "fml",
        "fml/reader.py",
        "limits = (-math.inf, math.inf) if is_tsukamoto else",
        "limits = (0.0, 1.0) if is_tsukamoto else",
    ),
    ("fml", "fml/reader.py", "kind in _AVERAGED for t", "kind in () for t"),
    ("fml", "fml/reader.py", '"sum" if kind in OVER_RULES else aggregation', "aggregation"),
    ("fml", "fml/reader.py", 'if "extremely" in rules.modifiers else', "if False else"),
    ("fml", "fml/reader.py", "variable.negated.add(name.text)", "pass"),
    ("fml", "fml/rules.py", '(sx.Word("not", place),) if _is_set', "() if _is_set"),
    ("fml", "fml/rules.py", 'name = "" if name == "rules1"', 'name = "" if name == "rules"'),
    ("fml", "fml/rules.py", "sx.Negation(span, antecedent)", "antecedent"),
    ("fml", "fml/rules.py", 'above=word == "above"', 'above=word != "above"'),
    (
        "fml",
        "fml/rules.py",
        "return replace(truth, hedges=(hedge, *truth.hedges))",
        "return replace(truth, hedges=(*truth.hedges, hedge))",
    ),
    ("fml", "fml/rules.py", "if norm != first:", "if False:"),
    ("fml", "fml/rules.py", '(rule, "operator"), ', ""),
    ("fml", "fml/rules.py", 'owner.keyword == "input"', "False"),
]


def first_difference(format):
    """Return the number of the first drawn file, whole or broken, that is read otherwise than by the oracle."""
    from tests.fuzzyctl.formats.test_oracles import DRAWN, broken
    from tests.oracles.comparing import differences

    for seed in range(1500):
        for text in (DRAWN[format](random.Random(seed)), broken(format, seed)):
            try:
                found = differences(format, text)
            except Exception as error:  # noqa: BLE001
                found = [repr(error)]
            if found:
                return f"file {seed}: {found[0][:60]}"
    return ""


def main():
    """Try all controls."""
    if len(sys.argv) == 3 and sys.argv[1] == "--in-copy":
        print(first_difference(sys.argv[2]))
        return
    missed = 0
    with tempfile.TemporaryDirectory() as folder:
        for part in ("fuzzyctl", "tests"):
            shutil.copytree(ROOT / part, Path(folder) / part, ignore=shutil.ignore_patterns("__pycache__", "vectors"))
        for format, module, old, new in CONTROLS:
            path = Path(folder) / FORMATS / module
            text = path.read_text(encoding="utf-8")
            assert old in text, (module, old)
            path.write_text(text.replace(old, new), encoding="utf-8")
            command = [sys.executable, "-B", "-m", "tests.oracles.controls", "--in-copy", format]
            found = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False).stdout.strip()
            path.write_text(text, encoding="utf-8")
            missed += not found
            print(f"{module}: {new}: {found or 'NOT FOUND'}", flush=True)
    sys.exit(bool(missed))


if __name__ == "__main__":
    main()
