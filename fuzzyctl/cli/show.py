"""`fuzzyctl show`: a rule file on one page."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import click

from fuzzyctl.cli.common import ALGORITHM, DONE, FORMAT, QUIET, answers_with_diagnostics
from fuzzyctl.cli.loading import Choice, chooses, open_block, open_blocks
from fuzzyctl.cli.streams import say, use_color, write_json
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.support.files import first_sentence, shipped_groups


@click.command("show")
@click.argument("file", required=False)
@click.option("--plan", "only_plan", is_flag=True, help="Print how it is computed, and why.")
@ALGORITHM
@FORMAT
@chooses
@QUIET
@answers_with_diagnostics
def show_system(
    file: str | None,
    only_plan: bool,
    algorithm: str,
    form: str,
    choice: Choice,
) -> int:
    """Print a summary of a rule file; without FILE, the shipped files.

    The summary has ranges and terms with computed numbers, the method with its defaults, the rules, and proved facts:
    the range of each output, and whether some rule fires everywhere. All systems of a file are printed unless --block
    names one. For controllers, plants and loops it prints params, signals, states and equations in the order in which
    they are computed. With --plan, --algorithm shows another choice, or why the system does not allow it.
    """
    if algorithm != "auto" and not only_plan:
        raise click.BadParameter("it is about how a system is computed: add --plan", param_hint="--algorithm")
    if file is None:
        if only_plan or choice != Choice():
            raise click.UsageError("--plan, --set, --block and --as need a FILE")
        _list_shipped(form)
        return DONE
    from fuzzyctl.display.summary import summary
    from fuzzyctl.display.systems import page_text

    opened = open_blocks(file, choice)
    systems = opened.of(FuzzySystem)
    if only_plan:
        called = systems or [s for block in opened.blocks for s in block.all_systems if choice.name is not None]
        called = called or [open_block(file, choice.name, FuzzySystem, examined=opened.file)[0]]
        return _show_plan(called, algorithm, form)
    pages = [summary(system) for system in systems]
    others: list[dict[str, Any]] = []
    if len(opened.blocks) > len(systems):
        from fuzzyctl.display.summary import block_summary
        from fuzzyctl.model.controller import EquationBlock

        others = [block_summary(block) for block in opened.of(EquationBlock)]
    if form == "json":
        several = {"systems": pages} | ({"blocks": others} if others else {})
        write_json((*pages, *others)[0] if len(pages) + len(others) == 1 else several)
        return DONE
    pages += others
    bold = (lambda text: f"\x1b[1m{text}\x1b[0m") if use_color(sys.stdout) else str
    click.echo("\n".join(page_text(page, bold) for page in pages), nl=False, file=sys.stdout)
    return DONE


def _list_shipped(form: str) -> None:
    """Print the shipped files with the first sentence of each."""
    groups = {group: {n: first_sentence(p) for n, p in files.items()} for group, files in shipped_groups().items()}
    if form == "json":
        write_json(groups)
        return
    width = max(len(name) for files in groups.values() for name in files)
    for group, files in groups.items():
        say("\n".join([group, *(f"  {name:{width}}  {text}" for name, text in files.items()), ""]))
    say("A name stands for the file: fuzzyctl show tipper, fuzzyctl sweep water_tank_gains.")
    say("A copy to change: fuzzyctl new tip --from tipper.")


def _show_plan(systems: Sequence[FuzzySystem], algorithm: str, form: str) -> int:
    from fuzzyctl.display.plan_summary import plan_text, planned

    plans = [planned(system, algorithm) for system in systems]
    if form == "json":
        write_json(plans[0] if len(plans) == 1 else {"systems": plans})
    else:
        say("\n\n".join(map(plan_text, plans)))
    return DONE
