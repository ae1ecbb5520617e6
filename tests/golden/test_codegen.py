"""Generated text as it stands in a file: changes of it are seen and meant.

After an intended change: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/golden, then read the difference.
"""

import os
import re
import zipfile
from pathlib import Path

import pytest

from fuzzyctl import __version__
from fuzzyctl.testing import run_command

HERE = Path(__file__).parent / "codegen"
VALVE = Path(__file__).parents[1] / "targets" / "valve.fz"

#: Folder of the golden files: arguments of `fuzzyctl codegen`.
CASES = {
    "c": "ais_reaction --target c",
    "c-float": "boundary_layer --target c --float float",
    "c-fixed": "ais_reaction --target c --fixed Q3.12",
    "c-table": "boundary_layer --target c --table 6",
    "c-rules": "tipper --target c",
    "st-rules": "tipper --target st",
    "st": "ais_reaction --target st",
    "python": "ais_reaction --target python",
    "c-step": f"{VALVE} --target c",
    "c-step-float": f"{VALVE} --target c --float float",
    "st-step": f"{VALVE} --target st",
    "python-step": f"{VALVE} --target python",
}
#: Descriptions and models of FMUs, by the version of FMI: of a controller, and of the plant of a file.
FMUS = {"fmu-2": 2, "fmu-3": 3}
#: Characters that differ with each change of the rule file.
DIGEST = re.compile(r"(?<=sha256: )[0-9a-f]+|(?<=SHA-256 )[0-9a-f]+")


def generated(case, folder):
    """Return the files of a case without their self-test, in which all numbers stand."""
    if case not in FMUS:
        result = run_command("codegen", *CASES[case].split(), "-o", folder)
        assert result.exit_code == 0, result
        return {p.name: plain(p.read_text(encoding="utf-8")) for p in folder.iterdir() if "_selftest" not in p.name}
    files = {}
    for block in ("fuzzy_pi", "tank"):
        path = folder / f"{block}.fmu"
        words = ("codegen", "water_tank", "--block", block, "--target", "fmu", "--fmi", FMUS[case], "-o", path)
        assert run_command(*words).exit_code == 0
        with zipfile.ZipFile(path) as archive:
            texts = {n.rpartition("/")[2]: archive.read(n).decode() for n in archive.namelist() if n.endswith(SUFFIXES)}
        token = re.search(r'(?:instantiationToken|guid)="([^"]*)"', texts["modelDescription.xml"])[1]
        files |= {f"{block}-{name}": plain(text.replace(token, "TOKEN")) for name, text in texts.items()}
    return files


SUFFIXES = ("modelDescription.xml", "fmu_model.h", "index.html")


def plain(text):
    """Return a text without version and digest."""
    return DIGEST.sub("DIGEST", text.replace(f"fuzzyctl {__version__}", "fuzzyctl VERSION"))


@pytest.mark.parametrize("case", [*CASES, *FMUS])
def test_the_text_is_as_it_stands_in_the_file(case, tmp_path):
    # Under another suffix, so that tools take the files for texts.
    files = {f"{name}.txt": text for name, text in generated(case, tmp_path).items()}
    folder = HERE / case
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8", newline="\n")
    assert sorted(files) == sorted(p.name for p in folder.iterdir())
    for name, text in files.items():
        assert text == (folder / name).read_text(encoding="utf-8"), f"{case}/{name}"
