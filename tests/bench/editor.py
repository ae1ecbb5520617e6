"""Answers of the language server: milliseconds on a file of 500 lines, and from the last key to the guarantee lights.

    python tests/bench/editor.py

All times are processor time of one thread. Prints for each answer the median and the 99th percentile over --places
places of the file; then the median time from a key to names and syntax, the wait for further keys included; then what
is computed for answers once for each version of the text: tree, symbols; then the time from the last key to the lights
of each shipped file, the rest before a proof included. Exit code 1 where an answer is above 20 ms, names and syntax
are above 30 ms, or lights above 300 ms.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[2]))

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException

from fuzzyctl.editor import session
from tests.golden.answers import OPTIONS, Case

ROOT = Path(__file__).parents[2]
LINES = 500
#: Most milliseconds for an answer, from a key to names and syntax, and from the last key to the lights.
MOST_ANSWER, MOST_NAMES, MOST_LIGHTS = 20.0, 30.0, 300.0


def renamed(case: Case, at: lsp.Position) -> Any:
    """Return the changes that give the name at a position another one; None without a name."""
    with suppress(JsonRpcException):
        return case.ask("textDocument/rename", lsp.RenameParams(case.document, at, "renamed"))


def next_lines(at: lsp.Position) -> lsp.Range:
    """Return the range of ten lines from a position on."""
    return lsp.Range(at, lsp.Position(at.line + 9, 0))


ANSWERS: dict[str, Callable[[Case, lsp.Position], Any]] = {
    "completion": lambda c, at: c.ask("textDocument/completion", lsp.CompletionParams(c.document, at)),
    "hover": lambda c, at: c.ask("textDocument/hover", lsp.HoverParams(c.document, at)),
    "signature": lambda c, at: c.ask("textDocument/signatureHelp", lsp.SignatureHelpParams(c.document, at)),
    "definition": lambda c, at: c.ask("textDocument/definition", lsp.DefinitionParams(c.document, at)),
    "references": lambda c, at: c.ask(
        "textDocument/references", lsp.ReferenceParams(lsp.ReferenceContext(True), c.document, at)
    ),
    "rename": renamed,
    "selections": lambda c, at: c.ask("textDocument/selectionRange", lsp.SelectionRangeParams(c.document, [at])),
    "code actions": lambda c, at: c.ask(
        "textDocument/codeAction", lsp.CodeActionParams(c.document, lsp.Range(at, at), lsp.CodeActionContext([]))
    ),
    "layout on type": lambda c, at: c.ask(
        "textDocument/onTypeFormatting", lsp.DocumentOnTypeFormattingParams(c.document, at, "\n", OPTIONS)
    ),
    "semantic tokens": lambda c, _: c.ask("textDocument/semanticTokens/full", lsp.SemanticTokensParams(c.document)),
    "inlay hints": lambda c, _: c.ask("textDocument/inlayHint", lsp.InlayHintParams(c.document, c.whole())),
    "code lenses": lambda c, _: c.ask("textDocument/codeLens", lsp.CodeLensParams(c.document)),
    "outline": lambda c, _: c.ask("textDocument/documentSymbol", lsp.DocumentSymbolParams(c.document)),
    "folds": lambda c, _: c.ask("textDocument/foldingRange", lsp.FoldingRangeParams(c.document)),
    "layout of a range": lambda c, at: c.ask(
        "textDocument/rangeFormatting", lsp.DocumentRangeFormattingParams(c.document, next_lines(at), OPTIONS)
    ),
}


def text_of(lines: int) -> str:
    """Return a file with a number of lines: systems as they are shipped, one after the other."""
    text = (ROOT / "rules" / "ais_reaction.fz").read_text(encoding="utf-8")
    systems = []
    while sum(s.count("\n") for s in systems) < lines:
        systems.append(text.replace("system ais_reaction", f"system ais_reaction_{len(systems)}"))
    return "".join(systems)


def milliseconds(call: Callable[[], Any]) -> float:
    """Return the processor time of a call."""
    start = time.thread_time()
    call()
    return 1e3 * (time.thread_time() - start)


def place_of(text: str, offset: int) -> lsp.Position:
    """Return an offset as a position of the protocol."""
    return lsp.Position(text.count("\n", 0, offset), offset - text.rfind("\n", 0, offset) - 1)


def answers(text: str, places: int) -> dict[str, list[float]]:
    """Return the times of each answer at random places of a text that has been checked."""
    case = Case(text)
    document = case.now
    _ = document.tree, document.symbols, document.lines, document.mistakes
    positions = [place_of(text, o) for o in random.Random(1).choices(range(len(text)), k=places)]
    found = {}
    for name, answer in ANSWERS.items():
        answer(case, positions[0])
        found[name] = sorted(milliseconds(lambda a=answer, at=at: a(case, at)) for at in positions)
    return found


def typed(text: str, versions: int = 21) -> list[float]:
    """Return the times from a key to the diagnostics of names and syntax for versions of a text, ascending."""
    documents = (Case(f"{text}# {k}\n").now for k in range(versions))
    return sorted(1e3 * session.BREATH + milliseconds(lambda d=d: d.mistakes) for d in documents)


def checked(text: str) -> dict[str, float]:
    """Return the times of what answers need once for a text, after its names and syntax."""
    document = Case(text).now
    _ = document.mistakes
    return {name: milliseconds(lambda n=name: getattr(document, n)) for name in ("tree", "symbols")}


def lit(path: Path) -> float:
    """Return the time from the last key to the lights of a file."""
    document = Case(path.read_text(encoding="utf-8"), folder=path.parent).now
    rest = 1e3 * (session.REST + session.BREATH)
    return rest + milliseconds(lambda: (document.mistakes, document.proved, session.lights.prove(document)))


def percentile(times: list[float], part: float) -> float:
    """Return a percentile of times in ascending order."""
    return times[min(len(times) - 1, int(part * len(times)))]


def main() -> int:
    """Print all times; return 1 where one is above its limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--places", type=int, default=200)
    given = parser.parse_args()
    text = text_of(LINES)
    is_late = False
    answers(text, 1)
    lit(ROOT / "rules" / "tipper.fz")
    session.settle_collector()  # as the server does
    print(f"answers on {text.count(chr(10))} lines       median    99 %  [ms]")
    for name, times in answers(text, given.places).items():
        late = percentile(times, 0.99) > MOST_ANSWER
        is_late |= late
        print(f"{name:<26} {percentile(times, 0.5):8.2f} {percentile(times, 0.99):8.2f}{'  above' if late else ''}")
    times = typed(text)
    late = percentile(times, 0.5) > MOST_NAMES
    is_late |= late
    print(f"\nkey to names and syntax    {percentile(times, 0.5):8.1f}{'  above' if late else ''}  [ms]")
    print("\nonce for each version, 500 lines and tipper.fz  [ms]")
    tipper = (ROOT / "rules" / "tipper.fz").read_text(encoding="utf-8")
    for (name, large), small in zip(checked(text).items(), checked(tipper).values(), strict=True):
        print(f"{name:<26} {large:8.2f} {small:8.2f}")
    print("\nlast key to guarantee lights  [ms]")
    for path in sorted((ROOT / "rules").glob("*.fz")):
        lit(path)
        took = min(lit(path) for _ in range(3))
        is_late |= took > MOST_LIGHTS
        print(f"{path.name:<26} {took:8.1f}{'  above' if took > MOST_LIGHTS else ''}")
    return int(is_late)


if __name__ == "__main__":
    sys.exit(main())
