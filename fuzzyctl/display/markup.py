"""HTML of notebooks: tables, pictures, light and dark; every text is escaped, and there is no script."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any, Final

from fuzzyctl.diagnostics.terminal import printable

#: Most rows of a table; the others are counted.
ROWS: Final = 60

_LIGHT: Final = """--text: #1a1a1a; --back: #ffffff; --line: #c8c8c8; --head: #f0f0f0; --note: #555555;
  --turn: none;"""
_DARK: Final = """--text: #e8e8e8; --back: #1c1c1c; --line: #505050; --head: #2c2c2c; --note: #b0b0b0;
  --turn: invert(0.89) hue-rotate(180deg);"""
#: The theme of Jupyter, VS Code or a page around it comes before that of the machine.
_THEMES: Final = tuple(
    f":is(body[data-jp-theme-light={is_light}], html[theme={name}], [data-theme={name}], body.vscode-{name})"
    for name, is_light in (("light", "true"), ("dark", "false"))
)
#: Background and text of one part, so that it can be read whatever the notebook around it looks like. Selectors name
#: the class twice, so that they come before those of Jupyter, which turns the texts of tables to the right.
_STYLE: Final = f"""<style>
.fuzzyctl {{ {_LIGHT} }}
@media (prefers-color-scheme: dark) {{ .fuzzyctl {{ {_DARK} }} }}
{_THEMES[0]} .fuzzyctl {{ {_LIGHT} }}
{_THEMES[1]} .fuzzyctl {{ {_DARK} }}
.fuzzyctl {{ color: var(--text); background: var(--back); padding: 0.6em 0.8em; max-width: 60em; overflow-x: auto; }}
.fuzzyctl.fuzzyctl table {{ border-collapse: collapse; margin: 0.3em 0 0.8em 0; color: inherit; }}
.fuzzyctl.fuzzyctl caption {{ text-align: left; font-weight: bold; white-space: nowrap; padding: 0.2em 0;
  color: inherit; }}
.fuzzyctl.fuzzyctl table tr {{ background: transparent; }}
.fuzzyctl.fuzzyctl table th, .fuzzyctl.fuzzyctl table td {{ border: 1px solid var(--line); padding: 0.2em 0.6em;
  text-align: left; vertical-align: top; color: inherit; background: transparent; }}
.fuzzyctl.fuzzyctl table th {{ background: var(--head); font-weight: bold; }}
.fuzzyctl p {{ margin: 0.3em 0; color: inherit; }}
.fuzzyctl .title {{ font-weight: bold; font-size: 1.1em; }}
.fuzzyctl .note {{ color: var(--note); }}
.fuzzyctl img {{ max-width: 100%; background: #ffffff; }}
.fuzzyctl img.lines {{ max-width: none; filter: var(--turn); }}
</style>"""


class Markup(str):
    """A text that is HTML already."""

    __slots__ = ()


def plain(text: object) -> Markup:
    """Return a text as HTML that shows its characters: nothing in it is markup, and control characters are visible."""
    if isinstance(text, Markup):
        return text
    return Markup(escape(printable(str(text)), quote=True))


def page(title: str, *parts: Markup) -> str:
    """Return a page for a notebook: a title and the parts that are not empty."""
    body = "\n".join(p for p in (paragraph(title, "title"), *parts) if p)
    return f'{_STYLE}\n<div class="fuzzyctl">\n{body}\n</div>'


def paragraph(text: object, kind: str = "") -> Markup:
    """Return a paragraph, nothing for an empty text."""
    attribute = f' class="{kind}"' if kind else ""
    return Markup(f"<p{attribute}>{plain(text)}</p>") if text else Markup("")


def table(
    caption: str, header: Sequence[object], rows: Iterable[Sequence[object]], *, headed_rows: bool = True
) -> Markup:
    """Return a table, nothing for one without rows.

    Args:
        caption: Its caption; may be empty.
        header: Of the columns; empty for none.
        rows: Each with its cells.
        headed_rows: Whether the first cell of a row is its heading.
    """
    all_rows = list(rows)
    if not all_rows:
        return Markup("")
    lines = [f"<table><caption>{plain(caption)}</caption>" if caption else "<table>"]
    if header:
        lines.append(f"<thead><tr>{''.join(_cell('th', h, 'col') for h in header)}</tr></thead>")
    lines.append("<tbody>")
    for first, *rest in all_rows[:ROWS]:
        head = _cell("th", first, "row") if headed_rows else _cell("td", first)
        lines.append(f"<tr>{head}{''.join(_cell('td', c) for c in rest)}</tr>")
    lines.append("</tbody></table>")
    if len(all_rows) > ROWS:
        lines.append(paragraph(f"and {len(all_rows) - ROWS} more", "note"))
    return Markup("\n".join(lines))


def pairs(caption: str, facts: Mapping[str, object]) -> Markup:
    """Return a table of names and values."""
    return table(caption, (), list(facts.items()))


def lines(texts: Iterable[object]) -> Markup:
    """Return texts below each other, for a cell."""
    return Markup("<br>".join(map(plain, texts)))


def picture_svg(text: str, what: str) -> Markup:
    """Return a picture of lines, which is turned dark where the notebook is."""
    return _image("image/svg+xml", text.encode(), what, ' class="lines"')


def picture_png(content: bytes, what: str) -> Markup:
    """Return a picture whose colours say something, which stays as it is."""
    return _image("image/png", content, what, "")


def _image(kind: str, content: bytes, what: str, attribute: str) -> Markup:
    # As an image, nothing within it is executed.
    data = base64.b64encode(content).decode("ascii")
    return Markup(f'<img{attribute} alt="{plain(what)}" src="data:{kind};base64,{data}">')


def _cell(tag: str, content: Any, scope: str = "") -> str:
    attribute = f' scope="{scope}"' if scope else ""
    return f"<{tag}{attribute}>{plain(content)}</{tag}>"
