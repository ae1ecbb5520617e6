"""Names and strings of `.fz` text, refused where they would not be read back."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from typing import Final

from fuzzyctl.diagnostics.diagnostic import ValueOutOfBoundsError
from fuzzyctl.expr import to_text
from fuzzyctl.lang.syntax import MAX_NAME
from fuzzyctl.model.block import Bounds, Guarantee, Param
from fuzzyctl.model.loop import Always

#: Characters that no string of a rule file can hold.
_UNWRITABLE: Final = re.compile('["\\n\\r\\0\\ud800-\\udfff]')


def require_names(names: Iterable[str]) -> None:
    """Refuse names that would not be read back.

    Raises:
        ValueOutOfBoundsError: For such a name.
    """
    for name in names:
        if len(name) > MAX_NAME or not name.isidentifier():
            bound = f"letters, digits and '_', at most {MAX_NAME} characters, and not begin with a digit"
            raise ValueOutOfBoundsError("a name of a rule file", name[:60], bound)


def quoted(before: str, text: str, what: str) -> str:
    """Return a quoted string after what introduces it; nothing for an empty one.

    Raises:
        ValueOutOfBoundsError: For a text that no string of a rule file can hold.
    """
    if _UNWRITABLE.search(text) or not unicodedata.is_normalized("NFC", text):
        bound = "a text in Unicode NFC without double quotes, line ends, NUL and halves of surrogate pairs"
        raise ValueOutOfBoundsError(what, text, bound)
    return f'{before}"{text}"' if text else ""


def param_text(param: Param) -> str:
    """Return a `param` line."""
    unit = quoted(" unit ", param.unit, "unit")
    return f"param {param.name}{bounds_text(param.bounds)} = {to_text(param.expression)}{unit}"


def bounds_text(bounds: Bounds | None) -> str:
    """Return a range with the word before it; nothing for none."""
    if bounds is None:
        return ""
    left, right = "(" if bounds.without_lower else "[", ")" if bounds.without_upper else "]"
    return f" in {left}{to_text(bounds.lower)}, {to_text(bounds.upper)}{right}"


def guarantee_text(g: Guarantee) -> str:
    """Return a guarantee without its keyword."""
    within = f" within {to_text(g.within)}" if g.within is not None else ""
    when = f" when {to_text(g.when)}" if g.when is not None else ""
    if not isinstance(g, Always):
        return f"{to_text(g.claim)}{within}{when}"
    times = [f" {word} {to_text(time)}" for word, time in (("from", g.begin), ("until", g.end)) if time is not None]
    return f"always {to_text(g.claim)}{within}{''.join(times)}{' forever' if g.forever else ''}"
