"""One version of a rule file that is open in an editor: its tree, symbols and diagnostics, each computed once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.editor.symbols import Symbols, symbols_of
from fuzzyctl.lang.lines import LogicalLine, split
from fuzzyctl.lang.parser import parse
from fuzzyctl.lang.syntax import SyntaxTree
from fuzzyctl.loading.assembly import bring_in
from fuzzyctl.loading.load import Examined, look_through


@dataclass(frozen=True)
class Document:
    """A text at one moment.

    Args:
        source: The text, under the path of its file.
        folder: Where the files stand that it uses; None for a text without a file.
    """

    source: SourceText
    folder: Path | None = None

    @property
    def text(self) -> str:
        """The characters."""
        return self.source.text

    @cached_property
    def tree(self) -> SyntaxTree:
        """The statements that could be read, those of used files brought in."""
        return bring_in(parse(self.source)[0], self.folder)[0]

    @cached_property
    def symbols(self) -> Symbols:
        """Names with their declarations and uses."""
        return symbols_of(self.tree)

    @cached_property
    def lines(self) -> list[LogicalLine]:
        """The logical lines that are not blank."""
        return [line for line in split(self.source) if line.kind != "blank"]

    @cached_property
    def examined(self) -> Examined:
        """Blocks and mistakes, as far as no proof is needed."""
        return look_through(self.source, folder=self.folder)

    @cached_property
    def mistakes(self) -> list[Diagnostic]:
        """Diagnostics without proofs, by location: what can be shown at once."""
        return self.examined.reported(self.examined.diagnostics)

    @cached_property
    def proved(self) -> list[Diagnostic]:
        """All diagnostics, those among them that need a proof: what can be shown a moment later."""
        from fuzzyctl.analysis.check import check_examined

        return check_examined(self.examined)[1]

    def line_at(self, offset: int) -> LogicalLine | None:
        """Return the last logical line that begins at an offset or before it."""
        found = None
        for line in self.lines:
            if line.start > offset:
                break
            found = line
        return found

    def text_before(self, offset: int) -> str:
        """Return what stands before an offset on its line."""
        return self.text[self.text.rfind("\n", 0, offset) + 1 : offset]
