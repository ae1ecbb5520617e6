"""Results with the row labels of what was given: pandas in, pandas out."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any


def labelled(results: Any, names: Sequence[Any], given: Any) -> Any:
    """Return results as pandas has them, if what was given is of pandas; else as they are.

    Args:
        results: Shape (rows,) for one output, (rows, outputs) for several; of another shape they have no row labels.
        names: Of the results, such as the outputs.
        given: A DataFrame, or Series as the values of a mapping; anything else has no row labels.

    Returns:
        A Series named after the output, for several outputs a DataFrame, with the index that was given.
    """
    pandas = sys.modules.get("pandas")  # whoever gives a frame has loaded it
    if pandas is None:
        return results
    frames = (pandas.DataFrame, pandas.Series)
    columns = given.values() if isinstance(given, Mapping) else (given,)
    index = next((v.index for v in columns if isinstance(v, frames)), None)
    if index is None or results.shape[:1] != (len(index),):
        return results
    if results.ndim == 1 and len(names) == 1:
        return pandas.Series(results, index=index, name=names[0])
    return pandas.DataFrame(results, index=index, columns=list(names)) if results.ndim == 2 else results
