"""`fuzzyctl explain`: what a diagnostic code means, with a mistake, its message and the repair."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import click

from fuzzyctl.cli.common import DONE, FORMAT, answers_with_diagnostics, use_color
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.diagnostics.diagnostic import CODES
from fuzzyctl.diagnostics.suggestions import did_you_mean
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


@click.command()
@click.argument("code", required=False)
@FORMAT
@answers_with_diagnostics
def explain(code: str | None, form: str) -> int:
    """Explain a diagnostic code, with or without its letters, or list all of them.

    \b
    fuzzyctl explain FZ203
    """
    if code is None:
        _list(form)
        return DONE
    name = f"FZ{code:0>3}" if code.isdecimal() and code.isascii() else code.upper()
    if name not in CODES:
        same = f"FZ{re.sub('[^0-9]', '', code):0>3}"
        near = f"did you mean '{same}'?" if same in CODES else did_you_mean(name, CODES)
        hint = near or "'fuzzyctl explain' lists the codes"
        raise click.BadParameter(f"no diagnostic code '{code}'; {hint}", param_hint="CODE")
    page = read_page(name)
    if form == "json":
        data = {"code": name, "title": CODES[name], "page": page.markdown if page else None}
        write_json(data)
    elif page is None:
        say(f"{name}: {CODES[name]}\n\nThe pages that explain the codes are missing from this installation.")
    else:
        click.echo(page.laid_out(color=use_color(sys.stdout)), nl=False, file=sys.stdout)
    return DONE


def _list(form: str) -> None:
    if form == "json":
        codes = [{"code": code, "title": title} for code, title in CODES.items()]
        write_json({"codes": codes})
        return
    for code, title in CODES.items():
        say(f"{code}  {title}")
