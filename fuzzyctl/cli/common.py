"""Shared parts of the commands: diagnostics on the terminal, `name=value` arguments, exit codes."""

from __future__ import annotations

import math
import re
import sys
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from typing import TYPE_CHECKING, Any, BinaryIO, Final, ParamSpec

import click

from fuzzyctl.cli.streams import painted, say, terminal_width, use_color, writable_output, write_data, write_json
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, FuzzyctlError, UnknownNameError, render_all
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.support.files import to_number

if TYPE_CHECKING:
    from fuzzyctl.kernels.kernel import Kernel
    from fuzzyctl.model.block import Block

#: Name of standard input in diagnostics; as an argument it is '-'.
STDIN: Final = "<stdin>"

#: Exit codes: done; diagnostics, refuted or diverged; wrong usage; undecided.
DONE: Final = 0
FAILED: Final = 1
USAGE: Final = 2
UNDECIDED: Final = 3
#: Codes of mistakes in arguments: a value is missing, a name is unknown, a value is not a number.
_OF_ARGUMENTS: Final = frozenset({"FZ501", "FZ502", "FZ503"})

P = ParamSpec("P")

FORMAT = click.option(
    "--format", "form", type=click.Choice(["text", "json"]), default="text", show_default=True, help="How to print."
)
DIAGNOSTICS_FORMAT = click.option(
    "--format",
    "form",
    type=click.Choice(["text", "json", "sarif", "github"]),
    default="text",
    show_default=True,
    help="How to print diagnostics: for people, as data, for code scanning, or as annotations of a GitHub workflow.",
)
SET = click.option(
    "--set", "settings", multiple=True, metavar="NAME=VALUE", help="Set a param of the system; may be repeated."
)
BLOCK = click.option("--block", "name", metavar="NAME", help="Which system, controller, plant or loop of the file.")
ALGORITHM = click.option(
    "--algorithm",
    # As kernels.algorithm.ALGORITHMS, which takes long to import.
    type=click.Choice(["auto", "interpolation", "active", "rules"]),
    default="auto",
    show_default=True,
    help="How it evaluates.",
)
POINTS = click.option(
    "--points",
    type=click.IntRange(2, 10_000_000),
    default=10_000,
    show_default=True,
    help="How many points to compare.",
)


def known_profiles(names: Iterable[str]) -> None:
    """Raise BadParameter for the first unknown profile.

    Raises:
        BadParameter: For an unknown name.
    """
    from fuzzyctl.model.profiles import PROFILES

    for name in names:
        if name not in PROFILES:
            hint = suggestion(name, PROFILES) or f"there are: {', '.join(PROFILES)}"
            raise click.BadParameter(f"no profile '{name}'; {hint}")


def _known_profile(_context: click.Context, _option: click.Parameter, profile: str | None) -> str | None:
    known_profiles([profile] if profile is not None else [])
    return profile


AS = click.option(
    "--as",
    "profile",
    metavar="PROFILE",
    callback=_known_profile,
    help="Compute as a tool does, such as matlab, fuzzylite or exact, whatever the file says.",
)


def _be_quiet(context: click.Context, _option: click.Parameter, quiet: bool) -> None:
    context.meta[_QUIET] = quiet


QUIET = click.option(
    "-q",
    "--quiet",
    is_flag=True,
    expose_value=False,
    callback=_be_quiet,
    help="Print errors only, no warnings and no hints.",
)
STATE = click.option(
    "--state",
    "state",
    multiple=True,
    metavar="NAME=VALUE",
    help="Set a number of the state; may be repeated.  [default: the initial state]",
)
SVG_TEXT = click.option("--svg-text", is_flag=True, help="Keep the texts of an SVG as text, not as outlines.")
#: Where a command keeps whether it is quiet, the warnings that it has printed, and whether it has read standard input.
_QUIET: Final = "fuzzyctl.quiet"
_PRINTED: Final = "fuzzyctl.printed"
_READ: Final = "fuzzyctl.read"


def show(diagnostics: Sequence[Diagnostic], form: str = "text") -> None:
    """Print diagnostics: as text on standard error, for machines on standard output."""
    if form == "text":
        before = bool(_meta().get(_PRINTED))
        if news := _unprinted(heard(diagnostics)):
            color, width = use_color(sys.stderr), terminal_width(sys.stderr)
            text = render_all(news, color=color, width=width, encoding=sys.stderr.encoding)
            click.echo(f"\n{text}" if before else text, file=sys.stderr)
        return
    from fuzzyctl.cli import reports

    text = {"json": reports.as_json, "sarif": reports.as_sarif, "github": reports.as_github}[form](diagnostics)
    if text:
        write_data(f"{text}\n")


def report(text: str) -> None:
    """Print a report on standard output; a terminal gets it in colour, with lines of its width."""
    stream = sys.stdout
    lines = painted(text, color=use_color(stream), width=terminal_width(stream), encoding=stream.encoding)
    click.echo(lines, file=stream)


