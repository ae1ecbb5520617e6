"""`fuzzyctl prove`: the guarantees of rule files, proved for all inputs or refuted by a point."""

from __future__ import annotations

import json
import math
import os
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from fuzzyctl.cli.common import (
    DONE,
    FAILED,
    FORMAT,
    QUIET,
    STDIN,
    UNDECIDED,
    NotNegative,
    answers_with_diagnostics,
    code_of,
    end_of_range,
    remark,
    report,
    show,
)
from fuzzyctl.cli.loading import (
    Choice,
    Opened,
    chooses,
    content_of,
    folder_of,
    load_checked,
    open_block,
    open_blocks,
    settable,
)  # fmt: skip
from fuzzyctl.cli.progress import status_line
from fuzzyctl.cli.streams import INTERRUPTED, say, write_json
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.support.files import place_of

if TYPE_CHECKING:
    from fuzzyctl.analysis.extremes import Extent
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.codegen.fixed.fixed_format import Format
    from fuzzyctl.model.block import Block
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.system import FuzzySystem
    from fuzzyctl.simulation.members import Tube


#: Suffixes of files of tubes; runs of members beside a tube.
_TUBES: Final = (".png", ".svg", ".pdf", ".csv")
_DRAWN: Final = 32


@dataclass
class Proof:
    """The verdicts on a block.

    Args:
        file: The file.
        block: The block.
        claims: How many claims there are.
        verdicts: The verdicts so far.
        prover: The prover of the block.
        tube: Bounds of the outputs of the plants of a loop over time, None without.
    """

    file: str
    block: Block
    claims: int = 0
    verdicts: list[Verdict] = field(default_factory=list)
    prover: Any = None
    tube: Tube | None = None


@dataclass(frozen=True)
class _Setting:
    """How the loop that is proved differs from that of the file: params, the format of fixed point, range of noise."""

    choice: Choice
    form: Format | None = None
    noise: float | None = None


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@chooses
@click.option("--bounds", is_flag=True, help="Bound the outputs of a file instead, and their slopes.")
@click.option(
    "--timeout",
    type=NotNegative(),
    metavar="SECONDS",
    help="How long one guarantee, or all bounds, may take.  [default: 10, with --bounds 4]",
)
@click.option(
    "--tube",
    metavar="FILE",
    help="Write bounds of all members of a loop over time: PNG, SVG or PDF with runs, or CSV.",
)
@click.option(
    "--certificate",
    metavar="OUT.json",
    help="Write what 'fuzzyctl verify' needs to check the proved claims of loops.",
)
@click.option("--fixed", metavar="Qm.n", help="Prove loops with the fixed-point code of 'codegen --fixed'.")
@click.option(
    "--noise",
    type=NotNegative(finite=True),
    metavar="DEVIATIONS",
    help="Prove loops for noise of any values up to this number of standard deviations.",
)
@FORMAT
@QUIET
@answers_with_diagnostics
def prove(
    files: tuple[str, ...],
    choice: Choice,
    bounds: bool,
    timeout: float | None,
    tube: str | None,
    certificate: str | None,
    fixed: str | None,
    noise: float | None,
    form: str,
) -> int:
    """Prove the guarantees of rule files: their 'require' lines.

    Each one is proved for all inputs, refuted by a point that is evaluated, or left undecided with a
    reason. For controllers, the ranges of states and outputs are proved, too, for every step that a run can reach.
    Claims of loops, 'require always' and 'require stable', are proved for all members of a family.
    Exit code 1 if one is refuted or a file has mistakes, 3 if one is undecided.

    --bounds prints for each output an interval that contains every number that a kernel returns, for any inputs; for a
    controller, over every step that a run can reach. The points at which an output comes nearest to its bounds are
    evaluated. The printed slopes bound the change of an output per unit of each input.

    --certificate writes the claims of loops that are proved to a file, with what had to be found; a claim whose proof
    cannot be written this way is named, and the exit code is 3.

    \b
    fuzzyctl prove tipper ais_reaction
    fuzzyctl prove ais_reaction --set k_s=0.6
    fuzzyctl prove ais_reaction --bounds
    fuzzyctl prove arch_unicycle --tube tube.png
    """
    loop_option = "--fixed" if fixed is not None else "--noise" if noise is not None else ""
    _require_options(files, tube, certificate, loop_option, bounds=bounds)
    if bounds:
        return print_bounds(files[0], choice, 4.0 if timeout is None else timeout, form)
    setting = _Setting(choice, None if fixed is None else _fixed_format(fixed), noise)
    timeout = 10.0 if timeout is None else timeout
    proofs: list[Proof] = []
    mistakes: list[Diagnostic] = []
    tell = report if form == "text" else None
    try:
        for file in dict.fromkeys(files):
            try:
                opened = _opened(file, choice)
            except DiagnosticError as error:
                mistakes.extend(error.diagnostics)
                continue
            label = STDIN if file == "-" else file
            claiming = [b for b in opened.blocks if not b.unclaimed and (b.kind == "loop" or not loop_option)]
            if loop_option and not claiming:
                raise click.UsageError(
                    f"{loop_option} is for loops, and {label} has none with claims about all members"
                )
            for block in claiming or opened.blocks:
                proofs.append(Proof(label, block))
                _prove(proofs[-1], timeout, tell, setting)
    except KeyboardInterrupt:
        show(mistakes)
        say(f"interrupted{': ' if proofs else ''}{_summary(proofs)}", err=True)
        sys.exit(INTERRUPTED)
    lacking = {} if certificate is None or mistakes else _write_certificate(certificate, proofs)
    if form == "json":
        data = _as_data(proofs, mistakes)
        write_json(data if certificate is None else data | {"certificate": {"file": certificate, "without": lacking}})
    else:
        if proofs:
            report(_summary(proofs))
        for claim, reason in lacking.items():
            report(f"no certificate of '{claim}': {reason}")
        show(mistakes)
    if tube is not None:
        _write_tube(Path(tube), proofs, tell)
    kinds = {type(v).__name__ for p in proofs for v in p.verdicts}
    if "Refuted" in kinds:
        return FAILED
    if mistakes:
        return code_of(mistakes)
    return UNDECIDED if "Undecided" in kinds or lacking else DONE


