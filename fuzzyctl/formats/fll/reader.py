"""Reader of `.fll` files, with the numerics of fuzzylite: blocks of lines become statements."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import PurePath
from typing import Final, Literal

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Expr, Number
from fuzzyctl.formats.common.blocks import FoundBlock, arranged, joins_of
from fuzzyctl.formats.common.ranges import corners, finite_range, reached, warn_of_degrees_beyond
from fuzzyctl.formats.common.translation import Translation, fallback, setting, settings
from fuzzyctl.formats.fll.lines import Block, Line, split, words
from fuzzyctl.formats.fll.methods import (
    HEDGE_WORDS,
    T_NORMS,
    activation,
    defuzzifier,
    is_none,
    norm,
    profile_of_version,
    version_said,
)
from fuzzyctl.formats.fll.rules import RuleText
from fuzzyctl.formats.fll.shapes import TERMS
from fuzzyctl.formats.fll.terms import Place, TermReader, told_apart
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.profiles import Profile, profile
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Fallback, Hold, Membership, Term

#: A comment that fuzzyctl writes into files with other numerics than those of the newest fuzzylite.
_NUMERICS: Final = re.compile(r"^# numerics of (fuzzylite|fuzzylite_6|pyfuzzylite)\r?$", re.MULTILINE)

#: Connectives of a rule: the word, its key and a norm to suggest.
_CONNECTIVES: Final = (("and", "conjunction", "Minimum"), ("or", "disjunction", "Maximum"))


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Read a file.

    Returns:
        The system, None when there are errors, and all diagnostics in the order of their places.
    """
    translation = Translation(source)
    blocks = split(source, translation)
    if not blocks:
        if not translation.failed:
            translation.error("FZ004", "the file declares no system", None, help="a file begins with: Engine: NAME")
        return None, translation.in_order()
    _File(blocks, translation).translate()
    return translation.system(), translation.in_order()


@dataclass
class _Variable:
    """A variable of the file, with the names of terms that could not be read."""

    block: Block
    name: str
    lower: Number = field(default_factory=lambda: Number(-math.inf))
    upper: Number = field(default_factory=lambda: Number(math.inf))
    terms: list[Term] = field(default_factory=list)
    unread: list[Span] = field(default_factory=list)
    enabled: bool = True
    locked: bool = False

    @property
    def span(self) -> Span:
        return self.block.place

    @property
    def is_output(self) -> bool:
        return self.block.kind == "OutputVariable"

    @property
    def names(self) -> list[str]:
        return [*(t.name for t in self.terms), *(s.text for s in self.unread)]

    @property
    def is_bounded(self) -> bool:
        return math.isfinite(self.lower.value + self.upper.value)


