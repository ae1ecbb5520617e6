"""What controllers, plants and loops look like: the text of `fuzzyctl show`, and tables in a notebook."""

from __future__ import annotations

from fuzzyctl.display.block_summary import block_summary
from fuzzyctl.display.layout import number_text
from fuzzyctl.display.markup import page, paragraph, table
from fuzzyctl.display.systems import page_text, params_table
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant


def text(block: Controller | Plant | Loop) -> str:
    """Return what `fuzzyctl show` prints."""
    return page_text(block_summary(block))


def html(block: Controller | Plant | Loop) -> str:
    """Return params, signals and equations in the order in which they are computed, as tables."""
    data = block_summary(block)
    title = f": {data['title']}" if data["title"] else ""
    times = [f"{word} {number_text(data[word])} s" for word in ("period", "duration", "step") if data.get(word)]
    return page(
        f"{data['kind']} {data['name']}{title}",
        paragraph(data["source"], "note"),
        paragraph(data["file"], "note"),
        paragraph(", ".join(times)),
        params_table(data["params"]),
        *(
            table(heading, (), [(s,) for s in found], headed_rows=False)
            for heading, found in data["statements"].items()
        ),
    )
