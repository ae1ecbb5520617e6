"""Writer of `.fll` files."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import Expr, Name, Number, number_text, replace_names
from fuzzyctl.formats.common.blocks import BlockPart, block_parts
from fuzzyctl.formats.common.identifiers import with_identifiers
from fuzzyctl.formats.common.losses import (
    cannot,
    defuzzifier_of,
    impossible,
    losses_of,
    missing_words,
    other_knobs,
    value_unfired,
    with_named_consequents,
    with_numbers_averaged,
)
from fuzzyctl.formats.common.words import DUAL_OF, first_words, up_to_any, words_by_kind
from fuzzyctl.formats.fll.formulas import FUNCTION_WORDS, formula
from fuzzyctl.formats.fll.methods import (
    ACTIVATION_WORDS,
    DEFUZZIFIERS,
    HEDGE_WORDS,
    RULE_WORDS,
    S_NORMS,
    T_NORMS,
    as_inverted_there,
)
from fuzzyctl.formats.fll.reader import read
from fuzzyctl.formats.fll.shapes import TERMS, as_written
from fuzzyctl.formats.registry import Loss
from fuzzyctl.model.method import Activation
from fuzzyctl.model.profiles import Profile, profile
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, LinguisticVariable, Membership, Output, Term

_CONJUNCTIONS: Final = first_words(T_NORMS)
_DISJUNCTIONS: Final = first_words(S_NORMS)
_ACTIVATIONS: Final = first_words(ACTIVATION_WORDS)

#: Terms by kind of the model; a rectangle that never ends is fuzzylite's Binary.
_NAMES: Final[dict[str, str]] = {
    **{kind: name for kind, (name, _) in words_by_kind(TERMS).items()},
    "rectangle": "Rectangle",
    "singleton": "Constant",
}


def write(system: FuzzySystem) -> tuple[str, list[Loss]]:
    """Return a system as a text, with its losses.

    Raises:
        DiagnosticError: With all reasons, if no `.fll` file can hold the system.
    """
    named, losses = with_named_consequents(system)
    named, of_names = with_identifiers(named, RULE_WORDS, FUNCTION_WORDS)
    named, of_averages = with_numbers_averaged(named)
    return _Writer(named, [*losses, *of_names, *of_averages]).write()


class _Writer:
    def __init__(self, system: FuzzySystem, losses: list[Loss]) -> None:
        self.system, self.reasons = as_inverted_there(system)
        self.losses = losses
        name = system.method.semantics.profile
        self.profile: Profile = profile(name) if "fuzzylite" in name else self._nearest()
        self.python = self.profile.name == "pyfuzzylite"

    def _nearest(self) -> Profile:
        """Return the tool under which fewer numbers change; the file names pyfuzzylite if that is the one."""
        tools = [profile(name) for name in ("fuzzylite", "pyfuzzylite")]
        losses, fewer = (list(other_knobs(self.system, tool.semantics)) for tool in tools)
        if len(losses) <= len(fewer):
            return tools[0]
        why = "the file is for pyfuzzylite, and says so; fuzzylite itself computes other numbers"
        self.losses += (Loss(loss.where, loss.what, why, exact=True) for loss in set(losses) - set(fewer))
        return tools[1]

    def write(self) -> tuple[str, list[Loss]]:
        """Return the text and the losses."""
        system = self.system
        self.reasons.extend(impossible(system))
        self.reasons.extend(missing_words(system, _NAMES, {*_CONJUNCTIONS, *_DISJUNCTIONS, "sum"}))
        comments = [] if self.profile.name == "fuzzylite" else [f"# numerics of {self.profile.name}"]
        lines = [*comments, f"Engine: {system.name}"]
        if system.title:
            where = f"system '{system.name}'"
            lines.append(f"  description: {self._plain(system.title, where, 'the title')}")
        for variable in (*system.inputs, *system.outputs):
            lines.extend(self._variable(variable))
        parts = block_parts(system)
        for part in parts:
            lines.extend(self._rule_block(part, split=sum(p.block == part.block for p in parts) > 1))
        if self.reasons:
            raise cannot(system, ".fll", self.reasons)
        text = "\n".join(lines) + "\n"
        back, _ = read(SourceText("written.fll", text))
        order = [r for part in parts for r, _ in part.rules]
        return text, sorted({*self.losses, *losses_of(system, back, order, nan_for_error=True)})

    # --- variables -----------------------------------------------------------------------------------------------

    def _variable(self, variable: LinguisticVariable) -> Iterator[str]:
        is_output = isinstance(variable, Output)
        yield f"{'OutputVariable' if is_output else 'InputVariable'}: {variable.name}"
        if variable.label:
            where = f"{'output' if is_output else 'input'} '{variable.name}'"
            yield f"  description: {self._plain(variable.label, where, 'the label')}"
        low, high = (self.system.number(end) for end in (variable.lower, variable.upper))
        yield "  enabled: true"
        yield f"  range: {number_text(low)} {number_text(high)}"
        locked = variable.clamped if isinstance(variable, Output) else not getattr(variable, "extrapolate", False)
        yield f"  lock-range: {str(locked).lower()}"
        if isinstance(variable, Output):
            yield from self._output(variable)
        for term in variable.terms:
            yield f"  term: {term.name} {self._term(variable, term)}"

    def _output(self, output: Output) -> Iterator[str]:
        defuzzifier = defuzzifier_of(self.system, output)
        aggregation = output.aggregation or self.system.method.aggregation
        # Separate rules are added up; fuzzylite would join those of one term.
        separate = self.system.method.semantics.merge == "rules" != self.profile.semantics.merge
        plain_sum = defuzzifier.over_rules and (aggregation == "sum" or separate)
        word = "none" if plain_sum else _DISJUNCTIONS.get(aggregation)
        if word is None:
            self.reasons.append(f"output '{output.name}': there is no aggregation '{aggregation}'")
        yield f"  aggregation: {word}"
        word = DEFUZZIFIERS[defuzzifier.kind]
        if not defuzzifier.over_rules:  # without a number the versions of fuzzylite differ
            word += f" {defuzzifier.resolution or self.profile.defuzzifier(defuzzifier.kind).resolution}"
        yield f"  defuzzifier: {word}"
        start = value_unfired(self.system, output)
        yield f"  default: {number_text(start) if start is not None else 'nan'}"
        yield f"  lock-previous: {str(isinstance(output.otherwise, Hold)).lower()}"

    def _term(self, variable: LinguisticVariable, term: Term) -> str:
        membership = term.membership
        kind, where = membership.kind, f"term '{term.name}' of '{variable.name}'"
        if kind in ("function", "formula"):
            text = formula(self._with_x(variable, membership, where), {}, python=self.python)
            if text is None:
                self.reasons.append(f"{where} is a formula with a function that fuzzylite does not have")
            return f"Function {text}"
        parameters = [self.system.number(a) for a in membership.arguments]
        if not isinstance(variable, Output) and kind in ("singleton", "constant"):
            # A Constant has its value as its degree everywhere; a triangle without sides is 1 at one place.
            kind, parameters = "triangle", parameters * 3
        name, values = _NAMES.get(kind, kind), [*as_written(kind, parameters, python=self.python)]
        if kind == "rectangle" and any(map(math.isinf, values)):
            left, right = values
            name, values = "Binary", ([left, math.inf] if math.isfinite(left) else [right, -math.inf])
        height = self.system.number(membership.height)
        return " ".join([name, *map(number_text, values if height == 1 else [*values, height])])

    def _with_x(self, variable: LinguisticVariable, membership: Membership, where: str) -> Expr:
        """Return a formula of numbers and variables, with `x` for the variable itself if it uses its place.

        fuzzylite has no other name for that place of an output; version 6 neither for that of an input.
        """
        # Params first, all at once: one may be called `x`.
        expr = replace_names(membership.arguments[0], {n: Number(v) for n, v in self.system.values.items()})
        is_taken = any(v.name == "x" for v in (*self.system.inputs, *self.system.outputs))
        if membership.kind == "formula" and is_taken:
            self.reasons.append(f"{where} is a formula of the output, and a variable is called 'x'")
        if is_taken or (isinstance(variable, Output) and membership.kind == "function"):
            return expr
        return replace_names(expr, {variable.name: Name("x")})

    # --- rules ---------------------------------------------------------------------------------------------------

    def _rule_block(self, part: BlockPart, *, split: bool) -> Iterator[str]:
        """Yield a rule block; `split` for one of several that a block of the system becomes."""
        method = part.method
        if split and method.activation.compares:
            kind = method.activation.kind
            self.reasons.append(f"activation '{kind}' compares rules of outputs with several implications")
        name = self.system.rule_blocks[part.block].name if part.block >= 0 else ""
        yield f"RuleBlock: {name}{f'_{part.number}' if name and part.number > 1 else ''}".rstrip()
        yield "  enabled: true"
        yield f"  conjunction: {_CONJUNCTIONS.get(method.conjunction)}"
        yield f"  disjunction: {_DISJUNCTIONS.get(method.disjunction)}"
        yield f"  implication: {_CONJUNCTIONS.get(part.implication)}"
        yield f"  activation: {self._activation(method.activation)}"
        dual = DUAL_OF.get(method.conjunction) == method.disjunction
        for r, rule in part.rules:
            whole = self.system.rules[r].consequents
            if len(rule.consequents) < len(whole) and any(c.hedges for c in whole):
                self.reasons.append(f"rule {r + 1} has hedges in consequents of outputs with several implications")
            yield f"  rule: {self._rule(rule, f'rule {r + 1}', dual=dual)}"

    def _activation(self, method: Activation) -> str:
        threshold = None if method.threshold is None else number_text(self.system.number(method.threshold))
        parts = (_ACTIVATIONS[method.kind], method.count, method.comparison, threshold)
        return " ".join(str(part) for part in parts if part is not None)

    def _rule(self, rule: Rule, where: str, *, dual: bool) -> str:
        antecedent = self._antecedent(rule.antecedent, where, dual=dual, negated=False, inside="or")
        consequents = " and ".join(
            f"{c.output} is {' '.join([*self._hedges(c.hedges, where), str(c.term)])}" for c in rule.consequents
        )
        weight = self.system.number(rule.weight)
        return f"if {antecedent} then {consequents}{f' with {number_text(weight)}' if weight != 1 else ''}"

    def _antecedent(self, antecedent: Antecedent, where: str, *, dual: bool, negated: bool, inside: str) -> str:
        """Return an antecedent; `not` before a group goes to its parts, if norms are dual with the other connective."""
        match antecedent:
            case Is(variable=variable, term=term, hedges=hedges):
                hedges, terms = up_to_any(("not", *hedges) if negated else hedges, term)
                return f"{variable} is {' '.join([*self._hedges(hedges, where), *terms])}"
            case Not(operand=operand):
                return self._antecedent(operand, where, dual=dual, negated=not negated, inside=inside)
            case And(operands=operands) | Or(operands=operands):
                if negated and not dual:
                    self.reasons.append(f"{where} negates a group")
                word = "and" if isinstance(antecedent, And) != negated else "or"
                text = f" {word} ".join(
                    self._antecedent(o, where, dual=dual, negated=negated, inside=word) for o in operands
                )
                return text if (inside == "or" and word == "and") or inside == word == "or" else f"({text})"
        raise TypeError(type(antecedent).__name__)

    def _hedges(self, hedges: Sequence[str], where: str) -> list[str]:
        for hedge in hedges:
            if hedge not in HEDGE_WORDS:
                self.reasons.append(f"{where} has the hedge '{hedge}'")
        return list(hedges)

    def _plain(self, text: str, where: str, what: str) -> str:
        """Return a description in one line without characters that begin a comment or end a line."""
        plain = " ".join(text.replace("#", "").replace(";", ",").split())
        if set(text) & set("#;"):
            why = f"'#' and ';' have no place in it; it becomes '{plain}'"
            self.losses.append(Loss(where, what, why, exact=True))
        return plain
