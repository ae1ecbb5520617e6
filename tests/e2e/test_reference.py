"""Holds the reference pages to the code that they describe."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from typing import Any, get_args

import click
import pytest
from pydantic import BaseModel

import fuzzyctl
from dwmr.cli.main import main as dwmr_commands
from dwmr.scenario.model import Scenario
from fuzzyctl import expr, formulas
from fuzzyctl.building import build
from fuzzyctl.cli.main import main as fuzzyctl_commands
from fuzzyctl.diagnostics import diagnostic
from fuzzyctl.kernels.algorithms.select import ALGORITHMS
from fuzzyctl.kernels.compile import BACKENDS
from fuzzyctl.lang import syntax
from fuzzyctl.lang.grammar import grammar_text
from fuzzyctl.lang.mistakes import BLOCK_FORMS
from fuzzyctl.lang.syntax import MAX_NAME
from fuzzyctl.loading.assembly import MAX_FILES
from fuzzyctl.model.forms import Form
from fuzzyctl.model.loop import MEASURES, SIGNALS
from fuzzyctl.model.method import ACTIVATIONS, DEFUZZIFIERS, Grid
from fuzzyctl.model.plant import PLANTS
from fuzzyctl.model.profiles import PROFILES
from fuzzyctl.model.stateful_operators import OPERATORS
from fuzzyctl.model.variable import Fallback
from fuzzyctl.resolve.block_names import FUNCTIONS
from fuzzyctl.resolve.rules import CLAIM_FORMS, MAX_OUTPUTS, MAX_RULES
from fuzzyctl.resolve.settings import RESOLUTIONS
from fuzzyctl.resolve.variables import MAX_TERMS
from tests import shipped
from tests.commands import commands_of
from tests.e2e.pages import DOCS, without_code


def _reference(name: str) -> str:
    return (DOCS / "reference" / name).read_text(encoding="utf-8")


def _options(text: str) -> set[str]:
    return set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", text))


class TestReference:
    """The reference pages name what there is, and nothing else."""

    def test_the_index_links_every_page(self) -> None:
        # The pages of the diagnostic codes hang below their own index.
        indexes = [DOCS / "index.md", DOCS / "reference" / "diagnostics.md"]
        linked = {
            (index.parent / t).resolve()
            for index in indexes
            for t in re.findall(r"\]\(([^)#]+)", index.read_text(encoding="utf-8"))
        }
        assert {p for p in DOCS.rglob("*.md") if p.name != "index.md"} <= linked

    def test_every_diagnostic_code_is_listed_with_its_title(self) -> None:
        form = r"^\| \[(FZ\d{3})\]\(diagnostics/\1\.md\) \| ([^|]+?) \|"
        rows = dict(re.findall(form, _reference("diagnostics.md"), flags=re.MULTILINE))
        assert rows == diagnostic.CODES

    @pytest.mark.parametrize("program", ["fuzzyctl", "dwmr"])
    def test_the_options_of_every_command_are_those_it_has(self, program: str) -> None:
        group = {"fuzzyctl": fuzzyctl_commands, "dwmr": dwmr_commands}[program]
        assert isinstance(group, click.Group)
        sections = dict(re.findall(r"^## (.+?)\n(.*?)(?=^## |\Z)", _reference("commands.md"), flags=re.M | re.S))
        described = {title.strip("`") for title in sections if title.startswith(f"`{program} ")}
        assert described == {f"{program} {name}" for name in commands_of(group)}
        for name, command in commands_of(group).items():
            text = re.sub(r"^```.*?^```$", "", sections[f"`{program} {name}`"], flags=re.M | re.S)
            has = {o for p in command.params if isinstance(p, click.Option) for o in p.opts}
            rows = "\n".join(re.findall(r"^\| (`-.*?) \|", text, flags=re.MULTILINE))
            assert _options(rows) == has, f"{program} {name}"
            assert _options(text) == has, f"{program} {name}"

    @pytest.mark.parametrize("program", ["fuzzyctl", "dwmr"])
    def test_the_choices_and_defaults_of_every_option_are_those_it_has(self, program: str) -> None:
        group = {"fuzzyctl": fuzzyctl_commands, "dwmr": dwmr_commands}[program]
        sections = dict(re.findall(r"^## `(.+?)`\n(.*?)(?=^## |\Z)", _reference("commands.md"), flags=re.M | re.S))
        for name, command in commands_of(group).items():
            rows = re.findall(r"^\| (`-.*?) \| (.*)$", sections[f"{program} {name}"], flags=re.MULTILINE)
            described = {option: forms + text for forms, text in rows for option in _options(forms)}
            for option in (p for p in command.params if isinstance(p, click.Option)):
                words = list(option.type.choices) if isinstance(option.type, click.Choice) else []
                if isinstance(option.default, str | int | float) and not isinstance(option.default, bool):
                    words.append(f"{option.default}".removesuffix(".0"))
                assert [w for w in words if w not in described[option.opts[-1]]] == [], f"{program} {name} {option}"

    def test_every_public_name_is_described(self) -> None:
        text = _reference("api.md")
        assert [n for n in fuzzyctl.__all__ if f"`{n}" not in text and f".{n}" not in text] == []

    def test_every_word_of_the_language_is_described(self) -> None:
        keywords = re.findall(r"^[A-Z_]+\.\d: /(\w+)", grammar_text(), flags=re.MULTILINE)
        assert set(syntax.STATEMENT_KEYWORDS) <= set(keywords)
        words = [
            *keywords,
            *syntax.RESERVED,
            *formulas.CONJUNCTIONS,
            *formulas.DISJUNCTIONS,
            *formulas.IMPLICATIONS,
            *formulas.AGGREGATIONS,
            *formulas.HEDGES,
            *ACTIVATIONS,
            *DEFUZZIFIERS,
            *PROFILES,
            *CLAIM_FORMS,
            *get_args(Fallback),
            *get_args(Grid),
            *expr.FUNCTIONS,
            *expr.CONSTANTS,
            *BLOCK_FORMS,
            *OPERATORS,
            *FUNCTIONS,
        ]
        pages = ("language.md", "imported-files.md", "controllers.md", "plants.md", "loops.md")
        page = "".join(without_code(DOCS / "reference" / name) for name in pages)
        shown = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`\n]+)`", page))))
        assert [w for w in words if w not in shown] == []

    @pytest.mark.parametrize(("name", "forms"), [("loops.md", SIGNALS), ("loops.md", MEASURES), ("plants.md", PLANTS)])
    def test_every_form_is_described_as_the_code_has_it(self, name: str, forms: dict[str, Form]) -> None:
        rows = dict(re.findall(r"^\| `(.*)` \| (.*) \|$", _reference(name), flags=re.MULTILINE))
        assert [f.form for f in forms.values() if f.form not in rows] == []
        assert name == "plants.md" or {f.form: rows[f.form] for f in forms.values()} == {
            f.form: f.what for f in forms.values()
        }

    def test_every_membership_function_is_described_with_its_parameters(self) -> None:
        text = _reference("language.md") + _reference("imported-files.md")
        rows = dict(re.findall(r"^\| `(\w+)\(([^`]*)\)` \|", text, flags=re.MULTILINE))
        for name, formula in formulas.MEMBERSHIP.items():
            assert rows[name].startswith(", ".join(formula.parameters)), name
            assert rows[name].endswith("...") == formula.variadic, name

    def test_every_hedge_is_described_with_its_formula(self) -> None:
        rows = dict(re.findall(r"^\| `(\w+)` \| ([^|]+) \|$", _reference("language.md"), flags=re.MULTILINE))
        assert {name: rows.get(name) for name in formulas.HEDGES} == {
            name: hedge.summary for name, hedge in formulas.HEDGES.items()
        }

    def test_the_limits_are_those_of_the_code(self) -> None:
        text = _reference("language.md").split("## Limits")[1].split("##")[0].replace("\u00a0", " ")
        limits = [expr.MAX_DEPTH, MAX_NAME, MAX_TERMS, MAX_OUTPUTS, MAX_RULES, MAX_FILES, RESOLUTIONS[1]]
        assert [n for n in limits if f"| {n:,}".replace(",", " ") not in text and f"| {n}" not in text] == []

    def test_every_name_of_the_build_module_is_described(self) -> None:
        text = _reference("api.md")
        assert [n for n in build.__all__ if f"`build.{n}(" not in text] == []

    def test_every_signature_is_that_of_the_code(self) -> None:
        """The page has the parameters and defaults of every public function, and no others."""
        text = _reference("api.md")
        functions = _functions()
        assert [s for s in (_signature(n, f) for n, f in functions.items()) if f"`{s}`" not in text] == []
        calls = re.findall(r"`([\w.]+)(\([^`]*\))`", text)
        assert [n for n, _ in calls if n.startswith(("fuzzyctl.", "build.")) and n not in functions] == []
        for name, given in calls:
            if name in functions:
                known = inspect.signature(functions[name]).parameters
                assert set(re.findall(r"[(, ](\w+)=", given)) <= set(known), name + given

    def test_every_docstring_names_the_parameters_and_no_private_function(self) -> None:
        for name, function in _functions().items():
            doc, known = str(function.__doc__), [p for p in inspect.signature(function).parameters if p != "self"]
            assert len(known) == 1 or [p for p in known if f" {p}" not in doc] == [], name
            assert "examine" not in doc, name

    def test_every_exception_is_listed_with_its_base(self) -> None:
        rows = dict(re.findall(r"^\| `(\w+Error)` \|[ `]*(\w*)`? \|", _reference("api.md"), flags=re.MULTILINE))
        kinds = [
            k for k in vars(diagnostic).values() if isinstance(k, type) and issubclass(k, diagnostic.FuzzyctlError)
        ]
        own = {k.__name__: next((b.__name__ for b in k.__bases__ if b.__module__ == "builtins"), "") for k in kinds}
        assert own.pop("FuzzyctlError") == "Exception"
        assert rows == own
        assert [name for name in own if name not in fuzzyctl.__all__] == []

    def test_every_backend_and_algorithm_is_described(self) -> None:
        text = _reference("api.md").split("## `compile`")[1]
        assert [w for w in (*BACKENDS, *ALGORITHMS) if f'"{w}"' not in text] == []
        assert [w for w in (*BACKENDS, *ALGORITHMS) if f'"{w}"' not in str(fuzzyctl.compile.__doc__)] == []

    def test_every_shipped_rule_file_is_described(self) -> None:
        text = _reference("rule-files.md")
        assert [p.name for p in shipped.SYSTEMS if f"## `{p.name}`" not in text] == []

    def test_every_key_of_a_scenario_is_described(self) -> None:
        text = _reference("scenario.md")
        assert [k for k in sorted(set(_keys(Scenario))) if f"`{k}`" not in text] == []


def _functions() -> dict[str, Callable[..., Any]]:
    """Return the public functions by the names that the page has for them."""
    found = {f"fuzzyctl.{n}": getattr(fuzzyctl, n) for n in fuzzyctl.__all__}
    found |= {f"build.{n}": getattr(build, n) for n in build.__all__}
    return {n: f for n, f in found.items() if inspect.isfunction(f)} | {
        "kernel.batch": fuzzyctl.Kernel.batch,
        "kernel.next_state": fuzzyctl.Kernel.next_state,
    }


def _signature(name: str, function: Callable[..., Any]) -> str:
    """Return a function with its parameters and defaults as the page prints them."""
    found = inspect.signature(function)
    kept = [p.replace(annotation=p.empty) for p in found.parameters.values() if p.name != "self"]
    return f"{name}{found.replace(parameters=kept, return_annotation=found.empty)}".replace("'", '"')


def _keys(model: type[BaseModel]) -> Iterator[str]:
    """Yield the keys of a scenario's section and of those below it."""
    for name, field in model.model_fields.items():
        yield name
        for below in _models(field.annotation):
            yield from _keys(below)


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in getattr(annotation, "__args__", ()):
        yield from _models(argument)
