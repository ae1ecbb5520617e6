"""`fuzzyctl page`: a file as one page that computes offline."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fuzzyctl.cli.common import DONE, FAILED, QUIET, UNDECIDED, answers_with_diagnostics, assignments, show
from fuzzyctl.cli.loading import Choice, analysed, chooses, claim_reports, examined_file, settable, settings_of
from fuzzyctl.cli.streams import say
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.analysis.verdicts import Verdicts
    from fuzzyctl.loading.load import Examined
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.page.document import Section
    from fuzzyctl.simulation.run import Run


@click.command()
@click.argument("file")
@click.option("-o", "--output", "out", metavar="FILE", help="The page.  [default: name of the file, .html]")
@chooses
@QUIET
@answers_with_diagnostics
def page(file: str, out: str | None, choice: Choice) -> int:
    """Write a file as one HTML page that computes offline, to look at and to share.

    It has sliders for the inputs, terms with their degrees, the rules that act, surfaces, and proved facts; steps
    of controllers; loops over time, which are run beforehand. Its numbers come from JavaScript as 'fuzzyctl
    codegen' writes it. The page of a file whose guarantee is refuted begins at the point that shows it.

    \b
    fuzzyctl page tipper -o tipper.html
    fuzzyctl page water_tank --block fill -o tank.html

    Exit code 1 if a guarantee is refuted, a requirement of a loop is not met or its run is stopped, 3 if a guarantee is
    undecided; the page is written.
    """
    from fuzzyctl.analysis.work import clock
    from fuzzyctl.loading.load import chosen
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.model.system import FuzzySystem
    from fuzzyctl.page.document import document, page_title
    from fuzzyctl.page.systems import LEAST_SECONDS, PAGE_SECONDS
    from fuzzyctl.support.writing import write_together

    began = clock.used()
    examined = examined_file(file, loop=choice.name)
    reported = examined.reported(examined.diagnostics)
    if any(d.severity == "error" for d in reported):
        raise DiagnosticError(reported)
    kinds: Any = (FuzzySystem, Controller, Loop)
    if choice.name is not None or not any(map(examined.of, kinds)):
        chosen(examined, choice.name, *kinds)
    loops = [loop for loop in examined.loops if choice.name in (None, loop.name)]
    if choice.settings:
        names = (settable(block) for block in examined.blocks)
        assignments(choice.settings, list(dict.fromkeys(chain.from_iterable(names))), "param")
    diagnostics = list(reported)
    until = clock.now() + max(PAGE_SECONDS - (clock.used() - began), LEAST_SECONDS)
    sections = [
        *_sections(examined, choice, diagnostics, until),
        *_runs(loops, choice, diagnostics),
    ]
    show(diagnostics)
    target = Path(out or f"{'stdin' if file == '-' else Path(file).stem}.html")
    blocks = [s.data["title"] or s.data["name"] for s in sections]
    title = page_title(blocks, target.stem if file == "-" else Path(file).stem)
    write_together({target: document(title, sections, diagnostics)})
    say(f"wrote {target}")
    if any(d.severity == "error" for d in diagnostics):
        return FAILED
    return UNDECIDED if any(d.code == "FZ402" for d in diagnostics) else DONE


def _sections(examined: Examined, choice: Choice, diagnostics: list[Diagnostic], until: float) -> Iterator[Section]:
    """Yield the sections of systems and controllers, and add what their checks find.

    Raises:
        DiagnosticError: For a block with errors, and one that JavaScript cannot compute.
    """
    from fuzzyctl.analysis.prove import CLAIM_SECONDS
    from fuzzyctl.analysis.work import clock
    from fuzzyctl.codegen import javascript_source
    from fuzzyctl.codegen.errors import CodegenError
    from fuzzyctl.codegen.prepare import prepare
    from fuzzyctl.page.document import require_size, unit_section
    from fuzzyctl.page.systems import LEAST_SECONDS, proofs

    blocks: tuple[Any, ...] = (*examined.systems, *examined.controllers)
    of_file: list[Diagnostic] | None = None
    for block in blocks:
        if choice.name not in (None, block.name):
            continue
        part = choice.of_params(block.settable)
        settings = assignments(part.settings, block.settable, "param")
        try:
            for system in block.systems:
                require_size(system)  # before proofs, which take seconds where there is much to prove
            changed, quick, reports = analysed(examined, block, part, of_file)
            of_file = None if block.is_function else reports
            with clock.limited(max(until - clock.now(), LEAST_SECONDS)):
                unit = prepare(changed, examined.source.text, settings=settings)
            if unit.is_step:
                javascript_source.require_size(javascript_source.size_of(unit.program))
            verdicts, rows = proofs(changed, quick, CLAIM_SECONDS, until=until)
            _add(diagnostics, [*reports, *claim_reports(verdicts, reports)])
            yield unit_section(replace(unit, verdicts=verdicts), verdicts, rows)
        except CodegenError as error:
            raise DiagnosticError([_refused(block.name, block.span, error)]) from None


def _add(diagnostics: list[Diagnostic], reports: Iterable[Diagnostic]) -> None:
    """Add diagnostics that are not there; there may be thousands."""
    present: dict[tuple[object, ...], list[Diagnostic]] = {}
    for d in diagnostics:
        present.setdefault(_key(d), []).append(d)
    diagnostics += [d for d in reports if d not in present.get(_key(d), [])]


def _key(d: Diagnostic) -> tuple[object, ...]:
    return d.code, d.message, d.span and d.span.start


def _runs(loops: list[Loop], choice: Choice, diagnostics: list[Diagnostic]) -> Iterator[Section]:
    """Yield the sections of loops, which are run; their claims are proved as far as the time allows."""
    if not loops:
        return
    from fuzzyctl.analysis.verdicts import Refuted
    from fuzzyctl.page.blocks import loop_data
    from fuzzyctl.page.document import Section
    from fuzzyctl.simulation.simulate import simulate, warnings

    for loop in loops:
        changed = settings_of(choice.of_params(settable(loop)).settings, [loop])[0]
        run = simulate(changed, record_calls=True)
        diagnostics += [*(_unmet(run) if run.stopped is None else [run.stopped]), *warnings(run)]
        proofs = _proofs(changed) if run.stopped is None else None
        _add(diagnostics, claim_reports([v for v in proofs or () if isinstance(v, Refuted)], diagnostics))
        yield Section(loop_data(run, len(loops), proofs))


def _proofs(loop: Loop) -> Verdicts | None:
    """Return the verdicts on the family of a loop within the time of a page; None without claims."""
    from fuzzyctl.analysis.prove import prover_of
    from fuzzyctl.analysis.verdicts import Verdict, Verdicts
    from fuzzyctl.analysis.work import clock
    from fuzzyctl.page.systems import PAGE_SECONDS

    if not loop.guarantees:
        return None
    prover, until, verdicts = prover_of(loop), clock.used() + PAGE_SECONDS, list[Verdict]()
    for claim in prover.own:
        prover.timeout = max(until - clock.used(), 0.0)
        verdicts.append(prover.verdict(claim))
    proofs = Verdicts(verdicts)
    proofs.tube = prover.tube
    return proofs


def _unmet(run: Run) -> Iterator[Diagnostic]:
    """Yield an error for each requirement that a run does not meet."""
    for written, r in zip((*run.loop.requirements, *run.loop.always), run.requirements, strict=True):
        if not r.holds:
            message, help_text = f"the run does not meet the requirement '{r.text}'", "change the loop, or require less"
            yield Diagnostic("FZ402", message, written.span, facts=r.facts, help=help_text, witness={})


def _refused(name: str, span: object, error: Exception) -> Diagnostic:
    from fuzzyctl.diagnostics.source import Span

    place = span if isinstance(span, Span) else None
    return Diagnostic(
        "FZ608", f"'{name}' cannot be written in JavaScript, with which pages compute", place, facts=(str(error),)
    )