def _require_options(
    files: Sequence[str], tube: str | None, certificate: str | None, loop_option: str, *, bounds: bool
) -> None:
    """Refuse options that exclude each other, and files to write that are read.

    Args:
        files: Files that are read.
        tube, certificate: Files that are written.
        loop_option: An option for loops alone, or an empty text.
        bounds: Whether bounds are printed in place of proofs.

    Raises:
        click.UsageError: For the first of them.
    """
    if tube is not None and not tube.lower().endswith(_TUBES):
        raise click.UsageError(f"--tube {tube}: the name must end in {', '.join(_TUBES)}")
    if loop_option and (bounds or certificate is not None):
        raise click.UsageError(f"{loop_option} is not for {'--bounds' if bounds else '--certificate'}")
    if bounds and (tube is not None or certificate is not None):
        raise click.UsageError(f"--{'certificate' if tube is None else 'tube'} is not for --bounds")
    if len(files) > 1 and (bounds or certificate is not None):
        raise click.UsageError(f"--{'bounds' if bounds else 'certificate'} takes one file")
    occupied = {os.path.realpath(place_of(f).path) for f in files if f != "-"}
    occupied |= {os.path.realpath(f) for f in (tube,) if f is not None}
    if certificate is not None and os.path.realpath(certificate) in occupied:
        raise click.UsageError(f"--certificate {certificate}: this file is read, or holds the tube")


def _write_certificate(path: str, proofs: Sequence[Proof]) -> dict[str, str]:
    """Write the certificate of all proved claims of loops; return why claims are not in it.

    Raises:
        DiagnosticError: If the file cannot be written.
    """
    from fuzzyctl.analysis.reach.certificate import certificate_of
    from fuzzyctl.analysis.verdicts import Proved
    from fuzzyctl.support.writing import written_whole

    parts: list[dict[str, Any]] = []
    lacking: dict[str, str] = {}
    for proof in proofs:
        if proof.block.kind != "loop":
            continue
        claims = [c for c, v in zip(proof.prover.own, proof.verdicts, strict=True) if isinstance(v, Proved)]
        certified, reasons = certificate_of(proof.prover, claims)
        parts += certified
        lacking |= reasons
    if parts:
        with written_whole(path) as temporary:
            temporary.write_text(json.dumps({"format": "fuzzyctl certificate 2", "parts": parts}), encoding="utf-8")
    return lacking


