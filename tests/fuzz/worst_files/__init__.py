"""Rule files that are as large, as long and as deep as the limits allow: the worst cases of each stage of a check.

Each case is a function from a size to files. The size is 1 for files at the limits of docs/reference/language.md; less
makes the same files smaller.
"""

from worst_files import (
    claims,
    controllers,
    functions,
    lets,
    lines,
    loops,
    names,
    params,
    plants,
    rules,
    sets,
    short_forms,
    systems,
    tables,
    used_files,
)
from worst_files.case import CASES, HEAD

__all__ = [
    "CASES",
    "HEAD",
    "claims",
    "controllers",
    "functions",
    "lets",
    "lines",
    "loops",
    "names",
    "params",
    "plants",
    "rules",
    "sets",
    "short_forms",
    "systems",
    "tables",
    "used_files",
]
