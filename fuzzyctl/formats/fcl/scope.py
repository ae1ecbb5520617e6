"""Scope of a function block: its dialect, its names, and the values, norms and functions that depend on them."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import CONSTANTS, FUNCTIONS, Call, Expr, ExprError, Name, Number, children, evaluate, rebuilt
from fuzzyctl.formats.common.translation import Translation
from fuzzyctl.formats.fcl.parser import FunctionBlock, Setting
from fuzzyctl.formats.fcl.words import (
    FUZZYLITE_ONLY,
    JFUZZYLOGIC_ONLY,
    JFUZZYLOGIC_SHAPES,
    MEANINGS,
    USUAL_NUMERICS,
    DialectName,
    fuzzylite_word,
)
from fuzzyctl.formats.fll.formulas import ARGUMENTS, expanded
from fuzzyctl.formats.fll.methods import profile_of_version, version_said
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.profiles import PROFILES, Profile

#: A comment of `write` that names the numerics of the system.
_NUMERICS: Final = re.compile(r"numerics of (\w+)")

#: Comments in files of fuzzylite and in files of `write` for it, which may be without any word of fuzzylite.
_FUZZYLITE_SIGNS: Final = ("generated with fuzzylite", "in the dialect of fuzzylite")

#: Functions of both tools under other names, by their names here.
_SAME: Final = {"ln": "log", "fabs": "abs"}


@dataclass(frozen=True)
class Dialect:
    """The dialect of a file and the numerics of its systems."""

    name: DialectName
    numerics: Profile


def dialect_of(comments: Iterable[str], blocks: Iterable[FunctionBlock]) -> Dialect:
    """Return the dialect of a file, by its words and comments; that of the standard without any sign."""
    others = [comment for comment in comments if not _NUMERICS.search(comment)]
    name = _dialect_name(others, blocks)
    names = [match.group(1) for comment in comments for match in _NUMERICS.finditer(comment)]
    profile = next((PROFILES[n] for n in names if n in PROFILES), None)
    if profile is None and name == "fuzzylite":
        profile = profile_of_version(version_said(comments))
    return Dialect(name, profile or PROFILES[USUAL_NUMERICS[name]])


def _dialect_name(comments: Sequence[str], blocks: Iterable[FunctionBlock]) -> DialectName:
    text = " ".join(comments).lower()
    parts = [part for block in blocks for part in block.blocks]
    kinds = [term.kind.text for part in parts for term in part.terms if term.kind is not None]
    settings = [setting for part in parts for setting in part.settings]
    words = {value.text.upper() for s in settings for value in s.values if isinstance(value, sx.Word)}
    has_word = words & FUZZYLITE_ONLY or any(fuzzylite_word(kind) is not None for kind in kinds)
    if has_word or any(sign in text for sign in _FUZZYLITE_SIGNS) or any(map(_is_of_fuzzylite, settings)):
        return "fuzzylite"
    shapes = {kind.upper() for kind in kinds} & {*JFUZZYLOGIC_SHAPES, "FUNCTION", "SINGLETONS"}
    slashes = any(comment.startswith(("//", "/*")) for comment in comments)
    return "jfuzzylogic" if words & JFUZZYLOGIC_ONLY or shapes or slashes or "jfuzzylogic" in text else "standard"


def _is_of_fuzzylite(setting: Setting) -> bool:
    first, keyword = setting.values[0], setting.keyword.text.upper()
    is_nan = isinstance(first, Number) and math.isnan(first.value)
    return keyword in ("LOCK", "ENABLED") or (keyword == "DEFAULT" and (len(setting.values) > 1 or is_nan))


class Scope(Translation):
    """The statements of a function block, its names and its diagnostics.

    Args:
        source: The file.
        dialect: The dialect of the file.

    Attributes:
        inputs: Names of VAR_INPUT.
        outputs: Names of VAR_OUTPUT.
        params: Values of the variables of VAR with a constant.
        readable: Names in functions at the term that is read, with their variables.
        clamped_differences: Whether a difference of sigmoids is 0 where it is negative, as in jFuzzyLogic.
    """

    def __init__(self, source: SourceText, dialect: Dialect) -> None:
        super().__init__(source)
        self.dialect = dialect
        self.inputs: dict[str, sx.Word] = {}
        self.outputs: dict[str, sx.Word] = {}
        self.params: dict[str, float] = {}
        self.readable: dict[str, str] = {}
        self.clamped_differences = False
        self._reported: set[str] = set()

    def _is_new(self, name: str) -> bool:
        """Return whether a name was not reported before, and count it as reported."""
        is_new = name not in self._reported
        self._reported.add(name)
        return is_new

    def spelt(self, name: str, known: Collection[str], span: Span) -> str | None:
        """Return a declared name, which may differ in capitals, as the standard allows."""
        if name in known:
            return name
        alike = [n for n in known if n.lower() == name.lower()]
        if len(alike) != 1:
            return None
        if self._is_new(name):
            message = f"'{name}' is taken for '{alike[0]}'"
            self.warning("FZ604", message, span, help="tools that mind capitals do not know it")
        return alike[0]

    # --- settings --------------------------------------------------------------------------------------------------

    def meaning(self, setting: Setting | None) -> str | None:
        """Return the norm or the defuzzifier of a setting; None for NONE, without a setting, and after an error."""
        if setting is None:
            return None
        keyword, word = setting.keyword.text, setting.word
        meanings = MEANINGS[keyword.upper()]
        if word is None:
            facts = (f"values: {listed(meanings)}",)
            self.error("FZ213", f"{keyword} takes one word", setting.span, facts=facts)
            return None
        text = word.text.upper()
        if text == "NONE":
            return None
        if text == "NSUM" and keyword.upper() == "ACCU":
            return self._normalized_sum(setting)
        return self.look_up(word.span, meanings, keyword, word=text, code="FZ213")

    def _normalized_sum(self, setting: Setting) -> str:
        """Return the norm of NSUM: the standard divides the whole sum by its largest value, tools each degree.

        No defuzzifier depends on the scale of a set, so that the standard's is the plain sum.
        """
        whole = self.dialect.name == "standard"
        ways = "the plain sum, since the standard divides the whole set by one number", "min(1, a + b), as BSUM"
        here, there = ways if whole else ways[::-1]
        facts = (f"{'jFuzzyLogic and fuzzylite take' if whole else 'the standard has'} {there}",)
        help_text = "write SUM or BSUM to say which one is meant"
        self.warning("FZ609", f"NSUM is read as {here}", setting.span, facts=facts, help=help_text)
        return "sum" if whole else "bounded_sum"

    def require_enabled(self, setting: Setting | None) -> None:
        """Refuse a block that fuzzylite has switched off, since the system would be another without it."""
        if setting is not None and (setting.word is None or setting.word.text.upper() != "TRUE"):
            help_text = "remove the block, or write: ENABLED : TRUE"
            self.error("FZ602", "a block that is switched off is not available", setting.span, help=help_text)

    # --- values ----------------------------------------------------------------------------------------------------

    def constant(self, expr: Expr, subject: str) -> Expr | None:
        """Return a parameter that is a number or a constant; report any other and return None."""
        if isinstance(expr, Number):
            if not math.isnan(expr.value):
                return expr
            self.error("FZ302", f"{subject} is not a number", expr.span)
            return None
        if not isinstance(expr, Name) or expr.name in self.params:
            return expr
        help_text = "write a number, or declare it in a VAR block with ':= value'"
        if expr.name in self.inputs or expr.name in self.outputs:
            if self._is_new(expr.name):
                kind = "input" if expr.name in self.inputs else "output"
                changes = "so the term would change with it; that is not available"
                self.error("FZ602", f"{subject} is the {kind} '{expr.name}', {changes}", expr.span, help=help_text)
            return None
        facts = (f"constants: {listed(self.params)}",) if self.params else ()
        help_text = did_you_mean(expr.name, [*self.params]) or help_text
        self.error("FZ202", f"'{expr.name}' is neither a number nor declared", expr.span, facts=facts, help=help_text)
        return None

    def value(self, expr: Expr) -> float | None:
        """Return the value of a parameter, None if it is not finite."""
        try:
            value = evaluate(expr, self.params)
        except ExprError:
            return None
        return value if math.isfinite(value) else None

    def values(self, exprs: Iterable[Expr]) -> tuple[float, ...] | None:
        """Return the values of parameters; None if one has none. Numbers may be infinite."""
        values = [expr.value if isinstance(expr, Number) else self.value(expr) for expr in exprs]
        numbers = tuple(v for v in values if v is not None)
        return numbers if len(numbers) == len(values) else None

    def function(self, expr: Expr) -> Expr | None:
        """Return an expression of FUNCTION with the names and functions of the system; report mistakes."""
        translated = [self.function(part) for part in children(expr)]
        parts = tuple(part for part in translated if part is not None)
        if len(parts) < len(translated):
            return None
        match expr:
            case Name():
                return self._variable(expr)
            case Number(value=value, span=span) if not math.isfinite(value):
                return self._refused("a number of a function is not finite", span)
            case Call():
                return self._call(expr, parts)
        return rebuilt(expr, parts)

    def _refused(self, message: str, span: Span | None, code: str = "FZ602", **more: Any) -> Expr | None:
        self.error(code, message, span, **more)
        return None

    def _variable(self, name: Name) -> Expr | None:
        alike = [n for n in self.readable if n.lower() == name.name.lower()]
        if name.name in self.readable:
            return Name(self.readable[name.name], name.span)
        if name.name in self.params:
            return name
        if name.name in self.outputs:
            message = f"a function of the output '{name.name}', which is not declared before, is not available"
            return self._refused(message, name.span)
        if len(alike) == 1:
            return Name(self.readable[alike[0]], name.span)
        if name.name.lower() in CONSTANTS:
            return Number(CONSTANTS[name.name.lower()], "", name.span)
        names = [*self.readable, *self.params]
        facts, help_text = (f"known: {listed(names)}",), did_you_mean(name.name, names)
        return self._refused(f"no variable '{name.name}'", name.span, "FZ202", facts=facts, help=help_text)

    def _call(self, call: Call, arguments: tuple[Expr, ...]) -> Expr | None:
        name = _SAME.get(call.function, call.function)
        if self.dialect.name != "fuzzylite":
            if name == "%":
                return self._refused("the remainder '%' is not available", call.span)
            if call.function == "log":  # to the base 10 in jFuzzyLogic, the natural one in fuzzylite
                name = "log10"
        name = "fmod" if name == "%" else name
        if name not in FUNCTIONS and name not in ARGUMENTS:
            facts = (f"functions: {listed(sorted({*FUNCTIONS, *ARGUMENTS}))}",)
            return self._refused(f"the function '{call.function}' is not available", call.span, facts=facts)
        least, most = (ARGUMENTS[name],) * 2 if name in ARGUMENTS else FUNCTIONS[name]
        if len(arguments) < least or (most is not None and len(arguments) > most):
            return self._refused(f"'{call.function}' does not take {len(arguments)} arguments", call.span, "FZ303")
        if name not in ARGUMENTS:
            return Call(name, arguments, call.span)
        return expanded(name, arguments) or self._refused("the function is too long", call.span)
