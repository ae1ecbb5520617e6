"""Names of a controller, plant or loop: its declarations, and the blocks that it calls."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence, Set
from dataclasses import field
from functools import cached_property
from itertools import chain
from typing import ClassVar, Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.suggestions import a_or_an
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.controller import EquationBlock, true_or_false
from fuzzyctl.model.stateful_operators import OPERATORS
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import dataclass
from fuzzyctl.resolve.context import Context

#: The kinds of blocks that a block may call.
Callee = FuzzySystem | EquationBlock

#: The declarations that share one set of names, by the kind of the block.
_SHARED: Final = {
    "controller": "params, inputs, states, lets, blocks and outputs",
    "plant": "params, inputs, states, lets and outputs",
    "loop": "params, blocks, lets, disturbances and measures",
}

#: Keywords of the blocks that a block may call.
CALLED: Final = frozenset({"function", "system", "controller", "plant"})

#: Finds a system, controller or plant by its name, or None.
Find = Callable[[str], Callee | None]

#: Functions of blocks besides those of all expressions, with their arguments.
FUNCTIONS: Final = {"clamp": ("x", "low", "high"), "where": ("condition", "a", "b")}


@dataclass
class Names:
    """Declared names of one block.

    Args:
        context: Where mistakes are reported.
        head: The line that begins the block.
        find: Finds the blocks that it calls.
    """

    #: The kind of the block.
    kind: ClassVar[str]
    #: Names that it has without declaring them.
    given: ClassVar[Collection[str]] = ()
    #: Functions that only such blocks have.
    own: ClassVar[Collection[str]] = ()
    #: Functions with reserved names.
    reserved: ClassVar[Collection[str]] = ()

    context: Context
    head: sx.Head
    find: Find
    named: dict[str, sx.Signal | sx.Equation] = field(default_factory=dict)
    #: Outputs of instances and of calls with several outputs, as `NAME.OUTPUT`, by the first of these names.
    members: dict[str, tuple[str, ...]] = field(default_factory=dict)
    #: Instances and calls of unknown blocks, whose outputs are unknown, too.
    lost: set[str] = field(default_factory=set)
    #: Results of earlier searches, by name.
    blocks: dict[str, Callee | None] = field(default_factory=dict)
    #: Names that were sorted last, and these in order.
    _ordered: tuple[Set[str], Sequence[str]] = (frozenset(), ())

    def declare(self, statements: Sequence[sx.Statement]) -> None:
        """Enter all names first, so that statements may come in any order."""
        self.context.named = self.named
        self.context.is_free(self.head.name, a_or_an(self.kind))
        for s in statements:
            match s:
                case sx.Param(name=name) if self._declared(name, "a param"):
                    self.context.params[name.text] = s
                case sx.Function(name=name) if self._is_new_function(name):
                    self.context.functions[name.text] = s
                case sx.Signal(name=name, keyword=keyword) if self._declared(name, a_or_an(keyword.text)):
                    self.named[name.text] = s
                case sx.Equation(name=name, keyword=keyword, value=value) if keyword.text in ("let", "block"):
                    if self._declared(name, f"a {keyword.text}"):
                        self.named[name.text] = s
                        self._declare_members(name.text, value)
        equations = ((name, s) for name, s in self.named.items() if isinstance(s, sx.Equation))
        self.lost = {name for name, s in equations if self._is_lost(s)}

    def _declared(self, word: sx.Word, what: str) -> bool:
        if word.text in self.given or word.text in self.reserved or word.text in FUNCTIONS:
            message = f"'{word.text}' is a word of {self.kind}s and cannot name {what}"
            self.context.report("FZ201", message, word.span, help="rename it")
            self.context.unread |= {word.text}
            return False
        return self.context.declare(word, what, _SHARED[self.kind])

    def _is_new_function(self, word: sx.Word) -> bool:
        is_known = any(word.text in names for names in (ex.FUNCTIONS, self.own, FUNCTIONS, OPERATORS))
        earlier = self.context.functions.get(word.text)
        if not is_known and earlier is None:
            return True
        note = (earlier.name.span, "first declared here") if earlier is not None else None
        self.context.report(
            "FZ201", f"there is a function '{word.text}' already", word.span, note=note, help="rename it"
        )
        return False

    def _declare_members(self, name: str, value: ex.Expr) -> None:
        block = self.found(value.function) if isinstance(value, ex.Call) else None
        if block is not None and (block.kind != "system" or len(block.outputs) > 1):
            self.members[name] = tuple(f"{name}.{o.name}" for o in block.outputs)
        if isinstance(block, EquationBlock):
            outputs = [f"{name}.{output}" for output in true_or_false(block)]
            self.context.conditions |= {o: ex.Compare(">", ex.Name(o), ex.ZERO) for o in outputs}

    def _is_lost(self, s: sx.Equation) -> bool:
        """Whether the value calls an unknown block, or one with mistakes; a `block` line may lack its call."""
        value = s.value
        if not isinstance(value, ex.Call) or self.found(value.function) is not None:
            return s.keyword.text == "block" and not isinstance(value, ex.Call)
        if s.keyword.text == "block":
            return True
        return not any(
            value.function in names for names in (ex.FUNCTIONS, self.own, FUNCTIONS, OPERATORS, self.context.functions)
        )

    def found(self, name: str) -> Callee | None:
        """Return the system, controller or plant of a name, or None."""
        if name not in self.blocks:
            is_function = name in self.context.functions or name in self.own or name in OPERATORS
            self.blocks[name] = None if is_function else self.find(name)
        return self.blocks[name]

    @cached_property
    def names(self) -> Set[str]:
        """All names that an expression may use, once all are entered."""
        return {*self.context.params, *self.named, *chain.from_iterable(self.members.values()), *self.given}

    def ordered(self, names: Set[str]) -> Sequence[str]:
        """Return names in alphabetical order, as messages list them; the same names again are not sorted anew."""
        if names is not self._ordered[0]:
            self._ordered = names, sorted(names)
        return self._ordered[1]

    def what(self, name: str) -> str:
        """Return the kind of a name, such as "a param"; empty for an unknown name."""
        if name in self.context.params:
            return "a param"
        return a_or_an(self.named[name].keyword.text) if name in self.named else ""
