"""The pictures of a Markdown page: terms of each variable, and a surface of each output."""

from __future__ import annotations

from pathlib import Path

from fuzzyctl.comparison.differences import quiet
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.plot.names import file_part
from fuzzyctl.support.writing import refuse_what_is_no_file


def picture_files(system: FuzzySystem, page: Path) -> dict[str, Path]:
    """Return the files of the pictures of a page, by what `markdown.page` calls them.

    Args:
        system: The system.
        page: The page's file; pictures go to a folder called after it, such as `tipper-pictures`.
    """
    folder = page.with_name(f"{page.stem}-pictures")
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


def draw(system: FuzzySystem, page: Path) -> dict[str, str]:
    """Draw the pictures of a page into a folder beside it.

    Args:
        system: The system.
        page: The page's file.

    Returns:
        Their paths relative to the page, by what `markdown.page` calls them.

    Raises:
        DiagnosticError: Where the folder cannot be made, or a picture not written.
    """
    from fuzzyctl.plot.memberships import draw_variable
    from fuzzyctl.plot.style import saved
    from fuzzyctl.plot.surfaces import draw_surface

    files = picture_files(system, page)
    _made(page.with_name(f"{page.stem}-pictures"))
    for path in files.values():
        refuse_what_is_no_file(path)
    for variable in system.variables:
        if variable.name not in files:
            continue
        with saved(files[variable.name]) as figure:
            figure.set_size_inches(7.5, 2.6)
            draw_variable(figure.subplots(), system, variable)
    # A surface has a hole where no rule fires, whatever calls of the system do there.
    drawn, axes = quiet(system), [v.name for v in system.inputs[:2]]
    for output in system.outputs:
        with saved(files[f"surface {output.name}"]) as figure:
            draw_surface(figure, drawn, axes, {}, output.name, 61)
    return {key: f"{path.parent.name}/{path.name}" for key, path in files.items()}


def _made(folder: Path) -> None:
    """Make the folder of pictures where it is not there."""
    try:
        folder.mkdir(exist_ok=True)
    except FileExistsError:
        message = "this is a file; the folder of the page's pictures has this name"
        help_text = "move it, or name another page"
        raise DiagnosticError([Diagnostic("FZ005", message, file=str(folder), help=help_text)]) from None
    except OSError as error:
        message = f"the folder of the page's pictures cannot be made: {error.strerror}"
        raise DiagnosticError([Diagnostic("FZ005", message, file=str(folder), help="name another page")]) from None
