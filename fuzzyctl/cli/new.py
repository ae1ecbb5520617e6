"""`fuzzyctl new`: an annotated rule file to begin with."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import click

from fuzzyctl.cli.common import DONE, answers_with_diagnostics, suggestion
from fuzzyctl.cli.streams import say
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.support.writing import holds, write_together

#: Longest name that makes a file name everywhere.
LONGEST: Final = 200

_STARTER: Final = """\
# What the controller is for, in one line; everything after a number sign is a comment.
# fuzzyctl check finds mistakes, fuzzyctl show prints a summary, fuzzyctl plot-surface draws what is computed.

system {name} "A controller of two inputs"
source "where the rules and numbers come from"

and         min       # truth of `a is A and b is B`
implication min       # how far a rule's consequent holds
aggregation max       # how the rules are joined
defuzzifier centroid  # how the result becomes a number

param reach = 10  # a number with a name: fuzzyctl eval ... --set reach=20

# An input has a range, a unit, and terms; values outside the range count as its nearer end.
# `terms` makes triangles by their peaks: each reaches to the peaks beside it.
input error "Error" in [-reach, reach] unit "K"
  terms negative@(-reach / 2) zero@0 positive@(reach / 2)

# The same terms one by one: left foot, peak, right foot. An infinite foot makes a shoulder.
input change "Change of the error" in [-1, 1] unit "K/s"
  falling = triangle(-inf, -1, 0)
  steady  = triangle(-1, 0, 1)
  rising  = triangle(0, 1, inf)

# The output is computed for every input, since some rule always fires: fuzzyctl check proves it.
# Where none may fire, write `else VALUE` behind the range.
output power "Power" in [0, 100] unit "%"
  terms low medium high

# One cell for each combination of terms: the rows are those of `error`, the columns those of `change`.
# `.` is no rule, `low*0.5` a rule of half weight.
table power = error x change
             falling  steady  rising
  negative | high     high    medium
  zero     | high     medium  low
  positive | medium   low     low

# Rules can also be written out:
#   if error is positive and not change is falling then power is low

# What must hold whatever the inputs are.
require bounded(power, 0, 100)
"""


@click.command()
@click.argument("name")
@click.option("-o", "--output", "out", metavar="FILE", help="The file to write.  [default: NAME.fz]")
@click.option("--from", "base", metavar="SHIPPED", help="Copy a shipped file, with those that it uses.")
@click.option("--force", is_flag=True, help="Replace files that exist.")
@answers_with_diagnostics
def new(name: str, out: str | None, base: str | None, force: bool) -> int:
    """Write an annotated rule file to begin with, or a copy of a shipped one.

    \b
    fuzzyctl new heater
    fuzzyctl check heater.fz
    fuzzyctl eval heater.fz error=2 change=0
    fuzzyctl new tip --from tipper

    NAME is the name of the system: letters, digits and _. A file that is there is not overwritten without
    --force. 'fuzzyctl show' lists the shipped files.
    """
    _require_name(name)
    target = Path(out or f"{name}.fz")
    texts = {target: starter(name)} if base is None else copies(name, base, target)
    if not force:
        _refuse_to_replace(texts, target)
    fresh = {path: text for path, text in texts.items() if force or not os.path.lexists(path)}
    write_together(fresh)
    say("\n".join(f"wrote {path}" for path in fresh))
    return DONE


def _refuse_to_replace(texts: Mapping[Path, str], target: Path) -> None:
    """Refuse to replace files; those that the target uses may be there with the same text.

    Raises:
        DiagnosticError: With each that is there.
    """
    mistakes = []
    if os.path.lexists(target):
        message = "there is already a file of this name"
        help_text = "name another file with -o FILE, or replace it with --force"
        mistakes.append(Diagnostic("FZ005", message, file=str(target), help=help_text))
    for path, text in texts.items():
        if path == target or not os.path.lexists(path):
            continue
        if not holds(path, text):
            message = f"{target} uses a file of this name, and the present one differs from the shipped one"
            mistakes.append(Diagnostic("FZ005", message, file=str(path), help="name another folder with -o FILE"))
    if mistakes:
        raise DiagnosticError(mistakes)


def copies(name: str, base: str, target: Path) -> dict[Path, str]:
    """Return the text of a copy of a shipped file under another name, and of the files that it uses.

    Args:
        name: The new name of the block that is called like the shipped file, if there is one.
        base: The shipped file.
        target: The path of the copy.

    Raises:
        BadParameter: If there is no such shipped file, or it uses a file that is called like the copy.
    """
    from fuzzyctl.loading.assembly import files_read
    from fuzzyctl.support.files import LIST, shipped_files

    files = shipped_files()
    if base not in files:
        hint = " ".join(filter(None, (suggestion(base, files), LIST)))
        raise click.BadParameter(f"no shipped file '{base}'; {hint}", param_hint="--from")
    path = files[base]
    head = rf"(?m)^((?:system|controller|plant|loop) +){base}\b"
    text = re.sub(head, rf"\g<1>{name}", path.read_text(encoding="utf-8"))
    used = {target.parent / p.relative_to(path.parent): p.read_text(encoding="utf-8") for p in files_read(path)}
    if target in used:
        raise click.BadParameter(f"'{base}' uses a file of this name; take another one", param_hint="NAME")
    return {target: text, **used}


def starter(name: str) -> str:
    """Return the rule file that `fuzzyctl new` writes, in its canonical layout."""
    from fuzzyctl.diagnostics.source import SourceText
    from fuzzyctl.lang.formatter import format_source

    return format_source(SourceText(name, _STARTER.format(name=name)))


def _require_name(name: str) -> None:
    """Raise BadParameter for an invalid name of a system."""
    from fuzzyctl.lang.syntax import NAME, RESERVED

    if not re.fullmatch(NAME, name):
        reason = "a name has letters, digits and _, and does not begin with a digit"
        near = re.sub(r"\W+", "_", name).strip("_")
        hint = f"; '{near}' would do" if re.fullmatch(NAME, near) and near not in RESERVED else ""
        raise click.BadParameter(f"'{name}' is not a name: {reason}{hint}", param_hint="NAME")
    if name in RESERVED:
        raise click.BadParameter(f"'{name}' is a word of the language", param_hint="NAME")
    if len(name) > LONGEST:
        raise click.BadParameter(f"the name has {len(name)} characters, more than {LONGEST}", param_hint="NAME")
