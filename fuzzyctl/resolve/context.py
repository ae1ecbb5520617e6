"""Context of resolution: diagnostics and declared names so far."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import field
from typing import Any, Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note, Severity
from fuzzyctl.diagnostics.fixes import Fix, Replacement, respelt, with_decimal_points
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import a_or_an, closest, counted, listed, look_alikes
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.profiles import PROFILES, Profile
from fuzzyctl.records import dataclass

#: Misspelt names of a system for which the closest known one is looked for.
MAX_SUGGESTIONS: Final = 500
#: Known names that count as one more misspelt one where they are looked through for it alone.
INDEXED: Final = 64

#: Words with a special meaning in guarantees.
CLAIM_FUNCTIONS: Final = ("total", "bounded", "increasing", "decreasing", "lipschitz")

#: Blocks, which may be called `pi`: they are called with parentheses, the number is not.
_BLOCKS: Final = ("a system", "a controller", "a plant", "a loop")


def is_function(name: str, *, output: bool) -> bool:
    """Whether a function of the language has this name, so that no input, param or, with `output`, output may."""
    # An output may be called in a guarantee, as `u(-e)`, like a function.
    return name in CLAIM_FUNCTIONS or (name in ex.FUNCTIONS and (output or name not in ex.SOFT))


@dataclass
class Context:
    """Diagnostics and declared names.

    Args:
        unread: Words of lines that could not be read; names among them are not reported where they are used.
        lost_variable: Whether the declaration of some input or output is known to be missing.
        lost_input: Whether that of some input is, so that inputs cannot be counted.
        lost_file: Whether any declaration may be missing, since a used file could not be read.
        nameless: Keywords of declarations whose name is missing.
        broken: Names of blocks that are declared and may have mistakes.
        callees: Returns the systems, controllers and plants that can be called, each name with its kind.
        foreign: Whether the statements are those of a file of another tool, which reserves no words, sets an output
            twice in a rule, and leaves variables without terms.
        where: The place of each declaration.
    """

    unread: frozenset[str] = frozenset()
    lost_variable: bool = False
    lost_input: bool = False
    lost_file: bool = False
    nameless: frozenset[str] = frozenset()
    broken: frozenset[str] = frozenset()
    callees: Callable[[], Mapping[str, str]] = dict
    foreign: bool = False

    #: The profile in force, whose settings hold where the file says nothing.
    profile: Profile = PROFILES["exact"]
    diagnostics: list[Diagnostic] = field(default_factory=list)
    where: dict[str, Span] = field(default_factory=dict)
    params: dict[str, sx.Param] = field(default_factory=dict)
    inputs: dict[str, sx.Variable] = field(default_factory=dict)
    outputs: dict[str, sx.Variable] = field(default_factory=dict)
    lets: dict[str, sx.Variable] = field(default_factory=dict)
    #: The declarations of a controller, plant or loop besides params.
    named: Mapping[str, sx.Signal | sx.Equation] = field(default_factory=dict)
    #: Outputs of the blocks inside of it that are conditions, 1 or 0, as comparisons.
    conditions: dict[str, ex.Expr] = field(default_factory=dict)
    hedges: dict[str, sx.Hedge] = field(default_factory=dict)
    functions: dict[str, sx.Function] = field(default_factory=dict)
    #: Names of the terms of a variable, by the identity of its statement, which lives as long as the tree.
    terms: dict[int, dict[str, None]] = field(default_factory=dict)
    #: Whether consequents may read inputs, so that an input needs no terms.
    has_functions: bool = False
    #: Outputs whose missing terms have been reported.
    termless: set[str] = field(default_factory=set)
    #: Misspelt names so far.
    suggested: int = 0

    @property
    def names(self) -> Mapping[str, Any]:
        """The params, inputs and outputs, in this order."""
        return ChainMap[str, Any](self.outputs, self.inputs, self.params)

    @property
    def read(self) -> Mapping[str, Any]:
        """The names that consequents, outputs with formulas, and guarantees may read: `names` and the lets."""
        return ChainMap[str, Any](self.outputs, self.inputs, self.lets, self.params)

    def near(self, name: str, known: Collection[str]) -> str | None:
        """Return the known name that a misspelt one most likely means; of a file full of them only for the first."""
        self.suggested += 1
        return closest(name, known) if self.suggested <= MAX_SUGGESTIONS else None

    def report(
        self,
        code: str,
        message: str,
        span: Span | None,
        *,
        facts: Iterable[str] = (),
        help: str = "",
        fix: Fix | None = None,
        **rest: object,
    ) -> None:
        """Add an error; `note=(span, text)` points at a second place, `warning=True` makes it a warning."""
        note = rest.get("note")
        notes = (Note(*note),) if isinstance(note, tuple) else ()
        severity: Severity = "warning" if rest.get("warning") else "error"
        self.diagnostics.append(Diagnostic(code, message, span, severity, tuple(facts), help, notes, fix=fix))

    def declare(self, word: sx.Word, what: str, shared: str = "params, inputs and outputs") -> bool:
        """Enter a name; report and return False when it is reserved or taken; `shared` describes the names."""
        is_clear = what == "a measure" and word.text in CLAIM_FUNCTIONS  # loops make no such claims
        is_word = is_function(word.text, output=what == "an output") and not is_clear
        if (word.text in sx.RESERVED or is_word) and not self.foreign:
            self._reserved(word, what)
            if word.text not in self.unread:
                self.unread |= {word.text}
            self.lost_input = self.lost_input or what == "an input"
            return False
        if word.text in self.where:
            first = self.where[word.text]
            # Most likely the slip is in the name, so that another one is missing now.
            self.lost_variable = True
            self.lost_input = self.lost_input or what == "an input"
            self.report(
                "FZ201",
                f"'{word.text}' is declared twice",
                word.span,
                note=(first, "first declared here"),
                help=f"{shared} share one set of names; rename one of them",
            )
            return False
        self.where[word.text] = word.span
        return True

    def is_first(self, word: sx.Word, seen: dict[str, sx.Word], what: str = "") -> bool:
        """Enter a declaration under its name or another; report and return False when there is one already."""
        first = seen.setdefault(what or word.text, word)
        if first is not word:
            note = (first.span, "first given here")
            named = what or f"'{word.text}'"
            self.report("FZ215", f"{named} is given twice", word.span, note=note, help="remove one of them")
        return first is word

    def is_free(self, word: sx.Word, what: str) -> bool:
        """Report a name that is a word of the language."""
        # `not` is a hedge already, which has another message.
        is_clear = (word.text == "not" and what == "a hedge") or (word.text == "pi" and what in _BLOCKS)
        if word.text in sx.RESERVED and not is_clear and not self.foreign:
            self._reserved(word, what)
            return False
        return True

    def _reserved(self, word: sx.Word, what: str) -> None:
        message = f"'{word.text}' is a word of the language and cannot name {what}"
        self.report("FZ201", message, word.span, help=f"rename it, such as: {word.text}_1")

    def unknown(self, kind: str, word: sx.Word | ex.Name, known: Collection[str], code: str = "FZ202") -> None:
        """Report a name that is not declared.

        Args:
            kind: The expected kind, such as "param or input"; or the possible ones, such as "a param nor 'x'".
            word: The name.
            known: Names that would have been right.
            code: The diagnostic code.
        """
        text = word.text if isinstance(word, sx.Word) else word.name
        block, _, member = text.rpartition(".")
        if (
            not self.unread.isdisjoint((text, block or text, member))
            or (self.lost_file and code == "FZ202")
            or (self.lost_variable and kind in ("input", "output", "input or output", "name"))
            or (code == "FZ202" and any(word in kind or kind == "name" for word in self.nameless))
        ):
            return
        constant = text.lower() if text.lower() in ex.CONSTANTS and "param" in kind else None
        near = constant or self.near(text, known)
        if near is not None and self._is_other(near, word):
            self.suggested += len(known) // INDEXED  # for all names but this one are looked through anew
            is_left = self.suggested < MAX_SUGGESTIONS
            near = self.near(text, [n for n in known if not self._is_other(n, word)]) if is_left else None
        if " nor " in kind:
            message, listing = f"'{text}' is neither {kind}", "known here"
        else:
            message, listing = f"no {kind} '{text}'", f"{kind.replace(', ', 's, ').replace(' or ', 's and ')}s"
        facts = (*look_alikes(text), f"{listing}: {listed(known)}" if known else f"there is no {kind}")
        help_text = f"did you mean '{near}'?" if near else ""
        fix = respelt(word.span, text, near, known)
        if constant is not None and word.span is not None:
            # It is declared nowhere, so that the slip is here, however often the text has each spelling.
            fix = Fix((Replacement(word.span, constant),), "sure")
        if text == "t" and "dt" in known and near is None:
            help_text = "count the time in a state, such as: next time = time + dt"
        if text in self.lets:
            fix = None
            help_text = "a let is not allowed here; a constant begins with 'param'"
        elif kind == "param" and text in self.named:
            fix = None
            help_text = self._no_constant(text, self.named[text])
        self.report(code, message, word.span, facts=facts, help=help_text, fix=fix)

    def _is_other(self, name: str, word: sx.Word | ex.Name) -> bool:
        """Whether a name cannot be a slip of a word: defined in the line of the word, or the time."""
        text = word.text if isinstance(word, sx.Word) else word.name
        place = self.where.get(name)
        is_defined = place is not None and word.span is not None and place.line == word.span.line
        return is_defined or (name in ("t", "dt") and name != text.lower())

    def _no_constant(self, name: str, statement: sx.Signal | sx.Equation) -> str:
        """Return the help on a signal of a controller, plant or loop in the place of a param."""
        keyword = statement.keyword.text
        if keyword == "let" and statement.value is not None and self._is_constant(statement.value):
            return f"'{name}' is a let: write 'param {name} = {ex.to_text(statement.value)}' in place of it"
        return f"'{name}' is {a_or_an(keyword)}, which may change while it runs; a constant begins with 'param'"

    def _is_constant(self, value: ex.Expr) -> bool:
        """Whether a param could have a value."""
        for node in ex.walk(value):
            match node:
                case ex.Name(name=name) if name not in self.params and name not in ex.CONSTANTS:
                    return False
                case ex.Call(function=function) if function not in ex.FUNCTIONS:
                    return False
                case ex.Compare() | ex.Logic() | ex.Keyword() | ex.Items() | ex.Text() | ex.Pair():
                    return False
        return True

    def value_of(self, part: ex.Name | ex.Call) -> ex.Expr | None:
        """Return the expression of a let, an output, a measure or a function; None for any other name."""
        if isinstance(part, ex.Call):
            return self.functions[part.function].expression if part.function in self.functions else None
        if part.name in self.conditions:
            return self.conditions[part.name]
        statement = self.named.get(part.name) or self.read.get(part.name)
        is_state = isinstance(statement, sx.Signal) and statement.keyword.text == "state"
        return None if is_state else getattr(statement, "value", None)

    def is_condition(self, expr: ex.Expr) -> bool:
        """Return whether an expression is a condition, or the name or a call of one."""
        return ex.is_condition(expr, self.value_of)

    def check_names(self, expr: ex.Expr, known: Collection[str], kind: str) -> bool:
        """Check that an expression uses only known names and functions, each with the right number of arguments."""
        if type(expr) is ex.Number:  # nearly all are
            return True
        ok = True
        for node in ex.walk(expr):
            if isinstance(node, ex.Name) and node.name not in known and node.name not in ex.CONSTANTS:
                self.unknown(kind, node, known)
                ok = False
            elif isinstance(node, ex.Call) and not self.check_call(node):
                ok = False
            elif isinstance(node, ex.Compare | ex.Logic):
                help_text = "a condition as a number: gt(a, b), lt(a, b), ge(a, b), le(a, b), eq(a, b)"
                self.report("FZ307", "expected a number, found a condition", ex.span_of(node), help=help_text)
                ok = False
            elif isinstance(node, ex.Keyword | ex.Items | ex.Text | ex.Pair):
                self.report("FZ303", "unexpected argument", ex.span_of(node), help="write a number")
                ok = False
        return ok

    def check_formula(self, expr: ex.Expr, known: Collection[str], kind: str) -> ex.Expr | None:
        """Check an expression that may hold conditions as numbers; return it with these, None after a mistake."""
        ok = True
        for node in ex.walk(expr):
            for operand in node.operands if isinstance(node, ex.Logic) else ():
                if not self.is_condition(operand):
                    self.no_condition(operand)
                    ok = False
        number = ex.as_number(expr)
        return number if self.check_names(number, known, kind) and ok else None

    def no_condition(self, expr: ex.Expr) -> None:
        """Report a number in place of a condition."""
        example = ex.to_text(expr) if isinstance(expr, ex.Name) else "x"
        help_text = f"compare it, such as: {example} > 0"
        self.report("FZ307", "expected a condition, found a number", ex.span_of(expr), help=help_text)

    def check_call(self, call: ex.Call) -> bool:
        """Check the name of a function and the number of its arguments."""
        if "." in call.function:
            help_text = f"name its value: let NAME = {ex.to_text(call)}"
            self.report("FZ214", "outputs of other systems are called in lets only", call.span, help=help_text)
            return False
        if call.function not in ex.FUNCTIONS:
            near = self.near(call.function, ex.FUNCTIONS)
            self.report(
                "FZ202",
                f"no function '{call.function}'",
                call.span,
                facts=(f"functions: {', '.join(ex.FUNCTIONS)}",),
                help=f"did you mean '{near}'?" if near else "",
                fix=respelt(call.span, call.function, near, ex.FUNCTIONS),
            )
            return False
        low, high = ex.FUNCTIONS[call.function]
        count = len(call.arguments)
        if count < low or (high is not None and count > high):
            due = counted(low, "argument") if high == low else f"{low} or more arguments"
            fix = with_decimal_points(call.span, count, low) if high == low else None
            self.report("FZ303", f"'{call.function}' takes {due}, not {count}", call.span, fix=fix)
            return False
        return True
