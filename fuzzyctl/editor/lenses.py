"""Code lenses: above each `require` line what is proved of it, above each block what can be shown of it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.lights import Light, lights
from fuzzyctl.expr import number_text

#: Names of the commands; each has a document and a block, `why` a point, too.
SURFACE, WHY, PROVE, SIMULATE = COMMANDS = tuple(f"fuzzyctl.{c}" for c in ("surface", "why", "prove", "simulate"))

_SIGNS: Final = {"proved": "✓", "refuted": "✗", "undecided": "?", "unknown": "…"}
_LONGEST: Final = 160


@dataclass(frozen=True)
class Lens:
    """A line of text above a location that runs a command when it is chosen.

    Args:
        span: The location.
        title: The text.
        command: One of `COMMANDS`.
        block: Name of the system, controller or loop.
        point: Values of inputs, for `why`.
    """

    span: Span
    title: str
    command: str
    block: str
    point: Mapping[str, float]


def lenses(document: Document) -> list[Lens]:
    """Return the lenses of a document, by location."""
    known = lights(document)
    claiming = {light.block for light in known}
    found = [_of_light(light) for light in known]
    for _, _, head in document.symbols.scopes:
        if head is None or head.span.source.name != document.source.name:
            continue
        if head.kind == "system":
            found.append(Lens(head.span, "surface", SURFACE, head.name, {}))
        if head.kind == "controller" or (head.kind == "system" and head.name in claiming):
            found.append(Lens(head.span, "prove", PROVE, head.name, {}))
        elif head.kind == "loop":
            found.append(Lens(head.span, "simulate", SIMULATE, head.name, {}))
    return sorted(found, key=lambda lens: lens.span.start)


def _of_light(light: Light) -> Lens:
    text = light.text if len(light.text) <= _LONGEST else light.text[: _LONGEST - 1] + "…"
    command = SIMULATE if light.kind == "loop" else PROVE
    if light.state == "refuted" and light.kind == "system":
        command, text = WHY, f"{text} – why"
    return Lens(light.span, f"{_SIGNS[light.state]} {text}", command, light.block, light.point)


def point_text(point: Mapping[str, float]) -> str:
    """Return a point as `fuzzyctl why` takes it."""
    return " ".join(f"{name}={number_text(x)}" for name, x in point.items())


def arguments(command: str, block: str, point: Mapping[str, Any], picture: str) -> Sequence[str]:
    """Return the arguments of the command line that does what a lens says; the text comes from standard input.

    Args:
        command: One of `COMMANDS`.
        block: Name of the system, controller or loop; empty where the file holds one.
        point: Values of inputs.
        picture: Path of the picture that `fuzzyctl.surface` writes.
    """
    chosen = ["--block", block] if block else []
    match command:
        case "fuzzyctl.surface":
            return ["plot-surface", "-", *chosen, "-o", os.fspath(picture)]
        case "fuzzyctl.why":
            return ["why", "-", *chosen, *(f"{n}={number_text(float(x))}" for n, x in point.items())]
        case "fuzzyctl.prove":
            return ["prove", "-", *chosen]
    return ["simulate", "-", *chosen]
