"""Holds the reference pages to the code that they describe."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Callable, Iterator
from typing import Any

import click
import pytest
from lsprotocol import types as lsp
from pydantic import BaseModel

import fuzzyctl
from dwmr import find, read
from dwmr.cli.main import main as dwmr_commands
from fuzzyctl import build
from fuzzyctl.testing import check_text, run_command
from tests import shipped
from tests.commands import commands_of
from tests.commands import main as fuzzyctl_commands
from tests.e2e.pages import DOCS, without_code
from tests.golden.answers import Case

#: What an editor completes, by what is before it.
PLACES = {
    **{f"values of {word}": f"system t\n{word} ①" for word in "and or implication aggregation activation".split()},
    **{f"values of {word}": f"system t\n{word} ①" for word in ("defuzzifier", "semantics")},
    "hedges": "system t\ninput x in [0, 1]\n  terms a b\noutput y in [0, 1]\n  terms p q\nif x is ①",
    "membership functions": "system t\ninput x in [0, 1]\n  low = ①",
    "expressions": "system t\ninput x in [0, 1]\nlet y = ①",
    "operators": "controller c\noutput y = ①",
    "signals": "loop l\nlet r = ①",
    "measures": "loop l\nmeasure m = ①",
    "plants": "plant p = ①",
    "statements": "①",
}


def _completed(place: str) -> dict[str, tuple[str, str]]:
    """Return the words that an editor completes, each with its form and its meaning."""
    case = Case(PLACES[place])
    found = case.ask("textDocument/completion", lsp.CompletionParams(case.document, case.places[0])).items
    return {i.label: (i.detail or "", getattr(i.documentation, "value", i.documentation) or "") for i in found}


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
        listed = [line.split("  ", 1) for line in run_command("explain").output.splitlines()]
        assert rows == dict(listed)

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
        grammar = json.loads((DOCS / "editors" / "fz.tmLanguage.json").read_text(encoding="utf-8"))
        groups = re.findall(
            r"\((?:\?:)?([a-z_0-9]+(?:\|[a-z_0-9]+)+)\)", " ".join(p["match"] for p in grammar["patterns"])
        )
        words = {word for group in groups for word in group.split("|")} | {
            w for place in PLACES for w in _completed(place)
        }
        pages = ("language.md", "imported-files.md", "controllers.md", "plants.md", "loops.md", "semantics-profiles.md")
        page = "".join(without_code(DOCS / "reference" / name) for name in pages)
        shown = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`\n]+)`", page))))
        assert len(words) > 150
        assert sorted(words - shown - {"a", "b", "x"}) == []

    @pytest.mark.parametrize(
        ("name", "place"), [("loops.md", "signals"), ("loops.md", "measures"), ("plants.md", "plants")]
    )
    def test_every_form_is_described_as_the_editor_has_it(self, name: str, place: str) -> None:
        rows = dict(re.findall(r"^\| `(.*)` \| (.*) \|$", _reference(name), flags=re.MULTILINE))
        others = {**_completed("expressions"), **_completed("operators")}
        forms = {word: form for word, form in _completed(place).items() if word not in others}
        assert len(forms) > 4
        for form, what in forms.values():
            assert form in rows
            assert name == "plants.md" or rows[form] == what

    def test_every_membership_function_is_described_with_its_parameters(self) -> None:
        text = _reference("language.md") + _reference("imported-files.md")
        rows = dict(re.findall(r"^\| `(\w+)\(([^`]*)\)` \|", text, flags=re.MULTILINE))
        for name, (form, _) in _completed("membership functions").items():
            parameters = form.removeprefix(f"{name}(").removesuffix(")")
            assert rows[name].startswith(parameters.removesuffix(", ...")), name
            assert rows[name].endswith("...") == form.endswith("...)"), name

    def test_every_hedge_is_described_with_its_formula(self) -> None:
        rows = dict(re.findall(r"^\| `(\w+)` \| ([^|]+) \|$", _reference("language.md"), flags=re.MULTILINE))
        found = {name: what for name, (_, what) in _completed("hedges").items() if name != "any"}
        hedges = {name: what.removeprefix("of a degree x: ") for name, what in found.items() if what}
        assert len(hedges) > 4
        assert {name: rows.get(name) for name in hedges} == hedges

    @pytest.mark.parametrize(
        ("limit", "text"),
        [
            (100, "param a = " + 101 * "(" + "1" + 101 * ")"),
            (200, f"system {'a' * 201}"),
            (1000, "system s\ninput x in [0, 1]\n  terms " + " ".join(f"t{k}" for k in range(1001))),
            (200, "system s\n" + "".join(f"output y{k} in [0, 1]\n  terms a b\n" for k in range(201))),
            (1_000_000, "system s\ndefuzzifier centroid(resolution=1000001)"),
        ],
    )
    def test_a_limit_is_that_of_the_code(self, limit: int, text: str) -> None:
        rows = _reference("language.md").split("## Limits")[1].split("##")[0].replace("\u00a0", " ")
        assert re.search(rf"\| {limit:,}".replace(",", " ") + r"\b", rows)
        found = [f"{d.message} {' '.join(d.facts)} {d.help}" for d in check_text(text + "\n")[1]]
        assert any(re.search(rf"\b{limit}\b|\b{limit:,}\b", message) for message in found), found

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
        kinds, waiting = [], [fuzzyctl.FuzzyctlError]
        while waiting:
            kinds.append(kind := waiting.pop())
            waiting += [k for k in kind.__subclasses__() if k.__module__ == kind.__module__]
        own = {k.__name__: next((b.__name__ for b in k.__bases__ if b.__module__ == "builtins"), "") for k in kinds}
        assert own.pop("FuzzyctlError") == "Exception"
        assert rows == own
        assert [name for name in own if name not in fuzzyctl.__all__] == []

    def test_every_backend_and_algorithm_is_described(self) -> None:
        text = _reference("api.md").split("## `compile`")[1]
        for choice in ("backend", "algorithm"):
            with pytest.raises(fuzzyctl.FuzzyctlError, match="there are: ") as refused:
                fuzzyctl.compile(fuzzyctl.load("tipper"), **{choice: "other"})
            words = str(refused.value).partition("there are: ")[2].split(", ")
            assert [w for w in words if f'"{w}"' not in text] == []
            assert [w for w in words if f'"{w}"' not in str(fuzzyctl.compile.__doc__)] == []

    def test_every_shipped_rule_file_is_described(self) -> None:
        text = _reference("rule-files.md")
        assert [p.name for p in shipped.SYSTEMS if f"## `{p.name}`" not in text] == []

    def test_every_key_of_a_scenario_is_described(self) -> None:
        text = _reference("scenario.md")
        assert [k for k in sorted(set(_keys(type(read(find("paper")).scenario)))) if f"`{k}`" not in text] == []


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
