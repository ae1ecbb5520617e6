"""`fuzzyctl explain`: the meaning of a diagnostic code, with a mistake, its message and the repair."""

from __future__ import annotations

import re
import sys

import click

from fuzzyctl.cli.common import DONE, FORMAT, answers_with_diagnostics
from fuzzyctl.cli.reports import read_page
from fuzzyctl.cli.streams import say, use_color, write_json
from fuzzyctl.diagnostics.diagnostic import CODES
from fuzzyctl.diagnostics.suggestions import did_you_mean


@click.command()
@click.argument("code", required=False)
@FORMAT
@answers_with_diagnostics
def explain(code: str | None, form: str) -> int:
    """Explain a diagnostic code, with or without its letters, or list all of them.

    \b
    fuzzyctl explain FZ203
    """
    if code is None:
        _list(form)
        return DONE
    name = f"FZ{code:0>3}" if code.isdecimal() and code.isascii() else code.upper()
    if name not in CODES:
        same = f"FZ{re.sub('[^0-9]', '', code):0>3}"
        near = f"did you mean '{same}'?" if same in CODES else did_you_mean(name, CODES)
        hint = near or "'fuzzyctl explain' lists the codes"
        raise click.BadParameter(f"no diagnostic code '{code}'; {hint}", param_hint="CODE")
    page = read_page(name)
    if form == "json":
        data = {"code": name, "title": CODES[name], "page": page.markdown if page else None}
        write_json(data)
    elif page is None:
        say(f"{name}: {CODES[name]}\n\nThe pages that explain the codes are missing from this installation.")
    else:
        click.echo(page.laid_out(color=use_color(sys.stdout)), nl=False, file=sys.stdout)
    return DONE


def _list(form: str) -> None:
    if form == "json":
        codes = [{"code": code, "title": title} for code, title in CODES.items()]
        write_json({"codes": codes})
        return
    for code, title in CODES.items():
        say(f"{code}  {title}")
