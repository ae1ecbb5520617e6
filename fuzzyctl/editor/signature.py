"""The form of the function whose arguments are being typed."""

from __future__ import annotations

import re
from dataclasses import dataclass

from fuzzyctl.editor.document import Document
from fuzzyctl.editor.words import called
from fuzzyctl.lang.edits import masked
from fuzzyctl.lang.syntax import NAME


@dataclass(frozen=True)
class Signature:
    """A form such as `triangle(left, peak, right)`, its parameters, and which of them is being typed, from 0."""

    form: str
    what: str
    parameters: tuple[str, ...]
    active: int


def signature(document: Document, offset: int) -> Signature | None:
    """Return the innermost open call before an offset; None where there is none that is known."""
    code = masked(document.text_before(offset))
    depth = commas = 0
    for at in range(len(code) - 1, -1, -1):
        char = code[at]
        if char in ")]":
            depth += 1
        elif char in "([" and depth:
            depth -= 1
        elif char == "," and not depth:
            commas += 1
        elif char == "(":
            found = re.search(rf"({NAME})\s*$", code[:at])
            return _of(document, offset, found[1], commas) if found is not None else None
    return None


def _of(document: Document, offset: int, name: str, commas: int) -> Signature | None:
    _, head = document.symbols.scope_at(offset)
    word = called(head.kind if head is not None and head.kind != "system" else "").get(name)
    if word is not None:
        inner = word.form[word.form.index("(") + 1 : word.form.rindex(")")]
        parameters = tuple(p.strip() for p in re.split(r",(?![^\[]*\])", inner))
        return Signature(word.form, word.what, parameters, min(commas, len(parameters) - 1))
    for scope, block in document.symbols.blocks():
        if block.name == name:
            inputs = tuple(s.name for s in scope.own.values() if s.kind == "input")
            if inputs:
                return Signature(f"{name}({', '.join(inputs)})", block.label, inputs, min(commas, len(inputs) - 1))
    return None
