"""Text of `fmu_model.h`: the model of an FMU, as the C that all FMUs share reads it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from fuzzyctl.codegen.c_source import comment
from fuzzyctl.codegen.c_text import INDENT
from fuzzyctl.codegen.comments import printable
from fuzzyctl.codegen.fmu.model import Model, Variable, c_text


def model_header(model: Model) -> str:
    """Return the text of `fmu_model.h`."""
    lines = [*comment([f"Model of the FMU '{printable(model.block)}', for fmu_core.h."])]
    lines += ["#ifndef FMU_MODEL_H", "#define FMU_MODEL_H", "", "#include <float.h>", "#include <stddef.h>", ""]
    lines += [*(f'#include "{name}"' for name in model.sources if name.endswith(".h")), "", *_constants(model), ""]
    lines += [*_variables(model), "", *_memory(model), "", *model.helpers, *([""] if model.helpers else [])]
    lines += ["static void fmu_begin(fmu_Model *model)", "{", *_in(model.begin), "}", ""]
    lines += ["// Make a step of dt seconds. Returns why there is none, NULL where all is well."]
    lines += ["static const char *fmu_make(fmu_Model *model, double dt)", "{", *_in(model.make), "}"]
    return "\n".join([*lines, "", "#endif // FMU_MODEL_H"]) + "\n"


def _constants(model: Model) -> Iterator[str]:
    yield f"#define FMU_TOKEN {c_text(model.token)}"
    yield "// References of variables; that of the time is 0."
    references = {
        "FIRST_INPUT": 1,
        "FIRST_OUTPUT": model.first_output,
        "FIRST_PARAM": model.first_param,
        "FIRST_CONSTANT": model.first_constant,
        "VALUES": 1 + len(model.variables),
    }
    yield from (f"#define FMU_{name} {reference}U" for name, reference in references.items())
    yield f"#define FMU_SAMPLED {int(model.period is not None)}"
    if model.period is not None:
        yield f"#define FMU_PERIOD {model.period!r} // [s]"
    yield f"#define FMU_PREVIEW {model.preview!r} // dt of the outputs before the first step [s]"


def _variables(model: Model) -> Iterator[str]:
    yield from ("typedef struct {", f"{INDENT}const char *name;", f"{INDENT}double start;")
    yield from (f"{INDENT}double lower;", f"{INDENT}double upper;", "} fmu_Variable;", "")
    yield "static const fmu_Variable fmu_variables[FMU_VALUES] = {"
    for v in (Variable(model.time), *model.variables):
        yield f"{INDENT}{{{c_text(v.name)}, {_number(v.start)}, {_number(v.lower)}, {_number(v.upper)}}},"
    yield "};"


def _number(value: float) -> str:
    """Return a number; one without end is the largest, since variables are finite."""
    return ("DBL_MAX" if value > 0 else "-DBL_MAX") if math.isinf(value) else repr(float(value))


def _memory(model: Model) -> Iterator[str]:
    yield from ("typedef struct {", f"{INDENT}double value[FMU_VALUES];")
    yield from ([f"{INDENT}{model.memory}"] if model.memory else [])
    yield "} fmu_Model;"


def _in(lines: Iterable[str]) -> list[str]:
    return [INDENT + line for line in lines]
