"""Elements of the XML of an FMU, without entities and document types, whose expansion may be endless."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final
from xml.parsers import expat

#: Deepest nesting of elements.
DEEPEST: Final = 100


@dataclass(frozen=True)
class Element:
    """An element: its name, its attributes, and how many others it lies in."""

    name: str
    attributes: dict[str, str]
    depth: int


def elements(text: bytes) -> Iterator[Element]:
    """Yield the elements in the order of their begins.

    Raises:
        ValueError: For broken XML, a document type, and deep nesting.
    """
    found: list[Element] = []
    depth = 0
    parser = expat.ParserCreate()

    def begin(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        if depth == DEEPEST:
            raise ValueError(f"elements lie more than {DEEPEST} levels inside each other")
        found.append(Element(name, attributes, depth))
        depth += 1

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1

    def document_type(*_: object) -> None:
        raise ValueError("it declares a document type, which FMI has none of")

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.StartDoctypeDeclHandler = document_type
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise ValueError(f"{expat.ErrorString(error.code)} in line {error.lineno}") from None
    except LookupError as error:  # an encoding that Python does not know
        raise ValueError(str(error)) from None
    yield from found
