"""Machine-readable diagnostics: SARIF 2.1.0, workflow commands for GitHub's annotations, plain JSON; pages of codes."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import fuzzyctl
from fuzzyctl.cli.streams import json_text
from fuzzyctl.diagnostics.diagnostic import CODES, Diagnostic
from fuzzyctl.diagnostics.fixes import Fix
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.support.files import explanations_folder

#: Where SARIF 2.1.0 is defined; viewers tell versions apart by it.
SARIF_SCHEMA: Final = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"

#: What SARIF and GitHub call a severity.
_LEVELS: Final = {"error": "error", "warning": "warning", "hint": "note"}
_COMMANDS: Final = {"error": "error", "warning": "warning", "hint": "notice"}


def as_json(diagnostics: Sequence[Diagnostic]) -> str:
    """Return diagnostics as a JSON document."""
    return json_text({"diagnostics": [d.as_dict() for d in diagnostics]})


def as_sarif(diagnostics: Sequence[Diagnostic]) -> str:
    """Return diagnostics as a SARIF log with one run; columns count UTF-16 units, files are relative to this folder."""
    codes = sorted({d.code for d in diagnostics})
    driver = {
        "name": "fuzzyctl",
        "semanticVersion": fuzzyctl.__version__,
        "rules": [_rule(code) for code in codes],
    }
    run = {
        "tool": {"driver": driver},
        "columnKind": "utf16CodeUnits",
        "results": [_result(d, codes.index(d.code)) for d in diagnostics],
    }
    return json_text({"$schema": SARIF_SCHEMA, "version": "2.1.0", "runs": [run]})


def as_github(diagnostics: Sequence[Diagnostic]) -> str:
    """Return diagnostics as GitHub workflow commands, one a line."""
    return "\n".join(_command(d) for d in diagnostics)


def _rule(code: str) -> dict[str, Any]:
    rule: dict[str, Any] = {"id": code, "shortDescription": {"text": CODES[code]}}
    page = read_page(code)
    if page is not None:
        rule["fullDescription"] = {"text": page.meaning}
        rule["help"] = {"text": page.laid_out(), "markdown": page.markdown}
    return rule


def _result(d: Diagnostic, index: int) -> dict[str, Any]:
    result: dict[str, Any] = {
        "ruleId": d.code,
        "ruleIndex": index,
        "level": _LEVELS[d.severity],
        "message": {"text": _text(d)},
    }
    if d.span is not None:
        result["locations"] = [{"physicalLocation": _location(d.span)}]
    elif d.file:
        result["locations"] = [{"physicalLocation": {"artifactLocation": {"uri": _uri(d.file)}}}]
    if d.fix is not None:
        result["fixes"] = [_sarif_fix(d.fix)]
    if d.notes:
        result["relatedLocations"] = [
            {"id": i, "physicalLocation": _location(n.span), "message": {"text": n.message}}
            for i, n in enumerate(d.notes)
        ]
    return result


def _sarif_fix(fix: Fix) -> dict[str, Any]:
    """Return a fix by the files that it changes; likely ones say so."""
    sources = dict.fromkeys(r.span.source for r in fix.replacements)
    changes = [
        {
            "artifactLocation": {"uri": _uri(source.name)},
            "replacements": [
                {"deletedRegion": _location(r.span)["region"], "insertedContent": {"text": r.text}}
                for r in fix.replacements
                if r.span.source == source
            ],
        }
        for source in sources
    ]
    return {"description": {"text": f"{fix.applicability} fix"}, "artifactChanges": changes}


def _location(span: Span) -> dict[str, Any]:
    line, column, end_line, end_column = _region(span)
    region = {"startLine": line, "startColumn": column, "endLine": end_line, "endColumn": end_column}
    return {"artifactLocation": {"uri": _uri(span.source.name)}, "region": region}


def _region(span: Span) -> tuple[int, int, int, int]:
    """Return first line and column and last line and column behind it, in UTF-16 units from 1."""
    source, end = span.source, max(span.start, span.end)
    return (
        span.line,
        source.utf16_column_of(span.start) + 1,
        source.line_of(end),
        source.utf16_column_of(end) + 1,
    )


def _text(d: Diagnostic) -> str:
    text = "\n".join([d.message, *d.facts, *([f"help: {d.help}"] if d.help else [])])
    return "\n".join(map(printable, text.split("\n")))


def _uri(name: str) -> str:
    """Return a file's name as a URI, relative to the current folder where it lies below it."""
    from urllib.parse import quote

    if not name or name.startswith("<"):
        return quote(name.strip("<>"))
    path = Path(os.path.abspath(name))
    here = Path.cwd()
    return quote(path.relative_to(here).as_posix()) if path.is_relative_to(here) else path.as_uri()


def _command(d: Diagnostic) -> str:
    properties: dict[str, object] = {}
    if d.span is not None:
        line, column, end_line, end_column = _region(d.span)
        properties = {"file": _shown_file(d.span.source.name), "line": line, "endLine": end_line, "col": column}
        if line == end_line:
            # GitHub refuses columns of ranges that span lines; endColumn is the last column, not the one behind it.
            properties["endColumn"] = max(column, end_column - 1)
    elif d.file:
        properties["file"] = _shown_file(d.file)
    properties["title"] = f"{d.code}: {CODES[d.code]}"
    listed = ",".join(f"{key}={_escaped_property(str(value))}" for key, value in properties.items())
    return f"::{_COMMANDS[d.severity]} {listed}::{_escaped(_text(d))}"


def _shown_file(name: str) -> str:
    """Return a path relative to the current folder, as GitHub wants it, where the file lies below it."""
    path, here = Path(os.path.abspath(name)), Path.cwd()
    return path.relative_to(here).as_posix() if not name.startswith("<") and path.is_relative_to(here) else name


def _escaped(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _escaped_property(text: str) -> str:
    return _escaped(text).replace(":", "%3A").replace(",", "%2C")


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
        """Yield each line with its kind: `heading`, `text` or `code`; fences and comments are left out."""
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
    """Return the page of a code, None if it or all pages are missing."""
    folder = explanations_folder()
    path = folder / f"{code}.md" if folder is not None else None
    if path is None or not path.is_file():
        return None
    return Page(code, path.read_text(encoding="utf-8"))
