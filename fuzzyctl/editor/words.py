"""Words of the language with their form and meaning, for completion, hover and signatures."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.formulas.hedges import HEDGES
from fuzzyctl.lang.mistakes import BLOCK_FORMS, FORMS, LET_FORM
from fuzzyctl.lang.syntax import BLOCKS, NAME, STATEMENT_KEYWORDS
from fuzzyctl.model.loop import MEASURES, SIGNALS
from fuzzyctl.model.plant import PLANTS
from fuzzyctl.model.stateful_operators import OPERATORS

#: Statements with placeholders, where their form is not one.
_SNIPPETS: Final = {
    "system": 'system ${1:name} "${2:title}"\n',
    "source": 'source "${1:where it comes from}"',
    "use": 'use "${1:file}.fz"',
    "param": "param ${1:name} = ${2:1}",
    "hedge": "hedge ${1:name}(x) = ${2:x^2}",
    "function": "function ${1:name}(${2:x}) = ${3:x}",
    "controller": 'controller ${1:name} "${2:title}"\ninput ${3:e}\noutput ${4:u} = ${5:e}\nevery ${6:10 ms}',
    "plant": "plant ${1:name} = tf(num=[${2:1}], den=[${3:1, 1}])",
    "loop": "loop ${1:name}\nblock ${2:law} = ${2:law}(${3})\nrun ${4:10 s}",
    "if": "if ${1:input} is ${2:term} then ${3:output} is ${4:term}",
    "otherwise": "otherwise ${1:output} is ${2:term}",
    "require": "require ${1:output} >= ${2:0}",
    "allow": 'allow ${1:FZ208} "${2:reason}"',
    "deny": 'deny ${1:FZ208} "${2:reason}"',
    "every": "every ${1:10 ms}",
    "run": "run ${1:10 s} step ${2:10 ms}",
    "for": "for ${1:block.state} in [${2:0}, ${3:1}]",
    "disturbance": "disturbance ${1:name} in [${2:0}, ${3:1}] = ${4:0}",
    "state": "state ${1:name} = ${2:0}",
    "next": "next ${1:state} = ${2:state}",
    "der": "der ${1:state} = ${2:0}",
    "let": "let ${1:name} = ${2:expression}",
    "block": "block ${1:name} = ${2:controller}(${3:input})",
    "measure": "measure ${1:name} = ${2:iae}(${3:signal}, ${4:reference})",
    "table": "table ${1:output} = ${2:rows} x ${3:columns}\n       ${4:low  high}\n  ${5:low} |  ${6:.  .}",
}
#: The meanings of statements, which docs/reference describes at more length.
_MEANINGS: Final = {
    "fz": "the version of the language; before everything else",
    "system": "begins a fuzzy system, with its title",
    "source": "where the numbers come from; for readers",
    "use": "brings in what another rule file in this folder or below declares",
    "semantics": "computes as another tool does; later statements prevail",
    "and": "the conjunction of antecedents; min by default",
    "or": "the disjunction of antecedents; max by default",
    "implication": "what an activation makes of the consequent set: min cuts it off, product scales it",
    "aggregation": "how the implied sets of all rules are joined; max by default",
    "activation": "which rules act, by their firing strengths; general by default: all",
    "defuzzifier": "how the fuzzy set of an output becomes its value; centroid by default",
    "param": "a named constant, which --set NAME=VALUE changes",
    "hedge": "a named change of degrees, written before a term",
    "function": "a named expression over its parameters and params",
    "controller": "begins a controller: equations that are computed at each step",
    "plant": "begins a plant: differential equations, or one line for a common form",
    "loop": "begins a closed loop: controllers and plants, and how they are connected",
    "input": "an input; label and unit may be left out, in equations the range, too",
    "output": "an output; in a system, else says what it is where no rule fires",
    "terms": "a partition: triangles by their peaks, evenly spaced ones without, or singletons with =",
    "rules": "begins a block of tables and rules with norms of its own",
    "with": "joins a condition to each rule of the table below, by and",
    "table": "rules as a table: a cell has the term of the output for its row and column; . means no rule",
    "if": "a rule: how true the antecedent is, so far it acts on the outputs",
    "otherwise": "the rule that fires as far as no other rule for the output does",
    "require": "a guarantee: proved for all inputs; of a loop, checked on a run",
    "allow": "drops warnings with these codes in this file; the reason is for readers",
    "deny": "makes warnings with these codes errors in this file",
    "let": "a name for a value",
    "state": "a number that is kept, with its start; next or der says how it goes on",
    "next": "the value of a state at the next step",
    "der": "the derivative of a state by time",
    "every": "the sample time; left out, each step takes dt",
    "block": "a controller or a plant inside of this block; its outputs are NAME.OUTPUT",
    "measure": "a number that a run is judged by",
    "run": "how long a run lasts, and the time between two samples of its record",
    "for": "a start of a state, or a param, that differs between the members of the family",
    "disturbance": "a signal that may be anything in its range; a plain run takes the value",
}
#: Those of systems that blocks of equations write in another form.
_VARIABLES: Final = {
    "input": "input ${1:name} in [${2:0}, ${3:1}]\n  terms ${4:low high}",
    "output": "output ${1:name} in [${2:0}, ${3:1}]\n  terms ${4:low=0 high=1}",
}
_SIGNALS: Final = {"input": "input ${1:name}", "output": "output ${1:name} = ${2:expression}"}


@dataclass(frozen=True)
class LanguageWord:
    """A word of the language.

    Args:
        name: The word.
        kind: "keyword", "membership function", "function", "operator", "signal", "measure", "plant" or "hedge".
        form: How it is written.
        what: Its meaning, one sentence; may be empty.
        block: The kind of its block: "controller", "plant", "loop", or the empty text for a system.
    """

    name: str
    kind: str
    form: str
    what: str = ""
    block: str = ""


def memberships() -> Iterator[LanguageWord]:
    """Yield the membership functions."""
    for name, formula in MEMBERSHIP.items():
        more = ", ..." if formula.variadic else ""
        form = f"{name}({', '.join(formula.parameters)}{more})"
        yield LanguageWord(name, "membership function", form, formula.summary)


def functions(block: str) -> Iterator[LanguageWord]:
    """Yield the functions that an expression of a system, controller, plant or loop may call."""
    for name, (low, high) in ex.FUNCTIONS.items():
        names = ", ".join("xyz"[:low]) + (", ..." if high is None else "")
        yield LanguageWord(name, "function", f"{name}({names})")
    if block:
        yield LanguageWord("clamp", "function", "clamp(x, low, high)", "x, kept from low to high")
        yield LanguageWord("where", "function", "where(condition, x, y)", "x where the condition holds, else y")
    if block == "controller":
        for name, operator in OPERATORS.items():
            yield LanguageWord(name, "operator", operator.form, operator.what)
    if block == "loop":
        for name, form in SIGNALS.items():
            yield LanguageWord(name, "signal", form.form, form.what)


def measures() -> Iterator[LanguageWord]:
    """Yield the measures of loops."""
    for name, form in MEASURES.items():
        yield LanguageWord(name, "measure", form.form, form.what)


def plants() -> Iterator[LanguageWord]:
    """Yield the plants of one line."""
    for name, form in PLANTS.items():
        yield LanguageWord(name, "plant", form.form, form.what)


def keywords(block: str) -> Iterator[LanguageWord]:
    """Yield the words that begin a statement of a block, the empty one being a system."""
    forms = BLOCK_FORMS if block else FORMS
    for name in BLOCKS[block] if block else (*STATEMENT_KEYWORDS, "let"):
        form = LET_FORM if name == "let" and not block else forms.get(name, FORMS.get(name, name))
        yield LanguageWord(name, "keyword", form, _MEANINGS[name], block)


def snippet(word: LanguageWord) -> str:
    """Return a word with placeholders for the words after it; empty without such words."""
    if word.kind == "keyword":
        variables = _SIGNALS if word.block else _VARIABLES
        return variables.get(word.name) or _SNIPPETS.get(word.name, "")
    call = re.fullmatch(rf"({NAME})\(((?:{NAME}(?:, )?)+)\)", word.form)
    if call is None:
        return ""
    names = enumerate(call[2].split(", "), 1)
    return f"{call[1]}({', '.join(f'${{{k}:{name}}}' for k, name in names)})"


def hedges() -> Iterator[LanguageWord]:
    """Yield the hedges that need no declaration."""
    for name, hedge in HEDGES.items():
        yield LanguageWord(name, "hedge", f"VARIABLE is {name} TERM", f"of a degree x: {hedge.summary}")


@cache
def called(block: str) -> dict[str, LanguageWord]:
    """Return all that may stand before an opening parenthesis in a block, by name."""
    words = [*memberships(), *plants(), *(measures() if block == "loop" else ()), *functions(block)]
    return {w.name: w for w in words}
