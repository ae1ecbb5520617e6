"""Program slice: the statements that some of the results depend on.

What one output does where another has no value is thereby none of the other's business, and is not computed for it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from fuzzyctl.kernels.program import traversal
from fuzzyctl.kernels.program.program import Program


def needed(program: Program, wanted: Sequence[int]) -> Program:
    """Return a program with the statements that some results depend on; all results keep their indices."""
    return dataclasses.replace(program, body=traversal.needed(program.body, [program.results[k] for k in wanted]))
