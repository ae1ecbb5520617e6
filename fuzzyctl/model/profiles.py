"""Profiles: the numerics of a tool as data.

The facts were measured by running the tool, or read in its sources or its manual, as each notes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from types import MappingProxyType
from typing import Any, Final, Literal

from fuzzyctl.diagnostics.diagnostic import UnknownNameError
from fuzzyctl.expr import ZERO, Expr
from fuzzyctl.model.method import AVERAGES, MAXIMA, OVER_MIDDLES, OVER_SETS, Defuzzifier, Grid, Method, Rule, Semantics
from fuzzyctl.model.variable import Fallback, Hold
from fuzzyctl.records import dataclass

#: Words that take back an option of a defuzzifier which the profile in force sets.
UNSET: Final[Mapping[str, str]] = MappingProxyType({"resolution": "exact", "rule": "usual", "tolerance": "usual"})


@dataclass(frozen=True)
class Profile:
    """The numerics of a tool.

    Args:
        name: As rule files and `--as` write it.
        tool: The tool with its version.
        evidence: How its numbers are known.
        semantics: The knobs.
        defuzzifiers: Options of a defuzzifier that is named without options; the others are as under `exact`.
        otherwise: The value of an output without a firing rule, unless the file sets one.
        method: Norms where a file names none.
        evaluates: The defuzzifiers that the tool has; None for all.
        keeps_resolution: Whether its files may set the number of samples, so that they keep it.
        has_activations: Whether it has other activation methods than `general`.
        has_blocks: Whether it has rule blocks with norms.
        not_imitated: Known behaviour of the tool that this profile does not imitate on purpose.
    """

    name: str
    tool: str
    evidence: str = ""
    semantics: Semantics = field(default_factory=Semantics)
    defuzzifiers: Mapping[str, Defuzzifier] = field(default_factory=lambda: MappingProxyType({}))
    otherwise: Expr | Fallback | Hold | None = None
    method: Method = field(default_factory=Method)
    evaluates: tuple[str, ...] | None = None
    keeps_resolution: bool = False
    has_activations: bool = False
    has_blocks: bool = False
    not_imitated: tuple[str, ...] = ()

    def defuzzifier(self, kind: str) -> Defuzzifier:
        """Return a defuzzifier that is named without options."""
        return self.defuzzifiers.get(kind, Defuzzifier(kind=kind))


def _sampled(
    resolution: int,
    grid: Grid,
    *,
    centroid: Rule | None = "plain",
    bisector: Rule | None,
    maxima: Rule | None = None,
    tolerance: float = 0.0,
    by: Literal["value", "magnitude"] = "value",
) -> Mapping[str, Defuzzifier]:
    """Return the defuzzifiers of a tool that samples sets."""
    common: dict[str, Any] = {"resolution": resolution, "grid": grid}
    results: dict[str, Defuzzifier] = {
        "centroid": Defuzzifier(kind="centroid", rule=centroid, **common),
        "bisector": Defuzzifier(
            kind="bisector", rule=bisector, tolerance=tolerance if bisector == "between" else None, **common
        ),
    }
    for kind in MAXIMA:
        measured: dict[str, Any] = {"by": by} if kind != "mom" else {}
        results[kind] = Defuzzifier(kind=kind, rule=maxima, tolerance=tolerance, **common, **measured)
    return MappingProxyType(results)


_FUZZYLITE: Final = Semantics(chained="degree", consequent_hedges="carried", places="free")
_OCTAVE: Final = Semantics(
    merge="places", consequent_hedges="undone", extremely="cube", sigmoid_difference="clamped", none_active="range"
)
_OCTAVE_BUGS: Final = (
    "its bisector is the index of a sample instead of its value; here it is the first sample up to which the sum is "
    "half or more",
    "a Sugeno output without a firing rule stops with an index error; here it is NaN",
    "its drastic sum of three or more degrees differs from the drastic sum of pairs; here they are equal",
)
_NEGATIVE: Final = (
    "if an unbounded sum raises the degree of a chained output above 1, `not` makes it negative, and an average leaves "
    "the range of its consequents; here it does not"
)
_FUZZYLITE_STEPS: Final = (
    "a pi_shape without a left side is 0 at its foot; here it is 0 in files of the tool, and 1 in rule files",
    "a sigmoid of slope 0 is NaN at an infinite input; here it is 0.5",
)
_FUZZYLITE_BUGS: Final = (
    _NEGATIVE,
    "an output that keeps its previous value is one step late; here it is not",
    "inverse Tsukamoto throws an exception; here it uses the degree of the activation, as pyfuzzylite does",
    "a fourth parameter of gbellmf in a .fis file is read as a height, so that the term is 0 everywhere",
    "rules that cannot be read are left out; here they are errors",
    "among equal activations `highest` and `lowest` may choose any; here they choose the earliest",
    "formulas treat numbers closer than 1e-6 as equal, and NaN as equal to NaN; here neither is equal",
    "if a list of points has an x twice, the first point counts, at the right end the last; here also in files of the "
    "tool, but in rule files the larger degree",
    *_FUZZYLITE_STEPS,
)

ProfileName = Literal[
    "exact",
    "matlab",
    "octave",
    "octave_0_4",
    "fuzzylite",
    "fuzzylite_6",
    "pyfuzzylite",
    "jfuzzylogic",
    "simpful",
    "scikit_fuzzy",
    "fuzzylogic_jl",
]
#: All profiles by name.
PROFILES: Final[Mapping[str, Profile]] = MappingProxyType(
    {
        p.name: p
        for p in (
            Profile(
                "exact", "fuzzyctl itself", "the definitions of this reference", has_activations=True, has_blocks=True
            ),
            Profile(
                "matlab",
                "MATLAB Fuzzy Logic Toolbox",
                "its manual, and Octave, which imitates it",
                Semantics(profile="matlab"),
                _sampled(101, "endpoints", bisector="first", by="magnitude"),
                otherwise="midpoint",
                evaluates=(*OVER_SETS, *OVER_MIDDLES),
            ),
            Profile(
                "octave",
                "Octave fuzzy-logic-toolkit 0.6",
                "its sources",
                replace(_OCTAVE, profile="octave"),
                _sampled(101, "endpoints", bisector="first"),
                otherwise="nan",
                evaluates=(*OVER_SETS, *OVER_MIDDLES),
                not_imitated=_OCTAVE_BUGS,
            ),
            Profile(
                "octave_0_4",
                "Octave fuzzy-logic-toolkit 0.4",
                "measured with 0.4.6",
                replace(_OCTAVE, profile="octave_0_4"),
                _sampled(101, "endpoints", centroid="trapezoid", bisector="first"),
                otherwise="nan",
                evaluates=(*OVER_SETS, *OVER_MIDDLES),
                not_imitated=(
                    *_OCTAVE_BUGS,
                    "the drastic product of a single degree is 0 unless the degree is 1, and the drastic sum 1 unless "
                    "it is 0; here both are the degree itself",
                    "with a single rule the aggregation runs along the samples instead of over the rules; here it does "
                    "not",
                    "the Hamacher sum of degrees that reach 1 may be any number up to 2; here it is 1",
                ),
            ),
            Profile(
                "fuzzylite",
                "fuzzylite 7 (C++)",
                "measured",
                replace(_FUZZYLITE, profile="fuzzylite", merge="terms", least=1e-6, equal=1e-6, none_active="range"),
                _sampled(1000, "midpoint", bisector="nearest"),
                otherwise="nan",
                keeps_resolution=True,
                has_activations=True,
                has_blocks=True,
                not_imitated=_FUZZYLITE_BUGS,
            ),
            Profile(
                "fuzzylite_6",
                "fuzzylite 6 (C++)",
                "measured with 6.0",
                replace(_FUZZYLITE, profile="fuzzylite_6", least=1e-6, equal=1e-6),
                _sampled(100, "midpoint", bisector="between", maxima="running", tolerance=1e-6),
                otherwise="nan",
                keeps_resolution=True,
                has_activations=True,
                has_blocks=True,
                not_imitated=(
                    *_FUZZYLITE_BUGS[3:],
                    "its tolerance of 1e-6 applies to the corners of terms, too; here they are exact",
                    "Tsukamoto's method ignores heights of terms; here it takes them into account",
                    "Tsukamoto's method inverts the upper half of s_shape, the lower half of z_shape, and concave "
                    "wrongly; here it inverts all of them correctly",
                    "Tsukamoto's method gives the end of the range for a sigmoid with the activation 1; here the value "
                    "is infinite",
                    "if active rules give an empty set, maxima are those of the whole range, and others NaN; here "
                    "outputs have the value of their `else`",
                    "if hedges change the activations of all active rules to 0, a sum over rules is 0 and an average "
                    "NaN; here outputs have the value of their `else`",
                ),
            ),
            Profile(
                "pyfuzzylite",
                "pyfuzzylite 8",
                "measured with 8.0.6",
                replace(_FUZZYLITE, profile="pyfuzzylite", merge="terms", least=None, fallback="undefined"),
                _sampled(1000, "midpoint", bisector="nearest"),
                otherwise="nan",
                keeps_resolution=True,
                has_activations=True,
                has_blocks=True,
                not_imitated=(
                    _NEGATIVE,
                    "a weighted sum without a contributing rule is NaN, here too, but 0 in fuzzylite",
                    "four of its activation methods refuse arrays; here they do not",
                    "formulas limit sums of truth values to 1, and treat NaN as equal to NaN; here they do neither",
                    "if several terms have one name, its rules mean the last; here the first, as in fuzzylite",
                    "if a list of points has an x twice, the last point counts; here also in files with the comment "
                    "'numerics of pyfuzzylite', but in other files as in fuzzylite, and in rule files the larger "
                    "degree",
                    *_FUZZYLITE_STEPS,
                    "a NaN input affects only outputs that depend on it, and a default replaces these; here every "
                    "output is NaN",
                    "a rule that uses an output before any rule has activated it makes a Tsukamoto output NaN if the "
                    "inverse at 0 is infinite; here the rule is not active",
                    "its Hamacher and drastic norms lose digits near 1, where rounding decides their value",
                ),
            ),
            Profile(
                "jfuzzylogic",
                "jFuzzyLogic 3",
                "measured with revision 1f421d1b",
                Semantics(profile="jfuzzylogic", merge="places", sigmoid_difference="clamped"),
                _sampled(1000, "left", bisector="two_sided"),
                otherwise=Hold(start="nan"),
                method=Method(aggregation="sum"),
                evaluates=(*OVER_SETS, *OVER_MIDDLES),
                has_blocks=True,
                not_imitated=(
                    "AND and OR bind equally, from left to right: a matter of reading its files, not of this profile",
                    "samples are computed by repeated addition of the step, so that rounding errors add up",
                ),
            ),
            Profile(
                "simpful",
                "simpful 2",
                "measured with 2.12.0",
                Semantics(profile="simpful", total="strengths"),
                _sampled(1000, "endpoints", bisector=None),
                otherwise=ZERO,
                evaluates=("centroid", "weighted_average", "center_average"),
                not_imitated=(
                    "AND and OR bind from right to left: a matter of reading its files, not of this profile",
                    "its product never ends, by infinite recursion",
                    "a triangle or trapezoid with a vertical side is 1 beyond this side; here it jumps to 0",
                    "a double Gaussian with its means in reverse order is one of the two; here it is their product",
                    "an unknown term of an output is read as the last term; here it is an error",
                ),
            ),
            Profile(
                "scikit_fuzzy",
                "scikit-fuzzy 0.5",
                "measured with 0.5.0",
                Semantics(profile="scikit_fuzzy", sigmoid_difference="clamped"),
                MappingProxyType(
                    {kind: Defuzzifier(kind=kind, grid="endpoints", rule="polygon") for kind in OVER_SETS[:2]}
                    | {kind: Defuzzifier(kind=kind, grid="endpoints", tolerance=0.0) for kind in MAXIMA}
                ),
                otherwise="nan",
                evaluates=OVER_SETS,
                not_imitated=(
                    "terms are polygons over the samples of a universe that the program gives; here only those of "
                    "outputs are, if the file gives the number of samples; others are the functions themselves",
                    "maxima are samples whose degrees agree in all digits, which depends on rounding; here they are "
                    "those of the set",
                    "a difference of sigmoids may be negative; here it is at least 0",
                    "its bisector ignores the area before a gap in the set; here this area counts",
                    "smallest and largest of maxima of a set that is 0 everywhere are the ends of the universe; here "
                    "they have no value",
                    "an output without a firing rule is missing from the result, or raises an exception; here it is "
                    "NaN",
                ),
            ),
            Profile(
                "fuzzylogic_jl",
                "FuzzyLogic.jl",
                "the sources of revision e0b728d2",
                Semantics(profile="fuzzylogic_jl", weight="after", total="all_rules", sigmoid_difference="clamped"),
                _sampled(101, "endpoints", centroid="trapezoid", bisector="walk", tolerance=2.0**-52),
                otherwise="nan",
                evaluates=(*OVER_SETS, *AVERAGES),
                not_imitated=(
                    "a zero in a rule of a .fis file shifts the inputs behind it",
                    "the nilpotent minimum of a .fcl file is read as the drastic product",
                    "a trapezoid with a shoulder is NaN at its edge",
                ),
            ),
        )
    }
)


def profile(name: str) -> Profile:
    """Return the profile of a name.

    Raises:
        UnknownNameError: For a name that no profile has.
    """
    if name not in PROFILES:
        raise UnknownNameError("profile", name, PROFILES)
    return PROFILES[name]
