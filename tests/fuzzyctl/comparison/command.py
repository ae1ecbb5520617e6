"""Systems, or texts of systems, compared by `fuzzyctl compare` within this process."""

import json
import math
import tempfile
from pathlib import Path
from types import SimpleNamespace

from fuzzyctl.testing import run_command


def compared(first, second, *options):
    """Run the command on two systems: each is its text, or the path of a file."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [_file(block, Path(folder) / f"{name}.fz") for name, block in (("a", first), ("b", second))]
        return run_command("compare", *paths, *options)


def _file(block, path):
    if isinstance(block, Path):
        return block
    path.write_text(block, encoding="utf-8")
    return path


def changes(first, second):
    """Return the changes from a system to another."""
    result = compared(first, second, "--changes", "--format", "json")
    (found,) = (s["changes"] for s in json.loads(result.output)["systems"])
    assert result.exit_code == bool(found), result.errors
    return [SimpleNamespace(**c) for c in found]


def differences(first, second, points=None):
    """Return the differences of the outputs of two systems with their causes; NaN for no value."""
    result = compared(first, second, "--format", "json", *(["--points", points] if points else []))
    (pair,) = json.loads(result.output)["pairs"]
    return [_difference(d) for d in pair["outputs"]]


def _difference(data):
    found = SimpleNamespace(**data)
    found.largest = math.inf if found.largest is None else found.largest
    for place in (found, *([gap := SimpleNamespace(**found.gap)] if found.gap is not None else [])):
        place.first, place.second = (math.nan if x is None else x for x in (place.first, place.second))
    if found.gap is not None:
        gap.causes = _causes(gap.causes)
        found.gap = gap
    found.causes, found.causes_of_mean = _causes(found.causes), _causes(found.causes_of_mean)
    return found


def _causes(data):
    return [SimpleNamespace(name=c["name"], before=c["first"], after=c["second"], explains=c["explains"]) for c in data]
