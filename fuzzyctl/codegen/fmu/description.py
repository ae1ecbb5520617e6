"""Descriptions in an FMU: modelDescription.xml, buildDescription.xml, and a page for people."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from html import escape
from typing import Final
from xml.sax.saxutils import quoteattr

from fuzzyctl import __version__
from fuzzyctl.codegen.fmu.model import Model, Variable

#: Options of a compiler for the C: sums and products are rounded one by one, as the kernel rounds them.
OPTIONS: Final = ("-std=c99", "-O2", "-ffp-contract=off")
_HEAD: Final = '<?xml version="1.0" encoding="UTF-8"?>'
_LOGS: Final = {
    "logEvents": "samples",
    "logStatusWarning": "inputs that are NaN",
    "logStatusError": "calls that are refused, and steps without a result",
}


def model_description(model: Model, version: int, files: Sequence[str]) -> str:
    """Return the text of modelDescription.xml.

    Args:
        model: The model.
        version: 2 or 3, of FMI.
        files: Names of the sources to compile.
    """
    body = [*(_interface2(model, files) if version == 2 else _interface3(model)), *_units(model), *_logs()]
    body += [f"  <DefaultExperiment{_attributes(stepSize=model.step)}/>", "  <ModelVariables>"]
    body += [f"    {line}" for line in (_variables2(model) if version == 2 else _variables3(model))]
    body += ["  </ModelVariables>", *(_structure2(model) if version == 2 else _structure3(model))]
    head = {"fmiVersion": f"{version}.0", "modelName": model.block}
    head["guid" if version == 2 else "instantiationToken"] = model.token
    head |= {"description": model.title, "generationTool": f"fuzzyctl {__version__}"}
    head["variableNamingConvention"] = "flat"
    return "\n".join([_HEAD, f"<fmiModelDescription{_attributes(**head)}>", *body, "</fmiModelDescription>"]) + "\n"


def build_description(model: Model, files: Sequence[str]) -> str:
    """Return the text of sources/buildDescription.xml of FMI 3."""
    sources = [f"      <SourceFile{_attributes(name=name)}/>" for name in files]
    options = _attributes(language="C99", compilerOptions=" ".join(OPTIONS))
    lines = [_HEAD, '<fmiBuildDescription fmiVersion="3.0">']
    lines += [f"  <BuildConfiguration{_attributes(modelIdentifier=model.name)}>", f"    <SourceFileSet{options}>"]
    lines += [*sources, "    </SourceFileSet>", '    <Library name="m"/>', "  </BuildConfiguration>"]
    return "\n".join([*lines, "</fmiBuildDescription>"]) + "\n"


def page(model: Model) -> str:
    """Return the text of documentation/index.html."""
    title = escape(xml_text(model.title or model.block))
    if model.period is not None:
        steps = f"It samples every {model.period!r} s from the start time on, whatever the communication steps are."
    else:
        steps = "Each communication step is a step of it."
    cells = [[f"<td>{escape(xml_text(cell))}</td>" for cell in row] for row in _rows(model)]
    rows = "".join(f"<tr>{''.join(row)}</tr>\n" for row in cells)
    return f"""<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{title}</title></head>
