"""SVG of what a command prints: text that can be selected and searched, light or dark as the page is."""

from __future__ import annotations

import re
from html import escape

#: Size of a letter and of the space around the text [pixels].
WIDE, HIGH, ROOM = 8.43, 19, 14
STYLE = """
text { font: 14px ui-monospace, SFMono-Regular, Menlo, Consolas, "DejaVu Sans Mono", monospace;
  fill: #1a1a1a; white-space: pre; }
rect { fill: #f6f8fa; stroke: #c8c8c8; } .command { font-weight: bold; } .error { fill: #b3202c; font-weight: bold; }
.warning { fill: #805500; font-weight: bold; } .help { fill: #00664b; } .dim { fill: #57606a; }
@media (prefers-color-scheme: dark) { text { fill: #e6e6e6; } rect { fill: #16191d; stroke: #444; }
.error { fill: #ff8a85; } .warning { fill: #f0c060; } .help { fill: #6fd3a8; } .dim { fill: #a0a8b0; } }"""
#: What is coloured in a line, in this order.
PARTS = re.compile(
    r"(?P<error>\berror\[FZ\d+\]:|^ +\| +\^+)|(?P<warning>\bwarning\[FZ\d+\]:)|(?P<help>^ += help:.*)|(?P<dim>^ += .*)"
)


def picture_of(command: str, printed: str) -> str:
    """Return a command with what it prints, as SVG."""
    lines = printed.rstrip("\n").split("\n")
    rows = [f'<tspan class="command">$ {escape(command)}</tspan>', *map(_coloured, lines)]
    width = ROOM * 2 + WIDE * max(map(len, [f"$ {command}", *lines]))
    texts = [f'<text x="{ROOM}" y="{ROOM + HIGH * k + 13}">{row}</text>' for k, row in enumerate(rows)]
    size = f'width="{width:.0f}" height="{2 * ROOM + HIGH * len(rows)}"'
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} xml:space="preserve">',
            f'<style>{STYLE}</style><rect x="0.5" y="0.5" width="99.8%" height="99.5%" rx="6"/>',
            *texts,
            "</svg>\n",
        ]
    )


def _coloured(line: str) -> str:
    text, end = "", 0
    for found in PARTS.finditer(line):
        text += escape(line[end : found.start()]) + f'<tspan class="{found.lastgroup}">{escape(found[0])}</tspan>'
        end = found.end()
    return text + escape(line[end:])
