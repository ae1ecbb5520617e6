"""docs/editors: the lines for each editor. Those that are installed start the server with them, without a window."""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.e2e.pages import DOCS, ROOT, blocks

PAGE = DOCS / "editors" / "README.md"
FILES = {block.file: block.text for block in blocks(PAGE) if block.file}
COMMAND = ["fuzzyctl", "lsp"]
TEXT = "system t\ninput x in [0, 1]\n  terms a b\noutput y in [0, 1]\n  terms p q\nif x is aa then y is p\n"
#: Seconds after which an editor hangs.
LIMIT = 300

LUA = """
vim.wait(1000 * LIMIT, function() return #vim.diagnostic.get(0) > 0 end, 50)
local at = { textDocument = { uri = vim.uri_from_bufnr(0) }, position = { line = 5, character = 3 } }
local function ask(method)
  for _, answer in pairs(vim.lsp.buf_request_sync(0, method, at, 1000 * LIMIT) or {}) do return answer.result end
end
local found = { hover = ask("textDocument/hover").contents.value, definition = ask("textDocument/definition").range }
for _, d in ipairs(vim.diagnostic.get(0)) do found.diagnostic = d.message end
local file = io.open("answers.json", "w")
file:write(vim.json.encode(found))
file:close()
vim.cmd("qall!")
""".replace("LIMIT", str(LIMIT))

LISP = """
(setq eglot-sync-connect LIMIT eglot-connect-timeout LIMIT)
(find-file "a.fz")
(apply #'eglot (eglot--guess-contact))
(flymake-mode 1)
(let ((limit (+ (float-time) LIMIT)))
  (while (and (null (flymake-diagnostics)) (< (float-time) limit))
    (flymake-start)
    (accept-process-output nil 0.1)))
(goto-char (point-min))
(search-forward "if x")
(backward-char 1)
(defun ask (method) (jsonrpc-request (eglot--current-server-or-lose) method (eglot--TextDocumentPositionParams)))
(with-temp-file "answers.json"
  (insert (json-encode
    (list :hover (plist-get (plist-get (with-current-buffer "a.fz" (ask :textDocument/hover)) :contents) :value)
          :definition (plist-get (with-current-buffer "a.fz" (ask :textDocument/definition)) :range)
          :diagnostic (with-current-buffer "a.fz" (flymake-diagnostic-text (car (flymake-diagnostics))))))))
(kill-emacs 0)
""".replace("LIMIT", str(LIMIT))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "a.fz").write_text(TEXT)
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(folder, name, text):
    (folder / name).write_text(text)
    return name


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True, timeout=2 * LIMIT, stdin=subprocess.DEVNULL)
    assert Path("answers.json").exists(), done.stdout + done.stderr
    return json.loads(Path("answers.json").read_text())


def require_answers(found):
    assert "input 'x' has no term 'aa'" in found["diagnostic"]
    assert "input x in [0, 1]" in found["hover"]
    assert found["definition"]["start"] == {"line": 1, "character": 6}


def test_neovim(folder):
    if shutil.which("nvim") is None:
        pytest.skip("Neovim is not installed")
    version = subprocess.run(["nvim", "--version"], capture_output=True, text=True).stdout
    found = re.search(r"v0\.(\d+)", version)
    if found is None or not 7 <= int(found[1]) <= 10:
        pytest.skip(f"the lines are for Neovim 0.7 to 0.10, not for {version.splitlines()[0]}")
    settings, drive = written(folder, "init.lua", FILES["init.lua"]), written(folder, "drive.lua", LUA)
    require_answers(run("nvim", "--headless", "-u", settings, "-i", "NONE", "a.fz", "-c", f"luafile {drive}"))


def test_emacs(folder):
    if shutil.which("emacs") is None:
        pytest.skip("Emacs is not installed")
    debian = '(add-to-list \'package-directory-list "/usr/share/emacs/site-lisp/elpa")'
    start = ["emacs", "--batch", "--eval", f"(progn (require 'package) {debian} (package-initialize))"]
    if subprocess.run([*start, "--eval", "(require 'eglot)"], capture_output=True).returncode:
        pytest.skip("Emacs has no eglot: it comes with Emacs 29, or as a package")
    settings, drive = written(folder, "init.el", FILES["init.el"]), written(folder, "drive.el", LISP)
    require_answers(run(*start, "--eval", "(require 'eglot)", "-l", settings, "-l", drive))


def test_helix():
    settings = tomllib.loads(FILES["languages.toml"])
    server = settings["language-server"]["fuzzyctl"]
    (language,) = settings["language"]
    assert [server["command"], *server["args"]] == COMMAND
    assert language["language-servers"] == ["fuzzyctl"]
    assert (language["name"], language["file-types"], language["comment-token"]) == ("fz", ["fz"], "#")


def test_kate():
    mode = ElementTree.fromstring(FILES["fz.xml"])
    (server,) = json.loads(FILES["kate.json"])["servers"].values()
    assert server["command"] == COMMAND
    assert re.search(server["highlightingModeRegex"], mode.attrib["name"])
    assert mode.attrib["extensions"] == "*.fz"
    styles = {item.attrib["name"] for item in mode.iter("itemData")}
    assert {node.attrib["attribute"] for node in mode.iter() if "attribute" in node.attrib} == styles


def test_the_mode_of_kate_colours(folder):
    highlighter = next(filter(None, map(shutil.which, ("kate-syntax-highlighter", "ksyntaxhighlighter6"))), None)
    if highlighter is None:
        pytest.skip("KSyntaxHighlighting is not installed")
    syntax = folder / "share" / "org.kde.syntax-highlighting" / "syntax"
    syntax.mkdir(parents=True)
    written(syntax, "fz.xml", FILES["fz.xml"])
    (folder / "a.fz").write_text('system t "Title"  # why\n')
    environment = os.environ | {"XDG_DATA_HOME": str(folder / "share"), "QT_QPA_PLATFORM": "offscreen"}
    command = [highlighter, "-f", "ansi", "a.fz"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=LIMIT)
    coloured = re.findall(r"\x1b\[[\d;]*m([^\x1b]+)", done.stdout)
    assert {'"Title"', "# why"} <= {part.strip() for part in coloured}, done.stdout + done.stderr
