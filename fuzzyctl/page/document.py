"""The text of a page: facts as data, the generated JavaScript, and the scripts that show them, without requests."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

from fuzzyctl import __version__
from fuzzyctl.analysis.verdicts import Verdict
from fuzzyctl.analysis.work import written
from fuzzyctl.codegen import javascript_parts, javascript_source
from fuzzyctl.codegen.javascript_source import JavaScriptLayout
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.page.blocks import controller_data
from fuzzyctl.page.systems import SystemFacts
from fuzzyctl.plot.style import COLORS

#: The scripts in their order: what later ones call stands before them.
SCRIPTS: Final = (
    *("plots.js", "panels.js", "inputs.js", "surface.js", "rules.js", "system.js", "controller.js", "loop.js"),
    "page.js",
)
#: Scripts of tables and panels of lines, for pages of other programs.
PANELS: Final = ("plots.js", "panels.js")
#: The last ones: of a page that stays as it is, and of one that gets new texts.
STILL: Final = ("still.js",)
LIVE: Final = ("files.js", "live.js")
#: Operations for a term that is shown, with its degree.
_SHOWN: Final = 6
#: What would end a script early, or begin another one within it.
_ENDS: Final = re.compile(r"</script|<script|<!--", re.IGNORECASE)


@dataclass(frozen=True)
class Section:
    """One block of a file on a page.

    Args:
        data: Its data.
        script: The expression in JavaScript that computes it; `null` if it was computed before.
    """

    data: dict[str, Any]
    script: str = "null"


def require_size(system: FuzzySystem) -> None:
    """Refuse a system that takes more operations than a page computes with, before anything is computed.

    Raises:
        CodegenError: If it is too large.
    """
    terms = sum(len(v.terms) for v in (*system.inputs, *system.lets, *system.outputs))
    javascript_source.require_size(written(plan(system)) + _SHOWN * terms)


def unit_section(unit: Unit, verdicts: Sequence[Verdict], rows: Mapping[str, Any]) -> Section:
    """Return the section of a block.

    Args:
        unit: The block.
        verdicts: Of its claims.
        rows: The rows of proofs.

    Raises:
        CodegenError: For a block that JavaScript cannot compute.
    """
    if unit.is_step:
        return controller_section({**controller_data(unit), **rows}, unit)
    return system_section(SystemFacts(unit, verdicts))


def system_section(facts: SystemFacts) -> Section:
    """Return the section of a system.

    Raises:
        CodegenError: For a system that JavaScript cannot compute.
    """
    unit: Unit = facts.unit
    require_size(unit.system)
    data, name = facts.data(), JavaScriptLayout(unit).name
    start = f"system.{name}_init" if data["state"] else "null"
    call = f"evaluate: system.{name}, start: {start}"
    modules = (("system", javascript_source.module(unit)), ("parts", javascript_parts.module(unit, facts.shown)))
    return Section(data, _expression(modules, f"{call}, ...parts"))


def controller_section(data: dict[str, Any], unit: Unit) -> Section:
    """Return the section of a controller.

    Raises:
        CodegenError: For a controller that JavaScript cannot compute.
    """
    layout = JavaScriptLayout(unit)
    start = f"system.{layout.name}_init" if layout.has_state else "null"
    call = f"step: system.{layout.function}, start: {start}"
    return Section(data, _expression([("system", javascript_source.module(unit))], call))


def _expression(modules: Sequence[tuple[str, str]], result: str) -> str:
    """Return modules as functions that are called at once, with the names that they export."""
    lines = ["(() => {"]
    for name, text in modules:
        exported = re.findall(r"^export (?:function|const|class) (\w+)", text, re.MULTILINE)
        plain = re.sub(r"^export ", "", text, flags=re.MULTILINE)
        lines += [f"const {name} = (() => {{", plain + f"return {{ {', '.join(exported)} }};", "})();"]
    return "\n".join([*lines, f"return {{ {result} }};", "})()"])


def page_title(blocks: Sequence[str], file: str) -> str:
    """Return the title of a page: that of its only block, else the name of the file.

    Args:
        blocks: Titles of the blocks that it shows, or names of those without one.
        file: The name of the file without its suffix.
    """
    return blocks[0] if len(blocks) == 1 else file


def document(title: str, sections: Sequence[Section], diagnostics: Sequence[Diagnostic]) -> str:
    """Return the whole page.

    Args:
        title: Of the window.
        sections: Its blocks.
        diagnostics: Warnings and hints of the file.
    """
    return _html(title, page_facts(title, sections, diagnostics), page_script(sections), STILL, "")


def live_document(nonce: str) -> str:
    """Return a page without a text; messages to its window bring `page_facts` and `page_script`, see `live.js`.

    Args:
        nonce: The nonce of scripts that come later: letters, digits and "-" that cannot be guessed.
    """
    assert re.fullmatch(r"[A-Za-z0-9-]+", nonce), "the nonce ends early"
    return _html("", page_facts("", [], []), "", LIVE, f" 'nonce-{nonce}'")


def page_facts(title: str, sections: Sequence[Section], diagnostics: Sequence[Diagnostic]) -> dict[str, Any]:
    """Return the facts of a page as plain data; control characters are visible."""
    facts = {
        "title": title,
        "version": __version__,
        "colors": list(COLORS),
        "sections": [s.data for s in sections],
        "diagnostics": [
            {
                "severity": d.severity,
                "code": d.code,
                "message": d.message,
                "place": "" if d.span is None else f"{Path(d.span.source.name).name}:{d.span.line}",
                "facts": list(d.explanations),
                "help": d.help,
            }
            for d in diagnostics
        ],
    }
    data: dict[str, Any] = _visible(facts)
    return data


def page_script(sections: Sequence[Section]) -> str:
    """Return the script that computes the numbers of a page."""
    kernels = ",\n".join(s.script for s in sections)
    return f'"use strict";\nvar kernels = [\n{kernels}\n];\n'


def _html(title: str, facts: dict[str, Any], computing: str, last: Sequence[str], nonce: str) -> str:
    body = '<main id="page"><noscript>This page computes with JavaScript, which is switched off.</noscript></main>'
    showing = enclosed(*map(asset, (*SCRIPTS, *last)))
    return html_document(title, body, facts, (computing, showing), asset("page.css"), nonce=nonce)


def enclosed(*scripts: str) -> str:
    """Return scripts as one whose names are its own."""
    return '"use strict";\n(() => {\n' + "\n".join(scripts) + "})();\n"


def html_document(title: str, body: str, facts: object, scripts: Sequence[str], style: str, *, nonce: str = "") -> str:
    """Return a document that loads nothing and runs its own scripts only.

    Args:
        title: Of the window.
        body: Its markup.
        facts: The data of the scripts.
        scripts: The scripts, in order.
        style: The style sheet.
        nonce: The nonce of scripts that come later, as a source of the policy; may be empty.
    """
    for part in (*scripts, style):
        assert _ENDS.search(part) is None, "a script ends before its end"
    allowed = " ".join(map(_hash, scripts)) + nonce
    policy = f"default-src 'none'; script-src {allowed}; style-src {_hash(style)}; img-src data:; base-uri 'none'"
    policy += "; form-action 'none'"
    executed = "\n".join(f"<script>{part}</script>" for part in scripts)
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{escape(printable(title))}</title>
<style>{style}</style>
</head>
<body>
{body}
<script type="application/json" id="facts">{_json(facts)}</script>
{executed}
</body>
</html>
"""


def asset(name: str) -> str:
    """Return the text of a file in `assets`."""
    return files("fuzzyctl.page").joinpath("assets", name).read_text(encoding="utf-8")


def _hash(content: str) -> str:
    digest = hashlib.sha256(content.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


def _json(facts: object) -> str:
    """Return data as JSON in ASCII in which no tag begins."""
    return json.dumps(facts, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _visible(value: Any) -> Any:
    if isinstance(value, str):
        return printable(value)
    if isinstance(value, dict):
        return {key: _visible(item) for key, item in value.items()}
    return [_visible(item) for item in value] if isinstance(value, list | tuple) else value