class _File:
    """Translate the blocks of a file.

    Args:
        blocks: The blocks.
        translation: Takes the statements, and mistakes.
    """

    def __init__(self, blocks: Sequence[Block], translation: Translation) -> None:
        self.blocks, self.translation, self.is_broken = blocks, translation, translation.failed
        comment = _NUMERICS.search(translation.source.text)
        self.profile = profile(comment.group(1)) if comment is not None else _profile(translation.source, blocks)
        self.terms = TermReader(translation)
        self.inputs = [_Variable(b, self._name(b)) for b in self._of("InputVariable")]
        self.outputs = [_Variable(b, self._name(b)) for b in self._of("OutputVariable")]
        inputs, outputs = (tuple(v.name for v in variables) for variables in (self.inputs, self.outputs))
        self.place = Place("", inputs, outputs, is_input=True, python=self.profile.name == "pyfuzzylite")

    def _of(self, kind: str) -> list[Block]:
        return [b for b in self.blocks if b.kind == kind]

    def translate(self) -> None:
        """Add all statements."""
        translation = self.translation
        self._head()
        for variable in (*self.inputs, *self.outputs):
            self._read(variable)
        enabled = [v for v in self.outputs if v.enabled]
        disabled = [v for v in self.outputs if not v.enabled]
        for variable in disabled:
            message = f"output '{variable.name}' is disabled; it is left out, and what rules say of it"
            translation.warning("FZ611", message, variable.span, help="enable it, or remove it")
        blocks, idle = self._rule_blocks()
        if not blocks and not translation.failed:
            self._report_no_rule()
        ranges = [self._input(v) for v in self.inputs]
        methods = [self._method(v, {o for _, b in blocks for o in b.outputs}) for v in enabled]
        sets = [v.name for v, (_, crisp) in zip(enabled, methods, strict=True) if not crisp.over_rules]
        self._require_norms(blocks, sets)
        arrangement = arranged([b for _, b in blocks], sets, keep=any(b.name for _, b in blocks))
        # A norm that no rule needs is kept all the same.
        usual = {n: getattr(blocks[0][1], n) for n in ("conjunction", "disjunction", "implication")} if blocks else {}
        method: dict[str, object] = {n: norm for n, norm in usual.items() if norm is not None} | arrangement.method
        first = methods[0] if methods else ("max", self.profile.defuzzifier("centroid"))
        method |= {"aggregation": first[0], "defuzzifier": first[1]}
        translation.statements += settings(method, self.blocks[0].head.span)
        for variable, (aggregation, crisp) in zip(enabled, methods, strict=True):
            implication = arrangement.implications.get(variable.name) or method.get("implication")
            fields = {"aggregation": aggregation, "defuzzifier": crisp, "implication": implication}
            different = {n: v for n, v in fields.items() if v != method.get(n)}
            self._output(variable, different, crisp.over_rules, ranges)
        for variable in disabled:
            self._add(variable, (Number(0.0), Number(1.0)))
            translation.left_out.add(variable.name)
        translation.rules(arrangement, idle)

    def _head(self) -> None:
        engines = self._of("Engine")
        for second in engines[1:]:
            notes = (Note(engines[0].head.span, "the first one is here"),)
            message, help_text = "the file has a second engine", "put each into a file of its own"
            self.translation.error("FZ215", message, second.head.span, help=help_text, notes=notes)
        for kind, variables in (("InputVariable", self.inputs), ("OutputVariable", self.outputs)):
            if not variables and not self.is_broken:
                message = f"the file has no {kind}"
                self.translation.error("FZ212", message, None, help=f"write: {kind}: NAME")
        name = engines[0].head.value.text if engines else ""
        place = (engines or self.blocks)[0].head.span
        title = engines[0].description if engines else ""
        self.translation.head(name or PurePath(self.translation.source.name).stem, title, place, self.profile)

    # --- variables ---------------------------------------------------------------------------------------------

    def _name(self, block: Block) -> str:
        """Return the name of a variable without blanks and parentheses, which fuzzylite leaves out, too."""
        text = block.head.value.text
        name = "".join(c for c in text if not c.isspace() and c not in "()")
        if not name:
            help_text = f"write: {block.head.span.text.strip(': ')}: NAME"
            self.translation.error("FZ212", "the variable has no name", block.head.span, help=help_text)
        elif name != text:
            message = f"'{text[:60]}' is not a name for rules; it becomes '{name[:60]}'"
            help_text = "names have no blanks and no parentheses"
            self.translation.warning("FZ604", message, block.head.value, help=help_text)
        return name

    def _read(self, variable: _Variable) -> None:
        block, translation = variable.block, self.translation
        place = replace(self.place, variable=variable.name, is_input=not variable.is_output)
        for line in block.all("term"):
            self._term(line, place, variable)
        help_text = "rules mean the first; give it a name of its own"
        variable.terms = told_apart(variable.terms, variable.name, translation, help_text)
        self._range(variable)
        aggregation = block.line("aggregation")
        below = not variable.is_output or aggregation is None or aggregation.value.text != "Maximum"
        sets = [t for t in variable.terms if not variable.is_output or t.membership.kind == "formula"]
        ends = variable.lower.value, variable.upper.value
        warn_of_degrees_beyond(sets, variable.name, ends, translation, below=below)
        variable.enabled = self._flag(block, True, "enabled")
        variable.locked = self._flag(block, False, "lock-range")
        if not variable.is_output and not variable.enabled:
            message = f"input '{variable.name}' is disabled, so that nothing can be one of its terms"
            translation.warning("FZ611", message, variable.span, help="enable it, or remove it")

    def _term(self, line: Line, place: Place, variable: _Variable) -> None:
        parts = words(line.value)
        if len(parts) < 2:
            help_text = "a term is written: term: NAME Triangle 0 1 2"
            self.translation.error("FZ601", "the term has no name or no kind", line.span, help=help_text)
            variable.unread += parts
            return
        name, kind, *rest = parts
        membership = self._membership(place, kind, rest, line.value)
        if membership is not None:
            variable.terms.append(Term(name=name.text, membership=membership, span=name))
        else:
            variable.unread.append(name)

    def _membership(self, place: Place, kind: Span, rest: list[Span], span: Span) -> Membership | None:
        word = self.translation.look_up(kind, TERMS, "term")
        if word is None:
            return None
        if word.kind != "function":
            numbers = tuple(n for s in rest if (n := self.translation.number(s)) is not None)
            return self.terms.shape(place, kind, word, numbers, span) if len(numbers) == len(rest) else None
        if rest:
            return self.terms.formula(place, rest[0].to(rest[-1]), span)
        self.translation.error("FZ303", "'Function' has no formula", span, help="write, for example: sin(x) / x")
        return None

    def _range(self, variable: _Variable) -> None:
        line = variable.block.line("range")
        if line is None:
            return
        ends = [self.translation.number(end) for end in words(line.value)]
        if len(ends) != 2:
            help_text = "write, for example: range: 0.0 10.0"
            self.translation.error("FZ601", "a range has two numbers", line.value, help=help_text)
        low, high = ends if len(ends) == 2 else (None, None)
        variable.lower, variable.upper = low or Number(0.0), high or Number(1.0)

    def _flag(self, block: Block, usual: bool, *keys: str) -> bool:
        """Return a switch, or the usual one if it is missing."""
        line = block.line(*keys)
        if line is None:
            return usual
        text = line.value.text.lower()
        if text not in ("true", "false"):
            message = f"'{line.key}' is true or false, got '{line.value.text[:40]}'"
            self.translation.error("FZ601", message, line.value)
            return usual
        return text == "true"

    def _add(self, variable: _Variable, ends: tuple[Number, Number], clauses: Sequence[sx.Clause] = ()) -> None:
        keyword, label = "output" if variable.is_output else "input", variable.block.description
        name = sx.Word(variable.name, variable.span)
        self.translation.variable(keyword, name, ends, variable.terms, clauses, label=label, unread=variable.unread)

    def _input(self, variable: _Variable) -> tuple[float, float]:
        needed, ends = corners(t.membership for t in variable.terms), (variable.lower, variable.upper)
        low, high = finite_range(variable.name, ends, needed, variable.span, self.translation)
        is_free = not variable.locked or not variable.is_bounded
        self._add(variable, (low, high), [sx.ExtrapolateClause(variable.span)] if is_free else [])
        return low.value, high.value

    def _method(self, variable: _Variable, concluded: set[str]) -> tuple[str, Defuzzifier]:
        """Return the aggregation and the defuzzifier of an output."""
        translation, block = self.translation, variable.block
        line, is_set = block.line("defuzzifier"), variable.name in concluded
        method = defuzzifier(line, variable.name, variable.span, variable.terms, self.profile, translation)
        if method is None and is_set and is_none(line):
            message = f"output '{variable.name}' has no defuzzifier"
            translation.error("FZ212", message, variable.span, help="write, for example: defuzzifier: Centroid 1000")
        method = method or self.profile.defuzzifier("centroid")
        line = block.line("aggregation", "accumulation")
        aggregation = norm(line, translation, "aggregation")
        if is_none(line) and is_set and not method.over_rules:
            message = f"output '{variable.name}' has no aggregation, which '{method.kind}' needs"
            translation.error("FZ212", message, variable.span, help="write: aggregation: Maximum")
        return aggregation or ("sum" if method.over_rules else "max"), method

    def _output(
        self, variable: _Variable, fields: dict[str, object], over_rules: bool, ranges: Sequence[tuple[float, float]]
    ) -> None:
        span = variable.span
        clauses: list[sx.Clause] = [
            sx.SettingClause(setting(n, v, span), span) for n, v in fields.items() if isinstance(v, str | Defuzzifier)
        ]
        clauses.append(fallback(self._otherwise(variable.block), span))
        if variable.locked and variable.is_bounded:
            clauses.append(sx.ClampClause(span))
        self._add(variable, self._ends(variable, over_rules, ranges), clauses)

    def _ends(
        self, variable: _Variable, over_rules: bool, ranges: Sequence[tuple[float, float]]
    ) -> tuple[Number, Number]:
        """Return the range of an output, which may be infinite or empty for averages, as they do not use it."""
        ends = variable.lower, variable.upper
        if not over_rules:
            if not variable.is_bounded:
                message = f"the range of '{variable.name}' is infinite, and its defuzzifier samples it"
                place = variable.lower.span or variable.span
                self.translation.error("FZ302", message, place, help="write, for example: range: 0.0 10.0")
                return Number(0.0), Number(1.0)
            return ends
        needed = [e for t in variable.terms for e in reached(t.membership, ranges)]
        needed += corners(t.membership for t in variable.terms if t.membership.kind not in ("constant", "linear"))
        kind = "infinite"
        if variable.lower.value == variable.upper.value:
            kind = "empty" if variable.is_bounded else kind
            ends = Number(-math.inf, span=variable.lower.span), Number(math.inf)
        return finite_range(variable.name, ends, needed, variable.span, self.translation, kind)

    def _otherwise(self, block: Block) -> Expr | Fallback | Hold:
        """Return the output if no rule fires: its default, or its previous value if that is locked."""
        line = block.line("default")
        start: Number | Literal["nan"] = "nan"
        if line is not None and line.value.text.lower() not in ("nan", "-nan"):
            start = self.translation.number(line.value) or "nan"
        return Hold(start=start) if self._flag(block, False, "lock-previous", "lock-valid") else start

    # --- rules -------------------------------------------------------------------------------------------------

    def _rule_blocks(self) -> tuple[list[tuple[Block, FoundBlock]], list[sx.Rule]]:
        """Return the enabled blocks with rules, and the rules that set only outputs left out."""
        blocks, idle = [], list[sx.Rule]()
        for block in self._of("RuleBlock"):
            if not self._flag(block, True, "enabled"):
                name = block.head.value.text[:60]
                named = f"rule block '{name}'" if name else "the rule block"
                message = f"{named} is disabled; it is left out, and {counted(len(block.all('rule')), 'rule')} with it"
                self.translation.warning("FZ611", message, block.head.span, help="enable it, or remove it")
                continue
            translated = self._rule_block(block, idle)
            if translated.rules:
                blocks.append((block, translated))
        return blocks, idle

    def _rule_block(self, block: Block, idle: list[sx.Rule]) -> FoundBlock:
        translation = self.translation
        terms = {v.name: v.names for v in (*self.inputs, *self.outputs)}
        disabled = [v.name for v in (*self.inputs, *self.outputs) if not v.enabled]
        off = {v.name for v in self.outputs if not v.enabled}
        rules = []
        for line in block.all("rule"):
            rule = RuleText(line.value, terms, HEDGE_WORDS, disabled, translation).read()
            if rule is not None and rule.consequents and all(c.output.text in off for c in rule.consequents):
                message = "the rule sets only disabled outputs, so it has no effect"
                translation.warning("FZ611", message, rule.span, help="enable one, or remove it")
                idle.append(rule)
            elif rule is not None:
                rules.append(rule)
        implication, method = block.line("implication"), block.line("activation")
        if implication is None and _implied(block) is not None:
            implication, method = method, None
        return FoundBlock(
            block.head.value.text,
            tuple(rules),
            norm(block.line("conjunction"), translation, "and"),
            norm(block.line("disjunction"), translation, "or"),
            norm(implication, translation, "and"),
            activation(method, translation),
            block.head.span,
        )

    def _require_norms(self, blocks: Sequence[tuple[Block, FoundBlock]], sets: Sequence[str]) -> None:
        """Report blocks without a norm that their rules need; outputs that are sets need an implication."""
        for block, translated in blocks:
            for word, key, usual in _CONNECTIVES:
                joining = next((r for r in translated.rules if word in joins_of(r)), None)
                if joining is not None and is_none(block.line(key)):
                    message = f"the rule joins by '{word}', and its rule block has no {key}"
                    self.translation.error("FZ212", message, joining.span, help=f"write: {key}: {usual}")
            lacks = translated.implication is None and is_none(block.line("implication"))
            for output in sets if lacks else ():
                if output in translated.outputs:
                    message = f"the rule block sets '{output}', which is a fuzzy set, and has no implication"
                    if not is_none(block.line("activation")):
                        message += " that is available"
                    self.translation.error("FZ212", message, block.head.span, help="write: implication: Minimum")

    def _report_no_rule(self) -> None:
        """Report why no rule acts."""
        blocks = self._of("RuleBlock")
        enabled = [b for b in blocks if self._flag(b, True, "enabled")]
        place = (enabled or blocks or self.blocks)[0].head.span
        help_text = "write, for example: rule: if A is x then C is z"
        if not any(v.enabled for v in self.outputs):
            message, place, help_text = "all outputs are disabled", self.outputs[0].span, "enable one"
        elif not blocks:
            message, help_text = "the file has no RuleBlock", "write: RuleBlock: NAME, with rules"
        elif not enabled:
            message = "all rule blocks are disabled" if len(blocks) > 1 else "the only rule block is disabled"
            help_text = "enable one"
        elif any(b.all("rule") for b in enabled):
            message = "no rule sets an output that is enabled"
        else:
            message = "the rule block has no rule" if len(enabled) == 1 else "the rule blocks have no rule"
        self.translation.error("FZ212", message, place, help=help_text)


def _profile(source: SourceText, blocks: Sequence[Block]) -> Profile:
    """Return the numerics of the version that wrote a file, by its comment, else by words that version 7 has not."""
    version = version_said(line for line in source.text.splitlines() if line.lstrip().startswith("#"))
    old = [line for b in blocks for line in (b.line("accumulation", "lock-valid"), _implied(b)) if line is not None]
    return profile_of_version(6 if version is None and old else version)


def _implied(block: Block) -> Line | None:
    """Return the line of an implication that has the key of the activation, as in fuzzylite 4 and 5."""
    line = block.line("activation")
    return line if line is not None and line.value.text in T_NORMS else None
