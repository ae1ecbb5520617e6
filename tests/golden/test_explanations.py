"""Each diagnostic code has a page whose mistake gives the message it shows, and whose repair does not.

Pages whose mistake is made on a command line are run by tests/e2e/test_docs.py, like all pages.
After an intended change of wording: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/golden, then read the difference.
"""

import os
import re
from pathlib import Path

import pytest

from fuzzyctl.diagnostics.diagnostic import CODES
from fuzzyctl.testing import check_text, run_command
from tests.own_files import own_files

ROOT = Path(__file__).parent.parent.parent
FOLDER = ROOT / "docs" / "reference" / "diagnostics"
PAGES = {p.stem: p.read_text(encoding="utf-8") for p in sorted(FOLDER.glob("*.md"))}

#: A mistake in a rule file, its message, and the repair.
SHAPE = re.compile(
    r"""\#\ (?P<code>FZ\d{3}):\ (?P<title>[^\n]+)\n\n
    (?P<meaning>.+?)\n\n
    \#\#\ The\ mistake\n\n (?:[^`#<]+\n\n)?
    <!--\ file:\ (?P<file>\S+)\ -->\n ```fz\n (?P<mistake>.*?) ```\n\n
    ```text\n (?P<message>.*?) ```\n\n
    \#\#\ The\ repair\n\n (?:[^#]+?\n\n)?
    ```fz\n (?P<repair>.*?) ```\n""",
    re.VERBOSE | re.DOTALL,
)
WITH_FILE = [code for code, page in PAGES.items() if "```fz" in page and "```console" not in page]
#: Ctrl-C, and native code that crashes, give these; `tests/fuzzyctl/simulation` has both, and no example of a page.
BY_HAND = {"FZ707", "FZ713"}
WITH_COMMAND = [code for code, page in PAGES.items() if "```console" in page]


def _parts(code):
    match = SHAPE.fullmatch(PAGES[code])
    assert match, f"{code}.md has another shape than its fellows"
    return match


def test_every_code_has_a_page_and_every_page_a_code():
    assert list(PAGES) == list(CODES)


@pytest.mark.parametrize("code", PAGES)
def test_a_page_begins_with_code_and_title_and_says_what_it_means(code):
    title, meaning, *_ = PAGES[code].split("\n\n")
    assert title == f"# {code}: {CODES[code]}"
    assert meaning.strip()
    assert not meaning.startswith("#")


@pytest.mark.parametrize("code", WITH_FILE)
def test_the_mistake_gives_the_code_with_exactly_this_message(code, tmp_path):
    page = _parts(code)
    _, diagnostics = check_text(page["mistake"], page["file"], folder=tmp_path)
    message = "\n\n".join(map(str, diagnostics)) + "\n"
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        first, last = page.span("message")
        (FOLDER / f"{code}.md").write_text(PAGES[code][:first] + message + PAGES[code][last:], encoding="utf-8")
        return
    assert message == page["message"]
    assert {d.code for d in diagnostics} == {code}
    begins = {"A warning: ": "warning", "A hint, ": "hint"}
    kind = next((word for text, word in begins.items() if page["meaning"].startswith(text)), "error")
    assert {d.severity for d in diagnostics} == {kind}


@pytest.mark.parametrize("code", WITH_FILE)
def test_the_repair_leaves_nothing_to_say(code, tmp_path):
    page = _parts(code)
    systems, diagnostics = check_text(page["repair"], page["file"], folder=tmp_path)
    assert diagnostics == []
    assert systems


@pytest.mark.parametrize("code", WITH_COMMAND)
def test_a_command_shows_the_code(code):
    mistake = PAGES[code].split("## The repair")[0]
    assert f"[{code}]" in mistake or f"title={code}%3A" in mistake
    assert f"[{code}]" not in PAGES[code].removeprefix(mistake)


def test_codes_without_an_example_are_not_reported():
    modules = [*(ROOT / "fuzzyctl").rglob("*.py"), *own_files(ROOT / "apps", "*.py")]
    texts = [p.read_text(encoding="utf-8") for p in modules if p.name != "codes.py"]
    silent = {code for code in CODES if not any(f'"{code}"' in text for text in texts)}
    assert set(PAGES) - set(WITH_FILE) - set(WITH_COMMAND) - BY_HAND == silent
    assert [code for code in silent if "This version does not report it" not in PAGES[code]] == []


def test_the_command_shows_the_pages_of_a_checkout():
    assert CODES["FZ202"] in run_command("explain", "FZ202").output
