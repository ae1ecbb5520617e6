"""The pictures of a Markdown page: terms of each variable, and a surface of each output."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from fuzzyctl.comparison.differences import quiet
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable
from fuzzyctl.plot.names import file_part


def pictures_folder(page: Path) -> Path:
    """Return the folder of the pictures of a page."""
    return page.with_name(f"{page.stem}-pictures")


def picture_files(system: FuzzySystem, page: Path) -> dict[str, Path]:
    """Return the files of the pictures of a page, by what `markdown.page` calls them.

    Args:
        system: The system.
        page: The page's file; pictures go to a folder called after it, such as `tipper-pictures`.
    """
    folder = pictures_folder(page)
    parts: dict[str, str] = {}
    for v in system.variables:
        parts[v.name] = file_part(v.name, parts.values())
    terms = {v.name: folder / f"{parts[v.name]}.svg" for v in system.variables if v.terms}
    return terms | {f"surface {o.name}": folder / f"surface-{parts[o.name]}.svg" for o in system.outputs}


def refuse_to_replace(files: dict[str, Path]) -> None:
    """Refuse pictures in the place of files that are there.

    Raises:
        DiagnosticError: With the files.
    """
    there = [path for path in files.values() if path.exists()]
    if there:
        what = "a file of this name exists" if len(there) == 1 else f"this file and {len(there) - 1} more exist"
        help_text = "name another page, whose pictures get a folder of their own, or add --force"
        raise DiagnosticError([Diagnostic("FZ005", what, file=str(there[0]), help=help_text)])


def page_files(system: FuzzySystem, page: Path) -> dict[Path, str]:
    """Return the texts of a Markdown page and of its pictures by file.

    Args:
        system: The system.
        page: The page's file.
    """
    from fuzzyctl.convert import markdown
    from fuzzyctl.plot.memberships import draw_variable
    from fuzzyctl.plot.style import svg
    from fuzzyctl.plot.surfaces import draw_surface

    files, texts = picture_files(system, page), dict[Path, str]()
    # A surface has a hole where no rule fires, whatever calls of the system do there.
    drawn, axes = quiet(system), [v.name for v in system.inputs[:2]]

    def terms(figure: Any, variable: LinguisticVariable) -> None:
        figure.set_size_inches(7.5, 2.6)
        draw_variable(figure.subplots(), system, variable)

    for variable in system.variables:
        if variable.name in files:
            texts[files[variable.name]] = svg(partial(terms, variable=variable))
    for output in system.outputs:
        surface = partial(draw_surface, system=drawn, axes=axes, fixed={}, output=output.name, resolution=61)
        texts[files[f"surface {output.name}"]] = svg(surface)
    links = {key: f"{path.parent.name}/{path.name}" for key, path in files.items()}
    return {**texts, page: markdown.page(system, links)}
