"""Generated text as it stands in a file: changes of it are seen and meant.

After an intended change: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/golden, then read the difference.
"""

import os
from pathlib import Path

import pytest

from fuzzyctl import Controller, Plant, __version__, load
from fuzzyctl.analysis.prove import quickly
from fuzzyctl.codegen.files import generate
from fuzzyctl.codegen.fixed.fixed_format import to_format
from fuzzyctl.codegen.fixed.fixed_system import fixed_point
from fuzzyctl.codegen.fmu.archive import model_header
from fuzzyctl.codegen.fmu.calls import block_model, tunable
from fuzzyctl.codegen.fmu.description import model_description, page
from fuzzyctl.codegen.fmu.plants import plant_model
from fuzzyctl.codegen.prepare import prepare

HERE = Path(__file__).parent / "codegen"
RULES = Path(__file__).parents[2] / "rules"
VALVE = Path(__file__).parents[1] / "targets" / "valve.fz"

#: Folder of the golden files: rule file, target, format of fixed point, options.
CASES = {
    "c": ("ais_reaction", "c", None, {}),
    "c-float": ("boundary_layer", "c", None, {"precision": "float"}),
    "c-fixed": ("ais_reaction", "c", "Q3.12", {}),
    "c-table": ("boundary_layer", "c", None, {"table": 6}),
    "c-rules": ("tipper", "c", None, {}),
    "st-rules": ("tipper", "st", None, {}),
    "st": ("ais_reaction", "st", None, {}),
    "python": ("ais_reaction", "python", None, {}),
}
#: Descriptions and models of FMUs, by the version of FMI: of a controller, and of the plant of a file.
FMUS = {"fmu-2": 2, "fmu-3": 3}
#: The same for a controller: target, options.
STEPS = {
    "c-step": ("c", {}),
    "c-step-float": ("c", {"precision": "float"}),
    "st-step": ("st", {"guarded": True}),
    "python-step": ("python", {}),
}


def generated(case):
    """Return the files of a case without their self-test, in which all numbers stand."""
    if case in FMUS:
        path = RULES / "loops" / "water_tank.fz"
        text, controller = path.read_text(encoding="utf-8"), load(path, block=Controller)
        unit = prepare(controller, text, small=True, free=tunable(controller))
        files = {}
        for model in (block_model(unit), plant_model(load(path, block=Plant), text)):
            described = model_description(model, FMUS[case], [f"{model.name}.c", f"fmi{FMUS[case]}.c"])
            own = {"modelDescription.xml": described, "fmu_model.h": model_header(model), "index.html": page(model)}
            files |= {f"{model.name}-{name}": text.replace(model.token, "TOKEN") for name, text in own.items()}
        return without_version(unit, files)
    if case in STEPS:
        target, options = STEPS[case]
        unit = prepare(load(VALVE, block=Controller), VALVE.read_text(encoding="utf-8"), **options)
        return without_version(unit, generate(unit, target).files)
    rules, target, form, options = CASES[case]
    path = RULES / f"{rules}.fz"
    system = load(path)
    unit = prepare(system, path.read_text(encoding="utf-8"), verdicts=quickly(system)[0], **options)
    fixed = fixed_point(unit, to_format(form)) if form else None
    return without_version(unit, generate(unit, target, fixed).files)


def without_version(unit, files):
    return {
        name: text.replace(f"fuzzyctl {__version__}", "fuzzyctl VERSION").replace(unit.digest, "DIGEST")
        for name, text in files.items()
        if "_selftest" not in name
    }


@pytest.mark.parametrize("case", [*CASES, *STEPS, *FMUS])
def test_the_text_is_as_it_stands_in_the_file(case):
    # Under another suffix, so that tools take the files for texts.
    files = {f"{name}.txt": text for name, text in generated(case).items()}
    folder = HERE / case
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8", newline="\n")
    assert sorted(files) == sorted(p.name for p in folder.iterdir())
    for name, text in files.items():
        assert text == (folder / name).read_text(encoding="utf-8"), f"{case}/{name}"
