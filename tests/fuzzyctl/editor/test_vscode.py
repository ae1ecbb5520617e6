"""What the extension for VS Code promises in its files; `apps/vscode/test/run.mjs` drives it in an editor."""

import itertools
import json
import re
import shutil
import struct
import subprocess
from fnmatch import fnmatch
from pathlib import Path

import pytest

from fuzzyctl.testing import check_text

ROOT = Path(__file__).parents[3]
EXTENSION = ROOT / "apps" / "vscode"
PACKAGE = json.loads((EXTENSION / "package.json").read_text())
SNIPPETS = json.loads((EXTENSION / "snippets.json").read_text())


def written(body):
    """Return the texts of a snippet with its defaults, one for each alternative of a choice."""
    text = re.sub(r"\$\{\d+:([^}]*)\}|\$0", r"\1", "\n".join(body))
    parts = re.split(r"\$\{\d+\|([^}]*)\|\}", text)
    choices = [part.split(",") if k % 2 else [part] for k, part in enumerate(parts)]
    return ["".join(chosen) for chosen in itertools.product(*choices)]


BLOCKS = ("System", "Controller", "Plant", "Loop")
#: A system that has what the other snippets name, without an output.
AROUND = "system t\ninput rows in [-1, 1]\n  terms N Z P\ninput columns in [-1, 1]\n  terms N Z P\n"
OUTPUT = "output output in [-1, 1] else 0\n  terms N Z P\n"
RULE = "if rows is N then {} is N\n"
CONTEXTS = {
    "Input": (AROUND, OUTPUT + RULE.format("output")),
    "Output": (AROUND, RULE.format("name")),
    "Table of two inputs": (AROUND + OUTPUT, ""),
    "Rule": (AROUND.replace("rows", "input").replace(" N ", " term N ") + OUTPUT.replace(" N ", " term N "), ""),
    "Guarantee": (AROUND + OUTPUT + RULE.format("output"), ""),
}


def test_the_blocks_together_have_no_mistakes():
    blocks = [written(SNIPPETS[name]["body"])[0] for name in BLOCKS]
    assert errors("\n".join(blocks)) == []


@pytest.mark.parametrize("name", [name for name in SNIPPETS if name not in BLOCKS])
def test_a_statement_has_no_mistakes_in_a_system(name):
    before, after = CONTEXTS[name]
    for text in written(SNIPPETS[name]["body"]):
        assert errors(f"{before}{text}{after}") == []


def errors(text):
    # Nothing is proved: the snippets are to be changed.
    return [d.message for d in check_text(text, guarantees=False)[1] if d.severity == "error" and d.code != "FZ401"]


def test_the_grammar_is_that_of_the_docs():
    source, target = re.search(
        r'copyFileSync\("([^"]*tmLanguage.json)", "([^"]*)"\)', (EXTENSION / "build.mjs").read_text()
    ).groups()
    scope = json.loads((EXTENSION / source).read_text())["scopeName"]
    (grammar,) = PACKAGE["contributes"]["grammars"]
    assert (grammar["path"], grammar["scopeName"]) == (f"./{target}", scope)


def test_commands_and_settings_are_those_of_the_program():
    program = "".join(p.read_text() for p in sorted((EXTENSION / "src").glob("*.ts")))
    contributed = PACKAGE["contributes"]
    commands = {c["command"] for c in contributed["commands"]}
    assert set(re.findall(r'registerCommand\("([^"]+)"', program)) == commands
    assert {k["command"] for k in contributed["keybindings"]} <= commands
    assert '"fuzzyctl/preview"' in program
    assert "fuzzyctl.python" in contributed["configuration"]["properties"]


LOCKS = [
    [json.loads((folder / f"package{kind}.json").read_text()) for kind in ("", "-lock")]
    for folder in (EXTENSION, EXTENSION / "test")
]


@pytest.mark.parametrize(("package", "lock"), LOCKS)
def test_dependencies_are_pinned(package, lock):
    root = lock["packages"][""]
    for kind in ("dependencies", "devDependencies"):
        for name, version in package.get(kind, {}).items():
            assert root[kind][name] == version == lock["packages"][f"node_modules/{name}"]["version"]


@pytest.mark.parametrize(("_package", "lock"), LOCKS)
def test_packages_come_from_the_public_registry_as_they_were(_package, lock):
    for name, entry in lock["packages"].items():
        if name:
            assert entry["integrity"].startswith("sha512-")
            # No address: npm takes the registry that it is set to.
            assert entry.get("resolved", "https://registry.npmjs.org/").startswith("https://registry.npmjs.org/")