@click.command()
@click.argument("file", metavar="CERTIFICATE")
@click.option("--source", metavar="FILE", help="Also check that this rule file is the one that was proved.")
@answers_with_diagnostics
def verify(file: str, source: str | None) -> int:
    """Check a certificate that 'fuzzyctl prove --certificate' wrote, without the rule file.

    The check is two modules of at most 200 lines that need Python alone; they evaluate the loop's equations with whole
    numbers, rounded outward, and search for nothing. Exit code 1 with the first step that does not hold.
    """
    from fuzzyctl.analysis import verify as checker
    from fuzzyctl.analysis.reach.certificate import is_of
    from fuzzyctl.loading.load import look_through
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.support.files import decode

    try:
        checker.main(file)
    except SystemExit as refused:
        say(f"{refused.code}", err=True)
        return FAILED
    if source is None:
        return DONE
    content, place = content_of(source)
    with open(file, "rb") as opened:
        parts = json.load(opened)["parts"]
    if not all(map(_names_its_source, parts)):
        raise click.ClickException(
            f"{file} lacks 'loop', 'lines', 'settings' or 'sha256', by which its source is known"
        )
    if not all(sha256(content).hexdigest() in part["sha256"].values() for part in parts):
        raise click.ClickException(f"{source} is not the file that was proved: its hash is not in {file}")
    examined = look_through(decode(content, place.name), folder=folder_of(source), hints=False)
    for part in parts:
        choice = Choice(tuple(part["settings"]), part["loop"])
        block = choice.changed(open_block(source, choice.name, Loop, examined=examined)[0])
        if not is_of(part, block):
            raise click.ClickException(f"{file} is about another loop than '{block.name}' of {source}")
        if part["settings"]:
            say(f"'{block.name}' of {source} is proved with {' '.join(f'--set {s}' for s in part['settings'])}")
    return DONE


def _names_its_source(part: dict[str, Any]) -> bool:
    """Return whether a part has the name of its loop, its claims, settings and hashes, which describe its source."""
    texts = [part.get(key) for key in ("lines", "settings")]
    are_texts = all(isinstance(t, list) and all(isinstance(x, str) for x in t) for t in texts)
    return are_texts and isinstance(part.get("loop"), str) and isinstance(part.get("sha256"), dict)


def _opened(file: str, choice: Choice) -> Opened:
    """Return the blocks of a file, or the one named; undecided coverage is printed.

    Raises:
        DiagnosticError: With the mistakes of the file.
    """
    from fuzzyctl.analysis.coverage import coverage
    from fuzzyctl.model.system import FuzzySystem

    opened = open_blocks(file, choice)
    uncovered = opened.file.reported(d for system in opened.of(FuzzySystem) for d in coverage.diagnostics(system))
    errors = [d for d in uncovered if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)
    show(uncovered)
    return opened


def _fixed_format(text: str) -> Format:
    """Return the format of fixed point.

    Raises:
        BadParameter: For an unreadable format.
    """
    from fuzzyctl.codegen.fixed.fixed_format import to_format

    try:
        return to_format(text)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--fixed") from None


def _prove(proof: Proof, timeout: float, tell: Callable[[str], None] | None, setting: _Setting) -> None:
    """Prove the claims of a block; report each as soon as it is settled."""
    from fuzzyctl.analysis.prove import prover_of
    from fuzzyctl.model.loop import Loop

    if proof.block.unclaimed:
        if tell is not None:
            tell(f"{proof.file}: {proof.block.name}: no guarantees; {proof.block.unclaimed}")
        return
    if isinstance(proof.block, Loop):
        chip = None
        if setting.form is not None:
            from fuzzyctl.codegen.files import chip_of

            chip = chip_of(proof.block, str(setting.form))
        proof.prover = prover_of(proof.block, timeout, chip=chip, noise=setting.noise)
        proof.prover.settings = setting.choice.of_params(settable(proof.block)).settings
        if others := [f"--set {t}" for t in setting.choice.settings if t not in proof.prover.settings]:
            remark(f"note: {' '.join(others)} sets nothing in loop '{proof.block.name}', but in another block")
    else:
        proof.prover = prover_of(proof.block, timeout)
    prover = proof.prover
    proof.claims = len(prover.own)
    if tell is not None and not proof.claims:
        tell(f"{proof.file}: {proof.block.name}: no guarantees")
    for claim in prover.own:
        with status_line() as status:
            prover.progress = None if status is None else _of_boxes(status)
            verdict = prover.verdict(claim)
        proof.verdicts.append(verdict)
        if tell is not None:
            tell("\n".join(_lines(proof.file, verdict)))
    proof.tube = getattr(prover, "tube", None)