def remark(text: str) -> None:
    """Print a line on standard error, unless the command is quiet."""
    if not _meta().get(_QUIET):
        say(text, err=True)


def heard(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics to print: with `--quiet` errors only."""
    return [d for d in diagnostics if d.severity == "error" or not _meta().get(_QUIET)]


def _unprinted(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return all errors, and the warnings and hints that this command has not printed."""
    before = _meta().setdefault(_PRINTED, set())
    news = [d for d in diagnostics if d.severity == "error" or (d.code, d.place, d.message) not in before]
    before.update((d.code, d.place, d.message) for d in news)
    return news


def _meta() -> dict[str, Any]:
    """Return the data that the stages of a command share."""
    context = click.get_current_context(silent=True)
    return context.meta if context is not None else {}


def answers_with_diagnostics(command: Callable[P, int | None]) -> Callable[P, None]:
    """Turn the errors of a command into a message and an exit code, never a traceback."""

    @wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            with writable_output():
                code = command(*args, **kwargs)
        except DiagnosticError as error:
            show(error.diagnostics, str(kwargs.get("form", "text")))
            code = code_of(error.diagnostics)
        except FuzzyctlError as error:
            if kwargs.get("form") == "json":
                write_json({"error": str(error)})
            say(f"error: {error}", err=True)
            code = USAGE if isinstance(error, UnknownNameError) else FAILED
        sys.exit(code or DONE)

    return run


def code_of(diagnostics: Iterable[Diagnostic]) -> int:
    """Return the exit code of a command that gives up: wrong usage where all mistakes are in the command line."""
    errors = [d for d in diagnostics if d.severity == "error"]
    return USAGE if errors and all(d.code in _OF_ARGUMENTS for d in errors) else FAILED


def standard_input() -> BinaryIO:
    """Return standard input as bytes, once in a command.

    Raises:
        UsageError: For a second '-'.
    """
    if _meta().get(_READ):
        raise click.UsageError("'-' is given twice, and standard input can be read once")
    _meta()[_READ] = True
    return sys.stdin.buffer


def assignments(texts: Iterable[str], names: Sequence[str], kind: str) -> dict[str, float]:
    """Read `name=value` arguments.

    Raises:
        DiagnosticError: With all unknown names, repeated names and values that are not numbers.
    """
    values: dict[str, float] = {}
    mistakes: list[Diagnostic] = []
    for text in texts:
        name, equals, number = _split(text, names)
        if not equals or not name:
            mistakes.append(
                Diagnostic("FZ503", f"'{text}' is not of the form NAME=VALUE", help=f"{kind}s: {_list(names)}")
            )
            continue
        if name not in names:
            mistakes.append(unknown(kind, name, names))
            continue
        if name in values:
            mistakes.append(Diagnostic("FZ502", f"{kind} '{name}' is given twice", help="give it once"))
            continue
        try:
            values[name] = to_number(number)
            if kind == "param" and not math.isfinite(values[name]):
                mistakes.append(Diagnostic("FZ503", f"param '{name}' = {number} is not a finite number"))
        except OverflowError:
            mistakes.append(Diagnostic("FZ503", f"{kind} '{name}' = {number} is larger than 1.8e308"))
        except ValueError:
            mistakes.append(_no_number(kind, name, number))
    if mistakes:
        raise DiagnosticError(mistakes)
    return values


def suggestion(name: str, names: Iterable[str]) -> str:
    """Return a question that names the closest name, or an empty text."""
    near = closest(name, names)
    return f"did you mean '{near}'?" if near else ""


def unknown(kind: str, name: str, names: Sequence[str]) -> Diagnostic:
    """Return the diagnostic of an unknown name of an argument."""
    facts = (f"{kind}s: {_list(names)}",)
    return Diagnostic("FZ502", f"no {kind} '{name}'", facts=facts, help=suggestion(name, names))


def _no_number(kind: str, name: str, text: str) -> Diagnostic:
    message = f"{kind} '{name}' is not a number: '{text}'"
    if not re.fullmatch(r"[-+]?\d+,\d+", text, re.ASCII):
        return Diagnostic("FZ503", message, help=f"the form is: {name}=NUMBER")
    fact = "decimals are written with a point"
    if re.fullmatch(r"[-+]?[1-9]\d{0,2},\d{3}", text):
        fact = f"{fact}, thousands without a separator: {text.replace(',', '')}"
    return Diagnostic("FZ503", message, facts=(fact,), help=f"write {name}={text.replace(',', '.')}")


def _split(text: str, names: Sequence[str]) -> tuple[str, str, str]:
    """Split `name=value` behind a known name, since names of other tools may hold the sign; else at the first sign."""
    parts = text.split("=")
    for count in range(len(parts) - 1, 0, -1):
        name = unicodedata.normalize("NFC", "=".join(parts[:count]).strip())
        if name in names:
            return name, "=", "=".join(parts[count:])
    name, equals, number = text.partition("=")
    return unicodedata.normalize("NFC", name.strip()), equals, number


def _list(names: Sequence[str]) -> str:
    return ", ".join(names) or "none"


def point_of(block: Any, texts: Iterable[str], command: str) -> dict[str, float]:
    """Return the point that `INPUT=VALUE` arguments of a command give; a controller without period may have `dt`.

    Raises:
        DiagnosticError: For mistakes in them, and for inputs without a value.
    """
    time = ["dt"] if block.is_sampled and block.period is None else []
    point = assignments(texts, [*(v.name for v in block.inputs), *time], "input")
    missing = missing_inputs(block, point, command)
    if time and "dt" not in point:
        from fuzzyctl.kernels.plan.expansion import equations_of

        if equations_of(block).reads_time:
            facts = ("the time since the step before [s]; the controller has no 'every' line",)
            missing.append(Diagnostic("FZ501", "'dt' has no value", facts=facts, help="write dt=SECONDS as well"))
    if missing:
        raise DiagnosticError(missing)
    return point


class NotNegative(click.FloatRange):
    """A number that is not negative, and finite if wanted; a NaN, which compares with nothing, is a mistake, too."""

    def __init__(self, *, finite: bool = False) -> None:
        super().__init__(min=0.0, max=math.inf if finite else None, max_open=finite)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number; the message is that of a range."""
        number = float(super().convert(value, param, ctx))
        if math.isnan(number):
            self.fail(f"{value} is not in the range x>=0.", param, ctx)
        return number


def plain(value: Any) -> Any:
    """Return data as JSON can have it, which knows no NaN and no infinity: null stands for them."""
    if isinstance(value, Mapping):
        return {k: plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def end_of_range(value: float) -> float | str | None:
    """Return an end of what something lies between: None for NaN, texts for infinities, which say where it is open."""
    if math.isnan(value):
        return None
    return value + 0.0 if math.isfinite(value) else ("inf" if value > 0 else "-inf")


def state_of(kernel: Kernel, texts: Iterable[str]) -> dict[str, float]:
    """Return the state that `NAME=VALUE` texts give, by name; see `states_of`."""
    return states_of(texts, kernel)[0]


def states_of(texts: Iterable[str], *kernels: Kernel) -> list[dict[str, float]]:
    """Return the state of each kernel by name: that of the start, with the numbers of `NAME=VALUE` texts that it has.

    Raises:
        DiagnosticError: For mistakes in them, and for blocks without a state.
    """
    texts, names = tuple(texts), list(dict.fromkeys(n for kernel in kernels for n in kernel.state_names))
    if texts and not names:
        help_text = "leave out --state: it is for outputs that adapt or hold, and for states of controllers"
        raise DiagnosticError([Diagnostic("FZ502", "the block has no state", help=help_text)])
    values = assignments(texts, names, "state")
    starts = [dict(zip(kernel.state_names, kernel.start().tolist(), strict=True)) for kernel in kernels]
    # NaN only if a start is NaN, too: an output that holds, before its first value.
    numbers = {name for start in starts for name, value in start.items() if not math.isnan(value)}
    mistakes = [
        _no_number("state", name, "nan") for name, value in values.items() if math.isnan(value) and name in numbers
    ]
    if mistakes:
        raise DiagnosticError(mistakes)
    return [{name: values.get(name, value) for name, value in start.items()} for start in starts]


def missing_inputs(block: Block, point: Mapping[str, float], command: str) -> list[Diagnostic]:
    """Report each input without a value."""
    form = " ".join(f"{v.name}=VALUE" for v in block.inputs)
    mistakes = []
    for variable in (v for v in block.inputs if v.name not in point):
        low, high = block.range_of(variable)
        unit = f" {variable.unit}" if variable.unit else ""
        facts = (f"its range is [{low:.6g}, {high:.6g}]{unit}",)
        help_text = f"write: fuzzyctl {command} FILE {form}"
        mistakes.append(Diagnostic("FZ501", f"input '{variable.name}' has no value", facts=facts, help=help_text))
    return mistakes


def outside_range(system: Block, values: dict[str, float]) -> list[Diagnostic]:
    """Warn of values that lie outside their input's range and are therefore clamped to it, as systems do."""
    warnings = []
    for variable in system.inputs if system.kind == "system" else ():
        if variable.extrapolate or variable.name not in values:
            continue
        low, high, value = system.number(variable.lower), system.number(variable.upper), values[variable.name]
        if value < low or value > high:
            unit = f" {variable.unit}" if variable.unit else ""
            consequence = f"taken as {min(max(value, low), high):.6g}"
            message = f"{variable.name} = {value:.6g}{unit} lies outside [{low:.6g}, {high:.6g}]; {consequence}"
            help_text = "widen the range in the file, or write 'extrapolate' behind it"
            warnings.append(Diagnostic("FZ504", message, severity="warning", help=help_text))
    return warnings
