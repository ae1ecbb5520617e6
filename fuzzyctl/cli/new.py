"""`fuzzyctl new`: an annotated rule file to begin with."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Final

import click

from fuzzyctl.cli.common import DONE, answers_with_diagnostics
from fuzzyctl.cli.streams import say
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.support.writing import written_whole

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
@answers_with_diagnostics
def new(name: str, out: str | None) -> int:
    """Write an annotated rule file to begin with.

    \b
    fuzzyctl new heater
    fuzzyctl check heater.fz
    fuzzyctl eval heater.fz error=2 change=0

    NAME is the name of the system: letters, digits and _. A file that is there is not overwritten.
    """
    _require_name(name)
    target = Path(out or f"{name}.fz")
    if os.path.lexists(target):
        message = "there is already a file of this name"
        raise DiagnosticError([Diagnostic("FZ005", message, file=str(target), help="name another file with -o FILE")])
    with written_whole(target) as temporary:
        temporary.write_text(starter(name), encoding="utf-8", newline="\n")
    say(f"wrote {target}")
    return DONE


def starter(name: str) -> str:
    """Return the rule file that `fuzzyctl new` writes, in its canonical layout."""
    from fuzzyctl.diagnostics.source import SourceText
    from fuzzyctl.lang.formatter import format_source

    return format_source(SourceText(name, _STARTER.format(name=name)))


def _require_name(name: str) -> None:
    """Refuse what cannot be the name of a system."""
    from fuzzyctl.lang.syntax import NAME, RESERVED

    if not re.fullmatch(NAME, name):
        reason = "a name has letters, digits and _, and begins with no digit"
        near = re.sub(r"\W+", "_", name).strip("_")
        hint = f"; '{near}' would do" if re.fullmatch(NAME, near) and near not in RESERVED else ""
        raise click.BadParameter(f"'{name}' is no name: {reason}{hint}", param_hint="NAME")
    if name in RESERVED:
        raise click.BadParameter(f"'{name}' is a word of the language", param_hint="NAME")
    if len(name) > LONGEST:
        raise click.BadParameter(f"the name has {len(name)} characters, more than {LONGEST}", param_hint="NAME")
