"""Words of other tools: their meaning here, and the order of their parameters."""

from __future__ import annotations

from typing import Final

from fuzzyctl.diagnostics.other_tools_words import PEER_REMARKS, PEER_WORDS
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS, IMPLICATIONS, MEMBERSHIP
from fuzzyctl.records import dataclass

_DEFUZZIFIERS: Final = (
    "centroid",
    "bisector",
    "som",
    "lom",
    "mom",
    "center_average",
    "weighted_average",
    "weighted_sum",
)
_VALUES: Final[dict[str, tuple[str, ...]]] = {
    "and": tuple(CONJUNCTIONS),
    "or": tuple(DISJUNCTIONS),
    "implication": tuple(IMPLICATIONS),
    "aggregation": tuple(AGGREGATIONS),
    "defuzzifier": _DEFUZZIFIERS,
    "activation": ("general", "first", "last", "highest", "lowest", "proportional", "threshold"),
}


@dataclass(frozen=True)
class Form:
    """How another tool writes a membership function.

    Args:
        tool: The tool.
        parameters: Its parameters in its order, by their names here.
    """

    tool: str
    parameters: tuple[str, ...]


def _form(tool: str, parameters: str) -> Form:
    return Form(tool, tuple(parameters.split()))


#: Functions whose parameters have another order than here.
ORDERS: Final[dict[str, Form]] = {
    "gaussmf": _form("MATLAB", "sigma mean"),
    "gauss2mf": _form("MATLAB", "sigma_left mean_left sigma_right mean_right"),
    "gbellmf": _form("MATLAB", "width slope center"),
    "sigmf": _form("MATLAB", "slope inflection"),
    "dsigmf": _form("MATLAB", "rising left falling right"),
    "psigmf": _form("MATLAB", "rising left falling right"),
    "linzmf": _form("MATLAB", "end start"),
    "gbell": _form("FCL", "width slope center"),
    "sigm": _form("FCL", "slope inflection"),
}

#: Words of other tools that a misspelt membership function may be like; 'gauss' is too like 'gauss2'.
PEER_KINDS: Final = tuple(w for w, meant in PEER_WORDS.items() if meant and meant[0] in MEMBERSHIP and w != "gauss")

#: Those of scikit-fuzzy, which are called with the universe first and take their parameters apart.
SCIKIT_ORDERS: Final[dict[str, Form]] = {
    "gaussmf": _form("scikit-fuzzy", "mean sigma"),
    "gauss2mf": _form("scikit-fuzzy", "mean_left sigma_left mean_right sigma_right"),
    "gbellmf": _form("scikit-fuzzy", "width slope center"),
    "sigmf": _form("scikit-fuzzy", "inflection slope"),
    "dsigmf": _form("scikit-fuzzy", "left rising right falling"),
    "psigmf": _form("scikit-fuzzy", "left rising right falling"),
}


def known_kind(word: str) -> str | None:
    """Return the membership function that a word means, in capitals, with other underscores or in another tool."""
    return word if word in MEMBERSHIP else _meant(word, tuple(MEMBERSHIP))


def differing_order(kind: str, word: str) -> str:
    """Return how the order of parameters differs in another tool; an empty string where it does not.

    Args:
        kind: The membership function.
        word: A word of another tool that means it, or its own name, for which MATLAB's stands.
    """
    # MATLAB's linsmf has the order of the ramp here; only linzmf, by its own name, has another.
    theirs = word if word in ORDERS else next((w for w in ORDERS if known_kind(w) == kind != "ramp"), None)
    if theirs is None:
        return ""
    form, ours = ORDERS[theirs], ", ".join(MEMBERSHIP[kind].parameters)
    return f"{form.tool} writes {theirs}({', '.join(form.parameters)}), here it is {kind}({ours}): the order differs"


def is_value(keyword: str, word: str) -> bool:
    """Whether a word is a value of a setting."""
    return word in _VALUES.get(keyword, ())


def known_setting(keyword: str, word: str) -> str | None:
    """Return the value of a setting that a word means which is none itself; None where it means nothing."""
    values = _VALUES.get(keyword, ())
    return None if word in values else _meant(word, values)


def remark(word: str) -> str:
    """Return what is to be known of a word of another tool, or an empty string."""
    return PEER_REMARKS.get(_bare(word), "")


def _meant(word: str, values: tuple[str, ...]) -> str | None:
    bare = _bare(word)
    same = next((v for v in values if _bare(v) == bare), None)
    return same or next((w for w in PEER_WORDS.get(bare, ()) if w in values), None)


def _bare(word: str) -> str:
    return word.casefold().replace("_", "")
