"""Reader of `.fll` files, with the numerics of fuzzylite."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import PurePath
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.report import Findings
from fuzzyctl.formats.fll.methods import profile_of_version, version_said
from fuzzyctl.model.method import Method
from fuzzyctl.model.profiles import Profile, profile
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Output
from tests.oracles.blocks import FoundBlock, combined, without_common
from tests.oracles.fll.lines import SPELT, Block, split
from tests.oracles.fll.methods import defuzzifier, is_none, norm
from tests.oracles.fll.rule_blocks import (
    read_rule_blocks,
    report_no_rule,
    require_norms,
)
from tests.oracles.fll.rules import RuleReader
from tests.oracles.fll.terms import Place
from tests.oracles.fll.variables import (
    Variable,
    corners,
    finite_range,
    named_twice,
    otherwise,
    own_name,
    reached,
    read_variable,
)
from tests.oracles.fll.vocabulary import T_NORMS

#: What fuzzyctl writes into files whose numerics are not those of the newest fuzzylite.
_SAID: Final = re.compile(r"^# numerics of (fuzzylite|fuzzylite_6|pyfuzzylite)\r?$", re.MULTILINE)


def read(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Read a file.

    Returns:
        The system, None when there are errors, and all diagnostics in the order of their places.
    """
    findings = Findings(source)
    system = _read(source, findings)
    return (None if findings.failed else system), findings.in_order()


def _read(source: SourceText, findings: Findings) -> FuzzySystem | None:
    blocks = split(source, findings)
    if not blocks:
        if not findings.failed:
            findings.error("FZ004", "the file declares no system", None, help="a file begins with: Engine: NAME")
        return None
    return _File(blocks, findings).system()


