"""`fuzzyctl convert`: a system in another format, with a report of the losses."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fuzzyctl.cli.common import (
    BLOCK,
    DONE,
    FAILED,
    FORMAT,
    POINTS,
    QUIET,
    SET,
    answers_with_diagnostics,
    show,
    suggestion,
)
from fuzzyctl.cli.loading import Choice, open_block
from fuzzyctl.cli.progress import status_line
from fuzzyctl.cli.streams import say, write_data, write_json
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, FuzzyctlError, NoRuleFiresError

if TYPE_CHECKING:
    from fuzzyctl.convert.convert import Conversion
    from fuzzyctl.formats.registry import Loss
    from fuzzyctl.model.system import FuzzySystem


@click.command()
@click.argument("source", metavar="IN")
@click.argument("target", metavar="OUT")
@click.option("--to", "wanted", metavar="FORMAT", help="The format, if the suffix of OUT does not name it.")
@click.option("--lossy", is_flag=True, help="Write it even though the format cannot express all of it.")
@click.option("--force", is_flag=True, help="Replace OUT if it has another text, and pictures of a page if they exist.")
@POINTS
@FORMAT
@SET
@BLOCK
@QUIET
@answers_with_diagnostics
def convert(
    source: str,
    target: str,
    wanted: str | None,
    lossy: bool,
    force: bool,
    points: int,
    form: str,
    settings: tuple[str, ...],
    name: str | None,
) -> int:
    """Write a system in another format.

    \b
    fuzzyctl convert tipper tipper.fis
    fuzzyctl convert tipper.fis tip.fz
    fuzzyctl convert tipper tipper.md        a page with tables and pictures
    fuzzyctl convert tipper - --to python    a module that builds it

    The suffix of OUT names the format: .fz .fll .fis .fcl .fml .xml, and .py and .md, which are not read back. OUT may
    be '-' for standard output, together with --to; the report then goes to standard error.

    The written file is read back, and both systems are compared at corners of terms, on an even grid and at random
    points. Settings that the format cannot express are listed; if they change an output by more than 0.1 % of its
    range, no file is written without --lossy.
    """
    to = _target(target, wanted)
    if target != "-":
        from fuzzyctl.support.writing import refuse_what_is_no_file

        refuse_what_is_no_file(Path(target))
    system, lost = _loaded(source, settings, name)
    if to == "markdown" and target != "-" and not force:
        from fuzzyctl.convert.markdown import picture_files, refuse_to_replace

        refuse_to_replace(picture_files(system, Path(target)))
    from fuzzyctl.convert.convert import convert as converted

    try:
        with status_line() as report:
            conversion = converted(system, to, points=points, progress=report)
    except NoRuleFiresError as error:
        raise _uncovered(system, error) from None
    conversion = replace(conversion, losses=(*lost, *conversion.losses))
    is_slight = conversion.slight and all(loss.exact for loss in lost)
    refused = bool(conversion.lossy) and not lossy and not is_slight
    if not refused:
        if target != "-" and not force:
            _refuse_to_replace(Path(target), conversion.text)
        _write(system, conversion, target)
    if form == "json" and target != "-":
        write_json(_data(source, target, conversion, refused))
    else:
        say("\n".join(_report(source, target, conversion, refused)), err=target == "-" or refused)
    return FAILED if refused else DONE


def _uncovered(system: FuzzySystem, error: NoRuleFiresError) -> FuzzyctlError:
    """Return a point without a value as `check` reports it, with its location."""
    from fuzzyctl.analysis.coverage import coverage

    errors = [d for d in coverage.diagnostics(system) if d.severity == "error"]
    return DiagnosticError(errors) if errors else error


def _refuse_to_replace(target: Path, text: str) -> None:
    """Refuse a target that exists with another text."""
    from fuzzyctl.support.writing import holds

    if os.path.exists(target) and not holds(target, text):
        message, help_text = "the file exists with another text", "name another file, or add --force"
        raise DiagnosticError([Diagnostic("FZ005", message, file=str(target), help=help_text)])


def _target(target: str, wanted: str | None) -> str:
    """Return the format to write.

    Raises:
        DiagnosticError: For a suffix that stands for none.
        BadParameter: For a name that does.
    """
    from fuzzyctl.convert.convert import TARGETS

    if wanted is not None:
        if wanted in TARGETS:
            return wanted
        hint = suggestion(wanted, TARGETS) or f"there are: {', '.join(TARGETS)}"
        raise click.BadParameter(f"no format '{wanted}'; {hint}", param_hint="--to")
    suffix = Path(target).suffix.lower()
    for name, suffixes in TARGETS.items():
        if suffix in suffixes:
            return name
    endings = ", ".join(s for suffixes in TARGETS.values() for s in suffixes)
    message = f"no format has the suffix '{suffix}'" if suffix else "the name has no suffix that says the format"
    help_text = f"end the name with one of {endings}, or add --to"
    raise DiagnosticError([Diagnostic("FZ005", message, file=target, help=help_text)])


def _loaded(source: str, settings: tuple[str, ...], name: str | None) -> tuple[FuzzySystem, list[Loss]]:
    """Load a system of any format, and the losses of its file; gaps of the system do not count."""
    from fuzzyctl.model.system import FuzzySystem

    system, examined, diagnostics = open_block(source, name, FuzzySystem)
    system = Choice(settings).changed(system)
    show(diagnostics)
    from fuzzyctl.convert.convert import left_out
    from fuzzyctl.formats.registry import Loss

    blocks = [(b.kind, b.name) for b in examined.equations]
    others = [Loss(f"{kind} '{block}'", "left out", "only systems are converted", exact=True) for kind, block in blocks]
    return system, [*left_out(diagnostics), *others]


def _write(system: FuzzySystem, conversion: Conversion, target: str) -> None:
    if target == "-":
        write_data(conversion.text)
        return
    from fuzzyctl.support.writing import folder_for, write_together

    path = Path(target)
    if conversion.target != "markdown":
        write_together({path: conversion.text})
        return
    from fuzzyctl.convert.markdown import page_files, pictures_folder

    with folder_for(pictures_folder(path)):
        write_together(page_files(system, path))


def _report(source: str, target: str, conversion: Conversion, refused: bool) -> list[str]:
    lines = [] if refused else [f"wrote {target}"] if target != "-" else []
    harmless, lost = [x for x in conversion.losses if x.exact], list(conversion.lossy)
    lines += _listed("written differently, or left out; no number changes:", harmless)
    lines += _listed("cannot be expressed, and changes numbers:", lost)
    if conversion.read_back is not None:
        from fuzzyctl.comparison.presentation import compared_text

        lines += compared_text(source, conversion.read_back, target, conversion.differences, conversion.explanations)
    if refused:
        lines.append(f"error: nothing was written to {target}; add --lossy to write it all the same")
    return lines


def _listed(title: str, losses: Sequence[Loss]) -> list[str]:
    """Return a list under a title; equal losses in several places share a line."""
    places: dict[tuple[str, str], list[str]] = {}
    for loss in losses:
        places.setdefault((loss.what, loss.why), []).append(loss.where)
    lines = [f"  {_places(where)}: {what}: {why}" for (what, why), where in places.items()]
    return [title, *lines] if losses else []


def _places(where: Sequence[str]) -> str:
    return where[0] if len(where) == 1 else f"{where[0]} and {len(where) - 1} more"


def _data(source: str, target: str, conversion: Conversion, refused: bool) -> dict[str, Any]:
    from fuzzyctl.comparison.presentation import compared_data

    return {
        "in": source,
        "out": target,
        "format": conversion.target,
        "written": not refused,
        "losses": [
            {"where": x.where, "what": x.what, "why": x.why, "changes_numbers": not x.exact} for x in conversion.losses
        ],
        "outputs": [compared_data(d, e) for d, e in zip(conversion.differences, conversion.explanations, strict=True)],
    }
