"""Names of a rule file: where each is declared and where it is used.

They are read from the syntax tree alone, so that a file with mistakes has them, too; the model stays free of it.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.lang import syntax as sx
from fuzzyctl.loading.assembly import split

#: Words in the place of a term that are not terms.
_NO_TERMS: Final = frozenset({"any"})
#: The kinds of names that may be before an opening parenthesis.
_CALLABLE: Final = frozenset({"system", "controller", "plant", "function", "hedge", "output"})


@dataclass(frozen=True, eq=False)
class Symbol:
    """One declared name.

    Args:
        kind: "system", "controller", "plant", "loop", "param", "hedge", "function", "input", "output", "let", "state",
            "block", "disturbance", "measure", "term" or "rules".
        name: The name.
        span: Location of the name where it is declared.
        whole: Location of the declaration, lines below it included.
        label: Its label or title, empty for none.
        owner: The symbol that it belongs to: a term's variable, a variable's block.
    """

    kind: str
    name: str
    span: Span
    whole: Span
    label: str = ""
    owner: Symbol | None = None

    @property
    def block(self) -> Symbol | None:
        """The system, controller, plant or loop that it belongs to."""
        return self.owner.block or self.owner if self.owner is not None else None

    @property
    def path(self) -> tuple[tuple[str, str], ...]:
        """Kind and name of the symbol, after those of its owners."""
        return (*(self.owner.path if self.owner is not None else ()), (self.kind, self.name))


@dataclass
class Scope:
    """Names of one block, or of all blocks of a file.

    Args:
        outer: Names that the blocks of the file have in common.
        own: Declared names.
        terms: Terms of each variable, by the name of the variable.
        callees: The block of each instance and each named call.
    """

    outer: Mapping[str, Symbol] = field(default_factory=dict)
    own: dict[str, Symbol] = field(default_factory=dict)
    terms: dict[str, dict[str, Symbol]] = field(default_factory=dict)
    callees: dict[str, str] = field(default_factory=dict)

    @property
    def names(self) -> Mapping[str, Symbol]:
        """All names that can be read here."""
        return ChainMap(self.own, dict(self.outer))


@dataclass
class Symbols:
    """All symbols of a file and of the files that it uses.

    Args:
        all: The symbols, in the order declared.
        uses: Each location of a name in these files with its symbol; declarations are among them.
    """

    all: list[Symbol] = field(default_factory=list)
    uses: list[tuple[Span, Symbol]] = field(default_factory=list)
    #: Systems, controllers and plants of used files, each with its scope.
    elsewhere: list[tuple[Scope, Symbol]] = field(default_factory=list)
    #: Symbols of used files by source and offset.
    known: dict[tuple[str, int], Symbol] = field(default_factory=dict)
    #: Scopes of the blocks by the offset at which each begins, and the kind of each block.
    scopes: list[tuple[int, Scope, Symbol | None]] = field(default_factory=list)

    @cached_property
    def _by_symbol(self) -> dict[Symbol, list[Span]]:
        spans: dict[Symbol, list[Span]] = {}
        for span, symbol in self.uses:
            spans.setdefault(symbol, []).append(span)
        return spans

    def at(self, source_name: str, offset: int) -> tuple[Span, Symbol] | None:
        """Return the name at an offset of a file, with its symbol."""
        for span, symbol in self.uses:
            if span.source.name == source_name and span.start <= offset <= span.end:
                return span, symbol
        return None

    def uses_of(self, symbol: Symbol) -> list[Span]:
        """Return all locations of a symbol, its declaration among them, in the order of the text."""
        return sorted(self._by_symbol.get(symbol, []), key=lambda s: (s.source.name, s.start))

    def blocks(self) -> Iterator[tuple[Scope, Symbol]]:
        """Yield the blocks of the file, then those of the files that it uses, each with its scope."""
        yield from ((scope, head) for _, scope, head in self.scopes if head is not None)
        yield from self.elsewhere

    def take_in(self, used: Symbols) -> None:
        """Add the names of a used file: the blocks that this one may call, and where the others are used there."""
        self.elsewhere += [(s, head) for _, s, head in used.scopes if head is not None and head.kind != "loop"]
        self.uses += used.uses
        self.known |= {(s.span.source.name, s.span.start): s for s in used.all}

    def scope_at(self, offset: int) -> tuple[Scope, Symbol | None]:
        """Return the scope of the block that holds an offset."""
        found: tuple[Scope, Symbol | None] = (Scope(), None)
        for start, scope, head in self.scopes:
            if start <= offset:
                found = (scope, head)
        return found


def symbols_of(tree: sx.SyntaxTree, used: Iterable[Symbols] = ()) -> Symbols:
    """Return the symbols of a file, whose used files have been brought in.

    Args:
        tree: The file, with the declarations of used files.
        used: The symbols of used files, whose blocks it may call.
    """
    symbols = Symbols()
    for file in used:
        symbols.take_in(file)
    parts = split(tree)
    shared = _Block(symbols, Scope(), None)
    common = parts[0].shared if parts else ()
    shared.declare(common)
    heads: dict[str, Scope] = {}
    blocks = []
    for part in parts:
        statements = part.tree.statements
        scope = Scope(shared.scope.own, terms=dict(shared.scope.terms))
        head = None
        if part.head is not None:
            keyword = "system" if isinstance(part.head, sx.System) else part.head.keyword.text
            end = max((_end(s) for s in statements), default=part.head.span.end)
            whole = Span(part.head.span.source, part.head.span.start, end)
            head = Symbol(keyword, part.head.name.text, part.head.name.span, whole, part.head.title)
            symbols.all.append(head)
            symbols.uses.append((head.span, head))
            heads.setdefault(head.name, scope)
            shared.scope.own.setdefault(head.name, head)
        start = part.head.span.start if part.head is not None else 0
        symbols.scopes.append((start, scope, head))
        block = _Block(symbols, scope, head)
        block.declare(statements)
        blocks.append((block, statements))
    for scope, head in symbols.elsewhere:
        heads.setdefault(head.name, scope)
        shared.scope.own.setdefault(head.name, head)
    shared.heads = heads
    shared.use(common)
    for block, statements in blocks:
        block.heads = heads
        block.use(statements)
    return symbols


def _end(statement: sx.Statement) -> int:
    lines: tuple[Any, ...] = ()
    if isinstance(statement, sx.Variable):
        lines = statement.terms
    elif isinstance(statement, sx.Table):
        lines = (*statement.rows, *((statement.header,) if statement.header is not None else ()))
    ends: list[int] = [line.span.end for line in lines if line.span.source == statement.span.source]
    return max([statement.span.end, *ends])


class _Block:
    """Declares and looks up the names of one block."""

    def __init__(self, symbols: Symbols, scope: Scope, head: Symbol | None) -> None:
        self.symbols, self.scope, self.head = symbols, scope, head
        self.heads: Mapping[str, Scope] = {}
        self.declared: dict[tuple[str, int], Symbol] = {}

    # -- declarations

    def declare(self, statements: Iterable[sx.Statement]) -> None:
        """Enter all names first, since statements may use later declarations."""
        for s in statements:
            match s:
                case sx.Param(name=name):
                    self._declare("param", name, s)
                case sx.Hedge(name=name):
                    self._declare("hedge", name, s)
                case sx.Function(name=name):
                    self._declare("function", name, s)
                case sx.Rules(name=name):
                    self._declare("rules", name, s)
                case sx.Signal(name=name, keyword=keyword, label=label):
                    self._declare(keyword.text, name, s, label)
                case sx.Equation(name=name, keyword=keyword, value=value) if keyword.text in ("let", "block"):
                    self._declare(keyword.text, name, s)
                    if isinstance(value, ex.Call):
                        self.scope.callees[name.text] = value.function
                case sx.Variable():
                    self._variable(s)

    def _declare(self, kind: str, word: sx.Word, s: sx.Statement, label: str = "") -> Symbol:
        whole = Span(s.span.source, s.span.start, _end(s))
        symbol = self._entered(Symbol(kind, word.text, word.span, whole, label, self.head))
        self.scope.own.setdefault(word.text, symbol)
        return symbol

    def _entered(self, symbol: Symbol) -> Symbol:
        """Return the symbol of a declaration: that of the used file, or that of the line that variables share."""
        at = (symbol.span.source.name, symbol.span.start)
        if at not in self.declared:
            if at not in self.symbols.known:
                self._used(symbol.span, symbol)
            self.declared[at] = self.symbols.known.get(at, symbol)
            self.symbols.all.append(self.declared[at])
        return self.declared[at]

    def _variable(self, s: sx.Variable) -> None:
        variable = self._declare(s.keyword.text, s.name, s, s.label)
        terms: dict[str, Symbol] = {}
        for line in s.terms:
            for word in [line.name] if isinstance(line, sx.TermLine) else [item.name for item in line.items]:
                term = Symbol("term", word.text, word.span, line.span, owner=variable)
                terms.setdefault(word.text, self._entered(term))
        self.scope.terms.setdefault(s.name.text, terms)

    # -- uses

    def use(self, statements: Iterable[sx.Statement]) -> None:
        """Look up all names that statements use."""
        statements = list(statements)
        for s in statements:
            if isinstance(s, sx.Variable):
                for clause in s.clauses:
                    if isinstance(clause, sx.TermsClause):
                        self._word(clause.variable)
                        of = self.scope.terms.get(clause.variable.text, {})
                        self.scope.terms[s.name.text] = {**of, **self.scope.terms.get(s.name.text, {})}
        for s in statements:
            self._statement(s)

    def _statement(self, s: sx.Statement) -> None:
        match s:
            case sx.Hedge(parameter=parameter, expression=expression):
                self._expr(expression, {parameter.text})
            case sx.Function(parameters=parameters, expression=expression):
                self._expr(expression, {p.text for p in parameters})
            case sx.Equation(keyword=keyword, name=name, value=value):
                if keyword.text in ("next", "der"):
                    self._word(name)
                self._expr(value)
            case sx.Varied(name=name):
                self._name(name.text, name.span)
                self._parts(s, skip={"name", "span"})
            case sx.Table():
                self._table(s)
            case sx.Rule(antecedent=antecedent, consequents=consequents, weight=weight):
                self._truth(antecedent)
                self._consequents(consequents)
                self._expr(weight)
            case sx.Otherwise(consequents=consequents, weight=weight):
                self._consequents(consequents)
                self._expr(weight)
            case sx.With(condition=condition):
                self._truth(condition)
            case sx.Variable():
                self._parts(s, skip={"name", "keyword", "span", "label"})
            case _:
                self._parts(s, skip={"name", "keyword", "span"})

    def _parts(self, node: Any, skip: Iterable[str] = ()) -> None:
        """Look up the expressions in the fields of a statement or of a part of it."""
        for name in getattr(node, "__dataclass_fields__", ()):
            if name in skip or name in ("keyword", "kind"):
                continue
            value = getattr(node, name)
            for part in value if isinstance(value, tuple) else (value,):
                if isinstance(part, ex.Expr):
                    self._expr(part)
                elif not isinstance(part, sx.Word | Span | str | float | int | bool | None):
                    self._parts(part)

    def _table(self, s: sx.Table) -> None:
        for word in (*s.outputs, s.first, *((s.second,) if s.second is not None else ())):
            self._word(word)
        if s.condition is not None:
            self._truth(s.condition)
        self._expr(s.scale)
        columns = s.second if s.second is not None else s.first
        if s.header is not None:
            for word in s.header.terms:
                self._term(columns.text, word)
        for row in s.rows:
            if row.label is not None:
                self._term(s.first.text, row.label)
            for cell in row.cells:
                outputs = [o.text for o in s.outputs]
                for k, term in enumerate(cell.terms):
                    self._consequent(outputs[min(k, len(outputs) - 1)], term)
                self._expr(cell.weight)

    def _truth(self, truth: sx.Truth) -> None:
        match truth:
            case sx.Literal(variable=variable, hedges=hedges, term=term):
                self._word(variable)
                for hedge in hedges:
                    self._word(hedge)
                self._term(variable.text, term)
            case sx.Negation(operand=operand) | sx.Group(operand=operand):
                self._truth(operand)
            case sx.Chain(operands=operands):
                for operand in operands:
                    self._truth(operand)

    def _consequents(self, consequents: Iterable[sx.ConsequentText]) -> None:
        for consequent in consequents:
            self._word(consequent.output)
            for hedge in consequent.hedges:
                self._word(hedge)
            self._consequent(consequent.output.text, consequent.term)

    def _consequent(self, output: str, term: Any) -> None:
        match term:
            case sx.Word():
                self._term(output, term)
            case sx.HedgedTerm(hedges=hedges, term=word):
                for hedge in hedges:
                    self._word(hedge)
                self._term(output, word)
            case sx.FunctionTerm(arguments=arguments):
                for argument in arguments:
                    self._expr(argument)
            case ex.Expr():
                self._expr(term)

    def _expr(self, expr: ex.Expr | None, local: Iterable[str] = ()) -> None:
        if expr is None:
            return
        for node in ex.walk(expr):
            span = ex.span_of(node)
            if span is None:
                continue
            if isinstance(node, ex.Name) and node.name not in local:
                self._name(node.name, span)
            elif isinstance(node, ex.Call):
                self._called(node.function, span)
                callee = self.heads.get(self.scope.callees.get(node.function, node.function))
                for argument in node.arguments:
                    if isinstance(argument, ex.Keyword) and argument.span is not None and callee is not None:
                        self._at(argument.name, argument.span, callee.names)

    def _name(self, name: str, span: Span) -> None:
        """Look up a name, which may have a member behind a point, at the beginning of a location."""
        first, _, member = name.partition(".")
        self._at(first, span, self.scope.names)
        callee = self.heads.get(self.scope.callees.get(first, first))
        if member and callee is not None:
            at = span.start + len(first) + 1
            self._at(member, Span(span.source, at, at + len(member)), callee.own)

    def _called(self, name: str, span: Span) -> None:
        """Look up a callee: a block of the file, a function, an output in a guarantee."""
        first, _, member = name.partition(".")
        for names in (self.scope.outer, self.scope.own):
            if first in names and names[first].kind in _CALLABLE:
                self._at(first, span, names)
                break
        if member and first in self.heads:
            at = span.start + len(first) + 1
            self._at(member, Span(span.source, at, at + len(member)), self.heads[first].own)

    def _at(self, name: str, span: Span, names: Mapping[str, Symbol]) -> None:
        symbol = names.get(name)
        place = Span(span.source, span.start, span.start + len(name))
        if symbol is not None and place.text == name:
            self._used(place, symbol)

    def _word(self, word: sx.Word) -> None:
        symbol = self.scope.names.get(word.text)
        if symbol is not None:
            self._used(word.span, symbol)

    def _term(self, variable: str, word: sx.Word) -> None:
        symbol = self.scope.terms.get(variable, {}).get(word.text)
        if symbol is not None and word.text not in _NO_TERMS:
            self._used(word.span, symbol)

    def _used(self, span: Span, symbol: Symbol) -> None:
        self.symbols.uses.append((span, symbol))