class _File:
    """Put the blocks of a file together.

    Args:
        blocks: The blocks.
        findings: Where mistakes go.
    """

    def __init__(self, blocks: Sequence[Block], findings: Findings) -> None:
        self.blocks = blocks
        self.findings = findings
        said = _SAID.search(findings.source.text)
        self.profile: Profile = profile(said.group(1)) if said is not None else _numerics(findings.source, blocks)
        self.inputs = self._of("inputvariable")
        self.outputs = self._of("outputvariable")

    def _of(self, kind: str) -> list[Block]:
        return [b for b in self.blocks if b.kind == kind]

    def system(self) -> FuzzySystem | None:
        """Return the system, None after an error."""
        findings = self.findings
        self._check_blocks()
        inputs, outputs = self._variables()
        known = {v.name: v for v in (*inputs, *outputs)}
        enabled = [v for v in outputs if v.enabled]
        for variable in outputs:
            if not variable.enabled:
                message = f"output '{variable.name}' is disabled; it is left out, and what rules say of it"
                findings.warning("FZ611", message, variable.span, help="enable it, or remove it")
        read = read_rule_blocks(self._of("ruleblock"), RuleReader(known, findings), findings)
        blocks = [found for _, found in read]
        if not enabled and outputs and not findings.failed:
            findings.error("FZ212", "all outputs are disabled", outputs[0].span, help="enable one")
        if not blocks and not findings.failed:
            report_no_rule(self._of("ruleblock"), self.blocks[0], findings)
        ranges = [self._input_range(v) for v in inputs]
        made = [self._output(v, blocks, ranges) for v in enabled]
        sets = [o.name for o in made if o.defuzzifier is not None and not o.defuzzifier.over_rules]
        require_norms(read, sets, findings)
        if findings.failed:
            return None
        rules = combined(blocks, sets, keep=any(b.name for b in blocks))
        # A norm that no rule needs is kept all the same.
        usual = {n: getattr(blocks[0], n) for n in ("conjunction", "disjunction", "implication")}
        method = Method(
            aggregation=made[0].aggregation or "max",
            defuzzifier=made[0].defuzzifier or self.profile.defuzzifier("centroid"),
            semantics=self.profile.semantics,
            **{n: norm for n, norm in usual.items() if norm is not None} | rules.method,
        )
        made = [o.model_copy(update={"implication": rules.implications.get(o.name)}) for o in made]
        name, title = self._title()
        return FuzzySystem(
            name=name,
            title=title,
            method=method,
            inputs=tuple(self._input(v, r) for v, r in zip(inputs, ranges, strict=True)),
            outputs=tuple(without_common(o, method) for o in made),
            blocks=rules.blocks,
            path=findings.source.name,
            span=next((b.head.span for b in self._of("engine")), None),
        )

    def _check_blocks(self) -> None:
        engines = self._of("engine")
        for again in engines[1:]:
            note = Note(engines[0].head.span, "the first one is here")
            message = "the file has a second engine"
            self.findings.error(
                "FZ215", message, again.head.span, help="put each into a file of its own", notes=(note,)
            )
        for kind, blocks in (("inputvariable", self.inputs), ("outputvariable", self.outputs)):
            if not blocks and not self.findings.failed:
                self.findings.error("FZ212", f"the file has no {SPELT[kind]}", None, help=f"write: {SPELT[kind]}: NAME")

    def _title(self) -> tuple[str, str]:
        engines = self._of("engine")
        name = engines[0].head.value.text if engines else ""
        described = engines[0].line("description") if engines else None
        title = described.value.text.replace('"', "'") if described is not None else ""
        return name or PurePath(self.findings.source.name).stem, title

    def _variables(self) -> tuple[list[Variable], list[Variable]]:
        findings = self.findings
        names = {id(b): own_name(b, findings) for b in (*self.inputs, *self.outputs)}
        named_twice((*self.inputs, *self.outputs), list(names.values()), findings)
        inputs = tuple(names[id(b)] for b in self.inputs)
        outputs = tuple(names[id(b)] for b in self.outputs)
        found: list[list[Variable]] = []
        for blocks in (self.inputs, self.outputs):
            is_input, python = blocks is self.inputs, self.profile.name == "pyfuzzylite"
            found.append(
                [
                    read_variable(b, names[id(b)], Place(names[id(b)], inputs, outputs, is_input, python), findings)
                    for b in blocks
                ]
            )
        return found[0], found[1]

    def _input_range(self, variable: Variable) -> tuple[Number, Number]:
        return finite_range(variable, corners(t.membership for t in variable.terms), self.findings)

    def _input(self, variable: Variable, ends: tuple[Number, Number]) -> Input:
        unbounded = math.isinf(variable.lower.value) or math.isinf(variable.upper.value)
        if not variable.enabled:
            message = f"input '{variable.name}' is disabled, so that nothing can be one of its terms"
            self.findings.warning("FZ611", message, variable.span, help="enable it, or remove it")
        return Input(
            name=variable.name,
            label=variable.label,
            lower=ends[0],
            upper=ends[1],
            terms=variable.terms,
            extrapolate=not variable.lock_range or unbounded,
            span=variable.span,
        )

    def _output(
        self, variable: Variable, blocks: Sequence[FoundBlock], ranges: Sequence[tuple[Number, Number]]
    ) -> Output:
        findings = self.findings
        block = variable.block
        method = defuzzifier(block.line("defuzzifier"), variable, self.profile, findings)
        is_set = any(variable.name in b.outputs for b in blocks)
        if method is None and is_set and is_none(block.line("defuzzifier")):
            message = f"output '{variable.name}' has no defuzzifier"
            findings.error("FZ212", message, variable.span, help="write, for example: defuzzifier: Centroid 1000")
        method = method or self.profile.defuzzifier("centroid")
        over_rules = method.kind not in ("centroid", "bisector", "som", "lom", "mom")
        line = block.line("aggregation", "accumulation")
        aggregation = norm(line, findings, kind="aggregation")
        if aggregation is None and is_none(line) and is_set and not over_rules:
            message = f"output '{variable.name}' has no aggregation, which '{method.kind}' needs"
            findings.error("FZ212", message, variable.span, help="write: aggregation: Maximum")
        lower, upper = self._output_range(variable, ranges, over_rules)
        return Output(
            name=variable.name,
            label=variable.label,
            lower=lower,
            upper=upper,
            terms=variable.terms,
            otherwise=otherwise(block, findings),
            clamped=variable.lock_range and math.isfinite(variable.lower.value + variable.upper.value),
            aggregation=aggregation or ("sum" if over_rules else "max"),
            defuzzifier=method,
            span=variable.span,
        )

    def _output_range(
        self, variable: Variable, ranges: Sequence[tuple[Number, Number]], over_rules: bool
    ) -> tuple[Number, Number]:
        """Return the range of an output; averages do not look at it: a file may give an infinite or empty one."""
        if not over_rules:
            if not math.isfinite(variable.lower.value + variable.upper.value):
                message = f"the range of '{variable.name}' is infinite, and its defuzzifier samples it"
                place = variable.lower.span or variable.span
                self.findings.error("FZ302", message, place, help="write, for example: range: 0.0 10.0")
            return variable.lower, variable.upper
        inputs = [(low.value, high.value) for low, high in ranges]
        ends = [e for t in variable.terms for e in reached(t.membership, inputs)]
        ends += corners(t.membership for t in variable.terms if t.membership.kind not in ("constant", "linear"))
        kind = "infinite"
        if variable.lower.value == variable.upper.value:
            kind = "empty" if math.isfinite(variable.lower.value) else kind
            unknown = Number(-math.inf, span=variable.lower.span)
            variable = Variable(**{**variable.__dict__, "lower": unknown, "upper": Number(math.inf)})
        return finite_range(variable, ends, self.findings, kind)


def _numerics(source: SourceText, blocks: Sequence[Block]) -> Profile:
    """Return how the version computes that wrote a file, by its comment, else by its words."""
    version = version_said(line for line in source.text.splitlines() if line.lstrip().startswith("#"))
    return profile_of_version(6 if version is None and _is_old(blocks) else version)


def _is_old(blocks: Sequence[Block]) -> bool:
    """Whether the file has words that fuzzylite 7 does not know any more."""
    for block in blocks:
        activation = block.line("activation")
        if block.line("accumulation", "lock-valid") or (activation and activation.value.text in T_NORMS):
            return True
    return False