def test_the_package_holds_what_it_names():
    kept = [line[1:] for line in (EXTENSION / ".vscodeignore").read_text().split() if line.startswith("!")]
    contributed = PACKAGE["contributes"]
    named = [PACKAGE["main"], *(e["path"] for kind in ("grammars",) for e in contributed[kind])]
    named += [f"./{PACKAGE['icon']}", *re.findall(r"\]\((media/[^)]+)\)", (EXTENSION / "README.md").read_text())]
    named += [language["configuration"] for language in contributed["languages"]]
    for path in [*named, "./NOTICES.txt", "./LICENSE.txt"]:
        assert any(fnmatch(path.removeprefix("./"), pattern) for pattern in kept), path
        assert not path.removeprefix("./").startswith("media/") or (EXTENSION / path).exists()


def test_snippets_are_offered_by_the_program_at_the_beginning_of_a_line():
    assert "snippets" not in PACKAGE["contributes"]
    program = (EXTENSION / "src" / "extension.ts").read_text()
    assert 'import snippets from "../snippets.json"' in program
    assert 'registerCompletionItemProvider("fz"' in program


def test_the_package_shows_itself():
    width, height = struct.unpack(">II", (EXTENSION / PACKAGE["icon"]).read_bytes()[16:24])
    assert width == height >= 128
    assert {"fuzzy logic", "fuzzy control"} <= set(PACKAGE["keywords"])
    # The one marked place: the address of the repository once there is one.
    assert PACKAGE["repository"]["url"] == "https://REPOSITORY.invalid/fuzzyctl.git"


def test_greek_letters_have_no_boxes():
    assert (
        PACKAGE["contributes"]["configurationDefaults"]["[fz]"]["editor.unicodeHighlight.ambiguousCharacters"] is False
    )


class TestJob:
    """`job.sh` fails for what is wrong with the extension, and for nothing that is wrong with the machine."""

    @pytest.fixture
    def job(self, tmp_path):
        if shutil.which("bash") is None:
            pytest.skip("no bash")
        programs = tmp_path / "bin"
        programs.mkdir()
        for name in ("basename", "bash", "cat", "dirname", "env", "mktemp", "rm", "tail", "timeout"):
            (programs / name).symlink_to(shutil.which(name))

        def run(**scripts):
            for name, script in {"node": "", "npm": "", "chromium": "", **scripts}.items():
                if script is not None:
                    (programs / name).write_text(f"#!/usr/bin/env bash\n{script}\n")
                    (programs / name).chmod(0o755)
            job = EXTENSION / "test" / "job.sh"
            environment = {"PATH": str(programs), "TMPDIR": str(tmp_path)}
            done = subprocess.run([job, "python"], env=environment, capture_output=True, text=True, check=False)
            assert list(tmp_path.iterdir()) == [programs]
            return done.returncode, done.stdout.removeprefix("VS Code was not driven: ").strip()

        return run

    def test_checks_that_pass(self, job):
        given = "[[ $PYTHON == */python && $CHROMIUM == */chromium ]]"
        assert job(npm=f'[[ $* != *start ]] || {{ {given} && echo "$*"; }}') == (0, "--prefix test run --silent start")

    @pytest.mark.parametrize("name", ["node", "npm", "chromium"])
    def test_a_machine_that_cannot(self, job, name):
        assert job(**{name: None}) == (0, f"there is no '{name}'")

    @pytest.mark.parametrize(
        ("npm", "expected"),
        [
            ("[[ $* == ci* ]] && { echo no network; exit 1; }", (0, "no network\nits packages cannot be installed")),
            ("[[ $* == *start ]] && exit 77 || exit 0", (0, "it does not start here")),
            ("[[ $* == *start ]] && exit 124 || exit 0", (0, "that takes longer than 150 s here")),
            ("[[ $* == *start ]] && exit 1 || exit 0", (1, "a check failed, and is run again")),
            (
                "[[ $* == *package ]] && { echo a.ts:1; exit 2; } || [[ $* != *start ]] || echo not reached",
                (1, "a.ts:1"),
            ),
        ],
    )
    def test_what_fails(self, job, npm, expected):
        code, said = job(npm=npm)
        assert (code, said.replace("VS Code was not driven: ", "")) == expected
