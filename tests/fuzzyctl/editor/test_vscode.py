"""What the extension for VS Code promises in its files; `apps/vscode/test/run.mjs` drives it in an editor."""

import itertools
import json
import re
from pathlib import Path

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.editor.document import Document
from fuzzyctl.lang.highlight import textmate
from fuzzyctl.lang.parser import parse
from fuzzyctl.lang.syntax import BLOCK_KEYWORDS, STATEMENT_KEYWORDS

ROOT = Path(__file__).parents[3]
EXTENSION = ROOT / "apps" / "vscode"
PACKAGE = json.loads((EXTENSION / "package.json").read_text())
LOCK = json.loads((EXTENSION / "package-lock.json").read_text())
SNIPPETS = json.loads((EXTENSION / "snippets.json").read_text())


def written(body):
    """Return the texts of a snippet with its defaults, one for each alternative of a choice."""
    text = re.sub(r"\$\{\d+:([^}]*)\}|\$0", r"\1", "\n".join(body))
    parts = re.split(r"\$\{\d+\|([^}]*)\|\}", text)
    choices = [part.split(",") if k % 2 else [part] for k, part in enumerate(parts)]
    return ["".join(chosen) for chosen in itertools.product(*choices)]


@pytest.mark.parametrize("name", SNIPPETS)
def test_a_snippet_is_a_text_of_the_language(name):
    snippet = SNIPPETS[name]
    assert snippet["prefix"] in {*STATEMENT_KEYWORDS, *BLOCK_KEYWORDS}
    for text in written(snippet["body"]):
        assert parse(SourceText("a.fz", text))[1] == []


def test_the_blocks_together_have_no_mistakes():
    blocks = [written(SNIPPETS[name]["body"])[0] for name in ("System", "Controller", "Plant", "Loop")]
    assert [d.code for d in Document(SourceText("a.fz", "\n".join(blocks))).mistakes if d.severity == "error"] == []


def test_the_grammar_is_that_of_the_docs():
    source, target = re.search(
        r'copyFileSync\("([^"]*tmLanguage.json)", "([^"]*)"\)', (EXTENSION / "build.mjs").read_text()
    ).groups()
    assert json.loads((EXTENSION / source).read_text()) == textmate()
    (grammar,) = PACKAGE["contributes"]["grammars"]
    assert grammar["path"] == f"./{target}"
    assert grammar["scopeName"] == textmate()["scopeName"]


def test_commands_and_settings_are_those_of_the_program():
    program = "".join(p.read_text() for p in sorted((EXTENSION / "src").glob("*.ts")))
    contributed = PACKAGE["contributes"]
    commands = {c["command"] for c in contributed["commands"]}
    assert set(re.findall(r'registerCommand\("([^"]+)"', program)) == commands
    assert {k["command"] for k in contributed["keybindings"]} <= commands
    assert '"fuzzyctl/preview"' in program
    assert "fuzzyctl.python" in contributed["configuration"]["properties"]


def test_dependencies_are_pinned():
    for package, lock in [
        (PACKAGE, LOCK),
        *[[json.loads((EXTENSION / "test" / f"package{x}.json").read_text()) for x in ("", "-lock")]],
    ]:
        root = lock["packages"][""]
        for kind in ("dependencies", "devDependencies"):
            for name, version in package.get(kind, {}).items():
                assert root[kind][name] == version == lock["packages"][f"node_modules/{name}"]["version"]
