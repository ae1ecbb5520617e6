"""Pages of docs/explanation: their texts, and the scripts and results behind what they say."""

import functools
import importlib.util
import json
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "explanation"


def text(page):
    """The text of a page, such as `experiment.md`."""
    return (FOLDER / page).read_text(encoding="utf-8")


def results(path):
    """What a result file holds, such as `experiment/readings.json`."""
    return json.loads((FOLDER / path).read_text(encoding="utf-8"))


@functools.cache
def script(path):
    """The module of a script, such as `experiment/readings.py`, known by its name as processes of its own need it."""
    name = Path(path).stem
    spec = importlib.util.spec_from_file_location(name, FOLDER / path)
    sys.modules[name] = module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