def _write_tube(path: Path, proofs: Sequence[Proof], tell: Callable[[str], None] | None) -> None:
    """Write the tube of the only loop that has one, a picture with runs of members or a table.

    Raises:
        DiagnosticError: For no loop or several, and when the file cannot be written.
    """
    from fuzzyctl.experiments.result_files import one_file, write_csv
    from fuzzyctl.model.loop import Loop

    having = [p for p in proofs if p.tube is not None]
    if len(having) != 1:
        count = f"{len(having)} loops have one" if having else "no loop has a claim 'require always' that is enclosed"
        help_text = "name the loop with --block NAME" if having else "a tube encloses the runs of a loop"
        raise DiagnosticError([Diagnostic("FZ218", f"there is not one tube to write: {count}", help=help_text)])
    loop, tube = having[0].block, having[0].tube
    assert isinstance(loop, Loop)
    assert tube is not None

    def fill(target: Path) -> None:
        if path.suffix.lower() == ".csv":
            columns = {"begin": tube.begin.tolist(), "end": tube.end.tolist()}
            for name, (least, greatest) in tube.bounds.items():
                columns |= {f"least {name}": least.tolist(), f"greatest {name}": greatest.tolist()}
            write_csv(target, columns)
            return
        from fuzzyctl.plot.style import saved
        from fuzzyctl.plot.time_series import draw_runs
        from fuzzyctl.simulation.members import members, runs
        from fuzzyctl.simulation.simulate import simulate

        with saved(target) as figure:
            draw_runs(figure, [simulate(loop)], [loop.name], tube, list(runs(loop, members(loop, _DRAWN))))

    with one_file(path) as files:
        files.write(path.name, fill)
        files.publish()
    if tell is not None:
        tell(f"wrote {path}")


def _of_boxes(report: Callable[[str], None]) -> Callable[[str, int, int], None]:
    """Return the progress callback of a prover."""
    return lambda claim, settled, open_: report(f"{claim}: {settled:,} boxes settled, {open_:,} open")


def _lines(file: str, verdict: Verdict) -> Iterator[str]:
    place = str(verdict.span).rpartition(":")[0] if verdict.span is not None else file
    yield f"{place}: {_word(verdict)}: {verdict.claim}"
    yield from (f"    {line}" for line in _details(verdict))


def _word(verdict: Verdict) -> str:
    return type(verdict).__name__.lower()


def _summary(proofs: Sequence[Proof]) -> str:
    """Return the numbers of guarantees that are proved, refuted, undecided, and not examined."""
    count = Counter(_word(v) for p in proofs for v in p.verdicts)
    count["left"] = sum(p.claims - len(p.verdicts) for p in proofs)
    words = ("proved", "refuted", "undecided", "left")
    return ", ".join(f"{count[word]} {word}" for word in words if count[word] or word == "proved")


def _details(verdict: Verdict) -> Iterator[str]:
    from fuzzyctl.analysis.verdicts import Refuted, Undecided

    if isinstance(verdict, Undecided):
        yield verdict.reason
        for box in verdict.boxes[:3]:
            yield "open: " + ", ".join(f"{n} {'=' if s.lower == s.upper else 'in'} {s}" for n, s in box.items())
        if verdict.remaining > len(verdict.boxes[:3]) > 0:
            yield f"and {verdict.remaining - len(verdict.boxes[:3])} more"
        return
    if isinstance(verdict, Refuted):
        yield str(verdict.witness)
    if verdict.note:
        yield verdict.note


def _as_data(proofs: Sequence[Proof], mistakes: Sequence[Diagnostic]) -> dict[str, Any]:
    groups: dict[str, Any] = {"systems": []}
    for proof in proofs:
        data = {"file": proof.file, **proof.block.identity, "guarantees": [_verdict_data(v) for v in proof.verdicts]}
        groups.setdefault(f"{proof.block.kind}s", []).append(data)
    return groups | {"diagnostics": [d.as_dict() for d in mistakes]}


def _verdict_data(verdict: Verdict) -> dict[str, Any]:
    from fuzzyctl.analysis.verdicts import Proved, Refuted

    data: dict[str, Any] = {
        "claim": verdict.claim,
        "line": verdict.span.line if verdict.span is not None else None,
        "verdict": _word(verdict),
    }
    if isinstance(verdict, Proved):
        return data | {"note": verdict.note or None}
    if isinstance(verdict, Refuted):
        w = verdict.witness
        values = {n: end_of_range(v) for n, v in w.sides}
        data |= {"witness": {"point": w.point, "other": w.other, "values": values}}
        return data | ({"note": verdict.note} if verdict.note else {})
    boxes = [{n: [end_of_range(s.lower), end_of_range(s.upper)] for n, s in box.items()} for box in verdict.boxes]
    return data | {"reason": verdict.reason, "boxes": boxes, "remaining": verdict.remaining}


#: Part of the time of a controller that is left for the work under way at its end; least time for its bounds [s].
_REST: Final = 0.25
_LEAST: Final = 0.1
#: Least time for the coverage of a system [s].
_SURE: Final = 0.5
#: Seconds that reading a byte of a system takes, beyond the first ones. Counted, as bounds of systems read no clock.
_BYTE: Final = 3.5 / (1 << 20)
_FREE: Final = 1 << 16
#: The same of an operation of a large system, which is planned, checked and compiled.
_OPERATION: Final = 5e-5
_FEW: Final = 10_000


