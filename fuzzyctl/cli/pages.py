"""The pages that explain diagnostic codes: found, read, and laid out for a terminal."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from fuzzyctl.support.shipped import explanations_folder


@dataclass(frozen=True)
class Page:
    """One page of docs/reference/diagnostics/.

    Args:
        code: The diagnostic code.
        markdown: The page as written.
    """

    code: str
    markdown: str

    @cached_property
    def meaning(self) -> str:
        """The first paragraph below the title, on one line."""
        return " ".join(self.markdown.split("\n\n")[1].split())

    def lines(self) -> Iterator[tuple[str, str]]:
        """Yield each line with what it is: `heading`, `text` or `code`; fences and comments are left out."""
        inside = False
        # A link may go on in the next line.
        text = re.sub(r"\[([^\]]+)\]\([^)\s]+\.md[^)\s]*\)", r"\1", self.markdown)
        for line in text.rstrip("\n").split("\n"):
            if line.startswith("```"):
                inside = not inside
            elif inside:
                yield "code", f"    {line}".rstrip()
            elif line.startswith("#"):
                yield "heading", line.lstrip("# ")
            elif not line.startswith("<!--"):
                yield "text", line

    def laid_out(self, *, color: bool = False) -> str:
        """Return the page without its marks: code is indented, links are their words; headings are bold in colour."""
        text = "\n".join(
            f"\x1b[1m{line}\x1b[0m" if color and kind == "heading" else line for kind, line in self.lines()
        )
        return re.sub(r"\n{3,}", "\n\n", text) + "\n"


def read_page(code: str) -> Page | None:
    """Return the page of a code, None where there is none or the installation holds no pages."""
    folder = explanations_folder()
    path = folder / f"{code}.md" if folder is not None else None
    if path is None or not path.is_file():
        return None
    return Page(code, path.read_text(encoding="utf-8"))
