"""Guarantees that name lets: which are known, and how large they may become."""

import pytest

from fuzzyctl import loads
from fuzzyctl.analysis.check import check_source
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import names_in
from fuzzyctl.model.inlined_lets import inlined

HEAD = "system s\ndefuzzifier center_average\ninput e in [-1, 1]\n  terms N P\noutput u in [-1, 1]\n  terms N P\n"
HEAD += "table u = e\n   N P\n | N P\n"


def found_in(lines):
    with pytest.raises(DiagnosticError) as error:
        loads(HEAD + lines)
    return [(d.code, d.span.text) for d in error.value.diagnostics if d.severity == "error"]


def test_what_they_are_made_of_is_written_out():
    system = loads(HEAD + "let b = 2 * a\nlet a = e + 1\nlet c = b + a\nrequire u <= c when b >= 0\n")
    (guarantee,) = system.guarantees
    found = inlined(system, guarantee)
    assert {n.name for part in (found.claim, found.when) for n in names_in(part)} == {"u", "e"}
    assert inlined(loads(HEAD + "let a = e\nrequire u <= e\n"), guarantee) == guarantee


@pytest.mark.parametrize("step", ["a{0} + a{0}", "a{0} + 1"], ids=["twice as large", "deeper"])
def test_guarantees_that_become_too_large_are_refused_at_once(step):
    lets = "let a0 = e + 1\n" + "".join(f"let a{k + 1} = {step.format(k)}\n" for k in range(300))
    assert found_in(lets + "require u <= a300\nrequire u <= 9 when a300 > 0\nrequire u <= a2 + 9\n") == [
        ("FZ112", "require u <= a300"),
        ("FZ112", "require u <= 9 when a300 > 0"),
    ]


def test_circles_are_reported_once():
    assert [code for code, _ in found_in("let a = b + e\nlet b = a + 1\nrequire u <= a\n")] == ["FZ217"]


def test_a_let_that_only_a_guarantee_names_is_used_and_has_its_unit():
    text = HEAD.replace("[-1, 1]\n  terms", '[-1, 1] unit "m"\n  terms', 1)
    lets = 'let way unit "m" = 2 * e\nlet time unit "s" = 3 * e\n'
    _, found = check_source(SourceText("s.fz", text + lets + "require u <= 9 when way >= e or time > 0\n"))
    assert not found
    with pytest.raises(DiagnosticError) as error:
        loads(text + lets + "require u <= 9 when way >= time\n")
    assert [d.code for d in error.value.diagnostics] == ["FZ312"]