<body>
<h1>{title}</h1>
<p>{steps}</p>
<table border="1">
<tr><th>variable</th><th>is</th><th>range</th><th>unit</th><th>description</th></tr>
{rows}</table>
<pre>{escape(chr(10).join(model.about))}</pre>
</body>
</html>
"""


def _rows(model: Model) -> Iterator[tuple[str, ...]]:
    kinds = {"input": model.inputs, "output": model.outputs, "parameter": model.params, "constant": model.constants}
    for kind, variables in kinds.items():
        for v in variables:
            ends = f"{v.lower!r} to {v.upper!r}" if math.isfinite(v.lower) or math.isfinite(v.upper) else ""
            yield v.name, kind, ends, v.unit, v.label


def _attributes(**values: str | float | None) -> str:
    """Return attributes of XML; those without a value, and ranges without an end, are left out."""
    texts = {n: repr(v) if isinstance(v, float) else str(v) for n, v in values.items() if _is_given(v)}
    return "".join(f" {name}={quoteattr(xml_text(text))}" for name, text in texts.items())


def xml_text(text: str) -> str:
    """Return a text with a space in place of each character that XML has not."""
    return re.sub(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", " ", text)


def _is_given(value: str | float | None) -> bool:
    return value is not None and value != "" and not (isinstance(value, float) and math.isinf(value))


def _interface2(model: Model, files: Sequence[str]) -> Iterator[str]:
    able = ["canHandleVariableCommunicationStepSize", "canNotUseMemoryManagementFunctions"]
    able += ["canGetAndSetFMUstate", "canSerializeFMUstate"]
    yield f"  <CoSimulation{_attributes(modelIdentifier=model.name, **dict.fromkeys(able, 'true'))}>"
    yield from ("    <SourceFiles>", *(f"      <File{_attributes(name=name)}/>" for name in files))
    yield from ("    </SourceFiles>", "  </CoSimulation>")


def _interface3(model: Model) -> Iterator[str]:
    able = ("canGetAndSetFMUState", "canSerializeFMUState", "canHandleVariableCommunicationStepSize")
    values: dict[str, str | float | None] = {"modelIdentifier": model.name, **dict.fromkeys(able, "true")}
    yield f"  <CoSimulation{_attributes(**values, fixedInternalStepSize=model.period)}/>"


def _units(model: Model) -> Iterator[str]:
    units = dict.fromkeys(["s", *(v.unit for v in model.variables if v.unit)])
    yield "  <UnitDefinitions>"
    for unit in units:
        base = '<BaseUnit s="1"/></Unit>' if unit == "s" else ""
        yield f"    <Unit{_attributes(name=unit)}{f'>{base}' if base else '/>'}"
    yield "  </UnitDefinitions>"


def _logs() -> Iterator[str]:
    categories = [f"    <Category{_attributes(name=n, description=d)}/>" for n, d in _LOGS.items()]
    yield from ("  <LogCategories>", *categories, "  </LogCategories>")


def _kinds(model: Model) -> Iterator[tuple[Variable, dict[str, str]]]:
    """Yield each variable with its causality and variability."""
    yield from ((v, {"causality": "input", "variability": "continuous"}) for v in model.inputs)
    changes = "continuous" if model.period is None else "discrete"
    yield from ((v, {"causality": "output", "variability": changes, "initial": "calculated"}) for v in model.outputs)
    kind = {"causality": "parameter", "variability": "tunable", "initial": "exact"}
    yield from ((v, kind) for v in model.params)
    kind = {"causality": "local", "variability": "constant", "initial": "exact"}
    yield from ((v, kind) for v in model.constants)


def _number(v: Variable, kind: dict[str, str]) -> dict[str, str | float | None]:
    start = None if kind["causality"] == "output" else v.start
    return {"unit": v.unit, "min": float(v.lower), "max": float(v.upper), "start": start}


def _variables2(model: Model) -> Iterator[str]:
    for reference, (v, kind) in enumerate(_kinds(model), start=1):
        attributes = {n: t for n, t in kind.items() if (kind["causality"], n) != ("input", "initial")}
        head = _attributes(name=v.name, valueReference=str(reference), description=v.label, **attributes)
        yield f"<ScalarVariable{head}><Real{_attributes(**_number(v, kind))}/></ScalarVariable>"


def _variables3(model: Model) -> Iterator[str]:
    time = {"causality": "independent", "variability": "continuous", "unit": "s"}
    yield f"<Float64{_attributes(name=model.time, valueReference='0', **time)}/>"
    for reference, (v, kind) in enumerate(_kinds(model), start=1):
        head = {"name": v.name, "valueReference": str(reference), "description": v.label, **kind}
        yield f"<Float64{_attributes(**head, **_number(v, kind))}/>"


def _structure2(model: Model) -> Iterator[str]:
    # Of FMI 2 the number is the place among the variables, which is the reference here.
    unknowns = [f'      <Unknown index="{model.first_output + k}"/>' for k in range(len(model.outputs))]
    yield from ("  <ModelStructure>", "    <Outputs>", *unknowns, "    </Outputs>")
    yield from ("    <InitialUnknowns>", *unknowns, "    </InitialUnknowns>", "  </ModelStructure>")


def _structure3(model: Model) -> Iterator[str]:
    yield "  <ModelStructure>"
    for kind in ("Output", "InitialUnknown"):
        for k in range(len(model.outputs)):
            yield f'    <{kind} valueReference="{model.first_output + k}"/>'
    yield "  </ModelStructure>"
