"""Translation of a file of another tool: its parts become nodes of the syntax tree, which `resolve` gives a meaning.

A reader splits its file, looks up words in its tables and adds statements, each with its location in the file. The
checks of names, terms and rules are those of rule files.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, TypeVar

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.expr import ONE, ZERO, Expr, Name, Number
from fuzzyctl.formats.common.blocks import Arrangement
from fuzzyctl.formats.common.identifiers import as_read
from fuzzyctl.formats.common.report import Findings, meant
from fuzzyctl.formats.fz import NORM_KEYWORDS
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import Activation, Defuzzifier
from fuzzyctl.model.profiles import Profile
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule, RuleBlock
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Fallback, Hold, LinguisticVariable, Term
from fuzzyctl.resolve import resolve
from fuzzyctl.support.files import TOO_LARGE, to_number

Meaning = TypeVar("Meaning")


class Translation(Findings):
    """The statements and the diagnostics of one file.

    Attributes:
        statements: The statements so far.
        left_out: Outputs that are declared, so that rules may name them, and left out of the system.
    """

    def __init__(self, source: SourceText) -> None:
        super().__init__(source)
        self.statements: list[sx.Statement] = []
        self.left_out: set[str] = set()
        self._declared: set[str] = set()

    def number(self, span: Span) -> Number | None:
        """Return a number, which may be infinite; report anything else."""
        try:
            value = to_number(span.text)
        except OverflowError:
            self.error("FZ108", TOO_LARGE, span, help="write 'inf'")
            return None
        except ValueError:
            value = math.nan
        if math.isnan(value):
            self.error("FZ601", f"'{span.text[:40]}' is not a number", span)
            return None
        return Number(value, span=span)

    def weight(self, place: Span, help: str = "") -> Number | None:
        """Return the weight of a rule; report anything but a number from 0 to 1."""
        text = place.text.strip()
        try:
            value = to_number(text)
        except (ValueError, OverflowError):
            value = math.nan
        if 0 <= value <= 1:
            return ONE if value == 1 else Number(value, span=place)
        if math.isnan(value):
            self.error("FZ601", f"the weight is a number, got '{text[:40]}'", place, help=help)
        else:
            help = "a weight is a number between 0 and 1"
            self.error("FZ302", f"the weight {text[:40]} lies outside [0, 1]", place, help=help)
        return None

    def look_up(
        self,
        place: Span,
        table: Mapping[str, Meaning],
        what: str,
        *,
        word: str = "",
        otherwise: str = "",
        code: str = "FZ602",
    ) -> Meaning | None:
        """Return the meaning of a word of the file; report a word that its format does not have.

        Args:
            place: The word.
            table: The words with their meanings.
            what: The noun for the words in messages.
            word: The word without quotes and in small letters, if that differs from the text.
            otherwise: The help if no word of the table is like it.
            code: The code of the error.
        """
        text = word or place.text
        if text in table:
            return table[text]
        facts = (f"there are: {', '.join(table)}",)
        help_text = meant(text, table) or otherwise
        self.error(code, f"there is no {what} '{text[:40]}'", place, facts=facts, help=help_text)
        return None

    def head(
        self, name: str, title: str, span: Span, profile: Profile, knobs: Mapping[str, str] = MappingProxyType({})
    ) -> None:
        """Add the name of the system and the numerics of its tool, with the knobs of the file."""
        options = tuple(sx.Option(sx.Word(n, span), sx.Word(v, span)) for n, v in knobs.items())
        self.statements.append(sx.System(span, sx.Word(name, span), title.replace('"', "'")))
        self.statements.append(sx.Semantics(span, sx.Word("semantics", span), sx.Word(profile.name, span), options))

    def variable(
        self,
        keyword: str,
        name: sx.Word,
        ends: tuple[Expr, Expr],
        terms: Sequence[Term],
        clauses: Sequence[sx.Clause] = (),
        *,
        label: str = "",
        unread: Sequence[Span | sx.Word] = (),
        place: Span | None = None,
    ) -> None:
        """Add an input or an output.

        Args:
            keyword: `input` or `output`.
            name: Its name.
            ends: Its range.
            terms: Its terms.
            clauses: Its other clauses.
            label: Its label.
            unread: Names of terms that have been reported, and that rules may name all the same.
            place: Its place, if that is not the place of its name.
        """
        lines = [] if name.text in self._declared else [term_line(t) for t in terms]  # a second one has no terms
        self._declared.add(name.text)
        words = [u if isinstance(u, sx.Word) else sx.Word(u.text, u) for u in unread]
        lines += [sx.TermLine(w.span, w, sx.Word("constant", w.span), (_argument(ZERO, w.span),)) for w in words]
        word, label = sx.Word(keyword, name.span), label.replace('"', "'")
        self.statements.append(sx.Variable(place or name.span, word, name, label, *ends, tuple(clauses), tuple(lines)))

    def rules(self, arrangement: Arrangement, idle: Sequence[sx.Rule] = ()) -> None:
        """Add the rules of a file in their blocks; `idle` are the rules of outputs left out."""
        self.statements += [*arrangement.loose, *idle]
        for name, block, method in arrangement.blocks:
            place = block.span or Span(self.source, 0, 0)
            self.statements.append(sx.Rules(place, sx.Word(name, place), settings(method, place)))
            self.statements += block.rules

    def system(self) -> FuzzySystem | None:
        """Return the system of the statements; None after a mistake."""
        tree = sx.SyntaxTree(self.source, tuple(self.statements))
        system, diagnostics = resolve(tree, (), self.failed, foreign=True)
        self.diagnostics += map(_without_fz, diagnostics)
        if self.failed or system is None:
            return None
        system = without_outputs(system, self.left_out)
        named, _ = as_read(system)
        changed = [(old, new) for old, new in zip(_parts(system), _parts(named), strict=True) if old.name != new.name]
        if changed:
            (old, new), *others = changed
            message = f"'{old.name[:60]}' is not a name here; it is called '{new.name[:60]}'"
            facts = tuple(f"'{o.name[:60]}' is called '{n.name[:60]}'" for o, n in others[:20])
            self.diagnostics.append(Diagnostic("FZ604", message, old.span, "hint", facts=facts, file=self.file))
        return named


def _parts(system: FuzzySystem) -> list[FuzzySystem | LinguisticVariable | Term]:
    """Return the parts of a system that have names, from the system itself to the terms."""
    parts: list[FuzzySystem | LinguisticVariable | Term] = [system]
    for variable in (*system.inputs, *system.outputs):
        parts += [variable, *variable.terms]
    return parts


def _without_fz(diagnostic: Diagnostic) -> Diagnostic:
    """Return a diagnostic without helps that only suit rule files."""
    suggests = diagnostic.help.startswith("did you mean") and "the form is" not in diagnostic.help
    return replace(diagnostic, help=diagnostic.help if suggests else "", fix=None)


def _argument(value: Expr, span: Span, keyword: str = "") -> sx.Argument:
    return sx.Argument(value, sx.Word(keyword, span) if keyword else None, span)


def term_line(term: Term) -> sx.TermLine:
    """Return the line of a term; a formula of the place itself is a function there."""
    membership = term.membership
    place = membership.span or term.span
    assert place is not None
    assert term.span is not None
    arguments = [_argument(a, place) for a in membership.arguments]
    if membership.height != ONE:
        arguments.append(_argument(membership.height, place, "height"))
    kind = "function" if membership.kind == "formula" else membership.kind
    return sx.TermLine(term.span, sx.Word(term.name, term.span), sx.Word(kind, place), tuple(arguments))


def fallback(value: Expr | Fallback | Hold, span: Span) -> sx.FallbackClause:
    """Return the clause for the value of an output if no rule fires."""
    if isinstance(value, Hold):
        start = Name(value.start, span) if isinstance(value.start, str) else value.start
        return sx.FallbackClause(sx.Held(start, span) if start is not None else sx.Word("hold", span), span)
    return sx.FallbackClause(sx.Word(value, span) if isinstance(value, str) else value, span)


def settings(fields: Mapping[str, Any], span: Span) -> tuple[sx.Setting | sx.Activation, ...]:
    """Return the settings of a system or of a rule block by the fields of its method; None has no setting."""
    values = ((NORM_KEYWORDS.get(name, name), value) for name, value in fields.items() if value is not None)
    return tuple(activation(v, span) if isinstance(v, Activation) else setting(word, v, span) for word, v in values)


def setting(keyword: str, value: str | Defuzzifier, span: Span) -> sx.Setting:
    """Return a norm, or a defuzzifier with its number of samples; its other fields are those of the profile."""
    options: tuple[sx.Option, ...] = ()
    if isinstance(value, Defuzzifier):
        if value.resolution is not None:
            options = (sx.Option(sx.Word("resolution", span), sx.Word(str(value.resolution), span)),)
        value = value.kind
    return sx.Setting(span, sx.Word(keyword, span), sx.Word(value, span), options)


def activation(method: Activation, span: Span) -> sx.Activation:
    """Return an activation method."""
    span = method.span or span
    options: list[sx.ActivationOption] = []
    if method.count is not None:
        options.append(sx.ActivationOption(sx.Word("count", span), Number(float(method.count))))
    if method.threshold is not None:
        options.append(sx.ActivationOption(sx.Word(method.comparison or "threshold", span), method.threshold))
    return sx.Activation(span, sx.Word("activation", span), sx.Word(method.kind, span), tuple(options))


def without_outputs(system: FuzzySystem, names: set[str]) -> FuzzySystem:
    """Return a system without some outputs; conditions on one of them are false, as those on a disabled input are."""
    if not names:
        return system
    outputs = tuple(o for o in system.outputs if o.name not in names)
    some = next((v for v in (*system.inputs, *outputs) if v.terms), None)

    def condition(antecedent: Antecedent) -> Antecedent:
        match antecedent:
            case Is(variable=variable) if variable in names and some is not None:
                update: dict[str, Any] = {"variable": some.name, "term": some.terms[0].name, "hedges": ("not", "any")}
            case Not(operand=operand):
                update = {"operand": condition(operand)}
            case And(operands=operands) | Or(operands=operands):
                update = {"operands": tuple(map(condition, operands))}
            case _:
                return antecedent
        return antecedent.model_copy(update=update)

    def remaining(rules: Sequence[Any]) -> Iterator[Rule]:
        for rule in rules:
            consequents = tuple(c for c in rule.consequents if c.output not in names)
            if consequents:
                update = {"consequents": consequents, "antecedent": condition(rule.antecedent)}
                yield rule.model_copy(update=update)

    blocks: list[Rule | RuleBlock] = []
    for block in system.blocks:
        if isinstance(block, RuleBlock):
            blocks.append(block.model_copy(update={"rules": tuple(remaining(block.rules))}))
        else:
            blocks += remaining([block])
    return system.model_copy(update={"blocks": tuple(blocks), "outputs": outputs})
