"""A plugin of pytest that changes one line of a module of the project: tests that still pass prove little."""

import importlib.abc
import importlib.util
import json
import os
import sys

MODULE, OLD, NEW = json.loads(os.environ["FUZZYCTL_REACH_MUTANT"])


class Changed(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds one module, and loads its changed text."""

    def find_spec(self, name, path, target=None):
        if name != MODULE:
            return None
        place = next(os.path.join(p, name.rpartition(".")[2] + ".py") for p in path)
        return importlib.util.spec_from_file_location(name, place, loader=self)

    def create_module(self, spec):
        return None

    def exec_module(self, module):
        with open(module.__spec__.origin, encoding="utf-8") as file:
            text = file.read()
        if text.count(OLD) != 1:
            raise RuntimeError(f"{text.count(OLD)} places in {MODULE} for {OLD!r}")
        exec(compile(text.replace(OLD, NEW), module.__spec__.origin, "exec"), module.__dict__)


sys.meta_path.insert(0, Changed())
