"""The tipper of MATLAB's manual: what tools print for it."""

#: Places (service, food).
POINTS = ((2.0, 1.0), (4.0, 5.0), (7.0, 8.0), (1.0, 2.0))

_MATLAB = (7.0168791431, 14.4584724643, 20.3413663053, 5.5585859298)
#: Measured with the tools, to ten digits. Octave and the trapezoid rule of FuzzyLogic.jl give what
#: MATLAB gives, since the set is 0 at both ends; scikit-fuzzy integrates exactly.
TIPS = {
    "matlab": _MATLAB,
    "octave": _MATLAB,
    "octave_0_4": _MATLAB,
    "fuzzylogic_jl": _MATLAB,
    "pyfuzzylite": (7.0150283767, 14.4529856908, 20.3444979688, 5.5539013785),
    "jfuzzylogic": (7.0151131237, 14.4530473104, 20.3444408811, 5.5540191962),
    "simpful": (7.0150195292, 14.4530479523, 20.3444875632, 5.5538924300),
    "scikit_fuzzy": (7.0150623200, 14.4530101086, 20.3444747745, 5.5539499363),
    "exact": (7.0150623200, 14.4530101086, 20.3444747745, 5.5539499363),
}
#: Of fuzzylite with 200 samples, which prints nine digits.
FUZZYLITE = (7.014311998, 14.453075768, 20.344651194, 5.553950749)
