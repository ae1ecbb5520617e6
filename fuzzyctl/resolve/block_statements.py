"""Statements that controllers, plants and loops share: params, functions, signals and definitions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fuzzyctl.diagnostics.fixes import respelt_as_suggested
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.block import Node, Param
from fuzzyctl.model.controller import Definition, Function, Result, Signal, State
from fuzzyctl.resolve.block_expressions import PARAMETERS, Expressions
from fuzzyctl.resolve.variables import resolve_bounds


class Statements(Expressions):
    """Resolution of the statements of a block, each to a part of the model.

    Attributes:
        incomplete: Whether some part has no meaning, perhaps through a mistake elsewhere.
    """

    incomplete = False

    def parts(self, statements: Sequence[sx.Statement]) -> dict[str, tuple[Any, ...]]:
        """Return the parts of the model by the keyword of their statement; those without a meaning are reported."""
        results: dict[str, list[Node | None]] = {}
        for s in statements:
            match s:
                case sx.Param(name=name) if self.context.params.get(name.text) is s:
                    results.setdefault("param", []).append(self._param(s))
                case sx.Function(name=name) if self.context.functions.get(name.text) is s:
                    results.setdefault("function", []).append(self._function(s))
                case sx.Signal(name=name, keyword=keyword) if self.named.get(name.text) is s:
                    results.setdefault(keyword.text, []).append(self.signal(s))
                case sx.Equation(name=name, keyword=keyword) if (
                    keyword.text in ("next", "der") or self.named.get(name.text) is s
                ):
                    results.setdefault(keyword.text, []).append(self.equation(s))
        self.incomplete = any(p is None for parts in results.values() for p in parts)
        return {key: tuple(p for p in parts if p is not None) for key, parts in results.items()}

    def shared_fields(self, statements: Sequence[sx.Statement], parts: dict[str, tuple[Any, ...]]) -> dict[str, Any]:
        """Return the fields of the model that all blocks have."""
        return {
            "name": self.head.name.text,
            "title": self.head.title,
            "citation": "; ".join(s.text for s in statements if isinstance(s, sx.Citation)),
            "params": parts.get("param", ()),
            "functions": parts.get("function", ()),
            "definitions": parts.get("let", ()),
            "inputs": parts.get("input", ()),
            "states": parts.get("state", ()),
            "results": parts.get("output", ()),
            "span": self.head.name.span,
        } | {
            f"{kind}s": tuple(b for b in self.blocks.values() if b is not None and b.kind == kind)
            for kind in ("system", "controller", "plant")
        }

    def equation(self, s: sx.Equation) -> Node | None:
        """Resolve a `let`, `next`, `der` or `block` line."""
        return Definition(name=s.name.text, value=s.value, span=s.name.span) if self.formula(s.value) else None

    def _param(self, s: sx.Param) -> Param | None:
        fine = self.context.check_names(s.expression, self.context.params, "param")
        bounds = resolve_bounds(self.context, s.bounds)
        if not fine:
            return None
        return Param(name=s.name.text, expression=s.expression, unit=s.unit, bounds=bounds, span=s.name.span)

    def _function(self, s: sx.Function) -> Function | None:
        parameters: dict[str, None] = {}
        for word in s.parameters:
            self.context.is_free(word, "a parameter")
            if word.text in parameters:
                self.context.report("FZ201", f"parameter '{word.text}' is given twice", word.span, help="rename one")
            parameters[word.text] = None
        names = {*parameters, *self.context.params}
        if not self.formula(s.expression, names=names, kind=PARAMETERS, pure=True):
            return None
        return Function(name=s.name.text, parameters=tuple(parameters), expression=s.expression, span=s.name.span)

    def signal(self, s: sx.Signal) -> Node | None:
        """Resolve an `input`, `state` or `output` line."""
        shared: dict[str, Any] = {
            "name": s.name.text,
            "label": s.label,
            "unit": s.unit,
            "bounds": resolve_bounds(self.context, s.bounds),
            "span": s.name.span,
        }
        if s.value is None:
            return Signal(**shared)
        if s.keyword.text == "state":
            fine = self.context.check_names(s.value, self.context.params, "param")
            return State(**shared, start=s.value) if fine else None
        return Result(**shared, value=s.value) if self.formula(s.value) else None

    def require_outputs(self, statements: Sequence[sx.Statement]) -> None:
        """Report a block without outputs."""
        has_outputs = any(isinstance(s, sx.Signal) and s.keyword.text == "output" for s in statements)
        if not has_outputs and "output" not in self.context.unread:
            message = f"{self.kind} '{self.head.name.text}' has no outputs"
            self.context.report("FZ212", message, self.head.name.span, help="add an 'output NAME = EXPRESSION' line")

    def require_updates(self, statements: Sequence[sx.Statement], keyword: str, what: str) -> None:
        """Check that each state has its next value or derivative, once, and that no other name has one."""
        states = {n: s for n, s in self.named.items() if isinstance(s, sx.Signal) and s.keyword.text == "state"}
        updates: dict[str, sx.Equation] = {}
        for s in statements:
            if not (isinstance(s, sx.Equation) and s.keyword.text == keyword):
                continue
            name = s.name.text
            if name not in states and (name in self.context.unread or "state" in self.context.nameless):
                self.incomplete = True
            elif name not in states:
                description = self.what(name)
                facts = (
                    (f"'{name}' is {description}",)
                    if description
                    else (f"states: {listed(list(states))}" if states else "there is no state",)
                )
                new = f"only a state has a {what}: declare one with another name" if description else ""
                help_text = did_you_mean(name, list(states)) or new or f"declare it: state {name} = START"
                fix = respelt_as_suggested(s.name.span, name, list(states))
                self.context.report("FZ202", f"no state '{name}'", s.name.span, facts=facts, help=help_text, fix=fix)
            elif name in updates:
                note = (updates[name].span, "first given here")
                self.context.report("FZ215", f"the {what} of '{name}' is given twice", s.span, note=note)
            updates.setdefault(name, s)
        self.incomplete = self.incomplete or not states.keys() <= updates.keys()
        for name, state in states.items():
            if name not in updates and name not in self.context.unread and keyword not in self.context.nameless:
                help_text = f"add: {keyword} {name} = EXPRESSION"
                message = f"state '{name}' has no '{keyword}' line"
                self.context.report("FZ212", message, state.name.span, help=help_text)
