"""The page of semantics profiles says what the profiles are: its tables are written from them."""

import dataclasses
import os
import re
from pathlib import Path

import pytest

from fuzzyctl import Defuzzifier, Method, Semantics
from fuzzyctl.model.profiles import OVER_SETS, PROFILES
from fuzzyctl.testing import check_text

KNOBS = tuple(field.name for field in dataclasses.fields(Semantics) if field.name not in ("profile", "span"))
PAGE = Path(__file__).parents[2] / "docs" / "reference" / "semantics-profiles.md"


def row(*cells):
    return f"| {' | '.join(cells)} |"


def profiles():
    lines = [row("profile", "tool", "how its numbers are known"), row("---", "---", "---")]
    return [*lines, *(row(f"`{p.name}`", p.tool, p.evidence) for p in PROFILES.values())]


def knobs():
    usual = Semantics()
    lines = [row("profile", "knobs that differ from `exact`"), row("---", "---")]
    for p in PROFILES.values():
        other = [f"`{k}={p.semantics.text(k)}`" for k in KNOBS if getattr(p.semantics, k) != getattr(usual, k)]
        lines.append(row(f"`{p.name}`", ", ".join(other) or "none"))
    return lines


def defuzzifiers():
    lines = [row("profile", *(f"`{kind}`" for kind in OVER_SETS)), row(*(["---"] * (len(OVER_SETS) + 1)))]
    for p in PROFILES.values():
        cells = []
        for kind in OVER_SETS:
            own, usual = p.defuzzifier(kind), Defuzzifier(kind=kind)
            said = [f"{own.resolution} {own.grid}" if own.resolution is not None else "exact"]
            said += [own.rule] if own.rule is not None else []
            said += [f"{n} {getattr(own, n)}" for n in ("tolerance", "by") if getattr(own, n) != getattr(usual, n)]
            cells.append(", ".join(said) if p.evaluates is None or kind in p.evaluates else "not supported")
        lines.append(row(f"`{p.name}`", *cells))
    return lines


def rest():
    usual = Method()
    lines = [row("profile", "if no rule fires", "other norms", "sums over rules"), row("---", "---", "---", "---")]
    for p in PROFILES.values():
        value = getattr(p.otherwise, "value", p.otherwise)  # a word, or a number of an expression
        word = f"hold({value.start})" if hasattr(value, "start") else value if isinstance(value, str) else f"{value}"
        otherwise = f"`else {word.removesuffix('.0')}`" if value is not None else "a rule must fire everywhere"
        fields = ("conjunction", "disjunction", "implication", "aggregation")
        norms = [f"`{f} {getattr(p.method, f)}`" for f in fields if getattr(p.method, f) != getattr(usual, f)]
        sums = [f"`{k}`" for k in p.evaluates or () if k not in OVER_SETS] if p.evaluates is not None else ["all"]
        lines.append(row(f"`{p.name}`", otherwise, ", ".join(norms) or "none", ", ".join(sums) or "none"))
    return lines


def not_imitated():
    lines = []
    for p in PROFILES.values():
        if p.not_imitated:
            lines += [f"- `{p.name}`:", *(f"  - {sentence}." for sentence in p.not_imitated)]
    return lines


@pytest.mark.parametrize("part", [profiles, knobs, defuzzifiers, rest, not_imitated])
def test_the_page_says_what_the_profiles_are(part):
    text = PAGE.read_text(encoding="utf-8")
    begin, end = f"<!-- {part.__name__} -->\n", "<!-- end -->"
    before, found, after = re.split(f"({re.escape(begin)}.*?{end})", text, maxsplit=1, flags=re.DOTALL)
    wanted = begin + "\n".join(part()) + "\n" + end
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        PAGE.write_text(before + wanted + after, encoding="utf-8")
        return
    assert found == wanted


def test_each_knob_and_each_of_its_values_is_explained():
    explained = PAGE.read_text(encoding="utf-8").split("## Knobs")[1].split("\n## ")[0]
    for knob in KNOBS:
        found = check_text(f"system s\nsemantics exact({knob}=zzz)\n")[1]
        facts = [fact for d in found if d.code == "FZ213" for fact in d.facts if fact.startswith("one of: ")]
        entry = re.search(rf"^- `{knob}`(.*?)(?=^- `|\Z)", explained, flags=re.DOTALL | re.MULTILINE)
        assert entry is not None, knob
        choices = facts[0].removeprefix("one of: ").split(", ") if facts else []
        assert all(f"`{choice}`" in entry[1] for choice in choices), (knob, choices)