def print_bounds(file: str, choice: Choice, timeout: float, form: str) -> int:
    """Print the bounds of the outputs of a system or controller, and the slopes of a system.

    Args:
        file: The file.
        choice: The block, its params and profile.
        timeout: Seconds that all bounds may take together.
        form: "text" or "json".
    """
    from fuzzyctl.analysis.extremes import extents
    from fuzzyctl.analysis.work import clock, written
    from fuzzyctl.kernels.plan.build import plan
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.system import FuzzySystem

    began = clock.used()
    kinds: list[Any] = [Controller, FuzzySystem]
    block, examined, _ = open_block(file, choice.name, *kinds)
    left = (1.0 - _REST) * timeout - (clock.used() - began)
    if block.kind == "controller":
        controller = choice.changed(block)
        _print_controller_bounds(controller, max(left, min(timeout, _LEAST)), form)
        return DONE
    # One half of the time is for the bounds, even if it is not known whether rules fire everywhere.
    with clock.limited(max(0.5 * left, _SURE)):
        system = load_checked(file, replace(choice, name=block.name), FuzzySystem, examined=examined)
    size = len(examined.source.text)
    spent = _BYTE * max(size - _FREE, 0) + _OPERATION * max(written(plan(system)) - _FEW, 0)
    # Small files without own hedges count operations well: the same bounds in every run, however busy the machine is.
    is_counted = not (spent or system.hedges)
    left = max(2.0 * timeout, 4.0 * _SURE) if is_counted else began + (1.0 - _REST) * timeout - clock.used()
    with clock.limited(left):
        bounds = extents(system, timeout=max(timeout - spent, 0.0))
    if form == "json":
        write_json({**system.identity, "outputs": [_extent_data(e) for e in bounds]})
    else:
        report("\n".join(line for e in bounds for line in _extent_lines(system, e)))
    return DONE


def _print_controller_bounds(controller: Controller, timeout: float, form: str) -> None:
    from fuzzyctl.analysis.induction.bounds import controller_bounds

    units = {s.name: s.unit for s in (*controller.results, *controller.states)}
    states = {s.name for s in controller.states}
    bounds = controller_bounds(controller, timeout)
    if form == "json":
        data = {
            n: {"name": n, "low": end_of_range(b.lo), "high": end_of_range(b.hi), "note": b.note or None}
            for n, b in bounds.items()
        }
        outputs, states_data = ([d for n, d in data.items() if (n in states) == wanted] for wanted in (False, True))
        write_json({**controller.identity, "outputs": outputs, "states": states_data})
        return
    for name, bound in bounds.items():
        report(f"{'state ' if name in states else ''}{_bound_line(name, bound.lo, bound.hi, units[name])}")
        if bound.note:
            report(f"  {bound.note}")


def _bound_line(name: str, low: float, high: float, unit: str) -> str:
    return f"{name}: from {low + 0.0:.9g} to {high + 0.0:.9g}{' ' + unit if unit else ''}"


def _extent_lines(system: FuzzySystem, extent: Extent) -> Iterator[str]:
    yield _bound_line(extent.name, extent.lo, extent.hi, system.output(extent.name).unit)
    for value, at in ((extent.lo_found, extent.lo_at), (extent.hi_found, extent.hi_at)):
        if at is not None and not math.isnan(value):
            yield f"  {value + 0.0:.9g} at {', '.join(f'{n} = {x + 0.0:.9g}' for n, x in at.items())}"
    slopes = [f"{s:.9g} along {n}" for n, s in extent.steepness.items() if math.isfinite(s)]
    if slopes:
        yield f"  slope at most {', '.join(slopes)}"
    unknown = [n for n, s in extent.steepness.items() if not math.isfinite(s)]
    if unknown:
        yield f"  no bound of the slope is known along {', '.join(unknown)}"
    if extent.note:
        yield f"  {extent.note}"


def _extent_data(extent: Extent) -> dict[str, Any]:
    return {
        "name": extent.name,
        "low": end_of_range(extent.lo),
        "high": end_of_range(extent.hi),
        "low_found": end_of_range(extent.lo_found),
        "low_at": extent.lo_at,
        "high_found": end_of_range(extent.hi_found),
        "high_at": extent.hi_at,
        "slopes": {n: end_of_range(s) for n, s in extent.steepness.items()},
        "note": extent.note or None,
    }
