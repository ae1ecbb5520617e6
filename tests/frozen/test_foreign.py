"""Drawn files of other tools have the meaning that is kept, and their systems are written as it is kept.

After an intended change: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/frozen/test_foreign.py, then read the
difference. Of each format the test line compares every third file.
"""

import os

import pytest

from fuzzyctl.formats.registry import FORMATS
from tests.frozen.foreign import differences, keep, kept, renewed
from tests.sizes import examples


@pytest.mark.parametrize("name", [*FORMATS, "fz"])
def test_files_mean_what_is_kept(name):
    files = kept(name)
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        files = [renewed(name, file) for file in files]
        keep(name, files)
    for file in files[:: examples(1, 3)]:
        assert differences(name, file) == [], "\n".join(file["text"])
