"""One version of a rule file that is open in an editor: its tree, symbols and diagnostics, each computed once."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.editor.symbols import Symbols, symbols_of
from fuzzyctl.lang.lines import LogicalLine, split
from fuzzyctl.lang.parser import parse
from fuzzyctl.lang.syntax import SyntaxTree, Use
from fuzzyctl.loading.assembly import bring_in
from fuzzyctl.loading.load import Examined, look_through
from fuzzyctl.support.files import is_below, overlaid, read_source

if TYPE_CHECKING:
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.model.system import FuzzySystem


@lru_cache(maxsize=32)
def _symbols_of_used(source: SourceText) -> Symbols:
    return symbols_of(parse(source)[0])


@dataclass(frozen=True)
class Document:
    """A text at one moment.

    Args:
        source: The text, under the path of its file.
        folder: Where the files stand that it uses; None for a text without a file.
        buffers: Texts that editors have not saved, by absolute path: what `use` reads in place of the files.
        characters: How many the text has where it is too large to be read, and `source` is empty; else 0.
        verdicts: The verdicts so far, by the offset of the line and the name of the block.
        bounds: Proved bounds of outputs so far, by system and output.
    """

    source: SourceText
    folder: Path | None = None
    buffers: Mapping[str, str] = field(default_factory=dict, repr=False)
    characters: int = 0
    verdicts: dict[tuple[int, str], Verdict] = field(default_factory=dict, init=False, compare=False, repr=False)
    bounds: dict[tuple[str, str], tuple[float, float]] = field(
        default_factory=dict, init=False, compare=False, repr=False
    )

    @property
    def text(self) -> str:
        """The characters."""
        return self.source.text

    @cached_property
    def parsed(self) -> tuple[SyntaxTree, list[Diagnostic]]:
        """The statements of the text alone, with its mistakes."""
        return parse(self.source)

    @cached_property
    def tree(self) -> SyntaxTree:
        """The statements that could be read, those of used files brought in."""
        with overlaid(self.buffers):
            return bring_in(self.parsed[0], self.folder)[0]

    @cached_property
    def symbols(self) -> Symbols:
        """Names with their declarations and uses."""
        with overlaid(self.buffers):
            return symbols_of(self.tree, [_symbols_of_used(s) for s in self._used_sources()])

    def _used_sources(self) -> Iterator[SourceText]:
        """Yield the files that `use` names, as far as they may be read; others are mistakes."""
        if self.folder is None:
            return
        for name in (s.path for s in self.tree.statements if isinstance(s, Use)):
            path = self.folder / name
            if is_below(path, self.folder):
                try:
                    yield read_source(path, only_regular=True)
                except DiagnosticError:
                    continue

    @cached_property
    def lines(self) -> list[LogicalLine]:
        """The logical lines that are not blank."""
        return [line for line in split(self.source) if line.kind != "blank"]

    @cached_property
    def examined(self) -> Examined:
        """Blocks and mistakes, as far as no proof is needed."""
        with overlaid(self.buffers):
            return look_through(self.source, folder=self.folder, parsed=self.parsed)

    @cached_property
    def mistakes(self) -> list[Diagnostic]:
        """Diagnostics without proofs, by location, which can be shown immediately."""
        return self.examined.reported(self.examined.diagnostics)

    @property
    def mistakes_stop_proofs(self) -> bool:
        """Whether there are errors, so that the text has no proofs."""
        return any(d.severity == "error" for d in self.mistakes)

    @property
    def used(self) -> frozenset[str]:
        """Absolute paths of the rule files that are brought in."""
        named = [s.path for s in self.tree.statements if isinstance(s, Use)] if self.folder is not None else []
        read = {s.span.source.name for s in self.tree.used}
        return frozenset(os.path.abspath(p) for p in [*read, *(os.path.join(self.folder or "", n) for n in named)])

    @cached_property
    def proved(self) -> list[Diagnostic]:
        """All diagnostics, also those that need a proof, which can be shown a moment later."""
        from fuzzyctl.analysis.check import check_examined

        return check_examined(self.examined)[1]

    def system_at(self, offset: int) -> FuzzySystem | None:
        """Return the system whose block holds an offset, the first one where no block does; None where it has mistakes.

        Raises:
            DiagnosticError: Where the text cannot be examined at all.
        """
        head = self.symbols.scope_at(offset)[1]
        named = head.name if head is not None and head.kind == "system" else None
        return next((s for s in self.examined.systems if named in (None, s.name)), None)

    def text_before(self, offset: int) -> str:
        """Return the text before an offset on its line."""
        return self.text[self.text.rfind("\n", 0, offset) + 1 : offset]
