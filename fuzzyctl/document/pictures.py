"""The pictures of a Markdown page: terms of each variable, and a surface of each output."""

from __future__ import annotations

from pathlib import Path

from fuzzyctl.formats.identifiers import identifier
from fuzzyctl.model.system import FuzzySystem


def draw(system: FuzzySystem, page: Path) -> dict[str, str]:
    """Draw the pictures of a page into a folder beside it.

    Args:
        system: The system.
        page: The page's file; pictures go to a folder called after it, such as `tipper-pictures`.

    Returns:
        Their paths relative to the page, by what `markdown.page` calls them.
    """
    from fuzzyctl.plot.style import saved
    from fuzzyctl.plot.surface import draw_surface
    from fuzzyctl.plot.terms import draw_variable

    folder = page.with_name(f"{page.stem}-pictures")
    folder.mkdir(exist_ok=True)
    found: dict[str, str] = {}
    for variable in (*system.inputs, *system.outputs):
        if not variable.terms:
            continue
        path = folder / f"{identifier(variable.name)}.svg"
        with saved(path) as figure:
            figure.set_size_inches(7.5, 2.6)
            draw_variable(figure.subplots(), system, variable)
        found[variable.name] = f"{folder.name}/{path.name}"
    axes = [v.name for v in system.inputs[:2]]
    for output in system.outputs:
        path = folder / f"surface-{identifier(output.name)}.svg"
        with saved(path) as figure:
            draw_surface(figure, system, axes, {}, output.name, 61)
        found[f"surface {output.name}"] = f"{folder.name}/{path.name}"
    return found
